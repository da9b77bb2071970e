"""Whether subjects have what a measure needs; see ``script.measures.needs``."""

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.model.network import Floats
from tissuec.script.measures.needs import NEEDS, Kind

_FLAT = 1e-9  # of its size: the depth of a surface that encloses nothing


def kind_of(drawing: Drawing) -> Kind:
    """Return whether a body is a solid, a wall, a thread or a net."""
    mesh = drawing.mesh
    if mesh.elements:
        return "wall" if drawing.body.is_wall else "solid"
    return "thread" if drawing.is_bars else "net"


def has_by_kind(need: str, drawing: Drawing) -> bool:
    """Return whether a body has by its kind what a measure needs, a name of ``NEEDS``."""
    if kind_of(drawing) not in NEEDS[need].kinds:
        return False
    mesh = drawing.mesh
    if need == "inside" and mesh.volume is None and not mesh.elements:
        return _is_deep(mesh.position[np.unique(mesh.skin)])
    if need == "inside" and drawing.body.is_wall:
        return _is_deep(mesh.position)
    return True


def _is_deep(position: Floats) -> bool:
    """Return whether points lie in no plane [m], shape (point, 3)."""
    if len(position) < 4:
        return False
    sizes = np.linalg.svd(position - position.mean(axis=0), compute_uv=False)
    return bool(sizes[2] > _FLAT * sizes[0])
