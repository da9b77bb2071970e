"""Syntax errors in plain words, from the tokens around them and the accepted tokens.

Each function looks for one kind of mistake. The first that recognises it has the word.
"""

import re
from collections.abc import Iterator
from itertools import takewhile

from tissuec.core.errors import Diagnostic, Note
from tissuec.core.hints import Edit, Hint, did_you_mean, leaving_out
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import ALL_UNITS, SYMBOLS, alternatives_of, converted, near_unit
from tissuec.lang.adjusted_lists import adjusted_list
from tissuec.lang.habits import habit, inches
from tissuec.lang.mistake import CHARACTER, ENDS, Mistake
from tissuec.lang.token_names import expected, shown
from tissuec.lang.tokens import Token, number_and_unit
from tissuec.lang.unopened import begins_block
from tissuec.lang.words import (
    CONTINUING,
    DECLARING_WORDS,
    JOINING_WORDS,
    RESERVED,
    STARTING,
    TIME_WORDS,
)
from tissuec.lang.wrong_sign import (
    BINDERS,
    NUMBERS,
    TIMES,
    equal_for_is,
    equals_as_test,
    is_before_number,
    is_for_equal,
    sign_before_clause,
)

_KEYWORDS = frozenset(word.upper() for word in RESERVED)
_STARTERS = frozenset(word.upper() for word in STARTING) - TIMES
_NAMING = _KEYWORDS - {"IS"} | {"WORD", "STRING"}
_PLAIN = r"[0-9]+(?:\.[0-9]+)?"
_PER_SECOND = re.compile(r"1/s\b")

#: What may follow a unit to make it a larger one.
_FURTHER_UNITS = re.compile(r"([*/·][^\W\d_]+(\^-?[0-9]+)?)*")

#: The beginnings of statements that hold no colon.
_KEYWORDS_ALONE = [[word.upper()] for word in DECLARING_WORDS]

#: After a word that begins a statement, one of these comes next.
_GOES_ON = frozenset({"WORD", "STRING", "EQUAL", "IS", "LBRACE"})


def classify(mistake: Mistake) -> Diagnostic:
    """Return the finding about a syntax error."""
    for recognise in _KINDS:
        finding = recognise(mistake)
        if finding:
            return finding
    return _anything(mistake)


def _decimal_comma(m: Mistake) -> Diagnostic | None:
    if m.found.type != "COMMA" or m.previous != "NUMBER" or m.next not in NUMBERS:
        return None
    if m.before[-1].stop != m.found.start or m.found.stop != m.after[0].start:
        return None
    if m.before[0].text == "vary" and any(token.type == "COMMA" for token in m.after):
        return None  # several values
    head = m.text(m.before[0], m.before[-1])
    written = shown(f"{head}.{m.text(m.after[0], m.after[-1])}")
    hint = Hint(f"write {written}", Edit("."))
    if re.match(r"[0-9]{3}(?![0-9])", m.after[0].text):
        whole = f"{m.before[-1].text}{m.after[0].text}"
        hint = Hint(f'{hint}, or "{whole}": digits are not grouped', *hint.edits, Edit(""))
    return m.finding("TIS108", "a decimal comma is not allowed", hint)


def _missing_colon(m: Mistake) -> Diagnostic | None:
    timed = m.first in TIMES or m.first == "WHEN"
    if not timed or "COLON" not in m.accepted or m.holds("COLON"):
        return None
    if m.first == "AT" and _is_of_tool(m):
        return _place_of_tool(m)
    if m.found.type == "WORD" and m.previous in NUMBERS and m.next == "COLON":
        return None  # a unit that is misspelt
    if m.first == "WHEN" and m.found.type in TIMES:
        return _time_of_when(m)
    message = f'missing ":" after the {"condition" if m.first == "WHEN" else "time"}'
    if m.found.type in ENDS or m.found.type == CHARACTER:
        hint = f'write "{m.text(m.before[0], m.before[-1])}: …", followed by the action'
        return m.finding("TIS105", message, hint)
    head = m.text(m.before[0], m.before[-1])
    if m.found.type == "COMMA" and m.next in NUMBERS:
        hint = "write a statement for each time, or: from … to … every …: …"
        return m.finding("TIS105", "a statement has one time only", hint)
    rest = m.text(m.found, m.after[-1] if m.after else m.found)
    hint = Hint(f"write {shown(f'{head}: {rest}')}", Edit(":", m.behind))
    return m.finding("TIS105", message, hint)


