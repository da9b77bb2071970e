"""The whole of learning on one page: data -> search -> identifiability -> result.

Additional starts of a search are the best of a random sample of all parameters. Parameters of
one ``adjust`` entry move together; each word of a vocabulary moves by itself.
"""

import time as clock
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tissuec.compiler.compile import Compiled
from tissuec.core.errors import TissueError
from tissuec.core.structs import replace
from tissuec.core.workers.workers import OwnProcess, Workers
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.assessment import assess, estimates, relative_error
from tissuec.learn.fit.bootstrap import Resampled, intervals
from tissuec.learn.fit.evaluations import Evaluator, LostWorkersError, StartError
from tissuec.learn.fit.identifiability import Identifiability
from tissuec.learn.fit.noise import NoiseDraws
from tissuec.learn.fit.optimiser import HORIZONS
from tissuec.learn.fit.outcome import Learnt
from tissuec.learn.fit.problem import Problem
from tissuec.learn.fit.rule_revision import CandidateScene, revised, with_texts
from tissuec.learn.fit.search import KeptSearch, Search, SearchState, key_of
from tissuec.learn.fit.session import LearnSession, prepare
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.model.network import Floats
from tissuec.scene.request import Request
from tissuec.script.fit_problem import FitProblem

SAMPLED = (0.25, 1.0)  # parts of the data on which random starts are judged


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
        fits: How many fits to simulated data are over, once the search is.
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
    session: LearnSession | None = None,
    state: Path | None = None,
    fresh: bool = False,
    progress: Tell | None = None,
    workers: Workers | None = None,
) -> Learnt:
    """Carry out a ``learn`` block.

    Args:
        compiled: The scene with the block.
        request: What it was compiled from.
        session: Prepared from these, so that data is not read again.
        state: Where each pass is kept; an interrupted learning continues from there.
        fresh: Whether it begins anew all the same.
        progress: Called after each pass, and after each fit to resampled residuals.
        workers: Who compares starts, runs the scene for differences, and fits resampled
            residuals, where that takes long; entered already. By default it is done here.

    Raises:
        CompileError: Data is wrong.
        PlaceError: ``state`` cannot be written, or another learning is writing it.
        Unlearnable: The first prediction has no numbers.
        TissueError: Workers cannot be reached, or die.
    """
    began = clock.monotonic()
    scene = CandidateScene(compiled, fit_problem, request)
    session = session or prepare(*scene)
    texts, sentences = dict[str, str](), tuple[str, ...]()
    if fit_problem.revise:
        changed = revised(scene, session)
        texts, sentences = dict(changed.texts), changed.sentences
        if texts:
            scene = with_texts(scene, texts)
            session = prepare(*scene, session.experiments)
    evaluator = Evaluator(scene, session, workers or OwnProcess())
    fitting = _Fitting(scene, session, evaluator, progress, began)
    with _told():
        problem, end, search, note = fitting.fitted(state, fresh=fresh)
        resample = partial(fitting.resampled, end)
        learnt = assess(fitting.session, problem, search, end, resample)
    words, shaping = fitting.session.words, fitting.session.shaping
    if words is not None:
        moving = end.theta[shaping.own : shaping.size]
        texts |= words.texts(moving)
        sentences += tuple(one.sentence for one in words.drift(moving))
    return replace(
        learnt,
        wall_time=clock.monotonic() - began,
        notes=(*([note] if note else []), *learnt.notes, *sentences),
        words=texts,
    )


@contextmanager
def _told() -> Generator[None]:
    """Raise the errors of the block."""
    try:
        yield
    except Diverged as failure:
        raise Unlearnable(str(failure)) from failure
    except LostWorkersError as lost:
        raise TissueError(f"{lost}; --workers 1 does without them") from lost


class _Found(NamedTuple):
    """A search that is over."""

    problem: Problem
    end: SearchState
    search: Search
    note: str


