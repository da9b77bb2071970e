"""Intervals of parameters by bootstrap: they are fitted again to data that might have been.

Such data are the predictions of the fit with its residuals, drawn again with replacement: in
blocks of successive rows, so that what is correlated from row to row stays so (H. R. Künsch,
Annals of Statistics 17, 1989, 1217-1241), and with the first row behind the last, so that all
rows are drawn equally often (D. N. Politis, J. P. Romano, A circular block-resampling procedure
for stationary data, in: Exploring the Limits of Bootstrap, 1992). Before that, the residuals of
each series are centred and multiplied by √(n / (n - p)), for p parameters that were fitted to n
numbers made them smaller. Expectations are drawn from what they say. Intervals are percentiles
of the parameters that are found (B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap,
1993, chapter 13).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.core.errors import TissueError
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.evaluations import Evaluator
from tissuec.learn.fit.problem import Problem
from tissuec.learn.fit.search import Search, SearchState
from tissuec.learn.fit.session import LearnSession
from tissuec.model.network import Floats

SURE = (2.5, 97.5)  # percentiles
MOST_FAILED = 0.2  # of the fits: beyond, intervals would be those of the others alone


class Resampled(NamedTuple):
    """Intervals of all parameters.

    Attributes:
        low, high: Their ends, dimensionless, shape (parameter,).
        fits, failed: How many fits there were, and how many of them found nothing.
    """

    low: Floats
    high: Floats
    fits: int
    failed: int

    @property
    def sentence(self) -> str:
        """Return what the intervals are from."""
        bad = f", {self.failed} of which failed" if self.failed else ""
        return f"bootstrap with {self.fits} fits to resampled residuals{bad}"


class Refit(Struct, frozen=True, eq=False):
    """A fit to data that might have been.

    Attributes:
        number: Of the data, from 0; with the seed, it says all about them.
        end: Where the search for the parameters ended.
    """

    number: int
    end: SearchState

    def evaluate(self, session: LearnSession) -> Floats:
        """Return the parameters, shape (parameter,); none where no fit is found."""
        problem, end = session.problem, self.end
        search = Search(problem, session.bounds(problem), _forget)
        try:
            search.enter(end)
            problem.freeze(end.theta)
            random = np.random.default_rng([session.fit_problem.seed, self.number])
            problem.data = resampled(problem, end.theta, random)
            problem.priors = tuple(
                replace(one, value=random.normal(one.value, one.spread))
                for one in problem.priors
            )
            found = search.refit(end)
        except (Diverged, TissueError):
            return np.zeros(0)
        # An optimiser that cannot take a step comes back with nothing changed.
        return found if (found != end.theta).any() else np.zeros(0)


def intervals(
    evaluator: Evaluator, end: SearchState, fits: int, done: Callable[[int], None] | None
) -> Resampled | None:
    """Return the intervals of the parameters that a search ended with; None if fits fail.

    Args:
        evaluator: Does the fits.
        end: Where the search ended.
        fits: How many there are.
        done: Told how many are over.
    """
    results = evaluator.all([Refit(number, end) for number in range(fits)], done)
    found = [theta for theta in results if theta is not None and len(theta)]
    if fits - len(found) > MOST_FAILED * fits:
        return None
    low, high = np.percentile(np.array(found), SURE, axis=0)
    return Resampled(low, high, fits, fits - len(found))


def resampled(problem: Problem, theta: Floats, random: np.random.Generator) -> Floats:
    """Return data that might have been measured, in SI units, shape (number,).

    Args:
        problem: Frozen at the parameters.
        theta: Parameters, dimensionless, shape (parameter,).
        random: Chooses blocks.
    """
    predicted = problem.predicted(theta)
    left = problem.data - predicted
    known = np.isfinite(left)
    count = int(known.sum())
    wider = np.sqrt(count / max(count - problem.size, 1))
    noise = np.zeros_like(left)
    for rows, into in zip(problem.of_series(left), problem.of_series(noise), strict=True):
        centred = rows - _mean(rows)
        into[:] = wider * np.nan_to_num(centred[_blocks(len(rows), random)])
    return np.where(known, predicted + noise, np.nan)


def _blocks(rows: int, random: np.random.Generator) -> Sequence[int]:
    """Return rows in blocks of the third root of their number, from random ones on."""
    length = max(1, round(rows ** (1.0 / 3.0)))
    starts = random.integers(0, max(rows, 1), -(-rows // length))
    drawn = (starts[:, None] + np.arange(length)) % max(rows, 1)
    return drawn.ravel()[:rows].tolist()


def _mean(rows: Floats) -> Floats:
    """Return the mean of each column without gaps, 0 where there is nothing."""
    known = np.isfinite(rows)
    total = np.where(known, rows, 0.0).sum(axis=0)
    return np.asarray(total / np.maximum(known.sum(axis=0), 1))


def _forget(_: SearchState) -> None:
    """Keep nothing of a search."""
