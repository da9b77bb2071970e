"""The inputs of a learning: experiments, compiled scenes and models."""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from msgspec import Struct

from tissuec.compiler.compile import Compiled
from tissuec.core.errors import CompileError, Diagnostic, TissueError
from tissuec.engine.integrators import INTEGRATORS
from tissuec.learn.derivatives.dynamic_model import DynamicModel
from tissuec.learn.derivatives.methods import choose
from tissuec.learn.derivatives.model import Model
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.derivatives.observables import look_of
from tissuec.learn.derivatives.refusals import refusal
from tissuec.learn.fit.problem import FittedExperiment, Problem
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.learn.vocabulary.moving import WordsModel
from tissuec.measurements.experiment import Experiment
from tissuec.measurements.reading import check_times, read_experiment, too_few
from tissuec.model.network import Floats
from tissuec.pipeline import set_for
from tissuec.scene.request import Request
from tissuec.script.fit_problem import WORDS, Data, FitProblem


class LearnSession(Struct, frozen=True, eq=False):
    """A learning, ready to begin.

    Attributes:
        shaping: Of the scene as it is written.
        words: Whose words move; None if none do.
        learning, held_out: Experiments that are learnt from, and those that judge.
        experiments: All of them as they were read, in the order of the data.
    """

    fit_problem: FitProblem
    shaping: Parametrisation
    words: WordsModel | None
    learning: tuple[FittedExperiment, ...]
    held_out: tuple[FittedExperiment, ...]
    experiments: tuple[Experiment, ...]

    @property
    def problem(self) -> Problem:
        """Return the problem of the experiments that are learnt from."""
        shaping = self.shaping
        return Problem(
            self.fit_problem,
            self.learning,
            shaping.size,
            shaping.priors(),
            reaches=shaping.reaches,
        )

    def judged(self, trials: Sequence[FittedExperiment], like: Problem) -> Problem:
        """Return a problem of other experiments, with the zeros of one."""
        return Problem(self.fit_problem, trials, self.shaping.size, zeros=like.unit_of_zero)

    def bounds(self, problem: Problem) -> tuple[Floats, Floats]:
        """Return the smallest and the largest parameters, dimensionless.

        Both have the shape (parameter,).
        """
        low, high = self.shaping.bounds()
        free = np.full(problem.size - self.shaping.size, np.inf)
        return np.concatenate([low, -free]), np.concatenate([high, free])


def prepare(
    compiled: Compiled,
    fit_problem: FitProblem,
    request: Request,
    experiments: Sequence[Experiment] | None = None,
) -> LearnSession:
    """Return a learning with its data read.

    Args:
        compiled: The scene.
        fit_problem: One of its learn blocks.
        request: What the scene was compiled from.
        experiments: Those of a session of the same block and mesh; without, files are read.

    Raises:
        CompileError: Data is wrong, or the scene is, as an experiment has it.
    """
    session = _prepared(compiled, fit_problem, request, {}, experiments)
    _check_size(session)
    scales = _scales(session)
    if not scales:
        return session
    return _prepared(compiled, fit_problem, request, scales, session.experiments)


def _prepared(
    compiled: Compiled,
    fit_problem: FitProblem,
    request: Request,
    scales: Mapping[int, float],
    experiments: Sequence[Experiment] | None,
) -> LearnSession:
    words = _words(compiled, fit_problem)
    shaping = Parametrisation(compiled, fit_problem, words, scales)
    learning: list[FittedExperiment] = []
    held: list[FittedExperiment] = []
    found: list[Experiment] = []
    for number, data in enumerate(fit_problem.data):
        mine = _of_data(compiled, fit_problem, data, request, scales)
        if experiments is None:
            experiment = read_experiment(data, mine.fit_problem, mine.compiled.network)
            check_times(experiment, mine.compiled.plan.simulation.duration)
        else:
            experiment = experiments[number].of(data, mine.fit_problem.fits)
        found.append(experiment)
        if data.held_out:
            held.append(FittedExperiment(experiment, mine.model(experiment)))
            continue
        experiment, last = experiment.split(fit_problem.last_part)
        if any(len(one.times) for one in last.series):  # a single row is not parted
            held.append(FittedExperiment(last, mine.model(last)))
        learning.append(FittedExperiment(experiment, mine.model(experiment)))
    return LearnSession(fit_problem, shaping, words, tuple(learning), tuple(held), tuple(found))


