"""Solid bodies as nets of springs and cells, for questions about their stiffness."""

from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.laws.evaluation import Behaviour
from tissuec.matter.coarseness import Coarseness, coarseness
from tissuec.matter.elasticity import Elasticity, of_solid
from tissuec.matter.solid import Solid
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

_SLIGHT = 1e-6  # strain


class SolidNet(NamedTuple):
    """Springs and cells of a solid about the state in which it is drawn.

    Attributes:
        position: Of its nodes [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
        constant: dT/dL of each spring [N/m], shape (spring,).
        cells: √(K/V) ∂V/∂x of cells that keep their volume [(N/m)^½], shape (3 node, cell).
        volume: Of each node [m³], shape (node,).
        skin: Triangles that face outwards, shape (triangle, 3).
    """

    position: Floats
    ends: NDArray[np.int32]
    constant: Floats
    cells: "csr_matrix | None"
    volume: Floats
    skin: NDArray[np.int32]

    @classmethod
    def of(cls, part: BodyPart, drawing: Drawing, state: State) -> Self:
        """Return the net of a body with a volume.

        Args:
            state: As it is drawn.
        """
        mesh, network = drawing.mesh, state.network
        assert mesh.volume is not None, "a solid has a volume"
        own, behaviour = acting_springs(part, drawing, state)
        cells = None
        if (enclosure := state.enclosures.get(part.name)) is not None:
            number = np.full(network.node_count, -1)
            size = part.nodes.stop - part.nodes.start
            number[part.nodes] = np.arange(size)
            cells = enclosure.columns(0.0, network.position, number, size)[0].tocsr()
        constant = steepness_as_drawn(behaviour, drawing.length[own])
        return cls(mesh.position, mesh.ends[own], constant, cells, mesh.volume, mesh.skin)

    def elasticity(self) -> Elasticity:
        """Return its elastic constants, which takes one linear system."""
        boundary, volume = np.unique(self.skin), float(self.volume.sum())
        return of_solid(self.position, self.ends, self.constant, self.cells, boundary, volume)

    def coarseness(self, elasticity: Elasticity) -> Coarseness:
        """Return how much too stiff it is in bending and torsion, by three linear systems."""
        solid = Solid.of(self.position, self.volume, self.skin)
        return coarseness(
            self.position, self.ends, self.constant, self.cells, solid, self.skin,
            np.array(elasticity.matrix),
        )  # fmt: skip


def acting_springs(part: BodyPart, drawing: Drawing, state: State) -> tuple[Indices, Behaviour]:
    """Return the living springs of a body that have a direction, and their behaviour.

    Args:
        state: Which springs are alive.

    Returns:
        Their numbers within the body, shape (spring,), and how they act.
    """
    own = np.flatnonzero(state.alive[part.springs] & (drawing.length > 0.0))
    return own, state.springs.some(part.springs.start + own).behaviour


def steepness_as_drawn(behaviour: Behaviour, length: Floats) -> Floats:
    """Return dT/dL of springs at their drawn length [N/m], shape (spring,).

    A little longer than drawn, so that springs count which resist tension only.

    Args:
        behaviour: Of the springs.
        length: As drawn [m], shape (spring,).
    """
    return behaviour.steepness(length * (1.0 + _SLIGHT) - behaviour.rest)
