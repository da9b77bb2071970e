"""Known curves of a tissue: measurements of sources, with their scatter.

A stress is nominal: the force over the area as it was before the test. Strains of tension and
compression are relative changes of length, positive in both; that of shear is the amount of
shear. A relaxation is the share of the largest stress that is left at times after the strain
was reached.
"""

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.units import NUMBER, PRESSURE, TIME, Dimension, show

STRESS, RELAXATION = "stress", "relaxation"
TENSION, COMPRESSION, SHEAR = "tension", "compression", "shear"
EQUIBIAXIAL = "equibiaxial tension"
ALONG, ACROSS = "tension along fibres", "tension across fibres"
#: Loading modes in which stresses are measured.
MODES = (TENSION, COMPRESSION, SHEAR, EQUIBIAXIAL, ALONG, ACROSS)


class KnownCurve(Struct, frozen=True):
    """Evidence on a curve of a tissue.

    Attributes:
        mode: One of ``MODES``, in which a stress is known; empty for a relaxation.
        places: Strains, or times [s]; ascending, positive.
        low, high: Limits of the stress [Pa], or of the remaining share, at each of them.
        source: Name of the source.
        is_verified: Whether the source could be looked up.
    """

    mode: str
    places: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    source: str
    is_verified: bool
    span: Span

    @property
    def name(self) -> str:
        """Return the name of the curve, such as "stress in tension"."""
        return f"{STRESS} in {self.mode}" if self.mode else RELAXATION

    @property
    def dimension(self) -> Dimension:
        """Return the dimension of the limits."""
        return PRESSURE if self.mode else NUMBER

    def shown_place(self, place: float) -> str:
        """Return a strain in percent, or a time."""
        return f"{100.0 * place:.4g} %" if self.mode else show(place, TIME, digits=4)

    @property
    def shown(self) -> str:
        """Return the limits at the first and at the last place, with their units."""
        ends = sorted({0, len(self.places) - 1})
        limits = (
            f"{show(self.low[n], self.dimension, digits=4)} to "
            f"{show(self.high[n], self.dimension, digits=4)} at "
            f"{self.shown_place(self.places[n])}"
            for n in ends
        )
        return " … ".join(limits)

    def limits_at(self, place: float) -> tuple[float, float] | None:
        """Return the linearly interpolated limits at a place; None beyond the known places."""
        if not self.places[0] <= place <= self.places[-1]:
            return None
        after = next(n for n, one in enumerate(self.places) if one >= place)
        if self.places[after] == place:
            return self.low[after], self.high[after]
        start, end = self.places[after - 1 : after + 1]
        part = (place - start) / (end - start)
        low, high = (
            limits[after - 1] + part * (limits[after] - limits[after - 1])
            for limits in (self.low, self.high)
        )
        return low, high
