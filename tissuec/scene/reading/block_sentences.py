"""Blocks of sentences, such as ``learn`` and ``study``: declarations, and how they are read."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NoReturn

from msgspec import Struct

from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean
from tissuec.core.markdown import paragraphs
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.reading import schema
from tissuec.scene.reading.clauses import ClauseReader, Written
from tissuec.scene.reading.entries import NEEDED, BlockEntries, Entries, Entry, written
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import VerbForm, VerbSentence, form_of, texts_of_sentences
from tissuec.script.parts import (
    ChoiceClause,
    ClausePart,
    ConcludedClause,
    ConditionClause,
    FilesClause,
    LimitsClause,
    MeasureClause,
    NameClause,
    Part,
    TextClause,
    UnionClause,
    UnitClause,
    ValueClause,
)

#: What can be between the first words of a sentence and a value.
SIGNS = ("=", "is", "between")


class SentenceKind(Struct, frozen=True):
    """One kind of sentence of a block.

    Attributes:
        forms: Its forms; the parts of each are those of the class.
        about: What it says.
        examples: How it is written, if its forms together with the examples of their parts do
            not show it; words in capitals are placeholders.
        wrong: The message about a sentence that has none of its forms.
        behind: What follows it in messages, such as a block.
        opens: The block that can follow it.
        begins: What an editor writes after its first words, if not what its forms begin with.
        instead: The way out if it is given twice, if not to remove one.
        is_needed: Whether there must be one.
        is_single: Whether there can only be one.
    """

    forms: tuple[type[VerbSentence], ...]
    about: str = ""
    examples: tuple[str, ...] = ()
    wrong: str = ""
    behind: str = ""
    is_needed: bool = False
    is_single: bool = False
    opens: BlockEntries | None = None
    begins: str = ""
    instead: str = ""

    def texts(self, first: str) -> tuple[str, ...]:
        """Return examples of it.

        Args:
            first: Its first words.
        """
        return self.examples or texts_of_sentences(first, self.forms, as_examples=True)


class FileWords(VerbSentence, frozen=True):
    """A file."""

    files: Annotated[tuple[s.Name, ...], FilesClause("", what="file", example='"table.csv"')]


def as_entries(kinds: Mapping[str, SentenceKind]) -> dict[str, Entry]:
    """Sentences of a block as its entries, which have sections of their own in the reference.

    Args:
        kinds: By their first words.
    """
    return {
        name: written(
            name, paragraphs(one.about), *one.forms, repeats=not one.is_single,
            opens=one.opens, examples=one.texts(name), begins=one.begins, has_section=True,
            default=NEEDED if one.is_needed else None,
        )
        for name, one in kinds.items()
    }  # fmt: skip


class SentenceReader(ClauseReader):
    """Reads one sentence of a block.

    Args:
        entry: Its first words.
        kind: Its declaration.
        item: The sentence.
        scope: Names and findings of the scene.
    """

    def __init__(self, entry: str, kind: SentenceKind, item: Written, scope: Scope):
        forms = tuple(map(form_of, kind.forms))
        super().__init__(item, entry, forms, scope, texts=kind.texts(entry))
        self.kind = kind
        if not entry:  # what begins it is a name of the author's own
            self.verb = self.object.text
            if not kind.examples:
                self.texts = [f"{self.verb} {text.partition(' ')[2]}" for text in self.texts]
        self.lead = "for example" if kind.examples or kind.about else "write"
        self.is_named = False  # whether words after the first ones belong to the sentence

    def get(self, form: type[VerbSentence] | None = None, *, is_last: bool = True) -> Any:
        """Return the content of the sentence.

        Args:
            form: Its form; by default, the first one whose required clauses are all written.
            is_last: Whether it has no clauses that are still to be read.
        """
        said = self.read() if form is None else self.read_form(form_of(form))
        parts = self.form.parts.values()
        self.is_named |= any(isinstance(part, ClausePart) and not part.word for part in parts)
        if self.object.text and not self.is_named and self.object.key != self.form.literal:
            self.reject_form()
        if is_last:
            self.finish()
        return said

    def reject_form(self) -> NoReturn:
        """Reject the sentence, with an example as the hint."""
        message = self.kind.wrong or f'wrong form of "{self.verb}"'
        hint = f"{self.lead}: {self._nearest_form()}{self.kind.behind}"
        self.reject("TIS312", message, hint=hint)

    def refuse(self, clause: s.Clause) -> NoReturn:
        known = {word for form in self.forms for word, *_ in form.clauses}
        if clause.word == "=" and "is" in known:
            schema.refuse_sign(self.sentence, self.scope, example=self.texts[0])
        if self.kind.wrong and clause.word in known.union(SIGNS):
            self.reject_form()
        super().refuse(clause)

    def read_form(self, form: VerbForm) -> VerbSentence:
        known = {word for one in self.forms for word, *_ in one.clauses}
        for word, clause in self.clauses.items():
            is_refused = word in form.kind.refused
            if not is_refused and word.partition(" ")[0] not in known:
                self.refuse(clause)
        self.check_complete(form)
        return super().read_form(form)

    def choose(self) -> VerbForm:
        of_words = [form for form in self.forms if form.literal == self.object.key != ""]
        forms = of_words or [form for form in self.forms if not form.literal]
        return next((form for form in forms if self.has_all(form)), forms[0])

    def has_all(self, form: VerbForm) -> bool:
        """Return whether all that a form requires is written."""
        needed = (part for name, part in form.parts.items() if name not in form.optional)
        return all(self._is_there(part) for part in needed if isinstance(part, ClausePart))

    def _is_there(self, part: ClausePart) -> bool:
        clause = self.clauses.get(part.word)
        if not part.word or clause is None:
            return not part.word and bool(self.object.text)
        match part, clause.value:
            case MeasureClause(functions=functions), node if functions:
                return isinstance(node, s.Call) and node.function.key in functions
            case ChoiceClause(word="=", words=words), node:
                return isinstance(node, s.Name) and node.key in words
            case UnionClause(), node:
                return isinstance(node, s.Listing)
            case _:
                return True

    def called(self, word: str) -> str:
        part = self.form.of_word(word)
        return f"the {part.what}" if part is not None and part.what else super().called(word)

    def read_other(self, part: Part, *, is_optional: bool) -> Any:
        match part:
            case NameClause(word=word, listed=True):
                return self._names(self.clauses[word].value if word else self.object)
            case UnionClause(word=word):
                node = self.clauses[word].value
                if not isinstance(node, s.Listing):
                    self.reject_form()
                return s.Name("", None, node.span, self._names(node))
            case NameClause(word=""):
                return self.object if self.object.text else None
            case NameClause(word=word, owners=(), joins=joins):
                return self.names_in(word) if joins else self.name_in(word)
            case NameClause(word=word):
                return (self.name_in(word), *self.repeated)
            case UnitClause(word=word):
                return self.clauses[word].value.span
            case LimitsClause(word=word):
                ends = self.clauses[word].value
                assert isinstance(ends, s.Listing)
                low, high = ends.items
                return s.Bounds(low, high, ends.span)
            case ConditionClause(word=""):
                assert isinstance(self.sentence, s.Expect | s.Rule)
                return self.sentence.condition
            case ConcludedClause(word=word):
                assert isinstance(self.sentence, s.Rule)
                self.asked.add(word)
                return self.sentence.conclusions
            case ValueClause(word=word) | MeasureClause(word=word) | ConditionClause(word=word):
                return self.clauses[word].value
            case TextClause():
                return (self.object.quoted or "").strip()
            case FilesClause(word=word):
                return self._files(self.clauses[word].value if word else self.object)
            case _:
                return super().read_other(part, is_optional=is_optional)

    def _names(self, node: s.Expression) -> tuple[s.Name, ...]:
        """Return one name, or those of a list."""
        parts = node.items if isinstance(node, s.Listing) else (node,)
        wrong = next((part for part in parts or (node,) if not isinstance(part, s.Name)), None)
        if wrong is not None:
            message = "a name, or a list of names, is needed here"
            self.reject_at(wrong.span, "TIS312", message)
        return tuple(part for part in parts if isinstance(part, s.Name))

    def _files(self, node: s.Expression) -> tuple[s.Name, ...]:
        """Return the names of files in quotes; each wrong one is rejected."""
        files: list[s.Name] = []
        with self.scope.findings.together():
            for one in node.items if isinstance(node, s.Listing) else (node,):
                with self.scope.findings.item():
                    if not isinstance(one, s.Name) or not one.quoted or one.words:
                        message = "the name of a file must be in quotes"
                        self.reject_at(one.span, "TIS312", message)
                    files.append(one)
        return tuple(files)


class BlockItems:
    """Sorts the items of one block of sentences.

    Args:
        what: It is called in messages.
        kinds: Its sentences by their first words.
        settings: Its other entries.
        scope: Names and findings of the scene.

    Attributes:
        places: Spans of entries that can be given once.
        values: Settings, by their fields.
    """

    def __init__(
        self, what: str, kinds: Mapping[str, SentenceKind], settings: Entries, scope: Scope
    ):
        self.scope, self.findings, self.what = scope, scope.findings, what
        self.kinds, self.settings = kinds, settings
        self.places: dict[str, Span] = {}
        self.values: dict[str, Any] = {}

    def entry(self, item: s.Item) -> str | None:
        """Return the kind of sentence that an item is; reads settings, which have none."""
        if not isinstance(item, s.Assign | s.Sentence | s.Function | s.Block):
            span = getattr(item, "head", item.span)
            self.findings.reject("TIS303", f"this is not allowed in {self.what}", span)
        entry = self._entry_of(item.name)
        kind = self.kinds.get(entry)
        if isinstance(item, s.Block) and kind is not None and kind.opens is None:
            hint = Hint(f"write: {item.head.text}", Edit(item.head.text, item.span))
            self.findings.reject("TIS303", f"{entry} has no entries", item.span, hint=hint)
        if isinstance(item, s.Assign) and item.keyword:
            message = "param and let are not allowed inside a block"
            self.findings.reject("TIS303", message, item.span)
        if kind is not None:
            if kind.is_single:
                self.once(entry, item.span, hint=kind.instead)
            return entry
        if isinstance(item, s.Function):
            self.findings.reject("TIS303", f"this is not allowed in {self.what}", item.span)
        found = schema.find_entry(self.settings, item, self.scope, what=self.what)
        self.once(found.name, item.span)
        self.values[found.field] = schema.read_entry(found, item, self.scope)
        return None

    def _entry_of(self, name: s.Name) -> str:
        known, words = (*self.kinds, *self.settings), s.key_of(name.words)
        found = [entry for entry in known if f"{words} ".startswith(f"{entry} ")]
        return max(found, key=len) if found else self.refuse_name(name, known)

    def refuse_name(self, name: s.Name, known: Sequence[str]) -> NoReturn:
        """Reject the name of an entry that there is not."""
        words = s.key_of(name.words)
        key = words if did_you_mean(words, known) else words.partition(" ")[0]
        hint = alternatives(key, known, what="entries")
        self.findings.refuse_entry(name, self.what, hint=hint)

    def once(
        self, entry: str, span: Span, places: dict[str, Span] | None = None, hint: str = ""
    ) -> None:
        """Reject an entry that was given before.

        Args:
            entry: The entry, or another name that is unique.
            span: Where it is given.
            places: Where others are given, if they are no entries.
            hint: The way out, if it is another than to remove one of them.
        """
        places, key = self.places if places is None else places, s.key_of(entry)
        if key in places:
            self.findings.refuse_second(f'"{entry}"', span, places[key], hint=hint)
        places[key] = span

    def need(self, entry: str, head: Span, example: str = "") -> None:
        """Report that a block lacks an entry.

        Args:
            head: Head of the block.
            example: An example; by default, the first of its forms.
        """
        self.findings.add(
            "TIS304", f'{self.what} needs "{entry}"', head,
            hint=f"for example: {example or self.kinds[entry].texts(entry)[0]}",
        )  # fmt: skip
