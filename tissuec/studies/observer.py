"""The recording of one run of a study: its measures in memory, the rest in a file, if any."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.compiler.compile import Compiled
from tissuec.compiler.manifest import manifest_of, outcome_facts
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.model.network import Floats, Indices
from tissuec.results.recording import EventSide
from tissuec.script.plan import Plan

if TYPE_CHECKING:
    from tissuec.engine.execution.companion import ErrorEstimate
    from tissuec.engine.execution.recorder import Writer
    from tissuec.engine.execution.run import Outcome
    from tissuec.scene.request import Request

MEASURED = "measure "  # how the logs of measures begin


class Observer(MemoryRecording):
    """Takes what a run records: measures into memory, the outputs of the scene into a file.

    Args:
        compiled: The scene.
        plan: Of the scene, without measures.
        request: What the scene was compiled from.
        path: Of the file; None keeps nothing but measures.
    """

    def __init__(self, compiled: Compiled, plan: Plan, request: "Request", path: Path | None):
        super().__init__()
        self.plan, self._writer = plan, None
        self._rest: Writer = MemoryRecording()  # nothing reads it
        if path is not None:
            from tissuec.engine.execution.recorder import wishes
            from tissuec.results.writer import ResultWriter

            self._rest = self._writer = ResultWriter(
                path,
                compiled.network,
                wishes(compiled.network, plan),
                manifest_of(compiled, request),
                compiled.scene.source.text,
                tuple(compiled.named_groups()),
            )

    def topology(self, alive: NDArray[np.bool_]) -> None:
        self._rest.topology(alive)

    def holds(self, time: float, holders: Mapping[str, Indices]) -> None:
        self._rest.holds(time, holders)

    def frames(
        self, time: Floats, position: Floats, velocity: Floats, fields: Mapping[str, Floats]
    ) -> None:
        self._rest.frames(time, position, velocity, fields)

    def awaits_sides(self, time: float, apart: float) -> bool:
        return self._rest.awaits_sides(time, apart)

    def sides(self, before: EventSide, after: EventSide) -> None:
        self._rest.sides(before, after)

    def surface(self, body: str, time: Floats, position: Floats) -> None:
        self._rest.surface(body, time, position)

    def log(self, channel: str, time: Floats, rows: Floats) -> None:
        if channel.startswith(MEASURED):
            super().log(channel, time, rows)
        else:
            self._rest.log(channel, time, rows)

    def log_jump(self, channel: str, time: float, before: Floats, after: Floats) -> None:
        if channel.startswith(MEASURED):
            super().log_jump(channel, time, before, after)
        else:
            self._rest.log_jump(channel, time, before, after)

    def energies(self, time: Floats, rows: Floats) -> None:
        self._rest.energies(time, rows)

    def energy_jump(self, time: float, before: Floats, after: Floats) -> None:
        self._rest.energy_jump(time, before, after)

    def errors(self, time: Floats, rows: Floats) -> None:
        self._rest.errors(time, rows)

    def event(
        self, time: float, kind: str, springs: tuple[int, ...], cause: str, place: str
    ) -> None:
        self._rest.event(time, kind, springs, cause, place)

    def checkpoint(self, saved: Mapping[str, Any]) -> None:
        self._rest.checkpoint(saved)

    def samples(self, channel: str) -> tuple[Floats, Floats]:
        """Return times [s] and values of a measure in SI units, shape (row,) each."""
        try:
            time, rows = self.log_arrays(channel)
        except KeyError:
            return np.zeros(0), np.zeros(0)
        return time, rows[:, 0]

    def samples_and_jumps(self, channel: str) -> tuple[Floats, Floats]:
        """Return times [s] and values, in SI units, of samples and of both sides of events.

        They ascend in time, shape (row,) each; rows after an event follow those
        before it.
        """
        time, values = self.samples(channel)
        try:
            jumps, before, after = self.jump_arrays(channel)
        except KeyError:
            return time, values
        times = np.concatenate([jumps, jumps, time])
        every = np.concatenate([before[:, 0], after[:, 0], values])
        order = np.argsort(times, kind="stable")
        return times[order], every[order]

    def close(self, outcome: "Outcome", estimate: "ErrorEstimate | None") -> None:
        """Finish the file, if there is one."""
        if self._writer is None:
            return
        if estimate is not None and len(estimate.times):
            self._writer.companion(estimate.times, estimate.apart[:, None])
        own = tuple(n for n in outcome.unreached if n < len(self.plan.expectations))
        facts = outcome_facts(self.plan, replace(outcome, unreached=own), estimate)
        self._writer.close(outcome.message, outcome.kind == "done", facts)

    def __enter__(self) -> Self:
        if self._writer is not None:
            self._writer.__enter__()
        return self

    def __exit__(self, *failure: Any) -> None:
        if self._writer is not None:
            self._writer.__exit__(*failure)
