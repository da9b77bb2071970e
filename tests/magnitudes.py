"""Whether an edit keeps the sizes of the numbers that it writes anew."""

import math
import re

from tissuec.core.hints import Edit
from tissuec.core.units import STANDARD_GRAVITY, UnitError, converted, parse_unit

_AMOUNT = re.compile(r"(?<![\w.])(\d+(?:[.,]\d+)?(?:e[+-]?\d+)?) ?([^\W\d][\w*/^·]*|%)?")
_OF_VECTOR = re.compile(r"\) ?([^\W\d][\w*/^·]*)")


def magnitudes(text: str) -> list[tuple[float, bool]]:
    """Return the amounts of a text, in SI units where they have one, and whether they do."""
    vector = _OF_VECTOR.search(text)
    found: list[tuple[float, bool]] = []
    for number, unit in _AMOUNT.findall(text):
        size = factor(unit or (vector[1] if vector else ""))
        found.append((float(number.replace(",", ".")) * (size or 1.0), size is not None))
    return found


def factor(unit: str) -> float | None:
    try:
        return parse_unit(unit).factor
    except UnitError:
        known = converted("1", unit) if unit else None
    return None if known is None else magnitudes(known)[0][0]


def keeps_magnitudes(edit: Edit) -> bool:
    """Return whether each number of an edit is as large as what it stands for."""
    assert edit.span is not None
    old, new = magnitudes(edit.span.text), magnitudes(edit.text)
    if len(old) != len(new):
        return True  # numbers are left out or added, and none is written anew
    if edit.span.text.endswith(" g") and edit.text.endswith("m/s^2"):
        old = [(amount * 1e3 * STANDARD_GRAVITY, True) for amount, _ in old]
    is_rate = "Hz" in edit.span.text and "Hz" not in edit.text  # every 1 ms for 1 kHz
    numbers = [
        [float(one[0].replace(",", ".")) for one in _AMOUNT.findall(text)]
        for text in (edit.span.text, edit.text)
    ]
    return all(
        math.isclose(before, after, rel_tol=1e-6)
        or (is_rate and math.isclose(before * after, 1.0, rel_tol=1e-6))
        if has and had
        else one == other
        for (before, had), (after, has), one, other in zip(
            sorted(old), sorted(new), *map(sorted, numbers), strict=True
        )
    )
