"""Instruments in the places and with the settings of a moment."""

import numpy as np

from tissuec.results.instruments.meshes import mesh_of
from tissuec.view.player.bodies import TriangleMesh, smooth_mesh
from tissuec.view.player.film import Instrument
from tissuec.view.player.moment import InterpolatedFrame


def posed(instrument: Instrument, moment: InterpolatedFrame) -> TriangleMesh:
    """Return an instrument as it is at a moment; see ``web/instruments.glsl``."""
    origin, *others = moment.position[list(instrument.points)]
    z, x, setting = (np.asarray(one) - origin for one in others)
    z = z / np.linalg.norm(z)
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    mesh = mesh_of(instrument.kind)
    local = mesh.posed(float(setting @ z) / instrument.size) * instrument.size
    return smooth_mesh(origin + local @ np.stack([x, np.cross(z, x), z]), mesh.triangles)
