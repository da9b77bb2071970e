"""The role of each word of a statement, from the words and signs before it.

Of a statement that is half typed, the same says what could stand at its end.
"""

from collections.abc import Iterator
from contextlib import suppress
from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import replace

from tissuec.core import units
from tissuec.core.names import key_of
from tissuec.core.units import Dimension, parse_unit
from tissuec.lang.tokens import KEYWORD, NUMBER, SIGN, STRING, UNIT, Token
from tissuec.lang.tree import Statement
from tissuec.lang.words import JOINING_WORDS, RESERVED, TIME_WORDS
from tissuec.lsp import terms as t
from tissuec.lsp.blocks import block_of
from tissuec.lsp.following import FOLLOWING
from tissuec.lsp.orders import CHANGED, DIMENSIONS, forms_of, kinds_for
from tissuec.lsp.terms import Block, Term, Terms
from tissuec.scene.declarations import NAMED, TOP_LEVEL
from tissuec.scene.evidence import KNOWN
from tissuec.script.measures import MEASURES
from tissuec.script.verbs import VERBS

#: Kinds of names that numbers, and that orders, are about.
NUMBERS = ("param", "let")
SUBJECTS = ("set", "body", "joint", "tool")
#: Of those, what has nodes; by the sorts of sets and tools.
NODES = ("nodes", "body")
#: What a measure is taken of, by what it takes.
MEASURED_OF = {
    "nodes": (*NODES, "holding"),
    "springs": ("set", "body", "joint"),
    "any": ("set", "body", "joint", "holding"),
}
#: All of these differ from one another, so that a name tells which of them it is.
ONE_NAMESPACE = (*NUMBERS, *SUBJECTS, "force")

#: What is written like a measure, too.
_MEASURED = ("count", "positions", "error")
_CLAUSES = frozenset((*TIME_WORDS, *JOINING_WORDS))


class Expected(NamedTuple):
    """Completions that are allowed at a place.

    Attributes:
        terms: Words of the language.
        names: Kinds of names that are declared.
        scale: The property or quantity whose words can stand here.
        declares: Kind of the name that is new here.
        files: What kind of file is named here: "use", or the entry that names it.
        unit: Whether a unit can stand here.
        dimension: Of numbers here, where that is known.
    """

    terms: tuple[Terms, ...] = ()
    names: tuple[str, ...] = ()
    scale: str = ""
    declares: str = ""
    files: str = ""
    unit: bool = False
    dimension: Dimension | None = None


class Phrase(Struct, frozen=True, eq=False):
    """A phrase with one meaning, or the empty place for it at the end of a statement.

    Attributes:
        is_called: Whether a bracket follows, or can still follow.
    """

    statement: Statement
    block: Block
    parts: tuple[Token, ...]
    expected: Expected
    start: int
    stop: int
    is_called: bool = False

    @property
    def key(self) -> str:
        """Return the words as names are compared."""
        return key_of(" ".join(part.text.strip('"') for part in self.parts))

    @property
    def term(self) -> Term | None:
        """Return the word of the language that it is, if it is one."""
        for words in self.expected.terms:
            found = words.get(self.key)
            if found is not None and (self.is_called or found.behind != "("):
                return found
        return None


# --- reading ----------------------------------------------------------------------------------


def phrases(statement: Statement, block: Block | None = None) -> list[Phrase]:
    """Return the phrases of a statement, in order."""
    return list(_Reading(statement, block or block_of(statement)).all())


def phrase_at_end(statement: Statement, offset: int) -> tuple[Phrase, list[str]]:
    """Return the phrase that ends, or could begin, at an offset, and words that could follow.

    Of the words of a name that are typed so far, all belong to the phrase.
    """
    parts = [part for part in _pieces(statement) if part.start < offset]
    if parts and (last := parts[-1]).stop >= offset:
        kind = "WORD" if last.kind in (KEYWORD, UNIT) else last.type  # it may go on
        parts[-1] = Token(kind, last.text[: offset - last.start], last.start, offset)
    cut = replace(statement, parts=parts, stop=offset, is_head=False)
    reading = _Reading(cut, block_of(statement), is_cut=True)
    found = list(reading.all())
    if not parts or not parts[-1].is_name:
        found.append(reading.empty())
    return found[-1], reading.following()


def _pieces(statement: Statement) -> list[Token]:
    """Return the tokens of a statement, numbers and their units one by one."""
    return [piece for part in statement.parts for piece in part.pieces]


