"""The mechanical state of a net: forces, energies, observables and equilibrium.

``balance`` is the arithmetic of equilibria, ``newton`` and ``relaxation`` are two ways to the
minimum of the energy, and ``settling`` applies them and reports what was found.
"""
