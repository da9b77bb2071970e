"""Positions over time, read a few frames at a time."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from tissuec.results.trajectory import Trajectory

_AT_ONCE = 1 << 18  # nodes: 6 MB


def no_frames(trajectory: "Trajectory") -> TissueError:
    """Return the error that a result holds no frames, and what to do about it."""
    remedy = "; write output { trajectory every 20 ms } into the scene and run it again"
    if len(trajectory.nodes):
        remedy = " yet; run the scene to its end"
    return TissueError(f'"{trajectory.path}" has no frames{remedy}')


def batches(trajectory: "Trajectory", frames: slice = slice(None)) -> Iterator[Floats]:
    """Yield positions [m] in frames, shape (some frames, node, 3), until all were there."""
    chosen = range(len(trajectory.times))[frames]
    size = max(1, _AT_ONCE // max(1, len(trajectory.nodes)))
    for first in range(0, len(chosen), size):
        part = chosen[first : first + size]
        yield np.asarray(trajectory.position[part.start : part.stop], dtype=float)


def every_point(trajectory: "Trajectory", frame: int) -> Floats:
    """Return positions of nodes and all riding points in a frame [m], shape (point, 3).

    Those of a later cut are there, too, so that points have one number in all frames.
    """
    from tissuec.results.frame_columns import POSITION  # needed where something is drawn

    place = np.asarray(trajectory.position[frame], dtype=float)
    return trajectory.mesh.at_points(place, POSITION)


def drawn(trajectory: "Trajectory") -> Floats:
    """Return where the recorded nodes are drawn [m], shape (node, 3)."""
    return trajectory.network.position[trajectory.nodes]


def largest_displacements(trajectory: "Trajectory") -> Floats:
    """Return the largest displacement of a recorded node so far [m], shape (frame,)."""
    home, mesh = drawn(trajectory), trajectory.mesh
    own = slice(None) if mesh.cut is None else np.flatnonzero(mesh.are_matter[: len(home)])
    found = [
        np.linalg.norm((position - home)[:, own], axis=2).max(axis=1, initial=0.0)
        for position in batches(trajectory)
    ]
    return np.maximum.accumulate(np.concatenate([np.zeros(0), *found]))


def moved(trajectory: "Trajectory", rows: Indices, frames: slice) -> Floats:
    """Return the displacements of some recorded nodes [m], shape (frame, node, 3).

    Args:
        rows: Rows of the nodes in frames, shape (node,).
        frames: Range of frames.
    """
    home = drawn(trajectory)[rows]
    found = [position[:, rows] - home for position in batches(trajectory, frames)]
    return np.concatenate([np.zeros((0, len(rows), 3)), *found])
