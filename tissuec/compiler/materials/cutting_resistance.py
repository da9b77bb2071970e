"""The energy that blades need: resistances of springs and elements, from their tissues."""

from collections.abc import Mapping, Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.materials.tissue_parts import TissueParts
from tissuec.model.network import Floats
from tissuec.model.resistance import CuttingResistance
from tissuec.scene.tissues.quantities import CUTTING_RESISTANCE, FIBRE_MODULUS, YOUNGS_MODULUS


class SpringResistance(Struct, frozen=True, eq=False):
    """Resistance of the springs of a body or joint; see ``CuttingResistance``."""

    areas: Floats
    springs: Floats

    @classmethod
    def none(cls, count: int) -> "SpringResistance":
        """Return the resistance of springs that a blade cuts without any energy."""
        return cls(np.zeros(count), np.zeros(count))


def resistance_of_parts(parts: TissueParts) -> Floats:
    """Return the resistance of each part [J/m²], 0 of those that give none, shape (part,)."""
    given = [m.tissue and m.tissue.given.get(CUTTING_RESISTANCE) for m in parts.materials]
    return np.array([0.0 if one is None else one.value for one in given])


def resistance_of_springs(
    parts: TissueParts, ends: NDArray[np.integer], pull: Floats
) -> SpringResistance:
    """Return the resistance of bars, which a blade cuts across their section.

    Args:
        parts: Of the body.
        ends: Numbers of the parts at both ends of each, shape (spring, 2).
        pull: Spring constants times lengths as drawn [N].
    """
    softness = np.zeros(len(parts.materials))
    for number, material in enumerate(parts.materials):
        if material.tissue is not None and YOUNGS_MODULUS in material.tissue.given:
            given = material.tissue.given
            softness[number] = 1.0 / given.get(FIBRE_MODULUS, given[YOUNGS_MODULUS]).value
    resistance = resistance_of_parts(parts)
    softness[resistance == 0.0] = 0.0
    section = pull * softness[ends].mean(axis=1)
    energy = pull * (resistance * softness)[ends].mean(axis=1)
    each = np.divide(energy, section, out=np.zeros_like(energy), where=section > 0.0)
    return SpringResistance(section, each)


def joined_resistance(
    springs: Sequence[SpringResistance], elements: Mapping[str, Floats]
) -> CuttingResistance | None:
    """Return the resistance of a network; None if blades need no energy anywhere.

    Args:
        springs: Of bodies and joints, one after the other.
        elements: Of elements [J/m²] by the name of their block, shape (element,).
    """
    found = CuttingResistance(
        np.concatenate([np.zeros(0), *(one.areas for one in springs)]),
        np.concatenate([np.zeros(0), *(one.springs for one in springs)]),
        elements,
    )
    has_any = found.springs.any() or any(one.any() for one in elements.values())
    return found if has_any else None
