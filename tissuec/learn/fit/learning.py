"""The whole of learning on one page: data -> search -> identifiability -> result."""

import time as clock
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.compiler.compile import Compiled
from tissuec.core.errors import TissueError
from tissuec.core.units import TIME, show
from tissuec.learn.derivatives.dynamic_model import DynamicModel
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.bootstrap import MOST_FAILED, Resampled, intervals
from tissuec.learn.fit.checkpoint import keep, kept, key_of
from tissuec.learn.fit.evaluations import Evaluator, LostWorkersError
from tissuec.learn.fit.identifiability import SHOWN, Identifiability, judge
from tissuec.learn.fit.misfit import misfit, remark, too_coarse, units
from tissuec.learn.fit.outcome import Estimates, Fitted, Learnt
from tissuec.learn.fit.problem import FittedExperiment, Problem
from tissuec.learn.fit.rule_revision import CandidateScene, revised, with_texts
from tissuec.learn.fit.search import HORIZONS, LEAST_SQUARES, Search, SearchState
from tissuec.learn.fit.session import LearnSession, prepare
from tissuec.learn.fit.starts import sample
from tissuec.model.network import Floats
from tissuec.scene.request import Request
from tissuec.script.fit_problem import FitProblem
from tissuec.workers.workers import OwnProcess, Workers

STEPS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)  # of differences, in parameters
AGREED = 1e-9  # of a derivative: differences with two steps that agree so well are believed
SAMPLED = (0.25, 1.0)  # parts of the data on which random starts are judged
NEAR_LIMIT = 1e-3  # of a parameter: the search stays that far inside


class Unlearnable(TissueError):
    """There is nothing to learn from: no motion, or none that depends on what may change."""


class LearnProgress(NamedTuple):
    """Progress of a learning.

    Attributes:
        passes, most: How many passes are over, and how many there may be.
        horizon: Part of the data in use, from 0 to 1.
        error, first: The error function now, and at the beginning of this horizon.
        held_out: Relative error of what was held out; None without any.
        seconds: Since the beginning.
        fits: How many fits to resampled residuals are over, once the search is.
    """

    passes: int
    most: int
    horizon: float
    error: float
    first: float
    held_out: float | None
    seconds: float
    fits: int | None = None


Tell = Callable[[LearnProgress], None]


def learn(
    compiled: Compiled,
    fit_problem: FitProblem,
    request: Request,
    *,
    state: Path | None = None,
    fresh: bool = False,
    progress: Tell | None = None,
    workers: Workers | None = None,
) -> Learnt:
    """Carry out a ``learn`` block.

    Args:
        compiled: The scene with the block.
        request: What it was compiled from.
        state: Where each pass is kept; a learning that was interrupted goes on from there.
        fresh: Whether it begins anew all the same.
        progress: Told after each pass, and after each fit to resampled residuals.
        workers: Who compares starts, runs the scene for differences, and fits resampled
            residuals, where that takes long; entered already. By default it is done here.

    Raises:
        CompileError: Data is wrong.
        Unlearnable: The first prediction has no numbers.
        TissueError: Workers cannot be reached, or die.
    """
    began = clock.monotonic()
    scene = CandidateScene(compiled, fit_problem, request)
    texts, sentences = dict[str, str](), tuple[str, ...]()
    if fit_problem.revise:
        changed = revised(scene)
        texts, sentences = dict(changed.texts), changed.sentences
        scene = with_texts(scene, texts) if texts else scene
    fitting = _Fitting.of(scene, workers, progress, began)
    session = fitting.session
    with _told():
        problem, end, search = fitting.fitted(state, fresh=fresh)
        resampled = fitting.resampled(end)
        found = _assessed(session, problem, end.theta)
    sureness = found.sureness
    if session.words is not None:
        moving = end.theta[session.shaping.own : session.shaping.size]
        texts |= session.words.texts(moving)
        sentences += tuple(one.sentence for one in session.words.drift(moving))
    fit_problem = session.fit_problem
    return Learnt(
        fit_problem=fit_problem,
        estimates=tuple(_estimates(session, end.theta, sureness, resampled)),
        zeros={fit_problem.fits[k].text: problem.zero(end.theta, k) for k in problem.zeroed},
        error=found.error,
        first_error=found.first_error,
        fitted=found.fitted,
        noise={
            fit.text: float(s) for fit, s in zip(fit_problem.fits, sureness.noise, strict=True)
        },
        singular=sureness.singular,
        blind=sureness.blind,
        method=_method(session, search),
        stepping=found.stepping,
        stepping_error=found.stepping_error,
        passes=end.passes,
        evaluations=end.evaluations,
        reason=end.reason,
        converged=end.converged,
        failure=found.failure,
        wall_time=clock.monotonic() - began,
        notes=(
            *(units(problem) if found.failure or sureness.blind else ()),
            *filter(None, [found.structure, _of_intervals(session, resampled)]),
            *_notes(session, end.theta, found.stepping_error),
            *sentences,
        ),
        words=texts,
    )


