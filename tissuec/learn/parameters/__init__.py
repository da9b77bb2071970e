"""Parameters of learning, and the numbers of a network that follow from them.

Shared arguments:
    theta: Parameters, dimensionless, shape (parameter,).
    vector: Numbers of a network in SI units, shape (number,).
    order: Order of these numbers.
    given: Numbers of tissues and forces.
    constants: Constants of laws by name.
    compiled: The compiled scene.
    scene: The scene.
    network: The network.
"""