class _Fitting(NamedTuple):
    """The search of a learning, and what comes after it; see ``learn``."""

    scene: CandidateScene
    session: LearnSession
    evaluator: Evaluator
    progress: Tell | None
    began: float

    def fitted(self, state: Path | None, *, fresh: bool) -> _Found:
        """Fit the parameters of the scene, or continue to do so.

        Raises:
            PlaceError: The state cannot be kept there.
        """
        session, problem = self.session, self.session.problem
        compiled, _, request = self.scene
        judges = session.judged(session.held_out, problem) if session.held_out else None
        texts = [request.source.text, *(s.text for s in compiled.scene.imports)]
        key = key_of(session, request, texts)
        file = nullcontext() if state is None else KeptSearch(state, key)
        firsts: dict[tuple[int, int], float] = {}

        def passed(now: SearchState) -> None:
            if kept is not None:
                kept.keep(now)
            if self.progress is not None:
                first = firsts.setdefault((now.horizon, now.rounds), now.error)
                held_out = None if judges is None else relative_error(judges, now.theta)
                self.progress(self._standing(now, first, held_out))

        bounds = session.bounds(problem)
        search = Search(
            problem,
            bounds,
            passed,
            lambda: sample(problem, session.shaping, bounds, SAMPLED, self.evaluator),
        )
        with file as kept:
            before, note = None, ""
            if kept is not None and not fresh:
                before, note = kept.before, kept.note
            return _Found(problem, search.go(before or search.begin()), search, note)

    def resampled(self, end: SearchState, draws: Sequence[NoiseDraws]) -> Resampled | None:
        """Return the intervals by bootstrap; None if none are wanted, or fits fail."""
        fits = self.session.fit_problem.bootstrap
        if fits is None or not len(end.theta):
            return None

        def done(count: int) -> None:
            if self.progress is not None:
                self.progress(self._standing(end, 0.0, None)._replace(fits=count))

        return intervals(self.evaluator, end, draws, fits, done)

    def _standing(
        self, now: SearchState, first: float, held_out: float | None
    ) -> LearnProgress:
        most, part = self.session.fit_problem.passes, HORIZONS[now.horizon]
        seconds = clock.monotonic() - self.began
        return LearnProgress(now.passes, most, part, now.error, first, held_out, seconds)


MOVED = 1e-3  # by which words move in a rehearsal


def rehearsal(session: LearnSession) -> Learnt:
    """Return the result of a learning that moves words slightly and changes no number.

    With it, what can be written is known before anything is learnt.
    """
    fit_problem = session.fit_problem
    shaping, problem = session.shaping, session.problem
    theta, many = np.zeros(problem.size), len(fit_problem.fits)
    told = np.ones(problem.size, dtype=bool)
    sureness = Identifiability(theta, theta, told, (), np.zeros(many))
    words = session.words
    return Learnt(
        fit_problem=replace(fit_problem, demands=()),
        estimates=tuple(estimates(session, theta, sureness)),
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


SIZE, AT_REST = 48, 12  # of the sample; at rest, there are no periods to be missed
BEST = 2  # that are taken for each part of the data
FARTHEST = 1.15  # reaches: of logarithms, a factor of 10


def sample(
    problem: Problem,
    shaping: Parametrisation,
    bounds: tuple[Floats, Floats],
    parts: tuple[float, ...],
    evaluator: Evaluator,
) -> Floats:
    """Return the starts with the best predictions, dimensionless, shape (start, parameter).

    Args:
        problem: What is to be solved.
        shaping: Its parameters.
        bounds: Their least and greatest values, shape (parameter,).
        parts: Parts of the data, from its beginning, on which predictions are compared.
        evaluator: Computes the predictions.

    Raises:
        LostWorkersError: A worker died of a prediction.
    """
    random = np.random.default_rng(problem.fit_problem.seed)
    groups = np.append(shaping.groups, np.full(problem.size - shaping.size, -1))
    size = SIZE if problem.fit_problem.axis.nodes is None else AT_REST
    drawn = random.uniform(-FARTHEST, FARTHEST, (size, shaping.groups.max(initial=0) + 2))
    drawn[:, -1] = 0.0  # zeros, whose group is -1
    reaches = np.where(np.isfinite(problem.reaches), problem.reaches, 0.0)
    points = np.clip(drawn[:, groups] * reaches, *bounds)
    chosen: list[int] = []
    every = evaluator.all([StartError(point, part) for point in points for part in parts])
    if any(error is None for error in every):
        raise LostWorkersError("workers died while they compared starts")
    problem.evaluations += 2 * len(every)
    for errors in np.array(every, dtype=float).reshape(-1, len(parts)).T:
        order = [
            k for k in np.argsort(errors, kind="stable").tolist() if np.isfinite(errors[k])
        ]
        chosen += [k for k in order if k not in chosen][:BEST]
    return points[chosen]
