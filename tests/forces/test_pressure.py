"""Prescribed pressure against volumes, quadrature, differences and the reference."""

import numpy as np
import pytest

from tests.derivatives import agree, forces, matrix_follows_from_forces, slopes
from tests.validate.scenes import compiled_scene
from tissuec.forces.enclosed.pressed_faces import FORMS, faces_of
from tissuec.forces.enclosed.pressed_sides import NoSide, Pressed, closed_by_caps, pressed_faces
from tissuec.forces.enclosed.pressure import SurfacePressure
from tissuec.forces.enclosed.volume import Enclosure
from tissuec.model.profiles import TimeProfile
from tissuec.validate.forces.pressure import PressedSkin

STEADY = TimeProfile("constant", 0.0, np.inf)
PRESSURE = 3e3  # [Pa]
TISSUE = "Young's modulus = 100 kPa; density = 1000 kg/m^3"
TUBE = "axis from (1, 2, 3) mm to (4, 7, 33) mm; radius = 5 mm; rings = 5; sides = 7"
BODIES = {
    "ball": "mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }\n"
    "  thickness = 1 mm",
    "tube": f"mesh is tube {{ {TUBE} }}\n  thickness = 1 mm",
    "sheet": "mesh is sheet { corner = (0, 0, 0) mm; first edge = (9, 0, 0) mm\n"
    "  second edge = (0, 9, 0) mm; columns = 4; rows = 4 }\n  thickness = 1 mm",
    "block": "mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 15) mm }",
}


def network_of(*names):
    bodies = "\n".join(
        f"body {name} {{ tissue is flesh\n  {BODIES[name]}\n}}" for name in names
    )
    return compiled_scene(
        f"language 1\ntissue flesh {{ {TISSUE} }}\n{bodies}\n"
        "environment { gravity = (0, 0, 0) m/s^2 }\nsimulate { duration = 1 ms }\n"
    ).network


def pressure_on(network, name, *, caps=False, where=None, inside=False, along=None):
    part = next(body for body in network.bodies if body.name == name)
    nodes = np.arange(part.nodes.start, part.nodes.stop)
    if where is not None:
        nodes = nodes[where(network.position[nodes])]
    faces = pressed_faces(network, Pressed(name, nodes, inside, along))
    span = part.span
    return SurfacePressure.of("key", name, faces, PRESSURE, STEADY, span, has_caps=caps)


def shaken(network, size=2e-3, seed=3):
    return network.position + size * np.random.default_rng(seed).normal(
        size=network.position.shape
    )


@pytest.mark.parametrize(("name", "caps"), [("ball", False), ("tube", True), ("block", False)])
def test_forces_and_matrix_of_a_closed_surface_follow_from_its_volume(name, caps):
    network = network_of(name)
    field, position = pressure_on(network, name, caps=caps), shaken(network)
    found, nodes = forces(field, position), range(0, len(position), 3)
    by_volume = slopes(lambda x: field.potential(0.0, x), position, nodes, 1e-7)
    np.testing.assert_allclose(found[nodes], by_volume, atol=1e-7 * np.abs(found).max())
    assert np.abs(found.sum(axis=0)).max() < 1e-12 * np.abs(found).max()
    count = len(position)
    matrix = field.slopes(0.0, position, np.arange(count), count).toarray()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-13 * np.abs(matrix).max())
    matrix_follows_from_forces(field, position, matrix, every=17, step=1e-6, allowed=1e-7)


def test_pressure_of_a_closed_wall_is_that_of_an_enclosed_volume():
    network = network_of("ball")
    field = pressure_on(network, "ball")
    kept = Enclosure.of(network, "ball", 1.0, field.span)
    position = shaken(network)
    swollen = kept.swollen(PRESSURE + float(kept.volumes(position)[0] / kept.drawn[0]) - 1.0,
                           STEADY)  # fmt: skip
    assert swollen.pressures(0.0, position) == pytest.approx(PRESSURE)
    np.testing.assert_allclose(forces(field, position), forces(swollen, position), rtol=1e-9,
                               atol=1e-12)  # fmt: skip
    assert field.volume(position) == pytest.approx(kept.volumes(position)[0])


def test_a_wall_is_pushed_outwards_and_a_solid_inwards_however_triangles_are_listed():
    network = network_of("ball", "block")
    for name, sign in (("ball", 1.0), ("block", -1.0)):
        field = pressure_on(network, name)
        pushed = forces(field, network.position)
        nodes = np.unique(field.faces.corners)
        outwards = network.position[nodes] - network.position[nodes].mean(axis=0)
        along = np.einsum("nk,nk->n", pushed[nodes], outwards)
        assert (sign * along > 0.0).all()