@contextmanager
def _told() -> Generator[None]:
    """Raise what people are told of in the block."""
    try:
        yield
    except Diverged as failure:
        raise Unlearnable(str(failure)) from failure
    except LostWorkersError as lost:
        raise TissueError(f"{lost}; --workers 1 does without them") from lost


class _Assessed(NamedTuple):
    """What is found of the parameters that a search ended with; see ``Learnt``."""

    first_error: float
    error: float
    fitted: tuple[Fitted, ...]
    sureness: Identifiability
    stepping: str
    stepping_error: float
    failure: str
    structure: str


def _assessed(session: LearnSession, problem: Problem, theta: Floats) -> _Assessed:
    singles = [session.judged([trial], problem) for trial in session.learning]
    errors = [trial.model.step_error(theta[: problem.own]) for trial in problem.trials]
    stepping, stepping_error = _stepping(problem, theta, errors)
    step_error = np.concatenate([np.zeros(0), *errors])
    return _Assessed(
        first_error=_first_error(problem),
        error=problem.error_at(theta),
        fitted=tuple(_fitted(session, problem, theta)),
        sureness=judge(problem, theta, *_names(session, problem), step_error),
        stepping=stepping,
        stepping_error=stepping_error,
        failure=too_coarse(stepping_error) or misfit(problem, theta, singles),
        structure=remark(problem, theta),
    )


class _Found(NamedTuple):
    """A search that is over."""

    problem: Problem
    end: SearchState
    search: Search


class _Fitting(NamedTuple):
    """The search of a learning, and what comes after it; see ``learn``."""

    scene: CandidateScene
    session: LearnSession
    evaluator: Evaluator
    progress: Tell | None
    began: float

    @classmethod
    def of(
        cls, scene: CandidateScene, workers: Workers | None, progress: Tell | None, began: float
    ) -> Self:
        """Return a learning that is prepared."""
        session = prepare(*scene)
        evaluator = Evaluator(scene, session, workers or OwnProcess())
        return cls(scene, session, evaluator, progress, began)

    def fitted(self, state: Path | None, *, fresh: bool) -> _Found:
        """Fit the parameters of the scene, or go on with that."""
        session, problem = self.session, self.session.problem
        compiled, _, request = self.scene
        judges = session.judged(session.held_out, problem) if session.held_out else None
        texts = [request.source.text, *(s.text for s in compiled.scene.imports)]
        key = key_of(session, request, texts)
        firsts: dict[tuple[int, int], float] = {}

        def passed(now: SearchState) -> None:
            if state is not None:
                keep(state, key, now)
            if self.progress is not None:
                first = firsts.setdefault((now.horizon, now.rounds), now.error)
                held_out = None if judges is None else _relative(judges, now.theta)
                self.progress(self._standing(now, first, held_out))

        bounds = session.bounds(problem)
        search = Search(
            problem,
            bounds,
            passed,
            lambda: sample(problem, session.shaping, bounds, SAMPLED, self.evaluator),
        )
        before = None if fresh or state is None else kept(state, key)
        return _Found(problem, search.go(before or search.begin()), search)

    def resampled(self, end: SearchState) -> Resampled | None:
        """Return the intervals by bootstrap; None if none are wanted, or fits fail."""
        fits = self.session.fit_problem.bootstrap
        if fits is None or not len(end.theta):
            return None

        def done(count: int) -> None:
            if self.progress is not None:
                self.progress(self._standing(end, 0.0, None)._replace(fits=count))

        return intervals(self.evaluator, end, fits, done)

    def _standing(
        self, now: SearchState, first: float, held_out: float | None
    ) -> LearnProgress:
        most, part = self.session.fit_problem.passes, HORIZONS[now.horizon]
        seconds = clock.monotonic() - self.began
        return LearnProgress(now.passes, most, part, now.error, first, held_out, seconds)


