"""Surfaces that enclose the volume of a body, by themselves or with caps."""

from tissuec.core.keeping import kept_on_owner
from tissuec.core.source import Source, Span
from tissuec.forces.enclosed.pressed_faces import PressedFaces
from tissuec.forces.enclosed.pressed_sides import (
    NoSide,
    Pressed,
    closed_by_caps,
    enclosed,
    pressed_faces,
)
from tissuec.forces.enclosed.volume import Enclosure
from tissuec.model.network import Floats, Network, numbers_in

_NOWHERE = Span(Source("", ""), 0, 0)


@kept_on_owner(16)
def _closed(network: Network, name: str) -> Enclosure | None:
    """Return the closed surface of a body, None where it is open."""
    try:
        return Enclosure.of(network, name, 1.0, _NOWHERE)
    except ValueError:
        return None


@kept_on_owner(16)
def capped(network: Network, name: str) -> PressedFaces | None:
    """Return the faces of a wall that caps or planes of symmetry can close, else None."""
    part = next((body for body in network.bodies if body.name == name), None)
    if part is None:
        return None
    try:
        faces = pressed_faces(network, Pressed(name, numbers_in(part.nodes)))
        if faces.rims.count or not faces.planes:
            closed_by_caps(network, name, faces)
    except NoSide:
        return None
    return faces


def enclosed_volume(network: Network, name: str, position: Floats) -> Floats | float:
    """Return the volume in the surface of a body [m³], shape (…); 0 where none closes it.

    Args:
        name: Of the body.
        position: Of all nodes [m], shape (…, node, 3).
    """
    closed = _closed(network, name)
    if closed is not None:
        return closed.volumes(position).sum(axis=-1)
    faces = capped(network, name)
    if faces is None:
        return 0.0
    return enclosed(position, faces.triples, faces.rims, crossing=faces.crossing)
