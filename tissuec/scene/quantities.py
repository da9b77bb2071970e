"""The physical quantities a tissue can give to a network; rules may conclude only these."""

from collections.abc import Iterator
from math import inf
from typing import Any, Literal

from msgspec import Struct

from tissuec.core import units
from tissuec.core.names import key_of
from tissuec.core.units import Dimension
from tissuec.model.inelastic import CONSTANTS, LIMIT, TIMES, VISCOSITY

#: Of branches, by their constants: the shares of the modulus that relax.
SHARES = tuple(constant.replace("constant", "share") for constant in CONSTANTS)

#: Keys of quantities of matter that others depend on.
YOUNGS_MODULUS, POISSONS_RATIO = "young's modulus", "poisson's ratio"
FIBRE_MODULUS, RETARDATION_TIME = "fibre modulus", "retardation time"
SHEAR_MODULUS = "shear modulus"
BREAKING_FORCE = "breaking force"
BREAKING_STRAIN, STRENGTH, TOUGHNESS = "breaking strain", "strength", "toughness"
#: Of the law of matter that stiffens when it is stretched.
STIFFENING = "stiffening"
#: Of fibres in solids that consist of elements.
FIBRE_STIFFENING, FIBRE_DISPERSION = "fibre stiffening", "fibre dispersion"
Spread = Literal["each spring", "each node", "whole body", "matter"]


class TissueQuantity(Struct, frozen=True):
    """A quantity of the network.

    Attributes:
        name: In the language.
        dimension: Of its value.
        array: The array of the network that it fills.
        spreads: What one value may belong to; the first holds unless written otherwise.
        scales: How a value "of 1 mm" changes with a spring's length: -1 for spring constant and
            viscosity (two springs in a row are half as stiff); 0 where length has no influence.
        default: The value that means "none", for quantities that may be left out.
        none: The value of the word "none", for limits that there need not be.
        may_be_zero: Whether zero is a sensible value.
        instead: Of matter, the quantity of springs or nodes that follows from it, by key.
        unit: Unit in which it is shown, if not the usual one of its dimension.
        digits: Least number of significant digits that are shown.
    """

    name: str
    dimension: Dimension
    array: str
    spreads: tuple[Spread, ...]
    scales: int = 0
    default: float | None = None
    none: float | None = None
    may_be_zero: bool = False
    instead: str = ""
    unit: str = ""
    digits: int = 3

    def show(self, value: float, *, digits: int = 3) -> str:
        """Return a value as text, such as "170 J/m^2".

        Args:
            value: In SI units.
            digits: Number of significant digits.
        """
        digits = max(digits, self.digits)
        if not self.unit:
            return units.show(value, self.dimension, digits=digits)
        return units.show_or_kilo(value, self.unit, digits=digits)

    @property
    def is_of_matter(self) -> bool:
        """Return whether it means the same on every mesh."""
        return self.spreads == ("matter",)


def _matter(
    name: str,
    dimension: Dimension,
    instead: str,
    array: str,
    *,
    none: float | None = None,
    **more: Any,
) -> TissueQuantity:
    """Return a quantity of matter, from which one of springs or nodes follows."""
    return TissueQuantity(
        name, dimension, array, ("matter",), none=none, instead=instead, **more
    )


def _springs(
    name: str, dimension: Dimension, scales: int, default: float, *, may_be_zero: bool = False
) -> TissueQuantity:
    """Return a quantity of each spring that may be left out; "none" is what it is then."""
    spread: tuple[Spread, ...] = ("each spring",)
    return TissueQuantity(name, dimension, name, spread, scales, default, default, may_be_zero)


def _branches() -> Iterator[TissueQuantity]:
    for constant, time in zip(CONSTANTS, TIMES, strict=True):
        yield _springs(constant, units.STIFFNESS, -1, 0.0, may_be_zero=True)
        yield _springs(time, units.TIME, 0, inf)


