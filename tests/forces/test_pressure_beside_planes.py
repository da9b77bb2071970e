"""Pressure and fluids in parts of tubes beside planes of symmetry, against the whole."""

from itertools import product

import numpy as np
import pytest
from scipy.spatial import KDTree

import tissuec
from tests.derivatives import agree, forces, slopes
from tests.imports.organs import write_obj
from tests.validate.scenes import compiled_scene
from tissuec.core.structs import replace
from tissuec.forces.enclosed.fluids import FluidCavities
from tissuec.forces.enclosed.pressed_sides import NoSide, Pressed, closed_by_caps, pressed_faces
from tissuec.forces.enclosed.pressure import SurfacePressure
from tissuec.model.profiles import TimeProfile
from tissuec.validate.forces.fluids import FluidField
from tissuec.validate.forces.pressure import PressedSkin

LOGGED = ("pressure", "volume")
PRESSURE, DENSITY, MODULUS = 3e3, 1010.0, 1e4
AXIS = np.array([3.0, -2.0, 1.0]) * 1e-3  # away from the origin
PLANES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
PARTS = {
    "whole": ("whole", "", 2),
    "half": ("half", "y", 2),
    "quarter": ("quarter", "xy", 2),
    "long half": ("whole", "z", 1),
    "eighth": ("quarter", "xyz", 1),
}


def network_of(name, *, others=""):
    part, planes, halves = PARTS[name]
    x, y, z = 1e3 * AXIS
    symmetric = "\n".join(
        f"  symmetric about plane through ({x}, {y}, {z}) mm facing {PLANES[one]}"
        for one in planes
    )
    return compiled_scene(f"""language 1
tissue media {{ Young's modulus = 100 kPa; density = 1100 kg/m^3 }}
body artery {{
  mesh is thick tube {{
    axis from ({x}, {y}, {z - 10 * (halves - 1)}) mm to ({x}, {y}, {z + 10}) mm
    inner radius = 4 mm; outer radius = 6 mm
    rings = {3 * halves - halves + 1}; sides = 8; layers = 1; part is {part}
  }}
  tissue is media
}}
environment {{ gravity = (0, 0, 0) m/s^2
{symmetric}
{others} }}
simulate {{ duration = 1 ms }}
""").network


def moved(position):
    """Return positions after a motion that is even about all three planes."""
    x, y, z = 1e3 * (position - AXIS).T
    return AXIS + 1e-3 * np.stack(
        [
            x * (1.2 + 1e-2 * y * y + 2e-3 * z * z),
            y * (0.9 - 3e-3 * x * x + 1e-3 * z * z),
            z * (1.1 + 2e-3 * x * x - 1e-3 * y * y),
        ],
        axis=1,
    )


def faces_within(network):
    return pressed_faces(network, Pressed("artery", np.arange(network.node_count), True))


def pressure_in(network, *, caps=True):
    faces, span = faces_within(network), network.bodies[0].span
    steady = TimeProfile("constant", 0.0, np.inf)
    return SurfacePressure.of("key", "a", faces, PRESSURE, steady, span, has_caps=caps)


def fluid_in(network, gravity=(0.0, 0.0, 0.0)):
    faces, span = faces_within(network), network.bodies[0].span
    made = FluidCavities.of(network, "a", faces, MODULUS, DENSITY, span, has_caps=True)
    return replace(made, gravity=np.array(gravity))


def downwards(name):
    """Return a gravity within all planes of a part [m/s²]."""
    free = [axis not in PARTS[name][1] for axis in "xyz"]
    return np.where(free, [2.0, -1.0, -9.0], 0.0)


def within_planes(network, vectors):
    """Return the parts within the planes of symmetry of vectors at nodes, shape (node, 3)."""
    found = vectors.copy()
    if network.guides is not None:
        network.guides.keep(found)
    return found


def share(network, name):
    """Return the part of each node that belongs to what is drawn, shape (node,)."""
    on = [
        np.isclose(network.position[:, "xyz".index(axis)], AXIS["xyz".index(axis)])
        for axis in PARTS[name][1]
    ]
    return 0.5 ** np.sum(on, axis=0)


