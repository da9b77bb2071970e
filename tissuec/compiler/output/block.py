"""The output block: trajectories, blocks, smooth surfaces, logs, energies, storage."""

import math
from collections.abc import Collection, Sequence
from typing import Any, NoReturn

import numpy as np

from tissuec.compiler.measures.conditions import Conditions
from tissuec.compiler.measures.quantities import QuantityReader
from tissuec.compiler.output.smoothing import read_surface
from tissuec.compiler.sets import Groups
from tissuec.core.arrays import distinct
from tissuec.core.hints import Edit, Hint, alternatives, proposal
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import FREQUENCY, TIME, parse_unit, show
from tissuec.lang import syntax as s
from tissuec.meshes.generators import Mesh
from tissuec.model.network import Indices
from tissuec.results import SINGLE
from tissuec.scene.output import (
    BLOCKS,
    COMPRESS,
    ENERGY,
    PRECISION,
    SURFACE,
    TRAJECTORY,
    recorded,
)
from tissuec.scene.reading.block_sentences import BlockItems, SentenceReader
from tissuec.scene.reading.clauses import Written, clauses_of
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.spellings import COUNT, COUNTED, in_parentheses
from tissuec.script.measures import MEASURES, Measure, Subject
from tissuec.script.measures.cut_faces import CUT_FACES
from tissuec.script.measures.statistics import STATISTICS
from tissuec.script.plan import LogRequest, Output, SurfaceOutput

MOST_SAMPLES, RATE = 100_000_000, "every 10 ms"


class _OutputSentence(SentenceReader):
    """Reads one output, with hints about clauses that outputs do not have."""

    def hint_without(self, clause: s.Clause) -> Hint:
        value, item = clause.value, self.sentence
        if clause.word == "is" and self.verb == SURFACE:
            every = (
                self.clauses["every"].span.text if "every" in self.clauses else "every 40 ms"
            )
            of = self.clauses["of"].span.text if "of" in self.clauses else "of BODY"
            text = f"{SURFACE} {of} {every} {{ kind is {value.span.text} }}"
            return Hint(f"write its options in braces: {text}", Edit(text, self.span))
        if clause.word == "along" and isinstance(item, s.RecordedCall):
            along = f"{item.call.span.text[:-1]} {clause.span.text})"
            edit = Edit(along, item.call.span.to(clause.span))
            return Hint(f"a direction is written inside the parentheses: {along}", edit)
        if clause.word in ("at", "per", "after"):
            return _rate_meant(clause)
        if not any(self.forms[0].clauses):
            return Hint(f"write only: {self.verb}", Edit(self.verb, self.span))
        takes_of = "of" not in self.clauses and self.forms[0].of_word("of") is not None
        if takes_of:
            return proposal(f"of {value.span.text}", clause.span)
        return super().hint_without(clause)


def _rate_meant(clause: s.Clause) -> Hint:
    """Return a hint for ``at 1 kHz``, and for ``at 1 ms`` where "every" was meant."""
    value = clause.value
    if isinstance(value, s.Quantity):
        unit = parse_unit(value.unit)
        amount = value.value * unit.factor
        if unit.dimension == TIME:
            return proposal(f"every {value.span.text}")
        if unit.dimension == FREQUENCY and amount > 0.0:
            return proposal(f"every {show(1.0 / amount, TIME, digits=6)}")
    return Hint("write how often, such as: every 10 ms; a log has the end of the run, too")


