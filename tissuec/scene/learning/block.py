"""Learn blocks, as far as they need no mesh: data, what is held out, and how is learnt."""

from collections.abc import Sequence

from tissuec.core.errors import Note
from tissuec.core.fields import OneOf, Real
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.core.units import NUMBER
from tissuec.lang import syntax as s
from tissuec.scene.learning.entries import LearnSettings, learn_schema
from tissuec.scene.learning.items import LearnItems
from tissuec.scene.learning.model import ADJUST, AXES, FIT, VocabularyFit, WrittenFitProblem
from tissuec.scene.learning.sentences import SENTENCES, PartHeld
from tissuec.scene.learning.vocabulary_fits import VocabularyFitReader, fits_words
from tissuec.scene.program.declarations import Declarations, Declared
from tissuec.scene.program.parameters import Constants
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import as_entries
from tissuec.scene.reading.entries import Entries
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import block, declare
from tissuec.scene.reading.spellings import in_parentheses
from tissuec.scene.settings import integrators
from tissuec.scene.words.vocabulary import Vocabulary


def _entries() -> Entries:
    settings, known = learn_schema(), integrators()
    words = {word: known[word] for word in settings["integrator"].words}
    integrator = replace(settings["integrator"], kind=OneOf(words))
    return {**as_entries(SENTENCES), **settings, "integrator": integrator}


declare(
    "learn", "Fits numbers of tissues, nodes, springs or words to measured data.", 30,
    block=block(_entries),
)  # fmt: skip


def read_learn_blocks(
    words: ResolvedProgram, sources: Sequence[Source]
) -> dict[str, WrittenFitProblem | VocabularyFit]:
    """Return every learn block by lower-case name; each error rejects one entry only.

    Args:
        words: The program with the blocks, as far as it needs no bodies.
        sources: All texts of the program, which no learn block may overwrite.
    """

    def read(declared: Declared) -> WrittenFitProblem | VocabularyFit:
        if fits_words(declared):
            return VocabularyFitReader(declared, words, sources).read()
        reader = LearnBlockReader(
            declared, words.declarations, words.constants, words.vocabulary, sources
        )
        return reader.read()

    return words.declarations.read_each("learn", read, words.constants.findings)


def refuse_without_scene(declarations: Declarations, findings: Findings) -> None:
    """Reject learn and study blocks that need a scene, in a text that has none."""
    for kind in ("learn", "study"):
        for declared in declarations.of(kind).values():
            if kind == "learn" and fits_words(declared):
                continue
            findings.add(
                "TIS304",
                f"the {kind} block {declared.name.text} has no scene",
                declared.name.span,
                hint='move it into the file of a scene, or use that file: use "./scene"',
            )


class LearnBlockReader(LearnItems):
    """Reads one learn block that fits a scene to data."""

    def __init__(
        self,
        declared: Declared,
        declarations: Declarations,
        constants: Constants,
        vocabulary: Vocabulary,
        sources: Sequence[Source],
    ):
        super().__init__(declared, constants, sources)
        self.declarations, self.vocabulary = declarations, vocabulary
        self.axis: s.Sentence | None = None
        self.fits: list[tuple[s.Assign, s.Sentence | None]] = []
        self.adjusts: list[s.Assign | s.Sentence] = []
        self.revise: list[str] = []
        self.last_part = 0.0

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
        entry = self.entry(item)
        if entry is None:
            return
        match entry, item:
            case "data", _:
                self._data(item)
            case (("time" | "displacement"), s.Sentence()):
                self._axis(entry, item)
            case "fit", s.Assign():
                self.places.setdefault(FIT, item.span)
                measured = in_parentheses(item)
                assert isinstance(measured, s.Assign)
                self.fits.append((measured, None))
            case "against column", s.Sentence():
                self._against(item, previous)
            case "adjust", s.Assign() | s.Sentence():
                self.adjusts.append(item)
            case "revise rules", s.Sentence():
                self._revise(item)
            case "hold out", _:
                self._hold_out(item)
            case "write", _:
                self.read_write(item)
            case _:
                self.reader(entry, item).reject_form()

    # --- entries ------------------------------------------------------------------------------

    def _data(self, item: s.Item) -> None:
        failures = self.findings.failures
        try:
            self.data.read(item, self.reader("data", item).get())
        finally:
            self.data.is_complete &= failures == self.findings.failures

    def _axis(self, entry: str, item: s.Sentence) -> None:
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
        if not self.fits or previous is None or self.fits[-1][0].span is not previous.span:
            if isinstance(previous, s.Assign) and previous.name.key == FIT:
                self.findings.stop()  # the fit was found wrong itself
            self.findings.reject(
                "TIS306", "the line above this column is not a fit", item.span,
                hint="put it on the line after its fit, or write: fit = … using column …",
            )  # fmt: skip
        self.fits[-1] = (self.fits[-1][0], item)

    def _revise(self, item: s.Sentence) -> None:
        owner = self.reader("revise rules", item).get().rules
        found = self.declarations.find("rules", owner, self.findings)
        if found.name.text in self.revise:
            self.findings.reject("TIS307", f"{found.name.text} is given twice", item.span)
        if found.name.key not in self.vocabulary.rules:
            self.findings.stop()  # the rules themselves were found wrong
        self.revise.append(found.name.text)

    def _hold_out(self, item: s.Item) -> None:
        reader = self.reader("hold out", item)
        if isinstance(item, s.Assign) and not isinstance(item.value, s.Listing | s.Name):
            self.once("hold out", item.span)
            kind = Real(NUMBER, above=0.0, at_most=0.9)
            part = reader.get(PartHeld).held
            self.last_part = schema.read_value(kind, part, self.scope, what="hold out")
        else:
            self.data.hold_out(reader.get().files)

    def _expect_all(self) -> None:
        """Report what a learn block cannot do without."""
        there = {"data": self.data.files, FIT: self.fits, ADJUST: self.adjusts or self.revise}
        for entry, found in there.items():
            if not found:
                self.need(entry, self.block.head)
