"""Knots of threads, which slip.

A knot holds like a piece of thread up to a force F. There it slips: its ends part under the
constant force F, all of whose work is lost, until they part no faster than the thread is drawn
in; from then on it holds again, that much longer.
"""

from msgspec import Struct

from tissuec.core.source import Span

SURE = 1.0 - 1e-6  # of its stretch: with which a knot holds again, lest it slips by rounding


class Knot(Struct, frozen=True):
    """A knot that was tied.

    Attributes:
        kind: Such as "square knot".
        hold, slip: Springs of the thread.
        limit: Force F above which it slips [N].
        strength: Of the thread [N]; where that is not above F, it breaks instead.
        stretch: Elongation with which it holds again [m]; None while it does not slip.
        span: The sentence.
    """

    kind: str
    hold: int
    slip: int
    limit: float
    strength: float
    stretch: float | None
    span: Span
