"""Elastic constants of elements at rest, from their material parameters.

A family of fibres with the modulus β along the unit vector a adds β a a a a to the stiffness: a
body of Young's modulus E, stretched along a and free across, then has the modulus E + β,
whatever its Poisson's ratio. This holds in tension only, as fibres bear no compression.
"""

from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.matter.elasticity import (
    IN_PLANE,
    VOIGT,
    Elasticity,
    frames_of_triangles,
    of_plane_stress,
    of_space,
)
from tissuec.model.network import Floats, Grid

_ALIKE = 1e-9  # rounding
_PARALLEL = 1e-3  # components of the same direction differ by less, as those of round tubes do


class WallNodes(Struct, frozen=True, eq=False):
    """Nodes of a wall of triangles.

    Attributes:
        position: Of all nodes of the scene as drawn [m], shape (node, 3).
        nodes: Indices of the nodes of the wall.
        grid: Their arrangement in rows and columns, if there is one.
    """

    position: Floats
    nodes: slice
    grid: Grid | None


def constants_of_elements(own: tuple[Any, ...], wall: WallNodes | None) -> Elasticity | None:
    """Return the elastic constants of elements; None if they differ.

    Args:
        own: Elements, shape by shape.
        wall: Nodes of a wall; None for a solid.
    """
    shear = np.concatenate([one.shear for one in own])
    bulk = np.concatenate([one.bulk_modulus for one in own])
    counts = {one.fibres.along.shape[1] for one in own}
    if len(counts) > 1 or any(np.ptp(one) > _ALIKE * one.max() for one in (shear, bulk)):
        return None
    g, k = float(shear[0]), float(bulk[0])
    young, ratio = 9.0 * k * g / (3.0 * k + g), (1.5 * k - g) / (3.0 * k + g)
    count, more = counts.pop(), np.zeros(())
    for family in range(count):
        added = np.concatenate([one.fibres.modulus for one in own]) / count
        along = np.concatenate([_along(one, family, wall) for one in own])
        pairs = np.einsum("ti,tj->tij", along, along)
        if np.ptp(pairs, axis=0).max() > _PARALLEL or np.ptp(added) > _ALIKE * added.max():
            return None
        more = more + _of_fibres(along[0], float(added[0]))
    if wall is None:
        return of_space(young, ratio, more)
    return of_plane_stress(young, ratio, wall.position[wall.nodes], wall.grid, more)


def _along(own: Any, family: int, wall: WallNodes | None) -> Floats:
    """Return unit vectors along fibres, shape (element, 3); in walls, shape (element, 2)."""
    along = own.fibres.along[:, family]
    if wall is None:
        return np.asarray(along)
    corners = own.nodes - wall.nodes.start
    frame = frames_of_triangles(wall.position[wall.nodes], corners, wall.grid)
    drawn = np.einsum("tdi,tqik,tk->td", frame, own.deformations(wall.position), along)
    return np.asarray(drawn / np.linalg.norm(drawn, axis=1)[:, None])


def _of_fibres(along: Floats, modulus: float) -> Floats:
    """Return β a a a a in Voigt's order [Pa], shape (3, 3) of a wall, else (6, 6).

    Args:
        along: a, shape (2,) or (3,).
        modulus: β [Pa].
    """
    pairs = IN_PLANE if len(along) == 2 else VOIGT
    strain = np.array([along[i] * along[j] for i, j in pairs])
    return modulus * np.outer(strain, strain)