def _is_of_tool(m: Mistake) -> bool:
    """Return whether a statement is in the block of a tool."""
    outer = m.statement.outer
    return outer is not None and bool(outer.parts) and outer.parts[0].text == "tool"


def _place_of_tool(m: Mistake) -> Diagnostic:
    """Return the finding about ``tool ball { …; at (0, 0, 9) mm }``."""
    place = m.text(m.before[1], m.before[-1]) if m.before[1:] else "(0, 0, 0) mm"
    hint = Hint(f"write {shown(f'centre = {place}')}", Edit("centre =", m.span(m.before[0])))
    return m.finding("TIS105", '"at" begins a time, and a tool has none', hint, m.before[0])


def _time_of_when(m: Mistake) -> Diagnostic:
    """Return the finding about ``when force(a) > 2 N at 0.1 s: …``."""
    hint = Hint(f"write {shown(f'{m.text(m.before[0], m.before[-1])}: …')}")
    colon = next((token for token in m.after if token.type == "COLON"), None)
    if colon is not None:
        hint = Hint(hint, Edit("", Span(m.source, m.behind.start, colon.start)))
    message = 'a "when" waits for a condition and has no time'
    return m.finding("TIS105", message, hint)


def _unit(m: Mistake) -> Diagnostic | None:
    """Recognise a word after a number that is no unit, or a unit where none is allowed."""
    if m.found.type == "RPAR_UNIT":
        message = f'the unit "{m.found.text[1:].strip()}" follows neither a number nor a vector'
        hint = Hint("write it after each number", *_inside_brackets(m))
        return m.finding("TIS104", message, hint)
    if m.found.type != "WORD" or m.next in _GOES_ON:
        return None
    word = m.found.text
    if m.previous == "QUANTITY" and (word in SYMBOLS or word == "Hg"):
        return _two_units(m, word)
    if m.previous in ("RPAR", "RSQB") and word in SYMBOLS:
        message = f'the unit "{word}" follows neither a number nor a vector'
        return m.finding("TIS104", message, "write it after each number")
    near = _near_unit(m, word)
    if m.previous == "NUMBER" and m.unit and m.unit.text.isascii():
        number = m.before[-1]
        if text := converted(number.text, m.unit.text):
            place = m.span(number).to(m.unit)
            message = f'"{m.unit.text}" is not a unit of the language'
            hint = Hint(f'write "{text}"', Edit(text, place))
            return m.finding("TIS104", message, hint)
    if m.previous == "NUMBER" or (m.previous == "RPAR" and near):
        return m.finding("TIS104", f'"{word}" is not a unit', near or ALL_UNITS)
    return None


def _two_units(m: Mistake, word: str) -> Diagnostic:
    """Return the finding about ``0.04 N mm``, ``40 mm Hg`` and ``500 ms s``."""
    unit = number_and_unit(m.before[-1].text)[1]
    place = m.behind.to(m.span(m.found))
    message = f'"{unit} {word}" is not a unit'
    if f"{unit}{word}" in SYMBOLS:
        return m.finding("TIS104", message, Hint(f'write "{unit}{word}"', Edit(word, place)))
    if word == "Hg":
        return m.finding("TIS104", message, 'write a pressure in "mmHg"')
    signs = alternatives_of(unit, word)
    if not signs:
        hint = Hint(f'write one unit: "{m.before[-1].text}"', Edit("", place))
        return m.finding("TIS104", message, hint)
    hint = " or ".join(f'"{unit}{sign}{word}"' for sign in signs)
    edit = Edit(f"{signs[0]}{word}", place)
    return m.finding("TIS104", message, Hint(f"write {hint}", edit))


