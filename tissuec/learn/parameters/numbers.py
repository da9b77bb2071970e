"""The numbers of a network that can be learnt, in one flat vector and in their arrays.

A vector holds masses, spring constants, viscosities, rest lengths, constants of laws, ambient
damping, the numbers of fields and of what springs remember, and the places and velocities at
0 s, in this order. Derivatives by numbers have the same order.
"""

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType

import numpy as np
from msgspec import Struct
from scipy import sparse

from tissuec.kernels.derivative_records import Seeds, Sparse, Values
from tissuec.learn.parameters.fields import (
    ActingNumbers,
    Fields,
    memory_numbers,
    numbers,
    rows_of,
)
from tissuec.model.network import Floats, Network

VALUES = Values._fields
NETWORK = ("mass", "stiffness", "damping", "rest")  # those that are arrays of the network
STATE = ("position", "velocity")
NO_FIELDS: Fields = MappingProxyType({})


class NumberOrder(Struct, frozen=True, eq=False, dict=True):
    """Place of each array in the vector.

    Args:
        sizes: By name, in order.
        fields: All fields, each whole.
    """

    sizes: Mapping[str, int]
    fields: Fields = NO_FIELDS

    @classmethod
    def of(cls, network: Network, constants: int, fields: Fields = NO_FIELDS) -> "NumberOrder":
        """Return the order for a network some constants of whose laws may change.

        Args:
            network: The network.
            constants: How many.
            fields: All fields that have derivatives.
        """
        nodes, springs = network.node_count, network.spring_count
        own = sum(len(numbers(field)) for field in fields.values())
        state = 3 * nodes, 3 * nodes
        past = springs * rows_of(network.springs.inelastic)
        counts = (nodes, springs, springs, springs, constants, nodes, own, past, *state)
        return cls(dict(zip((*VALUES, *STATE), counts, strict=True)), fields)

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

    def values(self, vector: Floats) -> Values:
        """Return views of the arrays that act all the time."""
        return Values(*(self.array(vector, name) for name in VALUES))

    def vector(self, network: Network, fields: Fields = NO_FIELDS) -> Floats:
        """Return the numbers of a network in SI units, shape (number,).

        Constants of laws are 0, and so are numbers of fields that are not there.

        Args:
            network: The network.
            fields: Its fields.
        """
        parts = [network.array(name) for name in NETWORK]
        parts += [np.zeros(self.sizes["constants"]), np.zeros(self.sizes["drag"])]
        if network.drag is not None:  # followed by nodes of tools and hidden ones
            parts[-1][: len(network.drag)] = network.drag
        for name, field in self.fields.items():
            here = fields.get(name)
            parts.append(np.zeros_like(numbers(field)) if here is None else numbers(here))
        parts.append(memory_numbers(network.springs.inelastic))
        parts += [network.position.ravel(), network.velocity.ravel()]
        return np.concatenate(parts)

    def network(self, vector: Floats, network: Network) -> Network:
        """Return a network with other numbers; laws and fields are unchanged."""
        arrays = {name: self.array(vector, name).copy() for name in NETWORK}
        if network.drag is not None:
            arrays["drag"] = self.array(vector, "drag")[: len(network.drag)].copy()
        state = {name: self.array(vector, name).reshape(-1, 3).copy() for name in STATE}
        return network.with_arrays(arrays | state)

    def add(self, total: Floats, values: Values) -> None:
        """Add numbers that act all the time, or derivatives by them, to a vector.

        Args:
            total: Numbers or derivatives in any unit, shape (number,), changed in place.
            values: What is added.
        """
        for name, part in values._asdict().items():
            self.array(total, name)[:] += part

    def seeds(
        self, change: sparse.csr_matrix, factors: Mapping[str, Floats], acting: ActingNumbers
    ) -> Seeds:
        """Return the parts of a change of all numbers that act all the time.

        Args:
            change: By each parameter, shape (number, parameter).
            factors: Factors of the script on entries of arrays by name, dimensionless, shape of
                each.
            acting: The numbers of fields that act.
        """
        if factors:
            every = np.ones(self.size)
            for name, factor in factors.items():
                self.array(every, name)[:] = factor
            change = sparse.csr_matrix(sparse.diags(every) @ change)
        parts: list[Sparse] = []
        for name in VALUES[:-2]:
            rows = sparse.csr_matrix(change[self.places[name]])
            places = rows.indptr.astype(np.int64), rows.indices.astype(np.int64)
            parts.append(Sparse(*places, np.asarray(rows.data, dtype=float)))
        own = sparse.csr_matrix(sparse.csr_matrix(change[self.places["fields"]])[acting.places])
        fields, memory = (
            np.ascontiguousarray(one.toarray()).ravel()
            for one in (own, sparse.csr_matrix(change[self.places["memory"]]))
        )
        count = int(change.shape[1])  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
        total, room = np.empty(count), np.empty((3, count))
        return Seeds(*parts, fields=fields, memory=memory, total=total, room=room)
