"""Solids keep thin tools outside at any depth: the sign of distances from closed surfaces."""

import numpy as np
import pytest

from tests.contact.scenes import gap_of_balance, play
from tests.contact.test_faces import GEL, deformed, forces, forces_of_an_energy, slab
from tests.every import every
from tests.validate.scenes import compiled_scene
from tissuec.engine.execution.doubts.turning import TURNED
from tissuec.forces.contact.pairs import kept_outside
from tissuec.forces.contact.sides_kernel import CLOSED
from tissuec.geometry.inside import inside, winding_numbers
from tissuec.geometry.nearest import TRIANGLE, places
from tissuec.geometry.neighbours import nearest_triangles
from tissuec.validate.forces.contact import ContactForce

NEEDLE = "kind is probe; radius = 0.6 mm; axis from (3.3, 3, 4.7) mm to (12, 13, 4.8) mm"
#: How far the needle is moved down in mm: outside, at the surface, inside, beyond its radius.
DROPS = (0.3, 0.55, 0.69, 0.75, 0.9, 1.1, 1.6, 2.3)


def lowered(drop, *, size=2e-4, entries="", tool=NEEDLE):
    """Return a slab, positions with a needle moved down [mm], and velocities."""
    network = slab(tool, entries=entries)
    position, velocity = deformed(network, size)
    position[network.body_nodes : network.node_count, 2] -= 1e-3 * drop
    return network, position, velocity


# --- the law ----------------------------------------------------------------------------------


@every("drop", DROPS)
def test_forces_at_any_depth_are_minus_the_derivative_of_the_energy_and_balance(drop):
    network, position, _ = lowered(drop)
    contact, still = network.contact, np.zeros_like(position)
    forces_of_an_energy(contact, position, rel=1e-7)
    count, way = len(position), np.random.default_rng(5).standard_normal(position.shape)
    matrix = contact.matrix(0.0, position, np.arange(count), count)
    sides = [forces(contact, position + side * 1e-9 * way, still) for side in (1.0, -1.0)]
    change = (sides[0] - sides[1]).ravel() / 2e-9
    assert np.abs(matrix @ way.ravel() + change).max() < 1e-5 * np.abs(change).max()


@pytest.mark.parametrize("drop", DROPS)
@pytest.mark.parametrize("size", [0.0, 2e-4, 6e-4])
def test_the_reference_has_the_same_forces_by_solid_angles(drop, size):
    entries = "friction = 0.3; contact damping = 2 s/m"
    network, position, velocity = lowered(drop, size=size, entries=entries)
    contact = network.contact
    own, pairs = ContactForce(contact), contact.near(position, 1e-4)
    found = own.at(position, velocity, pairs)
    force = forces(contact, position, velocity)
    expected = found.force
    assert np.abs(force - expected).max() < 1e-9 * np.abs(expected).max()
    assert contact.powers(0.0, position, velocity)[1] == pytest.approx(found.lost, rel=1e-9)
    energy = own.energy(position, pairs)
    assert contact.energy(0.0, position) == pytest.approx(energy, rel=1e-12)


def test_the_force_in_a_flat_place_grows_as_the_depth_and_is_even():
    entries = "contact surface stiffness = 100 MPa/m; contact layer = 1 nm"
    for depth in (0.2, 0.5, 0.7, 1.3, 1.9):
        found = []
        for shift in np.linspace(0.0, 4.0, 9):
            a, b = f"({3.1 + shift}, 4, 4.7)", f"({6.1 + shift}, 8.1, 4.7)"
            tool = f"kind is probe; radius = 0.6 mm; axis from {a} mm to {b} mm"
            network, position, _ = lowered(depth + 0.1, size=0.0, entries=entries, tool=tool)
            force = forces(network.contact, position, np.zeros_like(position))
            found.append(force[network.body_nodes :].sum(axis=0))
        found = np.array(found)
        length = np.hypot(3e-3, 4.1e-3) + 0.6e-3
        expected = 100e6 * 0.6e-3 * length * 1e-3 * depth
        assert found[:, 2] == pytest.approx(np.full(9, expected), rel=1e-5)
        assert np.ptp(found[:, 2]) < 1e-6 * expected
        assert np.abs(found[:, :2]).max() < 1e-6 * expected


