"""Contact of faces: a pressure by depth, integrated over the surface of bodies."""

import numpy as np
import pytest

from tests.contact.scenes import evaluated, play
from tests.validate.scenes import compiled_scene
from tissuec.forces.contact.bristle_kernel import SLIDES, cut_bristles
from tissuec.forces.contact.points import NO_FACE
from tissuec.forces.contact.readings import extent_at
from tissuec.geometry.elements import even, fourth_degree
from tissuec.validate.forces.contact import ContactForce

GEL = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
"""


def slab(
    tool, *, cell="4 mm", entries="", box="(0, 0, 0) mm to (16, 16, 4) mm", kind="", extra=""
):
    """Return the compiled scene of a slab whose faces a tool can touch."""
    return compiled_scene(f"""{GEL}
body slab {{ mesh is lattice {{ {kind} cell = {cell}; box from {box} }}; tissue is gel }}
{extra}
tool tool {{ {tool} }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only; {entries} }}
script {{ at 0 s: fix slab }}
simulate {{ duration = 1 ms }}
""").network


def deformed(network, size=2e-4):
    """Return positions of nodes, and velocities with bristles behind them, disturbed."""
    shift, speed = np.random.default_rng(3).standard_normal((2, network.row_count, 3))
    return network.position + size * shift[: network.node_count], 0.1 * speed


def forces(contact, position, velocity):
    """Return the forces of the compiled loops [N], shape (node, 3)."""
    found = np.zeros_like(position)
    contact.add_forces(0.0, position, velocity, found)
    return found


def forces_of_an_energy(contact, position, *, rel):
    """Return the forces [N], which are minus the derivative of the energy, and balance."""
    force = forces(contact, position, np.zeros_like(position))
    way = np.random.default_rng(5).standard_normal(position.shape)
    ends = [contact.energy(0.0, position + side * 1e-8 * way) for side in (1.0, -1.0)]
    assert (force * way).sum() == pytest.approx(-(ends[0] - ends[1]) / 2e-8, rel=rel)
    scale = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * scale
    assert np.abs(np.cross(position, force).sum(axis=0)).max() < 1e-14 * scale
    return force


TOOLS = {
    "ball": "kind is probe; radius = 6 mm; centre = (7.3, 8.2, 9) mm",
    "small ball": "kind is probe; radius = 3 mm; centre = (7.3, 8.2, 6.5) mm",
    "rod": "kind is probe; radius = 5 mm; axis from (4, 3, 8.4) mm to (11, 12, 8.7) mm",
    "plate": "kind is plane; point = (8, 8, 3.6) mm; normal = (0.05, 0.02, -1)",
    "needle": "kind is probe; radius = 0.6 mm; axis from (3.3, 3, 4.3) mm to (12, 13, 4.4) mm",
    "hook": "kind is hook; radius = 1 mm; shaft from (2, 3, 9) mm to (4, 5, 4.6) mm"
    "; bend = (8, 8, 4.5) mm; tip = (9, 10, 4.6) mm",
}


@pytest.mark.parametrize("name", TOOLS)
def test_forces_are_minus_the_derivative_of_the_energy_and_balance(name):
    network = slab(TOOLS[name])
    contact, (position, _) = network.contact, deformed(network)
    force = forces(contact, position, np.zeros_like(position))
    assert np.abs(force).max() > 1e-3
    way = np.random.default_rng(5).standard_normal(position.shape)
    way[network.body_nodes :] *= 0.3
    step = 1e-8
    change = contact.energy(0.0, position + step * way) - contact.energy(
        0.0, position - step * way
    )
    assert (force * way).sum() == pytest.approx(-change / (2.0 * step), rel=1e-6)
    scale = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * scale
    assert np.abs(np.cross(position, force).sum(axis=0)).max() < 1e-14 * scale


@pytest.mark.parametrize("name", ["ball", "plate", "needle"])
def test_the_matrix_is_minus_the_derivative_of_the_forces(name):
    network = slab(TOOLS[name])
    contact, (position, _) = network.contact, deformed(network)
    count = network.node_count
    number = np.arange(count)
    number[network.body_nodes :] = -1
    moves = number >= 0
    matrix = contact.matrix(0.0, position, number, network.body_nodes).toarray()
    way = np.random.default_rng(6).standard_normal(position.shape) * moves[:, None]
    still = np.zeros_like(position)
    change = forces(contact, position + 1e-9 * way, still) - forces(
        contact, position - 1e-9 * way, still
    )
    found = matrix @ way[moves].ravel()
    expected = -(change / 2e-9)[moves].ravel()
    assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()


STRAND = """
tissue silk { spring constant = 50 N/m; viscosity = 0 N*s/m; mass = 5 mg }
body strand { mesh is thread { line from (1, 3, 4.2) mm to (15, 11, 4.2) mm; pieces = 3
  thickness = 1 mm }; tissue is silk }
