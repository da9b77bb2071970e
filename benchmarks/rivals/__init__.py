"""Solvers of other libraries on scenes of tissuec, and how their times compare.

SciPy's solvers and CVODE use the compiled forces of tissuec; MuJoCo has its own.

Shared arguments:
    problem: The scene of the bench.
    points: Measured points.
    name: Name of a method.
    names: Names of methods.
    error: Error of positions [m].
    errors: Errors of positions [m].
    floor: Error below which nothing is known [m].
    kernel: The forces between two events.
    times: Times of interest [s], shape (row,).
    tolerance: Relative error that a solver is asked for, dimensionless.
    deadline: Time limit.
    time: Time [s].
    y, out: Unknowns and their rates in SI units, shape (6 free,).
"""
