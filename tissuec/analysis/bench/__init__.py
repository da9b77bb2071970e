"""Measuring the engine on a scene: run time against error, for every method.

Shared arguments:
    problem: The scene of the bench.
    points: Measured points.
    tolerance: Relative error that a solver is to keep, dimensionless.
    deadline: Time limit.
"""
