"""The search for parameters: SciPy's optimisers from several starts, over growing horizons.

A pass freezes what happens in all experiments where the last one came to, and begins the
optimiser anew there. Only the state of the search goes from pass to pass, so that an
interrupted one continues to the same result. Where the first prediction is far off, the
beginning of the data is learnt first; see ``horizons``. The beginning alone tells some
parameters next to nothing, and noise would carry them far away: there, all are pulled towards
where they start.

If what is left on the whole horizon does not look like noise, further starts are tried: the
same with the other kind of horizons, then the best of a random sample. The best minimum of all
is refined. No pass ends at a larger error than it began with, and the last one is not repeated
if predictions hardly change once events are found anew.
"""

import hashlib
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, Self

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict

from tissuec.core.errors import TissueError, counted
from tissuec.core.files import OutputFile, final_place
from tissuec.core.structs import replace
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.optimiser import (
    FAR,
    NEAR,
    WHOLE,
    Horizons,
    InfiniteError,
    Optimiser,
    limit,
)
from tissuec.learn.fit.problem import Problem
from tissuec.learn.fit.residual_structure import residual_structure
from tissuec.learn.fit.session import LearnSession
from tissuec.model.network import Floats
from tissuec.results import PlaceError
from tissuec.results.manifest import versions
from tissuec.scene.request import Request

WIDE = 3.0  # how far a pass goes in any parameter on the last horizon
LOOKS = 3  # at the noise, at most
SAME_NOISE = 0.05  # change of the noise for which nothing is weighed anew
TRIES = 3  # passes at most, before the last horizon
LOOSE = 1e-3  # tolerance of a start, before the best one is refined
SEARCHING = 0.6  # of all passes, after which no further start is tried
PERFECT = 1e-28  # of the first error: rounding is all that is left
#: Errors that are good: of uncorrelated residuals, and in units of given noise.
FITTING, MET = 0.3, 1.5
# Two starts that are so close came to the same minimum: their errors, and either their
# parameters or, as a part of the residuals, their predictions.
SAME_ERROR, SAME_PLACE = 0.01, 0.1


class SearchState(Struct, frozen=True, eq=False):
    """State of a search between two passes.

    Attributes:
        theta: Parameters, shape (parameter,).
        horizon: Which of the horizons is learnt.
        passes: How many are over, in all.
        error: E over this horizon.
        noise: By which residuals are measured, shape (fit,).
        best, best_error: The best parameters on the whole horizon so far, and their E.
        start: Number of the start in use: 0 is the scene as it is written, 1 the same with
            growing horizons instead of the whole one, or the reverse; from 2 on those of
            ``sample``.
        sample: Further starts, shape (start, parameter); made when they are needed.
        refined: Whether all starts are over, and the best minimum is refined.
        rounds: How often the noise was taken from what was left.
        rest: Root of the mean square of what was left at the last look.
        tries: How many passes this horizon has had.
        reason: Why the search is over; empty while it continues.
        converged: Whether that was because nothing changed any more.
    """

    theta: Floats
    horizon: int
    passes: int
    error: float
    noise: Floats
    evaluations: int
    best: Floats
    best_error: float
    sample: Floats
    start: int = 0
    refined: bool = False
    rounds: int = 0
    rest: float = 0.0
    tries: int = 0
    reason: str = ""
    converged: bool = False


Keep = Callable[[SearchState], None]


