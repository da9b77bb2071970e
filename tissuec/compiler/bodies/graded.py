"""Quantities that depend on the place: their numbers at elements, springs and nodes.

A formula holds at the centre of mass of an element of even density, at the middle of a spring,
and at a node. Each of these has one number, so that sums over a body, such as its mass or its
stiffness, converge with the second power of the size of its cells.
"""

from collections.abc import Iterator

import numpy as np

from tissuec.compiler.selections import PointScope
from tissuec.core.fields import Real
from tissuec.core.units import show
from tissuec.meshes.generators import Mesh
from tissuec.model.network import Floats
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.reading.expressions import Scope


def element_centres(mesh: Mesh) -> Floats:
    """Return the centre of mass of each element of a mesh [m], shape (element, 3)."""
    from tissuec.geometry.elements import SHAPES  # where there are elements
    from tissuec.meshes.elements import TRIANGLE, node_shares

    found: list[Floats] = []
    for one in mesh.elements:
        corners = mesh.position[one.nodes]
        if one.shape == TRIANGLE:
            found.append(corners.mean(axis=1))
            continue
        share = node_shares(SHAPES[one.shape], corners)
        found.append(np.einsum("ea,eax->ex", share, corners) / share.sum(axis=1)[:, None])
    return np.concatenate(found)


def spring_middles(mesh: Mesh) -> Floats:
    """Return the middle of each spring as drawn [m], shape (spring, 3)."""
    return mesh.position[mesh.ends].mean(axis=1)


def numbers_at(given: AssignedQuantity, places: Floats, scope: Scope, owner: str) -> Floats:
    """Return a graded quantity at some places in its SI unit, shape (place,).

    Args:
        given: With a formula.
        places: [m], shape (place, 3).
        owner: The body or region in messages.

    Raises:
        Rejected: The formula has another dimension, or a value beyond the limits of the
            quantity; the message names the place.
    """
    assert given.formula is not None
    name, node, limits = given.quantity.name, given.formula, given.quantity.limits
    points = PointScope(scope, places)
    value = points.number(node)
    points.expect(value, limits.dimension, node.span, what=name)
    amount = np.broadcast_to(value.amount, (len(places),)).astype(float)
    for flaw, words, limit in _flaws(limits, amount):
        if not flaw.any():
            continue
        worst = int(np.argmax(np.where(flaw, np.abs(amount - limit), -1.0)))
        where = ", ".join(f"{1000.0 * float(part):.4g}" for part in places[worst])
        allowed = f"{words} {show(limit, limits.dimension, digits=4)}"
        points.findings.reject(
            "TIS308",
            f"the {name} of {owner} must be {allowed}, but at ({where}) mm it is "
            f"{given.quantity.show(float(amount[worst]), digits=4)}",
            node.span,
            hint="change the formula, such as "
            f"{'min' if words == 'at most' else 'max'}({node.span.one_line}, …)",
        )
    return amount


def _flaws(limits: Real, amount: Floats) -> Iterator[tuple[np.ndarray, str, float]]:
    """Yield which numbers are beyond a limit, the limit in words and as a number."""
    if limits.above is not None:
        yield amount <= limits.above, "above", limits.above
    if limits.at_least is not None:
        yield amount < limits.at_least, "at least", limits.at_least
    if limits.at_most is not None:
        yield amount > limits.at_most, "at most", limits.at_most
