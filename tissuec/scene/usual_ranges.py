"""Usual ranges: what living tissue, organs and instruments have, against slips of units.

A value outside is possible, and a scene may be about a planet: it is warned of, and no more.
One table serves tissues (where they are read) and sizes (where a scene is compiled).
"""

import re
from collections.abc import Iterable
from math import inf

from msgspec import Struct

from tissuec.core.errors import Diagnostic, Note
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.core.units import (
    ACCELERATION,
    DENSITY,
    LENGTH,
    NUMBER,
    PRESSURE,
    PRESSURE_TIME,
    STIFFNESS,
    TIME,
    Dimension,
    parse_unit,
    show,
    show_or_kilo,
)

#: The last number with its unit in an entry, such as "1.06 kg/m^3".
_WRITTEN = re.compile(r"(-?[0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(%|[^\W\d][\w·*/^]*)?\s*\Z")


class Usual(Struct, frozen=True):
    """The usual range of a quantity.

    Attributes:
        low, high: Outside of these, in SI units, a value is warned of.
        least, most: What has such values.
        typical: The range of most of it; a slip of the unit is looked for here.
        units: In which a number may have been meant.
        beyond: A further usual range, such as that of bone.
    """

    dimension: Dimension
    low: float
    high: float
    least: str
    most: str
    typical: tuple[float, float]
    units: tuple[str, ...]
    beyond: tuple[float, float] = (0.0, 0.0)

    @property
    def shown(self) -> str:
        """Return the range as text: "200 kg/m^3 (lung) to 3000 kg/m^3 (enamel)"."""
        low, high = (self.show(end) for end in (self.low, self.high))
        return f"{low} ({self.least}) to {high} ({self.most})"

    def show(self, value: float) -> str:
        """Return a value in SI units as text; energies for areas in J/m^2, not in N/m."""
        if self.dimension != STIFFNESS:
            return show(value, self.dimension, digits=4)
        return show_or_kilo(value, self.units[0], digits=4)

    def holds(self, value: float) -> bool:
        """Return whether a value in SI units is usual; so are zero and no limit."""
        if value in (0.0, inf) or self.low <= abs(value) <= self.high:
            return True
        return self.beyond[0] <= abs(value) <= self.beyond[1]


_PRESSURES = ("Pa", "kPa", "MPa", "GPa")
_LENGTHS = ("um", "mm", "cm", "m")

#: By lower-case name: quantities of tissues, then what scenes have. Densities are of ICRU
#: Report 44 (1989), moduli of McKee et al. 2011, Tissue Eng B 17:155, and of single fibrils of
#: Wenger et al. 2007, Biophys J 93:1255; the others are wide enough to need no source.
USUAL: dict[str, Usual] = {
    "density": Usual(
        DENSITY, 200.0, 3000.0, "lung", "enamel", (900.0, 1200.0), ("g/cm^3", "kg/m^3")
    ),
    "young's modulus": Usual(
        PRESSURE, 10.0, 2.5e9, "softer than brain",
        "tendon along its fibres; bone has 10 to 25 GPa", (300.0, 30e6), _PRESSURES,
        (10e9, 25e9),
    ),
    "fibre modulus": Usual(
        PRESSURE, 100.0, 12e9, "gels", "single fibrils", (1e4, 2.5e9), _PRESSURES
    ),
    "strength": Usual(
        PRESSURE, 100.0, 1e9, "brain", "single fibrils", (1e3, 150e6), _PRESSURES
    ),
    "toughness": Usual(STIFFNESS, 0.1, 1e6, "gels", "tendon", (5.0, 1e5), ("J/m^2", "kJ/m^2")),
    "cutting resistance": Usual(
        STIFFNESS, 1.0, 1e5, "gels", "tendon", (20.0, 1e4), ("J/m^2", "kJ/m^2")
    ),
    "breaking strain": Usual(NUMBER, 0.01, 10.0, "bone", "gels", (0.05, 3.0), ("%",)),
    "stiffening": Usual(NUMBER, 0.05, 150.0, "nearly linear", "tendon", (0.3, 80.0), ("%",)),
    "friction": Usual(NUMBER, 5e-4, 3.0, "joints", "dry skin on rubber", (1e-3, 1.5), ("%",)),
    "retardation time": Usual(
        TIME, 1e-6, 1000.0, "ultrasound", "creep", (1e-4, 10.0), ("us", "ms", "s")
    ),
    "shear viscosity": Usual(
        PRESSURE_TIME, 1e-3, 1e7, "water", "creeping cartilage", (0.1, 1e5),
        ("mPa*s", "Pa*s", "kPa*s"),
    ),
    "size": Usual(
        LENGTH, 0.5e-3, 3.0, "a crumb of tissue", "a patient", (2e-3, 0.5), _LENGTHS
    ),
    "thickness": Usual(
        LENGTH, 1e-6, 0.1, "a membrane of cells", "a layer of fat", (1e-4, 0.03), _LENGTHS
    ),
    "distance": Usual(LENGTH, 0.0, 1.0, "contact", "across the table", (1e-3, 0.3), _LENGTHS),
    "gravity": Usual(
        ACCELERATION, 0.1, 100.0, "nearly none", "a centrifuge", (1.0, 20.0),
        ("mm/s^2", "m/s^2"),
    ),
}  # fmt: skip


def unusual(
    key: str, value: float, what: str, span: Span, *, others: Iterable[Note] = ()
) -> Diagnostic | None:
    """Return W504 for a value that is not usual, and None for one that is, or has no range.

    Args:
        key: Of the range.
        value: In SI units.
        what: What messages say before the value: "density of liver is".
        span: The entry.
        others: Other values of this kind, so that one warning names all.
    """
    usual = USUAL.get(key)
    if usual is None or usual.holds(value):
        return None
    return Diagnostic(
        "W504",
        f"{what} {usual.show(value)}, outside of the usual range: {usual.shown}",
        span,
        _slip(usual, value, span),
        tuple(others),
    )


def _slip(usual: Usual, value: float, span: Span) -> Hint:
    """Return a hint to the units with which a number would be typical.

    That is the number as written, with edits; what follows from several numbers, such as a
    size, is taken as it is shown.
    """
    written = _WRITTEN.search(span.text)
    found = written or _WRITTEN.search(show(value, usual.dimension, digits=4))
    assert found is not None
    texts = [
        f"{found[1]} {other}"
        for other in usual.units
        if other != found[2] and _is_typical(usual, float(found[1]) * parse_unit(other).factor)
    ]
    start = span.start + found.start()
    place = Span(span.source, start, start + len(found[0]))
    edits = (Edit(text, place) for text in texts) if written else ()
    meant = f"did you mean {' or '.join(texts)}?" if texts else "check the unit;"
    return Hint(f"{meant} if it is right, leave it as it is", *edits)


def _is_typical(usual: Usual, value: float) -> bool:
    low, high = usual.typical
    return low <= abs(value) <= high
