"""One run of a study in a worker: values, scene, motion, measures and their recording.

A scene is parsed once for all runs of a worker; what the values change is compiled again. Only
what measures need is recorded, and nothing is written unless results are to be kept.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.compile import Compiled
from tissuec.compiler.manifest import manifest_of, outcome_facts
from tissuec.compiler.recompiling import Recompiler
from tissuec.compiler.study.measures import StudyMeasure, compile_measures, observing
from tissuec.core.errors import CompileError, TissueError
from tissuec.core.signals import asked_to_stop, interruption
from tissuec.core.structs import replace
from tissuec.core.workers.workers import CommonCache
from tissuec.engine.execution.event_queue import SAME, rows_at
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.model.cut_cells import CutCells
from tissuec.model.network import Floats, Indices
from tissuec.results.promise import kinds
from tissuec.results.recording import EventSide
from tissuec.scene.program.imports import Program
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.spellings import SLOPE
from tissuec.scene.request import Request
from tissuec.scene.study.model import Cell, WrittenMeasure
from tissuec.script.plan import Plan, times_every
from tissuec.studies.table import DIVERGED, DONE, ENDED, REFUSED, STUCK, Row

if TYPE_CHECKING:
    from tissuec.engine.execution.companion import ErrorEstimate
    from tissuec.engine.execution.recorder import FrameWriter
    from tissuec.engine.execution.run import Outcome

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
        self._rest: FrameWriter = MemoryRecording()  # nothing reads it
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

    def topology(self, alive: NDArray[np.bool_], cut_cells: CutCells | None = None) -> None:
        self._rest.topology(alive, cut_cells)

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

        They ascend in time, shape (row,) and (row, column); rows after an event follow those
        before it.
        """
        try:
            time, rows = self.log_arrays(channel)
        except KeyError:
            return np.zeros(0), np.zeros((0, 1))
        try:
            jumps, before, after = self.jump_arrays(channel)
        except KeyError:
            return time, rows
        times = np.concatenate([jumps, jumps, time])
        every = np.concatenate([before, after, rows])
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


RESULT = "run_{:05d}.vtkhdf"
_NOTHING = math.nan


class Job(Struct, frozen=True):
    """What all runs of a study share.

    Attributes:
        program: Texts of the scene, without studies.
        request: What the scene was compiled from, for result files.
        names: Of the columns of measures, in their order.
        curves: Which of these hold curves.
        estimates: Whether errors are estimated.
        folder: Where result files go; None if they are not kept.
    """

    program: Program
    request: Request
    measures: tuple[WrittenMeasure, ...]
    names: tuple[str, ...]
    curves: tuple[bool, ...]
    estimates: bool
    folder: Path | None = None


class PlannedRun(Struct, frozen=True):
    """One run.

    Attributes:
        run: Its number in the design, from 0.
        values: Of the factors, as the table shows them.
        overrides: Texts of ``--set``.
        digest: Of all that the row follows from.
    """

    run: int
    values: tuple[Cell, ...]
    overrides: tuple[str, ...]
    digest: str


_RECOMPILERS = CommonCache[Job, Recompiler](lambda job: Recompiler(job.program))


def row_of(job: Job, planned: PlannedRun) -> Row:
    """Return the row of a run; what goes wrong is its reason.

    Raises:
        KeyboardInterrupt: The worker was asked to stop.
    """
    try:
        compiled, measures, ledger = _compiled(job, planned)
    except CompileError as error:
        first = error.diagnostics[0]
        place = f" ({first.span.place})" if first.span is not None else ""
        return failed(job, planned, REFUSED, f"{first.code}: {first.message}{place}")
    except Exception as error:
        return failed(job, planned, REFUSED, _named(error))
    try:
        return _run(job, planned, compiled, measures, ledger)
    except Exception as error:  # one run never ends a study
        return failed(job, planned, STUCK, _named(error))


def _named(error: Exception) -> str:
    """Return a message of ours, and of another one also what it is called."""
    is_told = isinstance(error, (TissueError, OSError))
    return str(error) if is_told else f"{type(error).__name__}: {error}"


def _compiled(job: Job, planned: PlannedRun) -> tuple[Compiled, tuple[StudyMeasure, ...], bool]:
    """Return the scene of a run and its measures.

    Raises:
        CompileError: The values do not go with the scene, or the measures do not.
    """
    findings = Findings()
    overrides = (*job.request.overrides, *planned.overrides)
    compiled = _RECOMPILERS.of(job).compile(overrides, findings)
    measures, ledger = compile_measures(compiled, job.measures)
    findings.raise_errors()
    by_name = {measure.name: measure for measure in measures}
    return compiled, tuple(by_name[name] for name in job.names), ledger


