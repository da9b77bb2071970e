"""Horizons: how much of the data is learnt, from its beginning; they grow to the whole.

Over many periods of an oscillation, an error function has a minimum for each period that is
missed; over the beginning it has one. (H. U. Voss, J. Timmer, J. Kurths, Int. J. Bifurcation
and Chaos 14:1905, 2004.) A first prediction is near enough for the whole if a step by
derivatives makes the error there as small as these promise.
"""

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.optimiser import FAINT, LEAST_SQUARES, Optimiser
from tissuec.learn.fit.problem import Problem
from tissuec.model.network import Floats

HORIZONS = (1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0)  # parts of the data, from the beginning
WHOLE = len(HORIZONS) - 1
FAR = 0.02  # of the data's own deviation: an error from which on horizons may grow
KEPT = 0.75  # of the decrease that derivatives promise: their step is to be relied on
NEAR = 1.0  # how far a step goes in any parameter, before the last horizon


def limit(problem: Problem, horizon: int) -> None:
    """Let a problem have the data of one of the horizons."""
    problem.limit_to(HORIZONS[horizon])


class Horizons:
    """The horizons of a problem.

    Args:
        problem: The problem.
        optimiser: Its optimiser.
    """

    def __init__(self, problem: Problem, optimiser: Optimiser):
        self.problem, self.optimiser = problem, optimiser

    def begun(self, theta: Floats) -> tuple[int, Floats]:
        """Return the horizon to begin with, and parameters with the zeros that suit it.

        The horizon is the whole, unless its prediction is far off.
        """
        problem = self.problem
        limit(problem, WHOLE)
        problem.freeze(theta)
        best = problem.with_zeros(theta)
        if self._is_near(best):
            return WHOLE, best
        return self.growing(theta)

    def growing(self, theta: Floats) -> tuple[int, Floats]:
        """Return the least horizon that determines all parameters, and zeros that suit it."""
        problem = self.problem
        enough = [
            k
            for k, part in enumerate(HORIZONS)
            if problem.many_until(part * problem.duration) >= 4 * problem.size
        ]
        horizon = WHOLE if self.is_still else min(enough, default=WHOLE)
        limit(problem, horizon)
        return horizon, problem.with_zeros(theta)

    @property
    def is_still(self) -> bool:
        """Return whether there is no time, so that horizons do not grow."""
        return self.problem.fit_problem.axis.nodes is not None or not self.problem.duration

    def _is_near(self, theta: Floats) -> bool:
        """Return whether the whole horizon, with events as they are frozen, can be learnt."""
        try:
            return (
                self.is_still
                or self.problem.relative(theta) < FAR
                or self._keeps_promise(theta)
            )
        except (Diverged, TissueError):
            return False

    def _keeps_promise(self, theta: Floats) -> bool:
        """Return whether a step by derivatives decreases the error as much as it should."""
        problem = self.problem
        if self.optimiser.method != LEAST_SQUARES or not problem.size:
            return False
        residuals, rows = problem.residuals(theta), problem.jacobian(theta)
        if not (np.isfinite(residuals).all() and np.isfinite(rows).all()):
            return False
        solved = np.linalg.lstsq(rows, -residuals, rcond=FAINT)[0]
        step: Floats = np.clip(theta + solved, *self.optimiser.bounds) - theta
        if (np.abs(step) > np.where(np.isfinite(problem.reaches), NEAR, np.inf)).any():
            return False
        before, promised = (
            0.5 * float(np.square(some).sum()) for some in (residuals, residuals + rows @ step)
        )
        return before - problem.error(theta + step) >= KEPT * (before - promised)
