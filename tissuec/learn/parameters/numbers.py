"""The numbers of a network and of its fields that can be learnt, in one flat vector.

A vector holds masses, spring constants, viscosities, rest lengths, constants of laws, ambient
damping, the numbers of fields and of what springs remember, and the places and velocities at
0 s, in this order. Derivatives by numbers have the same order.
"""

from collections.abc import Iterator, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy import sparse

from tissuec.forces.fields import Field
from tissuec.forces.matrices import ForceDerivatives, numbers_of, places_of
from tissuec.kernels.derivative_records import Seeds, Sparse
from tissuec.laws import Law
from tissuec.model.inelastic import Inelastic
from tissuec.model.network import ELEMENTS, SPRINGS, Floats, Indices, Network
from tissuec.script.verbs.preserve import Preserve

if TYPE_CHECKING:
    from tissuec.mechanics.state import State
    from tissuec.script.plan import Plan

#: Fields by what messages call them.
Fields = Mapping[str, Field]


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


def acting_numbers(acting: Fields, alive: NDArray[np.bool_], fields: Fields) -> Indices:
    """Return which numbers of all fields those of acting ones are, shape (n,).

    Args:
        acting: Fields without what is lost; at rest, without what has relaxed.
        alive: False for springs that were cut or broke, shape (spring,).
        fields: All fields, whole.
    """
    places = [np.zeros(0, dtype=np.int64)]
    for name, field, part in numbered(fields):
        if name in acting:
            lost, kept = field.lost_items(alive), derivatives_of(acting[name]).columns
            own = places_of(field, derivatives_of(field).columns, lost, kept)
            places.append(part.start + own)
    return np.concatenate(places)


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


def internal_rows(network: Network) -> Indices:
    """Return the rows of what springs and elements remember, shape (row,).

    See ``Network.internal``.
    """
    return np.concatenate([network.remembering(name) for name in (SPRINGS, ELEMENTS)])


def in_rows(values: Floats, network: Network, other: float = 0.0) -> Floats:
    """Return numbers of nodes, followed by others for rows of internal variables.

    Args:
        values: In any unit, shape (node, …).
        other: Of each row.
    """
    rows = np.full((network.row_count - len(values), *values.shape[1:]), other)
    return np.concatenate([values, rows])


#: Arrays of the vector, in its order.
ARRAYS = (
    "mass", "stiffness", "damping", "rest", "constants", "drag", "fields", "memory", "position",
    "velocity",
)  # fmt: skip
NETWORK = ("mass", "stiffness", "damping", "rest")  # those that are arrays of the network
STATE = ("position", "velocity")
NO_FIELDS: Fields = MappingProxyType({})


class NumberOrder(Struct, frozen=True, eq=False, dict=True):
    """Place of each array in the vector.

    Args:
        sizes: By name, in order.
        fields: All fields, each whole.
        laws: Of springs, with variables for constants that may change.
    """

    sizes: Mapping[str, int]
    fields: Fields = NO_FIELDS
    laws: tuple[Law, ...] = ()

    @classmethod
    def of(
        cls, network: Network, constants: int, fields: Fields = NO_FIELDS,
        laws: tuple[Law, ...] = (),
    ) -> "NumberOrder":  # fmt: skip
        """Return the order for a network some constants of whose laws may change.

        Args:
            constants: How many.
            fields: All fields that have derivatives.
            laws: As the attribute.
        """
        nodes, springs = network.row_count, network.spring_count
        own = sum(len(numbers(field)) for field in fields.values())
        state = 3 * nodes, 3 * nodes
        past = springs * rows_of(network.springs.inelastic)
        counts = (nodes, springs, springs, springs, constants, nodes, own, past, *state)
        return cls(dict(zip(ARRAYS, counts, strict=True)), fields, laws)

    @cached_property
    def places(self) -> dict[str, slice]:
        """Return the part of the vector that each array is."""
        ends = np.cumsum([0, *self.sizes.values()]).tolist()
        return {
            name: slice(first, last)
            for name, first, last in zip(self.sizes, ends, ends[1:], strict=False)
        }

    @property
    def size(self) -> int:
        """Return how many numbers there are."""
        return sum(self.sizes.values())

    def array(self, vector: Floats, name: str) -> Floats:
        """Return a view of one array, in SI units, shape (n,).

        Args:
            vector: All numbers in SI units, shape (number,).
            name: Name of the array.
        """
        return vector[self.places[name]]

    def vector(self, network: Network, fields: Fields = NO_FIELDS) -> Floats:
        """Return the numbers of a network in SI units, shape (number,).

        Constants of laws are 0, and so are numbers of fields that are not there.
        """
        parts = [network.array(name) for name in NETWORK]
        parts[0] = in_rows(network.mass, network, 1.0)  # whatever the scene weighs
        parts += [np.zeros(self.sizes["constants"]), np.zeros(self.sizes["drag"])]
        if network.drag is not None:  # followed by nodes of tools and internal variables
            parts[-1][: len(network.drag)] = network.drag
        for name, field in self.fields.items():
            here = fields.get(name)
            parts.append(np.zeros_like(numbers(field)) if here is None else numbers(here))
        parts.append(memory_numbers(network.springs.inelastic))
        parts += [
            in_rows(each, network).ravel() for each in (network.position, network.velocity)
        ]
        return np.concatenate(parts)

    def network(self, vector: Floats, network: Network) -> Network:
        """Return a network with other numbers; laws and fields are unchanged."""
        nodes = network.node_count
        arrays = {name: self.array(vector, name).copy() for name in NETWORK}
        arrays["mass"] = arrays["mass"][:nodes]
        if network.drag is not None:
            arrays["drag"] = self.array(vector, "drag")[: len(network.drag)].copy()
        state = {name: self.array(vector, name).reshape(-1, 3)[:nodes].copy() for name in STATE}
        return network.with_arrays(arrays | state)

    def seeds(
        self, change: sparse.csr_matrix, factors: Mapping[str, Floats], numbers: Indices
    ) -> Seeds:
        """Return the parts of a change of all numbers that act all the time.

        Args:
            change: By each parameter, shape (number, parameter).
            factors: Factors of the script on entries of arrays by name, dimensionless, shape of
                each.
            numbers: Those of the springs and fields that act, shape (n,).
        """
        if factors:
            every = np.ones(self.size)
            for name, factor in factors.items():
                self.array(every, name)[:] = factor
            change = sparse.csr_matrix(sparse.diags(every) @ change)
        parts: list[Sparse] = []
        for name in ("mass", "drag"):
            rows = sparse.csr_matrix(change[self.places[name]])
            places = rows.indptr.astype(np.int64), rows.indices.astype(np.int64)
            parts.append(Sparse(*places, np.asarray(rows.data, dtype=float)))
        own = np.ascontiguousarray(sparse.csr_matrix(change[numbers]).toarray()).ravel()
        count = int(change.shape[1])  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
        return Seeds(*parts, numbers=own, room=np.empty(count))
