"""The drawn part of the network in a frame: lines, triangles, and single nodes as vertices."""

from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.edge_supports import SupportedEdges
from tissuec.model.network import Indices, Network


class Cells(NamedTuple):
    """The cells of one topology; nodes are numbered as in the frames.

    Attributes:
        vertices: Nodes that nothing below touches, shape (vertex, 1).
        lines: Ends of the springs that are alive, shape (line, 2).
        triangles: Skin that is whole, shape (triangle, 3).
        springs: Network number of the spring of each line, shape (line,).
    """

    vertices: Indices
    lines: NDArray[np.integer]
    triangles: NDArray[np.integer]
    springs: NDArray[np.integer]

    @property
    def total(self) -> int:
        """Return how many cells there are."""
        return len(self.vertices) + len(self.lines) + len(self.triangles)

    @property
    def triangle_rows(self) -> slice:
        """Return where the triangles stand among the cells: last."""
        return slice(self.line_rows.stop, self.total)

    @property
    def line_rows(self) -> slice:
        """Return where the lines stand among the cells: behind the vertices."""
        return slice(len(self.vertices), len(self.vertices) + len(self.lines))

    def same_as(self, other: "Cells | None") -> bool:
        """Return whether both draw the same."""
        return other is self or (other is not None and all(map(np.array_equal, self, other)))


class RecordedMesh(Struct, frozen=True, eq=False):
    """The part of a network that frames show.

    A triangle of the skin vanishes with the first of its edges that tears, or with the element
    that it belongs to: a cut opens the skin along the cut springs (see
    ``tissuec/geometry/edges.py`` for edges without springs).

    Attributes:
        nodes: Network numbers of the nodes shown, shape (node,).
        springs: Network numbers of the springs shown, shape (spring,).
        lines: Ends of those springs as rows of ``nodes``, shape (spring, 2).
        triangles: Triangles among those nodes, as rows of ``nodes``, shape (triangle, 3).
        faces: Numbers of these triangles in the skin of the network, shape (triangle,).
        edges: Supports of the edges of each triangle, shape (triangle, 3).
    """

    nodes: NDArray[np.integer]
    springs: NDArray[np.integer]
    lines: NDArray[np.integer]
    triangles: NDArray[np.integer]
    faces: Indices
    edges: SupportedEdges

    @classmethod
    def of(
        cls, network: Network, nodes: NDArray[np.integer], springs: NDArray[np.integer]
    ) -> "RecordedMesh":
        """Return the part of a network with some nodes and springs.

        Args:
            nodes: Ascending indices, shape (node,).
            springs: Ascending indices, shape (spring,).

        Raises:
            ValueError: Numbers do not ascend within the network, or a spring ends elsewhere.
        """
        nodes = _ascending(nodes, network.node_count, "node")
        springs = _ascending(springs, network.spring_count, "spring")
        row = np.full(network.node_count, -1, dtype=np.int32)
        row[nodes] = np.arange(len(nodes), dtype=np.int32)
        # Of a network that is recorded as a whole, its own array serves.
        whole = len(nodes) == network.node_count and len(springs) == network.spring_count
        lines = (
            network.springs.ends if whole else row[network.springs.ends[springs]].reshape(-1, 2)
        )
        if (lines < 0).any():
            spring = springs[(lines < 0).any(axis=1)][0]
            raise ValueError(f"spring {spring} is recorded, but not both of its ends are")
        shown = (row[network.skin] >= 0).all(axis=1)
        skin = network.skin[shown].reshape(-1, 3)
        sides = np.stack([skin, np.roll(skin, -1, axis=1)], axis=-1)
        marks = None if network.skin_marks is None else network.skin_marks[shown]
        edges = SupportedEdges.of(network.springs.ends, sides, marks)
        return cls(nodes, springs, lines, row[skin], np.flatnonzero(shown), edges)

    def cells(self, alive: NDArray[np.bool_]) -> Cells:
        """Return the cells drawn while the springs ``alive``, shape (spring,), exist."""
        shown = alive[self.springs]
        everything = slice(None) if shown.all() else shown  # which copies nothing
        lines, springs = self.lines[everything], self.springs[everything]
        triangles = self.triangles[self.edges.holding(alive).all(axis=1)]
        lonely = np.ones(len(self.nodes), dtype=bool)
        lonely[lines] = False
        lonely[triangles] = False
        return Cells(np.flatnonzero(lonely)[:, None], lines, triangles, springs)

    def drawn_triangles(self, cells: Cells) -> Indices:
        """Return the places among ``triangles`` of those that cells draw, shape (drawn,)."""
        powers = len(self.nodes) ** np.arange(3)
        known, drawn = (
            one.astype(np.int64) @ powers for one in (self.triangles, cells.triangles)
        )
        order = np.argsort(known)
        return order[np.searchsorted(known, drawn, sorter=order)]


def _ascending(numbers: NDArray[np.integer], count: int, what: str) -> NDArray[np.integer]:
    numbers = np.asarray(numbers).reshape(-1)
    inside = not len(numbers) or (numbers[0] >= 0 and numbers[-1] < count)
    if not inside or (numbers[1:] <= numbers[:-1]).any():
        raise ValueError(f"{what} numbers must ascend and be less than {count}")
    return numbers