@pytest.mark.parametrize("name", [name for name in PARTS if name != "whole"])
def test_forces_on_a_part_are_those_on_the_whole(name):
    whole, part = network_of("whole"), network_of(name)
    _, place = KDTree(whole.position).query(part.position)
    count, gravity = 2 ** len(PARTS[name][1]), downwards(name)
    x, own = moved(whole.position), moved(part.position)
    fields = [
        (pressure_in(whole, caps=caps), pressure_in(part, caps=caps)) for caps in (True, False)
    ]
    for one, other in [*fields, (fluid_in(whole, gravity), fluid_in(part, gravity))]:
        wanted = forces(one, x)[place] * share(part, name)[:, None]
        found = within_planes(part, forces(other, own))
        np.testing.assert_allclose(found, wanted, atol=1e-12 * np.abs(wanted).max())
    for one, other in fields:
        assert count * other.volume(own) == pytest.approx(one.volume(x), rel=1e-12)
    one, other = fluid_in(whole, gravity), fluid_in(part, gravity)
    assert count * other.volumes(own) == pytest.approx(one.volumes(x), rel=1e-12)
    assert count * other.energy(0.0, own) == pytest.approx(one.energy(0.0, x), rel=1e-11)


@pytest.mark.parametrize("name", ["half", "quarter", "eighth"])
@pytest.mark.parametrize("caps", [True, False])
def test_forces_and_matrix_follow_from_the_potential_within_the_planes(name, caps):
    network = network_of(name)
    field, count = pressure_in(network, caps=caps), network.node_count
    chance = np.random.default_rng(4).normal(size=(count, 3))
    position = network.position + 3e-4 * within_planes(network, chance)
    found = forces(field, position)
    wayward = field.wayward(0.0, position)
    # By symmetry, the middle of a long half has no opening.
    assert (wayward is None) == caps
    if wayward is not None:
        found = found - wayward
    by_volume = slopes(lambda x: field.potential(0.0, x), position, range(count), 1e-7)
    found, by_volume = (within_planes(network, one) for one in (found, by_volume))
    np.testing.assert_allclose(found, by_volume, atol=1e-7 * np.abs(found).max())
    if caps:
        matrix = field.matrix(0.0, position, np.arange(count), count).toarray()
        way = within_planes(network, chance)
        ahead, behind = (forces(field, position + sign * 1e-8 * way) for sign in (1.0, -1.0))
        wanted = within_planes(network, (behind - ahead) / 2e-8)
        along = within_planes(network, (matrix @ way.ravel()).reshape(-1, 3))
        np.testing.assert_allclose(along, wanted, atol=1e-6 * np.abs(wanted).max())


@pytest.mark.parametrize("name", ["half", "quarter", "eighth"])
def test_fluids_follow_from_their_energy_within_the_planes(name):
    network = network_of(name)
    field = replace(fluid_in(network, downwards(name)), modulus=300.0)
    count = network.node_count
    chance = np.random.default_rng(4).normal(size=(count, 3))
    way = within_planes(network, chance)
    position = network.position + 3e-4 * way
    found = within_planes(network, forces(field, position))
    by_energy = slopes(lambda x: field.energy(0.0, x), position, range(count), 1e-7)
    by_energy = within_planes(network, by_energy)
    np.testing.assert_allclose(found, by_energy, atol=1e-6 * np.abs(found).max())
    matrix = field.matrix(0.0, position, np.arange(count), count).toarray()
    ahead, behind = (forces(field, position + sign * 1e-8 * way) for sign in (1.0, -1.0))
    wanted = within_planes(network, (behind - ahead) / 2e-8)
    along = within_planes(network, (matrix @ way.ravel()).reshape(-1, 3))
    np.testing.assert_allclose(along, wanted, atol=1e-6 * np.abs(wanted).max())


@pytest.mark.parametrize("name", ["half", "quarter", "eighth"])
def test_forces_are_those_of_the_reference(name):
    network = network_of(name)
    chance = np.random.default_rng(8)
    position = network.position + 3e-4 * chance.normal(size=network.position.shape)
    velocity = chance.normal(size=network.position.shape)
    limits = {"force": 1e-11, "matrix": 1e-11, "energy": 1e-11, "lost": 1e-12}
    for caps in (True, False):
        field = pressure_in(network, caps=caps)
        reference = PressedSkin(field)
        agree(field, reference, position, velocity, **limits)
        potential = reference.potential(0.0, position)
        assert field.potential(0.0, position) == pytest.approx(potential, rel=1e-10)
        supplied = field.powers(0.0, position, velocity)[0]
        assert supplied == pytest.approx(reference.pumping(0.0, position, velocity))