"""


def strand_on_slab():
    return slab("kind is probe; radius = 1 mm; centre = (0, 0, 30) mm", extra=STRAND)


def test_a_thread_touches_faces_along_its_pieces_and_forces_are_those_of_an_energy():
    network = strand_on_slab()
    contact, position = network.contact.intact(network.present), network.position.copy()
    thread = network.bodies[1].nodes
    force = forces(contact, position, np.zeros_like(position))
    # 2 h/R times E*, over the length: all points are 0.3 mm deep, less half the layer.
    size, firm = 4e-3, 10e3 / (1.0 - 0.3**2)
    length = np.hypot(14e-3, 8e-3)
    expected = firm * max(12.0, 2.0 * size / 0.5e-3) * length * (0.3e-3 - 0.0025 * size)
    assert force[thread].sum(axis=0) == pytest.approx([0.0, 0.0, expected], rel=1e-9, abs=1e-9)
    # Each node has its share, half as much at the ends.
    assert force[thread][:, 2] == pytest.approx(expected * np.array([1, 2, 2, 1]) / 6.0)
    position[:] += 0.1e-3 * np.random.default_rng(4).standard_normal(position.shape)
    force = forces_of_an_energy(contact, position, rel=1e-6)
    expected = ContactForce(contact).at(
        position, np.zeros_like(position), contact.near(position, 0.0)
    )
    assert np.abs(force - expected.force).max() < 1e-12 * np.abs(force).max()


def test_a_torn_piece_of_a_thread_touches_nothing():
    network = strand_on_slab()
    alive = network.present.copy()
    alive[network.bodies[1].thread.pieces.start + 1] = False
    contact, still = network.contact.intact(alive), np.zeros_like(network.position)
    force = forces(contact, network.position, still)[network.bodies[1].nodes, 2]
    assert force == pytest.approx(force.sum() / 4.0 * np.ones(4)) and force.sum() > 0.0


def rubbed(tool, friction):
    """Return a slab that a tool touches, with friction everywhere or on one half of it."""
    damping = "contact damping = 0.5 s/m"
    if friction:
        return slab(tool, entries=f"friction = {friction}; {damping}")
    half = "(0, 0, 0) mm to (16, 16, 4) mm }; region far where x > 8.1 mm { tissue is rough"
    return slab(
        tool, box=half, extra="tissue rough like gel { friction = 0.5 }", entries=damping
    )


@pytest.mark.parametrize("name", TOOLS)
@pytest.mark.parametrize("friction", ["0", "0.4", ""])
def test_loops_and_the_independent_reference_agree(name, friction):
    network = rubbed(TOOLS[name], friction)
    contact, (position, velocity) = network.contact, deformed(network)
    pairs = contact.near(position, 0.0)
    expected = ContactForce(contact).at(position, velocity, pairs)
    found = forces(contact, position, velocity)
    assert np.abs(found - expected.force).max() < 1e-12 * np.abs(found).max()
    lost = contact.powers(0.0, position, velocity)[1]
    assert lost == pytest.approx(expected.lost, rel=1e-11)
    energy = ContactForce(contact).energy(position, pairs)
    assert energy == pytest.approx(contact.energy(0.0, position), rel=1e-12)


@pytest.mark.parametrize("friction", ["0.4", ""])
@pytest.mark.parametrize("name", ["ball", "plate", "needle"])
def test_bristles_are_cut_and_slip_as_in_the_reference(name, friction):
    network = rubbed(TOOLS[name], friction)
    contact, (position, velocity) = network.contact, deformed(network)
    velocity[contact.memory] *= contact.rate * 1e-3
    table = contact.table(np.arange(len(velocity)), None, position)
    listed = np.searchsorted(contact.memory, table.touches.memory)
    velocity[np.delete(contact.memory, listed)] = 0.0  # as the engine has them
    reference, pairs = ContactForce(contact), contact.near(position, 0.0)
    found, expected = velocity.copy(), velocity.copy()
    for cuts in range(2):
        forces, _ = evaluated(contact, [table], position, found)
        touching = reference.at(position, expected, pairs)
        assert np.abs(forces - touching.force).max() < 1e-8 * np.abs(forces).max()
        rates = np.zeros((len(contact.memory), 3))
        rates[listed] = table.touches.bent[:, :3]
        scale = np.abs(rates).max()
        assert np.abs(rates - touching.bristle_rates).max() < 1e-8 * scale
        change = np.zeros_like(found)
        change[contact.memory] = rates
        grew = (change * found)[contact.memory].sum(axis=1)
        cut_bristles(found.reshape(-1), change.reshape(-1), table.touches)
        reference.slip(position, expected, pairs)
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
        slips = np.zeros(len(rates), dtype=bool)
        slips[listed] = table.touches.bent[:, SLIDES] > 0.0
        allowed = 1e-9 * scale * np.abs(found).max()
        # None that slips grows behind a cut, though some do before they slip.
        grows = (change * found)[contact.memory].sum(axis=1)
        assert slips.any() and grows[slips].max() <= allowed
        assert cuts or grew[slips].max() > 1e3 * allowed


def test_a_plate_presses_by_area_and_depth():
    network = slab("kind is plane; point = (8, 8, 3.9) mm; normal = (0, 0, -1)")
    contact = network.contact
    force = forces(contact, network.position, np.zeros_like(network.position))
    on_tool = force[network.body_nodes :].sum(axis=0)
    # c E*/h, less half the layer.
    by_depth = 12.0 * 10e3 / (1.0 - 0.09) / 4e-3
    expected = by_depth * 16e-3**2 * (0.1e-3 - 0.5 * 0.005 * 4e-3)
    assert on_tool == pytest.approx([0.0, 0.0, expected], rel=1e-9, abs=1e-12)
    extent = extent_at(
        contact, np.arange(network.body_nodes, network.node_count), network.position
    )
    assert extent.area == pytest.approx(16e-3**2) and extent.depth == pytest.approx(0.1e-3)


def test_a_ball_presses_evenly_on_a_flat_sheet_where_points_are_close():
    # A cell of 2 mm has points 0.6 mm apart; the contact radius √(2Rδ) is 2.4 mm.
    found = []
    for shift in np.linspace(0.0, 2.0, 9):
        network = slab(
            f"kind is probe; radius = 6 mm; centre = ({7 + shift}, {8 + 0.3 * shift}, 9.5) mm",
            cell="2 mm",
            entries="contact surface stiffness = 10 MPa/m; contact layer = 1 nm",
        )
        force = forces(network.contact, network.position, np.zeros_like(network.position))
        found.append(force[network.body_nodes :].sum(axis=0))
    found = np.array(found)
    depth, radius = 0.5e-3, 6e-3
    expected = np.pi * 10e6 * (radius - depth) * depth**2
    assert np.abs(found[:, 2] / expected - 1.0).max() < 0.02
    assert np.ptp(found[:, 2]) < 0.02 * expected
    assert np.abs(found[:, :2]).max() < 0.02 * expected


def test_a_needle_presses_evenly_wherever_it_is():
    found = []
    for shift in np.linspace(0.0, 4.0, 9):
        a, b = f"({3 + shift}, 4, 4.5)", f"({6 + shift}, 8, 4.5)"
        network = slab(
            f"kind is probe; radius = 0.6 mm; axis from {a} mm to {b} mm",
            entries="contact surface stiffness = 100 MPa/m; contact layer = 1 nm",
        )
        force = forces(network.contact, network.position, np.zeros_like(network.position))
        found.append(force[network.body_nodes :].sum(axis=0))
    found = np.array(found)
    # A strip as wide as the radius, half a radius longer at either end.
    expected = 100e6 * 0.6e-3 * (5e-3 + 0.6e-3) * 0.1e-3
    assert found[:, 2] == pytest.approx(np.full(9, expected), rel=1e-5)
    assert np.abs(found[:, :2]).max() < 1e-6 * expected
    assert np.ptp(found[:, 2]) < 1e-6 * expected


def test_a_needle_is_held_between_nodes_and_does_not_touch_nodes_of_faces():
    network = slab(
        "kind is probe; radius = 0.5 mm; axis from (1, 5, 3.9) mm to (15, 7, 3.9) mm"
    )
    points = network.contact.between
    assert (points.face == NO_FACE).sum() == 1 + int(np.ceil(np.hypot(14, 2))) + 1
    pairs = network.contact.near(network.position, 0.0)
    assert (network.contact.nodes[pairs.node] >= network.node_count).all()
    assert (
        points.face[network.contact.nodes[pairs.node] - network.node_count] == NO_FACE
    ).all()


def test_a_thin_hook_lifts_a_strip_and_does_not_pass():
    played = play(f"""{GEL.replace("kg/m^3", "kg/m^3; retardation time = 10 ms")}
