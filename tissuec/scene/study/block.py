"""Study blocks, as far as they need no mesh: factors, design, measures as written."""

from collections.abc import Sequence
from typing import NoReturn

from tissuec.core.errors import Note
from tissuec.core.hints import did_you_mean, proposal
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.program.declarations import Declarations, Declared, without
from tissuec.scene.program.parameters import Constants
from tissuec.scene.reading.block_sentences import BlockItems, SentenceReader, as_entries
from tissuec.scene.reading.entries import entries_of
from tissuec.scene.reading.parts import block, declare
from tissuec.scene.reading.spellings import in_parentheses
from tissuec.scene.study.entries import (
    GRID,
    LATIN,
    LIST,
    LISTED,
    MEASURE,
    OPTIONS,
    ROWS,
    SENTENCES,
    VARY,
    StudySettings,
)
from tissuec.scene.study.factors import FactorReader
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
from tissuec.script.measures import MEASURES

DESIGN, RUNS, SEED = "design", "runs", "seed"
declare(
    "study", "Many runs of the scene: what varies, and what is measured.", 31,
    block=block(lambda: {**as_entries(SENTENCES), **entries_of(StudySettings)}),
)  # fmt: skip


def read_studies(declarations: Declarations, constants: Constants) -> dict[str, Study]:
    """Return every study block by lower-case name; each error rejects one entry only."""
    return declarations.read_each(
        "study",
        lambda declared: _StudyReader(declared, declarations, constants).read(),
        constants.findings,
    )


class _StudyReader(BlockItems):
    """Reads one study block."""

    def __init__(self, declared: Declared, declarations: Declarations, scope: Constants):
        name = called(declared.name.text)
        what = f"the {name}" if name == UNNAMED else name
        assert isinstance(declared.item, s.Block)
        self.name, self.block = declared.name, declared.item
        super().__init__(what, SENTENCES, entries_of(StudySettings), scope)
        self.reader = FactorReader(self.block, declarations, scope)
        self.params = declarations.of("param")
        self.columns: dict[str, Span] = {}
        self.factors: list[Factor] = []
        self.rows: list[tuple[Cell, ...]] | None = None
        self.measures: list[WrittenMeasure] = []
        self.expects: list[s.Expect] = []
        self.is_kept = False  # whether only the text of the scene is there

    def read(self) -> Study:
        """Return the block, as far as it is right."""
        failures = self.findings.failures
        for item in self.block.items:
            with self.findings.item():
                self._read(item)
        is_whole = self.findings.failures == failures and not self.is_kept
        settings = StudySettings(**self.values)
        design = settings.design or self._usual()
        if is_whole:  # else what is missing may be what is wrong
            with self.findings.item():
                self._check(design)
            is_whole = self.findings.failures == failures
        return Study(
            self.name.text,
            tuple(self.factors),
            None if self.rows is None else tuple(self.rows),
            tuple(self.measures),
            tuple(self.expects),
            design,
            not settings.error_estimate,
            settings,
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
        first, _, measured = item.span.one_line.partition(" ")
        if first == MEASURE and not isinstance(item, s.Assign | s.Sentence):
            hint = proposal(f"{MEASURE} NAME = {measured}")
            self.findings.reject("TIS312", "a measure has a name", item.span, hint=hint)
        match self.entry(item), item:
            case "vary", s.Assign() | s.Sentence() | s.Function():
                factor = self.reader.vary(item)
                self.once(factor.name, item.name.span, self.columns)
                self.factors.append(factor)
            case "measure", s.Assign():
                self._measure(item)
            case "rows", s.Sentence():
                found = self.reader.rows(item)
                self.is_kept = found is None
                if found is not None:
                    self.factors += found[0]
                    self.rows = found[1]
            case None, _:
                pass
            case entry, s.Assign() | s.Sentence() | s.Function():
                SentenceReader(entry, SENTENCES[entry], item, self.scope).reject_form()
            case _:
                pass

    def refuse_name(self, name: s.Name, known: Sequence[str]) -> NoReturn:
        """Reject the name of an entry that there is not; a param is to be varied."""
        if name.key in self.params:
            hint = proposal(f"{VARY} {name.text}")
            self.findings.refuse_entry(name, self.what, hint=hint)
        super().refuse_name(name, known)

    def _measure(self, item: s.Assign) -> None:
        measured = in_parentheses(item)
        assert isinstance(measured, s.Assign)
        name = without(item.name, MEASURE)
        if name is None and isinstance(item.value, s.Name) and not item.clauses:
            self._refuse_name(item.value)
        end = item.clauses[-1].span if item.clauses else item.value.span
        text = name.text if name is not None else item.value.span.to(end).with_values
        self.once(text, item.name.span, self.columns)
        self.measures.append(WrittenMeasure(text, measured, item.span))

    def _refuse_name(self, name: s.Name) -> None:
        """Reject a name in place of a measure; one that is nearly a measure is read later."""
        example = f"{name.text} = max(force(A))"
        if s.key_of(name.text) in self.columns:
            message = f'the study has a column called "{name.text}" already'
            hint = "leave it out, or write a measure with another name: NAME = max(force(A))"
            self.findings.reject("TIS312", message, name.span, hint=hint)
        if name.key not in MEASURES and not did_you_mean(name.key, MEASURES):
            message = f'"{name.text}" does not say what is measured'
            hint = f"name it and say what it is, for example: {example}"
            self.findings.reject("TIS701", message, name.span, hint=hint)

    # --- what goes together -------------------------------------------------------------------

    def _usual(self) -> str:
        """Return the design if none is written."""
        if self.rows is not None:
            return LIST
        drawn = any(isinstance(factor.spread, Distribution) for factor in self.factors)
        return LATIN if drawn else GRID

    def _check(self, design: str) -> None:
        """Reject what is missing, and what does not go together."""
        for entry, there in ((VARY, self.factors), (MEASURE, self.measures)):
            if not there:
                self.need(entry, self.block.head)
        varied = [factor for factor in self.factors if factor.spread is not None]
        if self.rows is not None and varied:
            self.findings.reject(
                "TIS306", "rows and vary exclude each other", varied[0].span,
                hint="write a column for this factor into the file",
                notes=(Note("the rows", self.places[ROWS]),),
            )  # fmt: skip
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
        # The same command, with --seed, may carry out studies of any design.
        if SEED in self.places and self.places[SEED].source.name != OPTIONS:
            self.findings.reject(
                "TIS306", f"seed has no effect: the design {design} draws no random numbers",
                self.places[SEED], hint=f"remove it, or write: design is {LATIN}",
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
