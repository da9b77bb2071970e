"""The physical quantities a tissue can give to a network; rules may conclude only these."""

from collections.abc import Iterator
from math import inf
from typing import Annotated, Any, Literal

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.core.names import key_of
from tissuec.core.units import Dimension, describe
from tissuec.lang import syntax as s
from tissuec.laws.uniaxial import LARGEST_STIFFENING
from tissuec.model.inelastic import CONSTANTS, LIMIT, TIMES, VISCOSITY
from tissuec.scene.reading.entries import Entry, written
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ChoiceClause, NumberClause, ValueClause

#: Of branches, by their constants: the shares of the modulus that relax.
SHARES = tuple(constant.replace("constant", "share") for constant in CONSTANTS)

#: Keys of quantities of matter that others depend on.
YOUNGS_MODULUS, POISSONS_RATIO = "young's modulus", "poisson's ratio"
FIBRE_MODULUS, RETARDATION_TIME = "fibre modulus", "retardation time"
SHEAR_MODULUS, DENSITY = "shear modulus", "density"
BREAKING_FORCE = "breaking force"
BREAKING_STRAIN, STRENGTH, TOUGHNESS = "breaking strain", "strength", "toughness"
#: Of the law of matter that stiffens when it is stretched.
STIFFENING = "stiffening"
#: Of surfaces in contact, and of cuts.
FRICTION, CUTTING_RESISTANCE = "friction", "cutting resistance"
#: Of fibres in solids that consist of elements.
FIBRE_STIFFENING, FIBRE_DISPERSION = "fibre stiffening", "fibre dispersion"
LARGEST_SHARE = 0.99  # of a modulus that relaxes: what is left holds a body together
LARGEST_DISPERSION = 0.3  # at 1/3 fibres have no direction, along which there is a modulus
LARGEST_POISSON = 0.4999  # at 1/2 a solid would keep its volume exactly, and never move
#: The word for a quantity whose inherited number gives way to rules.
CONCLUDED = "concluded"
#: Letters and words of other texts for a stiffness.
_MODULI = ("k", "c", "e", "elastic modulus", "elasticity modulus")
Spread = Literal["each spring", "each node", "whole body", "matter"]


class GivenNumber(VerbSentence, frozen=True):
    """The number of a quantity."""

    number: Annotated[s.Expression, ValueClause("=", place="NUMBER")]


class ScaledNumber(GivenNumber, frozen=True):
    """The number of a quantity, and the length of springs that have it [m]."""

    length: Annotated[
        float | None, NumberClause("per", units.LENGTH, "positive", what="length")
    ]


class LeftToRules(VerbSentence, frozen=True):
    """A quantity that rules conclude."""

    word: Annotated[
        str,
        ChoiceClause(
            "is", {CONCLUDED: "What rules conclude, not the number of the parent."},
            in_forms=False,
        ),
    ]  # fmt: skip


class NoLimit(VerbSentence, frozen=True):
    """A limit that there is not."""

    word: Annotated[str, ChoiceClause("is", {"none": "No limit."})]


