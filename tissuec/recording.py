"""From samples to frames, logs, the energy table and verdicts on expectations.

The times of everything that somebody asked for are joined into one ascending list; the engine
delivers samples at these times in batches, each of which lies between two events. What nobody
asked for at a time is not computed.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tissuec.core.units import si_unit
from tissuec.measures.moment import Ledger, Moment
from tissuec.network import Floats, Network
from tissuec.plan import Plan, times_every
from tissuec.results.recording import LogChannel, Recording
from tissuec.sampling import SAME, join_times, rows_at, rows_within
from tissuec.situation import Situation
from tissuec.verbs import Happening


class Samples(Protocol):
    """A batch of states, as the engine delivers it."""

    @property
    def time(self) -> Floats: ...  # [s], shape (sample,)
    @property
    def position(self) -> Floats: ...  # [m], shape (sample, node, 3)
    @property
    def velocity(self) -> Floats: ...  # [m/s], shape (sample, node, 3)
    @property
    def work(self) -> Floats: ...  # [J], shape (sample,)
    @property
    def dissipated(self) -> Floats: ...  # [J], shape (sample,)


class Writer(Protocol):
    """Where rows go: a result file, or memory."""

    def topology(self, alive: NDArray[np.bool_]) -> None: ...
    def frames(
        self, time: Floats, position: Floats, velocity: Floats, force: Floats, tension: Floats
    ) -> None: ...
    def log(self, channel: str, time: Floats, rows: Floats) -> None: ...
    def energies(self, time: Floats, rows: Floats) -> None: ...
    def event(
        self, time: float, kind: str, springs: tuple[int, ...], cause: str, place: str
    ) -> None: ...
    def checkpoint(self, state: Mapping[str, Any]) -> None: ...


@dataclass(frozen=True, slots=True)
class Failure:
    """The first time at which an expectation did not hold.

    Attributes:
        expectation: Its place in the plan.
        time: [s].
        measured: What was measured instead, such as "gap(oviduct) = 0.2 mm".
    """

    expectation: int
    time: float
    measured: str


@dataclass(slots=True, eq=False)
class Memory:
    """What a recorder must know to go on after an interruption.

    Attributes:
        next: The first sample that has not come yet.
        scale: Largest energy so far [J].
        pinned: Moments that expectations look back to.
        failures: By the place of the expectation.
    """

    next: int
    scale: float
    pinned: dict[float, Moment]
    failures: dict[int, Failure]


class Recorder:
    """Receives samples and happenings of one run and passes on what the plan asks for.

    Args:
        network, plan: What is run.
        writer: Where rows go.
    """

    def __init__(self, network: Network, plan: Plan, writer: Writer):
        self.network = network
        self.plan = plan
        self.writer = writer
        self.memory = Memory(0, 0.0, {}, {})
        self._situation: Situation | None = None
        self._ledger = Ledger()
        self._ruptured = np.zeros(network.spring_count, dtype=bool)
        self._alive: NDArray[np.bool_] | None = None
        self._plan_times()

    def _plan_times(self) -> None:
        plan, duration = self.plan, self.plan.simulation.duration
        output = plan.output
        rates = {log.every for log in output.logs}
        rates |= {output.every} if len(output.frames) else set()
        rates |= {output.energy}
        streams = {rate: times_every(rate, duration) for rate in sorted(rates) if np.isfinite(rate)}
        expected = [time for e in plan.expectations for time in (e.start, e.stop, *e.pinned)]
        anchors = np.array([event.time for event in plan.events])
        near = SAME * duration
        wanted = np.concatenate([*streams.values(), np.array(expected, dtype=float)])
        self.times = join_times(np.minimum(wanted, duration), anchors, near)
        self._near = near
        self._due = {rate: rows_at(self.times, times, near) for rate, times in streams.items()}
        self._pinned_at = {
            time: int(np.flatnonzero(rows_at(self.times, np.array([time]), near))[0])
            for expectation in plan.expectations
            for time in expectation.pinned
        }
        self._judged = [rows_within(self.times, e.start, e.stop, near) for e in plan.expectations]

    # --- between events ------------------------------------------------------------------------

    def enter(self, situation: Situation, ruptured: NDArray[np.bool_], ledger: Ledger) -> None:
        """State what holds for the samples to come, after the events of a time.

        Args:
            ruptured: Which springs broke by themselves until now, shape (spring,).
            ledger: Initial and switched energy; the samples bring work and dissipation.
        """
        self._situation = frozen(situation)
        for judged, expectation in zip(self._judged, self.plan.expectations, strict=True):
            # An interval that ended here was judged before the events of this time.
            if expectation.start < expectation.stop - self._near <= situation.time:
                judged[self.times >= expectation.stop - 2.0 * self._near] = False
        self._ruptured, self._ledger = ruptured.copy(), ledger
        if self._alive is None or not np.array_equal(self._alive, situation.alive):
            self._alive = situation.alive.copy()
            self.writer.topology(self._alive)

    def leave(self, moment: Moment) -> None:
        """Judge expectations that end now, before the events of this time change anything."""
        for number, expectation in enumerate(self.plan.expectations):
            ends_now = abs(expectation.stop - float(moment.time)) <= self._near
            if ends_now and expectation.start < expectation.stop - self._near:
                self._judge(number, self._looking_back(moment))

    def happened(self, time: float, happening: Happening) -> None:
        """Enter something into the event log."""
        springs = tuple(int(spring) for spring in happening.springs)
        place = happening.span.place
        self.writer.event(time, happening.kind, springs, happening.cause, place)

    def checkpoint(self, state: Mapping[str, Any]) -> None:
        """Keep a state to go on from; every sample before it has been passed on."""
        self.writer.checkpoint(state)

    # --- samples -------------------------------------------------------------------------------

    def record(self, samples: Samples) -> None:
        """Take in a batch of samples, the next ones of ``times``."""
        assert self._situation is not None, "enter comes first"
        first = self.memory.next
        rows = slice(first, first + len(samples.time))
        self.memory.next = rows.stop
        moment = self._moment(samples, self._situation)
        parts: dict[float, Moment] = {}

        def part(rate: float) -> Moment | None:
            due = self._due[rate][rows] if rate in self._due else np.zeros(0, dtype=bool)
            if rate not in parts and due.any():
                parts[rate] = moment if due.all() else moment.pick(np.flatnonzero(due))
            return parts.get(rate)

        self._write_frames(part)
        self._write_logs(part)
        self._write_energies(part)
        self._pin(moment, first)
        self._judge_batch(moment, rows)

    def _moment(self, samples: Samples, situation: Situation) -> Moment:
        state = samples.time, samples.position, samples.velocity
        moment = Moment(situation, *state, self._ruptured, None, self.memory.pinned)
        if not self.plan.needs_ledger:
            return moment
        ledger = replace(self._ledger, work=samples.work, dissipated=samples.dissipated)
        sizes = ledger.size(moment.energies)
        scale = np.maximum.accumulate(np.concatenate([[self.memory.scale], sizes]))
        self.memory.scale = float(scale[-1])
        return moment.with_ledger(replace(ledger, scale=scale[1:]))

    def _write_frames(self, part: Callable[[float], Moment | None]) -> None:
        if len(self.plan.output.frames) and (moment := part(self.plan.output.every)) is not None:
            state = moment.time, moment.position, moment.velocity
            self.writer.frames(*map(np.asarray, state), moment.node_force, moment.tension)

    def _write_logs(self, part: Callable[[float], Moment | None]) -> None:
        for log in self.plan.output.logs:
            if (moment := part(log.every)) is not None:
                rows = log.measure.sample(log.subjects, moment)
                self.writer.log(log.name, np.asarray(moment.time), rows)

    def _write_energies(self, part: Callable[[float], Moment | None]) -> None:
        if (moment := part(self.plan.output.energy)) is None:
            return
        assert moment.ledger is not None, "an energy table needs the ledger"
        ledger = moment.ledger
        switched = np.full(np.shape(moment.time), ledger.switched)
        columns = (*moment.energies, ledger.work, ledger.dissipated, switched)
        self.writer.energies(np.asarray(moment.time), np.stack(columns, axis=-1))

    def _pin(self, moment: Moment, first: int) -> None:
        for time, place in self._pinned_at.items():
            if first <= place < first + len(np.atleast_1d(moment.time)):
                then = moment.pick(np.array([place - first])).pick(0)  # a copy of the state
                self.memory.pinned[time] = replace(then, pinned={})

    # --- expectations --------------------------------------------------------------------------

    def _judge_batch(self, moment: Moment, rows: slice) -> None:
        for number in range(len(self.plan.expectations)):
            for sample in np.flatnonzero(self._judged[number][rows]):
                if number in self.memory.failures:
                    break
                self._judge(number, moment.pick(int(sample)))

    def _judge(self, number: int, moment: Moment) -> None:
        expectation = self.plan.expectations[number]
        if number not in self.memory.failures and not expectation.condition(moment):
            failure = Failure(number, float(moment.time), expectation.describe(moment))
            self.memory.failures[number] = failure

    def _looking_back(self, moment: Moment) -> Moment:
        if moment.ledger is None:
            return replace(moment, pinned=self.memory.pinned)
        size = float(moment.ledger.size(moment.energies))
        ledger = replace(moment.ledger, scale=max(size, self.memory.scale))
        return replace(moment.with_ledger(ledger), pinned=self.memory.pinned)


def wishes(network: Network, plan: Plan) -> Recording:
    """Return what a result file of this plan must have room for."""
    output = plan.output
    shown = np.zeros(network.node_count, dtype=bool)
    shown[output.frames] = True
    start = Moment.of(Situation.start(network, gravity=plan.gravity, drag=plan.drag))
    channels = tuple(
        LogChannel(
            log.name,
            log.measure.columns(log.subjects, start),
            si_unit(log.measure.dimension),
            (log.measure.__doc__ or log.name).partition("\n")[0],
        )
        for log in output.logs
    )
    return Recording(
        nodes=output.frames,
        springs=np.flatnonzero(shown[network.ends].all(axis=1)),
        single=output.single,
        logs=channels,
        energies=bool(np.isfinite(output.energy)),
    )


def frozen(situation: Situation) -> Situation:
    """Return what a situation is now; arrays that later events replace are shared."""
    return replace(
        situation,
        position=situation.position.copy(),
        velocity=situation.velocity.copy(),
        holders=dict(situation.holders),
        motions=dict(situation.motions),
        loads=dict(situation.loads),
        hold_ends=dict(situation.hold_ends),
    )
