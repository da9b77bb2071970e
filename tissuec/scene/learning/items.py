"""The base of all learn blocks: entries, each once, and the file of the result."""

from collections.abc import Sequence
from pathlib import Path

from tissuec.core.source import Source, Span
from tissuec.lang import syntax as s
from tissuec.scene.learning.data import DataReader
from tissuec.scene.learning.entries import SENTENCES, learn_schema
from tissuec.scene.program.declarations import Declared
from tissuec.scene.program.parameters import Constants
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import entry_of

MOST_FORMS = 2  # of a sentence, in a hint


class LearnItems:
    """Sorts the items of one learn block.

    Attributes:
        data: Its files, also the one that is written.
        places: Spans of entries that can be given once, and of the first fit.
        values: Settings, by their fields.
    """

    def __init__(self, declared: Declared, constants: Constants, sources: Sequence[Source]):
        assert isinstance(declared.item, s.Block)
        self.name, self.block, self.scope = declared.name, declared.item, constants
        self.findings, self.sources = constants.findings, sources
        self.what = f"learn {declared.name.text}"
        self.data = DataReader(declared.item, constants)
        self.places: dict[str, Span] = {}
        self.values: dict[str, object] = {}
        self.write: Path | None = None

    def entry(self, item: s.Item) -> str | None:
        """Return the name of the sentence of an item; reads settings, for which it is None."""
        if not isinstance(item, s.Assign | s.Sentence | s.Block):
            self.findings.reject("TIS303", f"this is not allowed in {self.what}", item.span)
        known = (*SENTENCES, *learn_schema())
        entry = entry_of(item.name, known, self.findings, what=self.what)
        if isinstance(item, s.Assign) and (item.keyword or item.bounds):
            message = "param and let are not allowed inside a block"
            self.findings.reject("TIS303", message, item.span)
        if entry in SENTENCES:
            if SENTENCES[entry].is_single:
                self.once(entry, item)
            return entry
        found = schema.find_entry(learn_schema(), item, self.scope, what=self.what)
        self.once(found.name, item)
        self.values[found.field] = schema.read_entry(found, item, self.scope)
        return None

    def once(self, entry: str, item: s.Item) -> None:
        """Reject an entry that was given before."""
        if entry in self.places:
            self.findings.refuse_second(f'"{entry}"', item.span, self.places[entry])
        self.places[entry] = item.span

    def wrong_form(self, entry: str, item: s.Item) -> None:
        """Reject a sentence with its forms as the hint."""
        forms = SENTENCES[entry].forms
        shown = " or ".join(forms) if len(forms) <= MOST_FORMS else forms[0]
        message = f'wrong form of "{entry}"'
        self.findings.reject("TIS312", message, item.span, hint=f"write: {shown}")

    def read_write(self, item: s.Sentence) -> None:
        """Read the file of the result."""
        if not item.name.quoted or item.clauses:
            self.wrong_form("write", item)
        self.write = self.data.place_to_write(item, self.sources)

    def need(self, entry: str, example: str = "") -> None:
        """Report that a learn block lacks an entry.

        Args:
            entry: The entry.
            example: An example; by default, the first of its forms.
        """
        self.findings.add(
            "TIS304", f'{self.what} needs "{entry}"', self.block.head,
            hint=f"for example: {example or SENTENCES[entry].forms[0]}",
        )  # fmt: skip