def _of_intervals(session: LearnSession, resampled: Resampled | None) -> str:
    """Return what the intervals are from, if not from derivatives; empty otherwise."""
    fits = session.fit_problem.bootstrap
    if fits is None:
        return ""
    if resampled is not None:
        return f"intervals: {resampled.sentence}"
    return (
        f"more than {MOST_FAILED:.0%} of {fits} fits to resampled residuals failed: the "
        "intervals are from derivatives"
    )


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


MOVED = 1e-3  # by which words move in a rehearsal


def rehearsal(compiled: Compiled, fit_problem: FitProblem, request: Request) -> Learnt:
    """Return the result of a learning that moves words slightly and changes no number.

    With it, what can be written is known before anything is learnt.

    Raises:
        CompileError: Data is wrong.
    """
    session = prepare(compiled, fit_problem, request)
    shaping, problem = session.shaping, session.problem
    theta, many = np.zeros(problem.size), len(fit_problem.fits)
    told = np.ones(problem.size, dtype=bool)
    sureness = Identifiability(theta, theta, theta, told, (), np.zeros(many))
    words = session.words
    return Learnt(
        fit_problem=replace(fit_problem, demands=()),
        estimates=tuple(_estimates(session, theta, sureness, None)),
        zeros={},
        error=0.0,
        first_error=0.0,
        fitted=(),
        noise={},
        singular=theta,
        blind=(),
        method="",
        stepping="",
        stepping_error=0.0,
        passes=0,
        evaluations=0,
        reason="",
        converged=True,
        wall_time=0.0,
        words={} if words is None else words.texts(np.full(shaping.size - shaping.own, MOVED)),
    )


def _names(session: LearnSession, problem: Problem) -> tuple[list[str], list[str]]:
    """Return the names of all parameters, and of what kind they are."""
    shaping = session.shaping
    zeros = [f"zero of {session.fit_problem.fits[k].text}" for k in problem.zeroed]
    kinds = [block.adjust.what for block in shaping.blocks for _ in block.names]
    others = problem.size - len(kinds)
    return [*shaping.names, *zeros], kinds + [""] * others


def _estimates(
    session: LearnSession,
    theta: Floats,
    sureness: Identifiability,
    resampled: Resampled | None,
) -> Iterator[Estimates]:
    lows, highs = theta - sureness.away, theta + sureness.away
    if resampled is not None:  # of what no derivative tells, no resample does
        lows, highs = np.where(sureness.identified, resampled[:2], (lows, highs))
    for number, block in enumerate(session.shaping.blocks):
        part = session.shaping.place(number)
        here, known = theta[part], sureness.identified[part]
        with np.errstate(over="ignore"):
            low, high = block.value(lows[part]), block.value(highs[part])
        yield Estimates(
            adjust=block.adjust,
            names=block.names,
            start=block.start,
            value=block.value(here),
            low=low,
            high=high,
            identified=known,
            parts=block.parts,
        )


def _first_error(problem: Problem) -> float:
    """Return the error function at the beginning; infinite where the motion is not finite."""
    try:
        return problem.error_at(np.zeros(problem.size))
    except Diverged:
        return np.inf


