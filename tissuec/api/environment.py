"""A scene as an environment for reinforcement learning: ``gymnasium.Env``.

Observations, rewards and ends are measures and conditions of the language, and actions are
sentences of its script. (M. Towers et al., Gymnasium, 2024, https://gymnasium.farama.org.)
"""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import gymnasium  # pyright: ignore[reportMissingImports, reportMissingTypeStubs]
import numpy as np
from numpy.typing import NDArray

from tissuec.api.stepped_run import SteppedRun
from tissuec.core import arguments
from tissuec.core.errors import SimulationError, counted
from tissuec.model.network import Floats

Limits = tuple[float, float]
PLACE = "{}"  # in a sentence: the place of the number of the action


class TissueEnv(gymnasium.Env[Floats, Floats]):  # pyright: ignore
    """A run of a scene that is stepped by actions.

    An episode begins at 0 s. It is truncated at the end of the scene, and terminated by
    ``ends``, by ``end the run`` of the script, or where the motion cannot be computed; then
    ``info["reason"]`` says why, and the reward is 0.

    Args:
        run: The run, at 0 s.
        observations: Measures, such as "force of forceps A", with their limits in SI units;
            without limits, they are unbounded.
        actions: Sentences with ``{}`` in place of the number, such as "move forceps A by
            (0, 0, {} mm) using constant speed", with the limits of the number.
        reward: A measure or expression of measures.
        step: Time between two actions; each sentence takes that long.
        ends: A condition that ends an episode; empty for none.

    Attributes:
        run: See above.

    Raises:
        CompileError: A measure, condition or sentence is wrong.
        ValueError: A sentence has no place for its number, or limits are no range.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}  # pyright: ignore

    def __init__(
        self,
        run: SteppedRun,
        observations: Sequence[str] | Mapping[str, Limits],
        actions: Mapping[str, Limits],
        reward: str,
        *,
        step: str | float,
        ends: str = "",
    ):
        self.run, self._reward, self._step, self._ends = run, reward, step, ends
        self._observed = tuple(arguments.several(observations, "observations"))
        self._sentences = tuple(arguments.several(actions, "actions"))
        for sentence in actions:
            if sentence.count(PLACE) != 1:
                raise ValueError(f'the action "{sentence}" needs one {PLACE} for its number')
        given: Mapping[str, Limits] = observations if isinstance(observations, Mapping) else {}
        self._limits = _limits(self._observed, given)
        self.observation_space = _space(self._limits)
        acting = _limits(self._sentences, actions)
        self.action_space = _space(acting)
        self._start = run.save()
        self._rehearse(acting.mean(axis=1))

    def _rehearse(self, action: Floats) -> None:
        """Find mistakes in texts before the first episode."""
        self._observation()
        self.run.measure(self._reward)
        if self._ends:
            self.run.holds(self._ends)
        self._act(action)
        self.run.restore(self._start)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begin a new episode at 0 s; return the observation and info.

        The observation is in SI units, shape (observation,).

        Args:
            seed: Of ``np_random``; the scene itself has no chance in it.
            options: Not used.
        """
        super().reset(seed=seed)
        self.run.restore(self._start)
        return self._observation(), self._info()

    def step(self, action: Floats) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Act for one step.

        Args:
            action: Numbers of the sentences, in the units written there, shape (action,).

        Raises:
            ValueError: There are more or fewer numbers, or one is not finite; nothing is done.

        Returns:
            Observation in SI units, shape (observation,), reward, whether the episode ended,
            whether the scene did, and info.
        """
        numbers = np.asarray(action, dtype=float)
        if numbers.shape != (count := len(self._sentences),) or not np.isfinite(numbers).all():
            raise ValueError(
                f"an action is {counted(count, 'finite number')}, one for each sentence, and "
                f"not {action!r}"
            )
        try:
            self._act(numbers)
            self.run.step(self._step)
            seen, reward = self._observation(), self.run.measure(self._reward)
        except SimulationError as error:
            return self._seen, 0.0, True, False, {"time": self.run.time, "reason": str(error)}
        is_over = bool(self._ends) and self.run.holds(self._ends)
        at_end = self.run.time >= self.run.duration
        is_ended = is_over or (bool(self.run.ended) and not at_end)
        info = self._info()
        if is_ended:
            info["reason"] = self._ends if is_over else self.run.ended
        return seen, reward, is_ended, at_end and not is_ended, info

    def _act(self, action: Floats) -> None:
        span = min(self.run.seconds(self._step), self.run.duration - self.run.time)
        for sentence, number in zip(self._sentences, action.tolist(), strict=True):
            self.run.order(sentence.replace(PLACE, repr(number)), over=span)

    def _observation(self) -> Floats:
        """Return the measures, within their limits, shape (observation,)."""
        found = np.array([self.run.measure(what) for what in self._observed])
        self._seen = np.clip(found, *self._limits.T)  # returned if the next step fails
        return self._seen

    def _info(self) -> dict[str, Any]:
        return {"time": self.run.time}


def _limits(names: Sequence[str], limits: Mapping[str, Limits]) -> Floats:
    """Return the limits of numbers with names, shape (name, 2), infinite where none are given.

    Raises:
        ValueError: There are no names, or limits are no range.
    """
    found: NDArray[np.float64] = np.array(
        [limits.get(name, (-np.inf, np.inf)) for name in names], dtype=float
    ).reshape(-1, 2)
    wrong = [name for name, (low, high) in zip(names, found, strict=True) if not low < high]
    if wrong or not names:
        raise ValueError(
            f"limits must ascend: {', '.join(wrong)}" if wrong else "nothing given"
        )
    return found


def _space(limits: Floats) -> Any:
    """Return the space of numbers within limits."""
    return gymnasium.spaces.Box(limits[:, 0], limits[:, 1], dtype=np.float64)