class Search:
    """A search for the parameters of least error.

    Args:
        bounds: Least and greatest parameters, shape (parameter,).
        keep: Called after each pass with the state of the search.
        sample: Returns further starts, shape (start, parameter), the best first; None: there
            are none.
    """

    def __init__(
        self,
        problem: Problem,
        bounds: tuple[Floats, Floats],
        keep: Keep,
        sample: Callable[[], Floats] | None = None,
    ):
        self.problem, self.bounds, self.keep, self.sample = problem, bounds, keep, sample
        self.optimiser = Optimiser(problem, bounds)
        self.horizons = Horizons(problem, self.optimiser)

    def begin(self) -> SearchState:
        """Return the first state of a search.

        Raises:
            Diverged: The first prediction is not finite.
            InfiniteError: The error of the first prediction is not finite.
        """
        problem = self.problem
        problem.trust = self._trust(0, 0.0)
        theta = np.clip(np.zeros(problem.size), *self.bounds)
        horizon, theta = self.horizons.begun(theta)
        limit(problem, WHOLE)
        whole = self.optimiser.error_at(theta)
        limit(problem, horizon)
        error = problem.error_at(theta)
        if not np.isfinite(error):
            raise InfiniteError(problem.stop)
        none = np.zeros((0, problem.size))
        return SearchState(
            theta, horizon, 0, error, problem.noise, problem.evaluations, theta, whole, none
        )

    def go(self, state: SearchState) -> SearchState:
        """Return the final state of a search.

        Raises:
            InfiniteError: No start has a motion with a finite error.
        """
        self.problem.evaluations = state.evaluations
        while not state.reason:
            with np.errstate(all="ignore"):  # what has no numbers is not gone to
                state = replace(self._pass(state), evaluations=self.problem.evaluations)
            self.keep(state)
        self.enter(state)
        if not np.isfinite(self.problem.error_at(state.theta)):
            raise InfiniteError(self.problem.stop)
        return state

    def once(self, rounds: int) -> Floats:
        """Return the result of a single pass from the start on the whole horizon.

        It is dimensionless and has the shape (parameter,).

        Raises:
            Diverged: The first prediction is not finite.
        """
        self.optimiser.rounds = rounds
        with np.errstate(all="ignore"):
            _, start = self.horizons.begun(np.clip(np.zeros(self.problem.size), *self.bounds))
            limit(self.problem, WHOLE)
            self.problem.freeze(start)
            return self.optimiser.improved(start, self.problem.error(start), LOOSE, WIDE).theta

    def refit(self, end: SearchState) -> Floats:
        """Return the result of a single pass from the end of a search, with other data.

        Without a motion or a smaller error it is that end; dimensionless, shape (parameter,).
        """
        tolerance = self.problem.fit_problem.tolerance
        with np.errstate(all="ignore"):
            before = self.problem.error(end.theta)
            return self.optimiser.improved(end.theta, before, tolerance, WIDE).theta

    def enter(self, state: SearchState) -> None:
        """Measure residuals as they are at a state of the search."""
        problem = self.problem
        limit(problem, state.horizon)
        problem.trust, problem.noise = self._trust(state.rounds, state.rest), state.noise
        problem.faint = np.zeros(problem.size)

    def _pass(self, old: SearchState) -> SearchState:
        """Return where one pass comes to."""
        problem, last = self.problem, old.horizon == WHOLE
        # The first start is refined at once: mostly it is near the only minimum.
        is_fine = old.refined or (last and old.start == 0)
        tolerance = problem.fit_problem.tolerance if is_fine else LOOSE
        self.enter(old)
        before = self.optimiser.error_at(old.theta)
        if not np.isfinite(before):
            return self._failed(replace(old, passes=old.passes + 1))
        if not last:
            problem.faint = problem.rms(old.theta) / problem.reaches
            before = problem.error(old.theta)
        reached = self.optimiser.improved(old.theta, before, tolerance, WIDE if last else NEAR)
        theta, error = reached.theta, reached.error
        new = replace(old, theta=theta, passes=old.passes + 1, error=error, tries=old.tries + 1)
        calm = (
            reached.is_final
            or before - error <= tolerance * before
            or error <= PERFECT * len(problem.data)
        )
        if new.passes >= problem.fit_problem.passes and not (calm and last):
            return self._ended(new)
        if not last:
            over = calm or new.tries == (TRIES if old.start <= 1 else 1)
            return replace(new, horizon=old.horizon + 1, tries=0) if over else new
        if not old.refined and (calm or new.tries == TRIES):
            new = self._next_start(new)
        is_best = new.refined and np.array_equal(new.theta, theta)
        return self._finished(new) if calm and is_fine and is_best else new

    def _finished(self, old: SearchState) -> SearchState:
        """Return the end of a search; the same with other noise where that changes a result."""
        if self._measures_noise(old):
            new = self._weighed(old)
            if self._differ(old, new):
                return new
        return replace(old, reason="the error no longer decreases", converged=True)

    # --- starts -------------------------------------------------------------------------------

    def _next_start(self, old: SearchState) -> SearchState:
        """Return the next start, or the best minimum to be refined where no more is needed."""
        again = old.start > 0 and self._is_same(old)
        if old.error < old.best_error:
            old = replace(old, best=old.theta, best_error=old.error)
        # Two ways from one place may miss the same periods; then little is explained.
        is_sure = again and (old.start > 1 or self._explains(old.best))
        if is_sure or self.optimiser.is_blind or self._is_good(old.best):
            return self._refined(old)
        start = old.start + 1
        if start == 1:
            theta = np.clip(np.zeros(self.problem.size), *self.bounds)
            horizon, whole = self.horizons.begun(theta)
            horizon, theta = (
                self.horizons.growing(theta) if horizon == WHOLE else (WHOLE, whole)
            )
            if not self.horizons.is_still:
                return replace(old, theta=theta, horizon=horizon, start=start, tries=0)
            start = 2
        if start == 2 and self.sample is not None:
            old = replace(old, sample=self.sample())
        is_late = old.passes > SEARCHING * self.problem.fit_problem.passes
        if start > len(old.sample) + 1 or is_late:
            return self._refined(old)
        horizon, theta = self.horizons.begun(np.clip(old.sample[start - 2], *self.bounds))
        return replace(old, theta=theta, horizon=horizon, start=start, tries=0)

    def _is_same(self, old: SearchState) -> bool:
        """Return whether a start came to the best minimum so far.

        Parameters that predictions do not depend on may differ.
        """
        if not abs(old.error - old.best_error) <= SAME_ERROR * old.best_error:
            return False
        if np.abs(old.theta - old.best).max(initial=0.0) <= SAME_PLACE:
            return True
        problem, left = self.problem, list[Floats]()
        limit(problem, WHOLE)
        try:
            for theta in (old.theta, old.best):
                problem.freeze(theta)
                left.append(problem.scale * problem.left(theta))
        except (Diverged, TissueError):
            return False
        apart = np.square(left[0] - left[1]).sum()
        return bool(apart <= SAME_PLACE**2 * np.square(left[1]).sum())

    def _refined(self, old: SearchState) -> SearchState:
        """Return the best minimum, to be refined."""
        theta, error = old.best, old.best_error
        return replace(old, theta=theta, error=error, horizon=WHOLE, refined=True, tries=0)

    def _failed(self, old: SearchState) -> SearchState:
        """Return the step after a motion without numbers: the next start, if there is one."""
        if old.refined:
            return replace(old, reason="the motion is not finite")
        return self._next_start(replace(old, error=np.inf))

    def _explains(self, theta: Floats) -> bool:
        """Return whether parameters explain most of the data on the whole horizon."""
        limit(self.problem, WHOLE)
        try:
            self.problem.freeze(theta)
            return self.problem.relative(theta) < FITTING
        except (Diverged, TissueError):
            return False

    def _is_good(self, theta: Floats) -> bool:
        """Return whether what is left on the whole horizon may well be noise."""
        problem = self.problem
        limit(problem, WHOLE)
        try:
            problem.freeze(theta)
            if problem.relative(theta) < FAR:
                return True
            if problem.noise_is_given:
                return problem.rms(theta) < MET
            found = residual_structure(problem, problem.left(theta))
        except (Diverged, TissueError):
            return False
        return found.size < FAR or (found.size < FITTING and not found.is_significant)

    def _ended(self, state: SearchState) -> SearchState:
        """Return the end of a search whose passes are over, at the best that it found."""
        state = replace(state, reason=f"stopped after {counted(state.passes, 'pass')}")
        if state.refined:
            return state
        whole = replace(state, horizon=WHOLE)
        self.enter(whole)
        error = self.optimiser.error_at(state.theta)
        if error < state.best_error:
            return replace(whole, error=error)
        return replace(whole, theta=state.best, error=state.best_error)

    def _trust(self, rounds: int, rest: float) -> float:
        """Return the factor of what was expected, after so many estimates of the noise.

        Where errors count as they are, what was expected counts in units of what is left.
        """
        if not (self.problem.noise_is_given or rounds):
            return 0.0
        return 1.0 if self.problem.fit_problem.scaled else rest

    def _measures_noise(self, state: SearchState) -> bool:
        """Return whether residuals are to be weighed anew by what was left of each fit."""
        problem = self.problem
        matters = len(problem.fit_problem.fits) > 1 or bool(problem.priors)
        return not problem.noise_is_given and matters and state.rounds < LOOKS

    def _differ(self, old: SearchState, new: SearchState) -> bool:
        """Return whether other noise may give other parameters."""
        if not old.rounds and self.problem.priors:
            return True  # expected values count from now on
        if not self.problem.fit_problem.scaled:
            return abs(new.rest - old.rest) > SAME_NOISE * old.rest
        change = np.log(new.noise / old.noise)
        if not self.problem.priors:
            change -= change.mean()  # of fits, only the ratio counts
        return bool(np.abs(change).max(initial=0.0) > SAME_NOISE)

    def _weighed(self, old: SearchState) -> SearchState:
        """Return the same with the noise that was left, or at least that of rounding."""
        problem, left = self.problem, self.problem.left(old.theta)
        rest = float(np.sqrt(np.mean(left**2)))
        new = replace(old, rounds=old.rounds + 1, rest=rest)
        if not problem.fit_problem.scaled:
            return new
        found = problem.noise.copy()
        for k, fit in enumerate(problem.fit_problem.fits):
            mine = left[problem.fits == k]
            if fit.noise is None and len(mine):
                found[k] = max(float(np.sqrt(np.mean(mine**2))), 1e-9 * problem.spread[k])
        return replace(new, noise=found)