def test_a_solid_is_pushed_inwards_whatever_it_is_made_of():
    tube = "axis from (0, 0, 0) mm to (0, 0, 20) mm; inner radius = 3 mm; outer radius = 5 mm"
    for tissue in (TISSUE, "spring constant = 10 N/m; density = 1000 kg/m^3"):
        network = compiled_scene(
            f"language 1\ntissue flesh {{ {tissue}; retardation time = 1 ms }}\n"
            "body duct { tissue is flesh\n"
            f"  mesh is thick tube {{ {tube}; rings = 9; sides = 12 }} }}\n"
            "environment { gravity = (0, 0, 0) m/s^2 }\nsimulate { duration = 1 ms }\n"
        ).network
        found, x = forces(pressure_on(network, "duct"), network.position), network.position
        outer = np.hypot(x[:, 0], x[:, 1]) > 4.9e-3
        assert (found * x)[outer, :2].sum(axis=1).max() < 0.0


def test_an_open_tube_pushes_no_cap_and_its_matrix_is_the_symmetric_part():
    network = network_of("tube")
    open_tube, capped = (pressure_on(network, "tube", caps=caps) for caps in (False, True))
    assert open_tube.openings.count == 2 and capped.caps.count == 2
    position, count = shaken(network, 1e-4), network.node_count
    difference = forces(open_tube, position) - forces(capped, position)
    rims = np.unique(open_tube.openings.nodes)
    np.testing.assert_allclose(np.delete(difference, rims, axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(open_tube.wayward(0.0, position), difference, atol=1e-12)
    assert capped.wayward(0.0, position) is None
    # A cap of a ring of 7 sides, at right angles to the axis.
    area = 3.5 * np.sin(2.0 * np.pi / 7.0) * 5e-3**2
    drawn = forces(open_tube, network.position) - forces(capped, network.position)
    assert np.linalg.norm(drawn[:7].sum(axis=0)) == pytest.approx(PRESSURE * area, rel=1e-9)
    whole = open_tube.slopes(0.0, position, np.arange(count), count).toarray()
    assert np.abs(whole - whole.T).max() > 0.1 * np.abs(whole).max()
    matrix = open_tube.matrix(0.0, position, np.arange(count), count).toarray()
    np.testing.assert_allclose(matrix, 0.5 * (whole + whole.T), atol=1e-15)
    # With its rims held, it is symmetric.
    number = np.arange(count) - 7
    number[-7:] = -1
    number[:7] = -1
    kept = open_tube.slopes(0.0, position, number, count - 14).toarray()
    np.testing.assert_allclose(kept, kept.T, atol=1e-13 * np.abs(whole).max())


@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("ball", {}), ("tube", {}), ("tube", {"caps": True}), ("block", {}),
        ("block", {"where": lambda x: x[:, 2] > 14e-3}),
        ("tube", {"where": lambda x: x[:, 2] > 12e-3, "caps": True}),
        ("sheet", {"along": np.array([0.0, 0.0, 1.0])}),
    ],
)  # fmt: skip
def test_forces_power_potential_and_matrix_are_those_of_the_reference(name, more):
    network = network_of(name)
    field, position = pressure_on(network, name, **more), shaken(network, 1e-3)
    velocity, reference = shaken(network, 1.0, 9), PressedSkin(field)
    agree(
        field, reference, position, velocity, force=1e-12, matrix=1e-12, energy=1e-12,
        lost=1e-12,
    )  # fmt: skip
    supplied = field.powers(0.0, position, velocity)[0]
    assert supplied == pytest.approx(np.vdot(forces(field, position), velocity))
    assert supplied == pytest.approx(reference.pumping(0.0, position, velocity))
    potential = reference.potential(0.0, position)
    assert field.potential(0.0, position) == pytest.approx(potential, rel=1e-9)
    wayward = field.wayward(0.0, position)
    np.testing.assert_allclose(
        reference.wayward(0.0, position), 0.0 if wayward is None else wayward, atol=1e-9
    )


