"""Predictions of experiments, with exact derivatives of every step and equilibrium.

Shared arguments:
    act: Everything that acts on a leg.
    forces: Nodes, and the loops of springs and fields that accelerations follow from.
    at: A state of all nodes.
    start: State at the beginning of a leg.
    state: State at the first time.
    plan: The plan of the experiment.
    network: The network.
    times: Times of interest [s], ascending, shape (row,).
    x, v: Positions [m] and velocities [m/s] of all nodes, shape (3 node,).
    trail: States at all times.
    view: State and numbers as an observable needs them.
    theta: Parameters, dimensionless, shape (parameter,).
    weights: Weights of predictions or components, dimensionless, shape (number,).
    vector: Numbers of the network in SI units, shape (number,).
    seeds: Changes of the numbers by each parameter.
    change: Changes of the state by each parameter.
    due: Derivatives by the state.
    by: Derivatives by numbers, added to.
    changes: What the script changed in arrays, by name.
"""
