"""Characters: from bytes to clean text, and characters that no text may contain."""

import re
import unicodedata
from pathlib import Path

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Source, Span
from tissuec.core.units import NO_TEMPERATURES
from tissuec.lang.ranges import one_of, without_tolerance

#: Matches what may be odd: signs without a meaning, control characters, all beyond ASCII. An
#: apostrophe has one between two letters, as in "Young's modulus".
SUSPECT = r"[\x00-\x08\x0b-\x1f\x7f$&?@\\`|~]|(?<![^\W\d_])'|'(?![^\W\d_])|[^\x00-\x7f·]"

_UNIT = r"[^\W\d_][\w*/^]*"

#: Signs that people group digits with, and how far to look for those.
_GROUPING = "'‘’`´\u00a0\u2009\u202f"
_LONGEST_LINE = 200  # of which the start is looked for, so that effort grows as the length
_MOST_DIGITS = 20

_AMOUNT_BEFORE = re.compile(rf"([0-9.]+(?:[eE][+-]?[0-9]+)?)[ \t]*({_UNIT})?[ \t]*\Z")
_AMOUNT_BEHIND = re.compile(rf"[ \t]*[0-9.]+(?:[eE][+-]?[0-9]+)?[ \t]*({_UNIT}|%)?")

_TESTED = re.compile(r"[ \t]*(?:expect|when)\b")

_TEMPERATURE = re.compile(r"° ?[CFK]\b|[℃℉]")

#: What to type instead of characters that word processors and web pages put in.
_INSTEAD = {
    '"': "“”„‟«»＂″",
    "-": "−–—‐‑‒",
    "*": "×∙⋅",
    "/": "÷∕⁄",
    "<=": "≤",
    ">=": "≥",
    "!=": "≠",
    "==": "≡",
    "^2": "²",
    "^3": "³",
    "deg": "°",
    "and": "&∧",
    "or": "|∨",
    ",": "，、",
    ":": "：",
    ";": "；",
    "(": "（",
    ")": "）",
}
#: A text in curly quotes, on one line.
CURLY = re.compile('[{0}]([^{0}"\n]*)[{0}]'.format(_INSTEAD['"']))

#: Bars around an expression, on one line.
_IN_BARS = re.compile(r"\|(?! )([^|\n\"]+)(?<! )\|")

#: Signs between the ends of a range, and before a number that is not exact.
_ABOUT = "≈≅≃~"
_BETWEEN = f"–—…{_ABOUT}"

_REMEDY: dict[str, str] = {
    **{
        character: Hint(f"type {what} instead", Edit(what))
        for what, group in _INSTEAD.items()
        for character in group
    },
    **dict.fromkeys("'‘’‚‛`´′", 'put text in double quotes: "…"'),
    **dict.fromkeys(_ABOUT, 'write a range: "between 4 mN and 6 mN"'),
    "\\": "remove it: a line that begins with a joining word continues the line above",
}


def normalise(raw: bytes | str, name: str, path: Path | None = None) -> Source:
    """Return the text as a source: no byte order mark, NFC, line ends as ``\\n``.

    Args:
        raw: The contents of a file, or a text.
        name: Name of the source in messages.
        path: The file, if there is one.

    Raises:
        CompileError: The bytes are not UTF-8, or contain characters that no text may contain.
    """
    text = raw if isinstance(raw, str) else raw.decode("utf-8", errors="replace")
    source = Source(name, _clean(text), path)
    place, message = _not_text(source.text, raw)
    if place >= 0:
        span = Span(source, place, place + 1)
        hint = "save the file as plain text in UTF-8"
        raise CompileError([Diagnostic("TIS114", message, span, hint)])
    return source


def _clean(text: str) -> str:
    text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    return text if text.isascii() else unicodedata.normalize("NFC", text)


def _not_text(text: str, raw: bytes | str) -> tuple[int, str]:
    """Return the first offset at which this is no text, or -1, and a description."""
    if isinstance(raw, bytes):
        try:
            raw.decode("utf-8")
        except UnicodeDecodeError as error:
            place = len(_clean(raw[: error.start].decode("utf-8")))
            return place, f"byte 0x{raw[error.start]:02X} is not UTF-8 text"
    if "\0" in text:
        return text.index("\0"), "a zero byte: the file is not plain text"
    if not text.isascii():
        halves = (i for i, character in enumerate(text) if "\ud800" <= character <= "\udfff")
        return next(halves, -1), "half of a surrogate pair"
    return -1, ""


