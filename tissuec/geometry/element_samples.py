"""Places that fill elements evenly, by the weights of their corners.

They are those of an additive recurrence in the unit cube, from its middle on: parts of it that
a plane cuts off have their share of the places to a few of them (M. Roberts, The unreasonable
effectiveness of quasirandom sequences, 2018). In a triangle, ascending numbers a, b give the
weights a, b - a and 1 - b, and likewise in a tetrahedron: each order of the numbers has an
equal part of the cube (derived here).
"""

import numpy as np

from tissuec.geometry.edges import Floats

#: The positive roots of x³ = x + 1 and of x⁴ = x + 1.
_ROOTS = {2: 1.324717957244746, 3: 1.2207440846057596}
#: Corners of a hexahedron in the order of VTK, in the unit cube.
_CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)


def samples_within(shape: str, count: int) -> Floats:
    """Return the weights of corners at places within an element, shape (place, corner).

    Args:
        shape: "triangle", or of a solid.
        count: Of the places.
    """
    if shape == "triangle":
        return _ascending(_spread(count, 2))
    places = _spread(count, 3)
    if shape == "tetrahedron":
        return _ascending(places)
    if shape == "wedge":
        flat, height = _ascending(places[:, :2]), places[:, 2:]
        return np.concatenate([flat * (1.0 - height), flat * height], axis=1)
    assert shape in ("hexahedron", "quadratic hexahedron")  # within straight sides
    return np.where(_CUBE, places[:, None], 1.0 - places[:, None]).prod(axis=2)


def _spread(count: int, axes: int) -> Floats:
    """Return places in the unit square or cube, shape (place, axis)."""
    steps = _ROOTS[axes] ** -np.arange(1.0, axes + 1.0)
    return (0.5 + np.arange(count)[:, None] * steps) % 1.0


def _ascending(places: Floats) -> Floats:
    """Return weights of as many corners as there are axes, and one, shape (place, corner)."""
    low = np.zeros((len(places), 1))
    every = np.concatenate([low, np.sort(places, axis=1), low + 1.0], axis=1)
    return np.diff(every, axis=1)
