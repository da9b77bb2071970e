"""Equilibrium: where the forces on nodes balance, without any motion.

``balance`` is the arithmetic, ``newton`` and ``relaxation`` are two ways to the minimum of the
energy, ``settling`` goes them and says what it found.
"""
