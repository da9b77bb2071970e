"""Scenes in which something touches, as text; running them; what came out as arrays."""

import numpy as np
from msgspec import Struct

from tests.validate.scenes import compiled_scene
from tissuec.compiled.calls import kernel_on
from tissuec.compiler.compile import Compiled
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import Outcome, run
from tissuec.forces.contact.contact import Contact
from tissuec.forces.contact.sides import Meetings
from tissuec.geometry.edge_supports import SupportedEdges
from tissuec.geometry.inclusion import shared_elements
from tissuec.geometry.nearest import CAPSULE, PLANE, TRIANGLE


class Played(Struct):
    """A run that was kept in memory."""

    compiled: Compiled
    outcome: Outcome
    recording: MemoryRecording

    @property
    def time(self):
        """Return the times of the frames [s], shape (frame,)."""
        return self.recording.frame_arrays()[0]

    @property
    def position(self):
        """Return positions [m], shape (frame, node, 3); tools stand behind the bodies."""
        return self.recording.frame_arrays()[1]

    @property
    def velocity(self):
        """Return velocities [m/s], shape (frame, node, 3)."""
        return self.recording.frame_arrays()[2]

    def log(self, name):
        """Return times [s] and rows of a log."""
        return self.recording.log_arrays(name)

    def energies(self):
        """Return times [s], and the columns of the energies by name [J]."""
        time, rows = self.recording.energy_arrays()
        names = ("kinetic", "elastic", "gravity", "work", "dissipated", "switched")
        return time, dict(zip(names, rows.T, strict=True))


def play(text):
    """Run a scene to its end."""
    compiled = compiled_scene(text)
    recording = MemoryRecording()
    recorder = Recorder(compiled.network, compiled.plan, recording)
    outcome = run(compiled.network, compiled.plan, recorder)
    return Played(compiled, outcome, recording)


def bodies(played):
    """Return which nodes belong to bodies and not to tools."""
    return slice(0, played.compiled.network.body_nodes)


def gap_of_balance(played):
    """Return the largest gap in the energy balance, as a part of the energy that was moved."""
    _, e = played.energies()
    stored = e["kinetic"] + e["elastic"] + e["gravity"]
    gap = stored - stored[0] - (e["work"] - e["dissipated"] + e["switched"])
    moved = np.abs(e["work"]).max() + e["kinetic"].max() + np.abs(e["dissipated"]).max()
    return np.abs(gap).max() / moved


def ball(*, height="10 mm", velocity="(0, 0, 0) m/s", mass="1 g", extra=""):
    """Return the text of one mass point, to be followed by what it meets."""
    return f"""language 1
tissue lead {{ spring constant = 1 N/m; viscosity = 0 N*s/m; mass = {mass} }}
body ball {{ mesh is explicit; tissue is lead; velocity = {velocity} }}
table nodes of ball with columns "id x in mm y in mm z in mm" {{ 1 0 0 {height.split()[0]} }}
{extra}"""


#: Meshes of elements with edges and corners: a block, and a tube that lies along y.
BLOCK = "lattice { cell = 8 mm; box from (0, 0, 0) mm to (32, 16, 16) mm }"
TUBE = """thick tube { axis from (16, -8, 8) mm to (16, 24, 8) mm; inner radius = 4 mm
  outer radius = 8 mm; rings = 5; sides = 12; layers = 1 }"""

#: Tools of every shape, which reach into the cube of 20 mm around (10, 10, 10) mm.
MEETING = {
    "ball": "kind is probe; radius = 5 mm; centre = (4, 5, 6) mm",
    "rod": "kind is probe; radius = 4 mm; axis from (14, 2, 3) mm to (18, 16, 12) mm",
    "hook": "kind is hook; radius = 3 mm; shaft from (3, 25, 18) mm to (6, 14, 16) mm"
    "; bend = (12, 12, 17) mm; tip = (13, 9, 14) mm",
    "jaws": "kind is forceps; radius = 2 mm; upper from (0, 14, 12) mm to (12, 13, 11) mm"
    "; lower from (0, 14, 7) mm to (12, 13, 5) mm",
    "plate": "kind is plane; point = (0, 0, 2) mm; normal = (0.2, -0.1, 1)",
}


