"""How far the pieces of something have drawn apart."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.vectors import dot
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot

CHUNK = 64
"""Points compared at a time with those ahead: small beside the caches for any body."""


@MEASURES.member("gap")
class Gap(ScalarMeasure):
    """The smallest distance between nodes of A in different pieces of the net.

    0 as long as A is in one piece.
    """

    form = "gap(A)"
    dimension = units.LENGTH
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        nodes = snapshot.nodes(subjects[0])
        position, piece = snapshot.position[..., nodes, :], snapshot.pieces[nodes]
        states = position.reshape(-1, *position.shape[-2:])
        gaps = np.array([smallest_gap(state, piece) for state in states])
        return one_column(gaps.reshape(position.shape[:-2]), snapshot)


def smallest_gap(position: Floats, piece: NDArray[np.int32]) -> float:
    """Return the smallest distance between points of different pieces; 0 for a single piece.

    Points are swept along the longest side of their box: what lies further ahead than the best
    distance so far needs no comparison.

    Args:
        position: Points [m], shape (point, 3).
        piece: The piece of each, shape (point,).
    """
    if len(np.unique(piece)) < 2:
        return 0.0
    axis = int(np.ptp(position, axis=0).argmax())
    order = np.argsort(position[:, axis], kind="stable")
    position, piece = position[order], piece[order]
    best = np.inf
    for start in range(0, len(position), CHUNK):
        stop = min(start + CHUNK, len(position))
        reach = int(
            np.searchsorted(
                position[:, axis], float(position[stop - 1, axis]) + best, side="right"
            )
        )
        apart = position[start:stop, None, :] - position[None, start:reach, :]
        is_other = piece[start:stop, None] != piece[None, start:reach]
        squared = dot(apart, apart)
        best = min(best, float(np.sqrt(squared.min(where=is_other, initial=np.inf))))
    return best
