"""Learn blocks, as far as they need no mesh: data, what is held out, and how is learnt."""

from collections.abc import Sequence
from pathlib import Path

from tissuec.core.errors import Note
from tissuec.core.fields import Real
from tissuec.core.source import Source, Span
from tissuec.core.units import NUMBER
from tissuec.lang import syntax as s
from tissuec.scene import schema
from tissuec.scene.block_sentences import entry_of
from tissuec.scene.declarations import Declarations, Declared, without
from tissuec.scene.findings import Findings
from tissuec.scene.learn_clauses import Clauses
from tissuec.scene.learn_data import DataReader
from tissuec.scene.learn_entries import SENTENCES, LearnSettings, learn_schema
from tissuec.scene.learn_model import ADJUST, AXES, FIT, WrittenFitProblem
from tissuec.scene.parameters import Constants
from tissuec.scene.vocabulary import Vocabulary

MOST_FORMS = 2  # of a sentence, in a hint


def read_learn_blocks(
    declarations: Declarations,
    constants: Constants,
    vocabulary: Vocabulary,
    sources: Sequence[Source],
) -> dict[str, WrittenFitProblem]:
    """Return every learn block by lower-case name; each error rejects one entry only.

    Args:
        sources: All texts of the program, which no learn block may overwrite.
    """
    return declarations.read_each(
        "learn",
        lambda d: LearnBlockReader(d, declarations, constants, vocabulary, sources).read(),
        constants.findings,
    )


def refuse_without_scene(declarations: Declarations, findings: Findings) -> None:
    """Reject learn and study blocks of a text that has no scene."""
    for kind in ("learn", "study"):
        for declared in declarations.of(kind).values():
            findings.add(
                "TIS304",
                f"the {kind} block {declared.name.text} has no scene",
                declared.name.span,
                hint='move it into the file of a scene, or use that file: use "./scene"',
            )


