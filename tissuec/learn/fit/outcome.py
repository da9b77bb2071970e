"""Results of learning with their evidence, and expectations about their errors."""

from collections.abc import Iterable, Mapping, Sequence
from math import ceil, isfinite, log10, sqrt
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.units import NUMBER, Dimension, show
from tissuec.model.network import Floats
from tissuec.script.fit_problem import Adjust, Demand, Errors, FitProblem


class Estimates(Struct, frozen=True, eq=False):
    """The numbers of one ``adjust`` entry.

    Attributes:
        names: Of each, such as "spring constant of fat" or "spring 17", shape (number,).
        start: Before the learning, in SI units, shape (number,).
        value: After it.
        low, high: Ends of the interval that contains the true value with 95 % probability, if
            the model is right and the noise is as estimated; infinite where nothing is known.
        identified: Whether the data determines the number at all.
        parts: Of each ``per region`` or ``per tissue``: whose it is; else spring or node.
    """

    adjust: Adjust
    names: tuple[str, ...]
    start: Floats
    value: Floats
    low: Floats
    high: Floats
    identified: NDArray[np.bool_]
    parts: tuple[str, ...] | NDArray[np.int64]


class UnidentifiableCombination(Struct, frozen=True):
    """A combination of numbers that the data does not identify.

    Attributes:
        sentence: What it is: "multiplying all masses, spring constants and viscosities by one
            number changes nothing that was measured: only their ratios are known".
        advice: What would determine it: "give one mass or force".
        spread: By which factor it may be off (one standard deviation of its logarithm);
            infinite if nothing is known.
    """

    sentence: str
    advice: str
    spread: float


class Fitted(Struct, frozen=True, eq=False):
    """Quality of the fit of one experiment.

    Attributes:
        file: Name of the data.
        held_out: Whether the learning did not see it (or "last part" of it).
        count: Of numbers compared.
        error: Root of the mean square of what is left over that of the data's own deviation
            from its mean, 0 at best.
        left: Root of the mean square of what is left, in SI units, by the text of the fit.
        digest: SHA-256 of the file.
    """

    file: str
    held_out: bool
    count: int
    error: float
    left: Mapping[str, float]
    digest: str


class Learnt(Struct, frozen=True, eq=False):
    """A finished learning.

    Attributes:
        estimates: Of each ``adjust`` entry, in their order; words apart.
        zeros: Unknown constants of fits with a free zero, by the text of the fit.
        error, first_error: The error function after and before.
        fitted: Of each experiment.
        noise: Standard deviations that were given or found, in SI units, by the text of fits.
        singular: Singular values of the sensitivity of what was measured (in units of the
            noise) by the logarithms of the numbers, descending.
        blind: Combinations that are not identified.
        method: "least squares, forward sensitivities" or "L-BFGS-B, adjoint".
        stepping: "velocity verlet, 1000 steps of 50 us"; empty where nothing was stepped.
        stepping_error: Of what is predicted, compared with half the steps, relative to the
            range of what was measured.
        passes, evaluations: What was used.
        reason: Why it ended.
        converged: Whether that was not because the passes ran out.
        failure: Why it is no answer although it ended: what is left is too large, or no noise;
            empty if it is one.
        wall_time: [s].
        notes: What else is to be known.
        doubts: Those of the notes that question the result.
        words: New text of vocabularies by the name of their file, where words were adjusted or
            rules revised.
    """

    fit_problem: FitProblem
    estimates: tuple[Estimates, ...]
    zeros: Mapping[str, float]
    error: float
    first_error: float
    fitted: tuple[Fitted, ...]
    noise: Mapping[str, float]
    singular: Floats
    blind: tuple[UnidentifiableCombination, ...]
    method: str
    stepping: str
    stepping_error: float
    passes: int
    evaluations: int
    reason: str
    converged: bool
    wall_time: float
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    failure: str = ""
    words: Mapping[str, str] = field(default_factory=dict[str, str])


#: Plain numbers that are parts of something.
PARTS = ("prestress",)


def shown(value: float, dimension: Dimension, what: str = "", *, digits: int = 4) -> str:
    """Return a value with its unit: "12.35 N/m"; a prestress as "2.1 %"."""
    if what in PARTS and dimension == NUMBER and isfinite(value):
        return f"{100.0 * value:.{digits}g} %"
    return show(value, dimension, digits=digits)


def interval(
    low: float, high: float, dimension: Dimension, what: str = "", *, digits: int = 4
) -> str:
    """Return an interval: "1.2 N/m to 1.4 N/m"; "unknown" where it has no end.

    A narrow one is shown with as many digits as its ends need to differ in two of them.
    """
    if not (isfinite(low) and isfinite(high)):
        return "unknown"
    if high > low:
        needed = 2 + ceil(log10(max(abs(low), abs(high)) / (high - low)))
        digits = min(max(digits, needed), 15)
    ends = (shown(end, dimension, what, digits=digits) for end in (low, high))
    return " to ".join(ends)


def percent(part: float) -> str:
    """Return a part of 1 as "3.1 %"."""
    return f"{100.0 * part:.3g} %"


HELD_OUT, ALL = "held out", "data"


class DemandVerdict(NamedTuple):
    """Whether an expectation holds, and the measured value."""

    demand: Demand
    holds: bool
    measured: str

    @property
    def data(self) -> dict[str, Any]:
        """Return the verdict as plain data."""
        expect = self.demand.span.one_line
        return {"expect": expect, "holds": self.holds, "measured": self.measured}


def judged(learnt: Learnt) -> list[DemandVerdict]:
    """Return a verdict on each ``expect error(…)`` of a learn block."""
    return verdicts_of(learnt.fit_problem.demands, errors_of(learnt.fitted))


def verdicts_of(demands: Iterable[Demand], errors: Errors) -> list[DemandVerdict]:
    """Return a verdict on each expectation.

    Args:
        demands: The expectations.
        errors: Relative errors by name, as ``errors_of`` returns them.
    """
    return [DemandVerdict(one, one.holds(errors), one.describe(errors)) for one in demands]


def errors_of(fitted: Sequence[Fitted]) -> dict[str, float]:
    """Return the errors by the name of each file, "data" and "held out".

    "data" is all that was learnt from. A file whose last part is held out has both of its parts
    under its name. Where nothing belongs to a name, it is not there.
    """
    parts = {
        ALL: [one for one in fitted if not one.held_out],
        HELD_OUT: [one for one in fitted if one.held_out],
        **{file: [one for one in fitted if one.file == file] for file in _files(fitted)},
    }
    return {name: joined(some) for name, some in parts.items() if some}


def joined(fitted: Iterable[Fitted]) -> float:
    """Return the error of several experiments: root of the mean square, by their numbers."""
    some = list(fitted)
    total = sum(one.count for one in some)
    return sqrt(sum(one.count * one.error**2 for one in some) / max(total, 1))


def _files(fitted: Iterable[Fitted]) -> list[str]:
    return list(dict.fromkeys(one.file for one in fitted))