def meeting(count, *, tools=MEETING, friction="0", damping="0 s/m"):
    """Return the text of a cloud of points in a cube that every shape of tool reaches into."""
    places = np.random.default_rng(7).uniform(0.0, 20.0, (count, 3)).round(3)
    rows = "; ".join(f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(places, 1))
    drawn = "\n".join(f"tool {name} {{ {entries} }}" for name, entries in tools.items())
    return f"""language 1
tissue dust {{ spring constant = 1 N/m; viscosity = 0 N*s/m; mass = 1 g }}
body cloud {{ mesh is explicit; tissue is dust }}
table nodes of cloud in mm with columns "id x y z" {{ {rows} }}
{drawn}
environment {{
  gravity = (0, 0, 0) m/s^2; contact is tools only; friction = {friction}
  contact stiffness = 500 N/m; contact layer = 0.5 mm; contact damping = {damping}
}}
simulate {{ duration = 10 ms }}
"""


def contact_of(compiled):
    """Return the contact of a scene that has one."""
    assert compiled.network.contact is not None
    return compiled.network.contact


def by_loops(contact, position, velocity):
    """Return forces, power lost and ``Touches`` as the loops of the engine leave them."""
    own = replace(contact, stride=0.1)
    table = own.table(np.arange(len(velocity)), None, position)
    places, forces, power = in_rows(position, velocity), np.zeros(velocity.size), np.zeros(2)
    own.kernel(0.0, places.ravel(), velocity.ravel(), forces, power, table)
    return forces.reshape(-1, 3)[: len(position)], power[1], table.touches


def in_rows(position, velocity):
    """Return positions of nodes, and 0 for the internal variables behind velocities."""
    return np.concatenate([position, np.zeros((len(velocity) - len(position), 3))])


def evaluated(field, tables, position, velocity):
    """Return forces [N], shape (node, 3), and powers [W] of the loops of some tables."""
    forces, power = np.zeros_like(velocity), np.zeros(2)
    places = in_rows(position, velocity)
    for table in tables:
        own, call = np.zeros(2), kernel_on(field.kernel, table)
        call(0.0, places.ravel(), velocity.ravel(), forces.reshape(-1), own)
        power += own
    return forces[: len(position)], power


def contact_with(
    kind, points, nodes, *, friction=0.0, radius=0.1, damping=0.1, stiffness=50.0, rough=None,
    surface=None,
):  # fmt: skip
    """Return a contact of the first ``nodes`` nodes with faces of one surface.

    Args:
        kind: Of all faces.
        points: Their nodes, shape (face, 3); bristles stand behind them.
        friction: Of all nodes, or, with ``rough``, of each.
        stiffness: Of all nodes, or of each [N/m].
        rough: Friction of the nodes of faces, by their numbers, shape (node,).
        surface: Of each face; one of all if None.
    """
    count = len(points)
    surface = np.zeros(count, dtype=np.int64) if surface is None else surface
    sides = {TRIANGLE: 3, CAPSULE: 2, PLANE: 0}[kind]
    shared = shared_elements(points, np.full(count, sides), surface)
    rings = np.stack([points, np.roll(points, -1, axis=1)], axis=-1)
    behind = int(points.max()) + 1
    shapes = np.concatenate([points, shared.points])
    return Contact(
        nodes=np.arange(nodes),
        owner=np.zeros(nodes, dtype=np.int64),
        size=np.zeros(nodes),
        kind=np.concatenate([np.full(count, kind), np.full(len(shared.points), CAPSULE)]),
        points=shapes,
        surface=np.concatenate([surface, surface[shared.face]]),
        parts=shared.parts,
        radius=np.full(count, radius),
        spared=np.full(count, -1),
        bonds=np.full((count, 2), -1),
        edges=SupportedEdges.of(rings.reshape(-1, 2), rings),
        joined=np.zeros((0, 2), dtype=np.int64),
        stiffness=np.full(nodes, stiffness),
        layer=0.05,
        damping=damping,
        friction=friction if rough is None else None,
        node_friction=np.full(nodes, friction),
        face_friction=np.zeros((0, 3)) if rough is None else rough[shapes],
        stride=0.1,
        memory=np.arange(behind, behind + nodes if np.any(friction) else behind),
        rate=100.0,
        meetings=Meetings.of_all(nodes, count),
        whole=np.ones(count, dtype=bool),
        there=np.ones(nodes, dtype=bool),
        span=Span(Source("s.tis", "language 1"), 0, 1),
    )
