"""Plates: walls of triangles that resist bending at any Poisson's ratio.

The folds of a triangle at its edges say how it is curved (``matter.plate``). With the folds
θ_i - θ0_i = Δ_i and the weights w_i of hinges (``surfaces.bending``), a triangle stores

    E = Σ_i K_ii w_i (1 - cos Δ_i) + Σ_i<j K_ij z_i z_j,    z_i = p_i sin Δ_i,
    p_i = w_i (3 - w_i)/2,

which is Δᵀ K Δ/2 for small folds. It has no jump where faces are folded onto each other, lets
go of triangles that collapse, and is never negative, as K is positive, p² ≤ w, and
sin² Δ ≤ 2 (1 - cos Δ). A triangle with the retardation time τ has the potential of dissipation

    D = τ Σ_ij C_ij dθ_i/dt dθ_j/dt/2,
    C_ii = K_ii w_i,    C_ij = K_ij p_i p_j cos Δ_i cos Δ_j.
"""

from collections.abc import Sequence
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.autodiff import Angle, Numbers, Potential, Vector
from tissuec.core.source import Span
from tissuec.forces.fields import Items
from tissuec.forces.potential_fields import PotentialField
from tissuec.forces.surfaces.bending import Fold, as_drawn
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices
from tissuec.model.topology import PairIndex

#: Places in a patch of the nodes of the hinge opposite to each corner.
HINGES = ((1, 2, 0, 3), (2, 0, 1, 4), (0, 1, 2, 5))
#: Pairs of places in a patch that springs join: all edges of its triangles.
EDGES = np.array([[0, 1], [1, 2], [2, 0], [1, 3], [2, 3], [2, 4], [0, 4], [0, 5], [1, 5]])


def _plate(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
    """Return the potential of a triangle."""
    energy = loss = x[0][0].graph.number(0.0)
    folds = [Fold.of([x[k] for k in hinge]) for hinge in HINGES]
    speeds = [
        fold.speed([v[k] for k in hinge]) for fold, hinge in zip(folds, HINGES, strict=True)
    ]
    more = [fold.angle.less(Angle.written(p.drawn[i])) for i, fold in enumerate(folds)]
    weights = [
        p.hinged[i] * fold.weight(p.squares[2 * i : 2 * i + 2]) for i, fold in enumerate(folds)
    ]
    shares = [0.5 * weight * (3.0 - weight) for weight in weights]
    for i in range(3):
        own = p.stiffness[4 * i] * weights[i]
        energy = energy + own * more[i].versine
        loss = loss + 0.5 * own * speeds[i] ** 2
        for j in range(i):
            both = p.stiffness[3 * i + j] * shares[i] * shares[j]
            energy = energy + both * more[i].sine * more[j].sine
            loss = loss + both * more[i].cosine * more[j].cosine * speeds[i] * speeds[j]
    return Potential(energy, p.delay * loss)


class Plates(PotentialField, frozen=True):
    """Triangles of a wall that resist bending.

    One loses its stiffness if its patch loses an edge or a triangle.

    Attributes:
        nodes: Patches, see ``matter.plate``, shape (triangle, 6).
        name: Of the body.
        stiffness: K [N m], shape (triangle, 3, 3).
        delay: τ [s], shape (triangle,).
        drawn: θ0 [rad], shape (triangle, 3).
        squares: Of drawn normals of the triangle and its neighbours [m⁴], shape
            (triangle, 3, 2).
        span: The entry that asks for it.
    """

    at_once: ClassVar[int] = 1024
    item_potential = staticmethod(_plate)
    learnt = ("stiffness", "delay")
    columns = (*learnt, "drawn", "squares", "hinged")

    name: str
    stiffness: Floats
    delay: Floats
    drawn: Floats
    squares: Floats
    span: Span

    @classmethod
    def of(
        cls,
        name: str,
        nodes: Indices,
        position: Floats,
        stiffness: Floats,
        delay: Floats,
        ends: NDArray[np.int32],
        first_edge: int,
        span: Span,
        triangles: Indices | None = None,
    ) -> Self:
        """Return plates that are at rest as they are drawn.

        Args:
            name: Of the body.
            nodes: Patches, shape (triangle, 6).
            position: Of all nodes as drawn [m], shape (node, 3).
            stiffness: K [N m], shape (triangle, 3, 3).
            delay: τ [s], shape (triangle,).
            ends: Nodes of the edges of the body, shape (edge, 2).
            first_edge: Number of the first of these.
            span: The entry that asks for it.
            triangles: Those of each patch as entities of the network, shape (triangle, n); None
                where these neither break nor are divided.
        """
        own = nodes[:, np.array(HINGES)].reshape(-1, 4)
        is_hinge = (nodes[:, 3:] != nodes[:, :3]).ravel()
        drawn, squares = np.zeros(len(own)), np.ones((len(own), 2))
        drawn[is_hinge], squares[is_hinge] = as_drawn(position[own[is_hinge]])
        edges, which = PairIndex(ends).between(nodes[:, EDGES].reshape(-1, 2))
        walls, walled = first_edge + edges, which // len(EDGES)
        count = len(nodes)
        if triangles is not None:
            walls = np.append(walls, triangles)
            walled = np.append(walled, np.repeat(np.arange(count), triangles.shape[1]))
        return cls(
            walls, walled, nodes, name, stiffness, delay,
            drawn.reshape(count, 3), squares.reshape(count, 3, 2), span,
        )  # fmt: skip

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the bending of {self.name}", "plates", self, self.span)

    def items(self, place: Indices) -> Items:
        """Return the nodes of the patches, each once."""
        places = np.sort(place[self.nodes], axis=1)
        is_new = np.diff(places, axis=1, prepend=-1) > 0
        return Items(places[is_new], np.concatenate([[0], np.cumsum(is_new.sum(axis=1))]))

    @property
    def is_hinge(self) -> NDArray[np.bool_]:
        """Return which edges have a neighbour, shape (triangle, 3)."""
        return self.nodes[:, 3:] != self.nodes[:, :3]

    @property
    def hinged(self) -> Floats:
        """Return 1 for edges that have a neighbour, 0 for others [1], shape (triangle, 3)."""
        return self.is_hinge.astype(float)

    @property
    def is_damped(self) -> bool:
        """Return whether any triangle is damped."""
        return bool(self.delay.any())
