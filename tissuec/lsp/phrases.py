"""The phrases of a statement, and reserved words that can follow at a place.

Of a statement that is half typed, the last phrase says what is allowed at its end. The grammar
then narrows the words that the forms of its sentence allow.
"""

from collections.abc import Iterator

from msgspec import Struct

from tissuec.core.names import key_of
from tissuec.core.structs import replace
from tissuec.lang.tokens import KEYWORD, NUMBER, STRING, UNIT, WORD, Token
from tissuec.lang.tree import Statement
from tissuec.lsp import context
from tissuec.lsp import vocabulary as v
from tissuec.lsp.expected import Expected
from tissuec.lsp.forms import fitting, forms_of
from tissuec.lsp.prefix import Prefix, block_of
from tissuec.lsp.terms import ENTRY, BlockKind, Term, plain
from tissuec.lsp.vocabulary import entries
from tissuec.scene.reading.parts import REPEAT
from tissuec.script.verbs import VERBS


class Phrase(Struct, frozen=True, eq=False):
    """A phrase with one meaning, or the empty place for it at the end of a statement.

    Attributes:
        is_called: Whether a bracket follows, or can still follow.
    """

    statement: Statement
    block: BlockKind
    parts: tuple[Token, ...]
    expected: Expected
    start: int
    stop: int
    is_called: bool = False

    @property
    def key(self) -> str:
        """Return the words as names are compared."""
        return _key(self.parts)

    @property
    def term(self) -> Term | None:
        """Return the word of the language that it is, if it is one."""
        for words in self.expected.terms:
            found = words.get(self.key)
            if found is not None and (self.is_called or found.behind != "("):
                return found
        return None

    @property
    def may_become_term(self) -> bool:
        """Return whether a word of the language begins so."""
        return any(name.startswith(self.key) for words in self.expected.terms for name in words)


def phrases(statement: Statement, block: BlockKind | None = None) -> list[Phrase]:
    """Return the phrases of a statement, in order."""
    return list(_PhraseReader(statement, block or block_of(statement)).all())


def phrase_at_end(statement: Statement, offset: int) -> tuple[Phrase, list[str]]:
    """Return the phrase that ends, or could begin, at an offset, and words that could follow.

    Of the words of a name that are typed so far, all belong to the phrase.
    """
    reader = _reader_up_to(statement, offset)
    parts, found = reader.parts, list(reader.all())
    if not parts or not parts[-1].is_name:
        found += reader.run(len(parts), len(parts))
    return found[-1], following(reader.prefix)


def prefix_at(statement: Statement, offset: int) -> Prefix:
    """Return the beginning of a statement, up to an offset."""
    reader = _reader_up_to(statement, offset)
    for _ in reader.all():
        pass
    return reader.prefix


def _reader_up_to(statement: Statement, offset: int) -> "_PhraseReader":
    """Return a reader of the part of a statement before an offset."""
    parts = [part for part in _pieces(statement) if part.start < offset]
    if parts and (last := parts[-1]).stop >= offset:
        kind = "WORD" if last.kind in (KEYWORD, UNIT) else last.type  # it may be unfinished
        parts[-1] = Token(kind, last.text[: offset - last.start], last.start, offset)
    cut = replace(statement, parts=parts, stop=offset, is_head=False)
    return _PhraseReader(cut, block_of(statement), is_cut=True)


def _pieces(statement: Statement) -> list[Token]:
    """Return the tokens of a statement, numbers and their units one by one."""
    return [piece for part in statement.parts for piece in part.pieces]


def _key(parts: tuple[Token, ...]) -> str:
    return key_of(" ".join(part.text.strip('"') for part in parts))


