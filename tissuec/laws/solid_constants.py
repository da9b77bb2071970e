"""Constants of laws of solids that are numbers of elements, so that they can be learnt.

A law has a variable in the place of such a constant.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import fields

from tissuec.core.structs import replace
from tissuec.laws.derivatives import energy
from tissuec.laws.formula import Variable
from tissuec.laws.solid import SolidLaw

#: Invariants of stretched and of sheared solids, at which energies are compared.
_STATES = {"i1": np.array([3.01, 3.4, 5.0]), "i2": np.array([3.01, 3.3, 4.2])}
_SAME = 1e-9  # of energies: what follows from moduli in two ways differs by rounding


class PlacedConstant(NamedTuple):
    """A constant: the number of its law among several, and its name in the law."""

    law: int
    name: str


def constant_name(number: int) -> str:
    """Return the name of the variable that stands for a constant."""
    return f"constant {number}"


def differing(laws: Sequence[SolidLaw], others: Sequence[SolidLaw]) -> list[PlacedConstant]:
    """Return the constants in which laws differ from others of the same kinds.

    Raises:
        ValueError: They differ in more, or in constants that stay numbers.
    """
    found: list[PlacedConstant] = []
    for number, (law, other) in enumerate(zip(laws, others, strict=True)):
        if law == other or _are_same(law, other):
            continue
        if type(law) is not type(other):
            raise ValueError("laws of different kinds")
        for each in fields(type(law)):  # pyright: ignore[reportArgumentType]  # all are Structs
            one, another = (getattr(own, each.name) for own in (law, other))
            if one == another:
                continue
            if not isinstance(one, float | int):
                raise ValueError(f'"{each.name}" stays a number')
            found.append(PlacedConstant(number, each.name))
    return found


def _are_same(law: SolidLaw, other: SolidLaw) -> bool:
    values = [np.asarray(energy(each).at(_STATES)) for each in (law, other)]
    return bool(np.allclose(*values, rtol=_SAME, atol=0.0))


def with_variables(
    laws: Sequence[SolidLaw], places: Sequence[PlacedConstant]
) -> tuple[SolidLaw, ...]:
    """Return laws with variables for some constants, which are numbered in this order."""
    return _with(laws, {place: Variable(constant_name(k)) for k, place in enumerate(places)})


def places_in(laws: Sequence[SolidLaw]) -> list[PlacedConstant]:
    """Return the constants that variables stand for, in the order of their numbers."""
    found: dict[str, PlacedConstant] = {}
    for number, law in enumerate(laws):
        for each in fields(type(law)):  # pyright: ignore[reportArgumentType]  # all are Structs
            value = getattr(law, each.name)
            if isinstance(value, Variable):
                found[value.name] = PlacedConstant(number, each.name)
    return [found[constant_name(k)] for k in range(len(found))]


def with_constants(laws: Sequence[SolidLaw], values: Sequence[float]) -> tuple[SolidLaw, ...]:
    """Return laws with numbers in place of their variables, in the order of these."""
    return _with(laws, dict(zip(places_in(laws), values, strict=True)))


def _with(
    laws: Sequence[SolidLaw], values: Mapping[PlacedConstant, Any]
) -> tuple[SolidLaw, ...]:
    found = list[Any](laws)
    for place, value in values.items():
        found[place.law] = replace(found[place.law], **{place.name: value})
    return tuple(found)
