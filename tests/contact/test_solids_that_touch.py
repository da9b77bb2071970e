"""Contact between bodies: where it begins, how deep it holds, and how stiff it is."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

import tissuec
from tests.contact.scenes import play
from tests.contact.test_faces import deformed, forces, forces_of_an_energy
from tests.every import every
from tests.validate.scenes import compiled_scene, quantity, validated
from tissuec.engine.execution.doubts import Follower
from tissuec.engine.execution.doubts.sinking import Sinking
from tissuec.forces.contact.sides_kernel import CLOSED, TORN
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.state import State
from tissuec.validate.forces.contact import ContactForce

CUBES = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0; density = 1000 kg/m^3 }}
body low {{ mesh is lattice {{ cell = 10 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }}
  tissue is gel }}
body high like low {{ moved by (0.1, 0.05, {apart}) mm }}
set base = nodes of low where z < 1 mm
set top = nodes of high where z > {apart} mm + 5 mm
environment {{
  gravity = (0, 0, 0) m/s^2; contact is bodies too; contact layer = 1 nm; {entries}
}}
script {{
  at 0 s: fix base
  from 0 s to 1 s: move top by (0, 0, -{way}) mm using constant speed
}}
simulate {{ duration = 1 s; integrator is equilibrium; step = 0.25 s }}
output {{ force(top) every 0.25 s }}
"""


def pressing(apart=10.0, way=0.02, entries=""):
    """Return the force of a cube that is moved down onto another one [N]."""
    played = play(CUBES.format(apart=apart, way=way, entries=entries))
    assert played.outcome.kind == "done"
    return -played.log("force of top")[1][:, 2]


#: The two triangles of a face load its corners unevenly, which dents the cubes a little.
UNEVEN = 0.012


def springs_in_series(way):
    """Return the force of two cubes and of contact in series [N].

    A cube has E h, and contact 12 E/h per area on the faces of both.
    """
    cube = 10e3 * 10e-3
    return 1e-3 * way / (2.0 / cube + 1.0 / (24.0 * cube))


# --- where it begins --------------------------------------------------------------------------


@pytest.mark.parametrize("thickness", ["", "2 um", "0.02 mm", "0.2 mm", "3 mm"])
def test_cubes_that_touch_as_drawn_are_springs_in_series(thickness):
    entries = thickness and f"contact thickness = {thickness}"
    force = pressing(entries=entries)
    assert abs(force[0]) < 1e-12 * force[-1]  # rounding of coordinates
    assert force[1:] == pytest.approx(springs_in_series(0.02) * np.arange(1, 5) / 4, rel=UNEVEN)


@pytest.mark.parametrize("thickness", ["", "2 um", "0.2 mm"])
def test_pressed_by_a_tenth_they_do_not_pass(thickness):
    entries = thickness and f"contact thickness = {thickness}"
    force = pressing(way=2.0, entries=entries)
    assert np.all(np.diff(force) > 0.02)

    def left(of_cube):  # of the way [m], where cubes and contact bear the same
        return 2.0 * of_cube + borne(of_cube) / (24.0 * 10e3 * 10e-3) - 2e-3

    expected = borne(brentq(left, 1e-5, 2e-3))
    assert force[-1] == pytest.approx(expected, rel=2.0 * UNEVEN)


def borne(way):
    """Return the force of a cube with free sides that is pressed by a way [m], of ν = 0 [N]."""
    shear, bulk, along = 5e3, 10e3 / 3.0, 1.0 - way / 10e-3

    def kirchhoff(across):
        """Return the stresses along and across, of μ (I1 - 3)/2 + K (ln J)²/2."""
        j = along * across**2
        part = shear * j ** (-2.0 / 3.0) * (along**2 - across**2) / 3.0
        return 2.0 * part + bulk * np.log(j), bulk * np.log(j) - part

    across = brentq(lambda each: kirchhoff(each)[1], 0.8, 1.5)
    return -1e-4 * kirchhoff(across)[0] / along


