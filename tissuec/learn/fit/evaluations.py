"""Many evaluations of one learning, here or on workers.

What an evaluation returns depends on what it is of alone, so that results do not depend on who
did it.
"""

import time as clock
from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.workers.workers import CommonCache, Lost, OwnProcess, Workers
from tissuec.learn.derivatives.finite_differences import FiniteDifferenceModel, Runs
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.rule_revision import CandidateScene
from tissuec.learn.fit.session import LearnSession, prepare
from tissuec.model.network import Floats

Result = TypeVar("Result")
Result_co = TypeVar("Result_co", covariant=True)
PAYS, GOES_ON = 1.0, 0.05  # work [s] for which processes are started, or used once they are


class LostWorkersError(Exception):
    """Workers died or cannot be reached; no search takes it for a motion that is missing."""


class Evaluation(Protocol[Result_co]):
    """One evaluation; it can be pickled."""

    def evaluate(self, session: LearnSession) -> Result_co:
        """Return the result; called in a worker."""
        ...


class Evaluator:
    """Evaluates on workers what takes long, and here what does not.

    Args:
        scene: What is learnt from.
        session: Prepared from that.
        workers: Who does it; entered already.
    """

    def __init__(self, scene: CandidateScene, session: LearnSession, workers: Workers):
        self._scene, self._session, self._workers = scene, session, workers
        self._least = PAYS
        for number, trial in enumerate(session.learning):
            if isinstance(trial.model, FiniteDifferenceModel):
                trial.model.runs = self._runs_of(number)

    def all(
        self,
        items: Sequence[Evaluation[Result]],
        done: Callable[[int], None] | None = None,
    ) -> list[Result | None]:
        """Return the results in the order of the items; None where a worker died of one.

        Args:
            items: What is evaluated.
            done: Progress callback: the number of finished ones.

        Raises:
            LostWorkersError: No worker can be reached.
        """
        found: list[Result | None] = []
        began, is_alone = clock.perf_counter(), isinstance(self._workers, OwnProcess)
        for item in items:
            passed, left = clock.perf_counter() - began, len(items) - len(found)
            if found and not is_alone and left * passed / len(found) > self._least:
                return found + self._elsewhere(items[len(found) :], len(found), done)
            found.append(item.evaluate(self._session))
            if done is not None:
                done(len(found))
        return found

    def _elsewhere(
        self,
        items: Sequence[Evaluation[Result]],
        before: int,
        done: Callable[[int], None] | None,
    ) -> list[Result | None]:
        self._least = GOES_ON
        found: list[Result | None] = [None] * len(items)
        results = self._workers.map(_evaluated, self._scene, items)
        try:
            for count, (number, result) in enumerate(results, start=before + 1):
                if not isinstance(result, Lost):
                    found[number] = result
                if done is not None:
                    done(count)
        except TissueError as error:
            raise LostWorkersError(str(error)) from error
        return found

    def _runs_of(self, experiment: int) -> Runs:
        def runs(points: Sequence[Floats], method: str, stop: float) -> list[Floats | None]:
            found = self.all([WholeRun(experiment, at, method, stop) for at in points])
            if any(one is None for one in found):
                raise LostWorkersError("workers died while they ran the scene")
            return [values if len(values) else None for values in found if values is not None]

        return runs


class WholeRun(Struct, frozen=True, eq=False):
    """Predictions of one experiment by a run of the engine.

    Attributes:
        experiment: Its place among those that are learnt from.
        theta: Parameters, dimensionless, shape (parameter,).
        method: By which it is stepped.
        stop: Up to which time [s].
    """

    experiment: int
    theta: Floats
    method: str
    stop: float

    def evaluate(self, session: LearnSession) -> Floats:
        """Return the predictions, shape (number,); none of them where there is no motion."""
        model = session.learning[self.experiment].model
        assert isinstance(model, FiniteDifferenceModel)
        model.limit(self.stop)
        values = model.run_at(self.theta, self.method)
        return np.zeros(0) if values is None else values


class StartError(Struct, frozen=True, eq=False):
    """How far the prediction of a start is from the data.

    Attributes:
        theta: The start, dimensionless, shape (parameter,).
        part: Of the data, from its beginning, that is compared.
    """

    theta: Floats
    part: float

    def evaluate(self, session: LearnSession) -> float:
        """Return the relative error; infinite where there is no motion."""
        problem = session.problem
        problem.limit_to(self.part)
        try:
            problem.freeze(self.theta)
            return problem.relative(problem.with_zeros(self.theta))
        except (Diverged, TissueError):
            return np.inf


# --- in a worker ------------------------------------------------------------------------------


_SESSIONS = CommonCache[CandidateScene, LearnSession](lambda scene: prepare(*scene))


def _evaluated(scene: CandidateScene, item: Evaluation[Result]) -> Result:
    return item.evaluate(_SESSIONS.of(scene))
