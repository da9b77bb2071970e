"""What threads do beside pulling: they are drawn in and paid out, and their knots slip.

While a thread is drawn in, the rest length of each of its pieces follows a course,

    L0(t) = base + change s(t),

and whoever draws does the work -∫ f(L - L0) dL0 on it. A knot holds like a piece of thread up
to a force F. There it slips: its ends part under the constant force F, all of whose work is
lost, until they part no faster than the thread is drawn in; from then on it holds again, that
much longer.
"""

from msgspec import Struct
from msgspec.structs import replace

from tissuec.core.source import Span
from tissuec.courses import Course
from tissuec.network import Floats, Indices

SURE = 1.0 - 1e-6  # of its stretch: with which a knot holds again, lest it slips by rounding


class Reeling(Struct, frozen=True, eq=False):
    """A thread that is drawn in or paid out.

    Attributes:
        springs: The pieces, shape (piece,).
        base, change: What makes their rest lengths [m], shape (piece,).
        span: The sentence.
    """

    springs: Indices
    base: Floats
    change: Floats
    course: Course
    span: Span

    def rest(self, time: float) -> Floats:
        """Return the rest lengths at a time [m], shape (piece,)."""
        return self.base + self.course.at(time)[0] * self.change

    def rate(self, time: float) -> Floats:
        """Return the rates of the rest lengths [m/s], shape (piece,)."""
        return self.course.at(time)[1] * self.change

    def rate_of(self, spring: int, time: float) -> float:
        """Return the rate of one rest length [m/s], 0 for a spring that is none of these."""
        return float(self.rate(time)[self.springs == spring].sum())

    def lengthened(self, spring: int, by: float) -> "Reeling":
        """Return the same with one piece longer by a length [m], if it is one of these."""
        return replace(self, base=self.base + by * (self.springs == spring))


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