@pytest.mark.parametrize("name", ["half", "quarter", "eighth"])
def test_fluids_are_those_of_the_reference_within_the_planes(name):
    network = network_of(name)
    field, count = fluid_in(network, downwards(name)), network.node_count
    reference = FluidField(field)
    chance = np.random.default_rng(8).normal(size=(2, count, 3))
    shaken, way = (within_planes(network, one) for one in chance)
    position = network.position + 3e-4 * shaken
    wanted = np.zeros_like(position)
    reference.add_forces(0.0, position, wanted, wanted)
    along = [
        (one.matrix(0.0, position, np.arange(count), count) @ way.ravel()).reshape(-1, 3)
        for one in (field, reference)
    ]
    for found, due in ((forces(field, position), wanted), along):
        found, due = (within_planes(network, one) for one in (found, due))
        np.testing.assert_allclose(found, due, atol=1e-11 * np.abs(due).max())
    energy = reference.energy(0.0, position)
    assert field.energy(0.0, position) == pytest.approx(energy, rel=1e-11)
    assert field.volumes(position) == pytest.approx(reference.volumes(position), rel=1e-12)


def ball_scene(folder, name, mesh, order, *, planes=""):
    """Write a scene of a ball; return its path."""
    path = folder / f"{name}.tis"
    path.write_text(
        f"""language 1
tissue gel {{ Young's modulus = 100 kPa; density = 1100 kg/m^3; retardation time = 1 ms }}
body ball {{ tissue is gel; thickness = 1 mm; bending is none; mesh is {mesh} }}
environment {{ gravity = (0, 0, 0) m/s^2; {planes} }}
script {{ at 0 s: {{ {order}; settle }} }}
simulate {{ duration = 1 ms }}
output {{ pressure of ball every 1 ms; volume of ball every 1 ms }}
""",
        encoding="utf-8",
    )
    return path


def octants(signs, cells=4):
    """Return nodes [mm] and triangles of eighths of a ball of 10 mm.

    Args:
        signs: Of z of the eighths.
        cells: Along an edge of each.
    """
    corners = []
    for x, y, z in product((1, -1), (1, -1), signs):
        for i, j in product(range(cells), repeat=2):
            for one in (
                [(i, j), (i + 1, j), (i, j + 1)],
                [(i + 1, j), (i + 1, j + 1), (i, j + 1)],
            ):
                if max(map(sum, one)) <= cells:
                    ends = [(x * a, y * b, z * (cells - a - b)) for a, b in one]
                    corners.append(ends if x * y * z > 0 else ends[::-1])
    nodes, triangles = np.unique(np.reshape(corners, (-1, 3)), axis=0, return_inverse=True)
    position = 10.0 * nodes / np.linalg.norm(nodes, axis=1)[:, None]
    return position, triangles.reshape(-1, 3)


def test_a_fluid_in_half_a_ball_needs_no_caps(tmp_path):
    mesh = 'imported {{ file "{}.obj" in mm; merging is off }}'.format
    order = "preserve volume of ball with 1 MPa; inflate ball to {} ml"
    write_obj(tmp_path / "whole.obj", *octants((1, -1)))
    write_obj(tmp_path / "half.obj", *octants((1,)))
    one = ball_scene(tmp_path, "one", mesh("whole"), order.format(5))
    with tissuec.run(one, companion="off") as run:
        wanted = [run.logs[f"{what} of ball"].value[-1] for what in LOGGED]
    planes = "symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)"
    other = ball_scene(tmp_path, "other", mesh("half"), order.format(2.5), planes=planes)
    with tissuec.run(other, companion="off") as run:
        found = [run.logs[f"{what} of ball"].value[-1] for what in LOGGED]
    assert found[0] == pytest.approx(wanted[0], rel=1e-6)
    assert 2.0 * found[1] == pytest.approx(wanted[1], rel=1e-9)
    closed = ball_scene(
        tmp_path, "closed", mesh("half"), "press ball with 1 kPa with caps", planes=planes
    )
    with pytest.raises(tissuec.CompileError, match="closed, together with its mirror image"):
        tissuec.compile(closed)


def test_caps_of_parts_are_refused_between_parallel_planes():
    half = "  symmetric about plane through (0, 0, {}) mm facing (0, 0, {})"
    both = network_of("quarter", others=half.format(11, -1))
    assert len(faces_within(both).planes) == 3
    closed_by_caps(both, "artery", faces_within(both))
    held = network_of("eighth", others=half.format(11, -1))
    assert faces_within(held).planes == ()
    with pytest.raises(NoSide, match="two parallel planes"):
        closed_by_caps(held, "artery", faces_within(held))
