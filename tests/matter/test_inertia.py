"""Masses of solids against second moments of mass in closed form."""

import numpy as np
import pytest

import tissuec
from tests.forces.test_elements import mesh
from tests.forces.test_solid_meshes import MESHES, grid
from tests.imports.organs import write_vtk
from tissuec.geometry.elements import SHAPES
from tissuec.geometry.moments import moments
from tissuec.meshes.elements import node_shares

SCENE = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body piece {{ mesh is {mesh}
  tissue is gel; made of elements; {more} }}
environment {{ gravity = (0, 0, 0) m/s^2 {planes} }}
simulate {{ duration = 1 ms }}
"""


def net(mesh, more="", planes=""):
    return tissuec.compile(SCENE.format(mesh=mesh, more=more, planes=planes)).network


def box(cell, low, high):
    return f"lattice {{ cell = {cell} mm; box from {low} mm to {high} mm }}"


def second(network, about):
    """Return Σ m x ⊗ x about a point [kg m²], shape (3, 3)."""
    arm = network.position - about
    return (arm.T * network.mass) @ arm


@pytest.mark.parametrize("cell", [2.5, 2.0, 1.25])
def test_a_box_turns_as_it_does_with_any_number_of_cells_from_four(cell):
    network = net(box(cell, (0, 0, 0), (20, 10, 10)))
    assert network.mass.sum() == pytest.approx(2e-3, rel=1e-13)
    centre = np.array([10e-3, 5e-3, 5e-3])
    np.testing.assert_allclose(network.mass @ network.position, 2e-3 * centre, rtol=1e-12)
    due = 2e-3 * np.diag([20e-3, 10e-3, 10e-3]) ** 2 / 12.0
    np.testing.assert_allclose(second(network, centre), due, rtol=1e-11, atol=1e-20)
    assert network.mass.min() > 0.0


def test_two_cells_of_a_plate_have_simpsons_weights():
    # Nodes at -1, 0 and 1 integrate squares by 1/6, 4/6 and 1/6 alone. Across one cell, nothing
    # can be done, and along eight p is nearly a number.
    network = net(box(5, (0, 0, 0), (300, 5, 10)))
    inner = (network.position[:, 0] > 0.12) & (network.position[:, 0] < 0.18)
    mass = np.where(np.abs(network.position[:, 2] - 5e-3) < 1e-9, 4.0, 1.0)
    due = 1000.0 * 5e-3 * 5e-3 * 10e-3 / 12.0 * mass
    np.testing.assert_allclose(network.mass[inner], due[inner], rtol=2e-3)


def test_quadratic_elements_have_their_moments_anyway():
    text = SCENE.format(mesh=box(10, (0, 0, 0), (20, 10, 10)), more="", planes="")
    network = tissuec.compile(text.replace("of elements", "of quadratic elements")).network
    np.testing.assert_allclose(network.weighing, 1.0, rtol=1e-9)
    due = 2e-3 * np.diag([20e-3, 10e-3, 10e-3]) ** 2 / 12.0
    centre = np.array([10e-3, 5e-3, 5e-3])
    np.testing.assert_allclose(second(network, centre), due, rtol=1e-11, atol=1e-20)


def test_few_cells_keep_half_of_their_lumped_masses():
    for cell, parts in ((5, (0.5, 0.75)), (10 / 3, (0.75, 1.0))):
        network = net(box(cell, (0, 0, 0), (10, 10, 10)))
        assert (network.mass * 0.5 * network.weighing <= network.mass + 1e-15).all()
        found, lumped = second(network, np.full(3, 5e-3))[0, 0], 1.0 + 2.0 * (cell / 10) ** 2
        made = (lumped - found / (1e-3 * 10e-3**2 / 12.0)) / (lumped - 1.0)
        assert parts[0] - 1e-9 < made < parts[1] + 1e-9


def irregular(folder):
    x, cells = grid(4, 0.15)
    write_vtk(folder / "cubes.vtk", x, cells)
    return 'imported { file "cubes.vtk" in mm }'


def wedges(folder):
    x, cells = grid(4, 0.1)
    halves = [cells[:, [0, 1, 2, 4, 5, 6]], cells[:, [0, 2, 3, 4, 6, 7]]]
    write_vtk(folder / "wedges.vtk", x, np.concatenate(halves))
    return 'imported { file "wedges.vtk" in mm }'


@pytest.mark.parametrize(
    "drawn", [irregular, wedges, MESHES["tetrahedra"], MESHES["filled surface"]]
)
def test_any_cells_have_the_moments_of_the_bar(drawn, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    network = net(drawn(tmp_path))
    sides = np.array([60e-3, 10e-3, 10e-3])
    due = 6e-3 * np.diag(sides) ** 2 / 12.0
    np.testing.assert_allclose(network.mass.sum(), 6e-3, rtol=1e-12)
    np.testing.assert_allclose(second(network, sides / 2.0), due, rtol=1e-10, atol=1e-17)


def test_every_section_of_a_bar_turns_as_it_does():
    network = net(box(2.5, (0, 0, 0), (60, 10, 10)))
    square = ((network.position[:, 1:] - 5e-3) ** 2).sum(axis=1)
    layer = np.rint(network.position[:, 0] / 2.5e-3).astype(int)
    turning = np.bincount(layer, network.mass * square)
    mass = np.bincount(layer, network.mass)
    due = 2.0 * 10e-3**2 / 12.0
    # Ends have less mass: moments along the bar are exact, too.
    np.testing.assert_allclose(turning / mass, due, rtol=0.01)
    np.testing.assert_allclose(mass[1:-1], 1000.0 * 2.5e-3 * 10e-3**2, rtol=0.01)


def test_the_published_twisting_column_has_its_energy():
    # J. Bonet, A. J. Gil, R. Ortigosa, Comput. Meth. Appl. Mech. Eng. 283:1061, 2015: a column
    # of 1 x 1 x 6 that turns about its axis with 105 sin(π z/12) per second.
    for across, tolerance in ((2, 0.15), (4, 0.01), (8, 1e-3)):
        network = net(box(1e3 / across, (-500, -500, 0), (500, 500, 6000)))
        x, y, z = network.position.T
        rate = 105.0 * np.sin(np.pi * z / 12.0)
        found = 0.5 * network.mass @ (rate**2 * (x**2 + y**2))
        due = 0.5 * 1000.0 * 105.0**2 * 3.0 / 6.0  # ∫ sin² over the length is 3
        assert found == pytest.approx(due, rel=tolerance), across


def test_one_cell_across_keeps_its_mass_and_its_centre():
    # Where x² is the same at all nodes, their masses cannot change its mean.
    network = net(box(2.5, (0, 0, 0), (10, 10, 2.5)))
    centre = np.array([5e-3, 5e-3, 1.25e-3])
    np.testing.assert_allclose(network.mass.sum(), 2.5e-4, rtol=1e-12)
    found = second(network, centre)
    due = 2.5e-4 * np.diag([10e-3**2 / 12.0, 10e-3**2 / 12.0, 2.5e-3**2 / 4.0])
    np.testing.assert_allclose(found, due, rtol=1e-10, atol=1e-20)


def test_a_half_has_the_masses_of_half_the_whole():
    plane = "; symmetric about plane through (0, 0, 0) mm facing ({0}, {1}, 0)"
    whole = net(box(2.5, (-5, -5, 0), (5, 5, 10)))
    part = net(box(2.5, (0, 0, 0), (5, 5, 10)), planes=plane.format(1, 0) + plane.format(0, 1))
    inside = (whole.position[:, :2] > -1e-9).all(axis=1)
    place, mass = whole.position[inside], whole.mass[inside]
    mass = mass / 2.0 ** (np.abs(place[:, :2]) < 1e-9).sum(axis=1)
    found, due = (np.lexsort(np.round(one, 9).T) for one in (part.position, place))
    np.testing.assert_allclose(part.mass[found], mass[due], rtol=1e-11)


def test_a_plane_that_a_body_does_not_reach_leaves_its_masses():
    plane = "; symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)"
    away = box(2.5, (5, 0, 0), (15, 10, 10))
    scene = SCENE.format(mesh=away, more="", planes=plane)
    scene += f"body other {{ mesh is {box(2, (0, 0, 0), (4, 4, 4))}; tissue is gel }}"
    found = tissuec.compile(scene).network
    part = next(one for one in found.bodies if one.name == "piece")
    np.testing.assert_allclose(found.mass[part.nodes], net(away).mass, rtol=1e-11)


def test_regions_of_other_density_count():
    more = "region core where x > 10 mm { tissue is bone }"
    scene = SCENE.format(mesh=box(2.5, (0, 0, 0), (20, 10, 10)), more=more, planes="")
    bone = "tissue bone like gel { density = 2000 kg/m^3 }"
    network = tissuec.compile(f"{scene}{bone}").network
    mass, middles = np.array([1e-3, 2e-3]), np.array([[5e-3, 5e-3, 5e-3], [15e-3, 5e-3, 5e-3]])
    np.testing.assert_allclose(network.mass.sum(), 3e-3, rtol=1e-12)
    np.testing.assert_allclose(network.mass @ network.position, mass @ middles, rtol=1e-11)
    cube = np.eye(3) * 10e-3**2 / 12.0
    due = sum(m * (cube + np.outer(c, c)) for m, c in zip(mass, middles, strict=True))
    np.testing.assert_allclose(second(network, np.zeros(3)), due, rtol=1e-11)


def test_each_piece_of_a_body_keeps_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x, cells = grid(2, 0.0)
    far = x + np.array([0.0, 40.0, 0.0])
    every = np.concatenate([x, far]), np.concatenate([cells, cells + len(x)])
    write_vtk(tmp_path / "bars.vtk", *every)
    network = net('imported { file "bars.vtk" in mm }')
    alone = net(box(5, (0, 0, 0), (60, 10, 10)))
    order = np.lexsort(np.round(alone.position, 9).T)
    for shift in (0.0, 40e-3):
        own = np.abs(network.position[:, 1] - shift - 5e-3) < 6e-3
        place = network.position[own] - np.array([0.0, shift, 0.0])
        found = network.mass[own][np.lexsort(np.round(place, 9).T)]
        np.testing.assert_allclose(found, alone.mass[order], rtol=1e-10)


def test_a_written_mass_is_distributed_in_the_same_way():
    cube = box(2.5, (0, 0, 0), (10, 10, 10))
    found, due = net(cube, "mass = 3 g").mass, net(cube).mass
    np.testing.assert_allclose(found, 3.0 * due, rtol=1e-12)


def test_irregular_cells_keep_positive_masses(tmp_path, monkeypatch):
    # Few cells that are this irregular cannot turn as the body does with masses above half of
    # the lumped ones; what they can is closer to it than these.
    monkeypatch.chdir(tmp_path)
    position, cells = mesh("hexahedron", cells=2, displaced=0.0)
    position += 0.002 * np.random.default_rng(3).uniform(-1.0, 1.0, position.shape)
    write_vtk(tmp_path / "rough.vtk", 1e3 * position, cells)
    network = net('imported { file "rough.vtk" in mm }')
    volume = node_shares(SHAPES["hexahedron"], position[cells])
    lumped = 1e3 * np.bincount(cells.ravel(), volume.ravel())
    assert (network.mass >= 0.5 * lumped).all()
    total = [each.sum(axis=0) for each in moments("hexahedron", position[cells])]
    np.testing.assert_allclose(network.mass.sum(), 1e3 * total[0], rtol=1e-12)
    np.testing.assert_allclose(network.mass @ network.position, 1e3 * total[1], rtol=1e-11)
    left = np.abs(second(network, np.zeros(3)) - 1e3 * total[2]).max()
    before = np.abs(np.einsum("n,ni,nj", lumped, position, position) - 1e3 * total[2]).max()
    assert 0.2 * before < left < 0.9 * before


def test_weights_are_consistent_with_the_functions_of_the_place():
    network = net(box(2.5, (0, 0, 0), (10, 10, 10)))
    ends = (np.abs(network.position - 5e-3) > 4.9e-3).sum(axis=1)
    np.testing.assert_allclose(
        network.mass * network.weighing, 1e-3 / 64.0 / 2.0**ends, rtol=1e-12
    )
