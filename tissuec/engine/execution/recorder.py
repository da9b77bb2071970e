"""From samples to frames, logs, the energy table and evaluated expectations.

The times of all outputs are joined into one ascending list; the engine delivers samples at
these times in batches, each of which lies between two events. Only what is needed at a time is
computed.

Where an event changes what a log says, both sides of it are passed on beside the rows of the
log, whose times remain as requested.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.core.units import si_unit
from tissuec.engine.execution.doubts import Watcher
from tissuec.engine.execution.effects import EffectWatcher
from tissuec.engine.execution.event_queue import SAME, join_times, rows_at
from tissuec.engine.execution.expectations import ExpectationMemory, ExpectationMonitor
from tissuec.engine.execution.field_samples import FieldSampler, preserved_bodies
from tissuec.engine.method import Samples
from tissuec.engine.run_arrays import FLOOR, most_stored
from tissuec.geometry.surfaces import entries_of
from tissuec.mechanics.state import State
from tissuec.model.cut_cells import CutCells
from tissuec.model.network import Floats, Indices, Network
from tissuec.results.fields import channels
from tissuec.results.recording import (
    MOST_JUMPING,
    EventSide,
    LogChannel,
    Recording,
    SurfaceChannel,
    WithoutEffect,
)
from tissuec.results.volume_cells import VolumeCells
from tissuec.script.measures.snapshot import EnergyBalance, Snapshot
from tissuec.script.plan import Plan, times_every
from tissuec.script.verbs import LoggedEvent

ROUNDING = 1e-12
"""Part of the size of a row: a smaller change comes from another order of summation."""
APART = 0.001
"""Part of the distance of frames: events closer than that are shown as one."""


#: Gives the samples that are due at a rate [s], or None.
Part: TypeAlias = Callable[[float], Snapshot | None]


class FrameWriter(Protocol):
    """Destination of rows: a result file, or memory.

    Shared arguments:
        time: Times of the rows [s], shape (row,), or one time [s].
        position: Of all nodes [m], shape (row, node, 3).
        velocity: Of all nodes [m/s], shape (row, node, 3).
        fields: Numbers of fields by name in SI units, of all nodes, springs, triangles or
            cells, shape (row, node, …) or alike.
        body: Name of the body.
        channel: Name of the log.
        rows: Rows of a table in the units of its columns, shape (row, column).
        before, after: Rows on both sides of an event, shape (column,).
        kind, springs, cause, place: What happened, to which springs, why, and where in the
            text.
    """

    def topology(self, alive: NDArray[np.bool_], cut_cells: CutCells | None = None) -> None:
        """Set which entities exist in the frames to come, shape (entity,).

        Args:
            cut_cells: Parts of elements that were cut; None if there are no others than before.
        """
        ...

    def holds(self, time: float, holders: Mapping[str, Indices]) -> None:
        """Set which nodes are held from a time [s] on, by holder, shape (n,) each."""
        ...

    def frames(
        self, time: Floats, position: Floats, velocity: Floats, fields: Mapping[str, Floats]
    ) -> None:
        """Add frames."""
        ...

    def awaits_sides(self, time: float, apart: float) -> bool:
        """Return whether the net is to be written on both sides of an event at a time.

        Args:
            time: Of the event [s].
            apart: Least distance from the last event that was written [s].
        """
        ...

    def sides(self, before: EventSide, after: EventSide) -> None:
        """Add the net just before and just after an event."""
        ...

    def surface(self, body: str, time: Floats, position: Floats) -> None:
        """Add frames of the smooth surface of a body."""
        ...

    def log(self, channel: str, time: Floats, rows: Floats) -> None:
        """Add rows to a log."""
        ...

    def log_jump(self, channel: str, time: float, before: Floats, after: Floats) -> None:
        """Add the rows of a log on both sides of an event."""
        ...

    def energies(self, time: Floats, rows: Floats) -> None:
        """Add rows of energies [J]."""
        ...

    def energy_jump(self, time: float, before: Floats, after: Floats) -> None:
        """Add the energies on both sides of an event that changes them [J]."""
        ...

    def errors(self, time: Floats, rows: Floats) -> None:
        """Add estimated errors of positions [m], shape (row, 1)."""
        ...

    def event(
        self, time: float, kind: str, springs: tuple[int, ...], cause: str, place: str
    ) -> None:
        """Add an event."""
        ...

    def checkpoint(self, saved: Mapping[str, Any]) -> None:
        """Replace the state that a later run can continue from."""
        ...


class Tap(Protocol):
    """What is shown all that a recorder records, beside the writer."""

    def take(self, samples: Samples) -> None:
        """Take a batch of samples."""
        ...

    def log(self, name: str, time: Floats, rows: Floats) -> None:
        """Take rows of a log, shape (row, column), at times [s], shape (row,)."""
        ...

    def judged(self, place: int, time: Floats | None, gaps: Floats) -> None:
        """Take what an expectation compared.

        Args:
            place: Of the expectation in the plan.
            time: Times of samples [s], shape (row,); None for a time between samples.
            gaps: In SI units, shape (row, comparison).
        """
        ...

    def happened(self, logged_event: LoggedEvent) -> None:
        """Take an event."""
        ...


class _Observed(NamedTuple):
    """What makes a row of a log at a snapshot, and what takes both sides of an event."""

    row: Callable[[Snapshot], Floats]
    jump: Callable[[float, Floats, Floats], None]


class RecorderState(NamedTuple):
    """What a recorder knows beside its memory: what is due, and jumps still to be recorded."""

    due: tuple[NDArray[np.bool_], ...]
    before: Sequence[Floats]


class Recorder:
    """Receives samples and events of one run and records what the plan requests.

    Args:
        tap: Shown what is recorded as well.

    Attributes:
        takes_notes: Whether notes in the event log and doubts, which change nothing, are
            looked for.
        spacing: See ``Method`` [s].
        times: When samples are wanted [s], ascending, shape (sample,).
        memory: What is needed to continue after an interruption.
    """

    takes_notes: ClassVar[bool] = True
    spacing: float = 0.0

    def __init__(
        self,
        network: Network,
        plan: Plan,
        writer: FrameWriter,
        *,
        tap: Tap | None = None,
    ):
        self.network, self.plan, self.writer, self._tap = network, plan, writer, tap
        # Below, energies are made of rounding, and no balance is judged by them.
        self.memory = ExpectationMemory(scale=most_stored(network, FLOOR * network.extent))
        self._ledger = EnergyBalance()
        self._ruptured = np.zeros(network.entity_count, dtype=bool)
        self._tears = False  # whether something ruptured in the last events
        self._state: State | None = None
        self._alive: NDArray[np.bool_] | None = None
        self._holders: dict[str, Indices] | None = None
        self._observed = tuple(_observed(plan, writer))
        self._left: Sequence[Floats] = ()  # what was observed when events were about to come
        self._before: Sequence[Floats] = ()  # the same, once they have come
        self._side: EventSide | None = None  # of the net, before events
        self._changed: EventSide | None = None  # the same, once they have come
        duration = plan.simulation.duration
        near = self._near = SAME * duration
        streams = {rate: times_every(rate, duration) for rate in _rates(plan)}
        self.times = sample_times(plan)
        self._due = {rate: rows_at(self.times, times, near) for rate, times in streams.items()}
        weigh = None if tap is None else tap.judged
        self._judge = ExpectationMonitor(plan.expectations, self.times, near, weigh)
        self._watcher = Watcher(network, plan)
        self._effects = EffectWatcher(network, plan)
        self._sampler = FieldSampler(network, plan)

    def enter(self, state: State, ruptured: NDArray[np.bool_], ledger: EnergyBalance) -> None:
        """Set what is valid for the samples to come, after the events of a time.

        Args:
            state: The state after these events.
            ruptured: Entities that broke by themselves until now, shape (entity,).
            ledger: Initial and switched energy; the samples bring work and dissipation.
        """
        self._state = _frozen(state)
        self._tears = not np.array_equal(self._ruptured, ruptured)
        self._ruptured, self._ledger = ruptured.copy(), ledger
        self._judge.enter(state.time)
        if self._alive is None or not np.array_equal(self._alive, state.alive):
            self._alive = state.alive.copy()
            self.writer.topology(self._alive, state.cut_cells)
        if not _are_same(self._holders, holders := state.every_holder):
            self._holders = holders
            self.writer.holds(state.time, self._holders)
        if self.takes_notes:
            self._effects.enter(state, self.memory.effects)
        self._before, self._left = self._left, ()
        self._changed, self._side = self._side, None

    def leave(self, snapshot: Snapshot) -> None:
        """Judge expectations that end now, before the events of this time change anything."""
        self.record_jumps(snapshot)
        snapshot = self.scaled(snapshot)
        self._judge.leave(snapshot, self.memory)
        if self.takes_notes and self.plan.triggers:
            self._effects.measure(snapshot, self.memory.effects)
        self._left = [observed.row(snapshot) for observed in self._observed]
        self._side = self._side_of(snapshot) if self._awaits_sides(snapshot) else None

    def end(self, snapshot: Snapshot) -> None:
        """Judge the expectations under way at the end of a run that was ended early."""
        self._judge.end(self.scaled(snapshot), self.memory)

    @property
    def awaits_jumps(self) -> bool:
        """Return whether it is not recorded yet what the last events changed."""
        return len(self._before) > 0 or self._changed is not None

    def record_jumps(self, snapshot: Snapshot) -> None:
        """Record how the last events changed logged quantities.

        At a rupture, all of them are recorded: a force is largest there, and falls only later
        where what breaks is elsewhere.

        Args:
            snapshot: Just after them, at the same time; with a ledger if one is kept.
        """
        if not self.awaits_jumps:
            return
        snapshot = self.scaled(snapshot)
        for observed, before in zip(self._observed, self._before, strict=True):
            after = observed.row(snapshot)
            is_told = self._tears or not _is_same_row(before, after)
            if len(before) <= MOST_JUMPING and is_told:
                observed.jump(float(snapshot.time), before, after)
        if self._changed is not None:
            self.writer.sides(self._changed, self._side_of(snapshot))
        self._before, self._changed = (), None

    def _awaits_sides(self, snapshot: Snapshot) -> bool:
        output, time = self.plan.output, float(snapshot.time)
        return (
            len(output.frames) > 0
            and time > 0.0
            and self.writer.awaits_sides(time, APART * output.every)
        )

    def _side_of(self, snapshot: Snapshot) -> EventSide:
        """Return the arrays of the net that are written with an event."""
        return EventSide(
            float(snapshot.time),
            snapshot.position.copy(),
            snapshot.velocity.copy(),
            self._sampler.of(snapshot),
            snapshot.state.alive.copy(),
        )

    def happened(self, time: float, logged_event: LoggedEvent) -> None:
        """Add an event to the log of events."""
        springs = tuple(int(spring) for spring in logged_event.springs)
        place = logged_event.span.place
        self.writer.event(time, logged_event.kind, springs, logged_event.cause, place)
        if self._tap is not None:
            self._tap.happened(logged_event)

    def state(self) -> RecorderState:
        """Return the input of `bring_back` other than the memory."""
        return RecorderState(self._judge.due(), self._before)

    def bring_back(self, state: RecorderState) -> None:
        """Go back to what was known at some time; the memory of then is set already."""
        self._judge.set_due(state.due)
        self._before, self._left = state.before, ()
        self._changed = self._side = None

    @property
    def unreached(self) -> tuple[int, ...]:
        """Return the expectations that are still undecided, by their places in the plan."""
        return self._judge.unreached(self.memory)

    def without_effect(self, state: State, waiting: Iterable[int]) -> tuple[WithoutEffect, ...]:
        """Return what had no effect in a run that is done.

        Args:
            state: At its end.
            waiting: Conditions that were never true, by their places in the plan.
        """
        return self._effects.found(state, waiting, self.memory.effects)

    def checkpoint(self, saved: Mapping[str, Any]) -> None:
        """Keep a state to resume from; all samples before it have been recorded."""
        self.writer.checkpoint(saved)

    def record(self, samples: Samples) -> None:
        """Process a batch of samples, the next ones of ``times``."""
        assert self._state is not None, "enter comes first"
        if self._tap is not None:
            self._tap.take(samples)
        first = self.memory.next
        rows = slice(first, first + len(samples.time))
        self.memory.next = rows.stop
        snapshot = self._snapshot(samples, self._state)
        parts: dict[float, Snapshot] = {}

        def part(rate: float) -> Snapshot | None:
            due = self._due[rate][rows] if rate in self._due else np.zeros(0, dtype=bool)
            if rate not in parts and due.any():
                parts[rate] = snapshot if due.all() else snapshot.pick(np.flatnonzero(due))
            return parts.get(rate)

        self._write(part)
        self._write_errors(samples, rows)
        self._judge.sample(snapshot, rows, self.memory)
        if self.takes_notes:
            examined = self._look_at(self._state, samples)
            if examined and self.plan.triggers:
                self._effects.measure(snapshot.pick(np.array(examined)), self.memory.effects)

    def record_end(self, sample: Samples) -> None:
        """Record the state with which the run ends in the tables that do not hold it yet.

        Args:
            sample: One sample, which is none of ``times``, or was not recorded as one.
        """
        assert self._state is not None, "enter comes first"
        last, time = self.memory.next - 1, float(sample.time[0])
        is_sample = last >= 0 and abs(float(self.times[last]) - time) <= self._near
        missing = {rate for rate, due in self._due.items() if not (is_sample and due[last])}
        if not missing:
            return
        snapshot = self._snapshot(sample, self._state)
        self._write(lambda rate: snapshot if rate in missing else None)
        if self.plan.output.every in missing and len(self.plan.output.frames):
            self.writer.errors(sample.time, sample.error[:, None])

    def _look_at(self, state: State, samples: Samples) -> list[int]:
        """Look for doubts at some of a batch of samples, and return which."""
        examined, time, row = list[int](), samples.time, 0
        while True:
            row += int(np.searchsorted(time[row:], self.memory.doubts.next))
            if row == len(time):
                return examined
            self.look(state, float(time[row]), samples.position[row])
            examined.append(row)
            row += 1

    def look(
        self, state: State, time: float, position: Floats, *, always: bool = False
    ) -> bool:
        """Look for doubts and effects of orders, unless that was done a moment ago.

        Args:
            state: What is alive and held then.
            time: [s].
            position: Of all nodes [m], shape (node, 3).
            always: Whether to check in any case.

        Returns:
            Whether the state was examined.
        """
        is_due = always or time >= self.memory.doubts.next
        if is_due:
            self._watcher.look(state, time, position, self.memory.doubts)
            self._effects.look(state, position, self.memory.effects)
        return is_due

    def follow(
        self,
        time: float,
        position: Floats,
        state: State | None = None,
        *,
        always: bool = False,
    ) -> float:
        """Check for what could come and go between samples, if anything has moved far enough.

        Args:
            time: [s]; not before that of the last call.
            position: Of all nodes [m], shape (node, 3).
            state: Intact springs and held nodes at this time; by default, those entered last.
            always: Whether to check in any case.

        Returns:
            How far nodes may move before the next call [m].
        """
        state = self._state if state is None else state
        if not self.takes_notes or state is None:
            return np.inf
        memory = self.memory.doubts
        return self._watcher.follow(state, time, position, memory, always=always)

    def _snapshot(self, samples: Samples, state: State) -> Snapshot:
        motion = samples.time, samples.position, samples.velocity
        snapshot = Snapshot(state, *motion, self._ruptured, None, self.memory.pinned)
        if not self.plan.needs_ledger:
            return snapshot
        ledger = replace(self._ledger, work=samples.work, dissipated=samples.dissipated)
        sizes = ledger.size(snapshot.energies)
        scale = np.maximum.accumulate(np.concatenate([[self.memory.scale], sizes]))
        self.memory.scale = float(scale[-1])
        return snapshot.with_ledger(replace(ledger, scale=scale[1:]))

    def scaled(self, snapshot: Snapshot) -> Snapshot:
        """Return a single snapshot with the scale by which its energy balance is judged."""
        ledger = snapshot.ledger
        if ledger is None:
            return snapshot
        scale = np.maximum(ledger.size(snapshot.energies), self.memory.scale)
        return snapshot.with_ledger(replace(ledger, scale=scale))

    def _write(self, part: Part) -> None:
        """Write all tables but that of errors, ``part`` being the samples of a rate."""
        self.write_frames(part)
        self.write_surfaces(part)
        self._write_logs(part)
        self._write_energies(part)

    def write_frames(self, part: Part) -> None:
        """Write what is due of the trajectory, ``part`` being the samples of a rate."""
        output = self.plan.output
        if len(output.frames) and (snapshot := part(output.every)) is not None:
            fields = self._sampler.of(snapshot)
            time = np.asarray(snapshot.time)
            velocity = snapshot.velocity[..., : self.network.node_count, :]
            self.writer.frames(time, snapshot.position, velocity, fields)

    def write_surfaces(self, part: Part) -> None:
        """Write what is due of smooth surfaces, ``part`` being the samples of a rate."""
        for surface in self.plan.output.surfaces:
            if (snapshot := part(surface.every)) is not None:
                self.writer.surface(surface.body, np.asarray(snapshot.time), snapshot.position)

    def _write_errors(self, samples: Samples, rows: slice) -> None:
        output = self.plan.output
        if len(output.frames) and (due := self._due[output.every][rows]).any():
            self.writer.errors(samples.time[due], samples.error[due, None])

    def _write_logs(self, part: Part) -> None:
        for log in self.plan.output.logs:
            if (snapshot := part(log.every)) is not None:
                rows = log.measure.sample(log.subjects, snapshot)
                time = np.asarray(snapshot.time)
                self.writer.log(log.name, time, rows)
                if self._tap is not None:
                    self._tap.log(log.name, time, rows)

    def _write_energies(self, part: Part) -> None:
        if (snapshot := part(self.plan.output.energy)) is not None:
            self.writer.energies(np.asarray(snapshot.time), _energies(snapshot))


def wishes(network: Network, plan: Plan) -> Recording:
    """Return the recording that a result file of this plan needs."""
    output = plan.output
    shown = np.zeros(network.node_count, dtype=bool)
    shown[output.frames] = True
    start = Snapshot.of(plan.start(network))
    logs = tuple(
        LogChannel(
            log.name,
            log.measure.columns(log.subjects, start),
            si_unit(log.measure.dimension),
            (log.measure.__doc__ or log.name).partition("\n")[0],
        )
        for log in output.logs
    )
    fields = channels(output.fields)
    is_of_cells = any(one.at == "cell" for one in fields)
    return Recording(
        nodes=output.frames,
        lines=np.flatnonzero(shown[network.line_ends].all(axis=1) & network.shown_lines).astype(
            "i4"
        ),
        single=output.single,
        compress=output.compress,
        logs=logs,
        energies=bool(np.isfinite(output.energy)),
        surfaces=tuple(
            SurfaceChannel(surface.body, surface.kind, entries_of(surface.smoothing))
            for surface in output.surfaces
        ),
        fields=fields,
        cells=VolumeCells.of(network, preserved_bodies(network, plan)) if is_of_cells else None,
    )


def _rates(plan: Plan) -> list[float]:
    """Return the distances in time at which anything is wanted [s], ascending."""
    output = plan.output
    asked = (*output.logs, *output.surfaces)
    rates = {one.every for one in asked} | {output.energy}
    if len(output.frames):
        rates.add(output.every)
    return sorted(rate for rate in rates if np.isfinite(rate))


def sample_times(plan: Plan) -> Floats:
    """Return all times at which a sample is wanted [s], ascending, shape (sample,)."""
    expectations, duration = plan.expectations, plan.simulation.duration
    streams = [times_every(rate, duration) for rate in _rates(plan)]
    judged = [time for e in expectations for time in (e.start, e.stop, *e.pinned)]
    wanted = np.concatenate([*streams, np.array(judged, dtype=float)])
    # Frames keep their times to the last bit, whatever else is logged.
    every = len(plan.output.frames) > 0
    frames = times_every(plan.output.every, duration) if every else np.zeros(0)
    anchors = np.concatenate([frames, [event.time for event in plan.events]])
    return join_times(np.minimum(wanted, duration), anchors, SAME * duration)


def _observed(plan: Plan, writer: FrameWriter) -> Iterator[_Observed]:
    """Yield the logs of a plan, and the energies if they are recorded."""
    for log in plan.output.logs:
        row = partial(log.measure.sample, log.subjects)
        yield _Observed(row, partial(writer.log_jump, log.name))
    if np.isfinite(plan.output.energy):
        yield _Observed(_energies, writer.energy_jump)


def _energies(snapshot: Snapshot) -> Floats:
    """Return a row of the energy table for each time of a snapshot [J], shape (…, 6)."""
    ledger = snapshot.ledger
    assert ledger is not None, "an energy table needs the ledger"
    switched = np.full(np.shape(snapshot.time), ledger.switched)
    columns = (*snapshot.energies, ledger.work, ledger.dissipated, switched)
    return np.stack(columns, axis=-1)


def _is_same_row(before: Floats, after: Floats) -> bool:
    """Return whether no number of a row changed by more than rounding; NaN equals NaN."""
    sizes = np.abs([before, after])
    size = sizes[np.isfinite(sizes)].max(initial=0.0)
    return np.allclose(before, after, rtol=0.0, atol=ROUNDING * size, equal_nan=True)


def _are_same(before: Mapping[str, Indices] | None, now: Mapping[str, Indices]) -> bool:
    """Return whether the same nodes are held by the same."""
    return (
        before is not None
        and before.keys() == now.keys()
        and all(np.array_equal(before[name], now[name]) for name in now)
    )


def _frozen(state: State) -> State:
    """Return a copy of a state; arrays that later events replace are shared."""
    return replace(
        state,
        position=state.position.copy(),
        velocity=state.velocity.copy(),
        holders=dict(state.holders),
        motions=dict(state.motions),
        loads=dict(state.loads),
        blocks=dict(state.blocks),
        reelings=dict(state.reelings),
        knots=dict(state.knots),
        hold_ends=dict(state.hold_ends),
    )
