"""Vectors and tensors of numbers of a graph, with the operations of mechanics."""

from collections.abc import Iterable, Mapping, Sequence
from typing import overload

from tissuec.autodiff.functions import maximum, ruled, sqrt, where
from tissuec.autodiff.graph import Number, Operand

_SWEEPS = 5  # of rotations; four leave rounding
TINY = 1e-100  # keeps quotients by a length, and by its square, finite where it is zero

#: Rows and columns of the numbers of a symmetric tensor, by how many directions it has.
PLACES: Mapping[int, tuple[tuple[int, int], ...]] = {
    3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)),
    2: ((0, 0), (1, 1), (0, 1)),
    1: ((0, 0),),
}


class Vector(Sequence[Number]):
    """Numbers side by side, often the three components of a point or of a direction.

    Attributes:
        components: The numbers.
    """

    __slots__ = ("components",)

    def __init__(self, components: Iterable[Number]):
        self.components = tuple(components)

    def __len__(self) -> int:
        return len(self.components)

    @overload
    def __getitem__(self, index: int) -> Number: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Number, ...]: ...

    def __getitem__(self, index: int | slice) -> Number | tuple[Number, ...]:
        return self.components[index]

    def __add__(self, other: "Vector") -> "Vector":
        return Vector(a + b for a, b in zip(self, other, strict=True))

    def __sub__(self, other: "Vector") -> "Vector":
        return Vector(a - b for a, b in zip(self, other, strict=True))

    def __mul__(self, factor: Operand) -> "Vector":
        return Vector(factor * a for a in self)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Operand) -> "Vector":
        return Vector(a / divisor for a in self)

    def __neg__(self) -> "Vector":
        return Vector(-a for a in self)


def dot(a: Sequence[Operand], b: Sequence[Operand]) -> Number:
    """Return the sum of the products of components; at least one is a number of a graph."""
    products = [one * other for one, other in zip(a, b, strict=True)]
    return _total(products)


def _total(parts: Iterable[Operand]) -> Number:
    found: Operand = 0.0
    for part in parts:
        found = found + part
    assert isinstance(found, Number)
    return found


def square(a: "Sequence[Operand] | Tensor") -> Number:
    """Return the sum of the squares of all components."""
    if isinstance(a, Tensor):
        return _total(dot(row, row) for row in a.rows)
    return dot(a, a)


def cross(a: Sequence[Number], b: Sequence[Number]) -> Vector:
    """Return the cross product of two vectors."""
    turns = (1, 2), (2, 0), (0, 1)
    return Vector(a[i] * b[j] - a[j] * b[i] for i, j in turns)


def _directions(length: Number, *components: Number) -> list[Number]:
    inverse = 1.0 / (length + TINY)
    return [inverse * each for each in components]


def norm(a: Vector) -> Number:
    """Return the length of a vector, whose derivatives are zero where it is zero."""
    return ruled(sqrt(dot(a, a)), a, _directions)


class Tensor:
    """A tensor of second order.

    Attributes:
        rows: Its three rows.
    """

    __slots__ = ("rows",)

    def __init__(self, rows: Iterable[Iterable[Number]]):
        self.rows = tuple(Vector(row) for row in rows)

    @property
    def flat(self) -> list[Number]:
        """Return its nine components, row by row."""
        return [each for row in self.rows for each in row]

    @property
    def transposed(self) -> "Tensor":
        """Return the tensor with rows and columns exchanged."""
        return Tensor(zip(*self.rows, strict=True))

    @property
    def cofactors(self) -> "Tensor":
        """Return the derivative of the determinant."""
        a, b, c = self.rows
        return Tensor((cross(b, c), cross(c, a), cross(a, b)))

    def __add__(self, other: "Tensor") -> "Tensor":
        return Tensor(a + b for a, b in zip(self.rows, other.rows, strict=True))

    def __sub__(self, other: "Tensor") -> "Tensor":
        return Tensor(a - b for a, b in zip(self.rows, other.rows, strict=True))

    def __mul__(self, factor: Operand) -> "Tensor":
        return Tensor(factor * row for row in self.rows)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Operand) -> "Tensor":
        return Tensor(row / divisor for row in self.rows)

    def of(self, vector: Sequence[Operand]) -> Vector:
        """Return its product with a vector."""
        return Vector(dot(row, vector) for row in self.rows)

    def __matmul__(self, other: "Tensor") -> "Tensor":
        columns = other.transposed.rows
        return Tensor([dot(row, column) for column in columns] for row in self.rows)


