"""What a learn block compares with data: ``fit = force(pressed) using column "F" in N``."""

from collections.abc import Sequence

from tissuec.compiler.measures.conditions import Conditions
from tissuec.core.errors import Note, counted
from tissuec.core.source import Span
from tissuec.core.units import LENGTH
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.learning.clauses import LearnReader
from tissuec.scene.learning.model import AGAINST, FIT
from tissuec.scene.learning.sentences import AgainstWords, FitWords, TimeWords
from tissuec.script.fit_problem import POSITIONS, Data, DataAxis, DataColumn, Fit
from tissuec.script.measures import MEASURES, Measure, Subject
from tissuec.script.measures.common import VectorMeasure, is_directed

#: Endings of results, which know what is what; all else is a table.
RESULTS = (".vtkhdf", ".h5", ".hdf5", ".hdf", ".h5md")
#: What jumps, or is none of the motion: no slope leads to it.
JUMPING = ("nodes", "springs", "elements", "pieces", "count", "ruptured", "energy drift")


class FitReader:
    """Reads the sentences of one learn block that are about its data.

    Args:
        data: As far as it could be read.
    """

    def __init__(self, conditions: Conditions, data: Sequence[Data]):
        self.conditions, self.data = conditions, data
        self.scope, self.findings = conditions.scope, conditions.findings
        self.groups, self.tools = conditions.groups, conditions.tools
        self.is_timeless = False
        self.texts: dict[str, Span] = {}

    def axis(self, item: s.Sentence | None, where: Span) -> DataAxis:
        """Return the axis that sorts rows; without sentence, the times in the first column."""
        if item is None:
            return DataAxis(None, None, where)
        entry = item.name.key.partition(" ")[0]
        self.is_timeless = entry != "time"
        reader = LearnReader(entry, item, self.scope)
        said = reader.get()
        column, *more = said.columns
        if more:
            span = reader.clauses["using"].value.span
            reader.reject_at(span, "TIS802", f"a {entry} needs exactly one column")
        if isinstance(said, TimeWords):
            return DataAxis(None, column, item.span)
        self._refuse_tool(said.moved, "a displacement belongs to nodes of bodies")
        nodes = self.groups.nodes(said.moved).indices
        return DataAxis(nodes, column, item.span, said.along)

    def fit(self, item: s.Assign, against: s.Sentence | None) -> Fit:
        """Return one thing that was measured, or reject it."""
        reader = LearnReader(FIT, item, self.scope)
        behind = reader if against is None else self._against(reader, against)
        measure, subjects, along = self._measured(item.value, reader)
        dimension = measure.dimension if measure else LENGTH
        reader.own = behind.own = dimension
        reader.about = behind.about = item.value.span.with_values
        said = reader.get(FitWords)
        options = said if behind is reader else behind.get(AgainstWords)
        columns = options.columns or ()
        self._check_columns(columns, measure, subjects, along, item.value, behind)
        if options.every is not None and self.is_timeless:
            span = behind.clauses["every"].span
            self.findings.reject("TIS306", "rows over a displacement have no time", span)
        text = item.value.span.with_values
        self._once(text, item)
        return Fit(
            text, measure, subjects, along, dimension, columns, options.every, options.noise,
            1.0 if options.weight is None else options.weight, options.free_zero, item.span,
        )  # fmt: skip

    def _once(self, text: str, item: s.Assign) -> None:
        if text in self.texts:
            notes = (Note("first here", self.texts[text]),)
            self.findings.reject("TIS307", f"{text} is fitted twice", item.span, notes=notes)
        self.texts[text] = item.span

    # --- what is measured ---------------------------------------------------------------------

    def _measured(
        self, node: s.Expression, reader: LearnReader
    ) -> tuple[type[Measure] | None, tuple[Subject, ...], Floats | None]:
        """Return a measure, None for positions; of what it is taken; and along what."""
        if not isinstance(node, s.Call | s.Name):
            reader.reject_at(
                node.span, "TIS312", "the fitted quantity must be a single measure"
            )
        key = node.function.key if isinstance(node, s.Call) else node.key
        if key in JUMPING:
            self.findings.reject(
                "TIS802", f"{node.span.one_line} cannot be fitted: it changes in jumps "
                "or does not depend on the motion", node.span,
                hint="fit what changes smoothly, such as force(SET) or position(SET)",
            )  # fmt: skip
        if key == POSITIONS and isinstance(node, s.Call):
            return None, (self._positions(node),), None
        if isinstance(node, s.Name) and key not in MEASURES:
            reader.reject_at(node.span, "TIS701", f'"{node.text}" is not a measure')
        reading = self.conditions.reading(node)
        if reading.time is not None:
            self.findings.reject(
                "TIS702", "a fit uses all times of its data and cannot name one", node.span
            )
        return reading.measure, reading.subjects, reading.along

    def _positions(self, call: s.Call) -> Subject:
        """Return the nodes whose places were measured, each for itself."""
        first = call.arguments[0] if len(call.arguments) == 1 else None
        name = None if first is None or first.clauses else s.as_name(first.value)
        if name is None:
            self.findings.reject(
                "TIS702", "the form of positions is positions(A): x, y and z of each node of A",
                call.span, hint="for a direction, fit position(A along (1, 0, 0))",
            )  # fmt: skip
        self._refuse_tool(name, "positions belong to nodes of bodies")
        nodes = self.groups.nodes(name)
        return Subject(nodes.name, nodes.indices, self.groups.springs(name).indices)

    def _refuse_tool(self, name: s.Name, why: str) -> None:
        if name.key in self.tools:
            message = f"{why}; {self.tools[name.key].name} is a tool"
            self.findings.reject("TIS802", message, name.span, hint="name a set or a body")

    # --- columns ------------------------------------------------------------------------------

    def _against(self, reader: LearnReader, against: s.Sentence) -> LearnReader:
        """Return the reader of the line below a fit, which has its column."""
        if reader.clauses.keys() - {"="}:
            self.findings.reject(
                "TIS307", "columns and their options are given twice", against.span,
                hint="write them after using or on the line below, not in both places",
            )  # fmt: skip
        return LearnReader(AGAINST, against, self.scope)

    def _check_columns(
        self,
        columns: Sequence[DataColumn],
        measure: type[Measure] | None,
        subjects: Sequence[Subject],
        along: Floats | None,
        node: s.Expression,
        reader: LearnReader,
    ) -> None:
        """Reject columns that are not as many as what they hold has numbers."""
        text = node.span.with_values
        if not columns:
            table = next((d for d in self.data if d.path.suffix.lower() not in RESULTS), None)
            if table is not None:
                reader.reject("TIS802", f"the column of {text} in {table.path.name} is missing")
            return
        allowed = _counts(measure, along, _count(subjects) if measure is None else 0)
        if len(columns) in allowed:
            return
        needed = " or ".join(counted(count, "column") for count in allowed)
        hint = 'name them: using columns "x y z"'
        if measure is None:
            hint = 'name them: using columns "node x y z"; for a single node, "x y z"'
        elif allowed == (1,):
            hint = 'name it: using column "…"'
        elif measure is MEASURES["position"]:
            hint += ", or write position(A along (1, 0, 0))"
        message = f"{text} needs {needed}, not {len(columns)}"
        self.findings.reject("TIS802", message, columns[0].span, hint=hint)


def _counts(measure: type[Measure] | None, along: Floats | None, nodes: int) -> tuple[int, ...]:
    """Return in how many columns something can be."""
    if measure is None:
        return (3, 4) if nodes == 1 else (4,)
    if along is not None or not is_directed(measure) or not issubclass(measure, VectorMeasure):
        return (1,)
    return (3,) if measure is MEASURES["position"] else (1, 3)


def _count(subjects: Sequence[Subject]) -> int:
    nodes = subjects[0].nodes
    return 0 if nodes is None else len(nodes)
