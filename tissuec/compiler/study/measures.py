"""The measures of a study on one of its scenes, whose sets and nodes may differ.

A measure is observed by a log of its own, or judged like an expectation at its time, so that
the motion is the same as without it.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.compiler.compile import Compiled
from tissuec.compiler.measures.conditions import Conditions
from tissuec.compiler.measures.observed import ObservedMeasure
from tissuec.compiler.measures.quantities import (
    ObservedExpression,
    ObservedPair,
    QuantityReader,
)
from tissuec.core.hints import alternatives
from tissuec.core.structs import replace
from tissuec.core.units import TIME, Dimension, show, si_unit
from tissuec.lang import syntax as s
from tissuec.model.network import Indices
from tissuec.scene.reading.block_sentences import SentenceReader
from tissuec.scene.reading.spellings import SLOPE, form_over_time
from tissuec.scene.study.entries import (
    EVENT,
    EVENTS,
    MEASURE,
    SENTENCES,
    MeasuredAt,
    MeasuredEvent,
    MeasuredOver,
)
from tissuec.scene.study.model import WrittenMeasure
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import Expectation, LogRequest, Plan

SAMPLES = 1000  # of a run, where nothing says how many
MOST_SAMPLES = 10_000_000
AT, CURVE = "at", "every"


class Capture(Struct, eq=False):
    """A condition that always holds and keeps what it sees.

    Attributes:
        value: In SI units; NaN before the time has come.
    """

    quantity: ObservedExpression
    value: float = math.nan

    def __call__(self, snapshot: Snapshot) -> bool:
        """Keep the value at a snapshot."""
        return bool(self.holds(snapshot))

    def holds(self, snapshots: Snapshot) -> Any:
        """Keep the last value of a batch of snapshots; returns True of shape (…)."""
        values = self.quantity.sample((), snapshots)[..., 0]
        self.value = float(np.ravel(values)[-1])
        return np.ones(np.shape(values), dtype=bool)

    def describe(self, snapshot: Snapshot) -> str:
        """Return an empty text: no progress is reported here."""
        return ""


class StudyMeasure(Struct, frozen=True, eq=False):
    """One column of a study on one scene.

    Attributes:
        name: Of the column.
        unit: In SI.
        kind: One of ``AGGREGATES``, AT, CURVE or EVENT.
        log: What is logged; None for other kinds.
        capture: What is seen at a time; None for other kinds.
        start, stop: Interval of an aggregate [s].
        event: Kind of the event.
        springs: Those that an event must concern, shape (spring,); None for any.
    """

    name: str
    unit: str
    dimension: Dimension
    kind: str
    log: LogRequest | None = None
    capture: Expectation | None = None
    start: float = 0.0
    stop: float = math.inf
    event: str = ""
    springs: Indices | None = None

    @property
    def readings(self) -> Iterable[ObservedMeasure]:
        """Return the measures that it takes; none of an event."""
        seen: object = None if self.log is None else self.log.measure
        if self.capture is not None and isinstance(self.capture.condition, Capture):
            seen = self.capture.condition.quantity
        is_observed = isinstance(seen, ObservedExpression | ObservedPair)
        return seen.readings.values() if is_observed else ()

    @property
    def every(self) -> float | None:
        """Return the time between the values of a curve [s]; None for one number."""
        return self.log.every if self.kind == CURVE and self.log is not None else None


def compile_measures(
    compiled: Compiled, written: Iterable[WrittenMeasure]
) -> tuple[tuple[StudyMeasure, ...], bool]:
    """Return the measures of a study on a scene, and whether they need energies kept.

    Findings go to those of the scene's constants; what is wrong is left out.
    """
    reader = _MeasureReader(compiled)
    found: list[StudyMeasure] = []
    for one in written:
        with reader.findings.item():
            found.append(reader.read(one))
    return tuple(found), reader.conditions.needs_ledger


def observing(
    plan: Plan, measures: Sequence[StudyMeasure], *, ledger: bool, whole: bool = False
) -> Plan:
    """Return a plan that observes measures and nothing else.

    Args:
        plan: Of the scene.
        ledger: Whether they need energies kept.
        whole: Whether the outputs of the scene are kept, too.
    """
    logs = tuple(measure.log for measure in measures if measure.log is not None)
    captures = tuple(m.capture for m in measures if m.capture is not None)
    output = plan.output
    if whole:
        output = replace(output, logs=(*output.logs, *logs))
    else:
        none = np.zeros(0, dtype=np.int64)
        output = replace(
            output, frames=none, every=math.inf, logs=logs, energy=math.inf, surfaces=()
        )
    return replace(
        plan,
        output=output,
        expectations=(*plan.expectations, *captures),
        needs_ledger=plan.needs_ledger or ledger,
    )


class _MeasureReader:
    """Reads ``measure`` lines on one scene."""

    def __init__(self, compiled: Compiled):
        scene = compiled.scene
        self.plan, self.groups, self.scope = compiled.plan, compiled.groups, scene.constants
        self.network = compiled.network
        self.duration = scene.simulation.duration
        self.conditions = Conditions(compiled.groups, scene)
        self.findings = self.conditions.findings
        self._quantities = QuantityReader(self.conditions)

    def read(self, written: WrittenMeasure) -> StudyMeasure:
        """Return one measure, or reject it."""
        item, self.place = written.item, written.span
        reader = SentenceReader(MEASURE, SENTENCES[MEASURE], item, self.scope)
        said = reader.get(is_last=False)
        value = said.value
        if isinstance(said, MeasuredEvent | MeasuredOver):
            reader.finish()
            if isinstance(said, MeasuredOver):
                return self._over(written, said)
            return self._event(written.name, *said.event)
        quantity = self._quantities.read(value)
        reader.finish()
        pinned = [r.time for r in quantity.readings.values() if r.time is not None]
        if isinstance(said, MeasuredAt):
            return self._at(written, quantity, self.conditions.time(said.at), pinned)
        if said.every is not None and not pinned:
            log = self._request(written, quantity, self._every(said.every))
            unit = si_unit(quantity.dimension)
            return StudyMeasure(written.name, unit, quantity.dimension, CURVE, log)
        if not item.clauses and pinned and len(pinned) == len(quantity.readings):
            return self._at(written, quantity, max(pinned), pinned)
        text = value.span.one_line
        what = "unexpected time" if item.clauses else "its time is missing"
        self.findings.reject(
            "TIS312",
            f'wrong form of "measure": {what}',
            item.clauses[0].span if item.clauses else value.span,
            hint=f"write max({text}), or {text} at 0.3 s; with every 1 ms it is a curve",
        )

    def _over(self, written: WrittenMeasure, said: MeasuredOver) -> StudyMeasure:
        """Return a number from the values of a measure over time."""
        call, clauses = said.value, written.item.clauses
        argument = call.arguments[0]
        if call.function.key == EVENT and isinstance(argument.value, s.Name) and not clauses:
            owners = (one.value for one in argument.clauses if one.word == "of")
            return self._event(written.name, argument.value, *owners)
        count = 2 if call.function.key == SLOPE else 1
        if len(call.arguments) != count:
            form = form_over_time(call.function.key)
            message = f"wrong form of {call.function.key}"
            self.findings.reject("TIS702", message, call.span, hint=f"the form is {form}")
        both = [self._quantities.read(one.value) for one in call.arguments]
        for clause in (clause for one in call.arguments for clause in one.clauses):
            self.findings.reject("TIS303", f'unexpected "{clause.word}"', clause.span)
        quantity = both[0] if count == 1 else ObservedPair(*both)
        if any(reading.time is not None for reading in quantity.readings.values()):
            message = "a measure over time cannot name a time"
            self.findings.reject("TIS702", message, argument.span)
        words = [clause.word for clause in clauses if clause.word != CURVE]
        if words not in ([], ["over"], ["from", "to"], ["until"]):
            self.findings.reject(
                "TIS306", f'"{words[0]}" alone is no interval', clauses[0].span,
                hint="an interval is from T to T, or until T",
            )  # fmt: skip
        ends = (said.start, said.stop or said.until)
        start, stop = (
            usual if end is None else self.conditions.time(end)
            for end, usual in zip(ends, (0.0, self.duration), strict=True)
        )
        if start > stop:
            place = clauses[0].span.to(clauses[1].span)
            self.findings.reject("TIS403", "the interval ends before it begins", place)
        rate = self._usual_rate(quantity) if said.every is None else self._every(said.every)
        log, unit = self._request(written, quantity, rate), si_unit(quantity.dimension)
        kind = call.function.key
        return StudyMeasure(
            written.name, unit, quantity.dimension, kind, log, None, start, stop
        )

    def _request(
        self, written: WrittenMeasure, quantity: ObservedExpression | ObservedPair, every: float
    ) -> LogRequest:
        measure: Any = quantity  # has the methods of a measure
        return LogRequest(f"measure {written.name}", measure, (), every, written.span)

    def _at(
        self,
        written: WrittenMeasure,
        quantity: ObservedExpression,
        time: float,
        pinned: Sequence[float],
    ) -> StudyMeasure:
        capture = Capture(quantity)
        looked = Expectation(
            capture, capture.describe, time, time, tuple(sorted(set(pinned))), written.span
        )
        unit = si_unit(quantity.dimension)
        return StudyMeasure(written.name, unit, quantity.dimension, AT, None, looked)

    def _event(self, name: str, kind: s.Name, *owners: s.Expression) -> StudyMeasure:
        """Return the time of the first event of a kind."""
        if kind.key not in EVENTS:
            self.findings.reject(
                "TIS701", f'there are no events of the kind "{kind.text}"', kind.span,
                hint=alternatives(kind.key, EVENTS, what="kinds"),
            )  # fmt: skip
        springs = None
        for subject in filter(None, map(s.as_name, owners)):
            springs = self.groups.springs(subject).indices
            if not self.groups.is_springs(subject):
                nodes = self.groups.nodes(subject).indices
                springs = np.append(springs, self.network.elements_within(nodes))
        return StudyMeasure(name, "s", TIME, EVENT, event=kind.key, springs=springs)

    # --- parts --------------------------------------------------------------------------------

    def _usual_rate(self, quantity: ObservedExpression | ObservedPair) -> float:
        """Return the time between samples [s]: that of a log of the same, or a part of all."""
        for reading in quantity.readings.values():
            for log in self.plan.output.logs:
                same = [subject.name for subject in reading.subjects]
                if log.measure == reading.measure and [x.name for x in log.subjects] == same:
                    return log.every
        return self.duration / SAMPLES if math.isfinite(self.duration) else 1.0

    def _every(self, every: float) -> float:
        """Return a time between samples [s], of which there are not too many."""
        if math.isfinite(self.duration) and self.duration / every > MOST_SAMPLES:
            message = f"the time between samples cannot be {show(every, TIME)}"
            self.findings.reject("TIS308", message, self.place)
        return every
