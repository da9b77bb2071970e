"""Uncertainty of learnt parameters: intervals, and combinations that data does not identify.

The covariance of the parameters is ``A Σ Aᵀ`` with the change A of the parameters with the
measurements and the covariance Σ of these, for which a sample of all noises is taken that the
residuals allow. The interval of a parameter contains it in 95 % of all cases: it is that of the
mixture of normal distributions, one for each noise of the sample. (With white noise it is that
of Student.) To that comes how far the errors of the steps shift the estimates.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, svd
from scipy.special import ndtr

from tissuec.core.errors import counted, enumerated
from tissuec.learn.fit.linearised import LinearisedFit
from tissuec.learn.fit.noise import NoiseDraws
from tissuec.learn.fit.outcome import UnidentifiableCombination
from tissuec.model.network import Floats

SHARE = 1e-3  # of a parameter's square in blind combinations: less says it is known
SURE = 0.95
REMAINING = 4.0 / 3.0  # error of order 2 by what half the steps take away of it; less of others
SHOWN = 6  # names or factors in a sentence
#: What positions determine only up to ratios, and the plural of its name.
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
        away: How far the interval reaches to either side, shape (parameter,).
        identified: Whether the data determines a parameter, shape (parameter,).
        blind: Combinations that it does not determine.
        noise: Standard deviation of each fit in SI units, shape (fit,).
    """

    singular: Floats
    away: Floats
    identified: NDArray[np.bool_]
    blind: tuple[UnidentifiableCombination, ...]
    noise: Floats


def judge(
    fit: LinearisedFit,
    draws: Sequence[NoiseDraws],
    names: Sequence[str],
    kinds: Sequence[str],
    step_error: Floats | None = None,
) -> Identifiability:
    """Return the identifiability of the parameters of a fit.

    Args:
        fit: The fit, near its result.
        draws: The noise of its measurements.
        names: Of the parameters.
        kinds: Kind of each, such as "spring constant".
        step_error: Change of all predictions with half the steps, in SI units, shape (number,).
    """
    dark, vague = fit.is_dark, fit.is_vague
    identified = np.square(fit.turned[dark | vague]).sum(axis=0) < SHARE
    away = half_widths(fit, draws, SURE)
    if step_error is not None:
        away = away + REMAINING * np.abs(fit.answer @ step_error[fit.problem.counted])
    away[~identified] = np.inf
    blind = [
        *_blind(fit.turned[dark], fit.singular[dark], names, kinds),
        *_hidden(fit.turned[vague], fit.singular[vague], names),
    ]
    return Identifiability(fit.singular, away, identified, tuple(blind), fit.noise)


def half_widths(fit: LinearisedFit, draws: Sequence[NoiseDraws], sure: float) -> Floats:
    """Return how far the interval of each parameter reaches to either side.

    It is dimensionless and has the shape (parameter,).

    Args:
        fit: The fit, near its result.
        draws: The noise of its measurements.
        sure: Probability that an interval contains the parameter.
    """
    firm = np.square(fit.firm).sum(axis=1)
    deviations = np.sqrt(sum((one.variance for one in draws), firm[None]))
    low, high = deviations.min(axis=0), 2.0 * deviations.max(axis=0)
    high = np.maximum(high, 1e-300)
    for _ in range(60):  # twice as near each time, and to 1e-16 in the end
        middle: Floats = 0.5 * (low + high)
        below: Floats = ndtr(middle / np.maximum(deviations, 1e-300))
        inside = 2.0 * below.mean(axis=0) - 1.0
        low, high = np.where(inside < sure, middle, low), np.where(inside < sure, high, middle)
    return high


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
    """Return the part of a space at right angles to some directions."""
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
    every = enumerated((SCALED[kind] for kind in kinds), "and")
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
