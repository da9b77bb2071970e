"""Syntax errors where "=" is written for "is", for "==" or in vain, and the other way round.

Each function looks for one kind of mistake, as those of :mod:`tissuec.lang.classify` do.
"""

from tissuec.core.errors import Diagnostic
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.lang.mistake import Mistake
from tissuec.lang.token_names import shown
from tissuec.lang.tokens import Token
from tissuec.lang.words import TIME_WORDS

BINDERS = frozenset({"PARAM", "LET", "SET"})
NUMBERS = frozenset({"NUMBER", "QUANTITY", "STEPS"})
TIMES = frozenset(word.upper() for word in TIME_WORDS)

#: What a number, a vector or a list begins with.
_VALUES = NUMBERS | {"PLUS", "MINUS", "LPAR", "LSQB"}
_NAMES = frozenset({"WORD", "STRING"})


def is_for_equal(m: Mistake) -> Diagnostic | None:
    """Recognise ``set root is …``, unless a "=" comes after, so that "is" is in the name."""
    after = [token.type for token in m.after]
    if m.first not in BINDERS or m.found.type != "IS" or not m.after or "EQUAL" in after:
        return None
    if m.first != "SET" and set(after) == {"WORD"}:
        message = f"a {m.before[0].text} is a number, not a word"
        hint = f'write a number, such as "{m.text(m.before[0], m.before[-1])} = 1 mm"; '
        return m.finding("TIS312", message, f"{hint}words are for tissues", m.after[0])
    head, rest = m.text(m.before[0], m.before[-1]), m.text(m.after[0], m.after[-1])
    hint = Hint(f"write {shown(f'{head} = {rest}')}", Edit("="))
    return m.finding("TIS312", f'the value of a {m.before[0].text} follows "="', hint)


def is_before_number(m: Mistake) -> Diagnostic | None:
    """Recognise ``friction is 0.4``, and a test such as ``x is 3 mm``."""
    if m.previous != "IS" or m.found.type not in _VALUES or m.statement.is_head:
        return None
    if m.next == "WORD" and m.found.type != "LSQB":
        return None
    sign, name = m.before[-1], m.before[:-1]
    if m.first == "IF":
        hint = 'write a word of its scale after "is"'
        return m.finding("TIS312", "a rule tests and concludes words, not numbers", hint)
    if all(token.type in _NAMES for token in name):
        rest = m.text(m.found, [m.found, *m.after][-1])
        hint = Hint(f"write {shown(f'{m.text(name[0], name[-1])} = {rest}')}", Edit("="))
        return m.finding("TIS312", 'a number follows "=", not "is"', hint, sign)
    if m.first not in ("SET", "EXPECT", "WHEN"):
        return None
    hint = Hint('write "==" between numbers', Edit("=="))
    return m.finding("TIS111", '"is" tests a word and does not compare numbers', hint, sign)


def equal_for_is(m: Mistake) -> Diagnostic | None:
    """Recognise ``mesh = tube {`` and ``rupture = not allowed``."""
    types = [token.type for token in (*m.before, m.found, *m.after)]
    sign = types.index("EQUAL") if "EQUAL" in types else 0
    words = types[sign + 1 : -1]
    is_phrase = m.previous == "EQUAL" and m.found.type == "NOT"
    is_block = m.found.type == "LBRACE" and bool(words) and _NAMES.issuperset(words)
    if not (is_phrase or is_block) or not sign or not _NAMES.issuperset(types[:sign]):
        return None
    tokens = [*m.before, m.found, *m.after]
    name, phrase = m.text(tokens[0], tokens[sign - 1]), m.text(tokens[sign + 1], tokens[-1])
    hint = Hint(f"write {shown(f'{name} is {phrase}')}", _spaced(m, sign, "is"))
    message = 'use "is" to choose a word; "=" assigns a number'
    return m.finding("TIS312", message, hint, tokens[sign])


def equals_as_test(m: Mistake) -> Diagnostic | None:
    """Recognise ``where y = 1 mm`` and ``if hardness = soft``."""
    if m.found.type != "EQUAL" or "COMPARISON" not in m.accepted:
        return None
    left, place = m.words_before, len(m.before)
    if m.next == "STRING":
        text = f"write {left or '…'} is {m.after[0].text}"
        hint = Hint(text, _spaced(m, place, "is"))
    elif m.next == "WORD":
        text = f'write "{left or "…"} is {m.after[0].text}" for a word, or "==" between numbers'
        hint = Hint(text, _spaced(m, place, "is"), Edit("=="))
    else:
        value = m.after[0].text if m.after else "…"
        hint = Hint(f'write "{f"{left} == {value}" if left else "=="}"', Edit("=="))
    return m.finding("TIS111", '"=" assigns a value and does not compare', hint)


def sign_before_clause(m: Mistake) -> Diagnostic | None:
    """Recognise ``line = from … to …``, where the entry is a sentence."""
    if m.previous != "EQUAL" or m.found.type not in TIMES:
        return None
    sign = m.before[-1]
    message = f'"=" cannot precede "{m.found.text}"'
    return m.finding("TIS100", message, Hint('leave out "="', Edit("")), sign)


def _spaced(m: Mistake, index: int, word: str) -> Edit:
    """Return the edit that writes a word with a blank on both sides in place of a token."""
    tokens: list[Token] = [*m.before, m.found, *m.after]
    start, stop = tokens[index - 1].stop, tokens[index + 1].start
    return Edit(f" {word} ", Span(m.source, start, stop))