@pytest.mark.parametrize("apart", [10.3, 9.7, 9.98])
def test_the_gap_as_drawn_is_no_depth(apart):
    gap = max(apart - 10.0, 0.0)
    force = pressing(apart=apart, way=gap + 0.02)
    assert abs(force[0]) < 1e-12 * force[-1]  # rounding of coordinates
    assert force[-1] == pytest.approx(springs_in_series(0.02), rel=UNEVEN)
    if gap:
        assert (
            np.abs(force[:-1]).max() < 1e-12 * force[-1]
        )  # three quarters of the way are less than the gap


def test_a_thickness_that_is_written_keeps_solids_apart():
    force = pressing(apart=11.0, way=0.52, entries="contact thickness = 0.5 mm")
    assert force[-1] == pytest.approx(springs_in_series(0.02), rel=UNEVEN)
    assert np.abs(force[:-1]).max() < 1e-12 * force[-1]


# --- the law ----------------------------------------------------------------------------------

BLOCKS = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  breaking strain = 80 % }
body low { mesh is lattice { cell = 4 mm; box from (0, 0, 0) mm to (12, 12, 8) mm }
  tissue is gel; rupture is allowed }
body high { mesh is BODY; tissue is TISSUE }
environment { gravity = (0, 0, 0) m/s^2; contact is bodies too; ENTRIES }
simulate { duration = 1 ms }
"""
BLOCK = "lattice { cell = 3 mm; box from (1.3, 2.1, 8) mm to (7.3, 8.1, 14) mm }"
BALL = "ellipsoid { centre = (5.3, 6.1, 11) mm; radii = (3, 3, 3) mm; cell = 1.5 mm }"
SHEET = """sheet { corner = (1.1, 1.3, 8) mm; columns = 4; rows = 4
  first edge = (8, 0, 0) mm; second edge = (0, 8, 0) mm }"""
MIRROR = "symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)"
#: What lies on the lower block: a mesh, a tissue, and entries of the environment.
UPPER = {
    "block": (BLOCK, "gel", ""),
    "ball": (BALL, "gel", ""),
    "kept apart": (f"{BLOCK}; moved by (0, 0, 0.5) mm", "gel", "contact thickness = 0.3 mm"),
    "overlapping": (f"{BLOCK}; moved by (0, 0, -0.1) mm", "gel", ""),
    "half": (f"{BLOCK}; moved by (-1.3, 0, 0) mm", "gel", MIRROR),
    "wall": (SHEET, "gel; thickness = 0.5 mm", ""),
    "net": (f"{BLOCK[:-1]}; kind is sodium chloride }}", "cord", ""),
    "itself": (BLOCK, "gel", "contact is everywhere"),
}
CORD = "tissue cord { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 30 mg }"


def upper(name, entries=""):
    """Return the compiled scene of a body on a block."""
    body, tissue, more = UPPER[name]
    text = BLOCKS.replace("BODY", body).replace("TISSUE", tissue)
    if "contact is everywhere" in more:
        text, more = text.replace("contact is bodies too", "contact is everywhere"), ""
    text = text.replace("ENTRIES", f"{more}; {entries}" if more else entries)
    return compiled_scene(f"{text}\n{CORD}" if tissue == "cord" else text).network


def lowered(name, drop, *, size=1e-4, entries=""):
    """Return a scene, and disturbed positions and velocities with the body moved down [mm]."""
    network = upper(name, entries)
    position, velocity = deformed(network, size)
    nodes = network.bodies[1].nodes
    position[nodes, 2] -= 1e-3 * drop
    for plane in network.mirrored:
        position[plane.nodes, 0] = 0.0
    return network, position, velocity


@pytest.mark.parametrize("name", UPPER)
def test_nothing_presses_as_drawn(name):
    network, _, _ = lowered(name, 0.0, size=0.0)
    force = forces(network.contact, network.position, np.zeros_like(network.position))
    _, position, _ = lowered(name, 0.8, size=0.0)
    pressed = forces(network.contact, position, np.zeros_like(position))
    assert np.abs(force).max() < 1e-9 * np.abs(pressed).max()


CASES = [(name, drop) for name in UPPER for drop in (0.6, 0.9, 1.5)]


@every("case", CASES)
def test_forces_are_minus_the_derivative_of_the_energy_at_any_depth(case):
    name, drop = case
    network, position, _ = lowered(name, drop)
    contact = network.contact
    force = forces_of_an_energy(contact, position, rel=1e-6)
    assert np.abs(force).max() > 1e-5
    count, way = len(position), np.random.default_rng(5).standard_normal(position.shape)
    matrix, still = contact.matrix(0.0, position, np.arange(count), count), 0.0 * position
    sides = [forces(contact, position + side * 1e-9 * way, still) for side in (1.0, -1.0)]
    change = (sides[0] - sides[1]).ravel() / 2e-9
    assert np.abs(matrix @ way.ravel() + change).max() < 1e-5 * np.abs(change).max()


@every("case", CASES)
def test_the_reference_has_the_same_forces(case):
    name, drop = case
    network, position, velocity = lowered(
        name, drop, entries="friction = 0.3; contact damping = 2 s/m"
    )
    contact = network.contact
    own, pairs = ContactForce(contact), contact.near(position, 1e-4)
    found = own.at(position, velocity, pairs)
    force = forces(contact, position, velocity)
    expected = found.force
    assert np.abs(force - expected).max() < 1e-9 * np.abs(expected).max()
    assert contact.powers(0.0, position, velocity)[1] == pytest.approx(found.lost, rel=1e-9)
    assert contact.energy(0.0, position) == pytest.approx(
        own.energy(position, pairs), rel=1e-12
    )


@pytest.mark.parametrize("name", ["block", "ball", "half", "wall", "net"])
def test_the_deeper_the_body_the_more_it_is_pushed_out(name):
    pushes = []
    for drop in (0.1, 0.5, 1.0, 2.0):
        network, position, _ = lowered(name, drop, size=0.0)
        force = forces(network.contact, position, np.zeros_like(position))
        pushes.append(force[network.bodies[1].nodes, 2].sum())
    assert np.all(np.diff(pushes) > 0.0)


def lowered_on_a_tear():
    """Return a block on a slab with a torn face, positions, velocities, and what is intact."""
    network, position, velocity = lowered("block", 0.3, entries="friction = 0.3")
    alive, skin = network.present.copy(), network.skin_of(network.bodies[0])
    middle = network.position[skin].mean(axis=1)
    torn = int(np.argmin(np.linalg.norm(middle - [6e-3, 6e-3, 8e-3], axis=1)))
    assert network.skin_elements is not None
    alive[network.skin_elements[torn]] = False
    return network, position, velocity, alive


def test_what_settles_is_pressed_by_intact_faces_alone():
    network, position, _, alive = lowered_on_a_tear()
    state = State.start(network, gravity=np.zeros(3), drag=0.0)
    state.position[:], state.alive[:] = position, alive
    balance = Balance(state, np.ones(network.node_count, dtype=bool))
    own = np.arange(network.node_count)[network.bodies[1].nodes]
    force, bears = balance.pressed(balance.start, np.searchsorted(balance.free, own))
    left = forces(network.contact.intact(alive), position, 0.0 * position)
    expected = np.linalg.norm(left[own].sum(axis=0))
    assert force == pytest.approx(expected, rel=1e-12)
    assert bears == pytest.approx(0.3 * expected, rel=1e-12)


def test_where_a_surface_is_torn_it_keeps_out_what_is_elsewhere():
    network, position, velocity, alive = lowered_on_a_tear()
    contact = network.contact
    left = contact.intact(alive)
    assert set(np.unique(left.meetings.sided)) == {0, CLOSED, TORN}
    whole, part = (forces(one, position, velocity) for one in (contact, left))
    nodes = network.bodies[1].nodes
    assert 0.0 < part[nodes, 2].sum() < whole[nodes, 2].sum()
    found = ContactForce(left).at(position, velocity, left.near(position, 1e-4)).force
    assert np.abs(part - found).max() < 1e-9 * np.abs(found).max()


# --- how stiff it is --------------------------------------------------------------------------


def stiffness_of(hard, *, tool=""):
    """Return the stiffness per area of contact of a block with a firmer one [Pa/m]."""
    text = BLOCKS.replace("BODY", BLOCK).replace("TISSUE", "stone").replace("ENTRIES", "")
    stone = f"tissue stone like gel {{ Young's modulus = {hard} }}"
    network = compiled_scene(f"{text}\n{stone}\n{tool}").network
    contact, points = network.contact, network.contact.between
    first = len(contact.nodes) - len(points.corners)
    owner, k = contact.owner[first:], contact.stiffness[first:]
    return owner, k / points.areas, contact.meetings.group[first:]


def test_on_the_faces_of_both_bodies_the_softer_one_counts():
    firm = 10e3 / (1.0 - 0.3**2)
    owner, k, _ = stiffness_of("10 GPa")
    assert k[owner == 0] == pytest.approx(12.0 * firm / 4e-3)
    assert k[owner == 1] == pytest.approx(12.0 * firm / 3e-3)


def test_a_tool_finds_the_firmer_body_as_hard_as_it_is():
    firm = 10e3 / (1.0 - 0.3**2)
    tool = "tool probe { kind is probe; radius = 9 mm; centre = (4, 5, 40) mm }"
    owner, k, group = stiffness_of("10 GPa", tool=tool)
    own, softer = (k[(owner == 1) & (group == number)] for number in (3, 5))
    assert own == pytest.approx(12e6 * firm / 3e-3)
    assert softer == pytest.approx(12.0 * firm / 3e-3)
    assert len(own) == len(softer)


# --- runs -------------------------------------------------------------------------------------

FALL = """language 1
tissue gel {{ Young's modulus = {soft}; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 1 ms }}
body low {{ mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 10) mm }}
  tissue is gel }}
