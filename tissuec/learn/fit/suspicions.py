"""What is likely wrong with a measurement: its scale, clock or zero, or an expected value.

A wrong scale of a fit changes what is measured by a multiple of the prediction, a wrong clock
by one of its rate, a zero by a constant. Each is tried as a further parameter of the linearised
fit (a score test, C. R. Rao, Proc. Cambridge Phil. Soc. 44:50, 1948). What is reported is
certain even with correlated noise, and explains what the residuals show.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tissuec.core.units import TIME, show
from tissuec.learn.fit.identifiability import half_widths
from tissuec.learn.fit.linearised import LinearisedFit
from tissuec.learn.fit.noise import chains_of, noise_of
from tissuec.learn.fit.problem import Problem
from tissuec.learn.fit.residual_structure import residual_structure
from tissuec.model.network import Floats
from tissuec.script.fit_problem import Fit

SURE = 0.999  # that something is no chance, if it is told
PROBABLE = 4.0  # standard deviations with white noise, from which on it is looked at
ALIKE = 1e-3  # of a column: what the parameters leave of it
MOST = 0.5  # of the squares of residuals of a fit: what leaves less is told in any case
RIVAL = 0.8  # of the best explanation: as good
AT_WAR = 3.0  # standard deviations of an expected value against the data
TOLD_BY_DATA = 1e-6  # of the information on a parameter


class _Suspect(NamedTuple):
    """A quantity that may be wrong: its column in J, in SI units, shape (counted,)."""

    kind: str
    fit: Fit
    column: Floats


def suspicions(fit: LinearisedFit, theta: Floats) -> list[str]:
    """Return what the measurements have most likely wrong, as sentences.

    Args:
        fit: The fit, near its result.
        theta: The result, dimensionless, shape (parameter,).
    """
    found: list[tuple[float, str]] = []
    problem = fit.problem
    for one in _suspects(problem, theta):
        gain = _gain(fit, one.column)
        if gain < PROBABLE**2:
            continue
        more = fit.with_column(one.column)
        move = more.answer @ fit.left + more.firm @ fit.surprise
        away = float(half_widths(more, noise_of(more), SURE)[-1])
        rest, mine = fit.left - more.rows @ move, one.column != 0.0
        explained = np.square(rest[mine]).sum() < MOST * np.square(fit.left[mine]).sum()
        is_all = not residual_structure(problem, rest, more.basis).is_significant
        if abs(move[-1]) > away and (is_all or explained):
            found.append((gain, _sentence(one, -float(move[-1]), away)))
    best = max((gain for gain, _ in found), default=0.0)
    return [sentence for gain, sentence in found if gain >= RIVAL * best]


def contradictions(fit: LinearisedFit, names: Sequence[str]) -> Iterator[str]:
    """Yield which expected values the data contradicts.

    The residual of an expected value is held against its standard deviation if it is right,
    which is less than 1 as it has its part in the result.

    Args:
        fit: The fit, near its result.
        names: Of the parameters.
    """
    own = np.square(fit.expected @ fit.directions).sum(axis=1)
    for prior, surprise, share in zip(fit.problem.priors, fit.surprise, own, strict=True):
        others = max(1.0 - float(share), TOLD_BY_DATA)
        if abs(surprise) > AT_WAR * np.sqrt(others):
            yield (
                f"the data and the expected value of {names[prior.place]} differ by "
                f"{abs(surprise) / others:.3g} of its deviations: one of them is wrong, and "
                "the interval ignores that"
            )


# --- suspects ---------------------------------------------------------------------------------


def _suspects(problem: Problem, theta: Floats) -> Iterator[_Suspect]:
    """Yield a scale, a clock and a zero for each fit, where they are no parameters."""
    predicted = problem.predicted(theta)[problem.counted]
    rate = _rates(problem, predicted)
    for k, fit in enumerate(problem.fit_problem.fits):
        mine = problem.fits == k
        yield _Suspect("scale", fit, np.where(mine, predicted - problem.zero(theta, k), 0.0))
        if problem.fit_problem.axis.nodes is None:
            yield _Suspect("clock", fit, np.where(mine, -rate, 0.0))
        if not fit.free_zero:
            yield _Suspect("zero", fit, mine.astype(float))


def _rates(problem: Problem, predicted: Floats) -> Floats:
    """Return how fast predictions change, by differences of rows; 0 for single ones."""
    found, times = np.zeros(len(predicted)), problem.times[problem.counted]
    for chains in chains_of(problem):
        for part in np.split(chains.order, np.flatnonzero(np.isinf(chains.apart))[1:]):
            if len(part) > 1:
                found[part] = np.gradient(predicted[part], times[part])
    return found


def _gain(fit: LinearisedFit, column: Floats) -> float:
    """Return by how much a parameter reduces the squares of residuals over the noise."""
    scale = 1.0 / fit.noise[fit.problem.fits]
    rest = column - fit.rows @ (fit.answer @ column)
    size = float(np.square(scale * rest).sum())
    if size <= ALIKE**2 * float(np.square(scale * column).sum()) or size == 0.0:
        return 0.0
    return float((scale * rest) @ (scale * fit.left)) ** 2 / size


def _sentence(one: _Suspect, shift: float, away: float) -> str:
    name = one.fit.text
    if one.kind == "scale":
        ends = f"{100 * (shift - away):+.2g} to {100 * (shift + away):+.2g} %"
        wrong, way_out = (
            f"scale of {name} is off by {100 * shift:+.2g} % ({ends})",
            "calibration",
        )
        return f"probably the {wrong}: check its {way_out}"
    if one.kind == "clock":
        late = "late" if shift > 0.0 else "early"
        shown = f"{show(abs(shift), TIME)} {late}, ±{show(away, TIME)}"
        return f"probably the clock of {name} is off ({shown}): check where its time starts"
    shown = f"{show(shift, one.fit.dimension)}, ±{show(away, one.fit.dimension)}"
    return f"probably the zero of {name} is off ({shown}): write after it: with free zero"
