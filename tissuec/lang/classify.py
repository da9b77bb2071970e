"""Syntax errors in plain words, told from what stands before and behind, and what could stand.

Each function looks for one kind of mistake. The first that recognises it has the word.
"""

import re
from itertools import takewhile

from lark import Token

from tissuec.core.errors import Diagnostic, did_you_mean
from tissuec.core.units import ALL_UNITS, SYMBOLS
from tissuec.lang.mistake import CHARACTER, ENDS, Mistake
from tissuec.lang.plain import expected, shown
from tissuec.lang.words import CONTINUING, RESERVED, STARTING, TIME_WORDS

_TIMES = frozenset(word.upper() for word in TIME_WORDS)
_KEYWORDS = frozenset(word.upper() for word in RESERVED)
_STARTERS = frozenset(word.upper() for word in STARTING) - _TIMES
_BINDERS = frozenset({"PARAM", "LET", "SET"})
_NAMING = _KEYWORDS - {"IS"} | {"WORD", "STRING"}
_NUMBERS = frozenset({"NUMBER", "QUANTITY"})

#: What may follow behind a unit to make it a larger one.
_FURTHER_UNITS = re.compile(r"([*/·][^\W\d_]+(\^-?[0-9]+)?)*")

#: Behind a word that begins a statement, one of these comes next.
_GOES_ON = frozenset({"WORD", "STRING", "EQUAL", "IS", "LBRACE"})


def classify(mistake: Mistake) -> Diagnostic:
    """Return the finding about a syntax error."""
    for recognise in _KINDS:
        finding = recognise(mistake)
        if finding:
            return finding
    return _anything(mistake)


def _finding(
    m: Mistake, code: str, message: str, hint: str, at: Token | None = None
) -> Diagnostic:
    return Diagnostic(code, message, m.span(at or m.found), hint)


def _capitalised(m: Mistake) -> Diagnostic | None:
    for token in (*m.before, m.found):
        word = token.value.lower()
        if token.type == "WORD" and word in RESERVED:
            message = f'"{token}" is a reserved word, and those are written in small letters'
            return _finding(m, "TIS103", message, f'write "{word}"', token)
    return None


def _decimal_comma(m: Mistake) -> Diagnostic | None:
    if m.found.type != "COMMA" or m.previous != "NUMBER" or m.next not in _NUMBERS:
        return None
    if m.before[-1].end_pos != m.found.start_pos or m.found.end_pos != m.after[0].start_pos:
        return None
    head = m.text(m.before[0], m.before[-1])
    written = shown(f"{head}.{m.text(m.after[0], m.after[-1])}")
    hint = f"write {written}"
    if re.match(r"[0-9]{3}(?![0-9])", m.after[0].value):
        hint += f', or "{m.before[-1]}{m.after[0]}": digits are not grouped'
    return _finding(m, "TIS108", "decimals use a point", hint)


def _missing_colon(m: Mistake) -> Diagnostic | None:
    timed = m.first in _TIMES or m.first == "WHEN"
    if not timed or "COLON" not in m.accepted or m.holds("COLON"):
        return None
    if m.found.type == "WORD" and m.previous in _NUMBERS and m.next == "COLON":
        return None  # a unit that is misspelt
    message = '":" is missing between the time and what happens'
    if m.found.type in ENDS or m.found.type == CHARACTER:
        hint = f'write "{m.text(m.before[0], m.before[-1])}: …", and then what happens'
        return _finding(m, "TIS105", message, hint)
    head = m.text(m.before[0], m.before[-1])
    rest = m.text(m.found, m.after[-1] if m.after else m.found)
    return _finding(m, "TIS105", message, f"write {shown(f'{head}: {rest}')}")


def _unit(m: Mistake) -> Diagnostic | None:
    """Recognise a word behind a number that is no unit, or a unit where none can stand."""
    if m.found.type == "RPAR_UNIT":
        message = (
            f'the unit "{m.found[1:].strip()}" stands behind neither a number nor a vector'
        )
        return _finding(m, "TIS104", message, "write it behind each number")
    if m.found.type != "WORD" or m.next in _GOES_ON:
        return None
    word = m.found.value
    if m.previous == "QUANTITY" and word in SYMBOLS:
        unit = re.sub(r"^[0-9.]+([eE][+-]?[0-9]+)?\s*", "", m.before[-1].value)
        message = f'"{unit} {word}" is not a unit'
        return _finding(m, "TIS104", message, f'write "{unit}*{word}" or "{unit}/{word}"')
    if m.previous in ("RPAR", "RSQB") and word in SYMBOLS:
        message = f'the unit "{word}" stands behind neither a number nor a vector'
        return _finding(m, "TIS104", message, "write it behind each number")
    near = _near_unit(m, word)
    if m.previous == "NUMBER" or (m.previous == "RPAR" and near):
        return _finding(m, "TIS104", f'"{word}" is not a unit', near or ALL_UNITS)
    return None


