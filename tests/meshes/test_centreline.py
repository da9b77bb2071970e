"""Meshes along curves: volumes by Pappus, frames without twist, and what would intersect."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.every import every
from tissuec.geometry.edges import volume
from tissuec.geometry.elements import SHAPES, Measures
from tissuec.meshes.generators.centreline import Centreline, natural_spline
from tissuec.meshes.generators.round_solids import Cylinder, ThickTube
from tissuec.meshes.generators.tube import Tube

BEND, INNER, OUTER = 0.04, 0.004, 0.008
ANGLE = np.linspace(0.0, np.pi / 2.0, 17)
ARC = tuple(BEND * np.stack([np.sin(ANGLE), 1.0 - np.cos(ANGLE), 0.0 * ANGLE], axis=1))
#: Three pieces with two square corners, in space.
STAIRS = tuple(0.03 * np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1]]))


def thick(**entries):
    usual = {"axis": ARC, "inner_radius": INNER, "outer_radius": OUTER}
    return ThickTube(**usual | {"rings": 17, "sides": 16} | entries)


def test_the_spline_is_the_natural_one_of_scipy():
    points = np.random.default_rng(2).normal(size=(6, 3))
    knots = np.cumsum([0.0, 1.0, 0.4, 2.0, 0.7, 1.1])
    at = np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in pairwise(knots)])
    spline = CubicSpline(knots, points, bc_type="natural")
    found = natural_spline(knots, points, 8)
    for derivative, values in enumerate(found):
        expected = spline(np.append(at, knots[-1]), derivative)
        assert values == pytest.approx(expected, abs=1e-12)


def test_the_volume_of_a_bent_wall_tends_to_that_of_pappus_with_the_second_order():
    exact = np.pi * (OUTER**2 - INNER**2) * BEND * np.pi / 2.0
    errors = np.array([
        thick(rings=2 * n + 1, sides=2 * n).build_elements().volume.sum() / exact - 1.0
        for n in (4, 8, 16)
    ])  # fmt: skip
    assert (errors < 0.0).all()
    assert errors[:-1] / errors[1:] == pytest.approx(4.0, rel=0.1)


def test_the_volume_inside_of_a_bent_tube_tends_to_that_of_pappus():
    exact, errors = np.pi * OUTER**2 * BEND * np.pi / 2.0, []
    for n in (8, 16, 32):
        mesh = Tube(axis=ARC, radius=OUTER, rings=n, sides=n).build()
        ends = []
        for name, sign in (("first end", -1), ("last end", 1)):
            ring = mesh.groups[name]
            fan = np.stack([np.full(n - 2, ring[0]), ring[1:-1], ring[2:]], axis=1)
            ends.append(fan[:, ::sign])
        errors.append(volume(mesh.position, np.concatenate([mesh.skin, *ends])) / exact - 1.0)
    assert np.divide(errors[:-1], errors[1:]) == pytest.approx(4.0, rel=0.2)


def test_a_mitred_wall_has_exactly_the_volume_of_its_polygon():
    """Pieces are prisms with slanted ends: a round section times the length of the axis."""
    mesh = thick(axis=STAIRS, bends="sharp", rings=7).build_elements()
    section = np.pi * (OUTER**2 - INNER**2)
    assert mesh.volume.sum() == pytest.approx(section * 0.09, rel=1e-12)


def test_a_bent_cylinder_has_the_volume_of_pappus():
    exact = np.pi * OUTER**2 * BEND * np.pi / 2.0
    errors = [
        Cylinder(axis=ARC, radius=OUTER, cell=OUTER / n).build_elements().volume.sum() / exact
        for n in (2, 4, 8)
    ]
    assert np.divide(1.0 - np.array(errors[:-1]), 1.0 - np.array(errors[1:])) == pytest.approx(
        3.9, rel=0.1
    )


@pytest.mark.parametrize(
    "tube",
    [
        thick(),
        thick(axis=STAIRS, bends="sharp", rings=7),
        thick(axis=STAIRS, rings=33, inner_radius=0.002, outer_radius=0.005),
        thick(end_inner_radius=0.001, end_outer_radius=0.002),
        Cylinder(axis=ARC, radius=0.006, end_radius=0.002, cell=0.002),
    ],
    ids=["arc", "stairs", "through stairs", "tapered", "horn"],
)
def test_every_element_is_upright_at_all_of_its_points(tube):
    mesh = tube.build_elements()
    (cells,) = mesh.elements
    sizes = Measures.of(SHAPES[cells.shape], mesh.position[cells.nodes]).volume
    assert (sizes > 0.1 * sizes.mean()).all()


def test_rings_do_not_twist_about_a_helix():
    """Against the frame of Frenet, they turn back by the integral of the torsion."""
    radius, rise, turns = 0.03, 0.01, 1.5
    t = np.linspace(0.0, 2.0 * np.pi * turns, 121)
    points = np.stack([radius * np.cos(t), radius * np.sin(t), rise * t], axis=1)
    rings = Centreline(tuple(points)).rings(241, 0.001, 0.001)
    speed = np.hypot(radius, rise)
    inner = slice(20, -20)  # natural ends have no curvature

    def angle(k):
        at = np.arctan2(rings.centre[k, 1], rings.centre[k, 0])
        normal = -np.array([np.cos(at), np.sin(at), 0.0])
        tangent = np.array([-radius * np.sin(at), radius * np.cos(at), rise]) / speed
        return np.arctan2(
            rings.across[k, 0] @ np.cross(tangent, normal), rings.across[k, 0] @ normal
        )

    angles = np.unwrap([angle(k) for k in range(241)[inner]])
    length = rings.share[inner] * Centreline(tuple(points)).length
    torsion = rise / speed**2
    assert np.diff(angles) / np.diff(length) == pytest.approx(-torsion, rel=2e-3)


def test_frames_are_right_handed_and_across_the_axis():
    rings = Centreline(ARC).rings(9, OUTER, OUTER)
    tangent = np.cross(rings.across[:, 0], rings.across[:, 1])
    chord = rings.centre[2:] - rings.centre[:-2]
    chord /= np.linalg.norm(chord, axis=1)[:, None]
    assert np.einsum("rk,rk->r", tangent[1:-1], chord) == pytest.approx(1.0, abs=1e-3)
    assert np.linalg.norm(tangent, axis=1) == pytest.approx(1.0, abs=1e-12)


def test_a_list_of_points_in_a_row_draws_the_straight_tube():
    ends = np.zeros(3), np.array([0.06, 0.0, 0.0])
    row = tuple(np.linspace(*ends, 4))
    entries = {"radius": 0.003, "rings": 7, "sides": 8, "end_radius": 0.002}
    straight, through = (Tube(axis=axis, **entries).build() for axis in (ends, row))
    assert through.position == pytest.approx(straight.position, abs=1e-12)
    assert np.array_equal(through.ends, straight.ends)


def test_groups_are_the_rings_at_both_ends():
    mesh = Tube(axis=ARC, radius=0.002, rings=5, sides=6).build()
    for name, end in (("first end", ARC[0]), ("last end", ARC[-1])):
        apart = np.linalg.norm(mesh.position[mesh.groups[name]] - end, axis=1)
        assert apart == pytest.approx(0.002, rel=1e-9)


ROUND = np.linspace(0.0, np.radians(350.0), 15)
LOOP = tuple(0.02 * np.stack([np.cos(ROUND), np.sin(ROUND), 0.0 * ROUND], axis=1))
ACUTE = (*STAIRS[:2], np.array([0.0, 0.01, 0.0]))
HAIRPIN = tuple(1e-3 * np.array([[0.0, 0, 0], [30, 0, 0], [36, 5, 0], [30, 10, 0], [0, 10, 0]]))


@every(
    ("entries", "words"),
    [
        ({"axis": ARC, "radius": 0.045}, "bends too sharply around"),
        ({"axis": HAIRPIN, "radius": 0.0055, "rings": 60}, "too sharply"),
        ({"axis": LOOP, "radius": 0.003, "rings": 40}, "leads back to itself"),
        ({"axis": STAIRS, "radius": 0.02, "bends": "sharp"}, "intersects the next one"),
        ({"axis": STAIRS, "radius": 0.002, "bends": "sharp", "rings": 3}, "at each of its 4"),
        ({"axis": STAIRS, "radius": 0.002, "rings": 3}, "from one ring of nodes to the next"),
        ({"axis": (*STAIRS, STAIRS[-1]), "radius": 0.002}, "all differ"),
        ({"axis": ACUTE, "radius": 1e-3, "bends": "sharp"}, "more than 90 deg"),
    ],
)  # fmt: skip
def test_what_would_intersect_is_refused_with_its_place(entries, words):
    with pytest.raises(ValueError, match=words) as caught:
        Tube(**{"rings": 12, "sides": 8} | entries)
    assert '"axis"' in str(caught.value)


def test_a_wall_must_have_a_thickness_at_both_ends():
    with pytest.raises(ValueError, match="at the last end"):
        thick(end_outer_radius=0.003)
    with pytest.raises(ValueError, match="straight axis"):
        thick(part="half")


def test_impossible_numbers_of_rings_are_counted_and_not_made():
    many, axis = 10**8, {"axis": STAIRS}
    meshes = [
        Tube(**axis, radius=1e-3, rings=many, sides=8),
        thick(**axis, inner_radius=1e-3, outer_radius=2e-3, rings=many),
        Cylinder(**axis, radius=1e-3, cell=0.09 / many),
    ]
    assert all(mesh.size()[0] >= 8 * many for mesh in meshes)
