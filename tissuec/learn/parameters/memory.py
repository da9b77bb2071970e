"""Springs that remember, as compiled code reads them, and their numbers."""

import numpy as np
from numpy.typing import NDArray

from tissuec.kernels.derivative_records import SpringMemory
from tissuec.model.inelastic import Inelastic
from tissuec.model.network import Floats, Indices, Network

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
