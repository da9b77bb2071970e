"""Passes of SciPy's optimisers over growing horizons of the data.

Least squares are minimised by a trust region with exact derivatives; where parameters or data
are too many for a matrix of derivatives, L-BFGS-B follows gradients.

Horizons: how much of the data is learnt, from its beginning; they grow to the whole.

Over many periods of an oscillation, an error function has a minimum for each period that is
missed; over the beginning it has one. (H. U. Voss, J. Timmer, J. Kurths, Int. J. Bifurcation
and Chaos 14:1905, 2004.) A first prediction is near enough for the whole if a step by
derivatives makes the error there as small as these promise.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares, minimize

from tissuec.core.errors import TissueError
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.problem import Problem
from tissuec.model.network import Floats

LEAST_SQUARES, LBFGS = "least squares", "l-bfgs-b"
FEW = 1000  # parameters up to which every one is carried forward through the motion
ENTRIES = 4e7  # of the matrix of sensitivities, up to which it is made
ROUNDS, ITERATIONS = 50, 60  # of either optimiser in a pass
HALVINGS = 4  # of the way of a pass whose end is worse once events are found anew
FAINT = 1e-8  # of the strongest sensitivity: what is weaker leaves a parameter where it is


class InfiniteError(Diverged):
    """Predictions are so far from the data that their error is not finite."""

    def __str__(self) -> str:
        return "the prediction is too far from the data: the error is not finite"


class PassEnd(NamedTuple):
    """Where an optimiser came to.

    Attributes:
        error: E with the events of these parameters.
        is_final: Whether a further pass would find nothing better within the tolerance.
    """

    theta: Floats
    error: float
    is_final: bool


class Optimiser:
    """The optimiser of a problem, by the method that it states or that its size allows.

    Args:
        problem: The problem.
        bounds: Least and greatest parameters, shape (parameter,).

    Attributes:
        method: ``LEAST_SQUARES`` or ``LBFGS``.
        rounds: How often a pass by least squares evaluates the predictions at most.
        is_blind: Whether no prediction of the last pass depended on any parameter.
    """

    def __init__(self, problem: Problem, bounds: tuple[Floats, Floats]):
        self.problem, self.bounds, self.rounds = problem, bounds, ROUNDS
        self.method, self.is_blind = problem.fit_problem.method, False
        if self.method == "automatic":
            entries = problem.size * len(problem.data)
            is_small = problem.size <= FEW and entries <= ENTRIES
            self.method = LEAST_SQUARES if is_small else LBFGS

    def error_at(self, theta: Floats) -> float:
        """Return E with what happens for these parameters; infinite where there is none."""
        try:
            error = self.problem.error_at(theta)
        except (Diverged, TissueError):
            return np.inf
        return error if np.isfinite(error) else np.inf

    def improved(self, theta: Floats, before: float, tolerance: float, reach: float) -> PassEnd:
        """Return where a pass comes to, with events found anew there.

        They may make it worse than the frozen ones promised: then half of the way is tried.

        Args:
            theta: Where it begins, dimensionless, shape (parameter,).
            before: E there.
            tolerance: Relative decrease of E that is too small to continue.
            reach: How far it goes in any parameter.
        """
        problem, pull = self.problem, self.problem.faint
        try:
            there, expected = self._optimised(theta, tolerance, reach)
        except (Diverged, TissueError):
            return PassEnd(theta, before, is_final=False)
        finally:
            problem.faint = pull
        for halved in range(HALVINGS):
            error = self.error_at(there)
            if error <= before:
                is_final = False
                if expected is not None and not halved:
                    # No step of a linear model gains more, without what was faint then, too.
                    gain = 0.5 * float(np.square(problem.residuals(there) - expected).sum())
                    is_final = gain <= tolerance * error
                return PassEnd(there, error, is_final)
            there = 0.5 * (theta + there)
        return PassEnd(theta, before, is_final=False)

    def _optimised(
        self, theta: Floats, tolerance: float, farthest: float
    ) -> tuple[Floats, Floats | None]:
        """Return where the optimiser comes to, at most so far away in any parameter.

        Data that is noisy or short may hardly constrain some parameters, which then
        would go anywhere in one step. If there is the minimum, its residuals are returned, too.
        """
        low, high = self.bounds
        reach = np.where(
            np.isfinite(self.problem.reaches), farthest, np.inf
        )  # zeros are linear
        bounds = np.maximum(low, theta - reach), np.minimum(high, theta + reach)
        step = self._by_least_squares if self.method == LEAST_SQUARES else self._by_lbfgs
        if not self.problem.size:
            return theta, None  # only rules are revised
        there, left = step(theta, bounds, tolerance)
        is_inside = (np.abs(there - theta) < 0.9 * reach).all()
        return there, left if is_inside else None

    def _by_least_squares(
        self, theta: Floats, bounds: tuple[Floats, Floats], tolerance: float
    ) -> tuple[Floats, Floats | None]:
        """Return where SciPy's trust region of least squares comes to."""
        problem, pull = self.problem, self.problem.faint
        problem.faint = np.zeros(problem.size)
        columns = np.sqrt(np.square(problem.jacobian(theta)).sum(axis=0))
        self.is_blind = not columns.any()
        if self.is_blind:
            return theta, None  # no prediction depends on any parameter
        if not np.isfinite(columns).all():
            raise InfiniteError(problem.stop)
        problem.faint = np.maximum(FAINT * columns.max(), pull)
        size = len(problem.residuals(theta))

        def residuals(at: Floats) -> Floats:
            try:
                return problem.residuals(at)
            except (Diverged, TissueError):
                return np.full(size, np.nan)  # SciPy takes a shorter step

        options: dict[str, Any] = {
            "jac": problem.jacobian,
            "bounds": bounds,
            "ftol": max(tolerance, 1e-15),
            "xtol": 1e-14,
            "gtol": None,
            "max_nfev": self.rounds,
        }
        found: Any = least_squares(residuals, theta, **options)
        return np.asarray(found.x), np.asarray(found.fun) if found.status > 0 else None

    def _by_lbfgs(
        self, theta: Floats, bounds: tuple[Floats, Floats], tolerance: float
    ) -> tuple[Floats, None]:
        """Return where SciPy's L-BFGS-B comes to; how exactly, it does not say."""
        scale = max(self.problem.error(theta), 1e-300)

        def value(at: Floats) -> tuple[float, Floats]:
            try:
                error, slope = self.problem.gradient(at)
            except (Diverged, TissueError):
                return 1e30, np.zeros_like(at)
            if not (np.isfinite(error) and np.isfinite(slope).all()):
                return 1e30, np.zeros_like(at)
            return error / scale, slope / scale

        options: Any = {"maxiter": ITERATIONS, "maxcor": 30, "ftol": tolerance, "gtol": 0.0}
        limits: Any = np.stack(bounds, axis=1)
        found: Any = minimize(
            value,
            theta,
            jac=True,
            method="L-BFGS-B",
            bounds=limits,
            options=options,
        )
        return np.asarray(found.x), None


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
