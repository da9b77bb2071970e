"""Energies of the change of volume J of a solid, over its bulk modulus K.

All have the modulus K at rest. Compressed without limit at an unchanged shape, the logarithm
and the balanced one resist without limit; the quadratic one does not, so that a solid with free
sides and a small Poisson's ratio gives way. (J. C. Simo, R. L. Taylor, Comput. Meth. Appl.
Mech. Eng. 85:273, 1991, section 2.2; S. Doll, K. Schweizerhof, J. Appl. Mech. 67:17, 2000.)
"""

from collections.abc import Mapping
from functools import cache
from typing import Annotated, TypeAlias

from msgspec import Struct

from tissuec.core.fields import OneOf
from tissuec.laws.derivatives import energy
from tissuec.laws.formula import ZERO, Formula, apply, variables
from tissuec.laws.solid import LAME, TRACE, J, SolidLaw

_LOG = apply("log", (J,))
LOGARITHMIC = "logarithmic"
#: Formulas of j, by their names in the language.
VOLUMES: Mapping[str, Formula] = {
    LOGARITHMIC: 0.5 * _LOG**2,
    "quadratic": 0.5 * (J - 1.0) ** 2,
    "balanced": 0.25 * (J**2 - 1.0) - 0.5 * _LOG,
}


#: The type of fields that name one of ``VOLUMES``.
VolumeName: TypeAlias = Annotated[str, OneOf(tuple(VOLUMES))]


class WithVolume(Struct, frozen=True, kw_only=True):
    """A law of a solid that says what a change of volume costs.

    Attributes:
        volume: One of ``VOLUMES``.
    """

    volume: VolumeName = LOGARITHMIC


@cache
def volume_energies(law: SolidLaw) -> tuple[Formula, Formula]:
    """Return energies of the volume over the bulk and the shear modulus, formulas of j.

    The second one is what coupled laws need beside their energy, so that they have no stress at
    rest, and K there: their volume has the modulus λ = K - 2 μ/3. Whole laws have neither.
    """
    if is_whole(law):
        return ZERO, ZERO
    own = VOLUMES[getattr(law, "volume", LOGARITHMIC)]
    is_coupled = TRACE.name in variables(energy(law))
    return own, -1.0 * (_LOG + 2.0 / 3.0 * own) if is_coupled else ZERO


@cache
def is_whole(law: SolidLaw) -> bool:
    """Return whether the energy of a law includes that of the volume."""
    return LAME.name in variables(energy(law))