def quadrature(nodes):
    """Return shape functions and slopes at points of a face, and weights of the points."""
    if nodes == 4:
        at = 0.5 + np.array([-1.0, 1.0]) / np.sqrt(12.0)
        s, t = (each.ravel() for each in np.meshgrid(at, at))
        value = [(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t]
        slopes_s = [t - 1, 1 - t, t, -t]
        slopes_t = [s - 1, -s, s, 1 - s]
        return (np.array(each).T for each in (value, slopes_s, slopes_t)), np.full(4, 0.25)
    # Exact to the fifth degree (P. Hammer, A. Stroud, 1956).
    root = np.sqrt(15.0)
    a, b = (6.0 - root) / 21.0, (6.0 + root) / 21.0
    s = np.array([1 / 3, a, 1 - 2 * a, a, b, 1 - 2 * b, b])
    t = np.array([1 / 3, a, a, 1 - 2 * a, b, b, 1 - 2 * b])
    weight = np.repeat([9 / 80, (155 - root) / 2400, (155 + root) / 2400], [1, 3, 3])
    corner, by_s, by_t = np.array([1 - s - t, s, t]), [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]
    value, slope_s, slope_t = [], [], []
    for k in range(3):
        value.append(corner[k] * (2 * corner[k] - 1))
        slope_s.append((4 * corner[k] - 1) * by_s[k])
        slope_t.append((4 * corner[k] - 1) * by_t[k])
    for i, j in ((0, 1), (1, 2), (2, 0)):
        value.append(4 * corner[i] * corner[j])
        slope_s.append(4 * (corner[i] * by_s[j] + corner[j] * by_s[i]))
        slope_t.append(4 * (corner[i] * by_t[j] + corner[j] * by_t[i]))
    return (np.array(each).T for each in (value, slope_s, slope_t)), weight


@pytest.mark.parametrize(("count", "nodes"), [(2, 4), (4, 6)])
def test_weights_give_the_volume_and_the_forces_of_shape_functions(count, nodes):
    form, weight = FORMS[count]
    (value, by_s, by_t), points = quadrature(nodes)
    x = np.random.default_rng(2).normal(size=(nodes, 3))
    push = points[:, None] * np.cross(by_s @ x, by_t @ x)
    volume = np.einsum("qk,qk->", value @ x, push) / 3.0
    assert weight @ np.linalg.det(x[form]) / 6.0 == pytest.approx(volume, rel=1e-12)
    # Sides of faces that are straight: the forces of finite elements, corner by corner.
    if nodes == 6:
        x[3:] = 0.5 * (x[[0, 1, 2]] + x[[1, 2, 0]])
        push = points[:, None] * np.cross(by_s @ x, by_t @ x)
    found = np.zeros((nodes, 3))
    a, b, c = x[form].swapaxes(0, 1)
    each = weight[:, None] * np.cross(b - a, c - a) / 6.0
    for corner in form.T:
        np.add.at(found, corner, each)
    np.testing.assert_allclose(found, value.T @ push, atol=1e-14)


def test_faces_of_solids_are_those_of_their_elements():
    network = network_of("block")
    faces = faces_of(network, np.arange(len(network.skin)))
    assert faces.triples.count == len(network.skin) // 2
    assert (np.diff(faces.triples.first) == 4).all()
    half = faces_of(network, np.arange(1, len(network.skin)))
    assert half.triples.count == len(network.skin) // 2


def test_a_torn_face_is_not_pressed_and_its_cap_is_lost():
    network = network_of("tube")
    field = pressure_on(network, "tube", caps=True)
    alive = np.ones(network.entity_count, dtype=bool)
    assert field.intact(alive) is field
    ends = network.line_ends
    alive[np.flatnonzero((ends == [0, 1]).all(axis=1))] = False
    torn = field.intact(alive)
    assert torn.caps.count == 1 and torn.faces.triples.count < field.faces.triples.count
    position = shaken(network, 1e-4)
    left = np.arange(len(field.items(np.arange(99)).first) - 1)
    left = np.delete(left, field.lost_items(alive))
    np.testing.assert_allclose(
        forces(torn, position), forces(field.only(left), position), atol=1e-15
    )
    by_potential = slopes(lambda x: torn.potential(0.0, x), position, range(35), 1e-7)
    given = forces(torn, position) - torn.wayward(0.0, position)
    np.testing.assert_allclose(given, by_potential, atol=1e-7 * np.abs(given).max())


def test_a_sheet_has_no_inside_and_a_direction_says_where_it_is_pushed():
    network = network_of("sheet")
    with pytest.raises(NoSide, match="encloses no space") as flat:
        pressure_on(network, "sheet")
    assert "along" in flat.value.hint
    for sign in (1.0, -1.0):
        field = pressure_on(network, "sheet", along=np.array([0.1, 0.0, sign]))
        total = forces(field, network.position).sum(axis=0)
        assert total == pytest.approx([0.0, 0.0, sign * PRESSURE * 81e-6])
    with pytest.raises(NoSide, match="as much along this direction"):
        pressure_on(network, "sheet", along=np.array([1.0, 0.0, 0.0]))


def test_caps_close_single_loops_only():
    network = network_of("ball", "tube")
    ball = pressure_on(network, "ball")
    with pytest.raises(NoSide, match="ball is closed"):
        closed_by_caps(network, "ball", ball.faces)
    tube = pressure_on(network, "tube")
    closed_by_caps(network, "tube", tube.faces)
    crossed = tube.faces.some(np.array([0, 1, 16, 17]))
    corners = tube.faces.corners
    apart = next(
        face
        for face in range(2, len(corners))
        if len(np.intersect1d(corners[0], corners[face])) == 1
    )
    crossed = tube.faces.some(np.array([0, apart]))
    with pytest.raises(NoSide, match="4 edges of its rim meet at the node"):
        closed_by_caps(network, "tube", crossed)
