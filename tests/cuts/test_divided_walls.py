"""Blades divide triangles of walls: what is kept, what moves on its own, and bending."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.contact.scenes import play
from tests.cuts.scenes import (
    END,
    GEL,
    SHEET,
    TUBE,
    UNUSED,
    ahead_of,
    cut,
    momentum,
    state_of,
    volume,
)
from tests.cuts.test_touched_parts import forces
from tests.every import every
from tests.validate.scenes import compiled_scene
from tissuec.forces.surfaces.cut_plates import held_stiffness
from tissuec.mechanics.cutting import carry_out, divided
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot
from tissuec.validate.forces.cut_plates import fractions_of
from tissuec.validate.forces.cut_plates import held_stiffness as held_stiffness_again

BODY = """body block {
  mesh is MESH
  made of elements; tissue is gel; thickness = 1 mm; bending is elastic
}
set base = nodes of block where x < 0.01 mm
environment { gravity = (0, 0, 0) m/s^2 }
"""


def scene(mesh=SHEET, cuts=1, orders="", end=END):
    text = GEL + BODY.replace("MESH", mesh)
    return text + "script {\n" + orders + UNUSED * cuts + "}\n" + end


def intact(state, kind):
    """Return the fields of a kind with what they have left."""
    found = (each.intact(state.alive) for each in state.of_kind(kind))
    return [each for each in found if each.item_count]


BLADES = [
    ((11.2, 5, 0), (1, 0.2, 0)),
    ((10, 5, 0), (1, 0, 0)),  # along edges
    ((11, 5, 0), (0.3, 1, 0)),
    ((10, 5, 0), (1, 1, 0.3)),  # through nodes
]


@pytest.mark.parametrize("mesh", [SHEET, TUBE])
@every("blade", BLADES)
def test_mass_area_and_motion_are_kept(mesh, blade):
    """All are sums of as many numbers as there are nodes, to rounding."""
    state = state_of(scene(mesh, cuts=2))
    rng = np.random.default_rng(3)
    for through, facing in (blade, ((10.3, 4.4, 0.2), (0.1, 1, 0.3))):
        state.velocity[:] = 0.01 * rng.normal(size=state.velocity.shape)
        state.follow_hosts()
        before = state.inertia.sum(), volume(state), momentum(state)
        division = cut(state, through, facing)
        assert division is not None and len(division.copies)
        assert state.inertia.sum() == pytest.approx(before[0], rel=1e-14)
        assert volume(state) == pytest.approx(before[1], rel=1e-13)
        scale = np.abs(before[2]).max()
        assert_allclose(momentum(state), before[2], atol=1e-13 * scale, rtol=1e-12)
        assert (state.inertia[state.free] > 0.0).all()


@every("blade", BLADES[:3])
def test_each_side_passes_the_patch_test(blade):
    """Under plane stresses that leave the cut free, no node inside of a side has a force."""
    state = state_of(scene())
    normal = np.array(blade[1], float) / np.linalg.norm(blade[1])
    cut(state, *blade)
    place, ahead = state.network.position, ahead_of(state, blade[0], normal)
    young, ratio, rng = 10e3, 0.3, np.random.default_rng(5)
    moved = np.zeros_like(place)
    along = np.array([-normal[1], normal[0], 0.0])
    for side in (ahead, ~ahead):
        stress = rng.normal() * np.outer(along, along)
        strain = ((1.0 + ratio) * stress - ratio * np.trace(stress) * np.eye(3)) / young
        strain[2] = 0.0
        turn = 1e-4 * rng.normal(size=(3, 3))
        moved[side] = place[side] @ (strain + turn - turn.T).T
    force = np.zeros_like(place)
    for own in intact(state, "membranes"):
        stiff = own.element_matrices(place, exact=True)
        np.add.at(force, own.nodes, np.einsum("eaxby,eby->eax", stiff, moved[own.nodes]))
    x, y = place[:, :2].T
    outer = (x < 1e-9) | (x > 0.02 - 1e-9) | (y < 1e-9) | (y > 0.01 - 1e-9)
    assert np.abs(force[~outer]).max() < 1e-12 * np.abs(force[outer]).max()


def test_free_halves_bend_on_their_own():
    """A half that is folded along the cut has no bending energy, nor has one that turns."""
    state = state_of(scene())
    cut(state, (11.2, 5, 0), (1, 0, 0))
    ahead = ahead_of(state, (11.2, 5, 0), (1, 0, 0))
    turned = state.position.copy()
    turned[ahead] = turned[ahead] @ np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]) + 5e-3
    bent = [each.energies(turned).sum() for each in intact(state, "plates")]
    size = 10e3 * 1e-9 / 12.0  # rigidity, the energy of a fold of about 1 rad
    assert len(bent) == 2 and max(bent) < 1e-20 * size


def bent_energies(blade, curvature):
    """Return energies of a sheet rolled to a small curvature before and after a cut [J].

    Columns of shape: whole, and each side.
    """
    state = state_of(scene(FINE))
    rolled = state.position.copy()
    way = np.array([np.cos(curvature[1]), np.sin(curvature[1]), 0.0])
    rolled[:, 2] = 0.5 * curvature[0] * ((rolled - 5e-3) @ way) ** 2
    before = sum(each.energies(rolled).sum() for each in intact(state, "plates"))
    cut(state, *blade)
    rolled = rolled[state.network.parents]
    after = sum(each.energies(rolled).sum() for each in intact(state, "plates"))
    return before, after


FINE = SHEET.replace("columns = 9; rows = 5", "columns = 33; rows = 17")


@every("angle", [0.0, 0.7, 1.57])
def test_bending_of_both_sides_adds_up_to_that_of_the_whole(angle):
    """But for triangles along the cut, which have fewer hinges: their energy is lower.

    Of 32 x 16 cells, those beside a straight cut are 16 of 512, so that at most 3 % is lost.
    """
    before, after = bent_energies(((11.2, 5, 0), (1, 0.1, 0)), (0.1, angle))
    assert 0.96 * before < after < before * (1.0 + 1e-9)


def test_parts_hold_on_to_parts_as_far_as_these_are_there():
    """Springs in series: as the whole, a fraction of it, and without a moment at free edges."""
    rng = np.random.default_rng(2)
    root = rng.normal(size=(5, 3, 3))
    stiff = root @ root.swapaxes(1, 2)
    share = np.array([1.0, 0.3, 0.3, 0.7, 0.2])
    held = np.array([[1, 1, 1], [0.3, 0.5, 1], [1e-9, 1, 1], [0, 0.5, 0.7], [0.1, 0, 0]])
    found = held_stiffness(stiff, share, held)
    assert_allclose(found[0], stiff[0], rtol=1e-10)
    assert_allclose(found[1], 0.3 * stiff[1], rtol=1e-10)
    free = np.linalg.inv(np.linalg.inv(stiff[2])[1:, 1:])
    assert_allclose(found[2][1:, 1:], 0.3 * free, rtol=1e-6)
    assert np.abs(found[2][0]).max() < 1e-6 * np.abs(stiff[2]).max()
    for k in range(5):
        least = np.minimum(share[k], held[k])
        assert (np.diag(found[k]) <= 2.0 * least * np.diag(stiff[k]) * (1 + 1e-12)).all()
        assert np.linalg.eigvalsh(found[k])[0] > -1e-12 * np.abs(stiff[k]).max()


def test_a_half_falls_freely():
    """The half beyond the held edge falls as all that is free does."""
    orders = (
        "at 0 s: { fix base\n"
        "cut block along plane through (11.2, 0, 0) mm facing (1, 0.1, 0) }\n"
    )
    end = (
        "output { position(tip) every 1 ms }\nsimulate { duration = 10 ms; tolerance = 1e-8 }\n"
    )
    text = scene(cuts=0, orders=orders, end=end)
    text = text.replace("(0, 0, 0) m/s^2", "(0, 0, -10) m/s^2")
    text = text.replace(
        "environment", "set tip = nodes of block where x > 12.6 mm\nenvironment"
    )
    time, place = play(text).log("position of tip")
    assert_allclose(place[:, 2] - place[0, 2], -5.0 * time**2, atol=1e-9)


SLIT = (
    "at 0 s: fix base\n"
    "from 2 ms to 6 ms: cut block along line from (11.2, -1, 0) mm to (11.2, 6, 0) mm "
    "facing (1, 0, 0) using constant speed\n"
    "at 8 ms: cut block along plane through (5, 5, 0) mm facing (0.2, 1, 0.1)\n"
)
LOGGED = """output { trajectory every 1 ms; force of base every 1 ms; energy every 1 ms
  count(pieces of block) every 1 ms }
