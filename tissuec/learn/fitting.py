"""The search for the parameters: passes of SciPy's optimisers over growing horizons.

A pass freezes what happens in all experiments where the last one came to, and begins the
optimiser anew there. So nothing but the parameters goes from pass to pass, and a learning that
was interrupted goes on from the last one to the same result. Where the first prediction is
far off, the beginning of the data is learnt first: over many periods of an oscillation, an
error function has a minimum for each period that is missed. (H. U. Voss, J. Timmer, J. Kurths,
Int. J. Bifurcation and Chaos 14:1905, 2004.)
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares, minimize

from tissuec.core.errors import TissueError
from tissuec.learn.motion import Diverged
from tissuec.learn.problem import Problem
from tissuec.network import Floats

LEAST_SQUARES, LBFGS = "least squares", "l-bfgs-b"
FEW = 1000  # parameters up to which every one is carried forward through the motion
ENTRIES = 4e7  # of the matrix of sensitivities, up to which it is made
ROUNDS, ITERATIONS = 50, 60  # of either optimiser in a pass
HORIZONS = (1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0)  # parts of the data, from the beginning
FAR = 0.02  # of the data's own deviation: an error from which on horizons grow
NEAR, WIDE = 1.0, 3.0  # how far a pass goes in any parameter, before and on the last horizon
LOOKS = 3  # at the noise, at most
TRIES = 3  # passes at most, before the last horizon
LOOSE = 1e-3  # tolerance before the last horizon
FAINT = 1e-8  # of the strongest sensitivity: what is weaker leaves a parameter where it is
PERFECT = 1e-28  # of the first error: rounding is all that is left


class Countless(Diverged):
    """Predictions are so far from what was measured that their error is no number."""

    def __str__(self) -> str:
        return "what is predicted is too far from what was measured for any number"


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """Where a search stands between two passes.

    Attributes:
        horizon: Which of the horizons is learnt.
        passes: How many are over, in all.
        error: E over this horizon.
        noise: By which residuals are measured, shape (fit,).
        rounds: How often the noise was taken from what was left.
        rest: Root of the mean square of what was left at the last look.
        tries: How many passes this horizon has had.
        reason: Why the search is over; empty while it goes on.
        converged: Whether that was because nothing changed any more.
    """

    theta: Floats
    horizon: int
    passes: int
    error: float
    noise: Floats
    evaluations: int
    rounds: int = 0
    rest: float = 0.0
    tries: int = 0
    reason: str = ""
    converged: bool = False


Keep = Callable[[Standing], None]


class Search:
    """A search for the parameters of least error.

    Args:
        bounds: Least and greatest parameters, shape (parameter,).
        keep: Told where the search stands after each pass.
    """

    def __init__(self, problem: Problem, bounds: tuple[Floats, Floats], keep: Keep):
        self.problem, self.bounds, self.keep = problem, bounds, keep
        lesson = problem.lesson
        entries = problem.size * len(problem.data)
        self.method = lesson.method
        if self.method == "automatic":
            is_small = problem.size <= FEW and entries <= ENTRIES
            self.method = LEAST_SQUARES if is_small else LBFGS

    def begin(self) -> Standing:
        """Return where a search begins.

        Raises:
            Diverged: The first prediction has no numbers, or is beyond all measure.
        """
        problem = self.problem
        problem.trust = self._trust(0, 0.0)
        theta = np.clip(np.zeros(problem.size), *self.bounds)
        problem.freeze(theta)
        horizon = self._first_horizon(theta)
        self._limit(horizon)
        error = self._error(theta)
        return Standing(theta, horizon, 0, error, problem.noise, problem.evaluations)

    def go(self, standing: Standing) -> Standing:
        """Return where the search ends, from where it stands.

        Raises:
            Diverged: What it came to has no numbers on a longer horizon.
        """
        self.problem.evaluations = standing.evaluations
        while not standing.reason:
            standing = self._pass(standing)
            self.keep(standing)
        self._limit(len(HORIZONS) - 1)
        self.problem.trust, self.problem.noise = (
            self._trust(standing.rounds, standing.rest),
            standing.noise,
        )
        self.problem.freeze(standing.theta)
        return standing

    # --- parts --------------------------------------------------------------------------------

    def _first_horizon(self, theta: Floats) -> int:
        """Return the horizon to begin with: the whole, unless its prediction is far off."""
        problem, last = self.problem, len(HORIZONS) - 1
        if problem.lesson.axis.nodes is not None or not problem.duration:
            return last
        try:
            if problem.relative(theta) < FAR:
                return last
        except Diverged:
            pass  # as far off as can be
        enough = [
            k
            for k, part in enumerate(HORIZONS)
            if problem.many_until(part * problem.duration) >= 4 * problem.size
        ]
        return min(enough, default=last)

    def _limit(self, horizon: int) -> None:
        part = HORIZONS[horizon]
        self.problem.limit(np.inf if part == 1.0 else part * self.problem.duration)

    def _error(self, theta: Floats) -> float:
        """Return E where a pass begins, which no optimiser can do without."""
        error = self.problem.error(theta)
        if not np.isfinite(error):
            raise Countless(self.problem.stop)
        return error

    def _pass(self, old: Standing) -> Standing:
        """Return where one pass comes to."""
        problem, last = self.problem, old.horizon == len(HORIZONS) - 1
        tolerance = problem.lesson.tolerance if last else LOOSE
        self._limit(old.horizon)
        problem.trust, problem.noise = self._trust(old.rounds, old.rest), old.noise
        problem.freeze(old.theta)
        before = self._error(old.theta)
        theta = self._optimised(old.theta, tolerance, WIDE if last else NEAR)
        error = problem.error(theta)
        if not error <= before:
            theta, error = old.theta, before
        new = replace(
            old,
            theta=theta,
            passes=old.passes + 1,
            error=error,
            evaluations=problem.evaluations,
            tries=old.tries + 1,
        )
        calm = before - error <= tolerance * before or error <= PERFECT * len(problem.data)
        if not last and (calm or new.tries == TRIES):
            return replace(new, horizon=old.horizon + 1, tries=0)
        if calm and self._measures_noise(new):
            return self._weighed(new)
        if calm:
            return replace(new, reason="the error falls no further", converged=True)
        if new.passes >= problem.lesson.passes:
            return replace(new, reason=f"{new.passes} passes are over")
        return new

    @property
    def _noise_is_unknown(self) -> bool:
        fits = self.problem.lesson.fits
        return not self.problem.lesson.scaled or any(fit.noise is None for fit in fits)

    def _trust(self, rounds: int, rest: float) -> float:
        """Return the factor of what was expected, after so many looks at the noise.

        Where errors count as they are, what was expected counts in units of what is left.
        """
        if self._noise_is_unknown and not rounds:
            return 0.0
        return 1.0 if self.problem.lesson.scaled else rest

    def _measures_noise(self, standing: Standing) -> bool:
        """Tell whether residuals are to be weighed anew by what was left of each fit."""
        matters = len(self.problem.lesson.fits) > 1 or bool(self.problem.priors)
        return self._noise_is_unknown and matters and standing.rounds < LOOKS

    def _weighed(self, old: Standing) -> Standing:
        """Return the same with the noise that was left, or at least that of rounding."""
        problem, left = self.problem, self.problem.left(old.theta)
        rest = float(np.sqrt(np.mean(left**2)))
        new = replace(old, rounds=old.rounds + 1, rest=rest)
        if not problem.lesson.scaled:
            return new
        found = problem.noise.copy()
        for k, fit in enumerate(problem.lesson.fits):
            mine = left[problem.fits == k]
            if fit.noise is None and len(mine):
                found[k] = max(float(np.sqrt(np.mean(mine**2))), 1e-9 * problem.spread[k])
        return replace(new, noise=found)

    def _optimised(self, theta: Floats, tolerance: float, reach: float) -> Floats:
        """Return where the optimiser comes to, at most so far away in any parameter.

        Data that is noisy or short may tell next to nothing of some parameters, which then
        would go anywhere in one step.
        """
        low, high = self.bounds
        bounds = np.maximum(low, theta - reach), np.minimum(high, theta + reach)
        step = self._by_least_squares if self.method == LEAST_SQUARES else self._by_lbfgs
        with np.errstate(all="ignore"):  # what has no numbers is not gone to
            return step(theta, bounds, tolerance)

    def _by_least_squares(
        self, theta: Floats, bounds: tuple[Floats, Floats], tolerance: float
    ) -> Floats:
        """Return where SciPy's trust region of least squares comes to."""
        problem = self.problem
        problem.faint = 0.0
        columns = np.sqrt(np.square(problem.jacobian(theta)).sum(axis=0))
        if not columns.any():
            return theta  # nothing that is looked at depends on anything
        problem.faint = FAINT * float(columns.max())
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
            "max_nfev": ROUNDS,
        }
        found: Any = least_squares(residuals, theta, **options)
        return np.asarray(found.x)

    def _by_lbfgs(
        self, theta: Floats, bounds: tuple[Floats, Floats], tolerance: float
    ) -> Floats:
        """Return where SciPy's L-BFGS-B comes to."""
        scale = max(self.problem.error(theta), 1e-300)

        def value(at: Floats) -> tuple[float, Floats]:
            try:
                error, slope = self.problem.gradient(at)
            except (Diverged, TissueError):
                return 1e30, np.zeros_like(at)
            if not (np.isfinite(error) and np.isfinite(slope).all()):
                return 1e30, np.zeros_like(at)
            return error / scale, slope / scale

        options = {"maxiter": ITERATIONS, "maxcor": 30, "ftol": tolerance, "gtol": 0.0}
        found: Any = minimize(
            value,
            theta,
            jac=True,
            method="L-BFGS-B",
            bounds=np.stack(bounds, axis=1),
            options=options,
        )
        return np.asarray(found.x)