def _near_unit(m: Mistake, word: str) -> str:
    if product := _run_together(word):
        rest = _FURTHER_UNITS.match(m.source.text, m.found.end_pos or 0)
        return f'did you mean "{product}{rest[0] if rest else ""}"?'
    same = [symbol for symbol in SYMBOLS if symbol.lower() == word.lower()]
    return f'did you mean "{same[0]}"?' if same else did_you_mean(word, SYMBOLS)


def _run_together(word: str) -> str:
    """Return two units of different kinds with the sign between them that is left out."""
    for i in range(1, len(word)):
        first, second = SYMBOLS.get(word[:i]), SYMBOLS.get(word[i:])
        if first and second and first[1] != second[1]:
            return f"{word[:i]}*{word[i:]}"
    return ""


def _path_without_quotes(m: Mistake) -> Diagnostic | None:
    if not m.before or m.before[0].lower() != "use" or m.found.value not in ("/", "."):
        return None
    if any(token.type != "WORD" for token in m.before):
        return None
    end = m.source.text.rstrip().find("\n", m.found.start_pos or 0)
    written = m.source.text[m.before[0].end_pos : end if end > 0 else None]
    path = written.split("#")[0].strip("; \t\n")
    return _finding(m, "TIS312", "a path stands in quotes", f'write use "{path}"')


def _is_for_equal(m: Mistake) -> Diagnostic | None:
    """Recognise ``set root is …``, unless a "=" comes behind, so that "is" is in the name."""
    after = [token.type for token in m.after]
    if m.first not in _BINDERS or m.found.type != "IS" or not m.after or "EQUAL" in after:
        return None
    head, rest = m.text(m.before[0], m.before[-1]), m.text(m.after[0], m.after[-1])
    hint = f"write {shown(f'{head} = {rest}')}"
    return _finding(m, "TIS312", f'a {m.before[0]} is given with "="', hint)


def _colon_for_equal(m: Mistake) -> Diagnostic | None:
    name = _words_before(m)
    if m.found.type != "COLON" or "EQUAL" not in m.accepted or not name or not m.after:
        return None
    value = m.text(m.after[0], m.after[-1])
    sign = "is" if m.next == "WORD" else "="
    hint = f"write {shown(f'{name} {sign} {value}')}"
    return _finding(m, "TIS312", '":" stands behind a time or a condition only', hint)


def _if_for_when(m: Mistake) -> Diagnostic | None:
    if m.first != "IF" or m.found.type != "COLON" or not m.before[1:]:
        return None
    hint = f"write {shown(f'when {m.text(m.before[1], m.before[-1])}: …')}"
    return _finding(
        m, "TIS312", 'a script waits for a condition with "when"', hint, m.before[0]
    )


def _equals_as_test(m: Mistake) -> Diagnostic | None:
    if m.found.type != "EQUAL" or "COMPARISON" not in m.accepted:
        return None
    left = _words_before(m)
    if not left:
        hint = 'write "==" between numbers, "is" before a word'
    elif m.next == "WORD":
        hint = f'write "{left} is {m.after[0]}" for a word, or "==" between numbers'
    else:
        hint = f'write "{left} == {m.after[0].value if m.after else "…"}"'
    return _finding(m, "TIS111", '"=" sets a value and does not compare', hint)


def _rule_without_then(m: Mistake) -> Diagnostic | None:
    if m.first != "IF" or m.holds("THEN") or "THEN" not in m.accepted:
        return None
    if any(token.type == "THEN" for token in m.after):
        return None
    hint = 'write "if … then …", with what follows from the condition behind "then"'
    return _finding(m, "TIS112", 'the rule has no "then"', hint)


def _reserved_in_name(m: Mistake) -> Diagnostic | None:
    wrong = m.found
    if wrong.type == "EQUAL" and m.before:
        # "head of pancreas = …" was read as a name with a clause.
        inner = [token for token in m.before if token.type in _KEYWORDS - _BINDERS]
        if not inner or any(token.type not in _NAMING for token in m.before):
            return None
        wrong = inner[0]
    elif wrong.type not in _KEYWORDS or not _in_name(m):
        return None
    message = f'"{wrong}" cannot stand inside a name'
    hint = f'write the name in quotes: "{_whole_name(m, wrong)}"'
    return _finding(m, "TIS115", message, hint, wrong)


def _in_name(m: Mistake) -> bool:
    """Return whether only a name can stand, or go on, where a reserved word was found."""
    if not m.before:
        return m.next == "EQUAL"
    if m.previous in _BINDERS | {"TABLE", "IS"}:
        return "WORD" in m.accepted
    return all(token.type in _BINDERS | {"WORD", "STRING"} for token in m.before)


