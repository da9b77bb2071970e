"""What blocks show of a scene that its result does not contain."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.forces.enclosed.volume import Enclosure
from tissuec.mechanics.deformation import six
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

    from tissuec.forces.solids.elements import SolidElements
    from tissuec.forces.surfaces.membranes import Membranes


class CellPressure(Struct, frozen=True, eq=False):
    """Cells of a solid that keep their volume.

    Attributes:
        enclosure: The cells.
        cells: Nodes of the network and the cells around them, shape (pair, 2).
    """

    enclosure: Enclosure
    cells: Indices

    def at_nodes(self, position: Floats, torn: Indices, nodes: slice) -> Floats:
        """Return the mean pressure of the cells around each node [Pa], shape (node,).

        Args:
            position: Of all nodes of the network [m], shape (node, 3).
            torn: Cells that have lost a spring, and have no pressure.
            nodes: Those of the body.
        """
        pressure = self.enclosure.pressures(0.0, position)
        pressure[torn] = 0.0
        node, cell = self.cells.T
        total = np.bincount(node, pressure[cell], nodes.stop)
        count = np.bincount(node, minlength=nodes.stop)
        return (total / np.maximum(count, 1))[nodes]


class BodyMatter(Struct, frozen=True, eq=False):
    """How the matter of a body is spread.

    Attributes:
        volume: Drawn volume of the share of each node [m³], shape (node,); positive.
        dimension: 3 of a solid, 2 of a wall, 1 of bars and threads.
        lines: Springs that bear its stress, or edges of its elements, as numbers in the
            network, ascending.
        pressure: Of cells that keep their volume; None without any.
        near: By what the nodes near a node count for its stress, shape (node, node); None where
            it counts alone.
        elements: That bear its stress instead of springs.
    """

    volume: Floats
    dimension: int
    lines: Indices
    pressure: CellPressure | None = None
    near: "csr_matrix | None" = None
    elements: "tuple[SolidElements | Membranes, ...]" = ()

    def stress_of_elements(
        self, position: Floats, alive: NDArray[np.bool_], nodes: slice
    ) -> Floats:
        """Return the mean Cauchy stress of the elements around each node [Pa], shape (node, 6).

        It is zero where no element is left.

        Args:
            position: Of all nodes of the network [m], shape (node, 3).
            alive: False for entities that are lost, shape (entity,).
            nodes: Those of the body.
        """
        parts = [each.intact(alive).node_stress(position) for each in self.elements]
        total, volume = (sum(part[nodes] for part in each) for each in zip(*parts, strict=True))
        return six(total / np.where(volume > 0.0, volume, 1.0)[:, None, None])

    def of_elements(
        self, position: Floats, drawn: Floats, alive: NDArray[np.bool_]
    ) -> tuple[Floats, Floats]:
        """Return mean strains, without a unit, and Cauchy stresses of elements [Pa].

        Args:
            position: Of all nodes of the network [m], shape (node, 3).
            drawn: The same before the run.
            alive: False for entities that are lost, shape (entity,).

        Returns:
            Of the elements that are left, shape (element, 6) each.
        """
        from tissuec.forces.solids.elements import SolidElements  # where stress is computed

        none = np.zeros((0, 6))
        every = (each for each in self.elements if isinstance(each, SolidElements))
        intact = [each.intact(alive) for each in every]
        strain = [
            six(each.shape.mean_strain(position[each.nodes], drawn[each.nodes]))
            for each in intact
        ]
        stress = [six(each.mean_stress(position)) for each in intact]
        return np.concatenate([none, *strain]), np.concatenate([none, *stress])


class Anatomy(Struct, frozen=True, eq=False):
    """Tissues, matter and tools of a scene.

    Attributes:
        tissues: Their names.
        tissue: Of each node of bodies, as a number among ``tissues``, shape (node,).
        matter: Of the bodies that have strain and stress, by name.
        tools: Kinds of all tools by name, also of those without a shape.
        notes: Sentences that say what is left out, and why.
    """

    tissues: tuple[str, ...]
    tissue: Indices
    matter: Mapping[str, BodyMatter]
    tools: Mapping[str, str]
    notes: tuple[str, ...] = ()