QUANTITIES: dict[str, TissueQuantity] = {
    key_of(quantity.name): quantity
    for quantity in (
        TissueQuantity(
            "spring constant",
            units.STIFFNESS,
            "stiffness",
            ("each spring",),
            scales=-1,
            may_be_zero=True,
        ),
        TissueQuantity(
            "viscosity",
            units.VISCOSITY,
            "damping",
            ("each spring",),
            scales=-1,
            may_be_zero=True,
        ),
        TissueQuantity("mass", units.MASS, "mass", ("each node", "whole body")),
        TissueQuantity(BREAKING_FORCE, units.FORCE, "strength", ("each spring",), none=inf),
        TissueQuantity(
            "crushing force", units.FORCE, "crush", ("each spring",), default=inf, none=inf
        ),
        TissueQuantity(
            "prestress", units.NUMBER, "rest", ("each spring",), default=0.0, may_be_zero=True
        ),
        *_branches(),
        _springs(LIMIT, units.FORCE, 0, inf, may_be_zero=True),
        _springs(VISCOSITY, units.VISCOSITY, -1, inf),
        _matter("Young's modulus", units.PRESSURE, "spring constant", "stiffness"),
        # 0.4997 and 0.5 are different tissues.
        _matter("Poisson's ratio", units.NUMBER, "", "", digits=4),
        _matter(STIFFENING, units.NUMBER, "", "", none=0.0),
        _matter("fibre modulus", units.PRESSURE, "", ""),
        _matter(FIBRE_STIFFENING, units.NUMBER, "", "", may_be_zero=True),
        _matter(FIBRE_DISPERSION, units.NUMBER, "", "", may_be_zero=True),
        _matter("density", units.DENSITY, "mass", "mass"),
        _matter("retardation time", units.TIME, "viscosity", "damping", may_be_zero=True),
        _matter(
            "shear viscosity", units.PRESSURE_TIME, "viscosity", "damping", may_be_zero=True
        ),
        *(
            _matter(share, units.NUMBER, constant, constant, may_be_zero=True)
            for share, constant in zip(SHARES, CONSTANTS, strict=True)
        ),
        _matter("yield stress", units.PRESSURE, LIMIT, LIMIT, none=inf, may_be_zero=True),
        _matter("flow viscosity", units.PRESSURE_TIME, VISCOSITY, VISCOSITY, none=inf),
        _matter(BREAKING_STRAIN, units.NUMBER, "breaking force", "strength", none=inf),
        _matter(STRENGTH, units.PRESSURE, "breaking force", "strength", none=inf),
        _matter(
            TOUGHNESS, units.STIFFNESS, "breaking force", "strength", none=inf, unit="J/m^2"
        ),
    )
}
#: What can be known of matter: its quantities, and what only a laboratory measures.
KNOWABLE: dict[str, TissueQuantity] = {
    **{key: quantity for key, quantity in QUANTITIES.items() if quantity.is_of_matter},
    TIMES[0]: QUANTITIES[TIMES[0]],  # the same on every mesh
    SHEAR_MODULUS: _matter("shear modulus", units.PRESSURE, "", ""),
}
#: Those that messages list: of the branches of a spring, the first one stands for all.
LISTED = tuple(
    one.name
    for key, one in QUANTITIES.items()
    if key not in (*CONSTANTS[1:], *TIMES[1:], *SHARES[1:])
)
#: Quantities of matter from which each one of springs or nodes can follow, by key.
OF_MATTER: dict[str, tuple[str, ...]] = {
    name: tuple(key for key, one in QUANTITIES.items() if one.instead == name)
    for name in QUANTITIES
}


#: What many tissues do without: nothing is missing where no word speaks of it.
LEFT_OUT = frozenset((TOUGHNESS, *SHARES, *TIMES))
#: Limits that act together: tissue breaks at whichever is reached first.
TOGETHER = (BREAKING_STRAIN, STRENGTH)
#: Limits that a tissue can have side by side.
LIMITS = (*TOGETHER, TOUGHNESS)


def rivals(key: str) -> tuple[str, ...]:
    """Return the other quantities that say the same thing of a tissue, by key."""
    thing = QUANTITIES[key].instead or key
    return tuple(one for one in (thing, *OF_MATTER[thing]) if one != key)


def exclude(first: str, second: str) -> bool:
    """Return whether two quantities, by key, exclude each other in a tissue."""
    return second in rivals(first) and not {first, second} <= set(LIMITS)


def replaced_by(key: str, *, is_none: bool) -> tuple[str, ...]:
    """Return the inherited or concluded quantities that a written one replaces, by key.

    These are the quantities of the same kind. A strain or a strength leaves a toughness in
    place, which counts only where there is neither.

    Args:
        key: Key of the written quantity.
        is_none: Whether it is written as "none", so that nothing breaks.
    """
    keeps = (TOUGHNESS,) if key in TOGETHER and not is_none else ()
    return tuple(one for one in rivals(key) if one not in keeps)
