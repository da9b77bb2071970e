"""What the nodes of a solid stand for: their parts of its volume and of its boundary."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from tissuec.network import Floats

NEAR = 1e-6  # of a length: what is shorter than this is rounding


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """How a solid is shared out among its nodes.

    A uniform stress σ acts on its boundary with the force σ N on each node.

    Attributes:
        volume: [m³], shape (node,).
        outward: N, the area of the boundary times its outward normal [m²], shape (node, 3).
    """

    volume: Floats
    outward: Floats

    @classmethod
    def of(cls, position: Floats, volume: Floats, skin: NDArray[np.int32]) -> Self:
        """Return the solid within a closed skin.

        Args:
            position: [m], shape (node, 3).
            volume: What each node stands for [m³], shape (node,).
            skin: Triangles that face outwards, shape (triangle, 3).
        """
        a, b, c = position[skin].swapaxes(0, 1)
        third = np.cross(b - a, c - a) / 6.0
        outward = np.zeros_like(position)
        for corner in skin.T:
            np.add.at(outward, corner, third)
        near, far, number = _parallelograms(position, skin)
        for corner, share in ((near, -0.25), (far, 0.5)):
            np.add.at(outward, corner, share * third[number])
        return cls(volume, outward)


def _parallelograms(
    position: Floats, skin: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int64]]:
    """Return the parallelograms that triangles make in pairs, across the longest edge of both.

    Thirds of triangles depend on which diagonal divides them; quarters of the whole do not.

    Returns:
        For each triangle in a pair: nodes on the diagonal and one that is not on it, each once
        for either triangle, and its number.
    """
    corners = position[skin]
    opposite = np.linalg.norm(
        np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1), axis=2
    )
    apex = np.argmax(opposite, axis=1)
    ordered = np.sort(opposite, axis=1)
    number = np.flatnonzero(ordered[:, 1] < (1.0 - NEAR) * ordered[:, 2])
    rows = skin[number]
    apexes = rows[np.arange(len(number)), apex[number]]
    diagonal = np.sort(
        [rows[np.arange(len(number)), (apex[number] + k) % 3] for k in (1, 2)], axis=0
    )
    order = np.lexsort(diagonal)
    first, second = order[:-1], order[1:]
    is_pair = (diagonal[:, first] == diagonal[:, second]).all(axis=0)
    first, second = first[is_pair], second[is_pair]
    bent = (
        position[apexes[first]]
        + position[apexes[second]]
        - position[diagonal[:, first]].sum(axis=0)
    )
    flat = np.linalg.norm(bent, axis=1) < NEAR * ordered[number[first], 2]
    paired = np.concatenate([first[flat], second[flat]])
    return diagonal[:, paired], apexes[paired], number[paired]
