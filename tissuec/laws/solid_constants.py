"""Constants of laws of solids that are numbers of elements, so that they can be learnt.

A law has a variable in the place of such a constant: of a field, or of a number in its formula.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np
from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.laws.derivatives import energy
from tissuec.laws.formula import Constant, Given, Power, Variable
from tissuec.laws.solid import SolidLaw
from tissuec.laws.solid.volume import volume_energies

#: Invariants of stretched and of sheared solids, at which energies are compared.
_STATES = {
    "i1": np.array([3.01, 3.4, 5.0]), "i2": np.array([3.01, 3.3, 4.2]),
    "trace": np.array([3.5, 3.1, 5.5]), "cofactors": np.array([3.4, 2.9, 4.7]),
    "j": np.array([1.2, 0.8, 0.9]), "lame": np.array([1.5, 0.2, 9.0]),
}  # fmt: skip
_SAME = 1e-9  # of energies: what follows from moduli in two ways differs by rounding

_ANY = Variable("any number")

#: Names of fields, and places in tuples, that lead to a number.
Path: TypeAlias = tuple[str | int, ...]


class PlacedConstant(NamedTuple):
    """A constant: the number of its law among several, and where it is in the law."""

    law: int
    path: Path


def constant_name(number: int) -> str:
    """Return the name of the variable that stands for a constant."""
    return f"constant {number}"


def differing(laws: Sequence[SolidLaw], others: Sequence[SolidLaw]) -> list[PlacedConstant]:
    """Return the constants in which laws differ from others of the same kinds.

    Raises:
        ValueError: They differ in more.
    """
    found: list[PlacedConstant] = []
    for number, (law, other) in enumerate(zip(laws, others, strict=True)):
        if law == other or _are_same(law, other):
            continue
        ours, theirs = dict(_numbers(law)), dict(_numbers(other))
        own, their = (
            _with(one, dict.fromkeys(names, _ANY))
            for one, names in ((law, ours), (other, theirs))
        )
        if type(law) is not type(other) or own != their:
            raise ValueError("laws of different kinds")
        found += (PlacedConstant(number, path) for path in ours if ours[path] != theirs[path])
    return found


def constant_at(laws: Sequence[SolidLaw], place: PlacedConstant) -> float:
    """Return the value of a constant, in SI units."""
    return dict(_numbers(laws[place.law]))[place.path]


def with_variables(
    laws: Sequence[SolidLaw], places: Sequence[PlacedConstant]
) -> tuple[SolidLaw, ...]:
    """Return laws with variables for some constants, which are numbered in this order."""
    new: list[dict[Path, Any]] = [{} for _ in laws]
    for k, place in enumerate(places):
        new[place.law][place.path] = Variable(constant_name(k))
    return tuple(_with(law, own) for law, own in zip(laws, new, strict=True))


def _are_same(law: SolidLaw, other: SolidLaw) -> bool:
    several = zip(
        *((energy(each), *volume_energies(each)) for each in (law, other)), strict=True
    )
    return all(
        np.allclose(one.at(_STATES), another.at(_STATES), rtol=_SAME, atol=0.0)
        for one, another in several
    )


def _inner(part: Any) -> dict[Any, Any]:
    """Return the parts of a law, a formula or a tuple, by their places there."""
    if isinstance(part, tuple):
        return dict(enumerate(cast(tuple[Any, ...], part)))
    if not isinstance(part, Struct):
        return {}
    # Exponents that are learnt are formulas.
    names = ("base",) if isinstance(part, Power) else part.__struct_fields__
    return {name: getattr(part, name) for name in names}


def _numbers(part: Any, path: Path = ()) -> Iterator[tuple[Path, float]]:
    """Yield the numbers in a law, with where they are."""
    if isinstance(part, Constant | Given):
        yield path, part.value
    elif isinstance(part, float | int):
        yield path, float(part)
    else:
        for name, each in _inner(part).items():
            yield from _numbers(each, (*path, name))


def _with(part: Any, new: Mapping[Path, Any], path: Path = ()) -> Any:
    """Return a law with others in the places of some of its numbers."""
    if path in new:
        return new[path]
    inner = {name: _with(each, new, (*path, name)) for name, each in _inner(part).items()}
    if not inner:
        return part
    return tuple(inner.values()) if isinstance(part, tuple) else replace(part, **inner)
