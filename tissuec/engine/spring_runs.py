"""Springs in runs, which vector instructions process eight at a time.

A run is a row of springs between the nodes (i, i + k), (i + 1, i + 1 + k), …, of which
lattices, tubes and sheets have many; short gaps are filled. They need no lists
of nodes: the values of a run are contiguous in memory.

Runs end where a tile of ``springs.runs_kernel`` ends, for lower nodes as for upper ones. They
are kept in blocks by their lower nodes: ``engine.threads``.
"""

from itertools import pairwise

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiled.record_tables import aligned_zeros
from tissuec.core.structs import replace
from tissuec.engine.threads import BLOCK_NODES, Places, are_several, block_size
from tissuec.forces.springs.runs_kernel import LANES, NO_SPRING, NO_STEP, SIZE, TILE
from tissuec.kernels.records import Runs
from tissuec.model.network import Floats, Indices

GAP = 8  # springs that are missing in a row, at most
# Springs from which their lengths at rest take most of the nearer caches.
MANY = 100_000
MOST_STEPS = 2**15 - 1  # up or down, in two bytes
RUNS_AT_ONCE = 4096  # whose lengths are examined together
MOST_GROUPS = 32  # of blocks
LEAST_OF_GROUP = 4  # blocks
# What a run costs, and each of its springs, beside a spring by itself.
RUN_COST, SPRING_COST = 3.5, 0.4
# Springs whose nodes are further apart are cut into runs without common nodes.
FAR = 8 * LANES


class RunPlaces(Struct, frozen=True, eq=False):
    """Places of springs in runs.

    Attributes:
        first, offset: Nodes i and differences k, shape (run,).
        length, at: As in ``Runs``, shape (run,).
        block: As in ``Runs``, without blocks that begin no spring.
        width: Nodes of a block; 0 for a single one, if some springs are too long for several.
        place: Of each spring among those in runs, shape (spring,).
        size: How many those are, with what fills gaps.
    """

    first: Indices
    length: Indices
    offset: Indices
    at: Indices
    block: Indices
    width: int
    place: NDArray[np.integer]
    size: int

    @property
    def cost(self) -> float:
        """Return how many springs by themselves, without runs, would take as long."""
        return RUN_COST * len(self.first) + SPRING_COST * self.size

    @property
    def is_worthwhile(self) -> bool:
        """Return whether forces are computed faster in runs."""
        return self.cost < len(self.place)


def places_of(low: NDArray[np.integer], high: NDArray[np.integer]) -> RunPlaces:
    """Return springs in runs.

    Args:
        low, high: Their ends as places of nodes, low < high, shape (spring,); of a type that
            can count the springs and all gaps between them.
    """
    if not len(low):
        none = np.zeros(0, dtype=np.int64)
        return RunPlaces(none, none, none, none, np.zeros(1, dtype=np.int64), 0, none, 0)
    if (low[1:] < low[:-1]).any():
        order = np.argsort(low, kind="stable")
        found = places_of(low[order], high[order])
        place = np.empty_like(found.place)
        place[order] = found.place
        return replace(found, place=place)
    size = block_size(low, high)
    apart = are_several(high, size)
    width = size if apart else 4 * BLOCK_NODES
    # Block by block, so that what is needed on the way takes little room.
    begins = np.searchsorted(low, np.arange(0, int(low[-1]) + 1, width, dtype=low.dtype))
    place, filled = np.empty_like(low), 0
    parts: list[tuple[Places, Places, Places]] = []
    for begin, end in pairwise([*begins.tolist(), len(low)]):
        first, length, offset, within = _runs_of_block(low[begin:end], high[begin:end])
        place[begin:end] = within + filled
        filled += int(length.sum())
        parts.append((first, length, offset))
    first, length, offset = (
        np.concatenate(each).astype(np.int64) for each in zip(*parts, strict=True)
    )
    at = np.cumsum(length) - length
    counts = [len(firsts) for firsts, _, _ in parts] if apart else [len(first)]
    block = np.cumsum([0, *counts])
    return RunPlaces(first, length, offset, at, block, width if apart else 0, place, filled)


