"""Glue with a toughness: the patch test, what peeling takes, and what is left."""

import numpy as np
import pytest

import tissuec
from tests.contact.scenes import gap_of_balance, play
from tests.cuts.scenes import ALONG_ARMS, PULLED, peel_of_arms
from tests.every import every
from tests.glue.blocks import CROSSED, TIED, glued, on_box, standing
from tests.glue.test_faces import CUBES, cube
from tests.validate.scenes import compiled_scene, same_motion
from tests.whole_runs import same_on_two_threads, same_when_resumed
from tissuec.core.errors import CompileError
from tissuec.learn.derivatives.refusals import refusal_of_script
from tissuec.mechanics.observables import inner_forces
from tissuec.mechanics.settling import settle

TOUGH = 0.2  # J/m²
FIRM = "glue from face to {}; toughness = 1 MJ/m^2"
GRADIENTS = {
    "tension": [[0.02, 0, 0], [0, -0.005, 0], [0, 0, -0.005]],
    "shear": [[0, 0.03, 0], [0, 0, 0], [0, 0, 0]],
    "all": [[0.01, 0.02, -0.01], [0.005, -0.02, 0.015], [0.01, 0, 0.01]],
}
GEL = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 1 ms }
"""
#: Rows of cells of 3 mm and of 2 mm do not match.
BLOCKS = (
    GEL
    + """body low { mesh is lattice { cell = 3 mm; box from (0, 0, 0) mm to (12, 6, 6) mm }
  tissue is gel }
body high { mesh is lattice { cell = 2 mm; box from (0, 0, 6) mm to (12, 6, 12) mm }
  tissue is gel }
set face = nodes of high where z < 6.1 mm
set bed = nodes of low where z > 5.9 mm
joint bond { glue from face to low; toughness = 0.2 J/m^2 }
set top = nodes of high where z > 11.9 mm
set base = nodes of low where z < 0.1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix base
  from 0 s to 30 ms: move top by (0, 0, 2.4) mm using constant speed
}
simulate { duration = 30 ms; tolerance = 1e-4 }
output { force of top every 1 ms; energy every 1 ms; trajectory every 10 ms
  ruptured(high) every 1 ms; count(pieces of [low, high]) every 1 ms }
"""
)
SMALL = BLOCKS.replace("(12, 6, 6)", "(6, 6, 6)").replace("(12, 6, 12)", "(6, 6, 12)")


def glue_of(state):
    (found,) = state.of_kind("glue")
    return found


# --- before it opens --------------------------------------------------------------------------


def misses_even_stress(state, gradient, moved):
    """Return by how much nodes miss a uniform gradient with an even opening of the glue [m].

    The opening is the traction over the stiffness; the traction is that of the end in x if all
    follow the gradient.

    Args:
        moved: Which nodes are moved by it, shape (node,).
    """
    drawn, glue = state.network.position, glue_of(state)
    even = drawn + drawn @ np.array(gradient).T
    force = inner_forces(state, 0.0, even, np.zeros_like(even)).node
    end = drawn[:, 0] > drawn[:, 0].max() - 1e-9
    even[state.network.bodies[1].nodes] -= force[end].sum(axis=0) / glue.stiffness.sum()
    state.holders["moved"] = np.flatnonzero(moved)
    state.position[moved] = even[moved]
    settle(state, np.ones(len(drawn), dtype=bool))
    opened = np.einsum("pa,pax->px", glue.weights, state.position[glue.nodes])
    assert np.ptp(opened, axis=0).max() < 1e-9 * np.abs(opened).max()
    return np.abs(state.position - even).max()


@pytest.mark.parametrize("cells", ["lie in one another", "cross"])
@pytest.mark.parametrize("load", GRADIENTS)
def test_uniform_stress_passes_before_glue_opens(load, cells):
    """Newton's method ends at forces of 1e-12 of the largest, and so at places as exact."""
    text = glued(TIED.replace("glue from face to coarse", FIRM.format("coarse")))
    state = standing(text.replace(*CROSSED) if cells == "cross" else text)
    drawn = state.network.position
    moved = on_box(drawn)
    assert (~moved & state.free).sum() > 20
    assert misses_even_stress(state, GRADIENTS[load], moved) < 1e-12 * np.ptp(drawn)


