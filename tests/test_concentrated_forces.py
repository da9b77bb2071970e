"""Forces on points and edges: how far they dent a block, and which are reported."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from tests.validate.scenes import compiled_scene
from tissuec.compiler.checks import check_all
from tissuec.compiler.checks.concentrated_forces import resistance

SCENE = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = {ratio}; density = 1000 kg/m^3 }}
body block {{
  mesh is lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to (20, 20, 20) mm }}
  tissue is gel
  {made}
}}
set base = nodes of block where z == 0 mm
set pushed = nodes of block where {where}
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix base; at 0 s: push pushed with (0, 0, {force}) mN {how} }}
simulate {{ duration = 1 ms }}
"""
PLACES = {"corner": (20, 20, 20), "edge": (20, 10, 20), "face": (10, 10, 20)}


def scene(where, *, force=-1, cell=5, ratio=0.3, made="", how=""):
    return compiled_scene(
        SCENE.format(where=where, force=force, cell=cell, ratio=ratio, made=made, how=how)
    )


def at(place):
    return " and ".join(f"{axis} == {x} mm" for axis, x in zip("xyz", place, strict=True))


@pytest.mark.parametrize("ratio", [0.3, 0.49])
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("cell", [5, 2.5])
def test_dents_are_those_of_statics(cell, place, ratio):
    network = scene(at(PLACES[place]), cell=cell, ratio=ratio).network
    (elements,), count = network.elements, network.node_count
    stiff = elements.matrix(0.0, network.position, np.arange(count), count).tocsc()
    free = np.flatnonzero(np.repeat(network.position[:, 2] > 1e-9, 3))
    (node,) = np.flatnonzero(
        np.linalg.norm(network.position - np.array(PLACES[place]) / 1e3, axis=1) < 1e-9
    )
    load = np.zeros(3 * count)
    load[3 * node + 2] = 1.0
    moved = np.zeros(3 * count)
    moved[free] = spsolve(stiff[free][:, free], load[free])
    found, size = resistance(network)
    assert size[node] == pytest.approx(cell / 1e3, rel=1e-12)
    assert 1.0 / found[node] == pytest.approx(moved[3 * node + 2], rel=0.4)


def reported(*asked, **more):
    found = check_all(scene(*asked, **more), thorough=False)
    return [each.message for each in found if each.code == "W418"]


def test_points_and_edges_are_reported_with_numbers():
    # 9 F/E h at a corner.
    (message,) = reported(at(PLACES["corner"]), force=-20)
    assert message == (
        "20 mN on pushed, a single node, would dent elements of 5 mm by about 3.6 mm, and "
        "smaller ones more"
    )
    assert reported("x == 20 mm and z == 20 mm", force=-20)
    assert reported(at(PLACES["corner"]), force=-20, made="made of quadratic elements")


@pytest.mark.parametrize(
    ("where", "more"),
    [
        (at(PLACES["corner"]), {"force": -2}),
        ("z == 20 mm", {"force": -400}),
        ("z == 20 mm", {"force": -400, "how": "in equal parts"}),
        ("z == 20 mm and x > 14 mm and y > 14 mm", {"force": -100}),
        ("z > 14 mm", {"force": -400}),
    ],
)
def test_what_is_small_or_spread_is_not_reported(where, more):
    assert not reported(where, **more)
