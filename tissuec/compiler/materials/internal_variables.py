"""Internal variables of springs and elements, and where states keep them."""

from collections.abc import Mapping, Sequence
from math import ceil, sqrt

import numpy as np

from tissuec.core.structs import replace
from tissuec.model.blocks import OF_ELEMENTS, FieldBlock
from tissuec.model.inelastic import CONSTANTS, LIMIT, TIMES, VISCOSITY, Inelastic
from tissuec.model.network import ELEMENTS, SPRINGS, Floats, Network
from tissuec.model.phantoms import Phantoms

Arrays = Mapping[str, Floats]


def inelastic_of(bodies: Sequence[Arrays], springs: Sequence[int]) -> Inelastic | None:
    """Return the branches and flow of the springs of bodies, without storage.

    Args:
        bodies: Quantities of each body, by name; those that it does not have are left out.
        springs: How many springs each of them has.
    """

    def every(name: str, default: float) -> Floats:
        parts = (
            body.get(name, np.full(count, default))
            for body, count in zip(bodies, springs, strict=True)
        )
        return np.concatenate([np.zeros(0), *parts])

    times = [every(name, np.inf) for name in TIMES]
    used = [row for row, time in enumerate(times) if np.isfinite(time).any()]
    viscosity = every(VISCOSITY, np.inf)
    if not used and not np.isfinite(viscosity).any():
        return None
    rows, shape = range(max(used, default=-1) + 1), (-1, len(viscosity))
    time = np.array([times[row] for row in rows]).reshape(shape)
    constant = np.array([every(CONSTANTS[row], 0.0) for row in rows]).reshape(shape)
    nowhere = np.full((len(rows) + 1, len(viscosity)), -1)
    return Inelastic(
        constant=np.where(np.isfinite(time), constant, 0.0),
        time=time,
        limit=np.where(np.isfinite(viscosity), every(LIMIT, np.inf), np.inf),
        viscosity=viscosity,
        slot=nowhere,
        rate=np.ones(nowhere.shape),
    )


def with_memory(network: Network) -> Network:
    """Return a network with the internal variables of its springs.

    Variables are multiplied by the fastest rate of the net, or their own if that is faster: an
    error of elongations counts then as one of positions does.
    """
    inelastic = network.springs.inelastic
    if inelastic is None:
        return network
    has = np.isfinite(np.vstack([inelastic.time, inelastic.viscosity]))
    count = int(np.count_nonzero(has))
    first = 3 * network.row_count
    slot = np.full(has.shape, -1)
    # The variables of a spring lie together.
    slot.T[has.T] = first + np.arange(count)
    own = np.vstack([1.0 / inelastic.time, np.zeros(has.shape[1])])
    rate = np.maximum(own, _fastest(network))
    known = network.with_internal(SPRINGS, ceil(count / 3))
    stored = replace(inelastic, slot=slot, rate=rate)
    return replace(known, springs=replace(known.springs, inelastic=stored))


def with_element_memory(network: Network) -> Network:
    """Return a network with the internal variables of its elements.

    Strains, times the size of their elements, are multiplied as those of springs are.
    """
    blocks = [
        block for block in network.blocks if block.kind in OF_ELEMENTS and block.field.remembers
    ]
    if not blocks:
        return network
    fastest = max(block.field.fastest(network.mass) for block in blocks)
    first, stored = network.row_count, list[FieldBlock]()
    for block in blocks:
        field = block.field.stored(first, fastest)
        first += len(field.internal_rows)
        stored.append(field.block)
    phantoms: list[Phantoms] = []
    for part in network.phantoms:
        own = sum(len(b.field.internal_rows) for b in stored if b.field.name == part.body)
        phantoms.append(replace(part, rows=slice(first, first + part.cuts * own)))
        first += part.cuts * own
    known = network.with_internal(ELEMENTS, first - network.row_count)
    return replace(known, phantoms=tuple(phantoms)).with_blocks(*stored)


def _fastest(network: Network) -> float:
    """Return a bound of the angular frequencies of a net [1/s]; 1 where nothing resists.

    Gershgorin's: ω² ≤ 2 Σ c / m over the springs of a node.
    """
    steep = network.springs.behaviour.steepness(np.zeros(network.spring_count))
    assert network.springs.inelastic is not None
    each = np.repeat(steep + network.springs.inelastic.sudden, 2)
    joined = np.bincount(network.springs.ends.ravel(), each, network.node_count)
    return sqrt(2.0 * float((joined / network.mass).max(initial=0.0))) or 1.0
