"""The triangles that a jet may meet, and into how many elements they are divided."""

from collections.abc import Iterator

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import cross
from tissuec.core.structs import replace
from tissuec.forces.enclosed.volume import open_edges
from tissuec.geometry.edge_supports import SupportedEdges
from tissuec.model.cut_cells import PartTriangles
from tissuec.model.network import BodyPart, Floats, Indices, Network

FINE = 1.0  # parts of an edge for each width b0 of it
MOST = 16  # parts of an edge; jets that would need more are widened
# Nothing is so far inside of a face of a cut as to be in its shade [m]. What it would shade is
# also behind the surface through which the jet leaves the body; and where a cut is closed, its
# blurred shade would reach the surface on the other side.
NO_SHADE = -1e9
BLUR, THIN = 0.4, 0.35  # of b0, and of the height of a triangle: how far its shade is blurred


class JetSurface(Struct, frozen=True, eq=False):
    """Triangles that a jet may meet.

    Attributes:
        corners: Nodes, shape (triangle, 3).
        side: From where each can be pushed: 1 from where its corners turn left, -1 from the
            other side, 0 from both, as what belongs to no closed surface.
        struck: Whether it is pushed, or shades others only.
        parts: Into how many parts its edges are divided; it has three elements for each square.
        blur: How far their shades are blurred, to each side [m]; ``NO_SHADE`` of faces of cuts.
        edges: What holds the edges of triangles of the skin as drawn, which come first.
        whole: Which triangles are not torn.
        drawn: Corners as drawn [m], shape (triangle, 3, 3).
        like: The triangle of the skin that each is a part of, -1 of faces of cuts, shape
            (triangle,).
        nodes: Those whose triangles are pushed, shape (n,).
    """

    corners: Indices
    side: Indices
    struck: NDArray[np.bool_]
    parts: Indices
    blur: Floats
    edges: SupportedEdges
    whole: NDArray[np.bool_]
    drawn: Floats
    like: Indices
    nodes: Indices

    @classmethod
    def of(
        cls, network: Network, nodes: Indices, width: float, alive: NDArray[np.bool_]
    ) -> "JetSurface":
        """Return the triangles that a jet may meet.

        Args:
            nodes: Nodes whose triangles are pushed, shape (n,).
            width: Width b0 of the jet [m].
            alive: Springs that exist, shape (spring,).
        """
        corners = network.skin.astype(np.int64)
        drawn, every = network.position[corners], np.arange(len(corners))
        rings = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1)
        edges = SupportedEdges.of(network.line_ends, rings, network.skin_elements)
        struck = np.asarray(np.isin(corners, nodes).all(axis=1))
        blur = np.minimum(BLUR * width, THIN * _height(drawn))
        whole = np.asarray(edges.holding(alive).all(axis=1))
        return cls(
            corners, _sides(network, corners), struck, _parts(drawn, width), blur, edges, whole,
            drawn, every, nodes,
        )  # fmt: skip

    def with_parts(
        self, parts: PartTriangles, drawn: Floats, pushed: NDArray[np.bool_], width: float
    ) -> "JetSurface":
        """Return the same after cuts, with parts of triangles, and faces of cuts.

        Args:
            parts: Triangles that bound parts of solids and walls.
            drawn: Corners of these as drawn [m], shape (part, 3, 3).
            pushed: Which are pushed if they are faces of cuts, shape (part,).
            width: Width b0 of the jet [m].
        """
        count, like, is_cut = len(self.edges.own), parts.skin, parts.cuts != 0
        new = {
            "corners": parts.corners,
            "side": np.where(is_cut, 1, self.side[like]),
            "struck": np.where(is_cut, pushed, self.struck[like]),
            "parts": _parts(drawn, width),
            "blur": np.where(is_cut, NO_SHADE, self.blur[like]),
            "whole": np.ones(len(like), dtype=bool),
            "drawn": drawn,
            "like": like,
        }
        both = {n: np.concatenate([getattr(self, n)[:count], new[n]]) for n in new}
        return replace(self, **both)

    @property
    def count(self) -> Indices:
        """Return the number of elements of each triangle, shape (triangle,)."""
        return 3 * self.parts**2

    def torn(self, alive: NDArray[np.bool_]) -> "JetSurface":
        """Return the same while the springs ``alive``, shape (spring,), are there."""
        whole = np.asarray(self.edges.holding(alive).all(axis=1))
        whole = np.append(whole, self.whole[len(whole) :])
        return self if np.array_equal(whole, self.whole) else replace(self, whole=whole)


def finest_width(network: Network, nodes: Indices, bore: float) -> float:
    """Return b0 of a jet, or the smallest width that triangles of some nodes resolve [m].

    Args:
        nodes: Nodes whose triangles are pushed, shape (n,).
        bore: Diameter of the opening [m].
    """
    corners = network.skin[np.isin(network.skin, nodes).all(axis=1)]
    longest = float(_longest(network.position[corners]).max())
    return max(bore / np.sqrt(2.0), FINE * longest / MOST)


def _parts(drawn: Floats, width: float) -> Indices:
    """Return into how many parts edges of triangles are divided, shape (triangle,)."""
    # Less a little, so that rounding does not divide equal triangles differently.
    parts = np.ceil(FINE * _longest(drawn) / width - 1e-9)
    return np.clip(parts, 1, MOST).astype(np.int64)


def _longest(drawn: Floats) -> Floats:
    """Return the longest edges of triangles [m], shape (triangle,).

    Args:
        drawn: Corners as drawn [m], shape (triangle, 3, 3).
    """
    return np.linalg.norm(drawn - np.roll(drawn, 1, axis=1), axis=2).max(axis=1)


def _height(drawn: Floats) -> Floats:
    """Return the least heights of triangles [m], shape (triangle,); argument as above."""
    one, other = drawn[:, 1] - drawn[:, 0], drawn[:, 2] - drawn[:, 0]
    twice = np.linalg.norm(cross(one, other), axis=1)
    longest = _longest(drawn)
    return twice / np.where(longest > 0.0, longest, 1.0)


def _sides(network: Network, corners: Indices) -> Indices:
    """Return from where triangles can be pushed, as ``JetSurface.side``, body by body."""
    side = np.zeros(len(corners), dtype=np.int64)
    for _, own in _closed(network, corners):
        place = network.position[corners[own]]
        a, b, c = (place - place[0, 0]).swapaxes(0, 1)
        side[own] = np.sign(np.einsum("tk,tk->", a, cross(b, c)))
    return side


def _closed(network: Network, corners: Indices) -> Iterator[tuple[BodyPart, NDArray[np.bool_]]]:
    """Yield the bodies whose surfaces are closed, and which of the triangles are theirs."""
    for body in network.bodies:
        inside = (corners >= body.nodes.start) & (corners < body.nodes.stop)
        own = np.asarray(inside.all(axis=1))
        if own.any() and not len(open_edges(corners[own])):
            yield body, own


def buried_in(network: Network, position: Floats, point: Floats) -> str:
    """Return the name of a body with a closed surface around a point, empty if there is none.

    Args:
        point: The point [m], shape (3,).
    """
    from tissuec.geometry.inside import winding_numbers

    corners = network.skin.astype(np.int64)
    for body, own in _closed(network, corners):
        # Whichever way the surface faces.
        if abs(winding_numbers(point[None], position, corners[own])[0]) > 0.5:
            return body.name
    return ""