def test_a_point_exactly_on_the_surface_is_pushed_straight_out():
    tool = "kind is probe; radius = 0.6 mm; centre = (5.5, 6.7, 5) mm"
    network, position, _ = lowered(1.0, size=0.0, tool=tool)
    ball = slice(network.body_nodes, network.node_count)
    position[ball, 2] = 4e-3
    force = forces(network.contact, position, np.zeros_like(position))[ball].sum(axis=0)
    assert force[2] > 1e-3
    assert np.abs(force[:2]).max() < 1e-9 * force[2]


def spiky(seed):
    """Return a closed surface with sharp ridges and spikes: nodes [m] and triangles."""
    chance = np.random.default_rng(seed)
    step, golden = np.arange(60) + 0.5, np.pi * (1.0 + 5.0**0.5)
    z, turn = 1.0 - 2.0 * step / 60.0, golden * step
    across = np.sqrt(1.0 - z * z)
    ball = np.column_stack([np.cos(turn) * across, np.sin(turn) * across, z])
    from scipy.spatial import ConvexHull

    hull = ConvexHull(ball)
    out = (np.cross(*np.diff(ball[hull.simplices], axis=1).swapaxes(0, 1)) > 0.0).any()
    assert out
    normal = np.cross(
        ball[hull.simplices[:, 1]] - ball[hull.simplices[:, 0]],
        ball[hull.simplices[:, 2]] - ball[hull.simplices[:, 0]],
    )
    inwards = (normal * ball[hull.simplices[:, 0]]).sum(axis=1) < 0.0
    triangles = np.where(inwards[:, None], hull.simplices[:, [0, 2, 1]], hull.simplices)
    return ball * chance.uniform(0.3, 1.7, 60)[:, None], triangles.astype(np.int64)


@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_triangle_tells_the_side_at_sharp_edges_and_corners(seed):
    position, triangles = spiky(seed)
    chance = np.random.default_rng(seed)
    # Many near corners, where the nearest point is one.
    near = position[:, None] * (1.0 + chance.uniform(-0.3, 0.3, (60, 20, 1)))
    near = near + 0.1 * chance.standard_normal(near.shape)
    points = np.concatenate([near.reshape(-1, 3), chance.uniform(-1.7, 1.7, (1000, 3))])
    count, faces = len(points), len(triangles)
    point, face = np.repeat(np.arange(count), faces), np.tile(np.arange(faces), count)
    corners, kind = position[triangles[face]], np.full(len(point), TRIANGLE)
    radius = np.full(len(point), 1e-3)
    place = places(points[point], kind, corners, radius)
    found = kept_outside(place, corners, radius, np.full(len(point), CLOSED), point, 1e-14)
    is_deep = (found.depth > radius).reshape(count, faces).any(axis=1)
    expected = inside(points, position, triangles)
    assert expected.any() and not expected.all()
    assert np.array_equal(is_deep, expected)
    assert np.array_equal(expected, winding_numbers(points, position, triangles) > 0.5)


# --- what is listed, and where ----------------------------------------------------------------


def test_nearest_triangles_are_those_of_all_that_are_inside_or_may_get_there():
    position, triangles = spiky(3)
    points = np.random.default_rng(3).uniform(-1.2, 1.2, (300, 3))
    found = nearest_triangles(points, position, triangles, 0.05)
    distance = np.array(
        [
            -places(
                np.broadcast_to(point, (len(triangles), 3)),
                np.full(len(triangles), TRIANGLE),
                position[triangles],
                np.zeros(len(triangles)),
            ).depth
            for point in points
        ]
    )
    least = distance.min(axis=1)
    may = inside(points, position, triangles) | (least <= 0.05)
    expected = may[:, None] & (distance <= least[:, None] + 0.1)
    assert {*zip(found.point, found.triangle, strict=True)} == {
        *zip(*np.nonzero(expected), strict=True)
    }
    assert found.distance == pytest.approx(distance[found.point, found.triangle])