class _Reading:
    """One pass over the parts of a statement."""

    def __init__(self, statement: Statement, block: Block, *, is_cut: bool = False):
        self.is_cut = is_cut
        self.statement, self.block, self.parts = statement, block, _pieces(statement)
        self.head = ""  # first word of the statement, of an order: the verb
        self.subject = ""  # what stands before "is", or "="
        self.clause = ""
        self.object = ""  # literal words behind a verb, such as "spring constant"
        self.seen: list[str] = []  # clauses so far
        self.calls: list[str] = []  # what each open bracket belongs to
        self.commas: list[int] = []
        self.behind_is = self.is_between = self.behind_equal = False
        self.behind_where = self.behind_then = False
        self.is_order = block == Block("script", "inner")  # in a block of orders
        self.measure: Dimension | None = None
        self.read = 0  # how many parts are read

    def all(self) -> Iterator[Phrase]:
        index = 0
        while index < len(self.parts):
            part = self.parts[index]
            if not part.is_name:
                self._take(part, index)
                index += 1
                continue
            stop = index + 1
            while part.kind != STRING and stop < len(self.parts) and self.parts[stop].is_name:
                part = self.parts[stop]
                stop += 1
            self.read = stop
            yield from self._run(index, stop)
            index = self.read

    def empty(self) -> Phrase:
        """Return the place behind the last part."""
        return list(self._run(len(self.parts), len(self.parts)))[-1]

    def _phrase(self, start: int, stop: int, expected: Expected) -> Phrase:
        parts = tuple(self.parts[start:stop])
        nowhere = self.statement.stop
        first, last = (parts[0].start, parts[-1].stop) if parts else (nowhere, nowhere)
        behind = self.parts[stop].text if stop < len(self.parts) else ""
        is_called = behind == "(" or (self.is_cut and not behind)
        return Phrase(self.statement, self.block, parts, expected, first, last, is_called)

    # --- signs and reserved words -------------------------------------------------------------

    def _take(self, part: Token, index: int) -> None:
        """Remember what a sign, a number or a reserved word says of what follows."""
        if part.kind == KEYWORD:
            self._keyword(part.text, index)
        elif part.kind == UNIT:
            self._unit(part.text)
        elif part.kind != SIGN:
            pass
        elif part.text in "([":
            before = self.parts[index - 1] if index else None
            is_call = part.text == "(" and before is not None and before.kind == "word"
            self.calls.append(self._last_words(index) if is_call else part.text)
            self.commas.append(0)
        elif part.text in ")]":
            if self.calls:
                self.calls.pop()
                self.commas.pop()
        elif part.text == "=":
            self.behind_equal = True
        elif part.text == "," and self.commas:
            self.commas[-1] += 1
        elif part.text == ":" and self.block.kind == "script":
            self.head, self.clause, self.is_order = "", "", True
            self.seen.clear()

    def _keyword(self, word: str, index: int) -> None:
        if index == 0:
            self.head = word
        if word == "is":
            self.behind_is, self.is_between = True, False
        elif word == "between":
            self.is_between = True
        elif word == "and" and self.is_between:
            self.is_between = False
        elif word != "not":
            self.behind_is = False
        if word == "where":
            self.behind_where, self.clause = True, ""
        if word == "then":
            self.behind_then = True
        if word in _CLAUSES and not (self.behind_where or self._in_measure()):
            self.clause, self.behind_is = word, False
            self.seen.append(word)

    def _unit(self, unit: str) -> None:
        with suppress(ValueError, ArithmeticError):
            self.measure = self.measure or parse_unit(unit).dimension

    def _last_words(self, index: int) -> str:
        """Return the words directly before a part."""
        start = index
        while start and self.parts[start - 1].is_name:
            start -= 1
        return key_of(" ".join(part.text for part in self.parts[start:index]))

    @property
    def _is_of_interface(self) -> bool:
        """Return whether this says what springs between two regions are made of."""
        return self.block.kind == "body" and self.subject == "interface"

    def _in_measure(self) -> bool:
        return any(call in MEASURES or call in _MEASURED for call in self.calls)

    # --- runs of words ------------------------------------------------------------------------

    def _run(self, start: int, stop: int) -> Iterator[Phrase]:
        """Yield the phrases of a run of words and what they are there for."""
        before = self.parts[start - 1] if start else None
        if before is None or (before.text == ":" and self.is_order):
            yield from self._beginning(start, stop)
        elif before.kind == NUMBER or (before.kind == SIGN and before.text == ")"):
            yield self._phrase(start, stop, Expected(unit=True, dimension=self._dimension()))
        elif self.behind_is and before.text in ("is", "not", "between", "and"):
            yield from self._choice(start, stop)
        elif self._is_of_interface and before.text in ("from", "to"):
            yield self._phrase(start, stop, Expected(names=("region",)))
        else:
            yield from self._value(start, stop, before)

    def _choice(self, start: int, stop: int) -> Iterator[Phrase]:
        """Yield what stands behind ``is``, as long a word of the language as there is."""
        expected = self._choices()
        longest = stop
        while longest < len(self.parts) and self.parts[longest].kind in ("word", KEYWORD):
            longest += 1
        for end in range(longest, stop, -1):
            phrase = self._phrase(start, end, expected)
            if phrase.term is not None:  # "centre of gravity" holds a reserved word
                self.read = end
                yield phrase
                return
        yield self._phrase(start, stop, expected)

    def _choices(self) -> Expected:
        kind, subject = self.block.kind, self.subject
        if self.behind_where:
            return Expected(names=("region",)) if subject == "region" else Expected()
        if kind == "rules" and self.head == "if":
            return Expected(scale=subject)
        if subject == "otherwise":
            return Expected(scale=self.block.member)
        if subject == "tissue":
            return Expected(names=("tissue",))
        known = t.entries(self.block).get(subject)
        if known is not None:
            return Expected((known.choices,)) if known.choices else Expected()
        return Expected(scale=subject)

    # --- where statements begin ---------------------------------------------------------------

    def _beginning(self, start: int, stop: int) -> Iterator[Phrase]:
        match self.block.kind:
            case "":
                yield from self._part(start, stop)
            case "script":
                yield from self._order(start, stop)
            case "data":
                yield self._phrase(start, stop, Expected(names=("param",)))
            case "unknown":
                yield self._phrase(start, stop, Expected())
            case _:
                yield from self._entry(start, stop)

    def _part(self, start: int, stop: int) -> Iterator[Phrase]:
        first = self.parts[start].text if start < stop else ""
        known = Expected((t.parts(),))
        if first.lower() not in TOP_LEVEL or first in RESERVED:
            yield self._phrase(start, stop, known)
            return
        self.head = first.lower()
        yield self._phrase(start, start + 1, known)
        behind = start + 1
        if self._is_open(behind, stop):
            yield self._phrase(behind, stop, self._declared())

    def _is_open(self, start: int, stop: int) -> bool:
        """Return whether words stand there, or can be typed there now."""
        if not self.is_cut or start < stop:
            return start < stop
        return stop == len(self.parts) and self.parts[-1].stop < self.statement.stop

    def _declared(self) -> Expected:
        """Return what stands behind the first word of a part."""
        if self.head == "use":
            return Expected(files="use")
        if self.head == "quantity":
            return Expected((t.QUANTITY_TERMS,), declares="quantity")
        return Expected(declares=self.head if self.head in (*NAMED, "hedge") else "")

    def _entry(self, start: int, stop: int) -> Iterator[Phrase]:
        """Yield an entry of a block, and what is named with it."""
        known = t.entries(self.block)
        names = ("property",) if self.block.kind == "tissue" else ()
        declares = "word" if self.block.kind in ("property", "quantity") else ""
        expected = Expected((known,), names, declares=declares)
        typed = self._phrase(start, stop, expected)
        longer = (name for name in known if name.startswith(typed.key) and name != typed.key)
        if self.is_cut and start < stop == len(self.parts) and any(longer):
            yield typed  # it may become that
            return
        for end in range(stop, start, -1):
            phrase = self._phrase(start, end, expected)
            if phrase.key in known and self.parts[end - 1].kind != STRING:
                self.subject = phrase.key
                yield phrase
                if self._is_open(end, stop):
                    named = self._phrase(end, stop, self._named_with(phrase.key))
                    self.object = named.key
                    yield named
                return
        self.subject = typed.key
        yield typed

    def _named_with(self, entry: str) -> Expected:
        if entry == "region":
            return Expected(declares="region")
        if entry == KNOWN:
            return Expected((t.KNOWN_TERMS,))
        if entry == "adjust":
            return Expected((t.adjusted(),), ("param",))
        if self.block.kind == "learn" and entry in ("against column", "write"):
            return Expected()
        takes_file = t.entries(self.block)[entry].behind == t.IN_QUOTES
        return Expected(files=entry) if takes_file else Expected()

    def _order(self, start: int, stop: int) -> Iterator[Phrase]:
        """Yield a verb, words that go with it, and what it is done to."""
        is_timed = self.is_order or start == 0
        verb = self.parts[start].text.lower() if start < stop else ""
        if verb not in VERBS or not is_timed:
            yield self._phrase(start, stop, Expected((t.verbs(),)))
            return
        self.head, self.object = verb, ""
        yield self._phrase(start, start + 1, Expected((t.verbs(),)))
        behind = start + 1
        if not self._is_open(behind, stop):
            return
        forms = forms_of(verb)
        literals = t.plain(
            t.ENTRY, dict.fromkeys(form.literal for form in forms if form.literal)
        )
        for end in range(stop, behind, -1):
            phrase = self._phrase(behind, end, Expected((literals,), self._objects("")))
            if phrase.term is not None:
                self.object = phrase.key
                yield phrase
                behind = end
                break
        if self._is_open(behind, stop):
            unsaid = () if self.object else (literals,)
            yield self._phrase(behind, stop, Expected(unsaid, self._objects(self.object)))

    def _objects(self, literal: str) -> tuple[str, ...]:
        """Return what kinds of names a verb takes behind these words."""
        kinds = (
            kind
            for form in forms_of(self.head)
            if form.literal == literal
            for kind in kinds_for(self.head, literal, form.placeholder)
        )
        return tuple(dict.fromkeys(kinds))

    # --- everywhere else ----------------------------------------------------------------------

    def _value(self, start: int, stop: int, previous: Token) -> Iterator[Phrase]:
        expected = self._expected(previous)
        phrase = self._phrase(start, stop, expected)
        if previous.text == "table" and self.head != "table":
            yield self._phrase(start, stop, Expected(files="table"))
            return
        if stop - start > 1 and self.parts[stop - 1].kind == STRING:
            first = self._phrase(start, stop - 1, expected)
            if first.term is not None:  # columns "id x y z"
                yield first
                yield self._phrase(stop - 1, stop, Expected())
                return
        if phrase.term is not None and phrase.term.dimension is not None:
            self.measure = phrase.term.dimension
        if self.behind_where or (self.block.kind == "rules" and not self.behind_is):
            self.subject = phrase.key or self.subject
        yield phrase

    def _expected(self, before: Token) -> Expected:
        call = self.calls[-1] if self.calls else ""
        if self._in_measure() and not (self.calls and call in t.functions()):
            return self._argument(before, call)
        if self.block.kind == "rules" and self.head == "if":
            if self.clause:
                return self._number()
            return Expected(names=("quantity",) if self.behind_then else ("property",))
        if call in t.HEDGE_TERMS and self.commas[-1]:
            return Expected((t.DIRECTION_TERMS,))
        if self.behind_where:
            return self._number(self._conditions(before))
        if self.block.kind in ("tissue", "law") and self.subject in t.FORMULAS:
            return self._formula()
        if self.clause:
            return self._in_clause(before)
        return self._plain(call)

    def _conditions(self, before: Token) -> Terms:
        """Return what nodes or springs are chosen by, and can stand behind a part."""
        place = self.parts.index(before)
        texts = [part.text for part in self.parts[: place + 1]]
        while len(texts) > 1 and texts[-1] == "(":
            texts.pop()
        since = max((n for n, text in enumerate(texts) if text == "between"), default=-1)
        is_limit = texts[-1] == "and" and since >= 0 and "and" not in texts[since:-1]
        begins = texts[-1] in ("where", "and", "or", "not") and not is_limit
        found = t.conditions(of_springs="springs" in texts, are_tests=begins)
        if self.block.kind == "body":  # regions are there before ids are
            return {key: term for key, term in found.items() if key != "id"}
        return found

    def _plain(self, call: str) -> Expected:
        """Return what stands behind ``=`` and the like."""
        match self.block.kind, self.head:
            case "", ("param" | "let" | "set") if not self.behind_equal:
                return Expected(declares=self.head)
            case "", "set":
                parts = ("set", "body", "joint")
                return Expected(names=parts) if call == "[" else Expected((t.CHOSEN_FROM,))
            case "", "hedge":
                return self._number(t.HEDGE_TERMS)
            case ("", "expect"):
                return self._number(t.measures(), t.errors())
            case ("script", "when"):
                return self._number(t.measures())
            case ("learn", _) if self.subject in ("data", "hold out") and self.behind_equal:
                return Expected(files="data")
            case ("learn", _) if self.subject == "adjust":
                known = t.adjusted_in_lists() if call == "[" else t.adjusted()
                return Expected((known,), ("param",))
            case ("learn", _) if self.subject == "fit":
                return Expected((t.fitted(),))
            case "", "table":
                return Expected((t.CHOSEN_FROM,))
            case (("property" | "quantity"), _):
                if self.subject == "evenly":
                    return Expected(declares="word")
                return self._number(t.SHAPE_TERMS)
            case _:
                return self._number()

    def _formula(self) -> Expected:
        """Return what a formula of a law is of, or is made of."""
        texts = [part.text for part in self.parts]
        if not self.behind_equal:
            return Expected((t.FORMULAS[self.subject],), declares="variable")
        between = self.parts[texts.index("of") + 1 : texts.index("=")] if "of" in texts else []
        own = t.plain(t.VARIABLE, [part.text for part in between if part.is_name])
        meant = set(t.ARGUMENTS[self.subject]) - set(own)
        known = t.FORMULAS[self.subject].items()
        return self._number(own, {key: term for key, term in known if key not in meant})

    def _number(self, *known: Terms) -> Expected:
        return Expected((*known, t.functions()), NUMBERS, dimension=self._dimension())

    def _argument(self, before: Token, call: str) -> Expected:
        """Return what a measure is taken of, or where and when."""
        if call == "error":
            return Expected((t.ERRORS_OF,))
        if before.text == "along":
            return self._number()
        if call == "count" and before.text == "(":
            return Expected((t.COUNTED,))
        if before.text in ("(", ",", "of"):
            place = self.parts.index(before)
            names = self._measured_of(self._last_words(place) if call == "count" else call)
            is_time = before.text == "," and call in MEASURES
            if is_time and self.commas[-1] >= MEASURES[call].subjects:
                return self._number()._replace(dimension=units.TIME)
            return Expected(names=names)
        return self._number()

    def _measured_of(self, measure: str) -> tuple[str, ...]:
        """Return kinds of names of what a measure is taken of."""
        if measure in MEASURES:
            return MEASURED_OF[MEASURES[measure].takes]
        return NODES

    def _in_clause(self, before: Token) -> Expected:
        """Return what stands behind a joining word, or further on in what it joins."""
        word, is_first = self.clause, before.text == self.clause
        match self.block.kind:
            case "":
                return self._in_part(word)
            case "script" if self.is_order and self.head in VERBS:
                return self._in_order(word, is_first)
            case "script":
                if self.head == "when":
                    return self._number(t.measures())
                return self._number()._replace(dimension=units.TIME)
            case "tissue" | "law" if word == "in":
                return Expected(names=("rules",))
            case "tissue" if word == "by":
                return Expected((t.SOURCE_TERMS,))
            case "tissue" if word == "per":
                return self._number()._replace(dimension=units.LENGTH)
            case "joint" | "force":
                return Expected(names=NODES)
            case "learn":
                return self._in_learning(word)
            case "output" if self.subject == "surface":
                return Expected(names=("body",))
            case "output" if word in ("of", "to"):
                return Expected(names=self._measured_of(self.subject))
            case "output":
                return self._number()._replace(dimension=units.TIME)
            case "quantity" if word == "to" and self.subject == "applies":
                return Expected((t.SPREADS,))
            case "mesh" if word == "in":
                return Expected(unit=True, dimension=units.LENGTH)
            case _:
                return self._number()

    def _in_learning(self, word: str) -> Expected:
        """Return what stands behind a joining word of a learn block."""
        match self.subject, word:
            case _, "using":
                return Expected((t.COLUMN,))
            case _, "with":
                return Expected((t.FREE_ZERO,))
            case _, "in":
                return Expected(unit=True, dimension=self.measure)
            case _, "per":
                return Expected((t.DIVISIONS,))
            case "revise rules", "of":
                return Expected(names=("rules",))
            case "adjust", "of" if self.object == "words":
                return Expected(names=("quantity", "property"))
            case "adjust", "of":
                return Expected(names=("tissue", "set", "body", "joint", "region"))
            case _, "of":
                return Expected(names=("set", "body"))
            case _, "every":
                return self._number()._replace(dimension=units.TIME)
            case _:
                return self._number()

    def _in_part(self, word: str) -> Expected:
        match self.head, word:
            case "tissue", "like":
                return Expected(names=("tissue",))
            case (("property" | "quantity"), "on"):
                return Expected((t.LOG_SCALE,))
            case "set", "of":
                texts = [part.text for part in self.parts]
                return Expected(names=("body",) if "nodes" in texts else ("body", "joint"))
            case "table", "of":
                return Expected(names=("body",))
            case "table", "in":
                return Expected(unit=True, dimension=units.LENGTH)
            case "table", "with":
                return Expected((t.COLUMNS,))
            case "expect", "over":
                return Expected((t.RUN,))
            case "expect", _:
                return self._number()._replace(dimension=units.TIME)
            case _:
                return self._number()

    def _in_order(self, word: str, is_first: bool) -> Expected:
        """Return what a clause of an order holds, from the forms of its verb."""
        if word == "in":
            return Expected(unit=True, dimension=units.LENGTH)
        known: dict[str, Term] = {}
        names: list[str] = []
        for content in self._contents(word):
            first = content[0]
            if first in ("PROFILE", "COURSE"):
                known |= t.profiles()
            elif found := kinds_for(self.head, self.object, first):
                names += found
            elif first.isupper():
                is_first = False
            else:
                literal = " ".join(part for part in content if part.islower())
                known |= t.plain(t.CHOICE, [literal])
        known |= t.kinds_of_clause(self.head, word)
        if is_first:
            return Expected((known,), tuple(dict.fromkeys(names)))
        found = self._number(known)
        return found._replace(names=(*names, *found.names))

    def _contents(self, word: str) -> list[tuple[str, ...]]:
        """Return what can stand in a clause of an order, from the forms of its verb."""
        return [
            content
            for form in forms_of(self.head)
            for clause, content in form.clauses
            if clause == word and (form.literal or self.object) == self.object
        ]

    def _of_clause(self, word: str, placeholder: str) -> Dimension | None:
        if self.head == "change":
            return units.NUMBER if word == "by" else CHANGED.get(self.object)
        if self.head == "move" and word == "by":
            return units.LENGTH
        return DIMENSIONS.get(placeholder)

    def _dimension(self) -> Dimension | None:
        """Return the dimension of numbers here."""
        if self.block.kind == "script" and not self.is_order and self.head != "when":
            return units.TIME
        if self.block.kind == "script" and self.clause and self.head in VERBS:
            found = (self._of_clause(self.clause, c[0]) for c in self._contents(self.clause))
            return next((dimension for dimension in found if dimension is not None), None)
        if self.block.kind == "output" and self.clause == "every":
            return units.TIME
        if self.head == "expect" and self.clause:
            return units.TIME
        if self.behind_where:
            return units.LENGTH
        entries = t.KNOWN_TERMS if self.subject == KNOWN else t.entries(self.block)
        term = entries.get(self.object if self.subject == KNOWN else self.subject)
        if term is not None and term.dimension is not None:
            return term.dimension
        return self.measure

    # --- what can follow ----------------------------------------------------------------------

    def following(self) -> list[str]:
        """Return the reserved words that could follow."""
        kind = self.block.kind
        if kind == "script" and self.head in VERBS and self.is_order:
            return self._clauses_left()
        if kind == "rules" and self.head == "if":
            return (
                ["is", "and", "weighing"]
                if self.behind_then
                else ["is", "and", "or", "not", "then"]
            )
        if self.behind_where:
            return ["and", "or", "not", "is", "between", "within", "of"]
        if self._is_of_interface:
            last = (
                self.seen[-1]
                if self.seen
                else "is"
                if "is" in (part.text for part in self.parts)
                else ""
            )
            return {"": ["is", "from"], "is": ["from"], "from": ["to"]}.get(last, [])
        return list(FOLLOWING.get((kind, self.head), FOLLOWING.get((kind, ""), ())))

    def _clauses_left(self) -> list[str]:
        """Return the joining words of the forms of the verb that are not written yet."""
        words = (
            word
            for form in forms_of(self.head)
            if (form.literal or self.object) == self.object
            for word, _ in form.clauses
        )
        if "table" in (part.text for part in self.parts):
            return ["in"]  # the unit of its columns
        if self.clause == "using":
            return ["of"]  # the frequency of a sine
        return [word for word in dict.fromkeys(words) if word not in self.seen]
