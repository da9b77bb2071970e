"""Intervals of parameters by bootstrap: they are fitted again to data that might have been.

Such data are the predictions of the fit with noise. For each fit it is another one of those
that the residuals allow, with its size and its correlation in time, as for intervals by
derivatives; so only nonlinearity makes the two differ. Expectations are drawn from what they
say. Intervals are percentiles of the parameters that are found (B. Efron, R. J. Tibshirani, An
Introduction to the Bootstrap, 1993, chapter 13).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.structs import replace
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.evaluations import Evaluator
from tissuec.learn.fit.noise import NoiseDraws, chains_of
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
        """Return the source of the intervals."""
        bad = f", {self.failed} of which failed" if self.failed else ""
        return f"bootstrap with {self.fits} fits to simulated data{bad}"


class Refit(Struct, frozen=True, eq=False):
    """A fit to data that might have been.

    Attributes:
        number: Of the data, from 0; with the seed and the noise, it says all about them.
        noise: Standard deviation [unit of the fit], correlation from row to row and share of
            white noise of each fit.
        end: Where the search for the parameters ended.
    """

    number: int
    noise: tuple[tuple[float, float, float], ...]
    end: SearchState

    def evaluate(self, session: LearnSession) -> Floats:
        """Return the parameters, shape (parameter,); none where no fit is found."""
        problem, end = session.problem, self.end
        search = Search(problem, session.bounds(problem), _forget)
        try:
            search.enter(end)
            problem.freeze(end.theta)
            random = np.random.default_rng([session.fit_problem.seed, self.number])
            problem.data = resampled(problem, end.theta, self.noise, random)
            problem.priors = tuple(
                replace(one, value=random.normal(end.theta[one.place], one.spread))
                for one in problem.priors
            )
            found = search.refit(end)
        except (Diverged, TissueError):
            return np.zeros(0)
        # An optimiser that cannot take a step comes back with nothing changed.
        return found if (found != end.theta).any() else np.zeros(0)


def intervals(
    evaluator: Evaluator,
    end: SearchState,
    draws: Sequence[NoiseDraws],
    fits: int,
    done: Callable[[int], None] | None,
) -> Resampled | None:
    """Return the intervals of the parameters that a search ended with; None if fits fail.

    Args:
        evaluator: Does the fits.
        end: Where the search ended.
        draws: The noise of each fit.
        fits: How many there are.
        done: Progress callback: the number of finished ones.
    """
    results = evaluator.all([Refit(k, _noise(draws, k), end) for k in range(fits)], done)
    found = [theta for theta in results if theta is not None and len(theta)]
    if fits - len(found) > MOST_FAILED * fits:
        return None
    low, high = np.percentile(np.array(found), SURE, axis=0)
    return Resampled(low, high, fits, fits - len(found))


def _noise(draws: Sequence[NoiseDraws], number: int) -> tuple[tuple[float, float, float], ...]:
    """Return one noise of each fit; entries of a sample have no order."""
    return tuple(
        (float(one.size[k]), float(one.correlation[k]), float(one.white[k]))
        for one in draws
        for k in [number % len(one.size)]
    )


def resampled(
    problem: Problem,
    theta: Floats,
    noise: Sequence[tuple[float, float, float]],
    random: np.random.Generator,
) -> Floats:
    """Return data that might have been measured, in SI units, shape (number,).

    Args:
        problem: Frozen at the parameters.
        theta: Parameters, dimensionless, shape (parameter,).
        noise: Of each fit, as in ``Refit``.
        random: Chooses the noise.
    """
    predicted = problem.predicted(theta)
    errors = np.zeros(int(problem.counted.sum()))
    for chains, one in zip(chains_of(problem), noise, strict=True):
        errors[chains.order] = chains.path(*one, random)
    found = np.where(np.isfinite(problem.data), predicted, np.nan)
    found[problem.counted] += errors
    return found


def _forget(_: SearchState) -> None:
    """Keep nothing of a search."""
