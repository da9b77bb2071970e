"""Vibration about equilibrium: natural frequencies and mode shapes.

``operator`` is the matrix of small motions, ``eigen`` finds its lowest eigenvalues, ``modes``
says what they mean, and ``frames`` shows them in motion.
"""
