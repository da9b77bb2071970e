"""Elements whose laws have variables for the constants that are learnt.

Other numbers of elements, such as moduli, are numbers of their kernels anyway.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tissuec.core.structs import replace
from tissuec.forces.point_fields import PointField
from tissuec.laws.solid import SolidLaw
from tissuec.laws.solid_constants import (
    PlacedConstant,
    constant_at,
    differing,
    with_variables,
)
from tissuec.model.network import Indices, Network

_SAME = 1e-12  # relative difference of shapes that is rounding


class OpenLaws(NamedTuple):
    """Laws of elements with variables.

    Attributes:
        laws: With variables.
        law: Number of the law of each element, shape (element,).
        places: Of the variables in the laws.
        is_stretched: Whether the prestretch is a number of elements.
    """

    laws: tuple[SolidLaw, ...]
    law: Indices
    places: tuple[PlacedConstant, ...]
    is_stretched: bool


#: By the name of a block of elements.
OpenElements = Mapping[str, OpenLaws]


def elements_of(network: Network) -> dict[str, PointField]:
    """Return the elements of a network by the names of their blocks."""
    return {
        block.name: block.field
        for block in network.blocks
        if isinstance(block.field, PointField)
    }


def opened(network: Network, moved: Network) -> OpenElements:
    """Return laws with variables for all constants in which two networks differ.

    Raises:
        ValueError: They differ in what is no number of elements.
    """
    found: dict[str, OpenLaws] = {}
    others = elements_of(moved)
    for name, field in elements_of(network).items():
        other, is_stretched = others[name], False
        if not _have_same_shapes(field, other):
            field, other, is_stretched = field.with_stretches, other.with_stretches, True
        if not _have_same_shapes(field, other) or (
            field.kind != other.kind._replace(laws=field.kind.laws)
        ):
            raise ValueError("elements have other shapes or features")
        used = set(np.unique(other.law).tolist())
        places = [each for each in differing(field.laws, other.laws) if each.law in used]
        if places or is_stretched:
            laws = with_variables(field.laws, places)
            found[name] = OpenLaws(laws, other.law, tuple(places), is_stretched)
    return found


def _have_same_shapes(field: PointField, other: PointField) -> bool:
    pairs = zip((field.nodes, *field.measures), (other.nodes, *other.measures), strict=True)
    return all(
        a.shape == b.shape
        and np.abs(a - b).max(initial=0.0) <= _SAME * np.abs(a).max(initial=0.0)
        for a, b in pairs
    )


def with_open(network: Network, elements: OpenElements) -> Network:
    """Return a network whose elements have laws with variables, and constants as numbers."""
    blocks = [
        replace(block, field=_open(block.field, elements[block.name]))
        for block in network.blocks
        if block.name in elements
    ]
    return network.with_blocks(*blocks) if blocks else network


def _open(field: PointField, laws: OpenLaws) -> PointField:
    row = [constant_at(field.laws, place) for place in laws.places]
    constants = np.tile(row, (field.item_count, 1))
    field = field.with_stretches if laws.is_stretched else field
    return replace(field, laws=laws.laws, law=laws.law, constants=constants)
