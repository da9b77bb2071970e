"""Which entities exist, as bits of a dataset: one row of bytes after another."""

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Network
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.datasets import DatasetSpec


def row_bytes(network: Network) -> int:
    """Return how many bytes a row has."""
    return -(-network.entity_count // 8)


def read_alive(
    file: ResultGroup, dataset: DatasetSpec, row: int, network: Network
) -> NDArray[np.bool_]:
    """Return which entities of a network exist in a row, shape (entity,).

    Args:
        dataset: The bits, which have no unit.
        row: Number of the row.
    """
    size, found = row_bytes(network), access.dataset(file, dataset.path)
    rows = found[row * size : (row + 1) * size]
    if len(rows) < size:
        access.damaged(file.file, f'"{found.path}" is incomplete')
    return np.unpackbits(rows, count=network.entity_count).astype(bool)
