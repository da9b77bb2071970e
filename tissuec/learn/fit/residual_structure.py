"""Residuals that are no white noise: their correlation, and whether it is chance.

The ratio of two quadratic forms of residuals ``rᵀAr / rᵀr``, here the correlation of
neighbours, has a mean and a variance under white noise that follow exactly from the parameters
which were fitted; a beta distribution with the same ones gives how often chance alone gives as
much (J. Durbin, G. S. Watson, Biometrika 37:409, 1950, and 38:159, 1951). That holds for eight
rows, and for any number.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import betainc

from tissuec.learn.fit.noise import chains_of
from tissuec.learn.fit.problem import Problem
from tissuec.model.network import Floats, Indices

LIMIT = 3.0  # robust standard deviations, at which residuals are clipped
CORRELATED = 0.3  # of neighbouring residuals: more is structure, if it is significant
CHANCE = 0.01  # probability of white noise, below which a correlation is significant


class ResidualStructure(NamedTuple):
    """Statistics of residuals.

    Attributes:
        correlation: Of a residual with the one in the next row.
        chance: Probability that white noise gives as much.
        size: Root of the mean square of residuals, in units of the deviation of data from its
            mean.
    """

    correlation: float
    chance: float
    size: float

    @property
    def is_significant(self) -> bool:
        """Return whether the correlation is more than that of noise may well be."""
        return self.correlation > CORRELATED and self.chance < CHANCE

    def exceeds(self, least: float) -> bool:
        """Return whether correlated residuals, a sign of a wrong model, exceed a size."""
        return self.size >= least and self.is_significant


def residual_structure(
    problem: Problem, left: Floats, basis: Floats | None = None
) -> ResidualStructure:
    """Return statistics of residuals, each fit in its own unit; outliers hide nothing.

    Args:
        problem: Residuals of all experiments.
        left: Predictions less measurements in SI units, shape (counted,).
        basis: Residuals that the fit has taken away, orthonormal in units of the noise, shape
            (counted, direction); without, significance is underestimated.
    """
    unit = np.ones(len(left))
    for k in np.unique(problem.fits):
        mine = problem.fits == k
        robust = 1.4826 * float(np.median(np.abs(left[mine])))
        if robust > 0.0:
            limit = LIMIT * robust
            left = np.where(mine, np.clip(left, -limit, limit), left)
        unit[mine] = np.sqrt(np.mean(left[mine] ** 2)) or 1.0
    size = left / problem.spread[problem.fits]
    scaled = left / unit
    pairs = [
        (c.order[1:][near], c.order[:-1][near])
        for c in chains_of(problem)
        for near in [c.apart[1:] == 1.0]
    ]
    behind, before = (
        np.concatenate([np.zeros(0, dtype=np.int64), *side])
        for side in zip(*pairs, strict=True)
    )
    square = float(scaled @ scaled)
    correlation = float(scaled[behind] @ scaled[before]) / square if square > 0.0 else 0.0
    chance = _chance(correlation, len(scaled), behind, before, basis)
    rms = float(np.sqrt(np.mean(size**2))) if len(size) else 0.0
    return ResidualStructure(correlation, chance, rms)


def _chance(
    found: float, rows: int, behind: Indices, before: Indices, basis: Floats | None
) -> float:
    """Return the probability that white noise has a correlation of at least so much.

    With the projection M on what the fit leaves, the moments of the ratio are those of
    ``tr(MA) / f`` and ``(2 tr(MAMA) + tr(MA)²) / (f (f + 2))`` with f = tr M.
    """
    basis = np.zeros((rows, 0)) if basis is None else basis
    freedom: int = rows - basis.shape[1]
    if freedom < 2 or not len(behind):
        return 1.0
    shifted = np.zeros_like(basis)  # A times the basis
    np.add.at(shifted, behind, 0.5 * basis[before])
    np.add.at(shifted, before, 0.5 * basis[behind])
    inner = basis.T @ shifted
    first = -float(np.trace(inner))
    # tr(A²) is half the number of pairs.
    second = 0.5 * len(behind) - 2.0 * float(np.square(shifted).sum())
    second += float(np.square(inner).sum())
    mean = first / freedom
    variance = (2.0 * second + first**2) / (freedom * (freedom + 2.0)) - mean**2
    if not variance > 0.0:
        return 1.0
    middle, width = 0.5 * (1.0 + mean), 0.25 * variance
    total = middle * (1.0 - middle) / width - 1.0
    if not total > 0.0:
        return 1.0
    at = float(np.clip(0.5 * (1.0 - found), 0.0, 1.0))
    return float(betainc((1.0 - middle) * total, middle * total, at))