@pytest.mark.parametrize(
    ("host", "guest", "cells"),
    [
        ("hexahedra", "wedges", 4), ("wedges", "hexahedra", 3), ("tetrahedra", "hexahedra", 3),
        ("tetrahedra", "tetrahedra", 3), ("hexahedra", "tetrahedra", 3),
        ("quadratic", "hexahedra", 3), ("hexahedra", "quadratic", 3),
    ],
)  # fmt: skip
def test_uniform_stress_passes_between_elements_of_all_shapes(
    tmp_path, monkeypatch, host, guest, cells
):
    monkeypatch.chdir(tmp_path)
    kinds = {
        "@HOST": cube(tmp_path / "host.vtk", host, 2),
        "@GUEST": cube(tmp_path / "guest.vtk", guest, cells),
    }  # fmt: skip
    text = CUBES.replace("glue from face to host", FIRM.format("host"))
    for old, new in kinds.items():
        text = text.replace(old, new)
    state = standing(text)
    moved = on_box(state.network.position)
    assert misses_even_stress(state, GRADIENTS["all"], moved) < 1e-12 * 20e-3


def test_one_stiffness_holds_for_all_of_a_joint():
    """k = 2 · 10/(h₁/E + h₂/E), with the sizes of both cells, on the whole of the area."""
    state = standing(glued(TIED.replace("glue from face to coarse", FIRM.format("coarse"))))
    glue = glue_of(state)
    assert glue.areas.sum() == pytest.approx(1e-4, rel=1e-12)
    expected = 2.0 * 10.0 * 10e3 / (5e-3 + 2.5e-3)
    assert glue.stiffness / glue.areas == pytest.approx(expected, rel=1e-12)


# --- peeling ----------------------------------------------------------------------------------


def test_bodies_come_apart_for_the_toughness_of_their_glue():
    """The energy that is switched off is G times the area, to rounding; nothing is lost."""
    played = play(BLOCKS)
    _, energy = played.energies()
    assert -energy["switched"][-1] == pytest.approx(TOUGH * 72e-6, rel=1e-9)
    assert gap_of_balance(played) < 1e-5
    assert played.log("ruptured of high")[1][-1, 0] == 18  # elements in front
    pieces = played.log("pieces of [low, high]")[1]
    assert (pieces == pieces[0]).all()
    state = played.outcome.state
    assert state.alive.all() and not state.of_kind("glue")
    events = [one for _, one in played.outcome.logged_events if one.kind == "rupture"]
    assert "the glue bond has opened (4 mm^2, 800 nJ), at element" in events[0].cause
    assert events[0].span.text.startswith("joint bond")


def test_bodies_that_part_in_equilibrium_take_the_work_of_their_glue():
    """Between equilibria nothing is lost: both are pulled apart evenly, without a jump."""
    text = SMALL.replace("cell = 3 mm", "cell = 6 mm").replace("every 1 ms", "every 2 ms")
    played = play(text.replace("; tolerance = 1e-4", "; integrator is equilibrium"))
    _, energy = played.energies()
    assert energy["work"][-1] == pytest.approx(TOUGH * 36e-6, rel=1e-9)
    assert abs(energy["elastic"][-1]) < 1e-12 * energy["work"][-1]


PEELED = """language 1
tissue gel { Young's modulus = 100 kPa; Poisson's ratio = 0; density = 1000 kg/m^3
  retardation time = 1 ms }
body low { mesh is lattice { cell = 2 mm; box from (0, 0, 0) mm to (60, 4, 4) mm }
  tissue is gel }
body high { mesh is lattice { cell = (1.875, 4, 1.333333333333) mm
  box from (0, 0, 4) mm to (60, 4, 8) mm }; tissue is gel }
set face = nodes of high where z < 4.1 mm and x > 14.9 mm
joint bond { glue from face to low; toughness = 1 J/m^2 }
set top = nodes of high where x < 0.1 mm and z > 7.9 mm
set low end = nodes of low where x < 0.1 mm and z < 0.1 mm
"""
PEELED += f"{ALONG_ARMS}script {{\n  at 0 s: fix low end\n{PULLED}"


