"""The shapes of instruments, made of turned and flat parts."""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats
from tissuec.results.instruments import (
    FIXED,
    LOWER,
    SHIFTED,
    STRETCHED,
    UPPER,
    Course,
    InstrumentMesh,
)

_SIDES = 12
_ROUND = 5  # rings of each end of a capsule
_MIRRORED = np.array([-1.0, -1.0, 1.0])  # half a turn about z: one jaw becomes the other
Solid = tuple[Floats, NDArray[np.int64]]  # vertices and triangles


def turned(profile: Sequence[tuple[float, float]], sides: int = _SIDES) -> Solid:
    """Return a solid of revolution about z.

    Args:
        profile: Heights along z and radii, upwards; the ends are closed.
        sides: Around.
    """
    height, radius = np.array(profile).T
    turn = 2.0 * np.pi * np.arange(sides) / sides
    x, y = (radius[:, None] * f(turn) for f in (np.cos, np.sin))
    return _tube(np.stack([x, y, np.broadcast_to(height[:, None], x.shape)], axis=-1))


def bent(path: Sequence[tuple[float, float]], widths: Sequence[tuple[float, float]]) -> Solid:
    """Return a bar of four sides along a path in the plane of x and z.

    Args:
        path: Points (x, z) of its middle.
        widths: At each point, along x and along y.
    """
    x, z = np.array(path).T
    thick, wide = np.array(widths).T / 2.0
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    rings = [[(x + a * thick), b * wide, z] for a, b in corners]
    return _tube(np.moveaxis(np.array(rings), 2, 0).transpose(0, 1, 2))


def ring(middle: tuple[float, float], radius: float, thick: float) -> Solid:
    """Return a ring in the plane of x and z, such as for a finger.

    Args:
        middle: (x, z).
        radius: Of its middle line.
        thick: Radius of its section.
    """
    around, section = 16, 6
    a = 2.0 * np.pi * np.arange(around) / around
    b = 2.0 * np.pi * np.arange(section) / section
    far = radius + thick * np.cos(b)[None]
    x, z = middle[0] + far * np.cos(a)[:, None], middle[1] + far * np.sin(a)[:, None]
    y = np.broadcast_to(thick * np.sin(b)[None], x.shape)
    corner = np.arange(around * section).reshape(around, section)
    right, up = np.roll(corner, -1, axis=0), np.roll(corner, -1, axis=1)
    both = np.roll(right, -1, axis=1)
    faces = [np.stack([corner, up, right], -1), np.stack([up, both, right], -1)]
    return np.stack([x, y, z], -1).reshape(-1, 3), np.concatenate(faces).reshape(-1, 3)