simulate { duration = 10 ms; tolerance = 1e-4 }
"""


def slit(mesh=SHEET):
    text = scene(mesh, 0, SLIT, LOGGED)
    return text.replace("(0, 0, 0) m/s^2", "(2, 0, -9.81) m/s^2")


def test_a_slit_leaves_one_piece_and_a_second_cut_crosses_it():
    """Both sides of the slit hang on the rest above it, until the other cut crosses both."""
    played = play(slit())
    time, pieces = played.log("pieces of block")
    assert set(pieces[time < 7.5e-3, 0]) == {1.0}
    assert pieces[-1, 0] == 3


PATH = np.array([(8, -1), (10, 4), (12, 7), (12.5, 11)])


def test_strokes_along_a_path_leave_two_pieces():
    """Each begins where the one before ends, within a triangle; the sheet is in one piece."""
    orders = ""
    for k, (first, last) in enumerate(pairwise(PATH)):
        way = last - first
        ends = "from ({}, {}, 0) mm to ({}, {}, 0) mm".format(*first, *last)
        orders += (
            f"at {k + 1} ms: cut block along line {ends} facing ({-way[1]}, {way[0]}, 0)\n"
        )
    end = "output { count(pieces of block) every 0.5 ms }\nsimulate { duration = 4 ms }\n"
    played = play(scene(FINE, 0, orders, end))
    time, pieces = played.log("pieces of block")
    assert set(pieces[time < 2.9e-3, 0]) == {1.0} and pieces[-1, 0] == 2
    assert not any(map(len, played.outcome.state.tied.values()))
    assert volume(played.outcome.state) == pytest.approx(200e-9, rel=1e-12)


def test_the_gap_is_that_of_edges():
    """Halves that are moved apart by a millimetre have a gap of as much."""
    text = scene().replace("x < 0.01 mm", "x >= 0 mm")
    compiled = compiled_scene(text)
    state = compiled.plan.start(compiled.network)
    cut(state, (11.2, 5, 0), (1, 0, 0))
    snapshot = Snapshot.of(state)
    gap, subject = MEASURES["gap"], Subject("base", compiled.nodes_of("base"), ())
    assert gap.sample((subject,), snapshot)[0] == pytest.approx(0.0, abs=1e-12)
    state.position[ahead_of(state, (11.2, 5, 0), (1, 0, 0)), 0] += 1e-3
    state.follow_hosts()
    assert gap.sample((subject,), Snapshot.of(state))[0] == pytest.approx(1e-3, rel=1e-9)


PLATE = "tool plate { kind is plane; point = (0, 0, 0.6) mm; normal = (0, 0, -1) }\n"


def test_a_plate_presses_on_a_wall_that_is_cut_as_on_a_whole_one():
    """The area that is pressed is the same, and action and reaction are equal, to rounding."""
    text = scene(cuts=2).replace(
        "environment {", PLATE + "environment { contact is tools only;"
    )
    state = state_of(text)
    tool = state.network.tools[0].nodes
    state.position[tool, 2] -= 0.7e-3
    expected = forces(state)[tool].sum(axis=0)
    assert expected[2] > 0.1
    for blade in (BLADES[0], ((10.3, 4.4, 5.2), (0.1, 1, 0.3))):
        cut(state, *blade)
        found = forces(state)
        assert_allclose(found[tool].sum(axis=0), expected, atol=1e-12 * expected[2])
        assert_allclose(found.sum(axis=0), 0.0, atol=1e-13 * expected[2])


def test_the_reference_finds_the_stiffness_of_parts_by_itself():
    """From outlines of parts, after two blades that cross and a slit that ends inside."""
    state = state_of(scene(TUBE, cuts=3))
    cut(state, (11.2, 5, 5), (1, 0.3, 0.2))
    cut(state, (10.3, 4.4, 5.2), (0.1, 1, 0.3))
    height = state.position @ [1.0, 0.2, 0.1] - 5e-3
    (parts,) = state.cut_bodies["block"].parts
    active = state.network.position[parts.drawn].mean(axis=1)[:, 2] > 5e-3
    carry_out(state, divided(state, "block", height, "one", (active,)))
    plates = state.blocks["the bending of block beside cuts"].field
    (drawn,), body = state.network.of_kind("plates"), state.cut_bodies["block"]
    found = held_stiffness_again(plates, drawn, body)
    assert_allclose(found, plates.stiffness, atol=1e-9 * np.abs(drawn.stiffness).max())
    # Where the slit ends, triangles hold on to both parts of a neighbour.
    own = plates.walls[np.unique(plates.walled, return_index=True)[1]]
    assert len(np.unique(own)) < len(own)
    (parts,) = body.parts
    assert_allclose(fractions_of(parts), parts.fractions, rtol=1e-12)
