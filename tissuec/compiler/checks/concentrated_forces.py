"""Check of forces on points and edges of solids of elements, whose dents depend on the mesh.

The displacement under a force on a point or an edge of an elastic solid is infinite (J. V.
Boussinesq 1885, A. Flamant 1892). In a mesh, a force F on a node dents it by about

    9/8 F / Σ E h/n

over the elements around it, of Young's modulus E, the size h and n nodes: within 40 % at
corners, edges and faces of blocks of hexahedra, measured at Poisson's ratios of 0.3 to 0.49.
"""

from collections.abc import Iterator

import numpy as np

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.arrays import norm
from tissuec.core.errors import Diagnostic
from tissuec.core.units import FORCE, LENGTH, show
from tissuec.model.network import Floats, Network
from tissuec.script.verbs.push import Push

DEEP = 0.1  # of the size of elements: dents that are reported
DENT = 9.0 / 8.0


@check
def concentrated(compiled: Compiled) -> Iterator[Diagnostic]:
    """W418: forces on points and edges that dent a solid by a tenth of an element or more."""
    network = compiled.network
    pushes = [e.action for e in compiled.plan.every_event if isinstance(e.action, Push)]
    if not (pushes and network.of_kind("elements")):
        return
    stiffness, size = resistance(network)
    for push in pushes:
        nodes = push.group.indices
        if not len(nodes) or not stiffness[nodes].all() or _is_spread(network, push):
            continue
        whole = float(norm(push.force))
        each = whole if push.each_node else whole / len(nodes)
        depth, edge = each / float(stiffness[nodes].min()), float(size[nodes].max())
        if depth <= DEEP * edge:
            continue
        where = "a single node" if len(nodes) == 1 else f"{len(nodes)} nodes without a face"
        yield Diagnostic(
            "W418",
            f"{show(whole, FORCE)} on {push.group.name}, {where}, would dent elements of "
            f"{show(edge, LENGTH, digits=2)} by about {show(depth, LENGTH, digits=2)}, and "
            "smaller ones more",
            push.span,
            "push the nodes of a face, over whose area a force is spread, or let a tool press",
        )


def resistance(network: Network) -> tuple[Floats, Floats]:
    """Return forces over dents of nodes [N/m], and the sizes of elements there [m].

    Both have the shape (node,), and are zero without solid elements.
    """
    stiffness, size = np.zeros((2, network.node_count))
    for field in network.of_kind("elements"):
        count = field.nodes.shape[1]
        each = field.young * field.sizes / (DENT * count)
        stiffness += np.bincount(field.nodes.ravel(), np.repeat(each, count), len(stiffness))
        np.maximum.at(size, field.nodes, field.sizes[:, None])
    return stiffness, size


def _is_spread(network: Network, push: Push) -> bool:
    """Return whether a force acts on faces or whole elements."""
    from tissuec.forces.acting.traction import area_shares  # where there are elements

    if area_shares(network, push.group.indices) is not None:
        return True
    chosen = np.zeros(network.node_count, dtype=bool)
    chosen[push.group.indices] = True
    return any(chosen[field.nodes].all(axis=1).any() for field in network.of_kind("elements"))
