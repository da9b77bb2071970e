"""Study blocks, as far as they need no mesh: factors, design, measures as written."""

from collections.abc import Iterable

from tissuec.core.errors import Note
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.program.declarations import Declarations, Declared, without
from tissuec.scene.program.parameters import Constants
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import entry_of
from tissuec.scene.study.entries import (
    DESIGNS,
    GRID,
    LATIN,
    LIST,
    LISTED,
    SENTENCES,
    StudySettings,
)
from tissuec.scene.study.factors import VARY, FactorReader
from tissuec.scene.study.model import (
    UNNAMED,
    Cell,
    Distribution,
    Factor,
    Levels,
    Study,
    WrittenMeasure,
    called,
)

ROWS, MEASURE, DESIGN, ESTIMATE, RUNS = "rows", "measure", "design", "error estimate", "runs"


def read_studies(declarations: Declarations, constants: Constants) -> dict[str, Study]:
    """Return every study block by lower-case name; each error rejects one entry only."""
    return declarations.read_each(
        "study",
        lambda declared: _StudyReader(declared, declarations, constants).read(),
        constants.findings,
    )


class _StudyReader:
    """Reads one study block."""

    def __init__(self, declared: Declared, declarations: Declarations, scope: Constants):
        assert isinstance(declared.item, s.Block)
        self.name, self.block, self.scope = declared.name, declared.item, scope
        self.findings = scope.findings
        name = called(declared.name.text)
        self.what = f"the {name}" if name == UNNAMED else name
        self.reader = FactorReader(declared.item, declarations, scope)
        self.places: dict[str, Span] = {}
        self.columns: dict[str, Span] = {}
        self.values: dict[str, object] = {}
        self.factors: list[Factor] = []
        self.rows: list[tuple[Cell, ...]] | None = None
        self.measures: list[WrittenMeasure] = []
        self.expects: list[s.Expect] = []
        self.design = ""
        self.estimates = True
        self.is_kept = False  # whether only the text of the scene is there

    def read(self) -> Study:
        """Return the block, as far as it is right."""
        failures = self.findings.failures
        for item in self.block.items:
            with self.findings.item():
                self._read(item)
        is_whole = self.findings.failures == failures and not self.is_kept
        if is_whole:  # else what is missing may be what is wrong
            with self.findings.item():
                self._check()
            is_whole = self.findings.failures == failures
        return Study(
            self.name.text,
            tuple(self.factors),
            None if self.rows is None else tuple(self.rows),
            tuple(self.measures),
            tuple(self.expects),
            self.design or self._usual(),
            self.estimates,
            StudySettings(**self.values),  # type: ignore[arg-type]
            is_whole,
            self.block.head,
        )

    def _read(self, item: s.Item) -> None:
        if isinstance(item, s.Expect):
            if item.clauses:
                message = "an expectation of a study is about all runs and has no time"
                self.findings.reject("TIS303", message, item.clauses[0].span)
            self.expects.append(item)
            return
        if not isinstance(item, s.Assign | s.Sentence | s.Function):
            span = getattr(item, "head", item.span)
            self.findings.reject("TIS303", f"this is not allowed in {self.what}", span)
        match self._entry(item):
            case "vary":
                factor = self.reader.vary(item)
                self._once(factor.name, item.name.span, self.columns)
                self.factors.append(factor)
            case "measure" if isinstance(item, s.Assign) and not item.keyword:
                self._measure(item)
            case "rows" if isinstance(item, s.Sentence):
                self._once(ROWS, item.span, self.places)
                found = self.reader.rows(item)
                self.is_kept = found is None
                if found is not None:
                    self.factors += found[0]
                    self.rows = found[1]
            case "design" if isinstance(item, s.Sentence) and item.phrase is not None:
                self._once(DESIGN, item.span, self.places)
                self.design = self._choice(item, DESIGNS)
            case "error estimate" if isinstance(item, s.Sentence) and item.phrase is not None:
                self._once(ESTIMATE, item.span, self.places)
                self.estimates = self._choice(item, ("off",)) != "off"
            case "" if isinstance(item, s.Assign | s.Sentence):
                entries = schema.entries_of(StudySettings)
                found = schema.find_entry(entries, item, self.scope, what=self.what)
                self._once(found.name, item.span, self.places)
                self.values[found.field] = schema.read_entry(found, item, self.scope)
            case entry:
                forms = SENTENCES[entry].forms if entry else ("runs = 100",)
                message = f'wrong form of "{entry or item.name.text}"'
                self.findings.reject("TIS312", message, item.span, hint=f"write: {forms[0]}")

    def _entry(self, item: s.Assign | s.Sentence | s.Function) -> str:
        """Return which of the sentences an item is; "" for a setting, or reject it."""
        known = (*SENTENCES, *schema.entries_of(StudySettings))
        entry = entry_of(item.name, known, self.findings, what=self.what)
        return entry if entry in SENTENCES else ""

    def _once(self, name: str, span: Span, places: dict[str, Span]) -> None:
        key = key_of(name)
        if key in places:
            self.findings.refuse_second(f'"{name}"', span, places[key])
        places[key] = span

    def _choice(self, item: s.Sentence, known: Iterable[str]) -> str:
        """Return the words behind ``is``, one of the known ones."""
        assert item.phrase is not None
        span = item.phrase.span.to(item.span)
        text, names = key_of(span.one_line), list(known)
        if text not in names:
            hint = alternatives(text, names, what="choices")
            self.findings.reject(
                "TIS305", f'{item.name.text} cannot be "{text}"', span, hint=hint
            )
        return text

    def _measure(self, item: s.Assign) -> None:
        name = without(item.name, MEASURE)
        clauses = item.clauses
        end = clauses[-1].span if clauses else item.value.span
        text = name.text if name is not None else item.value.span.to(end).one_line
        self._once(text, item.name.span, self.columns)
        self.measures.append(WrittenMeasure(text, item, item.span))

    # --- what goes together -------------------------------------------------------------------

    def _usual(self) -> str:
        """Return the design if none is written."""
        if self.rows is not None:
            return LIST
        drawn = any(isinstance(factor.spread, Distribution) for factor in self.factors)
        return LATIN if drawn else GRID

    def _check(self) -> None:
        """Reject what is missing, and what does not go together."""
        for entry, there in ((VARY, self.factors), (MEASURE, self.measures)):
            if not there:
                self.findings.add(
                    "TIS304", f'{self.what} needs "{entry}"', self.block.head,
                    hint=f"for example: {SENTENCES[entry].forms[0]}",
                )  # fmt: skip
        varied = [factor for factor in self.factors if factor.spread is not None]
        if self.rows is not None and varied:
            self.findings.reject(
                "TIS306", "rows and vary exclude each other", varied[0].span,
                hint="write a column for this factor into the file",
                notes=(Note("the rows", self.places[ROWS]),),
            )  # fmt: skip
        design = self.design or self._usual()
        if self.rows is not None and design != LIST:
            message = f"rows are a list of runs, and no {design}"
            self.findings.reject(
                "TIS306", message, self.places[DESIGN], hint="remove the design"
            )
        if design not in LISTED:
            return
        for factor in self.factors:
            if isinstance(factor.spread, Distribution):
                self.findings.reject(
                    "TIS304", f"{factor.name} has no steps, which the design {design} needs",
                    factor.span, hint="write for example: in 9 steps; or: design is "
                    f"{LATIN}",
                )  # fmt: skip
        if RUNS in self.places:
            self.findings.reject(
                "TIS306", f"runs has no effect: the design {design} has as many as its values",
                self.places[RUNS], hint=f"remove it, or write: design is {LATIN}",
            )  # fmt: skip
        if design == LIST:
            self._refuse_unequal()

    def _refuse_unequal(self) -> None:
        """Reject lists of different lengths, which give no rows."""
        lists = [(f, f.spread) for f in self.factors if isinstance(f.spread, Levels)]
        for factor, levels in lists:
            first, others = lists[0]
            if len(levels.values) != len(others.values):
                self.findings.reject(
                    "TIS306",
                    f"{factor.name} has {len(levels.values)} values, and {first.name} has "
                    f"{len(others.values)}",
                    factor.span,
                    hint="a list needs as many of each; or write: design is grid",
                    notes=(Note("the other factor", first.span),),
                )
