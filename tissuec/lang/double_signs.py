"""Two signs before one number, such as ``+-35``, ``--3`` and ``5 +-1 mm``."""

import re

from tissuec.core.errors import Diagnostic
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.lang.ranges import MESSAGE, amount_of

_SIGNED = re.compile(r"([+\-\s]*)(.*)", re.DOTALL)
_ONE = "a number has one sign"


def two_signs(place: Span) -> Diagnostic:
    """Return the finding about a value that begins with several signs.

    Args:
        place: The value with its signs.
    """
    signs, value = _parts(place.text)
    if "\n" in place.text:
        return Diagnostic("TIS312", _ONE, place, "leave out all signs but one")
    texts = [value] if "-" not in signs else [f"-{value}", value]
    written = " or ".join(f'"{text}"' for text in texts)
    tolerance = "; a number has no tolerance" if "-" in signs and "+" in signs else ""
    edits = (Edit(text, place) for text in texts)
    return Diagnostic("TIS312", _ONE, place, Hint(f"write {written}{tolerance}", *edits))


def signs_meet(left: Span, right: Span) -> Diagnostic | None:
    """Return the finding about a sum in which a sign follows another one without a space.

    Args:
        left: Place of the term before the signs.
        right: Place of the term after the first sign; it may begin with the second one.
    """
    text = left.source.text
    if text[right.start] not in "+-" or text[right.start - 1] not in "+-":
        return None
    signs, value = _parts(text[left.end : right.end])
    place, alone = Span(left.source, left.start, right.end), amount_of(left.text, value)
    if "\n" in place.text:
        return Diagnostic("TIS312", _ONE, place, "leave out one of the signs")
    if signs.count("-") % 2 == 0:
        result = f"{left.text} + {value}"
        return Diagnostic("TIS312", _ONE, place, Hint(f'write "{result}"', Edit(result, place)))
    result = f"{alone} - {value}"
    hint = Hint(
        f'a number has no tolerance: write "{alone}", and vary it in a study; or a difference: '
        f'"{result}"',
        Edit(alone, place),
        Edit(result, place),
    )
    return Diagnostic("TIS312", MESSAGE, place, hint)


def _parts(text: str) -> tuple[str, str]:
    """Return the signs before a value, and the value."""
    found = _SIGNED.match(text)
    assert found is not None
    return found[1], found[2]
