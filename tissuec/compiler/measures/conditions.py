"""Conditions of a run: expressions over measures, checked now and evaluated later."""

from collections.abc import Mapping, Sequence
from typing import Any

from tissuec.compiler.measures.observed import (
    CompiledCondition,
    MeasureScope,
    ObservedMeasure,
    Place,
    place_of,
)
from tissuec.compiler.measures.subject_reader import SubjectReader
from tissuec.compiler.sets import Groups
from tissuec.core.errors import enumerated
from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean, proposal
from tissuec.core.source import Span
from tissuec.core.units import NUMBER, TIME, show
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.lang.words import written_name
from tissuec.model.network import Floats
from tissuec.scene.model import Scene
from tissuec.scene.reading.expressions import FUNCTIONS
from tissuec.scene.reading.spellings import COUNT, COUNTED
from tissuec.scene.reading.values import unit_vector
from tissuec.scene.sentences import (
    ExpectedAt,
    ExpectedOver,
    ExpectedUntil,
    ExpectedWithin,
    read_expect,
)
from tissuec.script.measures import MEASURES, Measure, Subject
from tissuec.script.measures.common import is_directed
from tissuec.script.measures.cut_faces import CUT_FACES
from tissuec.script.measures.statistics import PERCENTILE, STATISTICS, form_of
from tissuec.script.plan import Condition, Expectation

_NEAR = 0.01  # of a number: half of the range that is proposed in place of it
#: What could be taken for a measure, and what to write instead.
NOT_MEASURED = {
    "track": "in a learn block write: fit = positions(A) using columns …, "
    "and then: expect error(held out) < 8 %",
    "error": "it is available after learning: expect error(held out) < 8 %",
    "positions": "it is for learn blocks: fit = positions(A); for a single position, use "
    "position(A)",
}


