"""The output block: trajectories, blocks, smooth surfaces, logs, energies, storage."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Never

import numpy as np
from msgspec.structs import replace

from tissuec.compiler.measures.conditions import COUNT, COUNTED, LEDGER, Conditions
from tissuec.compiler.measures.quantities import QuantityReader
from tissuec.compiler.output.smoothing import SURFACE, read_surface
from tissuec.compiler.sets import Groups
from tissuec.core.hints import Edit, Hint, alternatives, proposal
from tissuec.core.precision import PRECISIONS, SINGLE
from tissuec.core.source import Span
from tissuec.core.units import FREQUENCY, TIME, parse_unit, show
from tissuec.lang import syntax as s
from tissuec.meshes.generators import Mesh
from tissuec.model.network import Indices
from tissuec.scene.reading.expressions import Scope
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.plan import LogRequest, Output, SurfaceOutput

_FORCE_ALONG = "for a component, write: force(A along (1, 0, 0)) every 10 ms"

_CLAUSES = ("of", "to", "every")
MOST_SAMPLES = 100_000_000


class OutputReader:
    """Reads the items of an output block.

    Args:
        nodes: How many nodes frames can show.
        duration: Of the run [s].
        idle: Springs that logs pass over.
    """

    def __init__(
        self,
        groups: Groups,
        conditions: Conditions,
        scope: Scope,
        *,
        nodes: int,
        duration: float,
        idle: Indices,
    ):
        self.groups = groups
        self.conditions = conditions
        self.scope = scope
        self.findings = scope.findings
        self.node_count = nodes
        self.duration = duration
        self.idle = idle
        self.places: dict[str, Span] = {}
        self.about_frames = set[str]()  # words without an error that need frames
        self.frames: Indices = np.zeros(0, dtype=np.int64)
        self.every = math.inf
        self.energy = math.inf
        self.single = False
        self.blocks = False
        self.compress = False
        self.asked: dict[str, Span] = {}
        self.logs: list[LogRequest] = []
        self.surfaces: list[SurfaceOutput] = []

    def read(self, items: Sequence[s.Item]) -> Output:
        """Return the recording; each error rejects one sentence only."""
        for item in items:
            with self.findings.item():
                self._item(item)
        written = {one.name.key for one in items if isinstance(one, s.Sentence | s.Block)}
        self._require_frames(written)
        logs, surfaces = tuple(self.logs), tuple(self.surfaces)
        return Output(
            self.frames, self.every, self.single, logs, self.energy, surfaces, self.blocks,
            self.compress, tuple(self.asked),
        )  # fmt: skip

    def _require_frames(self, written: Collection[str]) -> None:
        """Report words about frames where there are none.

        Args:
            written: Names of all outputs, wrong ones included.
        """
        if "trajectory" in written:
            return
        needs = {"blocks": "blocks needs a trajectory, whose frames it shows"}
        if SURFACE not in written:
            needs |= {
                "compress": "compress needs a trajectory or a surface, which it makes smaller",
                "precision": "precision needs a trajectory or a surface, which it rounds",
            }
        for word, message in needs.items():
            if word in self.about_frames:
                hint = "for example: trajectory every 10 ms"
                self.findings.add("TIS304", message, self.places[word], hint=hint)

    def _item(self, item: s.Item) -> None:
        if isinstance(item, s.Sentence | s.Block) and item.name.key == SURFACE:
            self._surface(item, self._clauses(item))
            return
        if isinstance(item, s.RecordedCall):
            self._recording(item)
            return
        if not isinstance(item, s.Sentence):
            self.findings.reject(
                "TIS312", "an output has the form: force(forceps A) every 1 ms", item.span
            )
        key = item.name.key
        clauses = self._clauses(item)
        if item.phrase is not None and key != "precision":
            self._chosen(item, item.phrase)
        if key == "precision":
            self._precision(item)
        elif key == "blocks":
            self._alone(item, "it shows the frames of the trajectory")
            self.blocks = True
        elif key == "compress":
            self._alone(item, "it applies to all frames and surfaces")
            self.compress = True
        elif key == "trajectory":
            self._trajectory(item, clauses)
        elif key == "energy" and "of" not in clauses:
            self._once("energy", item)
            self.energy = self._rate(item, clauses)
            self.conditions.needs_ledger = True
        elif key in MEASURES:
            self._log(item, clauses)
        else:
            known = ("trajectory", "precision", "compress", "blocks", SURFACE, *MEASURES)
            self.findings.reject(
                "TIS701",
                f'"{item.name.text}" is not an output',
                item.name.span,
                hint=alternatives(key, known, what="outputs"),
            )

    def _surface(self, item: s.Sentence | s.Block, clauses: dict[str, s.Clause]) -> None:
        if "of" not in clauses:
            text, hint = 'surface needs "of"', "for example: surface of BODY every 40 ms"
            self.findings.reject("TIS304", text, item.span, hint=hint)
        every = self._rate(item, clauses)
        for name in self._names(clauses["of"]):
            with self.findings.item():
                mesh, body = self._drawn(name)
                self._once(f"surface of {body}", item)
                kind, smoothing = read_surface(item, name, body, mesh, self.scope)
                self.surfaces.append(SurfaceOutput(body, kind, smoothing, every, item.span))

    def _drawn(self, name: s.Name) -> tuple[Mesh, str]:
        """Return the mesh of a body, and its name as it was declared."""
        group = self.groups.nodes(name)
        if name.key in self.groups.bodies:
            return self.groups.bodies[name.key].drawing.mesh, group.name
        bodies = [
            placed.drawing.body.name
            for placed in self.groups.bodies.values()
            if np.isin(group.indices, placed.nodes).any()
        ]
        self.findings.reject(
            "TIS704",
            f"{group.name} is a set; only bodies have surfaces",
            name.span,
            hint=Hint(f"write surface of {' or of '.join(bodies)}", *map(Edit, bodies)),
        )

    def _clauses(self, item: s.Sentence | s.Block) -> dict[str, s.Clause]:
        """Return the clauses of an output by their words; those without a meaning reject it."""
        clauses: dict[str, s.Clause] = {}
        known = _clause_words(item.name.key)
        for clause in item.clauses:
            if clause.word in _CLAUSES and clause.word not in known:
                self._without_meaning(item, clause, has_of="of" not in known or "of" in clauses)
            if clause.word not in known or clause.word in clauses:
                subject = clause.span.one_line.removeprefix(f"{clause.word} ")
                hint = "" if "of" in clauses else proposal(f"of {subject}")
                hint = self._rate_meant(clause) or hint
                message = f'"{clause.word}" is not allowed in an output'
                self.findings.reject("TIS303", message, clause.span, hint=hint)
            clauses[clause.word] = clause
        return clauses

    def _without_meaning(
        self, item: s.Sentence | s.Block, clause: s.Clause, *, has_of: bool
    ) -> Never:
        """Reject a clause that other outputs have."""
        subject = clause.span.one_line.removeprefix(f"{clause.word} ")
        hint = (
            Hint("leave it out", Edit("", clause.span)) if has_of else proposal(f"of {subject}")
        )
        message = f'"{clause.word}" has no meaning in {item.name.text}'
        self.findings.reject("TIS303", message, clause.span, hint=hint)

    def _chosen(self, item: s.Sentence, phrase: s.Predicate) -> Never:
        """Reject an output with a choice, such as "trajectory is liver"."""
        place = Span(item.span.source, item.name.span.end, phrase.span.end)
        has_of = any(clause.word == "of" for clause in item.clauses)
        takes = "of" in _clause_words(item.name.key) and not has_of
        hint = Hint("leave it out", Edit("", place))
        if takes:
            text = f"{item.name.text} of {phrase.span.text.removeprefix('is ')}"
            hint = proposal(text, Span(item.span.source, item.name.span.start, place.end))
        message = f'"is" is not allowed in {item.name.text}'
        self.findings.reject("TIS303", message, phrase.span, hint=hint)

    def _rate_meant(self, clause: s.Clause) -> Hint | str:
        """Return a hint for ``at 1 kHz``, and for ``at 1 ms`` where "every" was meant."""
        value = clause.value
        if clause.word == "along":
            return _FORCE_ALONG
        if clause.word not in ("at", "per", "after"):
            return ""
        if not isinstance(value, s.Quantity):
            return "write how often, such as: every 10 ms; a log has the end of the run, too"
        unit = parse_unit(value.unit)
        amount = value.value * unit.factor
        if unit.dimension == TIME:
            return proposal(f"every {value.span.text}")
        if unit.dimension != FREQUENCY or amount <= 0.0:
            return ""
        return proposal(f"every {show(1.0 / amount, TIME, digits=6)}")

    def _once(self, key: str, item: s.Sentence | s.Block | s.RecordedCall) -> None:
        if key in self.places:
            hint = (
                "list several bodies: trajectory of [A, B] every 10 ms"
                if key == "trajectory"
                else ""
            )
            self.findings.refuse_second(f'"{key}"', item.span, self.places[key], hint=hint)
        self.places[key] = item.span

    def _precision(self, item: s.Sentence) -> None:
        self._once("precision", item)
        word = item.phrase.words[0].key if item.phrase and item.phrase.kind == "word" else ""
        if word not in PRECISIONS:
            self.findings.reject("TIS305", "precision is single or double", item.span)
        self.single = word == SINGLE
        self.about_frames.add("precision")

    def _alone(self, item: s.Sentence, why: str) -> None:
        """Reject a word with anything behind it."""
        word = item.name.key
        self._once(word, item)
        if item.span != item.name.span:
            self.findings.reject(
                "TIS303",
                f"nothing can follow {word}: {why}",
                item.span,
                hint=proposal(word),
            )
        self.about_frames.add(word)

    def _trajectory(self, item: s.Sentence, clauses: dict[str, s.Clause]) -> None:
        self._once("trajectory", item)
        self.every = self._rate(item, clauses)
        if "of" in clauses:
            groups = [self.groups.nodes(name) for name in self._names(clauses["of"])]
            self.frames = np.unique(np.concatenate([group.indices for group in groups]))
        else:
            self.frames = np.arange(self.node_count)
        if "with" in clauses:
            from tissuec.compiler.output.frame_fields import (
                asked_fields,  # where any are asked for
            )

            self.asked = asked_fields(self._names(clauses["with"]), self.findings)

    def _log(self, item: s.Sentence, clauses: dict[str, s.Clause]) -> None:
        if MEASURES[item.name.key].subjects > 1 and "to" not in clauses:
            names = self._names(clauses["of"]) if "of" in clauses else []
        else:
            names = [self._name(clauses[word]) for word in ("of", "to") if word in clauses]
        self._log_of(item, item.name.key, names, clauses)

    def _log_of(
        self,
        item: s.Sentence | s.RecordedCall,
        key: str,
        names: Sequence[s.Name],
        clauses: Mapping[str, s.Clause],
    ) -> None:
        """Add the log of a measure.

        Args:
            item: The output.
            key: Of the measure.
            names: What is measured.
            clauses: Of the output, by their words.
        """
        measure = MEASURES[key]
        if len(names) != measure.subjects:
            self.findings.reject(
                "TIS702",
                f"wrong form of {item.name.text}",
                item.span,
                hint=f"write: {measure.form} every 10 ms",
            )
        every = self._rate(item, clauses)
        subjects = self.conditions.log_subjects(measure, names)
        if measure.takes == "springs":
            subjects = tuple(self._without_idle(subject) for subject in subjects)
        self.conditions.needs_ledger |= key == LEDGER
        name = " to ".join(subject.name for subject in subjects)
        title = f"{key} of {name}" if name else key
        self._once(title, item)
        self.logs.append(LogRequest(title, measure, subjects, every, item.span))

    def _recording(self, item: s.RecordedCall) -> None:
        """Read a measure that is written as in conditions: ``force(A along (1, 0, 0))``."""
        key, clauses = item.name.key, dict[str, s.Clause]()
        for clause in item.clauses:
            if clause.word != "every" or clause.word in clauses:
                hint = self._rate_meant(clause)
                if clause.word == "along":
                    along = f"{item.call.span.text[:-1]} {clause.span.text})"
                    hint = Hint(
                        f"a direction is written inside the parentheses: {along}",
                        Edit(along, item.call.span.to(clause.span)),
                    )
                message = f'"{clause.word}" is not allowed in an output'
                self.findings.reject("TIS303", message, clause.span, hint=hint)
            clauses[clause.word] = clause
        if key in ("trajectory", SURFACE):
            bodies = ", ".join(one.span.one_line for one in item.call.arguments)
            hint = proposal(f"{key} of {bodies}", item.call.span)
            self.findings.reject(
                "TIS312", f"{key} has no parentheses", item.call.span, hint=hint
            )
        if key not in MEASURES and key != COUNT:
            self.findings.reject(
                "TIS701",
                f'"{item.name.text}" is not a measure',
                item.name.span,
                hint=alternatives(key, MEASURES, what="measures"),
            )
        arguments = item.call.arguments
        match arguments:
            case (s.Argument(s.Name(key=counted), (s.Clause("of", s.Name() as of),)),):
                if key == COUNT and counted in COUNTED:
                    self._log_of(item, counted, [of], clauses)
                    return
            case _:
                pass
        named = (s.as_name(one.value) for one in arguments if not one.clauses)
        names = [name for name in named if name is not None]
        if key in MEASURES and len(names) == len(arguments):
            self._log_of(item, key, names, clauses)
            return
        every = self._rate(item, clauses)
        quantity = QuantityReader(self.conditions).read(item.call)
        if any(reading.time is not None for reading in quantity.readings.values()):
            message = "an output is taken over the whole run and cannot name a time"
            self.findings.reject("TIS702", message, item.call.span)
        of = " to ".join(one.span.one_line for one in arguments)
        title = f"{item.name.key} of {of}"
        self._once(title, item)
        measure: Any = quantity  # has the methods of a measure
        self.logs.append(LogRequest(title, measure, (), every, item.span))

    def _without_idle(self, subject: Subject) -> Subject:
        is_idle = np.isin(subject.springs, self.idle)
        return replace(subject, springs=subject.springs[~is_idle])

    def _name(self, clause: s.Clause) -> s.Name:
        """Return a name, or several as that of their union."""
        name = s.as_name(clause.value)
        if name is None:
            self.findings.reject(
                "TIS312", "a name, or a list of names, is needed here", clause.value.span
            )
        return name

    def _names(self, clause: s.Clause) -> list[s.Name]:
        parts = clause.value.items if isinstance(clause.value, s.Listing) else (clause.value,)
        names = [part for part in parts if isinstance(part, s.Name)]
        if not names or len(names) != len(parts):
            self.findings.reject(
                "TIS312", "a name, or a list of names, is needed here", clause.value.span
            )
        return names

    def _rate(
        self, item: s.Sentence | s.Block | s.RecordedCall, clauses: Mapping[str, s.Clause]
    ) -> float:
        if "every" not in clauses:
            self.findings.reject(
                "TIS304",
                f'{item.name.text} needs "every"',
                item.span,
                hint=Hint(
                    f"for example: {_head(item)} every 10 ms",
                    Edit(f"{_head(item)} every 10 ms", old=_head(item)),
                ),
            )
        node = clauses["every"].value
        value = self.scope.number(node)
        self.scope.expect(value, TIME, node.span, what="the time between outputs")
        every = float(value.amount)
        if every <= 0.0:
            message = f"the time between outputs must be above 0 s, not {value}"
            hint = Hint("for example: every 10 ms", Edit("10 ms"))
            self.findings.reject("TIS308", message, node.span, hint=hint)
        if math.isfinite(self.duration) and self.duration / every > MOST_SAMPLES:
            self.findings.reject(
                "TIS308",
                f"a sample every {node.span.text} for {show(self.duration, TIME)} gives too "
                "many samples",
                node.span,
                hint="the shortest possible time is "
                f"{show(self.duration / MOST_SAMPLES, TIME)}",
            )
        if every > self.duration * (1 + 1e-12):
            self.findings.add(
                "W405",
                f"a sample every {node.span.text}, but the run ends at "
                f"{show(self.duration, TIME)}: only the start is recorded",
                node.span,
                hint="write a shorter time after every, or a longer duration in simulate",
            )
        return every


def _clause_words(key: str) -> tuple[str, ...]:
    """Return the words of the clauses that an output has; all of them if it is unknown."""
    if key == "precision":
        return ()
    if key == "trajectory":
        return "of", "with", "every"
    if key == SURFACE:
        return "of", "every"
    if key in MEASURES:
        return (*("of", "to")[: MEASURES[key].subjects], "every")
    return _CLAUSES


def _head(item: s.Sentence | s.Block | s.RecordedCall) -> str:
    """Return what stands before the braces of an output."""
    return (item.head if isinstance(item, s.Block) else item.span).text
