"""The measures of a study on one of its scenes, whose sets and nodes may differ.

A measure is observed by a log of its own, or judged like an expectation at its time, so that
the motion is the same as without it.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.compiler.compile import Compiled
from tissuec.compiler.measures.conditions import Conditions
from tissuec.compiler.measures.quantities import ObservedExpression, QuantityReader
from tissuec.core.hints import alternatives
from tissuec.core.source import Span
from tissuec.core.units import TIME, Dimension, si_unit
from tissuec.lang import syntax as s
from tissuec.model.network import Indices
from tissuec.scene.study.entries import AGGREGATES, SENTENCES
from tissuec.scene.study.model import WrittenMeasure
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import Expectation, LogRequest, Plan

SAMPLES = 1000  # of a run, where nothing says how many
MOST_SAMPLES = 10_000_000
AT, CURVE, EVENT = "at", "every", "time"
#: Kinds of events whose time can be measured.
EVENTS = (
    "rupture", "slip", "cut", "grasp", "release", "trigger", "leak", "tie", "fix", "free",
    "hold", "move", "turn", "push", "press", "tighten", "inflate", "irrigate", "preserve",
    "change", "settle", "seize", "stroke", "stop", "end", "end the run", "note",
)  # fmt: skip


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
        measures: Of the study.
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
        self._quantities = QuantityReader(self.conditions, SENTENCES["measure"].forms[0])

    def read(self, written: WrittenMeasure) -> StudyMeasure:
        """Return one measure, or reject it."""
        value, clauses = written.item.value, written.item.clauses
        if (kind := _event(value, clauses)) is not None:
            return self._event(written.name, *kind)
        if isinstance(value, s.Call) and _is_aggregate(value):
            return self._aggregate(written.name, value, clauses)
        subjects = tuple(c for c in clauses if c.word in ("of", "to", "along"))
        times = tuple(c for c in clauses if c not in subjects)
        quantity = self._quantities.read(value, subjects, written.span)
        pinned = [r.time for r in quantity.readings.values() if r.time is not None]
        words = [clause.word for clause in times]
        if words == ["every"] and not pinned:
            every = self._every(times[0].value)
            log = self._request(written.name, quantity, every, written.span)
            unit = si_unit(quantity.dimension)
            return StudyMeasure(written.name, unit, quantity.dimension, CURVE, log)
        if words == ["at"]:
            return self._at(written, quantity, self.conditions.time(times[0].value), pinned)
        if not words and pinned and len(pinned) == len(quantity.readings):
            return self._at(written, quantity, max(pinned), pinned)
        text = value.span.to(subjects[-1].span if subjects else value.span).one_line
        what = "unexpected time" if words else "its time is missing"
        self.findings.reject(
            "TIS312",
            f'wrong form of "measure": {what}',
            times[0].span if times else value.span,
            hint=f"write max({text}), or {text} at 0.3 s; with every 1 ms it is a curve",
        )

    def _aggregate(self, name: str, call: s.Call, clauses: Sequence[s.Clause]) -> StudyMeasure:
        argument = call.arguments[0]
        quantity = self._quantities.read(argument.value, argument.clauses, call.span)
        if any(reading.time is not None for reading in quantity.readings.values()):
            message = "a measure over time cannot name a time"
            self.findings.reject("TIS702", message, argument.span)
        every, start, stop = self._usual_rate(quantity), 0.0, self.duration
        words = [clause.word for clause in clauses]
        while words[-1:] == ["every"]:
            every = self._every(clauses[len(words) - 1].value)
            words.pop()
        match words:
            case []:
                pass
            case ["over"] if clauses[0].value.span.text.lower() == "run":
                pass
            case ["from", "to"]:
                start, stop = (self.conditions.time(clause.value) for clause in clauses[:2])
                if start > stop:
                    message = "the interval ends before it begins"
                    self.findings.reject("TIS403", message, clauses[0].span.to(clauses[1].span))
            case ["until"]:
                stop = self.conditions.time(clauses[0].value)
            case _:
                self.findings.reject(
                    "TIS303", f'unexpected "{clauses[0].word}"', clauses[0].span,
                    hint="an interval is from T to T, or until T",
                )  # fmt: skip
        log = self._request(name, quantity, every, call.span)
        unit = si_unit(quantity.dimension)
        kind = call.function.key
        return StudyMeasure(name, unit, quantity.dimension, kind, log, None, start, stop)

    def _request(
        self, name: str, quantity: ObservedExpression, every: float, span: Span
    ) -> LogRequest:
        measure: Any = quantity  # has the methods of a measure
        return LogRequest(f"measure {name}", measure, (), every, span)

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

    def _event(self, name: str, kind: s.Name, owners: Sequence[s.Clause]) -> StudyMeasure:
        """Return the time of the first event of a kind."""
        if kind.key not in EVENTS:
            self.findings.reject(
                "TIS701", f'there are no events of the kind "{kind.text}"', kind.span,
                hint=alternatives(kind.key, EVENTS, what="kinds"),
            )  # fmt: skip
        springs = None
        for owner in owners:
            subject = s.as_name(owner.value)
            if owner.word != "of" or subject is None:
                self.findings.reject("TIS303", f'unexpected "{owner.word}"', owner.span)
            springs = self.groups.springs(subject).indices
            if not self.groups.is_springs(subject):
                nodes = self.groups.nodes(subject).indices
                springs = np.append(springs, self.network.marks_within(nodes))
        return StudyMeasure(name, "s", TIME, EVENT, event=kind.key, springs=springs)

    # --- parts --------------------------------------------------------------------------------

    def _usual_rate(self, quantity: ObservedExpression) -> float:
        """Return the time between samples [s]: that of a log of the same, or a part of all."""
        for reading in quantity.readings.values():
            for log in self.plan.output.logs:
                same = [subject.name for subject in reading.subjects]
                if log.measure is reading.measure and [x.name for x in log.subjects] == same:
                    return log.every
        return self.duration / SAMPLES if math.isfinite(self.duration) else 1.0

    def _every(self, node: s.Expression) -> float:
        value = self.scope.number(node)
        self.scope.expect(value, TIME, node.span, what="the time between samples")
        every = float(value.amount)
        if not every > 0.0 or (
            math.isfinite(self.duration) and self.duration / every > MOST_SAMPLES
        ):
            message = f"the time between samples cannot be {value}"
            self.findings.reject("TIS308", message, node.span)
        return every


def _event(
    value: s.Expression, clauses: Sequence[s.Clause]
) -> tuple[s.Name, Sequence[s.Clause]] | None:
    """Return the kind of event whose time is measured, and of what; None for other measures."""
    if isinstance(value, s.Name) and value.key == EVENT and clauses:
        first, *owners = clauses
        if first.word == "of" and isinstance(first.value, s.Name):
            return first.value, owners
    if isinstance(value, s.Call) and value.function.key == EVENT and not clauses:
        first = value.arguments[0] if len(value.arguments) == 1 else None
        if first is not None and isinstance(first.value, s.Name):
            return first.value, first.clauses
    return None


def _is_aggregate(call: s.Call) -> bool:
    """Return whether a call is a value over time, and no function of several numbers."""
    return call.function.key in AGGREGATES and len(call.arguments) == 1
