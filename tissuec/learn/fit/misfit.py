"""Detects residuals so large that the search, or the model, has failed."""

from collections.abc import Iterator, Sequence

import numpy as np

from tissuec.core.errors import TissueError, counted
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.outcome import percent
from tissuec.learn.fit.problem import Problem
from tissuec.learn.fit.residual_structure import ResidualStructure, residual_structure
from tissuec.learn.fit.search import MET
from tissuec.model.network import Floats

NOTHING = 0.8  # error from which on it is near that of knowing the mean alone, which is 1
STRUCTURED = 0.2  # size from which on residuals that are no noise are a failure
WRONG_UNIT = 300.0  # times as large, or as small, as predicted
OPPOSITE = -0.8  # cosine of data and prediction, below which they have opposite signs
COARSE = 0.05  # error of steps from which on a fit is none
TOLD = 0.02  # size from which on they are reported


def misfit(
    problem: Problem,
    theta: Floats,
    structure: ResidualStructure,
    singles: Sequence[Problem] = (),
) -> str:
    """Return why some parameters are no solution, as a sentence; empty if they may be one.

    Args:
        problem: Residuals of all experiments.
        theta: Result of the search on the whole horizon, dimensionless, shape (parameter,).
        singles: The same problem for each experiment by itself.
    """
    if _is_met(problem, theta):
        return ""
    error = problem.relative(theta)
    if error >= NOTHING:
        return (
            f"the error is {percent(error)}; the mean of the data alone gives "
            "100 %, so the fit does not explain the data"
        )
    if structure.exceeds(STRUCTURED):
        return (
            f"the error is {percent(error)}, and the residuals are correlated, so they are not "
            "noise: the fit found a wrong minimum, or the scene does not describe the "
            "experiment"
        )
    for one in singles:
        found = residual_structure(one, one.left(theta))
        share = found.size * float((one.spread / problem.spread).max(initial=0.0))
        if found.exceeds(NOTHING) and share >= TOLD:
            name = one.trials[0].experiment.name
            return (
                f"the error of {name} is {percent(found.size)}, and its residuals are not "
                "noise: with these parameters, the scene cannot describe the experiment"
            )
    return ""


def too_coarse(error: float) -> str:
    """Return why steps are too large for an answer, as a sentence; empty if they are not.

    Args:
        error: How much predictions change with half the steps, as a part of their range.
    """
    if error < COARSE:
        return ""
    return (
        f"halving the step changes predictions by {percent(error)} of their range: write a "
        "smaller step, or remove step to choose it automatically"
    )


def remarks(problem: Problem, theta: Floats, structure: ResidualStructure) -> Iterator[str]:
    """Yield remarks on residuals that do not look like noise, or are large.

    Args:
        problem: Residuals of all experiments.
        theta: Result of the search on the whole horizon, dimensionless, shape (parameter,).
    """
    if _is_met(problem, theta):
        return
    if problem.noise_is_given:
        yield f"the residuals are {problem.rms(theta):.3g} times as large as the given noise"
    error = problem.relative(theta)
    if structure.exceeds(TOLD):
        yield (
            f"the residuals are not white noise: they correlate from row to row by "
            f"{structure.correlation:.2f} ({percent(structure.size)} without outliers); "
            "intervals allow for that if it is noise, but not if the scene differs from the "
            "experiment"
        )
    elif error >= STRUCTURED:
        count = counted(int(problem.counted.sum()), "number")
        yield (
            f"the error is {percent(error)}; {count} do not show whether that is noise or a "
            "wrong model: compare with held-out data"
        )


def mistakes(problem: Problem) -> list[str]:
    """Return which fits are measured so that their unit or their sign may be wrong.

    The data is compared with the first prediction.
    """
    theta = np.zeros(problem.size)
    try:
        problem.freeze(theta)
        predicted = problem.predicted(theta)[problem.counted]
    except (Diverged, TissueError):
        return []
    found: list[str] = []
    data = problem.data[problem.counted]
    for k, fit in enumerate(problem.fit_problem.fits):
        mine = problem.fits == k
        sizes = [float(np.abs(some[mine]).max(initial=0.0)) for some in (data, predicted)]
        ratio = sizes[0] / sizes[1] if min(sizes) > 0.0 else 1.0
        if not 1.0 / WRONG_UNIT < ratio < WRONG_UNIT:
            found.append(
                f"the data of {fit.text} is {ratio:.1g} times as large as the first "
                "prediction: check its unit"
            )
        both = data[mine], predicted[mine] - problem.zero(theta, k)
        lengths = float(np.linalg.norm(both[0]) * np.linalg.norm(both[1]))
        if both[0] @ both[1] < OPPOSITE * lengths:
            way_out = "change the sign of the data"
            if " along " in fit.text:
                way_out = f"reverse the direction after along, or {way_out}"
            found.append(
                f"the data of {fit.text} has the opposite sign of the first prediction: "
                f"{way_out}"
            )
    return found


def _is_met(problem: Problem, theta: Floats) -> bool:
    """Return whether all noise was given, and no more is left."""
    return problem.noise_is_given and problem.rms(theta) < MET
