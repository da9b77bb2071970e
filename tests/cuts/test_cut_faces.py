"""Measures of the faces of cuts: areas, openings and angles against what is known of them."""

import numpy as np
import pytest

from tests.cuts.scenes import END, GEL, begun
from tests.cuts.test_divided_solids import BLADES, LATTICE
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.mechanics.cut_faces import CutFaces
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

ROUND = "thick tube { axis from (0, 5, 5) mm to (20, 5, 5) mm; inner radius = 2 mm; " + (
    "outer radius = 5 mm; rings = 8; sides = 10; layers = 2 }"
)
THROUGH = "at 0 s: cut block along plane through (11.3, 5, 5) mm facing (1, 0, 0)"
HALF = (
    "at 0 s: cut block along line from (11.3, -1, 0) mm to (11.3, 6.1, 0) mm facing (1, 0, 0)"
)
FRONT = np.array([11.3e-3, 6.1e-3, 0.0])


def state_after(*orders, mesh=LATTICE):
    return begun(
        f"{GEL}body block {{ mesh is {mesh}; made of elements; tissue is gel }}\n"
        "environment { gravity = (0, 0, 0) m/s^2 }\n"
        f"script {{ {chr(10).join(orders)} }}\n{END}"
    )


def turned(state, through, angle, below):
    """Return places of nodes after the parts on each side have turned by half of an angle.

    They turn about the line through a point along z, so that the cut opens towards -y. Elements
    whose middle is not below some y take no part, but for the nodes that they share.
    """
    x = state.position.copy()
    for parts in state.cut_bodies["block"].parts:
        middle = state.network.position[parts.drawn].mean(axis=1)
        side = np.where(parts.are_whole, np.sign(middle[:, 0] - through[0]), parts.sides[:, -1])
        for sign in (-1, 1):
            nodes = np.unique(parts.nodes[(side == sign) & (middle[:, 1] < below)])
            half = sign * angle / 2.0
            c, s = np.cos(half), np.sin(half)
            away = state.position[nodes] - through
            x[nodes] = through + away @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    return x


@pytest.mark.parametrize(("orders", "below"), [(THROUGH, 1.0), (HALF, 5e-3)])
@pytest.mark.parametrize("degrees", [3.0, 20.0, 70.0])
def test_halves_that_turn_are_open_by_the_angle_between_them(orders, below, degrees):
    """Both halves turn as rigid bodies about the end of the cut, which is a line along z.

    The elements in which a cut ends share nodes with those ahead, and are deformed.
    """
    state = state_after(orders)
    angle, faces = np.radians(degrees), CutFaces.of(state, "block")
    assert faces.angle(state.position) == pytest.approx(0.0, abs=1e-7)
    assert faces.opening(state.position) == pytest.approx(0.0, abs=1e-12)
    moved = turned(state, FRONT, angle, below)
    assert faces.angle(moved) == pytest.approx(angle, rel=1e-9)
    # The chord of the mouth of the cut, which is farther from the line than its other end.
    assert faces.opening(moved) == pytest.approx(2 * 6.1e-3 * np.sin(angle / 2), rel=1e-9)


def test_faces_that_slide_are_apart_but_not_at_an_angle():
    state = state_after(THROUGH)
    moved = state.position.copy()
    for parts in state.cut_bodies["block"].parts:
        middle = state.network.position[parts.drawn].mean(axis=1)
        right = np.where(parts.are_whole, middle[:, 0] > 11.3e-3, parts.sides[:, -1] > 0)
        nodes = np.unique(parts.nodes[right])
        moved[nodes] = state.position[nodes] + [0.0, 2e-3, 1.5e-3]
    faces = CutFaces.of(state, "block")
    assert faces.opening(moved) == pytest.approx(2.5e-3, rel=1e-9)
    assert faces.angle(moved) == pytest.approx(0.0, abs=1e-7)
    # Two states at once are measured as one after the other.
    both = np.stack([state.position, moved])
    assert faces.opening(both).tolist() == [faces.opening(one).item() for one in both]
    assert faces.area(both) == pytest.approx([200e-6, 200e-6], rel=1e-9)