def _inside_brackets(m: Mistake) -> list[Edit]:
    """Return the edit of "(3 + 4) mm" that writes the unit after each number of the sum."""
    place = m.span(m.found)
    text = m.source.text
    start = text.rfind("(", 0, place.start)
    inner, unit = text[start + 1 : place.start], m.found.text[1:].strip()
    if start < 0 or re.fullmatch(rf"{_PLAIN}(?: *[-+] *{_PLAIN})*", inner) is None:
        return []
    written = re.sub(rf"({_PLAIN})", rf"\1 {unit}", inner)
    return [Edit(f"({written})", Span(m.source, start, place.end))]


def _near_unit(m: Mistake, word: str) -> Hint:
    if product := _run_together(word):
        rest = _FURTHER_UNITS.match(m.source.text, m.found.stop)
        return Hint(f'did you mean "{product}{rest[0] if rest else ""}"?', Edit(product))
    return near_unit(word)


def _run_together(word: str) -> str:
    """Return two units of different kinds with the sign between them that is left out."""
    for i in range(1, len(word)):
        first, second = SYMBOLS.get(word[:i]), SYMBOLS.get(word[i:])
        if first and second and first[1] != second[1]:
            return f"{word[:i]}*{word[i:]}"
    return ""


def _path_without_quotes(m: Mistake) -> Diagnostic | None:
    if not m.before or m.before[0].text.lower() != "use" or m.found.text not in ("/", "."):
        return None
    if any(token.type != "WORD" for token in m.before):
        return None
    end = m.source.text.rstrip().find("\n", m.found.start)
    written = m.source.text[m.before[0].stop : end if end > 0 else None]
    path = written.split("#")[0].strip("; \t\n")
    start = m.before[0].stop
    quoted = Edit(
        f' "{path}"', Span(m.source, start, start + len(written.split("#")[0].rstrip("; \t")))
    )
    hint = Hint(f'write use "{path}"', quoted)
    return m.finding("TIS312", "a path must be in quotes", hint)


def _colon_after_keyword(m: Mistake) -> Diagnostic | None:
    """Recognise ``expect: energy drift < 1 %``, ``let: x = 3 mm`` and ``body: pad {``."""
    if m.found.type != "COLON":
        return None
    is_head = len(m.before) == 1 and m.after and m.statement.is_head
    if [one.type for one in m.before] not in _KEYWORDS_ALONE and not (
        is_head and begins_block(m.before[0].text)
    ):
        return None
    hint = Hint('leave out ":"', Edit(""))
    return m.finding("TIS312", '":" is allowed only after a time or a condition', hint)


def _colon_for_equal(m: Mistake) -> Diagnostic | None:
    name = m.words_before
    if m.found.type != "COLON" or "EQUAL" not in m.accepted or not name or not m.after:
        return None
    if all(token.type in _NAMING for token in m.before):
        name = m.text(m.before[0], m.before[-1])
    value = m.text(m.after[0], m.after[-1])
    sign = "is" if m.next == "WORD" else "="
    hint = Hint(f"write {shown(f'{name} {sign} {value}')}", Edit(f" {sign}"))
    return m.finding("TIS312", '":" is allowed only after a time or a condition', hint)


def _colon_for_brace(m: Mistake) -> Diagnostic | None:
    """Recognise the head of a block that ends with a colon, and is indented below."""
    name = m.words_before
    if m.found.type != "COLON" or not name or m.first in TIMES | {"WHEN"}:
        return None
    if m.after and not (len(m.before) > 1 and begins_block(m.before[0].text)):
        return None
    edits = [Edit(" {")] if m.after else []
    hint = Hint(f'write "{name} {{", and "}}" at the end of the block', *edits)
    return m.finding("TIS312", "a block is enclosed in braces", hint)


