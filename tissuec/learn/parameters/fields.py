"""Fields of a scene, and springs that remember, whose numbers can be learnt."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.forces import Field
from tissuec.forces.derivatives import ForceDerivatives, numbers_of, places_of
from tissuec.kernels.derivative_records import SpringMemory
from tissuec.model.inelastic import Inelastic
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.verbs.preserve import Preserve

if TYPE_CHECKING:
    from tissuec.mechanics.state import State
    from tissuec.script.plan import Plan

#: Fields by what messages call them.
Fields = Mapping[str, Field]


class ActingNumbers(NamedTuple):
    """The numbers of the fields that act for a while.

    Attributes:
        places: Which of the numbers of all fields they are, shape (acting,).
        total: How many numbers all fields have.
    """

    places: Indices
    total: int

    def of_all(self, values: Floats) -> Floats:
        """Return the numbers of all fields, or derivatives by them, 0 for what does not act.

        Args:
            values: Of those that act, in any unit, shape (acting,).

        Returns:
            Shape (number,).
        """
        found = np.zeros(self.total)
        found[self.places] = values
        return found


def starting_state(plan: "Plan", network: Network) -> "State":
    """Return the state at 0 s, with all fields that the script makes at any time."""
    state = plan.start(network)
    for action in preserves(plan):
        made = action.made(network)
        state.put(made.block)
    return state


def preserves(plan: "Plan") -> Iterator[Preserve]:
    """Yield the actions that make fields."""
    for event in plan.every_event:
        if isinstance(event.action, Preserve):
            yield event.action


def every_field(plan: "Plan", network: Network) -> Fields:
    """Return all fields that act at any time."""
    return starting_state(plan, network).named_fields


def derivatives_of(field: Field) -> ForceDerivatives:
    """Return the derivatives of a field that has some."""
    found = field.derivatives
    assert not isinstance(found, str), found
    return found


def numbers(field: Field) -> Floats:
    """Return the numbers of a field in SI units, shape (number,)."""
    return numbers_of(field, derivatives_of(field).columns)


def numbered(fields: Fields) -> Iterator[tuple[str, Field, slice]]:
    """Yield the name of each field, the field, and where its numbers are among those of all."""
    start = 0
    for name, field in fields.items():
        stop = start + len(numbers(field))
        yield name, field, slice(start, stop)
        start = stop


def acting_numbers(state: "State", fields: Fields) -> ActingNumbers:
    """Return which numbers of all fields those of the fields of a state are.

    Args:
        fields: All fields, whole.
    """
    acting = state.named_fields
    places, total = [np.zeros(0, dtype=np.int64)], 0
    for name, field, part in numbered(fields):
        if name in acting:
            lost = field.lost_items(state.alive)
            places.append(part.start + places_of(field, derivatives_of(field).columns, lost))
        total = part.stop
    return ActingNumbers(np.concatenate(places), total)


_NONE: Indices = np.zeros(0, dtype=np.int64)
NO_MEMORY = SpringMemory(
    *[_NONE] * 4, slot=np.zeros((0, 1), dtype=np.int64), rate=np.zeros((0, 1)), springs=0
)


def rows_of(inelastic: Inelastic | None) -> int:
    """Return how many numbers each spring of a net has for what it remembers."""
    return 0 if inelastic is None else 2 * len(inelastic.constant) + 2


def memory_numbers(inelastic: Inelastic | None) -> Floats:
    """Return c1 and 1/τ of all branches, F and 1/η, 0 where there is none, in SI units.

    The shape is (row spring,), see ``Values``.
    """
    if inelastic is None:
        return np.zeros(0)
    yields = np.isfinite(inelastic.limit)
    limit, fluidity = np.where(yields, (inelastic.limit, 1.0 / inelastic.viscosity), 0.0)
    rows = inelastic.constant, 1.0 / inelastic.time, limit[None], fluidity[None]
    return np.concatenate(rows).ravel()


def remembering(network: Network) -> NDArray[np.bool_]:
    """Return which springs of a net remember anything, shape (spring,)."""
    if network.springs.inelastic is None:
        return np.zeros(network.spring_count, dtype=bool)
    return network.springs.inelastic.remembers


def memory_of(network: Network, springs: Indices) -> SpringMemory:
    """Return those of some springs that remember, given by numbers of shape (n,)."""
    inelastic = network.springs.inelastic
    if inelastic is None:
        return NO_MEMORY
    chosen = springs[inelastic.remembers[springs]].astype(np.int64)
    low, high = network.springs.ends[chosen].astype(np.int64).T
    return SpringMemory(
        np.ascontiguousarray(low),
        np.ascontiguousarray(high),
        chosen,
        network.springs.law[chosen].astype(np.int64),
        np.ascontiguousarray(inelastic.slot[:, chosen].T.astype(np.int64)),
        np.ascontiguousarray(inelastic.rate[:, chosen].T),
        network.spring_count,
    )