def odd_character(span: Span) -> Diagnostic | None:
    """Return the finding about one suspect character.

    None for a letter, which is fine, and for the second of two bars, of which the first has it.
    """
    character = span.text
    if not character.isascii() and character.isalpha():
        return None
    bars = _in_bars(span)
    if bars is not None and span.start > bars.start():
        return None
    if len(character) > 1:  # && and ||
        word = "and" if character == "&&" else "or"
        hint = Hint(f'write "{word}"', Edit(word))
        return Diagnostic("TIS114", f'"{character}" is not a sign of the language', span, hint)
    name = unicodedata.name(character, "control character").lower()
    visible = character.isprintable() and not character.isspace()
    shown = f'"{character}"' if visible else "this character"
    message = f"{shown} (U+{ord(character):04X}, {name}) is allowed only in quotes and comments"
    fallback = (
        Hint("remove it, or put the name in quotes", Edit(""))
        if visible
        else Hint("type an ordinary blank", Edit(" "))
    )
    hint = (
        _ungrouped(span)
        or _temperature(span)
        or _tolerance(span)
        or _range(span)
        or _paired(span)
        or _apostrophe(span)
        or _absolute(bars, span.source)
        or _REMEDY.get(character, fallback)
    )
    return Diagnostic("TIS114", message, span, hint)


def _in_bars(span: Span) -> re.Match[str] | None:
    """Return the expression in bars, such as ``|y - 8 mm|``, that a bar opens or closes."""
    if span.text != "|":
        return None
    nearby = max(span.start - _LONGEST_LINE, 0)
    line = max(nearby, span.source.text.rfind("\n", nearby, span.start) + 1)
    found = _IN_BARS.finditer(span.source.text, line)
    return next((one for one in found if span.start in (one.start(), one.end() - 1)), None)


def _absolute(bars: re.Match[str] | None, source: Source) -> Hint | str:
    """Return a hint about bars around an expression, if there are any."""
    if bars is None:
        return ""
    absolute = f"abs({bars[1]})"
    return Hint(f'write "{absolute}"', Edit(absolute, Span(source, *bars.span())))


def _apostrophe(span: Span) -> Hint | str:
    """Return a hint about a curly apostrophe between two letters, if it is one."""
    text = span.source.text
    beside = text[span.start - 1 : span.start] + text[span.end : span.end + 1]
    if span.text not in "‘’´`" or len(beside) < 2 or not beside.isalpha():
        return ""
    return Hint("type ' instead", Edit("'"))


def _paired(span: Span) -> str:
    """Return a hint about a curly quote that begins a quoted text, if it does."""
    quoted = CURLY.match(span.source.text, span.start)
    if quoted is None:
        return ""
    return Hint('type " instead', Edit(f'"{quoted[1]}"', Span(span.source, *quoted.span())))


def _temperature(span: Span) -> str:
    """Return a hint about the sign of a temperature, if it is one."""
    return NO_TEMPERATURES if _TEMPERATURE.match(span.source.text, span.start) else ""


def _tolerance(span: Span) -> Hint | str:
    """Return a hint about the tolerance of a number, if it has one."""
    if span.text != "±":
        return ""
    text, nearby = span.source.text, max(span.start - _LONGEST_LINE, 0)
    before = _AMOUNT_BEFORE.search(text[nearby : span.start])
    behind = _AMOUNT_BEHIND.match(text, span.end)
    if before is None or behind is None:
        return ""
    if _TESTED.match(text, text.rfind("\n", nearby, span.start) + 1):
        return 'write the range: "between … and …"'
    place = Span(span.source, nearby + before.start(), behind.end())
    return without_tolerance(before[1], before[2] or behind[1], place)


def _range(span: Span) -> Hint | str:
    """Return a hint about ``5 – 6 kPa`` and ``~5 kPa``, if it is one of them."""
    if span.text not in _BETWEEN:
        return ""
    text, nearby = span.source.text, max(span.start - _LONGEST_LINE, 0)
    before = _AMOUNT_BEFORE.search(text[nearby : span.start])
    behind = _AMOUNT_BEHIND.match(text, span.end)
    if behind is None:
        return ""
    amount = behind[0].strip()
    if before is not None:
        place = Span(span.source, nearby + before.start(), behind.end())
        return one_of(before[0].strip(), amount, place)
    if span.text in _ABOUT and not _TESTED.match(text, text.rfind("\n", 0, span.start) + 1):
        place = Span(span.source, span.start, behind.end())
        return Hint(f'a number has no tolerance: write "{amount}"', Edit(amount, place))
    return ""


def _ungrouped(span: Span) -> str:
    """Return a hint with the number whose digits a character groups, if it does."""
    text = span.source.text
    before = re.search(r"\d+\Z", text[max(span.start - _MOST_DIGITS, 0) : span.start])
    after = re.match(r"\d+", text[span.end : span.end + _MOST_DIGITS])
    if span.text not in _GROUPING or not before or not after:
        return ""
    return Hint(f'digits are not grouped: write "{before[0]}{after[0]}"', Edit(""))