class _PhraseReader:
    """Divides the words of a statement into phrases, from left to right.

    Args:
        statement: The statement.
        block: Its block.
        is_cut: Whether more can be typed at its end.
    """

    def __init__(self, statement: Statement, block: BlockKind, *, is_cut: bool = False):
        self.statement, self.block, self.is_cut = statement, block, is_cut
        self.parts = _pieces(statement)
        self.prefix = Prefix(block)
        self.read = 0  # how many parts are read

    def all(self) -> Iterator[Phrase]:
        """Yield the phrases of the whole statement."""
        index, count = 0, len(self.parts)
        while index < count:
            part = self.parts[index]
            if not part.is_name:
                self.prefix.take(part)
                index += 1
                continue
            stop = index + 1
            while part.kind != STRING and stop < count and self.parts[stop].is_name:
                part = self.parts[stop]
                stop += 1
            self.read = stop
            yield from self.run(index, stop)
            self.prefix.tokens += self.parts[index : self.read]
            index = self.read

    def run(self, start: int, stop: int) -> Iterator[Phrase]:
        """Yield the phrases of words side by side; of none, the place for them."""
        prefix = self.prefix
        before = prefix.last
        if before is None or (before.text == ":" and prefix.is_order):
            yield from self._beginning(start, stop)
        elif before.kind == NUMBER or before.text == ")":
            yield self._phrase(start, stop, context.behind_number(prefix))
        elif prefix.is_choosing and before.kind == KEYWORD:
            yield from self._choice(start, stop)
        else:
            yield from self._value(start, stop)

    def _phrase(self, start: int, stop: int, expected: Expected) -> Phrase:
        parts = tuple(self.parts[start:stop])
        nowhere = self.statement.stop
        first, last = (parts[0].start, parts[-1].stop) if parts else (nowhere, nowhere)
        behind = self.parts[stop].text if stop < len(self.parts) else ""
        is_called = behind == "(" or (self.is_cut and not behind)
        return Phrase(self.statement, self.block, parts, expected, first, last, is_called)

    def _is_last(self, stop: int) -> bool:
        """Return whether more can be typed after a part."""
        return self.is_cut and stop == len(self.parts)

    def _is_open(self, start: int, stop: int) -> bool:
        """Return whether words are there, or can be typed there now."""
        if not self.is_cut or start < stop:
            return start < stop
        return stop == len(self.parts) and self.parts[-1].stop < self.statement.stop

    def _choice(self, start: int, stop: int) -> Iterator[Phrase]:
        """Yield the phrase after ``is``: the longest word of the language that fits."""
        expected = context.choices(self.prefix)
        longest = stop
        while longest < len(self.parts) and self.parts[longest].kind in (WORD, KEYWORD):
            longest += 1
        for end in range(longest, stop, -1):
            phrase = self._phrase(start, end, expected)
            # "centre of gravity" holds a reserved word.
            if phrase.term is not None or (self._is_last(end) and phrase.may_become_term):
                self.read = end
                yield phrase
                return
        yield self._phrase(start, stop, expected)

    # --- where statements begin ---------------------------------------------------------------

    def _beginning(self, start: int, stop: int) -> Iterator[Phrase]:
        match self.block.kind:
            case "script":
                yield from self._order(start, stop)
            case "data":
                yield self._phrase(start, stop, Expected(names=("param",)))
            case "unknown":
                yield self._phrase(start, stop, Expected())
            case _:
                yield from self._entry(start, stop)

    def _entry(self, start: int, stop: int) -> Iterator[Phrase]:
        """Yield an entry of a block, and the name after it."""
        known = entries(self.block)
        names = ("property",) if self.block.kind == "tissue" else ()
        declares = "word" if self.block.kind in ("property", "quantity") else ""
        expected = Expected((known,), names, declares=declares)
        typed = self._phrase(start, stop, expected)
        longer = (name for name in known if name.startswith(typed.key) and name != typed.key)
        if start < stop and self._is_last(stop) and any(longer):
            self.prefix.subject = typed.key  # it may become that
            yield typed
            return
        for end in range(stop, start, -1):
            phrase = self._phrase(start, end, expected)
            if phrase.key in known and self.parts[end - 1].kind != STRING:
                self.prefix.subject = phrase.key
                self.prefix.head = phrase.key if self.block.kind in ("", "script") else ""
                yield phrase
                if self._is_open(end, stop):
                    named = self._phrase(end, stop, context.named_with(self.prefix))
                    self.prefix.object = named.key
                    yield named
                return
        self.prefix.subject = typed.key
        yield typed

    def _order(self, start: int, stop: int) -> Iterator[Phrase]:
        """Yield a verb, its further words, and its object."""
        prefix = self.prefix
        verb = self.parts[start].text.lower() if start < stop else ""
        if verb == REPEAT:
            yield from self._entry(start, stop)
            return
        if verb not in VERBS:
            yield self._phrase(start, stop, Expected((v.verbs(), entries(self.block))))
            return
        prefix.head, prefix.object = verb, ""
        yield self._phrase(start, start + 1, Expected((v.verbs(),)))
        behind = start + 1
        if not self._is_open(behind, stop):
            return
        found = dict.fromkeys(form.literal for form in forms_of("script", verb) if form.literal)
        literals = plain(ENTRY, found)
        for end in range(stop, behind, -1):
            phrase = self._phrase(behind, end, Expected((literals,), context.objects(prefix)))
            if phrase.term is not None:
                prefix.object = phrase.key
                yield phrase
                behind = end
                break
        if self._is_open(behind, stop):
            unsaid = () if prefix.object else (literals,)
            yield self._phrase(behind, stop, Expected(unsaid, context.objects(prefix)))

    # --- everywhere else ----------------------------------------------------------------------

    def _value(self, start: int, stop: int) -> Iterator[Phrase]:
        prefix = self.prefix
        expected = context.expected_in(prefix)
        phrase = self._phrase(start, stop, expected)
        if stop - start > 1 and self.parts[stop - 1].kind == STRING:
            first = self._phrase(start, stop - 1, expected)
            if first.term is not None:  # columns "id x y z"
                yield first
                yield self._phrase(stop - 1, stop, Expected())
                return
        if phrase.term is not None and phrase.term.dimension is not None:
            prefix.dimension = phrase.term.dimension
        if prefix.has("where") or (prefix.block.kind == "rules" and not prefix.is_choosing):
            prefix.subject = phrase.key or prefix.subject
        yield phrase