body strip {{ mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (40, 10, 5) mm }}
  tissue is gel }}
set ends = nodes of strip where x == 0 mm or x == 40 mm
tool hook {{ kind is hook; radius = 1 mm; shaft from (21.3, -20, -1.2) mm to (21.3, -2, -1.2) mm
  bend = (21.3, 12, -1.2) mm }}
environment {{ gravity = (0, 0, 0) m/s^2; mass damping = 50 Hz; contact is tools only }}
script {{
  at 0 s: fix ends
  from 0 s to 0.1 s: move hook by (0, 0, 8) mm using smooth profile
}}
simulate {{ duration = 0.15 s; tolerance = 1e-3 }}
output {{ force of hook every 10 ms; penetration of hook every 10 ms; trajectory every 50 ms }}
""")
    network, position = played.compiled.network, played.position[-1]
    middle = np.isclose(network.position[:, :2], [20e-3, 5e-3]).all(axis=1)
    assert position[middle, 2].min() > 5e-3
    assert played.log("penetration of hook")[1].max() < 0.5e-3
    assert played.log("force of hook")[1][-1, 2] > 20e-3


def test_nets_and_a_stiffness_of_each_node_keep_contact_of_nodes():
    net = slab(TOOLS["ball"], entries="contact stiffness = 1 N/m").contact
    assert net.between is None
    assert slab(TOOLS["ball"], entries="contact places is nodes").contact.between is None
    assert slab(TOOLS["ball"]).contact.between is not None


def test_walls_bear_by_their_tension():
    network = compiled_scene(f"""{GEL}
