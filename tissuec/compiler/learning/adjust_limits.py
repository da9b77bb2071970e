"""Limits of what is adjusted, and what was expected of it: ``around 20 N/m by 30 %``.

Each of many springs can be expected where it starts: ``around initial value by 30 %``.
"""

from math import inf
from typing import NoReturn

import numpy as np
from msgspec import Struct

from tissuec.core.fields import Real
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.core.units import Dimension, show, suggested_unit
from tissuec.lang import syntax as s
from tissuec.model.network import Floats, Indices
from tissuec.scene.learning.clauses import LearnReader
from tissuec.scene.learning.sentences import INITIAL, LimitWords
from tissuec.script.fit_problem import START_POSITION, START_VELOCITY, Adjust, Per


class Found(Struct, frozen=True):
    """An adjustable quantity, before its limits are read.

    Attributes:
        kind: Its dimension, and the limits that it has by itself.
    """

    what: str
    of: str
    per: Per
    members: Indices
    kind: Real


def limited(found: Found, reader: LearnReader, span: Span) -> Adjust:
    """Return an adjustment within its limits.

    Args:
        found: The quantity to adjust.
        reader: Of the sentence.
        span: Of the quantity.
    """
    dimension, own = found.kind.dimension, found.kind
    reader.own = dimension
    said = reader.get(LimitWords)
    along = _along(found, said.along, reader)
    least = next((one for one in (own.above, own.at_least) if one is not None), -inf)
    most = inf if own.at_most is None else own.at_most
    low = _within(reader, "from", said.low, found, least, most)
    high = _within(reader, "to", said.high, found, least, most)
    if low >= high:
        _refuse_limits(reader, found.what)
    prior = _prior(reader, said, found, (low, high))
    return Adjust(
        found.what, found.of, found.per, found.members, along, dimension, low, high, prior,
        span,
    )  # fmt: skip


def _refuse_limits(reader: LearnReader, what: str) -> NoReturn:
    """Reject limits of which the lower one is not below the upper one."""
    low, high = reader.clauses.get("from"), reader.clauses.get("to")
    message = f"the lower limit of {what} is not below the upper one"
    if low is None or high is None:
        reader.findings.reject("TIS308", message, reader.span)
    hint = Hint("write a lower limit that is below the upper one")
    lower, upper = low.value.span, high.value.span
    if lower.text != upper.text and lower.end <= upper.start:
        limits = f"from {upper.text} to {lower.text}"
        hint = Hint(f"write: {limits}", Edit(limits, lower.to(upper)))
    reader.findings.reject("TIS308", message, lower, hint=hint)


def _within(
    reader: LearnReader, word: str, given: float | None, found: Found, least: float,
    most: float,
) -> float:  # fmt: skip
    """Return a limit, which lies between those that there are by themselves."""
    if given is None:
        return least if word == "from" else most
    if not least <= given <= most:
        lower = "at least" if found.kind.above is None else "above"
        limits = ((least, lower), (most, "at most"))
        allowed = " and ".join(
            f"{how} {show(limit, found.kind.dimension)}"
            for limit, how in limits
            if np.isfinite(limit)
        )
        reader.findings.reject(
            "TIS308",
            f"{found.what} must be {allowed}, which excludes the limit "
            f"{show(given, found.kind.dimension)}",
            reader.clauses[word].value.span,
        )
    return given


def _prior(
    reader: LearnReader, said: LimitWords, found: Found, limits: tuple[float, float]
) -> tuple[float | None, float] | None:
    """Return the expected value, None for each start, and its relative deviation."""
    what, dimension = found.what, found.kind.dimension
    around, by = reader.clauses.get("around"), reader.clauses.get("by")
    if around is None and by is None:
        return None
    if around is None or by is None:
        there, other = (by, "around") if around is None else (around, "by")
        assert there is not None
        unit, text = suggested_unit(dimension), there.span.one_line
        value = found.kind.example or f"1 {unit}".rstrip()
        whole = f"around {value} {text}" if around is None else f"{text} by 10 %"
        reader.findings.reject(
            "TIS304", f'"{there.word}" needs "{other}"', there.span,
            hint=Hint(f"for example: {whole}", Edit(whole)),
        )  # fmt: skip
    part = said.by
    assert part is not None
    if isinstance(around.value, s.Name) and around.value.key == INITIAL:
        _check_starts(reader, around, found)
        return None, part
    value = reader.number("around", dimension)
    if value == 0.0:
        message = "a relative deviation from 0 is not possible"
        hint = "write another expected value, or limits: from … to …"
        reader.findings.reject("TIS308", message, around.value.span, hint=hint)
    if not limits[0] <= value <= limits[1]:
        _outside(reader, around, what, dimension, limits)
    return value, part


def _check_starts(reader: LearnReader, around: s.Clause, found: Found) -> None:
    """Check that values start above 0, and that they are no single number to be written."""
    if found.what in (START_POSITION, START_VELOCITY):
        message = f"a {found.what} has no relative deviation from where it starts"
    elif found.per in ("tissue", "force"):
        message = f'"{INITIAL}" is for values of springs, nodes, regions and sets'
    else:
        return
    hint = "write the expected value: around … by …"
    reader.findings.reject("TIS312", message, around.span, hint=hint)


def _outside(
    reader: LearnReader,
    around: s.Clause,
    what: str,
    dimension: Dimension,
    limits: tuple[float, float],
) -> NoReturn:
    low, high = (show(limit, dimension) for limit in limits)
    message = f"{around.value.span.one_line} is not between the limits {low} and {high}"
    reader.findings.reject("TIS308", f"the expected value of {what}: {message}", around.span)


def _along(found: Found, along: Floats | None, reader: LearnReader) -> Floats | None:
    """Return the direction of a start; without one, no number can limit it."""
    is_vector = found.what in (START_POSITION, START_VELOCITY)
    if along is not None and not is_vector:
        message = f"{found.what} is a single number and has no direction"
        span = reader.clauses["along"].span
        hint = Hint(f'remove "{span.one_line}"', Edit(""))
        reader.findings.reject("TIS303", message, span, hint=hint)
    limiting = next((w for w in ("from", "to", "around") if w in reader.clauses), None)
    if is_vector and along is None and limiting is not None:
        reader.findings.reject(
            "TIS304", f"limits of a {found.what} need a direction",
            reader.span, hint=f"for example: adjust {found.what} of … along (1, 0, 0)",
        )  # fmt: skip
    return along