class LearnBlockReader:
    """Reads one learn block."""

    def __init__(
        self,
        declared: Declared,
        declarations: Declarations,
        constants: Constants,
        vocabulary: Vocabulary,
        sources: Sequence[Source],
    ):
        assert isinstance(declared.item, s.Block)
        self.name, self.block, self.scope = declared.name, declared.item, constants
        self.findings = constants.findings
        self.declarations, self.vocabulary, self.sources = declarations, vocabulary, sources
        self.what = f"learn {declared.name.text}"
        self.data = DataReader(declared.item, constants)
        self.places: dict[str, Span] = {}
        self.values: dict[str, object] = {}
        self.axis: s.Sentence | None = None
        self.fits: list[tuple[s.Assign, s.Sentence | None]] = []
        self.adjusts: list[s.Assign | s.Sentence] = []
        self.revise: list[str] = []
        self.last_part = 0.0
        self.write: Path | None = None

    def read(self) -> WrittenFitProblem:
        """Return the block, as far as it is right."""
        failures = self.findings.failures
        previous: s.Item | None = None
        for item in self.block.items:
            with self.findings.item():
                self._read(item, previous)
            previous = item
        if self.findings.failures == failures:  # else what is missing may be what is wrong
            self._expect_all()
        data = self.data.all(self.last_part)
        return WrittenFitProblem(
            self.name, data, self.data.names, self.axis, tuple(self.fits), tuple(self.adjusts),
            self.last_part, tuple(self.revise), LearnSettings(**self.values), self.write,  # type: ignore[arg-type]
            self.findings.failures == failures, self.block.head,
        )  # fmt: skip

    def _read(self, item: s.Item, previous: s.Item | None) -> None:
        entry = self._entry(item)
        assert isinstance(item, s.Assign | s.Sentence | s.Block)
        if entry is None:
            settings = learn_schema()
            found = schema.find_entry(settings, item, self.scope, what=self.what)
            self._once(found.name, item)
            self.values[found.field] = schema.read_entry(found, item, self.scope)
            return
        if SENTENCES[entry].is_single:
            self._once(entry, item)
        match entry, item:
            case "data", s.Assign() | s.Sentence() | s.Block() if self.data.read(item):
                pass
            case (("time" | "displacement"), s.Sentence()):
                self._axis(entry, item)
            case "fit", s.Assign():
                self.places.setdefault(FIT, item.span)
                self.fits.append((item, None))
            case "against column", s.Sentence():
                self._against(item, previous)
            case "adjust", s.Assign() | s.Sentence():
                self.adjusts.append(item)
            case "revise rules", s.Sentence():
                self._revise(item)
            case "hold out", s.Assign() | s.Sentence():
                self._hold_out(item)
            case "write", s.Sentence() if item.name.quoted and not item.clauses:
                self.write = self.data.place_to_write(item, self.sources)
            case _:
                self._wrong_form(entry, item)

    def _entry(self, item: s.Item) -> str | None:
        """Return which of the sentences an item is; None if a setting, or reject it."""
        if not isinstance(item, s.Assign | s.Sentence | s.Block):
            self.findings.reject("TIS303", f"this is not allowed in {self.what}", item.span)
        known = (*SENTENCES, *learn_schema())
        entry = entry_of(item.name, known, self.findings, what=self.what)
        self._refuse_binding(item)
        return entry if entry in SENTENCES else None

    def _refuse_binding(self, item: s.Assign | s.Sentence | s.Block) -> None:
        if isinstance(item, s.Assign) and (item.keyword or item.bounds):
            message = "param and let are not allowed inside a block"
            self.findings.reject("TIS303", message, item.span)

    def _once(self, entry: str, item: s.Item) -> None:
        if entry in self.places:
            self.findings.refuse_second(f'"{entry}"', item.span, self.places[entry])
        self.places[entry] = item.span

    def _wrong_form(self, entry: str, item: s.Item) -> None:
        forms = SENTENCES[entry].forms
        shown = " or ".join(forms) if len(forms) <= MOST_FORMS else forms[0]
        message = f'wrong form of "{entry}"'
        self.findings.reject("TIS312", message, item.span, hint=f"write: {shown}")

    # --- entries ------------------------------------------------------------------------------

    def _axis(self, entry: str, item: s.Sentence) -> None:
        if item.phrase is not None or item.name.key != entry:
            self._wrong_form(entry, item)
        for other in AXES:
            if other != entry and other in self.places:
                self.findings.reject(
                    "TIS306",
                    "time and displacement exclude each other",
                    item.span,
                    hint="without a time, the net is in equilibrium in each row",
                    notes=(Note(f"the {other}", self.places[other]),),
                )
        self.axis = item

    def _against(self, item: s.Sentence, previous: s.Item | None) -> None:
        if not self.fits or self.fits[-1][0] is not previous:
            if isinstance(previous, s.Assign) and previous.name.key == FIT:
                self.findings.stop()  # the fit was found wrong itself
            self.findings.reject(
                "TIS306", "the line above this column is not a fit", item.span,
                hint="put it on the line after its fit, or write: fit = … using column …",
            )  # fmt: skip
        self.fits[-1] = (self.fits[-1][0], item)

    def _revise(self, item: s.Sentence) -> None:
        clauses = Clauses(
            "revise rules", item.clauses, self.scope, allowed=("of",), where=item.span
        )
        names = clauses.names("of")
        if not names or item.name.key != "revise rules":
            self._wrong_form("revise rules", item)
        found = self.declarations.find("rules", names[0], self.findings)
        if found.name.text in self.revise:
            self.findings.reject("TIS307", f"{found.name.text} is given twice", item.span)
        if found.name.key not in self.vocabulary.rules:
            self.findings.stop()  # the rules themselves were found wrong
        self.revise.append(found.name.text)

    def _hold_out(self, item: s.Assign | s.Sentence) -> None:
        if isinstance(item, s.Assign) and not isinstance(item.value, s.Listing | s.Name):
            self._once("hold out", item)
            kind = Real(NUMBER, above=0.0, at_most=0.9)
            self.last_part = schema.read_value(kind, item.value, self.scope, what="hold out")
        elif isinstance(item, s.Assign):
            value = item.value
            self.data.hold_out(value.items if isinstance(value, s.Listing) else (value,))
        elif (name := without(item.name, "hold")) is not None and not item.clauses:
            self.data.hold_out((without(name, "out") or name,))
        else:
            self._wrong_form("hold out", item)

    def _expect_all(self) -> None:
        """Report what a learn block cannot do without."""
        there = {"data": self.data.files, FIT: self.fits, ADJUST: self.adjusts or self.revise}
        for entry, found in there.items():
            if not found:
                self.findings.add(
                    "TIS304", f'{self.what} needs "{entry}"', self.block.head,
                    hint=f"for example: {SENTENCES[entry].forms[0]}",
                )  # fmt: skip
