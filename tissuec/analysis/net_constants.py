"""Elastic constants of solids and walls that consist of springs, about their state as drawn."""

from typing import TYPE_CHECKING

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.laws.evaluation import Behaviour
from tissuec.matter.elasticity import Elasticity, of_solid
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

_SLIGHT = 1e-6  # strain


def constants_of_solid(
    part: BodyPart, drawing: Drawing, state: State, own: Indices, constant: Floats
) -> Elasticity:
    """Return the elastic constants of a net with a volume, which takes one linear system.

    Args:
        state: As it is drawn.
        own: Its springs that act, numbered within the body, shape (spring,).
        constant: dT/dL of each of them [N/m], shape (spring,).
    """
    mesh = drawing.mesh
    assert mesh.volume is not None, "a solid has a volume"
    boundary, volume = np.unique(mesh.skin), float(mesh.volume.sum())
    cells = _cells(part, state)
    return of_solid(mesh.position, mesh.ends[own], constant, cells, boundary, volume)


def _cells(part: BodyPart, state: State) -> "csr_matrix | None":
    """Return √(K/V) ∂V/∂x of cells that keep their volume [(N/m)^½], shape (3 node, cell)."""
    if (enclosure := state.enclosures.get(part.name)) is None:
        return None
    network, size = state.network, part.nodes.stop - part.nodes.start
    number = np.full(network.node_count, -1)
    number[part.nodes] = np.arange(size)
    return enclosure.columns(0.0, network.position, number, size)[0].tocsr()


def acting_springs(part: BodyPart, drawing: Drawing, state: State) -> tuple[Indices, Behaviour]:
    """Return the living springs of a body that have a direction, and their behaviour.

    Args:
        state: Which springs are alive.

    Returns:
        Their numbers within the body, shape (spring,), and how they act.
    """
    own = np.flatnonzero(state.alive[part.springs])
    own = own[drawing.length[own] > 0.0]
    return own, state.springs.some(part.springs.start + own).behaviour


def steepness_as_drawn(behaviour: Behaviour, length: Floats) -> Floats:
    """Return dT/dL of springs at their drawn length [N/m], shape (spring,).

    A little longer than drawn, so that springs count which resist tension only.

    Args:
        behaviour: Of the springs.
        length: As drawn [m], shape (spring,).
    """
    return behaviour.steepness(length * (1.0 + _SLIGHT) - behaviour.rest)