def determinant(a: Tensor) -> Number:
    """Return the determinant of a tensor."""
    return dot(a.rows[0], cross(a.rows[1], a.rows[2]))


def trace(a: Tensor) -> Number:
    """Return the sum of the diagonal of a tensor."""
    return _total(a.rows[k][k] for k in range(3))


def symmetric_part(a: Tensor) -> Tensor:
    """Return half the sum of a tensor and its transpose."""
    return 0.5 * (a + a.transposed)


def inner(a: Tensor, b: Tensor) -> Number:
    """Return the sum of the products of components."""
    return dot(a.flat, b.flat)


def symmetric(a: Tensor) -> Tensor:
    """Return a symmetric tensor that has each number off its diagonal twice."""
    return Tensor([a.rows[min(i, k)][max(i, k)] for k in range(3)] for i in range(3))


def gram(a: Tensor) -> Tensor:
    """Return aᵀ a, as of ``symmetric``."""
    return symmetric(a.transposed @ a)


def from_half(half: Sequence[Number], directions: int = 3) -> Tensor:
    """Return a symmetric tensor from its numbers in the order of ``PLACES``."""
    place = {each: k for k, each in enumerate(PLACES[directions])}
    every = range(directions)
    return Tensor([half[place[min(i, k), max(i, k)]] for k in every] for i in every)


def deviator(a: Tensor) -> Tensor:
    """Return a tensor without its mean diagonal."""
    mean = trace(a) / 3.0
    rows = a.rows
    return Tensor(
        [rows[i][j] - mean if i == j else rows[i][j] for j in range(3)] for i in range(3)
    )


def largest(a: Tensor) -> Number:
    """Return the largest eigenvalue of a symmetric tensor, of two or three rows.

    It is found by C. G. J. Jacobi's rotations (G. H. Golub, C. F. Van Loan, Matrix
    Computations, 2013, section 8.5): unlike closed forms, they leave no more than rounding
    where eigenvalues are equal.
    """
    rows = [list(row) for row in a.rows]
    pairs = [(i, j) for j in range(len(rows)) for i in range(j)]
    for _ in range(_SWEEPS if len(rows) > 2 else 1):
        for i, j in pairs:
            _rotate(rows, i, j)
    found = rows[0][0]
    for k in range(1, len(rows)):
        found = maximum(found, rows[k][k])
    return found


def _rotate(rows: list[list[Number]], i: int, j: int) -> None:
    """Make a component of a symmetric tensor zero by a rotation of two axes."""
    apart, mixed = rows[j][j] - rows[i][i], rows[i][j]
    twice = where(apart < 0.0, -2.0 * mixed, 2.0 * mixed)
    size = abs(apart) + sqrt(apart * apart + 4.0 * mixed * mixed)
    tangent = twice / maximum(size, TINY)
    cosine = 1.0 / sqrt(tangent * tangent + 1.0)
    sine = tangent * cosine
    for k in range(len(rows)):
        if k not in (i, j):
            one, other = rows[i][k], rows[j][k]
            rows[i][k] = rows[k][i] = cosine * one - sine * other
            rows[j][k] = rows[k][j] = sine * one + cosine * other
    rows[i][i], rows[j][j] = rows[i][i] - tangent * mixed, rows[j][j] + tangent * mixed
    rows[i][j] = rows[j][i] = mixed.graph.number(0.0)
