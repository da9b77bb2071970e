"""Whether what is left is so much that the search, or the model, has failed."""

from collections.abc import Sequence

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.learn.fitting import MET
from tissuec.learn.motion import Diverged
from tissuec.learn.problem import LIMIT, Problem
from tissuec.learn.shown import percent
from tissuec.network import Floats

NOTHING = 0.8  # error from which on it is near that of knowing the mean alone, which is 1
STRUCTURED = 0.2  # size from which on residuals that are no noise are a failure
WRONG_UNIT = 300.0  # times as large, or as small, as predicted
TOLD = 0.02  # size from which on they are told


def misfit(problem: Problem, theta: Floats, singles: Sequence[Problem] = ()) -> str:
    """Return why some parameters are no answer, as a sentence; empty if they may be one.

    Args:
        theta: Where the search ended, its whole horizon in use.
        singles: The same problem for each experiment by itself.
    """
    if _is_met(problem, theta):
        return ""
    error = problem.relative(theta)
    if error >= NOTHING:
        return (
            f"the error is {percent(error)}, and that of knowing only the mean of the data is "
            "100 %: nothing was learnt"
        )
    if problem.structure(theta, LIMIT).exceeds(STRUCTURED):
        return (
            f"the error is {percent(error)}, and what is left is no noise but a motion of its "
            "own: this is another minimum, or the scene is not what was measured"
        )
    for one in singles:
        found = one.structure(theta, LIMIT)
        share = found.size * float((one.spread / problem.spread).max(initial=0.0))
        if found.exceeds(NOTHING) and share >= TOLD:
            name = one.trials[0].experiment.name
            return (
                f"the error of {name} is {percent(found.size)}, and what is left of it is no "
                "noise: the scene, or what may change in it, is not what was measured"
            )
    return ""


def remark(problem: Problem, theta: Floats) -> str:
    """Return what is to be known of residuals that are small and yet no noise, if they are."""
    found = problem.structure(theta, LIMIT)
    if _is_met(problem, theta) or not found.exceeds(TOLD):
        return ""
    return (
        f"what is left is no noise: neighbours are correlated by {found.correlation:.2f} "
        f"({percent(found.size)} without outliers); the scene is not quite what was measured, "
        "and numbers may be off by more than their intervals"
    )


def units(problem: Problem) -> list[str]:
    """Return which fits are measured so large or small that their unit may be wrong.

    Sizes of the data are held against those of the first prediction.
    """
    theta = np.zeros(problem.size)
    try:
        problem.freeze(theta)
        predicted = problem.predicted(theta)[problem.counted]
    except (Diverged, TissueError):
        return []
    found, data = [], problem.data[problem.counted]
    for k, fit in enumerate(problem.lesson.fits):
        mine = problem.fits == k
        sizes = [float(np.abs(some[mine]).max(initial=0.0)) for some in (data, predicted)]
        ratio = sizes[0] / sizes[1] if min(sizes) > 0.0 else 1.0
        if not 1.0 / WRONG_UNIT < ratio < WRONG_UNIT:
            found.append(
                f"{fit.text} was measured {ratio:.1g} times as large as the scene predicts at "
                "first: is its unit right?"
            )
    return found


def _is_met(problem: Problem, theta: Floats) -> bool:
    """Tell whether all noise was given, and no more is left."""
    return problem.noise_is_given and problem.rms(theta) < MET