_MARK = b"PK\x03\x04"  # of files that numpy.savez writes


def key_of(session: LearnSession, request: Request, texts: Sequence[str]) -> str:
    """Return a digest of everything the result depends on: texts, settings, data, versions.

    Args:
        texts: All texts of the scene.
    """
    digest = hashlib.sha256()
    trials = (*session.learning, *session.held_out)
    parts = (
        *texts,
        *request.overrides,
        session.fit_problem.name,
        *(trial.experiment.digest for trial in trials),
        *(f"{name} {version}" for name, version in sorted(versions().items())),
    )
    for part in parts:
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()


class KeptSearch:
    """The file with the state of a search, which no other learning writes meanwhile.

    Args:
        path: The file.
        key: Digest of ``key_of``.

    Attributes:
        before: The stored state of a search of the same learning; None without one.
        note: Why it is None although there is a state, as a sentence; else empty.

    Raises:
        PlaceError: Another learning writes the file, it is not a state, or cannot be written.
    """

    def __init__(self, path: Path, key: str):
        self._key, self.before, self.note = key, None, ""
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = OutputFile(final_place(path), "append")
        except BlockingIOError as error:
            raise PlaceError(
                f'cannot write "{path}": another learning is writing it; wait for its end, or '
                "give another preset with -o"
            ) from error
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise PlaceError(f'cannot write "{path}": {reason}') from error
        content = self._file.readall()
        if content and not content.startswith(_MARK):
            self._file.close()
            raise PlaceError(
                f'cannot write "{path}": it exists and is not the state of a learning; remove '
                "it, or give another preset with -o"
            )
        if content:
            self._read(content, path)

    def _read(self, content: bytes, path: Path) -> None:
        try:
            with np.load(BytesIO(content), allow_pickle=False) as file:
                if str(file["key"]) == self._key:
                    names = SearchState.__struct_fields__
                    self.before = SearchState(**{name: _value(file[name]) for name in names})
        except Exception:  # damaged files raise what they like
            self.note = f'"{path}" is damaged, so learning has begun again'

    def keep(self, state: SearchState) -> None:
        """Write the state of the search; the file is complete at any moment.

        Raises:
            OSError: It cannot be written.
        """
        content = BytesIO()
        np.savez(content, key=self._key, **asdict(state))
        self._file = self._file.replaced(content.getvalue())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self._file.release()


def _value(array: np.ndarray) -> Any:
    """Return a plain value as such, and not as an array without axes."""
    return array if array.ndim else array.item()
