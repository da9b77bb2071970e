"""The tube: the published counts, the crossed springs, any direction of the axis."""

import numpy as np
import pytest

from tests.every import every
from tissuec.meshes.generators.centreline import perpendicular_frame
from tissuec.meshes.generators.tube import Tube

AXIS = (np.zeros(3), np.array([0.064, 0.0, 0.0]))


def tube(**entries):
    return Tube(**{"axis": AXIS, "radius": 0.003, "rings": 16, "sides": 10} | entries)


@pytest.mark.parametrize("options", [{"interior": "crossed"}, {"diagonals": "both"}])
def test_sixteen_rings_of_ten_have_the_published_counts(options):
    mesh = tube(**options).build()
    assert (len(mesh.position), len(mesh.ends)) == (160, 610)
    assert tube(**options).size() == (160, 610)


@pytest.mark.parametrize(
    ("sides", "steps"), [(6, (2, 4)), (7, (2, 5)), (9, (3, 6)), (10, (4, 6)), (11, (4, 7))]
)
def test_crossed_springs_run_to_the_documented_sides_of_the_next_ring(sides, steps):
    plain = {tuple(pair) for pair in tube(sides=sides).build().ends.tolist()}
    mesh = tube(sides=sides, interior="crossed").build()
    expected = {
        (sides * ring + side, sides * (ring + 1) + (side + further) % sides)
        for ring in range(15)
        for side in range(sides)
        for further in steps
    }
    assert {tuple(pair) for pair in mesh.ends.tolist()} - plain == expected


@every("sides", range(6, 14))
def test_crossed_springs_pass_through_the_inside(sides):
    """No crossed spring lies in the wall: its middle is nearer to the axis than the faces."""
    plain = {tuple(pair) for pair in tube(sides=sides, diagonals="both").build().ends.tolist()}
    mesh = tube(sides=sides, interior="crossed").build()
    added = np.array([pair for pair in mesh.ends.tolist() if tuple(pair) not in plain])
    assert len(added) == 2 * 15 * sides
    middle = mesh.position[added].mean(axis=1)
    apothem = 0.003 * np.cos(np.pi / sides)
    assert np.linalg.norm(middle[:, 1:], axis=1).max() < 0.9 * apothem


@pytest.mark.parametrize(("sides", "per_ring"), [(4, 2), (10, 5), (5, 5), (7, 7)])
def test_spokes_join_opposite_nodes(sides, per_ring):
    mesh = tube(sides=sides, interior="spokes", rings=2).build()
    lengths = np.linalg.norm(np.diff(mesh.position[mesh.ends], axis=1)[:, 0], axis=1)
    in_ring = mesh.ends[:, 0] // sides == mesh.ends[:, 1] // sides
    longest = 0.006 * np.sin(np.pi * (sides // 2) / sides)
    assert np.isclose(lengths[in_ring], longest, rtol=1e-12).sum() == 2 * per_ring


@pytest.mark.parametrize(
    ("options", "entry"),
    [
        ({"interior": "crossed", "sides": 5}, "sides"),
        ({"interior": "spokes", "sides": 3}, "sides"),
        ({"axis": (AXIS[1], AXIS[1])}, "axis"),
    ],
)
def test_impossible_tubes_are_refused_by_entry(options, entry):
    with pytest.raises(ValueError, match=f'"{entry}"'):
        tube(**options)


DIRECTIONS = [
    *np.eye(3),
    *-np.eye(3),
    np.ones(3),
    np.array([1.0, 1.0, 0.0]),
    np.array([1e-9, 0.0, 1.0]),
    np.array([1e-200, 1e-200, -1e-200]),
    np.array([1e200, 0.0, 3e200]),
]


@pytest.mark.parametrize("direction", DIRECTIONS, ids=str)
def test_the_frame_is_right_handed_and_orthonormal_for_any_direction(direction):
    across, upward = perpendicular_frame(direction)
    scaled = direction / np.abs(direction).max()
    frame = np.stack((across, upward, scaled / np.linalg.norm(scaled)))
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-14)
    assert np.linalg.det(frame) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize(
    "direction", [*np.eye(3), np.ones(3), np.array([1.0, -2.0, 0.5])], ids=str
)
def test_nodes_keep_their_distance_from_the_axis_and_rings_their_spacing(direction):
    unit = direction / np.linalg.norm(direction)
    start = np.array([0.5, -0.2, 0.1])
    position = tube(axis=(start, start + 0.06 * unit)).build().position - start
    along = position @ unit
    assert along == pytest.approx(np.repeat(np.linspace(0.0, 0.06, 16), 10), abs=1e-15)
    off = np.linalg.norm(position - along[:, None] * unit, axis=1)
    assert off == pytest.approx(0.003, rel=1e-12)


def test_the_wall_faces_outwards_and_is_cut_along_the_single_diagonals():
    mesh = tube(diagonals="one").build()
    a, b, c = mesh.position[mesh.skin].transpose(1, 0, 2)
    normal, middle = np.cross(b - a, c - a), (a + b + c) / 3.0
    assert (np.einsum("ti,ti->t", normal[:, 1:], middle[:, 1:]) > 0.0).all()
    assert len(mesh.skin) == 2 * 15 * 10
    drawn = {tuple(pair) for pair in mesh.ends.tolist()}
    edges = np.sort(mesh.skin[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert {tuple(edge) for edge in edges.tolist()} == drawn
