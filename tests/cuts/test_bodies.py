"""Bodies of many kinds that are cut straight, along a curve, and twice."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.cuts.scenes import END, GEL, SHEET, fastest, momentum, volume
from tests.hand_net import Diary
from tests.validate.scenes import compiled_scene
from tissuec.model.topology import pieces

LIVER = Path(__file__).parents[2] / "library" / "meshes" / "liver.obj"
#: Mesh and further entries of each body, its middle [mm], and its size across cuts [mm].
BODIES = {
    "block": (
        "lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 10) mm }", (10, 10, 5), 20,
    ),
    "liver": (
        'imported { file "liver.obj" in mm; filling is tetrahedra; cell = 30 mm }',
        (-10, 0, 0), 180,
    ),
    "tube": (
        "thick tube { axis from (0, 0, 0) mm to (20, 0, 0) mm; inner radius = 4 mm\n"
        "  outer radius = 8 mm; rings = 5; sides = 12; layers = 1 }",
        (10, 0, 0), 20,
    ),
    "layered": (
        "lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 10) mm }\n"
        "  region hard where z > 5 mm { tissue is firm }",
        (10, 10, 5), 20,
    ),
    "sheet": (SHEET, (10, 5, 0), 20),
}  # fmt: skip
PIECES = {"straight": 2, "curved": 2, "crossing": 4}
FIRM = "tissue firm like gel { Young's modulus = 100 kPa }\n"


def along(place, points):
    """Return sentences that cut along a path in millimetres, in the xy plane, from a place."""
    found = ""
    for k, (first, last) in enumerate(pairwise(np.asarray(points, float))):
        way = last - first
        ends = [np.append(end, 0.0) + place for end in (first, last)]
        ends = ["({:.9g}, {:.9g}, {:.9g}) mm".format(*end) for end in ends]
        found += f"  at {k + 1} ms: cut block along line from {ends[0]} to {ends[1]} "
        found += f"facing ({-way[1]:.9g}, {way[0]:.9g}, 0)\n"
    return found


def orders(kind, place, size):
    """Return sentences that cut straight, along an arc of six lines, or twice."""
    place = np.add(place, (0.13, 0.17, 0.1))
    share = np.linspace(0.0, 1.0, 7)
    curve = np.stack([1.4 * share - 0.7, 0.3 * np.sin(np.pi * share) - 0.1], axis=1) * size
    straight = along(place, [(0.1 * size, -size), (-0.15 * size, size)])
    return {
        "straight": straight,
        "curved": along(place, curve),
        "crossing": straight + along(place, [(-size, 0.1 * size), (size, -0.05 * size)]),
    }[kind]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Work in a folder with the surface of the liver."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "liver.obj").write_bytes(LIVER.read_bytes())


@pytest.mark.parametrize("kind", ["straight", "curved", "crossing"])
@pytest.mark.parametrize("name", BODIES)
def test_cuts_keep_mass_volume_and_motion(name, kind, folder):
    """All are sums of as many numbers as there are nodes, to rounding."""
    mesh, place, size = BODIES[name]
    thickness = "; thickness = 1 mm" if name == "sheet" else ""
    text = GEL + FIRM * (name == "layered")
    text += f"body block {{ mesh is {mesh}; made of elements; tissue is gel{thickness} }}\n"
    text += "environment { gravity = (0, 0, 0) m/s^2 }\nscript {\n" + orders(kind, place, size)
    scene = compiled_scene(text + "}\n" + END)
    state, diary = scene.plan.start(scene.network), Diary()
    rng = np.random.default_rng(3)
    state.velocity[:] = 0.01 * rng.normal(size=state.velocity.shape)
    state.follow_hosts()
    before = state.inertia.sum(), volume(state), momentum(state)
    swift = fastest(state)
    nodes = np.count_nonzero(state.free)
    for event in scene.plan.events:
        event.action.apply(state, diary)
    assert np.count_nonzero(state.free) > nodes
    assert state.inertia.sum() == pytest.approx(before[0], rel=1e-14)
    assert volume(state) == pytest.approx(before[1], rel=1e-12)
    scale = np.abs(before[2]).max()
    assert_allclose(momentum(state), before[2], atol=1e-13 * scale, rtol=1e-12)
    assert np.sqrt(swift / fastest(state)) > 0.5
    number = pieces(state.network.node_count, state.joined_pairs)
    assert len(np.unique(number[state.joined_pairs])) == PIECES[kind]