def _whole_name(m: Mistake, wrong: Token) -> str:
    """Return all words around one that cannot stand inside a name."""
    tokens = [*m.before, m.found, *m.after]
    place = next(i for i, token in enumerate(tokens) if token is wrong)
    start, end = place, place + 1
    while start and tokens[start - 1].type == "WORD":
        start -= 1
    while end < len(tokens) and tokens[end].type in _KEYWORDS | {"WORD"}:
        end += 1
    return " ".join(tokens[start:end])


def _two_statements(m: Mistake) -> Diagnostic | None:
    found = m.found.type
    if found == "COMMA" and m.can_end and m.next == "WORD":
        return _finding(m, "TIS107", "a comma does not end a statement", 'write ";" instead')
    begins = found in _STARTERS or (found == "WORD" and m.next in _GOES_ON)
    second_sign = found in ("EQUAL", "IS") and (m.holds("IS") or m.holds("EQUAL"))
    behind_block = m.source.text[m.statement.start - 1 : m.statement.start] == "}"
    if not (m.can_end and (begins or second_sign or (behind_block and found != CHARACTER))):
        return None
    if second_sign:
        hint = 'put ";" or a line break between them'
    else:
        hint = f'put ";" or a line break before {shown(m.found.value)}'
    return _finding(m, "TIS107", "two statements stand on one line", hint)


def _number_in_name(m: Mistake) -> Diagnostic | None:
    if m.found.type not in _NUMBERS or m.previous != "WORD":
        return None
    name = _words_before(m)
    if m.found.type == "QUANTITY" and "EQUAL" in m.accepted:
        hint = f"write {shown(f'{name} = {m.found}')}"
        return _finding(m, "TIS109", '"=" is missing between a name and its value', hint)
    hint = f'write the number as a word, or the name in quotes: "{name} {m.found}"'
    if "EQUAL" in m.accepted:
        hint += f'; to set a value, write "{name} = {m.found}"'
    return _finding(m, "TIS109", "a number cannot stand inside a name", hint)


def _words_before(m: Mistake) -> str:
    """Return the words directly before the wrong token."""
    words = takewhile(lambda token: token.type == "WORD", reversed(m.before))
    return " ".join(reversed(list(words)))


def _anything(m: Mistake) -> Diagnostic:
    """Say what was found and what could stand there."""
    ends = m.found.type in ENDS
    if ends and m.before:
        message = "the statement ends too early"
    else:
        message = (
            "a statement is missing" if ends else f"{shown(m.found.value)} cannot stand here"
        )
    hint = _special(m) or (expected(m.accepted) if m.before else _BEGINNINGS)
    return _finding(m, "TIS100", message, hint)


def _special(m: Mistake) -> str:
    """Return a hint for a mistake that needs no code of its own."""
    found, value = m.found.type, m.found.value
    if found == CHARACTER:
        return _SIGNS.get(value, "")
    if found in _NUMBERS and m.previous == "NUMBER":
        return f'digits are not grouped: write "{m.before[-1]}{m.found}"'
    if found == "COMMA" and m.previous in _NUMBERS and m.can_end:
        return 'a vector stands in brackets: "(0, 0, 1) mm"'
    if value in CONTINUING and not m.line_before.strip():
        return f'a line that begins with "{value}" continues the line above'
    if found == "CIRCUMFLEX":
        return 'write parentheses: "a^(b^c)"'
    if found == "COMPARISON" and m.holds("COMPARISON"):
        return 'write "x between 1 mm and 2 mm", or join two comparisons with "and"'
    if found == "LBRACE" and not m.before:
        return 'put "{" on the line of the name of its block'
    if found == "COMMA" and m.next == "THEN":
        return 'remove the ","'
    if found == "_NL" and m.previous == "COLON":
        return 'what happens stands on the line of its time, or in "{ }"'
    return ""


_BEGINNINGS = f"a statement begins with a name, a time, or one of {', '.join(sorted(STARTING))}"

_SIGNS = {
    ".": 'a number has digits on both sides of its point: "0.5"',
    "!": 'write "!=" for "is not equal to", and "not" for the opposite',
    "%": 'a unit stands behind a number: "5 %"',
    "·": 'write "*" for a product',
}

_KINDS = (
    _capitalised,
    _decimal_comma,
    _path_without_quotes,
    _is_for_equal,
    _colon_for_equal,
    _if_for_when,
    _missing_colon,
    _unit,
    _equals_as_test,
    _rule_without_then,
    _reserved_in_name,
    _two_statements,
    _number_in_name,
)