def _named_argument(m: Mistake) -> Diagnostic | None:
    """Recognise a call as in a program: ``vessel = Body(mesh="tube")``."""
    if m.found.type != "EQUAL" or [t.type for t in m.before[-2:]] not in _ARGUMENTS:
        return None
    if "EQUAL" not in [token.type for token in m.before]:
        return None
    hint = "a scene is made of blocks: body NAME { mesh is tube { … }; tissue is NAME }"
    finding = m.finding("TIS312", "this is the syntax of a programming language", hint)
    return replace(finding, notes=tuple(_undeclared(m)))


def _undeclared(m: Mistake) -> Iterator[Note]:
    """Yield a note about each number above that is set without param or let."""
    for line in _SET.finditer(m.source.text, 0, m.statement.start):
        place = Span(m.source, *line.span(1))
        yield Note(f'to declare a number, write "param {line[1]} = …"', place)


def _and_for_semicolon(m: Mistake) -> Diagnostic | None:
    """Recognise ``hardness is soft and elasticity is big`` where no condition is allowed."""
    if m.found.type != "AND" or not m.can_end or "IS" not in [t.type for t in m.after]:
        return None
    hint = Hint('write ";" instead', Edit(";", m.blank.to(m.span(m.found))))
    return m.finding("TIS107", '"and" does not join two statements', hint)


def _if_for_when(m: Mistake) -> Diagnostic | None:
    if m.first != "IF" or m.found.type != "COLON" or not m.before[1:]:
        return None
    hint = Hint(f"write {shown(f'when {m.text(m.before[1], m.before[-1])}: …')}", Edit("when"))
    message = 'a script waits for a condition with "when"'
    return m.finding("TIS312", message, hint, m.before[0])


def _rule_without_then(m: Mistake) -> Diagnostic | None:
    if m.first != "IF" or m.holds("THEN") or "THEN" not in m.accepted:
        return None
    if any(token.type == "THEN" for token in m.after):
        return None
    hint = 'write "if … then …", with the conclusion after "then"'
    return m.finding("TIS112", 'the rule has no "then"', hint)


def _reserved_as_entry(m: Mistake) -> Diagnostic | None:
    """Recognise ``every = 10 ms`` where an entry belongs."""
    tokens = [*m.before, m.found, *m.after]
    if tokens[0].type not in _KEYWORDS - BINDERS or len(tokens) < 3:
        return None
    if tokens[1].type != "EQUAL" or len(m.before) > 1:
        return None
    message = f'"{tokens[0].text}" is a reserved word; no entry or name begins with it'
    hint = "begin with the name of an entry, or write a name in quotes"
    if tokens[0].type == "EVERY":
        output = f"trajectory every {m.text(tokens[2], tokens[-1])}"
        whole = m.span(tokens[0]).to(m.span(tokens[-1]))
        hint = Hint(f'write the output: "{output}"', Edit(output, whole))
    return m.finding("TIS115", message, hint, tokens[0])


def _reserved_in_name(m: Mistake) -> Diagnostic | None:
    wrong = m.found
    if wrong.type == "EQUAL" and m.before:
        # "head of pancreas = …" was read as a name with a clause.
        inner = [token for token in m.before if token.type in _KEYWORDS - BINDERS]
        if not inner or any(token.type not in _NAMING for token in m.before):
            return None
        wrong = inner[0]
    elif wrong.type not in _KEYWORDS or not _in_name(m):
        return None
    message = f'a name cannot contain the reserved word "{wrong.text}"'
    return m.finding("TIS115", message, _quoted(m, _whole_name(m, wrong)), wrong)


def _quoted(m: Mistake, name: list[Token], begin: str = "write the name in quotes") -> Hint:
    """Return a hint to write a name in quotes, without the part or verb that it begins with."""
    tokens = [*m.before, m.found, *m.after]
    places = [token.start for token in tokens]  # tokens are equal where their texts are
    start, end = places.index(name[0].start), places.index(name[-1].start) + 1
    is_set = tokens[end : end + 1] and tokens[end].type in ("EQUAL", "IS")
    begins = start == 0 or tokens[start - 1].type == "COLON"
    head = name.pop(0) if begins and not is_set and len(name) > 1 else None
    text = m.text(name[0], name[-1])
    place = m.span(name[0]).to(m.span(name[-1]))
    shown_name = f'{head.text} "{text}"' if head else f'"{text}"'
    return Hint(f"{begin}: {shown_name}", Edit(f'"{text}"', place))


