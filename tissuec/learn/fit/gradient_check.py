"""The derivatives of the error that a fit uses, compared with differences, and the report."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tissuec.compiler.compile import Compiled
from tissuec.core.errors import counted
from tissuec.core.report import DONE, FAILED, FactTable, Part, Report
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.learning import Unlearnable
from tissuec.learn.fit.problem import Problem
from tissuec.learn.fit.session import prepare
from tissuec.model.network import Floats
from tissuec.scene.request import Request
from tissuec.script.fit_problem import FitProblem

STEPS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)  # of differences, in parameters
AGREED = 1e-9  # of a derivative: differences with two steps that agree so well are believed


class Compared(NamedTuple):
    """A derivative of the error along one direction, exactly and by differences.

    Attributes:
        apart: How far both are apart, as a part of the derivative.
        doubt: How far differences with two steps are apart; no difference is better than that.
    """

    name: str
    exact: float
    differences: float
    apart: float
    doubt: float = 0.0


def check_gradient(
    compiled: Compiled, fit_problem: FitProblem, request: Request, *, directions: int = 20
) -> list[Compared]:
    """Return derivatives of the error in random directions, exactly and by differences.

    Args:
        directions: Number of directions.

    Raises:
        CompileError: Data is wrong.
        Unlearnable: The first prediction has no numbers.
    """
    session = prepare(compiled, fit_problem, request)
    problem = session.problem
    random = np.random.default_rng(fit_problem.seed)
    theta = 0.01 * random.standard_normal(problem.size)
    theta = np.clip(theta, *session.bounds(problem))
    try:
        problem.freeze(theta)
        _, slope = problem.gradient(theta)
        found: list[Compared] = []
        for number in range(directions):
            way = random.standard_normal(problem.size)
            way /= np.linalg.norm(way)
            exact = float(slope @ way)
            found.append(_compared(problem, theta, way, exact, float(np.linalg.norm(slope))))
            found[-1] = found[-1]._replace(name=f"direction {number + 1}")
    except Diverged as failure:
        raise Unlearnable(str(failure)) from failure
    return found


def _compared(
    problem: Problem, theta: Floats, way: Floats, exact: float, steepest: float
) -> Compared:
    """Return a derivative beside central differences of sixth order.

    Their steps fall until two of them agree, or to the last. Larger ones are wrong by their
    order, smaller ones by rounding: those that agree best count.
    """
    tried: list[float] = []
    size = max(abs(exact), 1e-3 * steepest) or 1.0
    for step in STEPS:
        total = 0.0
        for many, weight in ((1, 45.0), (2, -9.0), (3, 1.0)):
            ahead, behind = (problem.error(theta + s * many * step * way) for s in (1, -1))
            total += weight * (ahead - behind)
        tried.append(total / (60.0 * step))
        if len(tried) > 1 and abs(tried[-1] - tried[-2]) <= AGREED * size:
            break
    apart = np.abs(np.diff(tried))
    best = int(np.argmin(apart))
    found = tried[best + 1]
    return Compared("", exact, found, abs(found - exact) / size, float(apart[best]) / size)


HEADINGS = ("derivative by", "exact", "by differences", "relative difference", "accuracy")
BETTER = 10.0  # times the doubt in differences: what is less is no sign of a mistake


def is_good(found: Sequence[Compared], allowed: float) -> bool:
    """Return whether all derivatives are right within the accuracy of differences."""
    return all(one.apart <= max(allowed, BETTER * one.doubt) for one in found)


def gradient_report(fit_problem: str, found: Sequence[Compared], allowed: float) -> Report:
    """Return a table of derivatives and the verdict on the worst of them.

    Args:
        fit_problem: Name of the ``learn`` block.
        found: The derivatives.
        allowed: Largest relative difference.
    """
    rows = [
        (one.name, f"{one.exact:+.9e}", f"{one.differences:+.9e}", f"{one.apart:.1e}",
         f"{one.doubt:.1e}")
        for one in found
    ]  # fmt: skip
    worst = max((one.apart for one in found), default=0.0)
    good = is_good(found, allowed)
    count = counted(len(found), "direction")
    last = f"{count}, at worst {worst:.1e} apart, allowed {allowed:g}"
    parts: list[Part] = [
        FactTable(HEADINGS, rows),
        f"learn {fit_problem}: derivatives are {'good' if good else 'WRONG'}: {last}",
    ]
    if good and worst > allowed:
        parts.append(
            "finite differences are not more accurate here: the motion is too "
            "sensitive for any step size"
        )
    document = {"gradient": [row._asdict() for row in found], "worst": worst}
    return Report(parts, document, DONE if good else FAILED)