@pytest.mark.parametrize("drop", DROPS[1:])
def test_what_is_listed_holds_for_a_short_way(drop):
    network, before, _ = lowered(drop)
    contact = network.contact
    way = np.random.default_rng(8).standard_normal(before.shape)
    way *= 0.999 * contact.stride / np.linalg.norm(way, axis=1)[:, None]
    after = before + way
    ends = []
    for around in (before, after):
        table = contact.table(np.arange(len(before)), None, around)
        force, power = np.zeros(before.size), np.zeros(2)
        contact.kernel(0.0, after.ravel(), np.zeros(after.size), force, power, table)
        ends.append(force)
    assert np.abs(ends[0]).max() > 1e-3
    assert np.array_equal(*ends)


def test_what_is_far_away_or_drawn_inside_is_not_kept_outside():
    network = slab("kind is probe; radius = 0.6 mm; axis from (3, 3, 9) mm to (12, 12, 9) mm")
    assert network.contact.meetings.is_sided
    assert network.contact.near(network.position, 1e-3).sided.sum() == 0
    network = slab("kind is probe; radius = 0.6 mm; axis from (3, 3, 2) mm to (12, 12, 9) mm")
    assert not network.contact.meetings.is_sided
    network = slab("kind is probe; radius = 3 mm; centre = (8, 8, 9) mm")
    assert not network.contact.meetings.is_sided


def test_walls_have_no_inside():
    network = compiled_scene(f"""{GEL}
body body {{ mesh is sphere {{ centre = (8, 8, 0) mm; radius = 8 mm; subdivisions = 1 }}
  thickness = 0.5 mm; tissue is gel }}
tool tool {{ kind is probe; radius = 0.5 mm; axis from (4, 4, 9) mm to (12, 9, 9) mm }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only }}
simulate {{ duration = 1 ms }}
""").network
    assert network.contact.between is not None
    assert not network.contact.meetings.is_sided


@pytest.mark.parametrize("drop", [0.5, 1.5, 2.5, 3.4])
@pytest.mark.parametrize("y", [4.0, 6.3])
def test_halves_of_bodies_push_tools_out_as_the_whole_does(drop, y):
    found = []
    plane = "symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)"
    for x, extra in ((0, plane), (-16, "")):
        network = compiled_scene(f"""{GEL}
body slab {{ mesh is lattice {{ cell = 4 mm; box from ({x}, 0, 0) mm to (16, 16, 8) mm }}
  tissue is gel }}
tool tool {{ kind is probe; radius = 0.5 mm; axis from (0.3, {y}, 9) mm to (12, 9, 9) mm }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only; {extra} }}
simulate {{ duration = 1 ms }}
""").network
        tool, position = slice(network.body_nodes, network.node_count), network.position.copy()
        position[tool, 2] -= 1e-3 * (0.5 + drop)
        found.append(forces(network.contact, position, np.zeros_like(position))[tool])
    assert np.abs(found[1]).max() > 1e-3
    assert found[0] == pytest.approx(found[1], rel=1e-12, abs=1e-15)


def test_a_torn_surface_has_no_sides():
    network, position, _ = lowered(1.6)
    contact = network.contact
    alive = network.present.copy()
    assert contact.intact(alive).meetings.is_sided
    corner = int(np.flatnonzero((network.position[: network.body_nodes] == 0.0).all(axis=1))[0])
    alive[np.flatnonzero((network.line_ends == corner).any(axis=1))] = False
    torn = contact.intact(alive)
    assert not torn.meetings.is_sided
    assert np.abs(forces(torn, position, np.zeros_like(position))).max() == 0.0