def _in_name(m: Mistake) -> bool:
    """Return whether only a name can begin, or continue, where a reserved word was found."""
    if not m.before:
        return m.next == "EQUAL"
    if m.previous in BINDERS | {"TABLE", "IS"}:
        return "WORD" in m.accepted
    return all(token.type in BINDERS | {"WORD", "STRING"} for token in m.before)


def _whole_name(m: Mistake, wrong: Token) -> list[Token]:
    """Return all words around one that is not allowed inside a name."""
    tokens = [*m.before, m.found, *m.after]
    place = next(i for i, token in enumerate(tokens) if token is wrong)
    start, end = place, place + 1
    while start and tokens[start - 1].type == "WORD":
        start -= 1
    while end < len(tokens) and tokens[end].type in _KEYWORDS | {"WORD"}:
        end += 1
    return tokens[start:end]


def _two_statements(m: Mistake) -> Diagnostic | None:
    found = m.found.type
    if found == "COMMA" and m.can_end and m.next == "WORD":
        signs = {token.type for token in m.after} & {"EQUAL", "IS"}
        if m.previous == "WORD" and not signs:
            hint = Hint('put ";" between two sentences; several names are a list: [A, B]')
            return m.finding("TIS107", "a comma does not join names", hint)
        hint = Hint('write ";" instead', Edit(";"))
        return m.finding("TIS107", "a comma does not end a statement", hint)
    begins = found in _STARTERS or (found == "WORD" and m.next in _GOES_ON)
    second_sign = found in ("EQUAL", "IS") and (m.holds("IS") or m.holds("EQUAL"))
    behind_block = m.statement.is_behind_block and found != CHARACTER
    if not (m.can_end and (begins or second_sign or behind_block)):
        return None
    if second_sign:
        hint = Hint('put ";" or a line break between them')
    else:
        text = f'put ";" or a line break before {shown(m.found.text)}'
        hint = Hint(text, Edit(";", m.behind))
    return m.finding("TIS107", "two statements on one line", hint)


def _second_language(m: Mistake) -> Diagnostic | None:
    if m.found.type != "LANGUAGE" or m.before:
        return None
    stop = m.after[-1].stop if m.after else m.found.stop
    hint = leaving_out("remove it", Span(m.source, m.found.start, stop))
    return m.finding("TIS307", "the version of the language is given twice", hint)


def _misspelt_time_word(m: Mistake) -> Diagnostic | None:
    """Recognise ``trajectory evry 5 ms``, ``force(A) evry 5 ms`` and ``form 0 s to 1 s: …``."""
    if m.found.type == "WORD" and m.previous == "RPAR" and m.next == "QUANTITY":
        near = did_you_mean(
            m.found.text, [one for one in TIME_WORDS if one.upper() in m.accepted]
        )
        message = f"a time cannot follow {shown(m.found.text)}"
        return m.finding("TIS109", message, near) if near else None
    if m.found.type not in NUMBERS or m.previous != "WORD" or m.first in BINDERS:
        return None
    *others, last = m.before
    if not others and m.next not in ("TO", "COLON"):
        return None
    near = did_you_mean(last.text, TIME_WORDS)
    if not near or (m.found.type != "QUANTITY" and others):
        return None  # nodes may be called "top 2"
    return m.finding("TIS109", f"a time cannot follow {shown(last.text)}", near, last)