class TissueQuantity(Struct, frozen=True):
    """A quantity of the network.

    Attributes:
        name: In the language.
        about: What it is, in one sentence.
        dimension: Of its value.
        array: The array of the network that it fills.
        spreads: What one value may belong to; the first holds unless written otherwise.
        scales: How a value "of 1 mm" changes with a spring's length: -1 for spring constant and
            viscosity (two springs in a row are half as stiff); 0 where length has no influence.
        default: The value that means "none", for quantities that may be left out.
        none: The value of the word "none", for limits that there need not be.
        may_be_zero: Whether zero is a sensible value.
        range: Limits of its value beside that; by default it is only positive.
        instead: Of matter, the quantity of springs or nodes that follows from it, by key.
        unit: Unit in which it is shown, if not the usual one of its dimension.
        digits: Least number of significant digits that are shown.
        also: Words and letters of other texts for it. The first one means it with any unit, the
            others if the unit fits.
    """

    name: str
    about: str
    dimension: Dimension
    array: str = ""
    spreads: tuple[Spread, ...] = ("matter",)
    scales: int = 0
    default: float | None = None
    none: float | None = None
    may_be_zero: bool = False
    range: Real | None = None
    instead: str = ""
    unit: str = ""
    digits: int = 3
    also: tuple[str, ...] = ()

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

    def __reduce__(self) -> Any:
        # Quantities are compared by identity, which has to hold in another process, too.
        key = key_of(self.name)
        if QUANTITIES.get(key) is self:
            return _quantity, (key,)
        return super().__reduce__()

    @property
    def is_of_matter(self) -> bool:
        """Return whether it means the same on every mesh."""
        return self.spreads == ("matter",)

    @property
    def limits(self) -> Real:
        """The numbers that can be written for it."""
        if self.range is not None:
            return self.range
        if self.may_be_zero:
            return Real(self.dimension, at_least=0.0)
        return Real(self.dimension, above=0.0)

    @property
    def entry(self) -> Entry:
        """The entry of a tissue that gives it a number."""
        of = " or ".join(self.spreads)
        about = f"{self.about}\n\n{describe(self.dimension)}, of {of}"
        none = () if self.none is None else (NoLimit,)
        return written(
            self.name, about, self.number, LeftToRules, *none,
            dimension=self.dimension, begins=" = ",
        )  # fmt: skip

    @property
    def number(self) -> type[GivenNumber]:
        """The class of sentences that give it a number."""
        return ScaledNumber if self.scales else GivenNumber


def _quantity(key: str) -> TissueQuantity:
    return QUANTITIES[key]


def _springs(
    name: str, about: str, dimension: Dimension, scales: int, default: float, **more: Any
) -> TissueQuantity:
    """Return a quantity of each spring that may be left out, which means "none"."""
    return TissueQuantity(
        name, about, dimension, name, ("each spring",), scales, default, default, **more
    )


def _branches() -> Iterator[TissueQuantity]:
    for constant, time in zip(CONSTANTS, TIMES, strict=True):
        yield _springs(
            constant, "Spring constant of a part of the spring that relaxes.",
            units.STIFFNESS, -1, 0.0, may_be_zero=True,
        )  # fmt: skip
        yield _springs(time, "Time in which that part relaxes to 1/e.", units.TIME, 0, inf)


def _shares() -> Iterator[TissueQuantity]:
    for share, constant in zip(SHARES, CONSTANTS, strict=True):
        yield TissueQuantity(
            share, "Share of the stress that relaxes after a sudden stretch.", units.NUMBER,
            constant, instead=constant, may_be_zero=True,
            range=Real(units.NUMBER, at_least=0.0, at_most=LARGEST_SHARE),
        )  # fmt: skip


