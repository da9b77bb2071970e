"""Common code of generators: spring lists, rows of nodes, places along a line, bending springs.

A grid numbers its nodes row by row: node ``row * columns + column``.

Steps along a line grow by one factor from its fine part on until they are coarse. Products of
such lines have no hanging nodes: a plane of a fine part goes through the whole block.

Bending springs: between nodes that are two steps apart on a surface.

A spring of constant c over a hinge whose sides, of length l, meet at the angle π - θ is
L = 2 l cos(θ/2) long and turns the hinge with

    M = dE/dθ = -c (L - L0) l sin(θ/2),

which near a drawn angle θ0 is c l² sin²(θ0/2) (θ - θ0). A surface that is drawn flat therefore
resists bending with the third power of the angle at first, and a curved one in proportion.
"""

from math import ceil
from typing import Any, Protocol, TypeAlias, cast, get_type_hints, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.fields import FromTo, OneOf, Point, Real, Whole
from tissuec.meshes.generators import Mesh
from tissuec.model.topology import lower_and_upper

Pairs: TypeAlias = NDArray[np.int64]


def springs(node_count: int, *pairs: Pairs) -> NDArray[np.int32]:
    """Return every pair once, lower node first, sorted by first and then second node.

    Sorted, so that the springs of a node lie together in memory and sums are reproducible.

    Args:
        node_count: Number of nodes.
        *pairs: Node pairs in any order and direction, each of shape (pair, 2).

    Returns:
        Node pair of each spring, shape (spring, 2).
    """
    low, high = lower_and_upper(np.concatenate(pairs))
    keys = np.sort(low * node_count + high)
    keys = keys[np.diff(keys, prepend=-1) > 0]
    return np.stack(np.divmod(keys, node_count), axis=1).astype(np.int32)


def grid_pairs(shape: tuple[int, int], step: tuple[int, int], *, wrap: bool = False) -> Pairs:
    """Return the pairs of grid nodes that lie ``step`` apart.

    Args:
        shape: Numbers of rows and columns.
        step: Rows (not negative) and columns from the first node of a pair to the second.
        wrap: Whether the last column is followed by the first.

    Returns:
        Node pairs, shape (pair, 2).
    """
    (rows, columns), (down, right) = shape, step
    column = np.arange(columns)
    if not wrap:
        column = column[max(0, -right) : max(0, columns - max(0, right))]
    row = np.arange(rows - down)[:, None]
    first = row * columns + column
    second = (row + down) * columns + (column + right) % columns
    return np.stack((first.ravel(), second.ravel()), axis=1)


def grid_triangles(shape: tuple[int, int], *, wrap: bool = False) -> NDArray[np.int32]:
    """Return two triangles per grid cell, cut along the step (1, 1).

    Their normals point along (direction of a row) x (direction of a column).

    Args:
        shape: Numbers of rows and columns.
        wrap: Whether the last column is followed by the first.

    Returns:
        Node numbers, shape (triangle, 3).
    """
    start, ahead = grid_pairs(shape, (1, 1), wrap=wrap).T
    columns = shape[1]
    beside, below = ahead - columns, start + columns
    halves = ((start, beside, ahead), (start, ahead, below))
    return (
        np.stack([np.stack(half, axis=1) for half in halves], axis=1)
        .reshape(-1, 3)
        .astype(np.int32)
    )


def require_limits(generator: object) -> None:
    """Check every field of ``generator`` against the metadata of its annotation.

    Raises:
        ValueError: A value is outside its declared limits; the message names the entry.
    """
    for field, hint in get_type_hints(type(generator), include_extras=True).items():
        for declared in getattr(hint, "__metadata__", ()):
            value = getattr(generator, field)
            problem = "" if value is None else _problem(value, declared)
            if problem:
                raise ValueError(f'"{field.replace("_", " ")}" {problem}')