class Conditions:
    """Turns conditions of ``when`` and ``expect`` into functions of a snapshot.

    Args:
        groups: The sets and bodies.
        scene: The scene.
    """

    def __init__(self, groups: Groups, scene: Scene):
        self.groups = groups
        self.tools = scene.tools
        self.scope = scene.constants
        self.findings = scene.constants.findings
        self.duration = scene.simulation.duration
        self.subjects = SubjectReader(groups, scene)
        self.needs_ledger = False

    def condition(self, node: s.Expression) -> Condition:
        """Return a condition on the present only; rejects pinned times."""
        readings = self.readings(node)
        for reading in readings.values():
            if reading.needs_ledger:
                self.findings.reject(
                    "TIS702",
                    "when cannot wait for the energy drift, which is known only after a step",
                    node.span,
                    hint="write instead: expect energy drift < 1 % over run",
                )
            if reading.time is not None:
                self.findings.reject(
                    "TIS702",
                    "a when condition refers to the present and cannot name a time",
                    node.span,
                )
        return self._judgement(node, readings)

    def expectation(self, item: s.Expect) -> Expectation:
        """Return an ``expect`` clause with its interval."""
        readings = self.readings(item.condition)
        judgement = self._judgement(item.condition, readings)
        pinned = tuple(sorted({r.time for r in readings.values() if r.time is not None}))
        if not item.clauses and readings and all(r.time is not None for r in readings.values()):
            start = stop = pinned[-1]  # every measure says its own time
        else:
            start, stop = self._interval(item)
        if pinned and pinned[-1] > start:
            self.findings.reject(
                "TIS703",
                f"{show(pinned[-1], TIME)} is later than {show(start, TIME)}",
                item.condition.span,
            )

        return Expectation(
            judgement, judgement.describe, start, stop, pinned, item.span, judgement
        )

    def reading(self, node: s.Call | s.Name) -> ObservedMeasure:
        """Return a measure with its subjects, or reject it."""
        if isinstance(node, s.Call):
            return self._read(node.function.key, node, node.arguments)
        return self._read(node.key, node, ())

    def log_subjects(
        self, measure: type[Measure], names: Sequence[s.Name]
    ) -> tuple[Subject, ...]:
        """Return the subjects of a measure in an output sentence."""
        subjects = tuple(self.subjects.subject(measure, name) for name in names)
        if names:
            self._refuse_same(measure, subjects, names[-1].span)
        return subjects

    def _refuse_same(
        self, measure: type[Measure], subjects: Sequence[Subject], span: Span
    ) -> None:
        """Reject the distance of something from itself."""
        if len(subjects) == 2 and subjects[0].name == subjects[1].name:
            message = f"{measure.form} is always 0: both are {subjects[0].name}"
            self.findings.reject("TIS702", message, span, hint="name two sets or bodies")

    def _judgement(
        self, node: s.Expression, readings: Mapping[Place, ObservedMeasure]
    ) -> CompiledCondition:
        truth = MeasureScope(readings, self.scope, None).decide(node)
        if truth.ndim:
            self.findings.reject(
                "TIS312", "a condition compares single numbers, not vectors", node.span
            )
        self._check_limits(node, readings)
        self._doubt_signs(node, readings)
        self._doubt_equality(node, readings)
        return CompiledCondition(node, readings, self.scope)

    def _check_limits(
        self, node: s.Expression, readings: Mapping[Place, ObservedMeasure]
    ) -> None:
        """Reject limits of which the lower one is above the upper one, if none is measured."""
        for part in walk(node):
            if not isinstance(part, s.Between):
                continue
            limits = part.low, part.high
            inside = (one for one in walk(limits) if isinstance(one, s.Call | s.Name))
            if any(place_of(one) in readings for one in inside):
                continue
            low, high = (self.scope.number(limit) for limit in limits)
            if low.amount > high.amount:
                self.scope.refuse_reversed(part.low.span, part.high.span)

    def _doubt_signs(
        self, node: s.Expression, readings: Mapping[Place, ObservedMeasure]
    ) -> None:
        """W701: a magnitude of a vector or a stress is compared so that nothing is said."""
        for part in walk(node):
            if not isinstance(part, s.Compare):
                continue
            for side, other in ((part.left, part.right), (part.right, part.left)):
                reading = readings.get(place_of(side))
                if reading is None or reading.along is not None:
                    continue
                is_vector = is_directed(reading.measure)
                is_fixed = not any(place_of(one) in readings for one in walk(other))
                if not is_vector or not is_fixed:
                    continue
                limit = float(self.scope.number(other).amount)
                at_zero = (">=", "<") if side is part.left else ("<=", ">")
                if limit < 0.0 or (limit == 0.0 and part.sign in at_zero):
                    (subject,) = reading.subjects
                    text = side.span.one_line
                    component = text.replace(subject.name, f"{subject.name} along (0, 0, 1)")
                    self.findings.add(
                        "W701", f"{text} is a magnitude, which is never negative", part.span,
                        hint=f"for a component, write a direction: {component}",
                    )  # fmt: skip

    def _doubt_equality(
        self, node: s.Expression, readings: Mapping[Place, ObservedMeasure]
    ) -> None:
        """W702: a measured real number is compared with exactly one number.

        Zero is left out: the force of what touches nothing, and the speed of what is held, are
        exactly 0.
        """
        for part in walk(node):
            if not isinstance(part, s.Compare) or part.sign not in ("==", "!="):
                continue
            for side, other in ((part.left, part.right), (part.right, part.left)):
                reading = readings.get(place_of(side))
                if reading is None or getattr(reading.measure, "counts", False):
                    continue
                is_fixed = not any(place_of(one) in readings for one in walk(other))
                if not is_fixed or (value := float(self.scope.number(other).amount)) == 0.0:
                    continue
                text, dimension = side.span.one_line, reading.measure.dimension
                near = sorted((value * (1.0 - _NEAR), value * (1.0 + _NEAR)))
                between = " and ".join(show(one, dimension, digits=4) for one in near)
                often, meant = "hardly ever", f"{text} between {between}"
                if part.sign == "!=":
                    often, meant = "nearly always", f"not ({meant})"
                message = f'"{part.sign}" is {often} true of a measured number, {text}'
                hint = f"write a range, such as {meant}"
                self.findings.add("W702", message, part.span, hint=hint)

    # --- measures -----------------------------------------------------------------------------

    def readings(self, node: s.Expression) -> dict[Place, ObservedMeasure]:
        """Return every measure in a condition by the place of its node."""
        readings: dict[Place, ObservedMeasure] = {}
        described = set[Place]()  # what a clause says more of, such as "force of hook"
        for part in walk(node, enters=_is_mathematical):
            match part:
                case s.Name(key=key) if key in MEASURES and MEASURES[key].subjects == 0:
                    readings[place_of(part)] = self._read(key, part, ())
                case s.Argument(clauses=(_, *_)):
                    described.add(place_of(part.value))
                case s.Name() if place_of(part) not in described and not self.scope.has(part):
                    self._refuse_bare(part)
                case s.Call() if not _is_mathematical(part):
                    reading = self._read(part.function.key, part, part.arguments)
                    readings[place_of(part)] = reading
                case _:
                    pass
        return readings

    def _read(
        self, key: str, node: s.Call | s.Name, arguments: Sequence[s.Argument]
    ) -> ObservedMeasure:
        if key == COUNT:
            key, arguments = self._counted(node, arguments)
        measure: Any = MEASURES.get(key)
        if key in STATISTICS:
            measure, arguments = self._statistic(key, node, arguments)
        if measure is None:
            name = node.function if isinstance(node, s.Call) else node
            self._refuse_mistaken(name)
            self.findings.reject(
                "TIS701",
                f'"{name.text}" is not a measure',
                name.span,
                hint=_aggregate_meant(name)
                or alternatives(
                    key,
                    (COUNT, *STATISTICS, *(name for name in MEASURES if name not in COUNTED)),
                    what="measures",
                ),
            )
        arguments = self._of_cut_faces(measure, arguments)
        time, along, subjects = None, None, list[Subject]()
        for argument in arguments:
            if isinstance(argument.value, s.Call):
                self._refuse_mistaken(argument.value.function)
            name = s.as_name(argument.value)
            if name is not None and self.subjects.is_subject(name):
                subject = self.subjects.subject(measure, name)
                if (
                    at := next((c for c in argument.clauses if c.word == "at"), None)
                ) is not None:
                    subject = self.subjects.point(measure, name, at)
                    others = tuple(one for one in argument.clauses if one is not at)
                    argument = s.Argument(argument.value, others, argument.span)
                subjects.append(subject)
                along = self._along(argument, key, measure) if argument.clauses else along
            elif time is None and len(subjects) == measure.subjects and not argument.clauses:
                time = self._pinned(argument)
            else:
                self.subjects.refuse_unknown(argument)
        if len(subjects) != measure.subjects:
            hint = f"the form is {measure.form}"
            self.findings.reject("TIS702", f"wrong form of {key}", node.span, hint=hint)
        self._refuse_same(measure, subjects, node.span)
        found = ObservedMeasure(measure, tuple(subjects), time, along)
        self.needs_ledger |= found.needs_ledger
        return found

    def _refuse_bare(self, name: s.Name) -> None:
        """Reject a measure without subject, such as ``energy``, and a misspelt one."""
        meant = [
            measure
            for key, measure in MEASURES.items()
            if name.key in (key, measure.form.partition("(")[0])
        ]
        if not meant:
            near = did_you_mean(name.key, MEASURES)
            if near and not did_you_mean(name.text, self.scope.names()):
                message = f'"{name.text}" is not a measure'
                self.findings.reject("TIS701", message, name.span, hint=near)
            return
        first, bodies = meant[0], self.groups.names_of_bodies()
        hint = Hint(f"write {', or '.join(measure.form for measure in meant)}")
        if len(meant) == 1 == first.subjects and first.takes != "jaws" and bodies:
            example = first.form.replace("A)", f"{written_name(bodies[0])})")
            hint = Hint(f"write {example}", Edit(example))
        message = f'"{name.text}" does not say what it is measured on'
        self.findings.reject("TIS702", message, name.span, hint=hint)

    def _refuse_mistaken(self, name: s.Name) -> None:
        """Reject what could be taken for a measure, and is none."""
        if name.key in NOT_MEASURED:
            message = f'"{name.text}" is not a measure'
            self.findings.reject("TIS701", message, name.span, hint=NOT_MEASURED[name.key])

    def _counted(
        self, node: s.Call | s.Name, arguments: Sequence[s.Argument]
    ) -> tuple[str, list[s.Argument]]:
        """Return ``count(nodes of oviduct)`` as the measure "nodes" of oviduct."""
        first = arguments[0] if arguments else None
        what = first.value.key if first is not None and isinstance(first.value, s.Name) else ""
        if first is None or what not in COUNTED or [c.word for c in first.clauses] != ["of"]:
            self.findings.reject(
                "TIS702",
                "wrong form of count",
                node.span,
                hint="forms: " + ", ".join(f"count({one} of A)" for one in COUNTED),
            )
        return what, [s.Argument(first.clauses[0].value, (), first.span), *arguments[1:]]

    def _of_cut_faces(
        self, measure: type[Measure], arguments: Sequence[s.Argument]
    ) -> Sequence[s.Argument]:
        """Return the arguments, ``cut faces of liver`` as ``liver``."""
        if not arguments:
            return arguments
        first, needs = arguments[0], measure.takes == CUT_FACES
        clauses, name = {each.word: each for each in first.clauses}, s.as_name(first.value)
        says = name is not None and name.key == CUT_FACES and "of" in clauses
        if not says and not needs:
            return arguments
        if says and needs and len(clauses) == 1:
            return [s.Argument(clauses["of"].value, (), first.span), *arguments[1:]]
        if needs:
            named = s.as_name(clauses["of"].value) if "of" in clauses else name
            bodies = self.groups.names_of_bodies()
            known = named is not None and named.key in self.groups.bodies
            body = named.text if known else bodies[0] if len(bodies) == 1 else "BODY"
            self.findings.reject(
                "TIS702", f"wrong form of {measure.form.partition('(')[0]}", first.span,
                hint=proposal(f"{CUT_FACES} of {body}"),
            )  # fmt: skip
        forms = [one.form for one in MEASURES.values() if one.takes == CUT_FACES]
        message = f"{measure.form} is not taken of faces of cuts"
        hint = f"write {enumerated(forms, 'or')}"
        self.findings.reject("TIS702", message, first.span, hint=hint)

    def _statistic(
        self, key: str, node: s.Call | s.Name, arguments: Sequence[s.Argument]
    ) -> tuple[object, list[s.Argument]]:
        """Return ``largest(FIELD of A)`` as a measure of A."""
        from tissuec.compiler.measures import statistics  # takes long to import

        first, *rest = arguments or (None,)
        words = [] if first is None else [clause.word for clause in first.clauses]
        needed = 1 if key == PERCENTILE else 0
        if first is None or words != ["of"] or len(rest) < needed:
            hint = f"the form is {form_of(key)}, such as {form_of(key, 'von Mises stress')}"
            if first is not None and isinstance(first.value, s.Call) and key in _OVER_TIME:
                hint += f"; over time, a study has {_OVER_TIME[key]}({first.span.one_line})"
            self.findings.reject("TIS702", f"wrong form of {key}", node.span, hint=hint)
        field = first.value
        name = statistics.field_called(s.key_of(field.span.one_line))
        if not name:
            text, known = field.span.one_line, statistics.names_of_fields()
            hint = _FIELDS_MEANT.get(s.key_of(text)) or alternatives(text, known, what="fields")
            self.findings.reject("TIS701", f'"{text}" is not a field', field.span, hint=hint)
        of, share = s.Argument(first.clauses[0].value, (), first.span), 0.0
        if needed:
            share = self._share(rest.pop(0))
        return statistics.FieldStatistic(key, name, share), [of, *rest]

    def _share(self, argument: s.Argument) -> float:
        """Return the part of the volume that a percentile is about, or reject it."""
        value, span = self.scope.number(argument.value), argument.span
        self.scope.expect(value, NUMBER, span, what="the part of a percentile")
        share = float(value.amount)
        if not 0.0 <= share <= 1.0:
            hint = proposal(f"{span.text} %") if 1.0 < share <= 100.0 else ""
            message = f"a percentile is between 0 % and 100 %, not {100.0 * share:g} %"
            self.findings.reject("TIS308", message, span, hint=hint)
        return share

    def _along(self, argument: s.Argument, key: str, measure: type[Measure]) -> Floats:
        clause = argument.clauses[0]
        value = self.scope.evaluate(clause.value)
        if (
            clause.word != "along"
            or len(argument.clauses) > 1
            or not value.is_vector
            or value.dimension != NUMBER
            or (direction := unit_vector(value.amount)) is None
        ):
            self.findings.reject(
                "TIS702",
                f"only a direction is allowed after {argument.value.span.text}: "
                "along (0, 0, 1)",
                clause.span,
            )
        if not is_directed(measure):
            names = [name for name, one in MEASURES.items() if is_directed(one)]
            hint = f"{enumerated(names, 'and')} have a direction"
            self.findings.reject(
                "TIS702", f"{key} is a single number and has no direction", clause.span,
                hint=Hint(f'remove "{clause.span.one_line}": only {hint}', Edit("")),
            )  # fmt: skip
        return direction

    def _pinned(self, argument: s.Argument) -> float:
        if isinstance(argument.value, s.Name) and not self.scope.has(argument.value):
            self.subjects.refuse_unknown(argument)
        return self.time(argument.value)

    # --- times --------------------------------------------------------------------------------

    def _interval(self, item: s.Expect) -> tuple[float, float]:
        match read_expect(item, self.scope):
            case ExpectedAt(time=node):
                time = self.time(node)
                return time, time
            case ExpectedWithin(start=first, stop=last):
                start, stop = self.time(first), self.time(last)
                if start > stop:
                    begin, end = first.span.text, last.span.text
                    self.findings.reject(
                        "TIS403",
                        f"the interval from {begin} to {end} ends before it begins",
                        item.clauses[0].span.to(item.clauses[1].span),
                        hint=proposal(f"from {end} to {begin}"),
                    )
                return start, stop
            case ExpectedUntil(stop=last):
                return 0.0, self.time(last)
            case ExpectedOver():
                return 0.0, self.duration

    def time(self, node: s.Expression) -> float:
        """Return a time within the run [s], or reject it."""
        value = self.scope.number(node)
        self.scope.expect(value, TIME, node.span, what="the time")
        time = float(value.amount)
        if not 0.0 <= time <= self.duration * (1 + 1e-12):
            self.findings.reject(
                "TIS703",
                f"{show(time, TIME)} is not within the run of {show(self.duration, TIME)}",
                node.span,
                hint="write an earlier time, or a longer duration in simulate"
                if time > 0.0
                else "the run begins at 0 s",
            )
        return min(time, self.duration)


def _is_mathematical(call: s.Call) -> bool:
    return call.function.key in FUNCTIONS


#: Fields by what could be taken for them.
_FIELDS_MEANT = {
    "stress": "write von Mises stress, largest principal stress or smallest principal stress",
    "strain": "write largest principal strain or smallest principal strain",
}
#: What a study calls a statistic over time.
_OVER_TIME = {"largest": "max", "smallest": "min", "average": "mean"}

#: What a study calls the extremes and the mean of a measure, by other words.
_AGGREGATES = {
    "max": "maximum maximal peak highest largest",
    "min": "minimum minimal lowest smallest",
    "mean": "average avg median",
    "final": "last end",
}


def _aggregate_meant(name: s.Name) -> Hint | str:
    """Return a hint with what a study calls an extreme of a measure, or an empty one."""
    first, *rest = name.key.split(" ")
    if first in ("never", "no") and rest:
        return proposal(f"not {' '.join(rest)}")
    meant = next((one for one, words in _AGGREGATES.items() if first in words.split()), "")
    if meant and rest:
        return f"for example: {meant}({' '.join(rest)}(A))"
    return Hint(f'did you mean "{meant}"?', Edit(meant)) if meant else ""