def _misspelt_joining_word(m: Mistake) -> Diagnostic | None:
    """Recognise ``press slab wth 2 kPa``; short words may as well be parts of names."""
    if m.found.type not in NUMBERS or m.previous != "WORD" or len(m.before) < 3:
        return None
    word = m.before[-1]
    near = did_you_mean(word.text, (one for one in JOINING_WORDS if len(one) > 3))
    if not near or len(word.text) < 3:
        return None
    message = f"a number cannot follow {shown(word.text)}"
    return m.finding("TIS109", message, near, word)


def _number_in_name(m: Mistake) -> Diagnostic | None:
    if m.found.type not in NUMBERS or m.previous != "WORD":
        return None
    name = m.words_before
    if m.found.type == "QUANTITY" and "EQUAL" in m.accepted:
        name = m.text(m.before[0], m.before[-1]) if m.holds("OF") else name
        hint = Hint(f"write {shown(f'{name} = {m.found.text}')}", Edit(" =", m.behind))
        return m.finding("TIS109", '"=" is missing between a name and its value', hint)
    value = Hint(f'write "{name} = {m.found.text}"', Edit(" =", m.behind))
    is_set = "EQUAL" in m.accepted and m.next != "EQUAL"
    if is_set and name == m.before[0].text:
        return m.finding("TIS109", "a name cannot contain a number", value)
    words = [*takewhile(lambda token: token.type == "WORD", reversed(m.before))][::-1]
    hint = _quoted(m, [*words, m.found], "write the number as a word, or the name in quotes")
    if is_set:
        hint = Hint(f"{hint}; to set a value, {value}", *hint.edits, *value.edits)
    return m.finding("TIS109", "a name cannot contain a number", hint)


def _anything(m: Mistake) -> Diagnostic:
    """Say what was found and what is allowed there."""
    ends = m.found.type in ENDS
    if ends and m.before:
        message = "the statement ends too early"
    else:
        message = "a statement is missing" if ends else f"unexpected {shown(m.found.text)}"
    hint = _special(m) or (expected(m.accepted) if m.before else _BEGINNINGS)
    return m.finding("TIS100", message, hint)


def _special(m: Mistake) -> str:
    """Return a hint for a mistake that needs no code of its own."""
    found, value = m.found.type, m.found.text
    if found == CHARACTER:
        return _sign(m, value)
    if found in NUMBERS and m.previous == "NUMBER":
        start = m.span(m.found).start
        if per_second := _PER_SECOND.match(m.source.text, start):
            place = Span(m.source, start, per_second.end())
            return Hint('the unit 1/s is written "Hz"', Edit("Hz", place))
        whole = f"{m.before[-1].text}{m.found.text}"
        return Hint(f'digits are not grouped: write "{whole}"', Edit("", m.blank))
    if found == "COMMA" and m.previous in NUMBERS and m.can_end:
        return _bracketed(m)
    if value in CONTINUING and not m.line_before.strip():
        return f'a line that begins with "{value}" continues the line above'
    if found == "CIRCUMFLEX":
        return 'write parentheses: "a^(b^c)"'
    if found == "COMPARISON" and m.holds("COMPARISON"):
        return _between(m)
    if found == "LBRACE" and not m.before:
        return Hint('put "{" on the line of the name of its block', *_brace_moved(m))
    if found == "COMMA" and m.next == "THEN":
        return Hint('remove the ","', Edit(""))
    if found == "LINE" and m.previous == "COLON":
        return 'write the action on the line of its time, or in "{ }"'
    return ""


def _bracketed(m: Mistake) -> str:
    """Return a hint to write the three numbers around a comma as a vector."""
    signed = len(m.before) > 1 and m.before[-2].type == "MINUS"
    first = m.before[-2 if signed else -1]
    last = [m.found, *takewhile(lambda token: token.type in _LISTED, m.after)][-1]
    parts = [_AMOUNT.fullmatch(part) for part in m.text(first, last).split(",")]
    amounts = ", ".join(part[1] for part in parts if part)
    if len(parts) != 3 or not parts[2] or amounts.count(",") != 2:
        return 'write a vector in brackets: "(0, 0, 1) mm"'
    vector = f"({amounts}) {parts[2][2]}".rstrip()
    place = m.span(first).to(m.span(last))
    return Hint(f'write the vector in brackets: "{vector}"', Edit(vector, place))