def _problem(value: Any, declared: object) -> str:
    """Return a description of the error of ``value``, or an empty string."""
    match declared:
        case OneOf(words):
            return "" if value in words else f'must be one of {", ".join(words)}, not "{value}"'
        case Whole(at_least, at_most):
            if isinstance(value, bool) or not isinstance(value, int | np.integer):
                return f'must be a whole number, not "{value}"'
            whole = cast("int | np.integer[Any]", value)
            return _outside(int(whole), at_least, at_most, units.NUMBER)
        case Real(by_axis=True) if np.ndim(value):
            each = (_problem(one, declared) for one in np.ravel(value).tolist())
            return _not_points(value, (3,)) or next(filter(None, each), "")
        case Real(dimension, above, at_least, at_most):
            if not np.isfinite(value):
                return f'must be finite, not "{value}"'
            if above is not None and value <= above:
                limit, shown = (units.show(number, dimension) for number in (above, value))
                return f"must be above {limit}, not {shown}"
            return _outside(value, at_least, at_most, dimension)
        case Point():
            return _not_points(value, (3,))
        case FromTo(may_bend=may_bend):
            count = max(len(value), 2) if may_bend else 2
            return _not_points(value, (count, 3))
        case _:
            return ""


def _outside(
    value: float, low: float | None, high: float | None, dimension: units.Dimension
) -> str:
    shown = units.show(value, dimension, digits=9)
    if low is not None and value < low:
        return f"must be at least {units.show(low, dimension, digits=9)}, not {shown}"
    if high is not None and value > high:
        return f"must be at most {units.show(high, dimension, digits=9)}, not {shown}"
    return ""


def _not_points(value: Any, shape: tuple[int, ...]) -> str:
    array = np.asarray(value, dtype=np.float64)
    if array.shape != shape:
        return f"must have the shape {shape}, not {array.shape}"
    return "" if np.isfinite(array).all() else "must have finite components"


def require_fine_part(
    fine_cell: float | NDArray[np.float64] | None,
    fine_box: object,
    cell: float | NDArray[np.float64] | None,
) -> None:
    """Check the entries of a part with finer cells.

    Args:
        fine_cell: Size of cells in the part [m], one number or shape (3,).
        fine_box: Corners of the part.
        cell: Size of all other cells [m], likewise.

    Raises:
        ValueError: One of them is missing, or cells are not finer.
    """
    if (fine_cell is None) != (fine_box is None):
        raise ValueError('"fine cell" and "fine box" are needed together')
    if fine_cell is None or cell is None:
        return
    if np.all(np.greater_equal(fine_cell, cell)):
        raise ValueError('"fine cell" must be smaller than "cell"')
    for axis, is_larger in zip(
        "xyz", np.broadcast_to(np.greater(fine_cell, cell), 3), strict=True
    ):
        if is_larger:
            raise ValueError(f'"fine cell" must not be larger than "cell" along {axis}')


GROWTH = 1.5  # largest ratio of neighbouring steps; up to 1.6 where few coarse ones fit
_LEAST = 1.0 / GROWTH
_ROUNDING = 1e-9  # of a step


def graded_line(
    ends: tuple[float, float], fine_part: tuple[float, float], coarse: float, fine: float
) -> NDArray[np.float64]:
    """Return ascending places from one end to the other [m], shape (n,).

    Args:
        ends: Of the line [m], ascending.
        fine_part: Ends of the part with fine steps [m], ascending; what is outside of the line
            has no effect.
        coarse: Largest step [m].
        fine: Largest step of the fine part [m], at most ``coarse``.

    Raises:
        ValueError: The fine part is not on the line.
    """
    low, high = ends
    if fine_part[1] < low or fine_part[0] > high:
        raise ValueError("the fine part is not on the line")
    start, stop = max(fine_part[0], low), min(fine_part[1], high)
    if stop - start < fine:  # at least one step
        middle, half = 0.5 * (start + stop), 0.5 * min(fine, high - low)
        middle = min(max(middle, low + half), high - half)
        start, stop = middle - half, middle + half
    # What is left on a side has room for a step that is not much smaller.
    start = low if start - low < _LEAST * fine else start
    stop = high if high - stop < _LEAST * fine else stop
    count = max(1, ceil((stop - start) / fine - _ROUNDING))
    step = (stop - start) / count
    inside = np.linspace(start, stop, count + 1)
    before = start - np.cumsum(_growing(start - low, step, coarse))[::-1]
    after = stop + np.cumsum(_growing(high - stop, step, coarse))
    places = np.concatenate([before, inside, after])
    places[0], places[-1] = low, high  # whatever rounding did
    return places


