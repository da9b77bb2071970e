"""Loops over elements that add their matrices to a sparse one."""

from collections.abc import Mapping, Sequence
from itertools import product

from tissuec.autodiff.emission import Writer
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.loops.cell_matrices import cell_matrices, cell_rows
from tissuec.compiled.loops.cells import CellLoop
from tissuec.compiled.loops.frame import LoopText, transposed
from tissuec.compiled.loops.point_frame import PointLoop, PointTable, parted
from tissuec.compiled.loops.tables import LANES, filled_count


def matrix_loop(name: str, point: TracedPoint, nodes: int, points: int) -> LoopText:
    """Return the loop that adds ∂²E/∂x∂x of elements to the entries of a sparse matrix.

    They are Σ w ∂N/∂X ∂²W/∂F∂F ∂N/∂X + U''/V p pᵀ with p = Σ w ∂r/∂F ∂N/∂X; the arguments are
    those of ``force_loop``.
    """
    if point.cell is not None:
        cells = CellLoop(point, point.cell, nodes, points)
        return _added(name, cells, cell_matrices(cells), cell_rows(nodes))
    loop = PointLoop(point, nodes, points)
    code, width, rows = loop.code, point.directions, _rows(nodes)
    size = filled_count(len(rows))
    outputs = [*point.moduli, *(point.pooling if point.is_pooled else ())]
    loop.begin([*outputs, point.bend_of_mean])
    halves, swell = loop.room_of(size), loop.room_of(3 * nodes)
    loop.clear(halves, size)
    loop.clear(swell, 3 * nodes)

    def add(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        written = loop.times(weight, code.write(outputs, values))
        moduli, pooling = parted(written, len(point.moduli))
        if pooling:
            loop.push(swell, pooling, slopes)
        # All of a node, one node after the other, so that what is turned stays in registers.
        for a in range(nodes):
            turned = {
                (i, j): loop.inner(
                    slopes[a], [_of_half(moduli, width * i + k, j) for k in range(width)]
                )
                for i, j in product(range(3), range(3 * width))
            }
            for b, i, j in product(range(a + 1), range(3), range(3)):
                several, row = (
                    [turned[i, width * j + k] for k in range(width)],
                    rows[a, b, i, j],
                )
                loop.put(loop.inner(slopes[b], several, loop.read(halves, row)), halves, row)

    loop.each_point("add", add)
    if point.is_pooled:
        (bend,) = code.write([point.bend_of_mean], loop.values)
        rise = code.add(f"fdiv {code.kind} {bend}, {loop.read(loop.sums, 0)}")
        pushed = [loop.read(swell, k) for k in range(3 * nodes)]
        for (a, b, i, j), row in rows.items():
            (both,) = loop.times(rise, [pushed[3 * a + i]])
            value = code.fused(both, pushed[3 * b + j], loop.read(halves, row))
            loop.put(value, halves, row)
    return _added(name, loop, halves, rows)


def _added(
    name: str, loop: PointLoop, halves: str, rows: Mapping[tuple[int, int, int, int], int]
) -> LoopText:
    """Return the loop that adds matrices of elements to the entries of ``matrix_loop``.

    Args:
        halves: Where their lower halves are, and room for a multiple of LANES.
        rows: Of the entries, by nodes and components.
    """
    code, size = loop.code, filled_count(max(rows.values()) + 1)

    def turn(block: str) -> None:
        # Squares are transposed in their places, so that numbers of a lane are side by side.
        first = code.add(f"mul i64 {block}, {LANES}")
        every = [code.add(f"add i64 {first}, {k}") for k in range(LANES)]
        square = transposed(code, [loop.read(halves, row) for row in every])
        for row, value in zip(every, square, strict=True):
            loop.put(value, halves, row)

    loop.repeat("turn", size // LANES, turn)
    loop.each_lane(lambda: _add_blocks(loop, halves, rows))
    return loop.text(name, ("x", "v", "out"), PointTable)


def _add_blocks(
    loop: PointLoop, halves: str, rows: Mapping[tuple[int, int, int, int], int]
) -> None:
    """Add the matrix of the present lane, whose numbers are side by side."""
    code, nodes = loop.code, loop.nodes
    own = loop.row(halves, "%lane")
    first = code.add(f"mul i64 %item, {nodes * (nodes + 1)}")
    for b in range(nodes):
        places = code.add(f"add i64 {first}, {b * (nodes + 1)}")
        places = code.address("%targets", places, "i64")
        apart = code.load(code.address(places, nodes, "i64"), "i64")
        for a in range(nodes):
            place = code.load(code.address(places, a, "i64"), "i64")
            to = code.address("%out", place)
            for j in range(3):
                every = [rows[(a, b, i, j) if a >= b else (b, a, j, i)] for i in range(3)]
                # Two at once, and the third, since vectors have no three lanes.
                for part, at in ((every[:2], to), (every[2:], code.address(to, 2))):
                    kind = f"<{len(part)} x double>"
                    old, more = code.load(at, kind), _turned(code, own, part)
                    code.store(code.add(f"fadd {kind} {old}, {more}"), at, kind)
                to = code.address(to, apart)


def _turned(code: Writer, own: str, rows: Sequence[int]) -> str:
    """Return numbers of a lane, side by side.

    Args:
        own: Where the first number of the lane is.
        rows: Of the numbers.
    """
    kind = f"<{len(rows)} x double>"
    places = [LANES * LANES * (row // LANES) + row % LANES for row in rows]
    if places == list(range(places[0], places[0] + len(places))):
        return code.load(code.address(own, places[0]), kind)
    found = "poison"
    for k, place in enumerate(places):
        number = code.load(code.address(own, place), "double")
        found = code.add(f"insertelement {kind} {found}, double {number}, i64 {k}")
    return found


def _rows(nodes: int) -> dict[tuple[int, int, int, int], int]:
    """Return the entries of the lower half of a matrix, by nodes and components."""
    entries = (
        (a, b, i, j) for a in range(nodes) for b in range(a + 1)
        for i in range(3) for j in range(3)
    )  # fmt: skip
    return {entry: row for row, entry in enumerate(entries)}


def _of_half(values: Sequence[str], row: int, column: int) -> str:
    """Return an entry of a symmetric matrix whose lower half is given row by row."""
    high, low = max(row, column), min(row, column)
    return values[high * (high + 1) // 2 + low]