_OF_SPRINGS: tuple[Spread, ...] = ("each spring",)
QUANTITIES: dict[str, TissueQuantity] = {
    key_of(quantity.name): quantity
    for quantity in (
        TissueQuantity(
            "spring constant", "Force of a spring per elongation.", units.STIFFNESS,
            "stiffness", _OF_SPRINGS, -1, may_be_zero=True,
            also=("stiffness", *_MODULI, "modulus"),
        ),
        TissueQuantity(
            "viscosity", "Force of the dashpot of a spring per rate of elongation.",
            units.VISCOSITY, "damping", _OF_SPRINGS, -1, may_be_zero=True,
            also=("damping", "d", "eta", "dashpot"),
        ),
        TissueQuantity(
            "mass", "Mass of each node, or of the whole body.", units.MASS,
            "mass", ("each node", "whole body"),
        ),
        TissueQuantity(
            BREAKING_FORCE, "Tension at which a spring breaks.", units.FORCE,
            "strength", _OF_SPRINGS, none=inf,
        ),
        TissueQuantity(
            "crushing force", "Compressive force at which a spring breaks.", units.FORCE,
            "crush", _OF_SPRINGS, default=inf, none=inf,
        ),
        TissueQuantity(
            "prestress", "Initial strain: how much shorter than drawn something is at rest.",
            units.NUMBER, "rest", _OF_SPRINGS, default=0.0, may_be_zero=True,
            range=Real(units.NUMBER, above=-10.0, at_most=0.99),
        ),
        *_branches(),
        _springs(
            LIMIT, "Force above which the rest length of a spring changes permanently.",
            units.FORCE, 0, inf, may_be_zero=True,
        ),
        _springs(
            VISCOSITY, "Excess of the force over the yield force, per rate of the rest length.",
            units.VISCOSITY, -1, inf,
        ),
        TissueQuantity(
            "Young's modulus", "Stress per strain of a bar at rest.", units.PRESSURE,
            "stiffness", instead="spring constant", also=("modulus", *_MODULI, "stiffness"),
        ),
        TissueQuantity(
            "Poisson's ratio", "Contraction across a bar per elongation along it.",
            units.NUMBER, range=Real(units.NUMBER, above=-1.0, at_most=LARGEST_POISSON),
            digits=4,  # 0.4997 and 0.5 are different tissues
            also=("poisson", "nu", "poisson ratio"),
        ),
        TissueQuantity(
            STIFFENING,
            "How fast the tissue stiffens when stretched: k of Fung's exponential law.",
            units.NUMBER, none=0.0,
            range=Real(units.NUMBER, above=0.0, at_most=LARGEST_STIFFENING),
        ),
        TissueQuantity(
            FRICTION, "Coefficient of friction along tools and other tissue.", units.NUMBER,
            may_be_zero=True, also=("mu", "friction coefficient", "coefficient of friction"),
        ),
        TissueQuantity(
            "fibre modulus", "Young's modulus along the fibres.", units.PRESSURE,
            also=(
                "fibre stiffness", "fiber modulus", "fiber stiffness", "longitudinal modulus"
            ),
        ),
        TissueQuantity(
            FIBRE_STIFFENING, "How fast fibres stiffen when stretched, in bodies of elements.",
            units.NUMBER, may_be_zero=True,
        ),
        TissueQuantity(
            FIBRE_DISPERSION,
            "How far the directions of fibres scatter: 0 if all are parallel.",
            units.NUMBER, may_be_zero=True,
            range=Real(units.NUMBER, at_least=0.0, at_most=LARGEST_DISPERSION),
        ),
        TissueQuantity(
            "density", "Mass per volume.", units.DENSITY, "mass", instead="mass",
            also=("mass density", "rho"),
        ),
        TissueQuantity(
            "retardation time", "Viscosity per stiffness.", units.TIME, "damping",
            instead="viscosity", may_be_zero=True,
        ),
        TissueQuantity(
            "shear viscosity",
            "Shear stress per rate of shear, as measured with shear waves.",
            units.PRESSURE_TIME, "damping", instead="viscosity", may_be_zero=True,
        ),
        *_shares(),
        TissueQuantity(
            "yield stress", "Stress above which the tissue deforms permanently.",
            units.PRESSURE, LIMIT, instead=LIMIT, none=inf, may_be_zero=True,
        ),
        TissueQuantity(
            "flow viscosity",
            "Excess of the stress over the yield stress, per rate of permanent strain.",
            units.PRESSURE_TIME, VISCOSITY, instead=VISCOSITY, none=inf,
        ),
        TissueQuantity(
            BREAKING_STRAIN, "Strain at which the tissue breaks.", units.NUMBER,
            "strength", instead=BREAKING_FORCE, none=inf,
        ),
        TissueQuantity(
            STRENGTH, "Nominal stress at which a bar breaks.", units.PRESSURE,
            "strength", instead=BREAKING_FORCE, none=inf,
        ),
        TissueQuantity(
            TOUGHNESS, "Energy that a crack needs per area.", units.STIFFNESS,
            "strength", instead=BREAKING_FORCE, none=inf, unit="J/m^2",
        ),
        TissueQuantity(
            CUTTING_RESISTANCE, "Energy that a blade needs per area of the cut surface.",
            units.STIFFNESS, may_be_zero=True, unit="J/m^2",
        ),
    )
}  # fmt: skip
#: What can be known of matter: its quantities, and what only a laboratory measures.
KNOWABLE: dict[str, TissueQuantity] = {
    **{key: quantity for key, quantity in QUANTITIES.items() if quantity.is_of_matter},
    TIMES[0]: QUANTITIES[TIMES[0]],  # the same on every mesh
    SHEAR_MODULUS: TissueQuantity("shear modulus", "Shear stress per shear.", units.PRESSURE),
}
#: Those that messages list: of the branches of a spring, the first one represents all.
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
LEFT_OUT = frozenset((TOUGHNESS, FRICTION, *SHARES, *TIMES))
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
