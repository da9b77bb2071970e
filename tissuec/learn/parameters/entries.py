"""Parameters of single entries of arrays: of springs, of nodes, of members of a set."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy import sparse

from tissuec.learn.parameters.blocks import ParameterBlock
from tissuec.learn.parameters.numbers import NumberOrder
from tissuec.model.network import Floats, Indices

_NONE: Indices = np.zeros(0, dtype=np.int64)


class Entries:
    """Blocks whose parameters change entries by themselves, on top of all else.

    Args:
        blocks: All blocks of a fit_problem.
        parts: Places of the parameters of each.
    """

    def __init__(self, blocks: Sequence[ParameterBlock], parts: Sequence[slice]):
        self._own = [
            (block, block.group, part)
            for block, part in zip(blocks, parts, strict=True)
            if block.group is not None
        ]

    def __bool__(self) -> bool:
        return bool(self._own)

    def put(self, order: NumberOrder, vector: Floats, theta: Floats) -> Floats:
        """Return the numbers of a net in SI units, shape (number,), changed in place."""
        for block, chosen, parameters in self._chosen():
            array, change = order.array(vector, block.array), theta[parameters]
            if block.scale is None:
                array[chosen] *= np.exp(change)
            else:
                array[chosen] += block.scale * change * _sense(block, order)[chosen]
        return vector

    def factors(self, order: NumberOrder, theta: Floats) -> Floats:
        """Return the dimensionless factors of ``put``, shape (number,)."""
        factors = np.ones(order.size)
        for block, chosen, parameters in self._chosen():
            if block.scale is None:
                order.array(factors, block.array)[chosen] *= np.exp(theta[parameters])
        return factors

    def change(self, order: NumberOrder, vector: Floats, size: int) -> sparse.csr_matrix:
        """Return the derivative of the numbers, shape (number, parameter).

        Args:
            order: Order of the numbers.
            vector: Result of ``put`` in SI units, shape (number,).
            size: Number of parameters.
        """
        rows, columns, entries = [_NONE], [_NONE], [np.zeros(0)]
        for block, chosen, parameters in self._chosen():
            rows.append(chosen + order.places[block.array].start)
            columns.append(parameters)
            entries.append(
                order.array(vector, block.array)[chosen]
                if block.scale is None
                else block.scale * _sense(block, order)[chosen]
            )
        parts = np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))
        return sparse.csr_matrix(sparse.coo_matrix(parts, shape=(order.size, size)))

    def _chosen(self) -> Iterator[tuple[ParameterBlock, Indices, Indices]]:
        """Yield each block with the entries that it changes and the parameter of each."""
        for block, group, part in self._own:
            chosen = np.flatnonzero(group >= 0)
            yield block, chosen, part.start + group[chosen]


def _sense(block: ParameterBlock, order: NumberOrder) -> Floats:
    """Return the share that each component of a place or velocity has in its parameter."""
    along = block.adjust.along
    if along is None:
        return np.ones(order.sizes[block.array])
    return np.tile(along, order.sizes[block.array] // 3)