def test_tools_touch_bodies_that_touch_themselves_too():
    text = f"""{GEL}
body slab {{ mesh is lattice {{ cell = 4 mm; box from (0, 0, 0) mm to (16, 16, 4) mm }}
  tissue is gel }}
tool tool {{ kind is probe; radius = 0.6 mm; axis from (3, 3, 4.3) mm to (12, 13, 4.4) mm }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is WHERE }}
simulate {{ duration = 1 ms }}
"""
    found = []
    for where in ("tools only", "everywhere"):
        network = compiled_scene(text.replace("WHERE", where)).network
        still = np.zeros_like(network.position)
        found.append(forces(network.contact, network.position, still)[network.body_nodes :])
    assert np.abs(found[0]).max() > 1e-3
    assert found[1] == pytest.approx(found[0], rel=1e-12)


# --- runs -------------------------------------------------------------------------------------

PRESSED = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 5 ms }}
body block {{ mesh is lattice {{ cell = 4 mm; box from (0, 0, 0) mm to (16, 16, {height}) mm }}
  tissue is gel }}
set base = nodes of block where z < 0.1 mm
tool needle {{ kind is probe; radius = 0.3 mm
  axis from (-3, 10, {above}) mm to (19, 10, {above}) mm }}
environment {{
  gravity = (0, 0, 0) m/s^2; contact is tools only; mass damping = 50 Hz; {entries}
}}
script {{ at 0 s: fix base
  from 0 s to 0.1 s: move needle by (0, 0, {way}) mm using smooth profile }}
simulate {{ duration = 0.1 s; tolerance = 1e-3 }}
output {{ force of needle every 5 ms; penetration of needle every 5 ms; energy every 1 ms }}
"""


def pressed(way, entries="", height=12):
    return play(PRESSED.format(way=way, entries=entries, height=height, above=height + 0.4))


def test_a_needle_between_rows_of_nodes_is_held_back_deeper_than_its_radius():
    played = pressed(-3.5)
    up = -played.log("force of needle")[1][:, 2]
    depth = played.log("penetration of needle")[1].ravel()
    assert played.outcome.kind == "done"
    # It dents a cell by nearly its side, whose top and bottom are then turned by more than 90°.
    assert [doubt.kind for doubt in played.outcome.doubts] == [TURNED]
    assert depth.max() > 0.3e-3
    pressing = up[4:14]
    assert (np.diff(pressing) > 0.0).all() and up[4:].min() > 20e-3
    assert up[-1] > 0.9 * up.max()
    assert gap_of_balance(played) < 1e-5


def test_a_needle_that_soft_contact_lets_sink_deep_is_held_and_reported():
    played = pressed(-3.0, "contact surface stiffness = 3 MPa/m")
    up = -played.log("force of needle")[1][:, 2]
    assert played.log("penetration of needle")[1].max() > 2e-3
    assert up[-1] > 0.9 * up.max() > 10e-3
    (doubt,) = played.outcome.doubts
    assert doubt.what == "needle sinks deep into block: contact is too soft there"
    assert doubt.kind == "passes through a surface" and doubt.last >= 1


def test_a_needle_that_is_pressed_beyond_the_middle_of_a_plate_passes_and_is_reported():
    played = pressed(-6.0, "contact surface stiffness = 1 MPa/m", height=4)
    assert np.abs(played.log("force of needle")[1][-1]).max() == 0.0
    (doubt,) = played.outcome.doubts
    assert doubt.what == "needle sinks deep into block: contact is too soft there"
    assert doubt.most >= 1 and doubt.last == 0


def test_the_energy_of_a_rod_that_is_thrown_into_a_block_is_kept():
    gaps = []
    for step in (40.0, 5.0):  # single halvings scatter, as contacts begin within steps
        played = play(f"""language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body block {{ mesh is lattice {{ cell = 4 mm; box from (0, 0, 0) mm to (8, 8, 8) mm }}
  tissue is gel; velocity = (0.02, 0.01, 0.3) m/s; spin = (1, 2, 0) rad/s }}
tool needle {{ kind is probe; radius = 0.3 mm
  axis from (-3, 5.1, 8.4) mm to (11, 5.3, 8.5) mm }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only
  contact surface stiffness = 20 MPa/m }}
