"""Uncertainty of learnt parameters: intervals, and combinations that data does not identify.

With J the derivatives of what was measured, in units of its noise, by the parameters, no
unbiased estimate has a smaller covariance than (JᵀJ)⁻¹: the bound of Cramér and Rao. Least
squares come to it where the noise is Gaussian and small enough for the model to be linear.
Singular vectors of J whose singular values are as good as none are combinations that the data
does not tell; those with small ones are hidden by its noise. (A. Raue et al., Bioinformatics
25:1923, 2009, on identifiability.)

To that comes what is no noise: how far the errors of the steps shift the estimates, and, where
residuals are correlated in time, that they tell less than as many independent ones: with a
correlation r of neighbours, as if there were (1 - r) / (1 + r) of them (G. V. Bayley, J. M.
Hammersley, Suppl. J. R. Stat. Soc. 8:184, 1946).
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, svd
from scipy.stats import t as student

from tissuec.core.errors import counted
from tissuec.learn.fit.outcome import UnidentifiableCombination
from tissuec.learn.fit.problem import Problem
from tissuec.model.network import Floats

ROUNDING = 1e-7  # of the largest singular value: derivatives are no better than that
VAGUE = 1.0  # standard deviation of a logarithm from which nothing is known: a factor e
SHARE = 1e-3  # of a parameter's square in blind combinations: less says it is known
SURE = 0.95
REMAINING = 4.0 / 3.0  # error of order 2 by what half the steps take away of it; less of others
MOST_CORRELATED = 0.99
SHOWN = 6  # names or factors in a sentence
#: What no position tells but by its ratios, and how several of a kind are called.
SCALED = {
    "mass": "masses",
    "density": "densities",
    "spring constant": "spring constants",
    "young's modulus": "Young's moduli",
    "viscosity": "viscosities",
    "shear viscosity": "shear viscosities",
}


class Identifiability(NamedTuple):
    """Uncertainty of parameters.

    Attributes:
        singular: Singular values of J, descending, shape (parameter,).
        spread: Standard deviations of the parameters, shape (parameter,).
        away: How far the interval reaches to either side, shape (parameter,).
        identified: Whether the data tells a parameter, shape (parameter,).
        blind: Combinations that it does not tell.
        noise: Standard deviation of each fit in SI units, shape (fit,).
    """

    singular: Floats
    spread: Floats
    away: Floats
    identified: NDArray[np.bool_]
    blind: tuple[UnidentifiableCombination, ...]
    noise: Floats


def judge(
    problem: Problem,
    theta: Floats,
    names: Sequence[str],
    kinds: Sequence[str],
    step_error: Floats | None = None,
) -> Identifiability:
    """Return the identifiability of some parameters.

    Args:
        problem: Residuals of all experiments.
        theta: Result of the search on the whole horizon, dimensionless, shape (parameter,).
        names: Of the parameters.
        kinds: Kind of each, such as "spring constant".
        step_error: Change of all predictions with half the steps, in SI units, shape (number,).
    """
    left, before = problem.left(theta), problem.noise
    if not problem.size:
        none = np.zeros(0)
        noise, _ = _noise(problem, left, 0)
        return Identifiability(none, none, none, np.zeros(0, dtype=bool), (), noise)
    rows = problem.jacobian(theta)
    noise, freedom = _noise(problem, left, problem.size)
    weighed = len(left)
    own = rows[:weighed] * (before / noise)[problem.fits][:, None]
    others = rows[weighed : weighed + len(problem.priors)]
    sides, singular, turned = svd(np.concatenate([own, others]), full_matrices=False)
    singular = np.pad(singular, (0, problem.size - len(singular)))
    turned = np.concatenate([turned, _completed(turned, problem.size)])
    is_dark = singular <= ROUNDING * singular[0]
    is_vague = ~is_dark & (singular * VAGUE <= 1.0)
    told = ~(is_dark | is_vague)
    unseen = np.square(turned[~told]).sum(axis=0)
    inverse = turned[told] / singular[told, None]
    spread = np.sqrt(np.square(inverse).sum(axis=0))
    identified = unseen < SHARE
    spread[~identified] = np.inf
    blind = [
        *_blind(turned[is_dark], singular[is_dark], names, kinds),
        *_hidden(turned[is_vague], singular[is_vague], names),
    ]
    quantile = float(student.ppf(0.5 + 0.5 * SURE, max(freedom, 1)))
    away = quantile * spread * _fewer(problem, theta)
    if step_error is not None:
        shift = np.zeros(len(own) + len(others))
        shift[:weighed] = (REMAINING * step_error / noise[problem.fit_of])[problem.counted]
        away += np.abs((sides.T @ shift)[told[: sides.shape[1]]] @ inverse)
    return Identifiability(singular, spread, away, identified, tuple(blind), noise)


def _fewer(problem: Problem, theta: Floats) -> float:
    """Return by which factor correlated residuals widen an interval."""
    found = problem.structure(theta)
    if not found.is_significant:
        return 1.0
    correlation = min(found.correlation, MOST_CORRELATED)
    return float(np.sqrt((1.0 + correlation) / (1.0 - correlation)))


def _noise(problem: Problem, left: Floats, parameters: int) -> tuple[Floats, int]:
    """Return the noise of each fit, and from how many free numbers it was found."""
    total = max(len(left), 1)
    freedom = max(len(left) - parameters, 1)
    noise, known = np.empty(len(problem.fit_problem.fits)), True
    for k, fit in enumerate(problem.fit_problem.fits):
        mine = left[problem.fits == k]
        found = np.sqrt(np.sum(mine**2) / max(len(mine) * freedom / total, 1e-300))
        floor = 1e-13 * problem.spread[k]
        noise[k] = max(float(found), floor) if fit.noise is None else fit.noise
        known &= fit.noise is not None
    return noise, (10**9 if known else freedom)


def _completed(turned: Floats, size: int) -> Floats:
    """Return further directions, at right angles to those that there are."""
    if len(turned) == size:
        return turned[:0]
    found: Any = qr(turned.T, mode="full")
    return found[0][:, len(turned) :].T


def _blind(
    space: Floats, singular: Floats, names: Sequence[str], kinds: Sequence[str]
) -> list[UnidentifiableCombination]:
    """Return the combinations that a space of parameters is made of, the plainest first.

    Args:
        space: Orthonormal, shape (direction, parameter).
    """
    if not len(space):
        return []
    spread = float(1.0 / singular.max()) if singular.max() > 0 else np.inf
    alone, space = _parted(space)
    found = [_alone([names[k] for k in alone], spread)] if alone else []
    together = np.array([kind in SCALED for kind in kinds], dtype=float)
    if together.sum() > 1:
        together /= np.linalg.norm(together)
        if np.square(space @ together).sum() > 1.0 - SHARE:
            found.append(_scale([kind for kind in SCALED if kind in kinds], spread))
            space = _without(space, together[None])
    way_out = "fix one of them, or measure another quantity, too"
    found += [
        UnidentifiableCombination(_mixture(row, names), way_out, spread)
        for row in _plain(space)
    ]
    return found


def _hidden(
    space: Floats, singular: Floats, names: Sequence[str]
) -> list[UnidentifiableCombination]:
    """Return the combinations that the noise of the data hides, the plainest first."""
    if not len(space):
        return []
    alone, space = _parted(space)
    sentences = [f"hidden by the noise: {_mixture(row, names)}" for row in _plain(space)]
    if alone:
        verb = "is" if len(alone) == 1 else "are"
        listed = _listed([names[k] for k in alone])
        count = counted(len(alone), "parameter")
        sentences.insert(0, f"{count} {verb} hidden by the noise: {listed}")
    way_out = "measure longer, more precisely or where they act, or fix one of them"
    return [
        UnidentifiableCombination(sentence, way_out, float(1.0 / singular.max()))
        for sentence in sentences
    ]


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more


def _parted(space: Floats) -> tuple[list[int], Floats]:
    """Return which parameters a space contains by themselves, and the space without them."""
    alone = np.flatnonzero(np.square(space).sum(axis=0) > 1.0 - SHARE)
    if not len(alone):
        return [], space
    return alone.tolist(), _without(space, np.eye(space.shape[1])[alone])


def _without(space: Floats, known: Floats) -> Floats:
    """Return what is left of a space at right angles to some directions."""
    rest = space - (space @ known.T) @ known
    _, sizes, rows = svd(rest, full_matrices=False)
    return rows[sizes > 0.5]


def _plain(space: Floats) -> Floats:
    """Return a basis in which every direction has few parameters, each scaled to 1."""
    if not len(space):
        return space
    found: Any = qr(space, mode="economic", pivoting=True)
    _, upper, order = found
    count = len(space)
    plain = np.zeros_like(space)
    plain[:, order] = np.linalg.solve(upper[:, :count], upper)
    return plain


def _alone(names: Sequence[str], spread: float) -> UnidentifiableCombination:
    verb = "has" if len(names) == 1 else "have"
    return UnidentifiableCombination(
        f"{counted(len(names), 'parameter')} {verb} no influence on the measurements: "
        f"{_listed(names)}",
        "remove them from adjust, or measure where they act",
        spread,
    )


def _scale(kinds: Sequence[str], spread: float) -> UnidentifiableCombination:
    *first, last = [SCALED[kind] for kind in kinds]
    every = f"{', '.join(first)} and {last}" if first else last
    return UnidentifiableCombination(
        f"multiplying all {every} by the same factor does not change the measurements: "
        "only their ratios can be determined",
        f"fix one {kinds[0]} (remove it from adjust) or fit a measured force",
        spread,
    )


def _mixture(row: Floats, names: Sequence[str]) -> str:
    strongest = np.argsort(-np.abs(row), kind="stable")
    parts = [k for k in strongest if abs(row[k]) > 0.05][: SHOWN + 1]
    shown = ", ".join(f"{names[k]} ({row[k]:+.2f})" for k in parts[:SHOWN])
    more = ", …" if len(parts) > SHOWN else ""
    return (
        "the data does not distinguish these parameters; their logarithms can change in the "
        f"ratio {shown}{more}"
    )