def _growing(length: float, first: float, most: float) -> NDArray[np.float64]:
    """Return steps that grow from a first one, which is not among them [m], shape (n,).

    Args:
        length: Their sum [m].
        first: The step before them [m].
        most: Largest step [m].
    """
    if length <= 0.0:
        return np.zeros(0)

    def steps(factor: float, count: int) -> NDArray[np.float64]:
        with np.errstate(over="ignore"):
            return np.minimum(first * factor ** np.arange(1.0, count + 1.0), most)

    count = 1
    while steps(GROWTH, count).sum() < length * (1.0 - _ROUNDING):
        more = (length - steps(GROWTH, count).sum()) / most
        count += max(1, int(more))
    low, high = 0.0, GROWTH
    for _ in range(100):
        middle = 0.5 * (low + high)
        is_long = steps(middle, count).sum() > length
        low, high = (low, middle) if is_long else (middle, high)
    found = steps(high, count)
    return found * (length / found.sum())


@runtime_checkable
class Bendable(Protocol):
    """A generator that knows its second neighbours, or says why it has none."""

    def second_neighbours_of_surface(self) -> Pairs:
        """Return the pairs that bending springs join, shape (spring, 2).

        Raises:
            ValueError: Bending springs make no sense here, and why.
        """
        ...


def bending_springs(mesh: Mesh, generator: object) -> NDArray[np.int32]:
    """Return the pairs of second neighbours that no spring joins, shape (pair, 2).

    Without a word from the generator these are the nodes on either side of an edge of the skin.

    Raises:
        ValueError: There are none.
    """
    if isinstance(generator, Bendable):
        pairs = generator.second_neighbours_of_surface()
    elif len(mesh.skin):
        pairs = across_edges(mesh.skin)
    else:
        raise ValueError("it has no surface that can bend; join second neighbours by springs")
    count = len(mesh.position)
    found = springs(count, pairs)
    low, high = mesh.ends.min(axis=1), mesh.ends.max(axis=1)
    joined = low.astype(np.int64) * count + high
    asked = found[:, 0].astype(np.int64) * count + found[:, 1]
    new = found[np.isin(asked, joined, assume_unique=True, invert=True)]
    if not len(new):
        raise ValueError("springs already join all its second neighbours")
    return new


def across_edges(skin: NDArray[np.int32]) -> Pairs:
    """Return the two nodes beside each edge that two triangles share, shape (edge, 2)."""
    return around_edges(skin)[:, 2:]


def around_edges(skin: NDArray[np.int32]) -> Pairs:
    """Return the ends of each edge that two triangles share, and the two nodes beside it.

    Args:
        skin: Triangles, shape (triangle, 3).

    Returns:
        Nodes, shape (edge, 4); triangles with all three nodes in common have no such edge.
    """
    triangles = skin.astype(np.int64)
    size = int(triangles.max()) + 1
    first, second = triangles, np.roll(triangles, -1, axis=1)
    beside = np.roll(triangles, -2, axis=1).ravel()
    keys = (np.minimum(first, second) * size + np.maximum(first, second)).ravel()
    order = np.argsort(keys, kind="stable")
    keys, beside = keys[order], beside[order]
    begins = np.flatnonzero(np.diff(keys, prepend=-1))
    shared = begins[np.diff(begins, append=len(keys)) == 2]
    low, high = np.divmod(keys[shared], size)
    found = np.stack((low, high, beside[shared], beside[shared + 1]), axis=1)
    return found[found[:, 2] != found[:, 3]]