@pytest.mark.parametrize(("order", "area"), [(THROUGH, 200e-6), (HALF, 2 * 6.1e-3 * 10e-3)])
def test_the_area_is_that_of_both_faces_without_what_is_tied(order, area):
    state = state_after(order)
    faces = CutFaces.of(state, "block")
    found = faces.area(state.position)
    assert found == pytest.approx(area, rel=1e-9)
    # A stretch along the faces, and another at right angles to them.
    stretch = np.array([1.7, 1.2, 1.1])
    found = faces.area(stretch * state.position)
    assert found == pytest.approx(1.2 * 1.1 * area, rel=1e-9)


@pytest.mark.parametrize("mesh", [LATTICE, ROUND])
@pytest.mark.parametrize("blade", BLADES)
def test_every_free_corner_has_its_twin_in_the_same_place(mesh, blade):
    point, facing = (", ".join(map(str, one)) for one in blade)
    order = f"at 0 s: cut block along plane through ({point}) mm facing ({facing})"
    crossing = "at 0 s: cut block along plane through (10.3, 4.4, 5.2) mm facing (0.1, 1, 0.3)"
    for orders in ([order], [order, crossing]):
        faces = CutFaces.of(state := state_after(*orders, mesh=mesh), "block")
        row, weights = faces.twins()
        assert (row >= 0).all()
        there = np.einsum("fck,fckx->fcx", weights, faces.drawn[row])
        assert np.abs(there - faces.drawn).max() < 1e-9
        assert faces.opening(state.position) < 1e-9


def test_faces_between_elements_are_faces_on_both_sides_and_stay_so_after_another_cut():
    """What a blade in faces leaves is touched from both sides, as whole elements are."""
    between = "at 0 s: cut block along plane through (10, 5, 5) mm facing (1, 0, 0)"
    crossing = "at 0 s: cut block along plane through (10.3, 4.4, 5.2) mm facing (0.1, 1, 0)"
    for orders in ([between], [between, crossing]):
        faces = CutFaces.of(state_after(*orders), "block")
        on_it = np.ptp(faces.drawn[..., 0], axis=1) < 1e-9
        a, b, c = faces.drawn[on_it].swapaxes(0, 1)
        normal = 0.5 * np.cross(b - a, c - a)[:, 0]
        assert normal[normal > 0].sum() == pytest.approx(100e-6, rel=1e-9)
        assert normal[normal < 0].sum() == pytest.approx(-100e-6, rel=1e-9)


@pytest.mark.parametrize(
    ("output", "hint"),
    [
        ("face area(block)", "cut faces of block"),
        ("face area(cutfaces of block)", "cut faces of block"),
        ("face area(corner)", "cut faces of block"),
        ("face area(cut faces of block along (1, 0, 0))", "cut faces of block"),
        ("stress(cut faces of block)", "write face area(cut faces of A)"),
    ],
)
def test_measures_that_do_not_fit_faces_of_cuts_say_what_does(output, hint):
    with pytest.raises(CompileError) as caught:
        begun(
            f"{GEL}body block {{ mesh is {LATTICE}; tissue is gel }}\n"
            "environment { gravity = (0, 0, 0) m/s^2 }\n"
            f"{END}output {{ {output} every 1 ms }}\n"
        )
    (found,) = (one for one in caught.value.diagnostics if one.severity == "error")
    assert found.code == "TIS702"
    assert hint in str(found.hint)


def test_a_body_that_nothing_divides_is_reported():
    text = (
        f"{GEL}body block {{ mesh is {LATTICE}; made of elements; tissue is gel }}\n"
        "environment { gravity = (0, 0, 0) m/s^2 }\n"
        "output { opening angle(cut faces of block) every 1 ms }\n"
    )
    (found,) = check_request(Request(Source("x.tis", text + END)))[1]
    assert found.code == "W703"
    assert "opening angle(cut faces of block) is always 0" in found.message
    faces = text.replace("tissue is gel }", "tissue is gel; rupture by faces }")
    tough = faces.replace("retardation", "toughness = 1 J/m^2; retardation")
    assert all(
        one.code != "W703" for one in check_request(Request(Source("x", tough + END)))[1]
    )