class OutputReader(BlockItems):
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
        super().__init__("output", recorded(), {}, scope)
        self.groups = groups
        self.conditions = conditions
        self.node_count = nodes
        self.duration = duration
        self.idle = idle
        self.frames: Indices = np.zeros(0, dtype=np.int64)
        self.every = math.inf
        self.energy = math.inf
        self.words: set[str] = set()  # of those that stand alone, and single precision
        self.asked: dict[str, Span] = {}
        self.logs: list[LogRequest] = []
        self.surfaces: list[SurfaceOutput] = []

    def read(self, items: Sequence[s.Item]) -> Output:
        """Return the recording; each error rejects one sentence only."""
        for item in items:
            with self.findings.item():
                self._item(in_parentheses(item))
        written = {one.name.key for one in items if isinstance(one, s.Sentence | s.Block)}
        self._require_frames(written)
        logs, surfaces = tuple(self.logs), tuple(self.surfaces)
        return Output(
            self.frames, self.every, SINGLE in self.words, logs, self.energy, surfaces,
            BLOCKS in self.words, COMPRESS in self.words, tuple(self.asked),
        )  # fmt: skip

    def _require_frames(self, written: Collection[str]) -> None:
        """Report words about frames where there are none.

        Args:
            written: Names of all outputs, wrong ones included.
        """
        if TRAJECTORY in written:
            return
        needs = {BLOCKS: "blocks needs a trajectory, whose frames it shows"}
        if SURFACE not in written:
            needs |= {
                COMPRESS: "compress needs a trajectory or a surface, which it makes smaller",
                PRECISION: "precision needs a trajectory or a surface, which it rounds",
            }
        for word, message in needs.items():
            if word in self.words:
                hint = "for example: trajectory every 10 ms"
                self.findings.add("TIS304", message, self.places[word], hint=hint)

    def _item(self, item: s.Item) -> None:
        if isinstance(item, s.RecordedCall):
            self._recording(item)
            return
        if not isinstance(item, s.Sentence | s.Block):
            self.findings.reject(
                "TIS312", "an output has the form: force(forceps A) every 1 ms", item.span
            )
        entry = self.entry(item) or ""
        measure = MEASURES.get(entry)
        if measure is not None and entry != ENERGY and measure.subjects:
            self._refuse_form(item, measure)
        sentence = self._sentence(entry, item)
        match entry:
            case "trajectory":
                self._trajectory(sentence)
            case "surface":
                self._surface(item, sentence)
            case "energy":
                self.energy = self._rate(sentence.get().every, sentence)
                self.conditions.needs_ledger = True
            case "precision":
                self.words |= {PRECISION, sentence.get().kind}
            case "compress" | "blocks":
                sentence.get()
                self.words.add(entry)
            case _:
                self._log(item, entry, ())

    def _sentence(self, entry: str, item: Written) -> _OutputSentence:
        return _OutputSentence(entry, self.kinds[entry], item, self.scope)

    def refuse_name(self, name: s.Name, known: Collection[str]) -> NoReturn:
        message = f'"{name.text}" is not an output'
        hint = alternatives(name.key, known, what="outputs")
        self.findings.reject("TIS701", message, name.span, hint=hint)

    # --- frames and surfaces ------------------------------------------------------------------

    def _trajectory(self, sentence: _OutputSentence) -> None:
        said = sentence.get()
        self.every = self._rate(said.every, sentence)
        self.frames = np.arange(self.node_count)
        if said.of is not None:
            groups = [self.groups.nodes(name).indices for name in said.of]
            self.frames = distinct(np.concatenate(groups))
        if said.fields is not None:  # rarely, and what describes them takes long to import
            from tissuec.compiler.output.frame_fields import asked_fields

            self.asked = asked_fields(said.fields, self.findings)

    def _surface(self, item: s.Sentence | s.Block, sentence: _OutputSentence) -> None:
        said = sentence.get()
        every = self._rate(said.every, sentence)
        for name in said.of:
            with self.findings.item():
                mesh, body = self._drawn(name)
                self.once(f"surface of {body}", item.span)
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

    # --- measures -----------------------------------------------------------------------------

    def _log(
        self, item: s.Sentence | s.Block | s.RecordedCall, key: str, names: Sequence[s.Name]
    ) -> None:
        """Add the log of a measure.

        Args:
            item: The output.
            key: Of the measure.
            names: What is measured.
        """
        measure = MEASURES[key]
        every = self._recorded(key, item)
        if len(names) != measure.subjects:
            self._refuse_form(item, measure)
        subjects = self.conditions.log_subjects(measure, names)
        if measure.takes == "springs":
            subjects = tuple(self._without_idle(subject) for subject in subjects)
        name = " to ".join(subject.name for subject in subjects)
        title = f"{key} of {name}" if name else key
        self.once(title, item.span)
        self.logs.append(LogRequest(title, measure, subjects, every, item.span))
        self.conditions.needs_ledger |= self.logs[-1].needs_ledger

    def _refuse_form(
        self, item: s.Sentence | s.Block | s.RecordedCall, measure: type[Measure]
    ) -> NoReturn:
        """Reject an output that does not name what its measure is taken of."""
        hint = Hint(f"write: {measure.form} {RATE}")
        said = [one for one in clauses_of(item) if one.word != "every"]
        if len(said) == measure.subjects == 1 and s.as_name(said[0].value) is not None:
            written = f"{item.name.text}({said[0].value.span.text})"
            hint = proposal(written, item.name.span.to(said[0].span))
        message = f"wrong form of {item.name.text}"
        self.findings.reject("TIS702", message, item.span, hint=hint)

    def _recording(self, item: s.RecordedCall) -> None:
        """Read a measure that is written as in conditions: ``force(A along (1, 0, 0))``."""
        key, arguments = item.name.key, item.call.arguments
        if key in (TRAJECTORY, SURFACE):
            bodies = ", ".join(one.span.one_line for one in arguments)
            hint = proposal(f"{key} of {bodies}", item.call.span)
            self.findings.reject(
                "TIS312", f"{key} has no parentheses", item.call.span, hint=hint
            )
        if key not in {*MEASURES, *STATISTICS, COUNT}:
            hint = alternatives(key, (*STATISTICS, *MEASURES), what="measures")
            message = f'"{item.name.text}" is not a measure'
            self.findings.reject("TIS701", message, item.name.span, hint=hint)
        match arguments:
            case (s.Argument(s.Name(key=counted), (s.Clause("of", value),)),):
                of = s.as_name(value)
                if key == COUNT and counted in COUNTED and of is not None:
                    self._log(item, counted, [of])
                    return
            case _:
                pass
        named = (s.as_name(one.value) for one in arguments if not one.clauses)
        names = [name for name in named if name is not None]
        is_own = key in MEASURES and MEASURES[key].takes != CUT_FACES
        if is_own and len(names) == len(arguments):
            self._log(item, key, names)
            return
        self._quantity(item)

    def _quantity(self, item: s.RecordedCall) -> None:
        """Add the log of a point, of a statistic, or of a component along a direction."""
        key = item.name.key if item.name.key in MEASURES else COUNTED[0]
        every, reading = self._recorded(key, item), self.conditions.reading(item.call)
        if reading.time is not None:
            message = "an output is taken over the whole run and cannot name a time"
            self.findings.reject("TIS702", message, item.call.span)
        measure: Any = reading.measure
        subjects = reading.subjects
        if reading.along is not None:
            of = " to ".join(one.span.one_line for one in item.call.arguments)
            title = f"{item.name.key} of {of}"
            measure, subjects = QuantityReader(self.conditions).read(item.call), ()
        else:
            of = " to ".join(subject.name for subject in subjects)
            title = f"{getattr(measure, 'title', item.name.key)} of {of}"
        self.once(title, item.span)
        self.logs.append(LogRequest(title, measure, subjects, every, item.span))

    def _without_idle(self, subject: Subject) -> Subject:
        is_idle = np.isin(subject.lines, self.idle)
        return replace(subject, lines=subject.lines[~is_idle])

    def _recorded(self, key: str, item: Written) -> float:
        """Return the time between the values of a log [s]."""
        sentence = self._sentence(key, item)
        return self._rate(sentence.get().every, sentence)

    # --- times --------------------------------------------------------------------------------

    def _rate(self, every: float, sentence: _OutputSentence) -> float:
        """Return the time between the values of an output [s], which are not too many."""
        node = sentence.clauses["every"].value
        if math.isfinite(self.duration) and self.duration / every > MOST_SAMPLES:
            least = show(self.duration / MOST_SAMPLES, TIME)
            self.findings.reject(
                "TIS308",
                f"a sample every {node.span.text} for {show(self.duration, TIME)} gives too "
                "many samples",
                node.span, hint=f"the shortest possible time is {least}",
            )  # fmt: skip
        if every > self.duration * (1 + 1e-12):
            self.findings.add(
                "W405",
                f"a sample every {node.span.text}, but the run ends at "
                f"{show(self.duration, TIME)}: only the start is recorded",
                node.span,
                hint="write a shorter time after every, or a longer duration in simulate",
            )
        return every