_LOGIC = ("and", "or", "not", "is", "between", "within", "of")
_OF_TRIGGERS = ("to", "every", "and", "or", "not", "between", "along")


def following(prefix: Prefix) -> list[str]:
    """Return the reserved words that could follow, in the order of the forms."""
    kind, head = prefix.block.kind, prefix.head
    if prefix.has_verb and "table" in prefix.texts:
        return ["in"]  # the unit of its columns
    if prefix.has_verb and prefix.clause == "using":
        return ["of"]  # the frequency of a sine
    if kind == "rules" and head == "if":
        return (
            ["is", "and", "weighing"]
            if prefix.has("then")
            else ["is", "and", "or", "not", "then"]
        )
    if prefix.has("where"):
        return list(_LOGIC)
    if kind == "script" and not prefix.has_verb and head != REPEAT:
        return list(_OF_TRIGGERS)
    return [*([] if prefix.calls else _clauses_left(prefix)), *_inside(prefix)]


def _clauses_left(prefix: Prefix) -> Iterator[str]:
    """Yield the joining words of the forms of a sentence that are not written yet."""
    found = dict[str, None]()
    for form in fitting(prefix):
        words = [one.word for one in form.clauses]
        past = words.index("=") + 1 if "=" in words and prefix.has("=") else 0
        for index, one in enumerate(form.clauses[past:], start=past):
            is_left = prefix.openers.count(one.word) == words[:index].count(one.word)
            is_next = all(prefix.has(word) if word else prefix.object for word in one.needs)
            if is_left and is_next and one.word not in ("", "="):
                found[one.word] = None
    yield from found


def _inside(prefix: Prefix) -> tuple[str, ...]:
    """Return the words that may follow what is chosen or measured at a place."""
    if prefix.head == "expect" and prefix.block.kind == "study":
        return ("and", "or", "not", "between")
    if prefix.head == "expect":
        return ("and", "or", "not", "between", "along", "of")
    if prefix.block.kind == "tissue" and prefix.is_choosing:
        return ("between", "and")
    return ("along", "of") if prefix.in_measure else ()