def _between(m: Mistake) -> str:
    """Return a hint to write a chain of comparisons, such as 1 < x < 2, with "between"."""
    tokens = [*m.before, m.found, *m.after]
    ends = [i for i, token in enumerate(tokens) if token.type in _CONDITION_ENDS]
    second = len(m.before)
    first = max(i for i in range(second) if tokens[i].type == "COMPARISON")
    start = max((i + 1 for i in ends if i < first), default=0)
    stop = min((i for i in ends if i > second), default=len(tokens))
    parts = tokens[start:first], tokens[first + 1 : second], tokens[second + 1 : stop]
    if (
        not all(parts)
        or tokens[first].text[0] != m.found.text[0]
        or m.found.text[0] not in "<>"
    ):
        return 'join two comparisons with "and"'
    low, middle, high = (m.text(part[0], part[-1]) for part in parts)
    if m.found.text[0] == ">":
        low, high = high, low
    text = f"{middle} between {low} and {high}"
    place = m.span(tokens[start]).to(m.span(tokens[stop - 1]))
    return Hint(f"write {shown(text)}", Edit(text, place))


def _brace_moved(m: Mistake) -> list[Edit]:
    """Return the edit that moves a brace up to the line of the text before it."""
    place = m.found.start
    blank = re.search(r"[\s;]*\Z", m.source.text[:place])
    if blank is None or "#" in m.source.text[:place].rstrip().rpartition("\n")[2]:
        return []
    return [Edit(" {", Span(m.source, blank.start(), place + 1))]


def _sign(m: Mistake, sign: str) -> str:
    """Return a hint about a sign that begins nothing."""
    if sign == "." and m.previous == "NUMBER":
        return Hint(f'write "{m.before[-1].text}.0"', Edit(".0"))
    if sign == "." and (digits := _DIGITS.match(m.source.text, m.found.stop)):
        return Hint(f'write "0.{digits[0]}"', Edit("0."))
    if sign == "·":
        return Hint('write "*" for a product', Edit("*"))
    return _SIGNS.get(sign, "")


_BEGINNINGS = f"a statement begins with a name, a time, or one of {', '.join(sorted(STARTING))}"

#: How an argument with a name begins.
_ARGUMENTS = (["LPAR", "WORD"], ["COMMA", "WORD"])
#: A line that sets a number.
_SET = re.compile(r"^([a-z]\w*) *= *[-0-9.]", re.MULTILINE)

_DIGITS = re.compile(r"[0-9]+")

#: A number with its unit.
_AMOUNT = re.compile(r"\s*(-?[0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*")

#: Types of tokens that numbers of a vector are made of.
_LISTED = NUMBERS | {"COMMA", "MINUS"}

#: Types of tokens around a comparison.
_CONDITION_ENDS = (
    ENDS | TIMES | frozenset({"AND", "OR", "NOT", "IF", "THEN", "WHEN", "WHERE", "EXPECT"})
    | frozenset({"LPAR", "RPAR", "COLON", "LBRACE", "OVER"})
)  # fmt: skip

_SIGNS = {
    ".": 'a number has digits on both sides of its point: "0.5"',
    "!": 'write "!=" for "is not equal to", and "not" for the opposite',
    "%": 'a unit follows a number: "5 %"',
}

_KINDS = (
    _decimal_comma,
    _path_without_quotes,
    is_for_equal,
    is_before_number,
    equal_for_is,
    _colon_after_keyword,
    _colon_for_brace,
    _colon_for_equal,
    _named_argument,
    _and_for_semicolon,
    _if_for_when,
    adjusted_list,
    habit,
    inches,
    _missing_colon,
    _unit,
    equals_as_test,
    _rule_without_then,
    _reserved_as_entry,
    _reserved_in_name,
    _second_language,
    _two_statements,
    _misspelt_time_word,
    _misspelt_joining_word,
    sign_before_clause,
    _number_in_name,
)