simulate {{ duration = 11 ms; step = {step} us; integrator is velocity Verlet }}
output {{ energy every 0.1 ms; penetration of needle every 0.1 ms }}
""")
        depth = played.log("penetration of needle")[1].ravel()
        assert depth.max() > 0.6e-3 > depth[-1]
        _, energy = played.energies()
        whole = energy["kinetic"] + energy["elastic"]
        gaps.append(np.abs(whole - whole[0]).max() / whole[0])
    assert gaps[1] < 0.4**3 * gaps[0] < 0.4**3 * 1e-2


# --- threads ----------------------------------------------------------------------------------


def strand(drop, *, line="(1, 3, 4.7) mm to (15, 11, 4.7) mm", extra=""):
    """Return a slab, positions with a thread moved down [mm], and the nodes of the thread."""
    network = slab(
        "kind is probe; radius = 3 mm; centre = (0, 0, 30) mm",
        entries="friction = 0.3",
        extra=f"""
tissue silk {{ spring constant = 50 N/m; viscosity = 0 N*s/m; mass = 5 mg }}
body strand {{ mesh is thread {{ line from {line}; pieces = 3; thickness = 1 mm }}
  tissue is silk }}
{extra}""",
    )
    position, _ = deformed(network, 1e-4)
    thread = network.bodies[1].nodes
    position[thread, 2] -= 1e-3 * drop
    return network, position, thread


@pytest.mark.parametrize("drop", [0.4, 0.8, 1.1, 1.6])
def test_threads_that_are_drawn_outside_are_pushed_out_at_any_depth(drop):
    network, position, thread = strand(drop)
    contact = network.contact.intact(network.present)
    velocity = 0.1 * np.random.default_rng(4).standard_normal((network.row_count, 3))
    force = forces_of_an_energy(contact, position, rel=1e-6)
    assert force[thread, 2].min() > 0.0
    found = ContactForce(contact).at(position, velocity, contact.near(position, 1e-4)).force
    force = forces(contact, position, velocity)
    assert np.abs(force - found).max() < 1e-9 * np.abs(found).max()


def test_threads_that_are_drawn_inside_sewn_or_torn_are_not_kept_outside():
    inner = strand(0.0, line="(1, 3, 4.7) mm to (15, 11, 3) mm")[0]
    assert not inner.contact.meetings.is_sided
    sewn = """set end = nodes of strand in [1]
set corner = nodes of slab in [1]
joint suture { springs from end to corner; tissue is silk }"""
    assert not strand(0.0, extra=sewn)[0].contact.meetings.is_sided
    network, position, thread = strand(1.6)
    alive = network.present.copy()
    alive[network.bodies[1].thread.pieces] = False
    force = forces(network.contact.intact(alive), position, np.zeros_like(position))
    assert np.abs(force[thread]).max() == 0.0


def test_a_thread_that_is_pulled_hard_over_an_edge_is_held_deeper_than_its_radius():
    played = play("""language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
tissue silk { spring law is tension only; spring constant = 400 N/m
  viscosity = 0.1 N*s/m; mass = 5 mg }
body block { mesh is lattice { cell = 8 mm; box from (0, 0, 0) mm to (16, 16, 16) mm }
  tissue is gel }
body strand { mesh is thread { line from (-8, 9, 16.8) mm to (24, 9, 16.8) mm; pieces = 8
  thickness = 0.6 mm }; tissue is silk }
set base = nodes of block where z < 0.1 mm
set ends = nodes of strand where x < -7.9 mm or x > 23.9 mm
environment { gravity = (0, 0, 0) m/s^2; mass damping = 50 Hz; contact is tools only
  contact surface stiffness = 30 MPa/m }
script {
  at 0 s: { fix base; hold ends }
  from 0 s to 0.1 s: move ends by (0, 0, -6) mm using smooth profile
}
simulate { duration = 0.12 s; tolerance = 1e-2 }
output { force of ends every 10 ms; penetration of strand every 5 ms }
""")
    assert played.log("penetration of strand")[1].max() > 0.6e-3
    down = played.log("force of ends")[1][:, 2]
    assert down[-1] < 0.8 * down.min() < -5e-3
    assert not any("holds it no longer" in doubt.what for doubt in played.outcome.doubts)
