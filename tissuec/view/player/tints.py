"""Colours of tissue: those of the scene at each node, and which skins have an inside."""

from collections.abc import Container
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core import palette
from tissuec.model import topology
from tissuec.model.network import BodyPart, Floats, Indices
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.rules import rgb

GLOSS = 0.4  # of tissue of which the scene does not say it


def node_tints(trajectory: Trajectory) -> Floats:
    """Return red, green, blue and gloss of points, dimensionless, shape (point, 4)."""
    found = np.tile([*rgb(palette.SKIN), GLOSS], (trajectory.network.node_count, 1))
    for body in trajectory.network.bodies:
        found[body.nodes] = body_tint(trajectory, body.name)
    for group in trajectory.groups:
        if group.body and group.what == "nodes":
            found[group.indices] = body_tint(trajectory, group.body, group.name)
    return found[trajectory.mesh.representatives]


def node_tissues(trajectory: Trajectory) -> tuple[tuple[str, ...], Indices]:
    """Return the names of all tissues, and which points of frames have, shape (point,)."""
    names: dict[str, int] = {}
    found = np.zeros(trajectory.network.node_count, dtype=np.int64)

    def number(body: str, region: str = "") -> int:
        name = written_tissue(trajectory, body, region).get("name", body)
        return names.setdefault(name, len(names))

    for body in trajectory.network.bodies:
        found[body.nodes] = number(body.name)
    for group in trajectory.groups:
        if group.body and group.what == "nodes":
            found[group.indices] = number(group.body, group.name)
    return tuple(names), found[trajectory.mesh.representatives]


def written_tissue(trajectory: Trajectory, body: str, region: str = "") -> dict[str, Any]:
    """Return name and appearance of the tissue of a body or a region; empty if unknown.

    Args:
        body: Name of the body.
        region: Name of the region; empty for the rest of the body.
    """
    parts: dict[str, Any] = trajectory.manifest.get("tissues", {}).get(body, {})
    return parts.get(region) or parts.get("") or {}


def body_tint(trajectory: Trajectory, body: str, region: str = "") -> Floats:
    """Return red, green, blue and gloss of a body or a region, dimensionless, shape (4,).

    Args:
        body: Name of the body.
        region: Name of the region; empty for the rest of the body.
    """
    written = written_tissue(trajectory, body, region)
    gloss: float | None = written.get("gloss")
    colour = rgb(written.get("colour") or palette.SKIN)
    return np.array([*colour, GLOSS if gloss is None else gloss])


def is_hollow(
    trajectory: Trajectory, triangles: NDArray[np.integer], filled: Container[str]
) -> NDArray[np.bool_]:
    """Return which triangles have an inside: those of shells and tubes.

    Args:
        triangles: Rows of points of frames, shape (triangle, 3).
        filled: Names of bodies that are known to be solid.
    """
    network, hollow = trajectory.network, np.ones(len(triangles), dtype=bool)
    first = trajectory.mesh.representatives[triangles[:, 0]]
    for body in network.bodies:
        if body.name in filled or borders(network.skin_of(body)) == 1:
            hollow &= ~_within(first, body)
    return hollow


def _within(nodes: Indices, body: BodyPart) -> NDArray[np.bool_]:
    return (nodes >= body.nodes.start) & (nodes < body.nodes.stop)


def borders(triangles: NDArray[np.integer]) -> int:
    """Return how many lines bound a skin: none of a solid, two of a tube, one of a sheet.

    Args:
        triangles: Corners, shape (triangle, 3).
    """
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(sides, axis=0, return_counts=True)
    free = edges[count == 1]
    if not len(free):
        return 0
    used, ends = np.unique(free, return_inverse=True)
    labels = topology.pieces(len(used), ends.reshape(-1, 2).astype(np.int32))
    return len(np.unique(labels))