@pytest.mark.slow
def test_two_beams_are_peeled_by_the_force_of_the_closed_form():
    """The glue opens element by element: the toughness is 1 J/m²."""
    assert peel_of_arms(play(PEELED)) == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_scipy_finds_the_same_peeling():
    same_motion(SMALL.replace("duration = 30 ms", "duration = 16 ms"), within=1e-3)


def test_a_run_that_is_resumed_while_it_peels_gives_the_same_bytes():
    text = SMALL.replace("move top by (0, 0, 2.4)", "move top by (1.2, 0, 2.4)")
    text = text.replace("cell = 2 mm", "cell = (2, 3, 3) mm")
    _, *parts = same_when_resumed(compiled_scene(text), "force of top", 7, 8)
    left = [len(glue_of(first.state).nodes) for first, _ in parts]
    assert 168 > left[0] > left[1] > 0  # of the points


@pytest.mark.slow
def test_threads_change_no_bit(threads_in_small_nets):
    text = BLOCKS.replace("cell = 2 mm", "cell = 1 mm").replace("cell = 3 mm", "cell = 1.2 mm")
    text = text.replace("(12, 6,", "(30, 6,").replace("30 ms", "10 ms").replace("2.4)", "1.6)")
    run = same_on_two_threads(compiled_scene(text), "force of top")
    assert any(one.kind == "rupture" for _, one in run.logged_events)


def test_elements_that_are_lost_lose_their_glue():
    """Those in front and those behind, also in a body whose elements may break."""
    text = BLOCKS.replace("retardation time", "breaking strain = 90 %\n  retardation time")
    text = text.replace(
        "tissue is gel }\nset face", "tissue is gel; rupture is allowed }\nset face"
    )
    state = standing(text)
    glue, owners = glue_of(state), state.network.bodies
    for body in owners[::-1]:
        before, field = glue_of(state), state.network.elements_of(body.name)[0]
        lost = field.walls[(field.nodes[:, :, None] == before.nodes[0]).any(axis=(1, 2))][:1]
        state.break_entities(lost)
        left = glue_of(state).intact(state.alive)
        assert not np.isin(left.walls, lost).any()
        assert (
            left.item_count
            == (
                ~np.isin(before.walls.reshape(-1, 2), np.flatnonzero(~state.alive)).any(axis=1)
            ).sum()
        )
    assert left.areas.sum() < glue.areas.sum()


def test_a_cut_of_a_third_body_leaves_glue_as_it_is():
    third = (
        "body other { mesh is lattice { cell = 3 mm; box from (20, 0, 0) mm to (26, 6, 6) mm }"
    )
    order = "at 0 s: cut other along plane through (23.5, 0, 0) mm facing (1, 0, 0)\n"
    text = BLOCKS.replace("set face", third + "; tissue is gel }\nset face")
    text = text.replace("at 0 s: fix base", order + "  at 0 s: fix base")
    assert glue_of(standing(text)).areas.sum() == pytest.approx(72e-6, rel=1e-12)


def test_glued_bodies_hang_together_and_do_not_touch():
    """What is glued to a held body is held; that bodies touch would push them apart."""
    compiled = compiled_scene(BLOCKS)
    assert compiled.network.glued.tolist() == [[1, 0]]
    loose = BLOCKS.replace("(0, 0, 0) m/s^2", "(0, 0, -9.81) m/s^2")
    loose = loose.replace(
        "from 0 s to 30 ms: move top by (0, 0, 2.4) mm using constant speed", ""
    )
    assert not [one for one in tissuec.check(loose) if one.code == "W310"]
    alone = loose.replace("joint bond { glue from face to low; toughness = 0.2 J/m^2 }", "")
    assert [one for one in tissuec.check(alone) if one.code == "W310"]


def test_learning_has_no_exact_derivatives_with_peeling_glue():
    compiled = compiled_scene(BLOCKS)
    assert "glue with a toughness" in refusal_of_script(compiled.plan, compiled.network)