body sheet {{
  mesh is sheet {{
    corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 40, 0) mm
    columns = 11; rows = 11
  }}
  tissue is gel; thickness = 1 mm
}}
tool ball {{ kind is probe; radius = 10 mm; centre = (20, 20, 10.2) mm }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only }}
simulate {{ duration = 1 ms }}
""").network
    contact = network.contact
    firm = 10e3 / (1.0 - 0.3**2)
    by_area = contact.stiffness[-len(contact.between.areas) :] / contact.between.areas
    size = np.sqrt(2.0 * contact.between.areas.sum() / len(contact.between.triangles))
    assert by_area == pytest.approx(np.full(len(by_area), 12.0 * firm * 1e-3 / size**2))


def test_points_of_torn_faces_are_gone():
    network = slab(TOOLS["ball"])
    contact, alive = network.contact, network.present.copy()
    assert contact.intact(alive).there.all()
    corner = contact.between.triangles[0]
    lost = np.flatnonzero(np.isin(network.line_ends, corner).all(axis=1))
    alive[lost] = False
    there = contact.intact(alive).there
    gone = contact.nodes[~there] - network.node_count
    assert (contact.between.face[gone] == 0).sum() == np.sum(contact.between.face == 0)


@pytest.mark.parametrize(("rule", "degree"), [(fourth_degree(), 4), (even(1), 1), (even(4), 1)])
def test_rules_of_triangles_integrate_polynomials(rule, degree):
    from math import factorial

    assert rule.points.sum(axis=1) == pytest.approx(np.ones(len(rule.weights)))
    for i in range(degree + 1):
        for j in range(degree + 1 - i):
            x, y = rule.points[:, 1], rule.points[:, 2]
            exact = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2)
            assert (rule.weights * x**i * y**j).sum() == pytest.approx(exact, rel=1e-12)