def _run(
    job: Job,
    planned: PlannedRun,
    compiled: Compiled,
    measures: Sequence[StudyMeasure],
    ledger: bool,
) -> Row:
    """Return the row of a run whose scene is right."""
    from tissuec.engine.execution.companion import Companion
    from tissuec.engine.execution.recorder import Recorder
    from tissuec.engine.execution.run import run

    plan = observing(compiled.plan, measures, ledger=ledger, whole=job.folder is not None)
    companion = Companion(
        compiled.network, plan, "inline" if job.estimates else "off", None, threads=1
    )
    path = None if job.folder is None else job.folder / RESULT.format(planned.run)
    request = replace(job.request, overrides=(*job.request.overrides, *planned.overrides))
    with asked_to_stop() as stop, Observer(compiled, compiled.plan, request, path) as observer:
        recorder = Recorder(compiled.network, plan, observer, tap=companion.tap)
        outcome = run(compiled.network, plan, recorder, interrupt=stop, threads=1)
        is_over = outcome.kind not in (DIVERGED, STUCK)
        estimate = None
        if is_over and not stop.answered:
            # However long it takes: a row must not depend on how busy the machine is.
            estimate = companion.estimate(
                outcome.statistics, stop, failures=outcome.failures, patience=math.inf
            )
        if stop.answered:
            raise interruption(stop.signal)
        observer.close(outcome, estimate)
    ended = outcome.ended if outcome.kind == DONE else None
    reason = "" if outcome.kind == DONE else outcome.message
    if ended is not None:
        reason = f"{ended.cause} ({ended.span.place})"
    events = [(time, event.kind, event.springs) for time, event in outcome.logged_events]
    return Row(
        planned.run,
        planned.values,
        tuple(_value(one, observer, events) for one in measures) if is_over else _none(job),
        outcome.kind if ended is None else ENDED,
        " ".join(reason.split()),
        "not checked" if estimate is None else estimate.promise,
        _NOTHING if estimate is None or estimate.error is None else estimate.error,
        planned.digest,
        kinds(outcome.doubts),
        outcome.state.time if is_over else _NOTHING,
    )


def _value(
    measure: StudyMeasure,
    observer: Observer,
    events: Sequence[tuple[float, str, Sequence[int]]],
) -> float | tuple[float, ...]:
    """Return the measured value; NaN if there is none."""
    match measure.kind:
        case "time":
            found = (
                time
                for time, kind, springs in events
                if kind == measure.event and _concerns(measure, springs)
            )
            return min(found, default=_NOTHING)
        case "at":
            assert measure.capture is not None
            return measure.capture.condition.value  # type: ignore[attr-defined]
        case "every":
            assert measure.log is not None
            times, values = observer.samples(measure.log.name)
            duration = observer.plan.simulation.duration
            regular = times_every(measure.log.every, duration)
            # Without the state with which a run ends early, samples have the same times in all.
            return tuple(values[rows_at(times, regular, SAME * duration)].tolist())
        case kind:
            assert measure.log is not None
            times, rows = observer.samples_and_jumps(measure.log.name)
            inside = (measure.start <= times) & (times <= measure.stop)
            if kind == SLOPE:
                return _slope(rows[inside])
            return _reduced(kind, times[inside], rows[inside, 0])


def _concerns(measure: StudyMeasure, springs: Sequence[int]) -> bool:
    return measure.springs is None or bool(np.isin(springs, measure.springs).any())


def _reduced(kind: str, times: Floats, values: Floats) -> float:
    """Return one number of values over time, both of shape (sample,), in their unit."""
    known = ~np.isnan(values)
    times, values = times[known], values[known]
    if not len(values):
        return _NOTHING
    match kind:
        case "max":
            return float(values.max())
        case "min":
            return float(values.min())
        case "first":
            return float(values[0])
        case "last":
            return float(values[-1])
        case _:
            length = times[-1] - times[0]
            area = np.sum(np.diff(times) * (values[1:] + values[:-1]) / 2.0)
            return float(area / length if length > 0.0 else values[0])


def _slope(rows: Floats) -> float:
    """Return the slope of the line of least squares through values over others.

    Args:
        rows: Values and what they are over, in their units, shape (sample, 2).
    """
    known = rows[~np.isnan(rows).any(axis=1)]
    apart = known - known.mean(axis=0) if len(known) else known
    spread = float((apart[:, 1] ** 2).sum()) if len(known) else 0.0
    return float(apart[:, 0] @ apart[:, 1]) / spread if spread > 0.0 else _NOTHING


def _none(job: Job) -> tuple[float | tuple[float, ...], ...]:
    """Return the measures of a run that has none."""
    return tuple(() if is_curve else _NOTHING for is_curve in job.curves)


def failed(job: Job, planned: PlannedRun, outcome: str, reason: str) -> Row:
    """Return the row of a run that has no measures.

    Args:
        job: Of the study.
        outcome: One of ``OUTCOMES``.
        reason: Why.
    """
    reason = " ".join(reason.split())
    return Row(
        planned.run,
        planned.values,
        _none(job),
        outcome,
        reason,
        "not checked",
        _NOTHING,
        planned.digest,
    )