def _tube(rings: Floats) -> Solid:
    """Return the triangles between closed rings of points, shape (ring, side, 3), and lids."""
    count, sides = len(rings), int(rings.shape[1])
    corner = np.arange(count * sides).reshape(count, sides)
    a, b = corner[:-1], np.roll(corner, -1, axis=1)[:-1]
    c, d = corner[1:], np.roll(corner, -1, axis=1)[1:]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([b, d, c], -1)]).reshape(-1, 3)
    first, last = count * sides, count * sides + 1
    bottom, top = corner[0], corner[-1]
    lids = [
        np.stack([np.full(sides, first), np.roll(bottom, -1), bottom], -1),
        np.stack([np.full(sides, last), top, np.roll(top, -1)], -1),
    ]
    ends = np.stack([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    points = np.concatenate([rings.reshape(-1, 3), ends])
    return points, np.concatenate([faces, *lids])


def _mesh(parts: Sequence[tuple[int, Solid]], pivot: float = 0.0) -> InstrumentMesh:
    """Return solids as one mesh; those of the upper jaw are there for the lower one, too."""
    whole = list(parts)
    for part, (points, faces) in parts:
        if part == UPPER:
            whole.append((LOWER, (points * _MIRRORED, faces)))
    counts = np.cumsum([0, *(len(points) for _, (points, _) in whole)])
    return InstrumentMesh(
        np.concatenate([points for _, (points, _) in whole]),
        np.concatenate([np.full(len(points), part) for part, (points, _) in whole]),
        np.concatenate([f + n for n, (_, (_, f)) in zip(counts, whole, strict=False)]),
        pivot,
    )


def forceps() -> InstrumentMesh:
    """Return surgical forceps: two springy arms that meet at their upper end."""
    arm = bent(
        [
            (0.08, -0.6),
            (0.09, 0.0),
            (0.2, 1.0),
            (0.42, 2.6),
            (0.4, 4.4),
            (0.12, 6.2),
            (0.1, 7.0),
        ],
        [(0.14, 0.2), (0.18, 0.36), (0.2, 0.5), (0.2, 0.8), (0.2, 0.8), (0.2, 0.6), (0.2, 0.6)],
    )
    return _mesh([(UPPER, arm), (FIXED, bent([(0, 6.3), (0, 7.1)], [(0.3, 0.62)] * 2))], 6.6)


def scissors() -> InstrumentMesh:
    """Return scissors: two blades, a screw, and a ring for a finger behind each."""
    blade = bent(
        [(0.03, -1.0), (0.12, -0.2), (0.2, 0.9), (0.1, 1.5), (-0.3, 2.6), (-0.5, 3.8)],
        [(0.04, 0.04), (0.24, 0.08), (0.4, 0.1), (0.4, 0.14), (0.22, 0.18), (0.2, 0.2)],
    )
    screw = turned([(-0.16, 0.15), (0.16, 0.15)])
    points, faces = screw
    points = points[:, [0, 2, 1]] * [1.0, 1.0, 1.0] + [0.0, 0.0, 1.4]
    return _mesh(
        [
            (UPPER, blade),
            (UPPER, ring((-0.85, 4.4), 0.62, 0.13)),
            (FIXED, (points, faces[:, ::-1])),
        ],
        1.4,
    )


def clamp() -> InstrumentMesh:
    """Return a haemostat: thick jaws, a joint, rings, and a catch that locks them."""
    jaw = bent(
        [(0.07, -1.0), (0.12, 0.0), (0.2, 1.4), (0.1, 2.0), (-0.28, 3.2), (-0.5, 5.2)],
        [(0.14, 0.2), (0.24, 0.3), (0.34, 0.36), (0.4, 0.36), (0.24, 0.24), (0.22, 0.22)],
    )
    joint, faces = turned([(-0.3, 0.26), (0.3, 0.26)])
    catch, sides = turned([(0.0, 0.1), (0.44, 0.1)], 6)
    return _mesh(
        [
            (UPPER, jaw),
            (UPPER, ring((-0.88, 5.75), 0.62, 0.15)),
            (UPPER, (catch[:, [2, 0, 1]] + [-0.46, 0.0, 4.6], sides)),
            (FIXED, (joint[:, [1, 2, 0]] + [0.0, 0.0, 2.0], faces)),
        ],
        2.0,
    )


def needle() -> InstrumentMesh:
    """Return a curved needle, which the thread is pulled by at the origin."""
    turn = np.linspace(0.0, 0.85, 17) * np.pi
    radius = np.interp(turn, [0.0, 0.6 * np.pi, 0.85 * np.pi], [0.11, 0.12, 0.01])
    arc = 1.8
    middle = np.stack([arc * (1.0 - np.cos(turn)), 0.0 * turn, arc * np.sin(turn)], axis=1)
    outwards = np.stack([-np.cos(turn), 0.0 * turn, np.sin(turn)], axis=1)
    around = 2.0 * np.pi * np.arange(8) / 8
    rings = middle[:, None] + radius[:, None, None] * (
        np.cos(around)[:, None] * outwards[:, None]
        - np.sin(around)[:, None] * np.array([0.0, 1.0, 0.0])
    )
    return _mesh([(FIXED, _tube(rings))])


def scalpel() -> InstrumentMesh:
    """Return a scalpel, which cuts where no scissors are named."""
    edge = bent(
        [(0.05, -0.1), (0.12, 0.4), (0.16, 1.2), (0.1, 1.7)],
        [(0.02, 0.02), (0.34, 0.04), (0.36, 0.06), (0.22, 0.1)],
    )
    handle = bent(
        [(0.1, 1.7), (0.06, 2.4), (0.02, 6.5)], [(0.26, 0.14), (0.34, 0.2), (0.4, 0.2)]
    )
    return _mesh([(FIXED, edge), (FIXED, handle)])


def handle() -> InstrumentMesh:
    """Return the rod and the grip that a probe's ball is carried by."""
    return _mesh(
        [(FIXED, turned([(0.5, 0.3), (7.0, 0.3), (7.3, 0.55), (14.0, 0.55), (14.3, 0.4)]))]
    )


def jet() -> InstrumentMesh:
    """Return a jet of fluid, which flows against z and widens."""
    return _mesh([(STRETCHED, turned([(-1.0, 1.5), (-0.6, 1.15), (0.0, 0.8)], 16))])


def capsule() -> InstrumentMesh:
    """Return all points within 1 of a line from the origin along z."""
    turn = np.linspace(0.05, 0.5, _ROUND) * np.pi
    half = [(-float(np.cos(a)), float(np.sin(a))) for a in turn]
    points, faces = turned([*half, *((-z, r) for z, r in reversed(half))], 16)
    part = np.full(len(points), FIXED)
    rings = 16 * _ROUND
    part[rings : 2 * rings] = SHIFTED
    part[-1] = SHIFTED  # the middle of the lid
    return InstrumentMesh(points, part, faces)


def opening() -> InstrumentMesh:
    """Return the tube that leads to the opening of a nozzle."""
    return _mesh([(STRETCHED, turned([(0.0, 1.0), (0.2, 1.15), (1.0, 1.15)], 16))])


def plane() -> InstrumentMesh:
    """Return a part of a plane, whose upper side touches, as a thin plate."""
    return _mesh([(FIXED, turned([(-0.01, 2.0**0.5), (0.0, 2.0**0.5)], 4))])


_EVERY = (
    forceps, scissors, clamp, needle, scalpel, handle, jet, capsule, opening, plane,
)  # fmt: skip
KINDS: dict[str, Callable[[], InstrumentMesh]] = {one.__name__: one for one in _EVERY}


@cache
def mesh_of(kind: str) -> InstrumentMesh:
    """Return the mesh of a kind of instrument."""
    return KINDS[kind]()


def placed(course: Course, row: int) -> Floats:
    """Return the vertices of an instrument at a moment [m], shape (vertex, 3).

    Args:
        course: The instrument.
        row: The moment.
    """
    local = mesh_of(course.kind).posed(float(course.setting[row])) * course.size
    return course.origin[row] + local @ course.axes[row]
