"""A check of bodies that are drawn inside of others."""

from collections.abc import Iterator

import numpy as np

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic, Note
from tissuec.core.names import key_of
from tissuec.model.network import BodyPart, Network


@check
def buried_bodies(compiled: Compiled) -> Iterator[Diagnostic]:
    """W416: a body inside of a solid that nothing ties to it, so that neither feels the other.

    Contact acts from outside of solids, and does not push out what is drawn inside.
    """
    network = compiled.network
    solids = [body for body in network.bodies if body.is_solid]
    for outer in solids:
        for inner in network.bodies:
            if inner is outer or inner.thread is not None or network.are_joined(inner, outer):
                continue
            if _is_inside(network, inner, outer):
                region = _region(compiled, inner)
                yield Diagnostic(
                    "W416",
                    f"{inner.name} is drawn inside of {outer.name}, and neither acts on the "
                    "other",
                    inner.span,
                    f"write in {outer.name}: {region}; or join both by a joint",
                    (Note("the body around it", outer.span),),
                )


def _region(compiled: Compiled, inner: BodyPart) -> str:
    """Return the text of a region about as large as a body."""
    place = compiled.network.position[inner.nodes]
    low, high = 1e3 * place.min(axis=0), 1e3 * place.max(axis=0)
    middle = ", ".join(f"{round(float(x), 3) + 0.0:g}" for x in 0.5 * (low + high))
    tissue = compiled.scene.bodies[key_of(inner.name)].tissues[0].name
    where = f"within {0.5 * float((high - low).max()):.3g} mm of ({middle}) mm"
    return f"region {inner.name} where {where} {{ tissue is {tissue} }}"


def _is_inside(network: Network, inner: BodyPart, outer: BodyPart) -> bool:
    """Return whether all of a body with a surface is inside of a solid."""
    points, around = network.position[inner.nodes], network.position[outer.nodes]
    if not len(network.skin_of(inner)):
        return False
    if (points <= around.min(axis=0)).any() or (points >= around.max(axis=0)).any():
        return False
    from tissuec.geometry.inside import winding_numbers

    skin = network.skin_of(outer).astype(np.int64)
    # The first point is outside of most bodies that are not around the others.
    return all(
        bool((np.abs(winding_numbers(some, network.position, skin)) > 0.5).all())
        for some in (points[:1], points)
    )
