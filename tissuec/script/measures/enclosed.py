"""Common code of measures of volumes: the surface of a body."""

from tissuec.core.keeping import kept_on_owner
from tissuec.core.source import Source, Span
from tissuec.forces.pressed_faces import PressedFaces
from tissuec.forces.pressed_sides import NoSide, Pressed, closed_by_caps, pressed_faces
from tissuec.forces.volume import Enclosure
from tissuec.model.network import Network, numbers_in

_NOWHERE = Span(Source("", ""), 0, 0)


@kept_on_owner(16)
def surface_of(network: Network, name: str) -> Enclosure | None:
    """Return the closed surface of a body, None where it is open."""
    try:
        return Enclosure.of(network, name, 1.0, _NOWHERE)
    except ValueError:
        return None


@kept_on_owner(16)
def capped_surface_of(network: Network, name: str) -> PressedFaces | None:
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
