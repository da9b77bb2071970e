"""Expectations about learning, compared with its errors."""

from collections.abc import Iterable, Sequence
from math import sqrt
from typing import Any, NamedTuple

from tissuec.learn.fit.outcome import Fitted, Learnt
from tissuec.script.fit_problem import Demand, Errors

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
