"""The fit: problem, search, identifiability and outcome.

Shared arguments:
    compiled: The compiled scene.
    fit_problem: The ``learn`` block.
    request: What the scene was compiled from.
    problem: Residuals of all experiments.
    theta: Parameters, dimensionless, shape (parameter,).
    bounds: Smallest and largest parameters, dimensionless, shape (parameter,) each.
    shaping: How numbers follow from parameters.
    value, low, high: Numbers in SI units.
    dimension: Their dimension.
    what: Name of the quantity.
    digits: Number of significant digits.
"""