# --- what is refused --------------------------------------------------------------------------

BOND = "glue from face to low; toughness = 0.2 J/m^2"
SHEET = (
    "body wall { mesh is sheet { corner = (0, 0, 6) mm; first edge = (12, 0, 0) mm\n"
    "  second edge = (0, 6, 0) mm; columns = 4; rows = 3 }; tissue is gel; thickness = 1 mm }\n"
)
CUT = "at 0 s: cut low along plane through (5, 0, 0) mm facing (1, 0, 0)\n  at 0 s: fix base"
WRONG = {
    "springs": (BOND, "springs from face to low; tissue is gel; section = 1 mm^2\n"
                "  toughness = 1 J/m^2", "only glue has a toughness"),
    "negative": ("toughness = 0.2 J/m^2", "toughness = -1 J/m^2", "must be above 0"),
    "a unit": ("toughness = 0.2 J/m^2", "toughness = 1 J", "but 1 J is an energy"),
    "cut": ("at 0 s: fix base", CUT, "low is cut or tears"),
    "a tear": ("set face",
               "tissue tough { Young's modulus = 10 kPa; density = 1000 kg/m^3; "
               "breaking strain = 50 % }\nbody third { mesh is lattice { cell = 3 mm\n"
               "box from (0, 0, 12) mm to (6, 6, 18) mm }; tissue is tough\n"
               "rupture by faces }\n"
               "set under = nodes of third "
               "where z < 12.1 mm\njoint more { glue from under to high; "
               "toughness = 1 J/m^2 }\n"
               "set face", "third is cut or tears"),
    "an interface": ("to (12, 6, 6) mm }",
                     "to (12, 6, 6) mm }\n  region a where x > 6 mm "
                     "{ tissue is gel }\n  interface from a to low { toughness = 1 J/m^2 }\n",
                     "low has an interface that peels"),
    "a wall": ("joint bond", SHEET + "joint more { glue from wall to low; "
               "toughness = 1 J/m^2 }\njoint bond", "wall is no solid of elements"),
    "to a wall": ("joint bond", SHEET + "joint more { glue from face to wall; toughness = "
                  "1 J/m^2 }\njoint bond", "wall is no solid of elements"),
    "itself": (BOND, "glue from face to high; toughness = 1 J/m^2", "glued to itself"),
    "far": ("z < 6.1 mm", "z > 11.9 mm", "18 faces of face are not at low"),
    "half of a face": ("z < 6.1 mm", "z < 6.1 mm or (x == 0 mm and y == 0 mm and z < 9 mm)",
                       "1 node of face is not part of a face"),
    "no face": ("z < 6.1 mm", "z < 6.1 mm and x == 0 mm", "4 nodes of face are not part"),
    "twice": ("joint bond", "joint more { glue from bed to high; toughness = 1 J/m^2 }\n"
              "joint bond", "more joins faces of face and low already"),
    "firmly": ("joint bond", "joint more { glue from face to low }\njoint bond",
               "other glue joins faces of face and low already"),
    "firmly from there": ("joint bond", "joint more { glue from bed to high }\njoint bond",
                          "other glue joins faces of face and low already"),
}  # fmt: skip


@every("wrong", WRONG)
def test_glue_that_cannot_come_apart_is_refused(wrong):
    old, new, message = WRONG[wrong]
    assert BLOCKS.count(old) == 1 or old == "joint bond"
    with pytest.raises(CompileError, match=message):
        compiled_scene(BLOCKS.replace(old, new))


def test_a_whole_body_is_glued_by_its_faces_at_the_other():
    whole = standing(BLOCKS.replace("glue from face to low", "glue from high to low"))
    face = standing(BLOCKS)
    assert np.array_equal(glue_of(whole).nodes, glue_of(face).nodes)
    away = BLOCKS.replace("glue from face", "glue from high").replace(
        "(0, 0, 6) mm", "(0, 0, 8) mm"
    )
    with pytest.raises(CompileError, match="faces of high are not at low"):
        standing(away)
