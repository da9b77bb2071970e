"""Means at nodes of what springs, triangles or cells have."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats


def mean_at(corners: NDArray[np.integer], values: NDArray[Any], nodes: int) -> Floats:
    """Return the mean at each node of the items that it is a corner of, NaN without any.

    Args:
        corners: Nodes of each item, shape (item, corner).
        values: Of the items, in any unit, shape (…, item).
        nodes: How many nodes there are.

    Returns:
        In the unit of ``values``, shape (…, node).
    """
    at, width = corners.reshape(-1), corners.shape[1]
    count = np.bincount(at, minlength=nodes)
    leading = values.shape[:-1]
    rows = np.repeat(values.reshape(-1, values.shape[-1]), width, axis=1)
    total = [np.bincount(at, row, nodes) for row in rows.astype(float)]
    means = np.full((len(rows), nodes), np.nan)
    np.divide(np.array(total).reshape(len(rows), nodes), count, out=means, where=count > 0)
    return means.reshape(*leading, nodes)
