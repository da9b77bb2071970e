"""Faces that turn about their middle: their rotation, and forces that form a couple.

Friction acts on a node, not where it touches a face; the couple of both is taken up by the
points of the face, by the smallest forces that form it.

Shared arguments:
    row: Index of the row of ``met``.
    c0, c1, c2: Components of a couple [N m].
    t0, t1, t2: Components of a vector, in any unit.
    touches: Record of the contact; its fields give the shapes and units.
"""

from tissuec.forces.contact.rows_kernel import points, push, shape_of
from tissuec.geometry.nearest import CAPSULE, PLANE
from tissuec.kernels.records import ContactTable, Floats

FLAT = 1e-12  # part of its size to the sixth: a triangle that thin takes up no couples


def arms(row: int, x: Floats, touches: ContactTable) -> tuple[float, ...]:
    """Return the vectors from the mean of the points of a face to each of them [m].

    The third one of a capsule is zero, because a capsule has two points.
    """
    a, b, c = points(row, touches)
    if touches.kind[shape_of(row, touches)] == CAPSULE:
        h0, h1, h2 = (
            0.5 * (x[b] - x[a]),
            0.5 * (x[b + 1] - x[a + 1]),
            0.5 * (x[b + 2] - x[a + 2]),
        )
        return -h0, -h1, -h2, h0, h1, h2, 0.0, 0.0, 0.0
    m0 = (x[a] + x[b] + x[c]) / 3.0
    m1 = (x[a + 1] + x[b + 1] + x[c + 1]) / 3.0
    m2 = (x[a + 2] + x[b + 2] + x[c + 2]) / 3.0
    return (
        x[a] - m0, x[a + 1] - m1, x[a + 2] - m2,
        x[b] - m0, x[b + 1] - m1, x[b + 2] - m2,
        x[c] - m0, x[c + 1] - m1, x[c + 2] - m2,
    )  # fmt: skip


def turned(
    row: int, t0: float, t1: float, t2: float, x: Floats, touches: ContactTable
) -> tuple[bool, float, float, float]:
    """Return whether a face can turn, and the inverse of its inertia times a vector.

    The inertia is that of unit masses on the corners [m²]. The inertia of a capsule about its
    own axis has no effect and is arbitrary.
    """
    kind = touches.kind[shape_of(row, touches)]
    if kind == PLANE:
        return False, 0.0, 0.0, 0.0
    a0, a1, a2, b0, b1, b2, c0, c1, c2 = arms(row, x, touches)
    xx, yy, zz = (
        a0 * a0 + b0 * b0 + c0 * c0,
        a1 * a1 + b1 * b1 + c1 * c1,
        a2 * a2 + b2 * b2 + c2 * c2,
    )
    xy, xz, yz = (
        a0 * a1 + b0 * b1 + c0 * c1,
        a0 * a2 + b0 * b2 + c0 * c2,
        a1 * a2 + b1 * b2 + c1 * c2,
    )
    square = xx + yy + zz
    if kind == CAPSULE:
        if square <= 0.0:
            return False, 0.0, 0.0, 0.0
        # What is about the line adds nothing to a cross product with it.
        return True, t0 / square, t1 / square, t2 / square
    i00, i11, i22, i01, i02, i12 = yy + zz, xx + zz, xx + yy, -xy, -xz, -yz
    j00, j01, j02 = i11 * i22 - i12 * i12, i02 * i12 - i01 * i22, i01 * i12 - i02 * i11
    j11, j12, j22 = i00 * i22 - i02 * i02, i01 * i02 - i00 * i12, i00 * i11 - i01 * i01
    size = i00 * j00 + i01 * j01 + i02 * j02
    if size <= FLAT * square**3:
        return False, 0.0, 0.0, 0.0
    return (
        True,
        (j00 * t0 + j01 * t1 + j02 * t2) / size,
        (j01 * t0 + j11 * t1 + j12 * t2) / size,
        (j02 * t0 + j12 * t1 + j22 * t2) / size,
    )


def spin(
    row: int, x: Floats, v: Floats, touches: ContactTable
) -> tuple[bool, float, float, float]:
    """Return whether a face can turn, and the rotation that fits its points best [1/s].

    The fit is by least squares.
    """
    a0, a1, a2, b0, b1, b2, c0, c1, c2 = arms(row, x, touches)
    a, b, c = points(row, touches)
    t0 = (
        a1 * v[a + 2]
        - a2 * v[a + 1]
        + b1 * v[b + 2]
        - b2 * v[b + 1]
        + c1 * v[c + 2]
        - c2 * v[c + 1]
    )
    t1 = a2 * v[a] - a0 * v[a + 2] + b2 * v[b] - b0 * v[b + 2] + c2 * v[c] - c0 * v[c + 2]
    t2 = a0 * v[a + 1] - a1 * v[a] + b0 * v[b + 1] - b1 * v[b] + c0 * v[c + 1] - c1 * v[c]
    return turned(row, t0, t1, t2, x, touches)


def twist(row: int, c0: float, c1: float, c2: float, x: Floats, touches: ContactTable) -> None:
    """Add the smallest forces on the points of a face that form a given couple [N]."""
    _, w0, w1, w2 = turned(row, c0, c1, c2, x, touches)
    a0, a1, a2, b0, b1, b2, g0, g1, g2 = arms(row, x, touches)
    push(row, 1, w1 * a2 - w2 * a1, w2 * a0 - w0 * a2, w0 * a1 - w1 * a0, touches)
    push(row, 2, w1 * b2 - w2 * b1, w2 * b0 - w0 * b2, w0 * b1 - w1 * b0, touches)
    push(row, 3, w1 * g2 - w2 * g1, w2 * g0 - w0 * g2, w0 * g1 - w1 * g0, touches)
