"""What tests of cuts share: scenes, states, plane cuts, and what cuts keep."""

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh

from tests.geometry.cut_bodies import areas
from tests.hand_net import Diary
from tests.validate.scenes import compiled_scene
from tissuec.mechanics.cutting import carry_out, divided

GEL = """language 1
tissue gel {
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 1 ms
}
"""
SHEET = (
    "sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm\n"
    "  columns = 9; rows = 5 }"
)
TUBE = "tube { axis from (0, 5, 5) mm to (20, 5, 5) mm; radius = 5 mm; rings = 8; sides = 10 }"
#: A cut that a run never comes to, for the reserve of cuts that a test makes by itself.
UNUSED = "at 0.9 s: cut block along plane through (1, 0, 0) m facing (1, 0, 0)\n"
#: A plane of symmetry along two arms of 4 mm that are pulled apart; see ``peel_of_arms``.
ALONG_ARMS = """environment {
  gravity = (0, 0, 0) m/s^2; mass damping = 2.5 Hz
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}
"""
PULLED = """  from 0 s to 1 s: move top by (0, 0, 16) mm using constant speed
}
simulate { duration = 1 s; tolerance = 1e-4 }
output { force of top every 5 ms; energy every 5 ms }
"""
END = "simulate { duration = 1 s }\n"


def state_of(text):
    compiled = compiled_scene(text)
    return compiled.plan.start(compiled.network)


def begun(text):
    """Return a state after the events of 0 s."""
    compiled = compiled_scene(text)
    state, queue = compiled.plan.start(compiled.network), Diary()
    for event in compiled.plan.events:
        if event.time == 0.0:
            event.action.apply(state, queue)
    assert not queue.added
    return state


def cut(state, through, facing, body="block"):
    """Cut through a plane, given in millimetres; return the division."""
    normal = np.array(facing, float) / np.linalg.norm(facing)
    heights = (state.position - 1e-3 * np.array(through, float)) @ normal
    division = divided(state, body, heights, f"{through} {facing}")
    if division is not None:
        carry_out(state, division)
    return division


def ahead_of(state, through, facing):
    """Return which nodes belong to parts in front of a plane, shape (node,)."""
    found = np.zeros(len(state.position), dtype=bool)
    for parts in state.cut_bodies["block"].parts:
        middle = state.network.position[parts.drawn].mean(axis=1) - 1e-3 * np.array(through)
        side = np.where(parts.are_whole, middle @ np.array(facing, float), parts.sides[:, -1])
        found[parts.nodes[side > 0.0]] = True
    return found


def momentum(state):
    """Return the momentum, the angular momentum and the kinetic energy, shape (7,)."""
    velocity = state.velocity[: len(state.position)]
    impulse = state.inertia[:, None] * velocity
    turning = np.cross(state.position, impulse)
    energy = 0.5 * (state.inertia * (velocity**2).sum(axis=1)).sum()
    return np.concatenate([impulse.sum(axis=0), turning.sum(axis=0), [energy]])


def volume(state):
    """Return the volume of solids and walls as drawn [m³]."""
    return sum(each.intact(state.alive).volume.sum() for each in state.elements)


def tied_area(state, body):
    """Return the area of the sections of a body that are tied, as drawn [m²]."""
    if (tied := state.tied.get(body)) is None:
        return 0.0
    return tied.areas(state.network, body, state.cut_bodies[body]).sum()


def peel_of_arms(played):
    """Return the mean of √G over some elements that open, from the force of two arms.

    Double cantilevers of the width w: G = P² a²/(w² E I), the opening is 2 P a³/(3 w E I). The
    length a follows from the opening, since the ends of the beams turn.
    """
    stiff, width = 100e3 * 4e-3**3 / 12.0, 4e-3
    time, force = played.log("force of top")
    opening, pull = 16e-3 * time[time > 0.65], force[time > 0.65, 2] / width
    length = np.cbrt(1.5 * stiff * opening / pull)
    return (pull * length).mean() / np.sqrt(stiff)


def cut_faces(state):
    """Return the corners of both sides of cuts as drawn [m], shape (triangle, 3, 3)."""
    cells = state.cut_cells
    own = state.alive[cells.borders] & (cells.cuts != 0)
    return cells.points.beside(state.network.position)[cells.triangles[own]]


def sections(state):
    """Return middles [m], areas [m²], and normals of all triangles of cut faces as drawn."""
    faces = cut_faces(state)
    normal = areas(faces)
    size = np.linalg.norm(normal, axis=1)
    return faces.mean(axis=1), size, normal / size[:, None]


def fastest(state):
    """Return the largest eigenvalue of the net as drawn [1/s²]."""
    place, free = state.network.position, np.flatnonzero(state.free)
    number = np.full(len(place), -1)
    number[free] = np.arange(len(free))
    fields = [each for each in state.fields if hasattr(each, "element_matrices")]
    stiff = sum(each.matrix(0.0, place, number, len(free)) for each in fields)
    root = diags_array(np.repeat(state.inertia[free], 3) ** -0.5)
    scaled, start = root @ stiff @ root, np.random.default_rng(1).normal(size=stiff.shape[0])
    return eigsh(scaled, 1, which="LA", v0=start, return_eigenvectors=False)[0]