def _check_size(session: LearnSession) -> None:
    """Refuse fewer measurements and expected values than parameters.

    Raises:
        CompileError: There are fewer.
    """
    problem = session.problem
    many = int(np.isfinite(problem.data).sum())
    if many + len(problem.priors) < problem.size:
        names = [trial.experiment.name for trial in session.learning]
        raise CompileError([too_few(names, many, problem.size, session.fit_problem)])


def _scales(session: LearnSession) -> dict[int, float]:
    """Return scales of constants, by their blocks, that say more than where they start.

    A constant that starts at 0 says nothing of how large it may be: its scale is what changes
    predictions as much as the data deviates from its mean.
    """
    blocks = session.shaping.blocks
    chosen = {
        k: one.scale
        for k, one in enumerate(blocks)
        if one.is_difference and one.scale is not None
    }
    if not chosen:
        return {}
    problem, found = session.problem, dict[int, float]()
    theta = np.clip(np.zeros(problem.size), *session.bounds(problem))
    try:
        problem.freeze(theta)
        influence = problem.influence(theta)
    except (Diverged, TissueError):
        return {}
    for k, scale in chosen.items():
        most = float(influence[session.shaping.place(k)].max(initial=0.0))
        if np.isfinite(most) and 0.0 < most < 1.0:
            found[k] = scale / most
    return found


class _ExperimentScene(Struct, frozen=True, eq=False):
    """A scene as one experiment has it."""

    compiled: Compiled
    fit_problem: FitProblem
    shaping: Parametrisation

    def model(self, experiment: Experiment) -> Model:
        """Return the model of an experiment."""
        series, plan = experiment.series, self.shaping.compiled.plan
        fit_problem, shaping = self.fit_problem, self.shaping
        looks = [look_of(one.fit, one.nodes) for one in series]
        known = tuple(look for look in looks if look is not None)
        axis = fit_problem.axis if fit_problem.axis.nodes is not None else None
        reason = refusal(shaping, at_rest=axis is not None)
        if len(known) < len(looks) or reason or (plan.simulation.is_static and axis is None):
            from tissuec.learn.derivatives.finite_differences import FiniteDifferenceModel

            return FiniteDifferenceModel(shaping, series, axis)
        if axis is not None:
            from tissuec.learn.derivatives.static_model import StaticModel

            return StaticModel(shaping, series, known, axis)
        self._refuse_method()
        stop = experiment.duration or plan.simulation.duration
        chosen = partial(choose, fit_problem.integrator, fit_problem.step, duration=stop)
        first = chosen(self.compiled.network, plan)
        return DynamicModel(shaping, series, known, *first, chosen)

    def _refuse_method(self) -> None:
        """Reject a method that would not step what springs remember, or contact."""
        name, compiled = self.fit_problem.integrator, self.compiled
        what = ""
        if compiled.network.contact is not None:
            what = "contact"
        if compiled.network.springs.inelastic is not None:
            what = "springs that relax or yield"
        if not what or name not in INTEGRATORS or not INTEGRATORS[name].implicit:
            return
        message = f"in learning, {name} does not support {what}"
        hint = "write integrator is automatic, or an explicit one such as dop853"
        raise CompileError([Diagnostic("TIS306", message, self.fit_problem.span, hint)])


def _of_data(
    compiled: Compiled,
    fit_problem: FitProblem,
    data: Data,
    request: Request,
    scales: Mapping[int, float],
) -> _ExperimentScene:
    """Return the scene as it was set for a measurement."""
    compiled, fit_problem = set_for(compiled, fit_problem, data, request)
    shaping = Parametrisation(compiled, fit_problem, _words(compiled, fit_problem), scales)
    return _ExperimentScene(compiled, fit_problem, shaping)


def _words(compiled: Compiled, fit_problem: FitProblem) -> WordsModel | None:
    if not any(adjust.what == WORDS for adjust in fit_problem.adjusts):
        return None
    return WordsModel(compiled.scene, fit_problem.adjusts)