def _runs_of_block(low: Places, high: Places) -> tuple[Places, Places, Places, Places]:
    """Return first nodes, lengths and offsets of runs, and the place of each spring in them."""
    offset = high - low
    # NumPy sorts numbers of 16 bits by radix, which is four times as fast.
    short = offset.astype(np.uint16) if offset.max(initial=0) < 2**16 else offset
    order = np.argsort(short, kind="stable")
    offset, ordered = offset[order], low[order]
    step = np.diff(ordered)
    ends = (np.diff(offset) != 0) | (step <= 0) | (step > GAP + 1)
    start = np.flatnonzero(np.concatenate([[True], ends])[: len(low)])
    stop = np.append(start, len(low))[1:]
    first = ordered[start]
    length = ordered[stop - 1] - first + 1
    place = np.empty_like(low)
    place[order] = np.repeat(np.cumsum(length) - length - first, stop - start) + ordered
    first, length, offset = _cut(first, length, offset[start])
    filled = -(-length // LANES) * LANES
    # Between two tiles at a time, which stay in the nearest cache meanwhile.
    order = np.lexsort((first, offset, (first + offset) // TILE, first // TILE))
    at = np.empty_like(length)
    at[order] = np.cumsum(filled[order]) - filled[order]
    place += np.repeat(at - (np.cumsum(length) - length), length)[place]
    return first[order], filled[order], offset[order], place


def _cut(first: Places, length: Places, offset: Places) -> tuple[Places, Places, Places]:
    """Return parts of runs with lower nodes in one tile, and upper ones in one tile.

    No node of a part is both, if that takes no short parts. Where parts end does not depend on
    where runs begin: a spring that is gone leaves the order of sums as it is.
    """
    run, done = np.arange(len(first)), np.zeros_like(length)
    far, most = offset >= FAR, np.maximum(offset, LANES) // LANES * LANES
    parts: list[tuple[Places, Places, Places]] = []
    while len(run):
        low, left = first[run] + done, length[run] - done
        high = low + offset[run]
        size = np.minimum(left, TILE - np.maximum(low % TILE, high % TILE))
        size = np.where(far[run], np.minimum(size, most[run] - low % TILE % most[run]), size)
        parts.append((run, low, size))
        some = size < left
        run, done = run[some], (done + size)[some]
    of, low, size = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.lexsort((low, of))
    return low[order], size[order], offset[of[order]]


def packed(
    places: RunPlaces,
    nodes: int,
    parts: int,
    *,
    stiffness: Floats,
    rest: Floats,
    damping: Floats | None = None,
    near: Floats | None = None,
    near_crush: Floats | None = None,
) -> Runs:
    """Return springs in runs for the stepping code.

    Args:
        places: Places of the springs in runs.
        nodes: Number of nodes.
        parts: Of loops that threads share.
        stiffness, damping: Of springs [N/m], [N s/m], shape (spring,); both 0 for dead ones.
        rest: Their lengths at rest [m], shape (spring,).
        near, near_crush: Tension and pressure that are near to breaking [N], shape (spring,).
    """
    acts = stiffness != 0.0
    if damping is not None:
        acts |= damping != 0.0
    numbers = (stiffness, damping, near, near_crush)
    alike = all(value is None or _is_constant(value, acts) for value in numbers)

    def in_runs(value: Floats | None) -> Floats:
        if value is None:
            return np.zeros(0)
        filled = aligned_zeros(TILE if alike else places.size)
        if not alike:
            filled[places.place] = value
        elif len(value):
            filled.fill(value[acts.argmax()])
        return filled

    nodes = max(nodes, 1)
    width = places.width or -(-nodes // TILE) * TILE
    blocks = -(-nodes // width)
    none = np.full(blocks + 1 - len(places.block), len(places.first))
    block = np.concatenate([places.block, none])
    group = _groups(blocks)
    begin = np.repeat(group[:-1], np.diff(group)).repeat(np.diff(block))
    half = width // TILE * SIZE
    ring = min(blocks, 2) * half + SIZE

    def in_tiles(nodes: Indices) -> Indices:
        """Return where nodes are in the tiles of two blocks, which take turns."""
        own, within = divmod(nodes, width)
        return (own - begin) % 2 * half + within // TILE * SIZE + within % TILE

    return Runs(
        in_tiles(places.first), in_tiles(places.first + places.offset), places.length,
        places.at, block, group, width, in_runs(stiffness), in_runs(damping),
        *_lengths(places, np.where(acts, rest, NO_SPRING)),
        in_runs(near), in_runs(near_crush), alike,
        aligned_zeros(min(parts, len(group) - 1) * ring), ring,
        aligned_zeros((len(group) - 2) * 3 * width),
    )  # fmt: skip


def _lengths(places: RunPlaces, rest: Floats) -> tuple[Floats, Indices, NDArray[np.int16]]:
    """Return lengths at rest as in ``Runs``: ``rest``, ``base`` and ``steps``.

    They are in steps where they are many, and those of a run differ by no more than steps can
    express. The bits of successive floating-point numbers are successive integers.

    Args:
        places: Places of the springs in runs.
        rest: Lengths [m], negative of dead springs, shape (spring,).
    """
    lengths = aligned_zeros(places.size)
    lengths.fill(NO_SPRING)
    lengths[places.place] = rest
    whole = lengths, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int16)
    if places.size < MANY:
        return whole
    base, steps = np.zeros(len(places.first), dtype=np.int64), np.empty(places.size, np.int16)
    for begin in range(0, len(base), RUNS_AT_ONCE):
        some = slice(begin, begin + RUNS_AT_ONCE)
        at, length = places.at[some], places.length[some]
        own = slice(int(at[0]), int(at[-1] + length[-1]))
        bits, none = lengths[own].view(np.int64), lengths[own] < 0.0
        at = at - own.start
        least = np.minimum.reduceat(np.where(none, np.iinfo(np.int64).max, bits), at)
        most = np.maximum.reduceat(np.where(none, -1, bits), at)
        if (most - least > 2 * MOST_STEPS).any():
            return whole
        base[some] = np.where(most < 0, 0, least + MOST_STEPS)
        steps[own] = np.where(none, NO_STEP, bits - base[some].repeat(length))
    return np.zeros(0), base, steps


def are_shared(high: Places, size: int) -> bool:
    """Return whether there are several groups of blocks, which threads can share.

    Args:
        high: Upper nodes of springs, shape (spring,).
        size: Number of nodes of a block.
    """
    blocks = int(high.max(initial=0)) // size + 1
    return are_several(high, size) and len(_groups(blocks)) > 2


def _groups(blocks: int) -> Indices:
    """Return the first blocks of groups, and the number of blocks.

    There are as many as threads may share evenly, and each has blocks enough that it does not
    matter that the tiles of the next block are taken, too.
    """
    count = 1
    while count < MOST_GROUPS and blocks >= 2 * count * LEAST_OF_GROUP:
        count *= 2
    return np.arange(count + 1) * blocks // count


def _is_constant(value: Floats, acts: NDArray[np.bool_]) -> bool:
    """Return whether all springs that act have the same number."""
    if value.strides == (0,):
        return True
    return bool((value == value[acts.argmax()])[acts].all()) if len(value) else True
