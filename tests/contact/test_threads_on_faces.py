"""Threads that are pulled over edges and corners of elements: they do not slip in between."""

import numpy as np
import pytest

from tests.contact.scenes import BLOCK, TUBE, play
from tissuec.geometry.sweeps import side_of

SCENE = """language 1
tissue gel {{ Young's modulus = 20 kPa; density = 1000 kg/m^3; retardation time = 5 ms }}
tissue silk {{ spring law is tension only; spring constant = {stiffness} N/m
  viscosity = 0.1 N*s/m; mass = 5 mg }}
body block {{ mesh is {mesh}; tissue is gel }}
body strand {{ mesh is thread {{ line from (-12, {y}, 17) mm to (44, {y}, 17) mm
  pieces = {pieces}; thickness = 0.6 mm }}; tissue is silk }}
set base = nodes of block where z < 0.1 mm
set left end = nodes of strand where x < -11.9 mm
set right end = nodes of strand where x > 43.9 mm
environment {{ gravity = (0, 0, 0) m/s^2; mass damping = 50 Hz; contact is tools only
  friction = {friction} }}
script {{
  at 0 s: {{ fix base; hold left end; hold right end }}
  from 0 s to 0.1 s: move left end by (0, 0, -6) mm using smooth profile
  from 0 s to 0.1 s: move right end by (0, {aside}, -6) mm using smooth profile
}}
simulate {{ duration = 0.12 s; tolerance = 1e-2 }}
output {{ trajectory every 10 ms; force of left end every 10 ms }}
"""


def pulled(*, pieces, y=4.0, friction=0.0, aside=0.0, mesh=BLOCK):
    text = SCENE.format(
        pieces=pieces, y=y, friction=friction, aside=aside, mesh=mesh, stiffness=20 * pieces / 7
    )
    played = play(text)
    assert played.outcome.kind == "done"
    return played


def behind(played):
    """Return how many places along the thread are behind the surface at the end."""
    network, position = played.compiled.network, played.position[-1]
    block, strand = network.bodies
    ends = position[network.springs.ends[strand.thread.pieces]]
    share = np.linspace(0.0, 1.0, 9)[:, None, None]
    places = (ends[:, 0] + share * (ends[:, 1] - ends[:, 0])).reshape(-1, 3)
    skin = network.skin_of(block)
    return sum(not side_of(place, position, skin)[0] for place in places)


@pytest.mark.parametrize("pieces", [7, 14])
def test_a_thread_lies_across_edges_wherever_its_nodes_are(pieces):
    found = pulled(pieces=pieces)
    assert not found.outcome.doubts and not behind(found)
    network, position = found.compiled.network, found.position[-1]
    block = network.bodies[0].nodes
    # It touches the upper side with its radius, and no more than that above it.
    middle = position[network.bodies[1].nodes][:, 0] - 16e-3
    height = position[network.bodies[1].nodes][np.abs(middle).argmin(), 2]
    assert 16e-3 < height < position[block, 2].max() + 1.3e-3
    # Both ends pull alike, and down.
    force = found.log("force of left end")[1][-1]
    assert 5e-3 < np.linalg.norm(force) < 9e-3 and force[2] < 0.0


def test_a_thread_is_held_on_edges_by_friction_across_a_corner():
    found = pulled(pieces=14, y=7.3, friction=0.2, aside=6.0)
    assert not found.outcome.doubts and not behind(found)


def test_a_thread_lies_on_a_tube():
    found = pulled(pieces=14, mesh=TUBE)
    assert not found.outcome.doubts and not behind(found)


CORNERS = 16e-3 * np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
SLING = """language 1
tissue gel { Young's modulus = 20 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
tissue silk { spring law is tension only; spring constant = 60 N/m
  viscosity = 0.1 N*s/m; mass = 5 mg }
body block { mesh is lattice { cell = 8 mm; box from (0, 0, 0) mm to (16, 16, 16) mm }
  tissue is gel }
body sling { mesh is thread { centre = (8, 8, 8) mm; normal = (1, 0, 0); radius = 12.6 mm
  pieces = 24; thickness = 1 mm }; tissue is silk }
set base = nodes of block where x < 0.1 mm or x > 15.9 mm
environment { gravity = (0, 0, 0) m/s^2; mass damping = 50 Hz; contact is tools only }
script {
  at 0 s: fix base
  from 0 s to 0.2 s: tighten sling to 64 mm using smooth profile
}
simulate { duration = 0.25 s; tolerance = 1e-2 }
output { trajectory every 10 ms; tension of sling every 10 ms }
"""


def test_a_sling_lies_around_four_edges_and_pulls_alike_everywhere():
    found = play(SLING)
    assert found.outcome.kind == "done" and not found.outcome.doubts and not behind(found)
    network, position = found.compiled.network, found.position[-1]
    ends = position[network.springs.ends[network.bodies[1].thread.pieces]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    # Shorter than around the block at its radius of 0.5 mm, into which it presses.
    assert 64e-3 < length < 64e-3 + 2.0 * np.pi * 0.5e-3
    tension = np.ravel(found.log("tension of sling")[1][-1])
    assert tension == pytest.approx(60.0 * (length - 64e-3) / 24.0, rel=0.05)
    # No edge is further from it than its radius.
    share = np.linspace(0.0, 1.0, 33)[:, None, None]
    places = (ends[:, 0] + share * (ends[:, 1] - ends[:, 0])).reshape(-1, 3)[:, 1:]
    edges = position[np.isclose(network.position[:, 0], 8e-3)][:, 1:]
    edges = [edges[np.abs(edges - corner).sum(axis=1).argmin()] for corner in CORNERS]
    assert max(np.linalg.norm(places - edge, axis=1).min() for edge in edges) < 0.5e-3