body high {{ mesh is lattice {{ cell = 5 mm; box from (3, 4, 10.2) mm to (13, 14, 20.2) mm }}
  tissue is gel; velocity = (0.05, 0, {speed}) m/s }}
set base = nodes of low where z < 0.1 mm
environment {{ gravity = (0, 0, 0) m/s^2; contact is bodies too; friction = 0.3; {entries} }}
script {{ at 0 s: fix base }}
simulate {{ duration = {duration}; tolerance = 1e-4 }}
output {{ trajectory every 1 ms }}
"""


def fall(speed="-0.3", entries="", duration="6 ms", soft="10 kPa"):
    return FALL.format(speed=speed, entries=entries, duration=duration, soft=soft)


def test_a_block_that_hits_another_one_agrees_with_scipy():
    found = validated(fall(duration="1 ms"), rtol=1e-7)
    assert found.verdict == "kept", found.reasons
    assert quantity(found, "position").error < 1e-4


@pytest.mark.parametrize(("stiffness", "is_deep"), [("0.3 MPa/m", True), ("20 MPa/m", False)])
def test_what_sinks_in_deep_is_doubtful(stiffness, is_deep):
    entries = f"contact surface stiffness = {stiffness}"
    text = CUBES.format(apart=10.0, way=2.0, entries=entries)
    said = {one.what for one in tissuec.run(text, companion="off").doubts}
    pairs = (("low", "high"), ("high", "low"))
    deep = {f"{a} sinks deep into {b}: contact is too soft there" for a, b in pairs}
    assert said == (deep if is_deep else set())


@pytest.mark.parametrize(("drop", "count"), [(0.8e-3, 0), (0.9e-3, 2), (3e-3, 2)])
def test_deep_is_a_quarter_of_the_thickness_of_a_plate_of_equal_volume(drop, count):
    # Of a cube of 10 mm, volume over surface is 10/6 mm: half of it are 0.83 mm.
    compiled = compiled_scene(CUBES.format(apart=10.0, way=2.0, entries=""))
    network, position = compiled.network, compiled.network.position.copy()
    watch = Sinking.of(network, compiled.plan)
    assert isinstance(watch, Follower), "it is asked wherever nodes have moved far"
    position[network.bodies[1].nodes, 2] -= drop
    found = list(watch.look(SimpleNamespace(contact=network.contact), position))
    assert len(found) == count
    assert all(one.count > 0 for one in found)


def test_a_thin_thickness_takes_no_more_steps():
    few, many = (
        tissuec.run(fall(entries=entries, duration="1 ms"), companion="off").manifest[
            "statistics"
        ]["accepted"]
        for entries in ("", "contact thickness = 2 um")
    )
    assert many < 1.2 * few