def _relative(problem: Problem, theta: Floats) -> float:
    """Return what is left of a problem over how far its data deviates from its mean.

    Infinite where the motion is not finite: it is held-out data that is not met, then.
    """
    try:
        problem.freeze(theta)
        return problem.relative(theta)
    except Diverged:
        return np.inf


def _fitted(session: LearnSession, like: Problem, theta: Floats) -> Iterator[Fitted]:
    both: Sequence[tuple[FittedExperiment, bool]] = [
        *((trial, False) for trial in session.learning),
        *((trial, True) for trial in session.held_out),
    ]
    for trial, held_out in both:
        problem = session.judged([trial], like)
        error = _relative(problem, theta)
        left = problem.left(theta) if np.isfinite(error) else np.full(len(problem.fits), np.inf)
        fits = session.fit_problem.fits
        rest: dict[str, float] = {
            fits[int(k)].text: float(np.sqrt(np.mean(np.square(left[problem.fits == k]))))
            for k in np.unique(problem.fits).tolist()
        }
        experiment = trial.experiment
        yield Fitted(experiment.name, held_out, len(left), error, rest, experiment.digest)


def _stepping(problem: Problem, theta: Floats, errors: Sequence[Floats]) -> tuple[str, float]:
    """Return how motions were stepped, and the largest error as a part of what was measured.

    Args:
        errors: Of the steps, of the predictions of each experiment, shape (number,).
    """
    found, worst = "", 0.0
    for trial, apart in zip(problem.trials, errors, strict=True):
        model = trial.model
        if not isinstance(model, DynamicModel):
            continue
        step = f"{model.motion.steps} steps of at most {show(model.motion.longest, TIME)}"
        found, predicted = f"{model.stepping.name}, {step}", model.predict(theta[: problem.own])
        for one, slot in zip(model.series, model.slots, strict=True):
            mine = slice(slot.start, slot.start + slot.rows * slot.width)
            seen = one.values[np.isfinite(one.values)]
            # Each in its own unit; what hardly moves is held against what was measured.
            both = [values for values in (predicted[mine], seen) if len(values)]
            span = max((float(np.ptp(v)) or float(np.abs(v).max()) for v in both), default=0.0)
            worst = max(worst, float(np.abs(apart[mine]).max(initial=0.0)) / (span or 1.0))
    return found, worst


def _method(session: LearnSession, search: Search) -> str:
    names = dict.fromkeys(trial.model.name for trial in session.learning)
    way = "forwards" if search.method == LEAST_SQUARES else "backwards"
    derivatives = ", ".join(names)
    if any(isinstance(trial.model, DynamicModel) for trial in session.learning):
        derivatives += f", {way}"
    return f"{search.method}, {derivatives}"


def _notes(session: LearnSession, theta: Floats, stepping_error: float) -> Iterator[str]:
    """Yield what else is to be known."""
    shaping = session.shaping
    low, high = shaping.bounds()
    own = theta[: shaping.size]
    at_limit = (own <= low + NEAR_LIMIT) | (own >= high - NEAR_LIMIT)
    if at_limit.any():
        names = _first_few(shaping.names, at_limit)
        yield f"at a limit, which the interval ignores: {names}"
    outside = (low > 0.0) | (high < 0.0)
    if outside.any():
        names = _first_few(shaping.names, outside)
        yield f"outside its limits, so the fit starts at the nearer limit: {names}"
    if stepping_error > 1e-4 and not too_coarse(stepping_error):
        yield (
            f"halving the step changes predictions by {stepping_error:.1g} of their range: "
            "write a smaller step"
        )
    for trial in (*session.learning, *session.held_out):
        yield from getattr(trial.model, "notes", ())


def _first_few(names: Sequence[str], chosen: NDArray[np.bool_]) -> str:
    """Return the first of some names, and how many more there are."""
    found = [names[k] for k in np.flatnonzero(chosen).tolist()]
    more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return ", ".join(found[:SHOWN]) + more
