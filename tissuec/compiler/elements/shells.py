"""Walls of matter that resist bending by their thickness: their hinges in numbers."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.core.hints import leaving_out
from tissuec.forces.surfaces.bending import Hinges, hinges_at
from tissuec.model.network import Floats
from tissuec.model.topology import PairIndex
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.reading.findings import Findings

if TYPE_CHECKING:
    from tissuec.compiler.materials.matter import Matter

#: Pairs of nodes of a hinge that springs may join: all but its two tips.
_SIDES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3]])


def hinges_of(
    drawing: Drawing,
    matter: "Matter | None",
    moduli: Sequence[AssignedQuantity | None],
    modulus_at_nodes: Callable[[], Floats],
    stiffness: Floats,
    damping: Floats,
    findings: Findings,
) -> Hinges:
    """Return the hinges of a body that resists bending; missing numbers are rejected.

    Their modulus is the mean of those of their nodes. They are damped as the springs around
    them.

    Args:
        drawing: The body as drawn.
        matter: How its stiffness is distributed; None where its springs are specified one by
            one.
        moduli: What gives the spring constants of each part of the body.
        modulus_at_nodes: Returns Young's modulus [Pa], shape (node,).
        stiffness, damping: Of the springs [N/m], [N s/m], shape (spring,).
    """
    body = drawing.body
    assert body.shell is not None
    used: list[int] = np.unique(drawing.part).tolist()
    given = [moduli[part] for part in used]
    if matter is None or any(m is None or not m.quantity.is_of_matter for m in given):
        findings.reject(
            "TIS304",
            f"elastic bending of {body.name} needs a Young's modulus",
            body.shell,
            hint="write a Young's modulus in its tissue and a thickness in the body, "
            "or bending = 20 %",
        )
    if matter.hinges is None:
        findings.reject(
            "TIS306",
            f"body {body.name} cannot have elastic bending because it is not a wall",
            body.shell,
            hint=leaving_out("remove it: a solid resists bending anyway", body.shell)
            if matter.is_solid
            else "use a sheet, a tube, a sphere or an imported surface",
        )
    nodes, position = matter.hinges.nodes, drawing.mesh.position
    modulus = modulus_at_nodes()
    rigidity = matter.hinges.constant * modulus[nodes].mean(axis=1)
    ends, count = drawing.mesh.ends, len(position)
    acts = stiffness > 0.0
    delay = np.divide(damping, stiffness, where=acts, out=np.zeros_like(damping))
    at, each = ends[acts].ravel(), np.repeat(delay[acts], 2)
    delay = np.bincount(at, each, count) / np.maximum(np.bincount(at, minlength=count), 1)
    walls, which = PairIndex(ends).between(nodes[:, _SIDES].reshape(-1, 2))
    slowness = delay[nodes].mean(axis=1)
    owners = which // len(_SIDES)
    return hinges_at(position, nodes, rigidity, rigidity * slowness, walls, owners)
