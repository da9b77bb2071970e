"""Matrices of elements whose points are strained by all nodes together; see ``autodiff.cells``.

Strains y of points have coefficients q(b), numbers b depend on vectors w, and these are linear
in the places of nodes: w = Σ N x. Second derivatives follow by the chain rule:

    ∂²E/∂b∂b = Σ ∂y/∂b ∂²W/∂y∂y ∂y/∂b + Σ ∂W/∂q ∂²q/∂b∂b + ∂²U/∂b∂b,
    ∂²E/∂w∂w = ∂b/∂w ∂²E/∂b∂b ∂b/∂w + Σ ∂E/∂b ∂²b/∂w∂w,    ∂²E/∂x∂x = N ∂²E/∂w∂w N.

There are few numbers b, and each depends on few vectors: on inner ones, or else on z.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from itertools import product

from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.loops.cells import CellLoop
from tissuec.compiled.loops.frame import LoopText
from tissuec.compiled.loops.point_frame import PointTable
from tissuec.compiled.loops.tables import LANES, filled_count

#: Values by rows and columns; those that are missing are zero.
_Sparse = Mapping[tuple[int, int], str]


def cell_rows(nodes: int) -> dict[tuple[int, int, int, int], int]:
    """Return where ``cell_matrices`` has the entries of a lower half, by nodes and components.

    All entries of a node are side by side.
    """
    return {
        (a, b, i, j): (a * nodes + b) * 9 + 3 * i + j
        for a in range(nodes) for b in range(a + 1) for i in range(3) for j in range(3)
    }  # fmt: skip


def cell_matrices(loop: CellLoop) -> str:
    """Return where lower halves of ∂²E/∂x∂x of elements are; see ``cell_rows``."""
    cell, point = loop.cell, loop.point
    by_b, slopes, moduli = cell.by_between, cell.strain_slopes, cell.between_moduli
    of_points = point.active_moduli
    loop.begin([*point.elastic_stress, *of_points.values()])
    pulls = loop.pulls(point.elastic_stress)
    written = iter(loop.of_cell([*by_b, *slopes.values(), *moduli.values()], pull=pulls))
    of_b = {f"by.{k}": next(written) for k in range(len(by_b))}
    strained, bent = ({place: next(written) for place in each} for each in (slopes, moduli))
    whole = _Half(loop, len(by_b), bent, also=_touched(loop, slopes))
    _add_points(loop, of_points, strained, whole)
    inner = set(cell.inner)
    outer = whole.among(lambda i, j: not inner.issuperset((i, j)))
    of_z = _by_vectors(loop, outer, of_b, is_inner=False)
    if inner:
        within = whole.among(lambda i, j: inner.issuperset((i, j)))
        of_inner = _by_vectors(loop, within, of_b, is_inner=True)
        found = _congruent(loop, "inner", of_inner, cell.inner_shares)
        for (a, b, i, j), row in cell_rows(len(cell.x) // 3).items():
            if (m := 3 * a + i) >= (n := 3 * b + j):
                of_z.add(m, n, loop.read(found, row))
    return _congruent(loop, "nodes", of_z, cell.shares)


class _Half:
    """The lower half of a matrix in memory.

    Args:
        size: Of the matrix.
        start: Its entries so far.
        also: Further ones that may be added to.
    """

    def __init__(
        self, loop: CellLoop, size: int, start: _Sparse,
        also: "set[tuple[int, int]] | None" = None,
    ):  # fmt: skip
        self._loop, self.size = loop, size
        self.room = loop.room_of(size * (size + 1) // 2)
        self.entries = {*start, *(also or ())}
        for place in sorted(self.entries):
            loop.put(start.get(place, loop.code.constant(0.0)), self.room, self.row(*place))

    def row(self, i: int, j: int) -> int:
        """Return where an entry is, i >= j."""
        return i * (i + 1) // 2 + j

    def read(self, i: int, j: int) -> str:
        """Return an entry, above the diagonal, too; the empty text if it is zero."""
        place = max(i, j), min(i, j)
        return self._loop.read(self.room, self.row(*place)) if place in self.entries else ""

    def add(self, i: int, j: int, one: str, other: str = "") -> None:
        """Add a number or a product to an entry, i >= j."""
        row, before = self.row(i, j), self.read(i, j)
        self._loop.put(_total(self._loop, [(before, ""), (one, other)]), self.room, row)
        self.entries.add((i, j))

    def among(self, chosen: Callable[[int, int], bool]) -> "_Half":
        """Return the same memory with some of its entries."""
        found = copy(self)
        found.entries = {place for place in self.entries if chosen(*place)}
        return found


def _touched(loop: CellLoop, slopes: Mapping[tuple[int, int], Number]) -> set[tuple[int, int]]:
    """Return the entries of ∂²E/∂b∂b to which points add."""
    columns = _columns(loop, slopes)
    pairs = loop.point.active_moduli
    every = [*pairs, *((j, i) for i, j in pairs)]
    found = (each for k, m in every for each in product(columns[k], columns[m]))
    return {(a, b) for a, b in found if a >= b}


def _columns(
    loop: CellLoop, slopes: Mapping[tuple[int, int], Number]
) -> dict[int, dict[int, list[tuple[int, int]]]]:
    """Return, of strains and numbers b, which term of the strain depends on it and its place.

    Args:
        slopes: Derivatives of coefficients by b.
    """
    begins = loop.cell.begins
    strain = {
        q: (k, q - begins[k])
        for k in loop.point.active
        for q in range(begins[k], begins[k + 1])
    }
    found = defaultdict[int, dict[int, list[tuple[int, int]]]](dict)
    for place, (q, b) in enumerate(slopes):
        k, term = strain[q]
        found[k].setdefault(b, []).append((term, place))
    return found


def _add_points(
    loop: CellLoop, of_points: Mapping[tuple[int, int], Number], strained: _Sparse, to: _Half
) -> None:
    """Add Σ ∂y/∂b ∂²W/∂y∂y ∂y/∂b of all points.

    Args:
        of_points: ∂²W/∂y∂y.
        strained: ∂q/∂b.
    """
    code, columns = loop.code, _columns(loop, loop.cell.strain_slopes)
    room = loop.keep(list(strained.values()))

    def add(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        terms = ["", *(term for (term,) in slopes)]  # the first one is 1
        written = loop.times(weight, code.write(list(of_points.values()), values))
        moduli = dict(zip(of_points, written, strict=True))
        moduli |= {(j, i): value for (i, j), value in moduli.items()}
        steep = dict[int, dict[int, str]]()
        for k, own in columns.items():
            steep[k] = {}
            for b, parts in own.items():
                pairs = [(loop.read(room, place), terms[term]) for term, place in parts]
                steep[k][b] = _total(loop, pairs)
        for k, own in steep.items():
            turned = defaultdict[int, list[tuple[str, str]]](list)
            for m, other in steep.items():
                for b, value in other.items() if (k, m) in moduli else ():
                    turned[b].append((moduli[k, m], value))
            for b, pairs in turned.items():
                value = _total(loop, pairs)
                for a in (a for a in own if a >= b):
                    to.add(a, b, own[a], value)

    loop.each_point("bend", add)


def _total(loop: CellLoop, pairs: Iterable[tuple[str, str]]) -> str:
    """Return a sum of products; empty first factors are zero, and empty second ones, one."""
    code, found = loop.code, ""
    for one, other in (pair for pair in pairs if pair[0]):
        if other and found:
            found = code.fused(one, other, found)
        elif other:
            found = code.add(f"fmul {code.kind} {one}, {other}")
        else:
            found = code.add(f"fadd {code.kind} {found}, {one}") if found else one
    return found or code.constant(0.0)


def _by_vectors(
    loop: CellLoop, whole: _Half, of_b: Mapping[str, str], *, is_inner: bool
) -> _Half:
    """Return ∂²E/∂w∂w, as far as it follows from some entries of ∂²E/∂b∂b, and from own b.

    Args:
        whole: ∂²E/∂b∂b.
        of_b: ∂E/∂b, by the names of inputs.
        is_inner: Whether w are inner vectors, of which those b are own that follow from them;
            or z, which has the others.
    """
    cell = loop.cell
    own = [k for k in range(whole.size) if (k in cell.inner) == is_inner]
    used = sorted({k for place in whole.entries for k in place})
    slopes = cell.between_slopes(used, is_inner=is_inner)
    moduli = cell.vector_moduli(own, is_inner=is_inner)
    written = iter(loop.of_cell([*slopes.values(), *moduli.values()], of_b))
    rows = defaultdict[int, dict[int, str]](dict)
    for k, m in slopes:
        rows[k][m] = next(written)
    found = {place: next(written) for place in moduli}
    for i in used:
        pairs = defaultdict[int, list[tuple[str, str]]](list)
        for j in used:
            if entry := whole.read(i, j):
                for m, value in rows[j].items():
                    pairs[m].append((entry, value))
        for m, each in pairs.items():
            value = _total(loop, each)
            for a in (a for a in rows[i] if a >= m):
                found[a, m] = _total(loop, [(found.get((a, m), ""), ""), (rows[i][a], value)])
    return _Half(loop, len(cell.x), found)


def _congruent(
    loop: CellLoop, name: str, half: _Half, shares: Sequence[Sequence[Number]]
) -> str:  # fmt: skip
    """Return where N A N of a matrix A by vectors is; see ``cell_rows``.

    Args:
        name: Of loops.
        half: A.
        shares: N, of each vector by each of what it is linear in.
    """
    code, count, ends = loop.code, len(shares), len(shares[0])
    room = loop.keep(loop.of_cell([share for each in shares for share in each]))
    found = loop.room_of(filled_count(9 * ends * ends))
    turned, every = loop.room_of(9 * count), range(count)

    def of(vector: int, end: str) -> str:
        return loop.read(room, code.add(f"add i64 {end}, {vector * ends}"))

    def one(a: str) -> None:
        own = [of(m, a) for m in every]
        for i, j, n in product(range(3), range(3), every):
            pairs = [(half.read(3 * m + i, 3 * n + j), own[m]) for m in every]
            loop.put(_total(loop, pairs), turned, (3 * i + j) * count + n)
        first = code.add(f"mul i64 {a}, {ends}")

        def other(b: str) -> None:
            own = [of(n, b) for n in every]
            row = code.add(f"mul i64 {code.add(f'add i64 {first}, {b}')}, 9")
            for k in range(9):
                pairs = [(loop.read(turned, k * count + n), own[n]) for n in every]
                loop.put(_total(loop, pairs), found, code.add(f"add i64 {row}, {k}"))

        loop.repeat(f"{name}.others", code.add(f"add i64 {a}, 1"), other)

    loop.repeat(name, ends, one)
    return found


# --- parts that are written -----------------------------------------------------------------


def column_loop(name: str, point: TracedPoint, by: str, nodes: int, points: int) -> LoopText:
    """Return the loop that writes minus derivatives of viscous forces on z, column by column.

    Args:
        name: Of the function.
        point: Of the elements.
        by: "x", z, or "v", dz/dt.
        nodes, points: Of each element.
    """
    loop = _cell_loop(point, nodes, points)
    code, side = loop.code, len(loop.cell.x)
    stress, changed = point.viscous_stress, point.viscous_change
    base = loop.row_of_blocks("out", side * side)
    loop.begin([*stress, *changed, *point.stress], moves=True)
    pulls, dpull = loop.pulls(stress), loop.room_of(loop.strained)

    def column(c: str, dx: str, dv: str) -> None:
        strain, rate = loop.carried(dx), loop.carried(dx, dv)
        loop.clear(dpull, loop.strained)

        def change(q: str) -> None:
            slopes, weight, values = loop.at_point(q)
            for letter, room in (("df", strain), ("dg", rate)):
                every = loop.gradient_of(room, slopes)
                values |= {f"{letter}.{k}": one for k, one in enumerate(every)}
            minus = code.add(f"fneg {code.kind} {weight}")
            loop.push(dpull, loop.times(minus, code.write(changed, values)), slopes)

        loop.each_point("change", change)
        rooms = {"pull": pulls, "dx": dx, "dv": dv, "dpull": dpull}
        found = loop.of_cell(loop.cell.braking_change, **rooms)
        first = code.add(f"mul i64 {c}, {side}")
        for k, value in enumerate(found):
            minus = code.add(f"fneg {code.kind} {value}")
            _store(loop, minus, base, code.add(f"add i64 {first}, {k}"))

    still = loop.room_of(side)
    loop.clear(still, side)
    _each_column(loop, lambda c, moved: column(c, *(
        (moved, still) if by == "x" else (still, moved)
    )))  # fmt: skip
    return loop.text(name, ("x", "v", "out"), PointTable)


def strain_loop(name: str, point: TracedPoint, nodes: int, points: int) -> LoopText:
    """Return the loop that writes derivatives of active coefficients by z, column by column."""
    loop = _cell_loop(point, nodes, points)
    code, active = loop.code, loop.cell.active
    base = loop.row_of_blocks("out", len(loop.cell.x) * len(active))
    loop.begin([])

    def column(c: str, moved: str) -> None:
        changes, first = loop.carried(moved), code.add(f"mul i64 {c}, {len(active)}")
        for k, q in enumerate(active):
            _store(loop, loop.read(changes, q), base, code.add(f"add i64 {first}, {k}"))

    _each_column(loop, column)
    return loop.text(name, ("x", "v", "out"), PointTable)


def _each_column(loop: CellLoop, write: Callable[[str, str], None]) -> None:
    """Write a loop over components of z, given the number of one and where its change is."""
    side = len(loop.cell.x)
    moved = loop.room_of(side)
    loop.clear(moved, side)

    def column(c: str) -> None:
        loop.put(loop.code.constant(1.0), moved, c)
        write(c, moved)
        loop.put(loop.code.constant(0.0), moved, c)

    loop.repeat("columns", side, column)


def _store(loop: CellLoop, value: str, base: str, row: str) -> None:
    """Write a value for ``tables.recorded`` to read."""
    code = loop.code
    code.store(value, code.address(base, code.add(f"mul i64 {row}, {LANES}")))


def _cell_loop(point: TracedPoint, nodes: int, points: int) -> CellLoop:
    """Return a writer of one loop over such elements."""
    assert point.cell is not None
    return CellLoop(point, point.cell, nodes, points)
