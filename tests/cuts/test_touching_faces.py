"""Both faces of a cut touch each other, where bodies touch one another."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.contact.scenes import gap_of_balance, play
from tests.cuts.scenes import begun, cut
from tests.cuts.test_touched_parts import forces
from tests.validate.scenes import compiled_scene, same_motion
from tests.whole_runs import same_on_two_threads, same_when_resumed
from tissuec.mechanics.cut_faces import CutFaces, face_normals

SCENE = """language 1
tissue gel {
  Young's modulus = 10 kPa; Poisson's ratio = NU; density = 1000 kg/m^3; MORE
}
body block { mesh is MESH; tissue is gel }
set low = nodes of block where x < 0.01 mm
set far = nodes of block where x > 19.99 mm
environment { gravity = (0, 0, 0) m/s^2; contact is LAW }
script {
  at 0 s: fix low
  CUTS
  from 1 ms to 10 ms: move far by (WAY) mm using smooth profile
}
output { force of far every 1 ms; energy every 1 ms; trajectory every 5 ms }
simulate { METHOD }
"""
LATTICE = "lattice { cell = 2.5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }"
COARSE = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }"
ROUND = "cylinder { axis from (0, 5, 5) mm to (20, 5, 5) mm; radius = 5 mm; cell = 2.5 mm }"
AT_REST = "duration = 10 ms; integrator is equilibrium"
FREE, ROUGH = "bodies too", "bodies too; friction = 0.5"


def blade(through, facing, *, at="0 s"):
    return f"at {at}: cut block along plane through {through} mm facing {facing}\n"


def scene(cuts, law=FREE, *, mesh=LATTICE, way=(-1, 0, 0), method=AT_REST, ratio=0.0, more=""):
    text = SCENE.replace("CUTS", cuts).replace("LAW", law).replace("METHOD", method)
    text = text.replace("WAY", ", ".join(map(str, way))).replace("MESH", mesh)
    return text.replace("NU", str(ratio)).replace("MORE", more)


def then(text, order, profile="smooth profile"):
    """Return a scene that moves the far end once more."""
    return text.replace("profile\n}", f"profile\n  {order} using {profile}\n}}")


def pressed(cuts, law=FREE, **options):
    """Return the force on the far end at the end."""
    return play(scene(cuts, law, **options)).log("force of far")[1][-1]


@pytest.mark.parametrize(
    "cuts",
    [
        blade((10, 0, 0), (1, 0, 0)),
        blade((11.2, 0, 0), (1, 0, 0)),
        blade((10.04, 0, 0), (1, 0, 0)),
        blade((11.2, 5, 5), (1, 0, 0)) + blade((0, 4.8, 5), (0, 1, 0)),
        blade((10, 5, 5), (1, 0, 0)) + blade((0, 5, 5), (0, 1, 0)),
    ],
    ids=["between elements", "within", "sliver", "crossing", "crossing between elements"],
)
@pytest.mark.parametrize("law", [FREE, ROUGH])
def test_a_block_that_is_cut_across_carries_a_push_as_the_whole(cuts, law):
    """It is pushed by less, the depth δ of the faces: each presses 24 E/h δ²/2w on the other.

    Points are not all equally deep, as nodes get other shares of an even pressure: the force is
    within a tenth of what the depth takes from it, 1.8 %.
    """
    found = pressed(cuts, law, mesh=COARSE)
    h = 5e-3
    layer, soft = 0.005 * h, abs(found[0]) / 100e-6 * h / (48.0 * 1e4)
    assert soft < 0.5 * layer
    depth = np.sqrt(2.0 * layer * soft)
    expected = pressed("", law, mesh=COARSE, way=(-1.0 + 1e3 * depth, 0, 0))
    assert expected[0] < -0.05
    assert_allclose(found, expected, atol=2e-3 * abs(expected[0]))


def test_a_slit_closes_under_pressure():
    """Its force is between that of the whole and that of a cut through all."""
    line = "line from (11.2, -1, 0) mm to (11.2, 6.1, 0) mm facing (1, 0, 0)"
    slit = f"at 0 s: cut block along {line}"
    whole, part, through = (
        pressed(one, mesh=COARSE)[0] for one in ("", slit, blade((11.2, 0, 0), (1, 0, 0)))
    )
    assert whole < part < through


def test_faces_do_not_hold_together():
    """Halves that are pulled apart bear nothing."""
    found = pressed(blade((11.2, 0, 0), (1, 0.2, 0)), ROUGH, way=(1, 0, 0), mesh=COARSE)
    assert np.abs(found).max() < 1e-9


def test_tools_alone_touch_no_face_of_a_cut():
    """Halves pass through each other where contact is between tools and bodies only."""
    tool = "tool ball { kind is probe; radius = 1 mm; centre = (0, 0, 99) mm }\nenvironment"
    text = scene(blade((10, 0, 0), (1, 0, 0)), "tools only").replace("environment", tool)
    ended = play(text).log("force of far")[1][-1]
    assert np.abs(ended).max() < 1e-6


@pytest.mark.parametrize("mesh", [LATTICE, ROUND])
def test_action_and_reaction_are_equal(mesh):
    """Of two and of four pieces that are pushed into each other and turned."""
    state = begun(scene(blade((1000, 0, 0), (1, 0, 0)) * 2, ROUGH, mesh=mesh))
    cut(state, (11.2, 5, 5), (1, 0.3, 0.1))
    for again in (False, True):
        if again:
            cut(state, (11.2, 4.9, 5), (0.2, 1, 0.1))
        place = state.network.position
        ahead = np.zeros(len(place), dtype=bool)
        for parts in state.cut_bodies["block"].parts:
            ahead[parts.nodes[parts.sides[:, 0] > 0]] = True
            middle = place[parts.drawn].mean(axis=1)
            far = (parts.sides[:, 0] == 0) & (
                (middle - [11.2e-3, 5e-3, 5e-3]) @ [1, 0.3, 0.1] > 0
            )
            ahead[parts.nodes[far]] = True
        state.position[ahead] += [-0.2e-3, 0.4e-3, 0.1e-3]
        state.follow_hosts()
        found = forces(state)
        scale = np.abs(found).sum()
        assert scale > 1e-2
        assert_allclose(found.sum(axis=0), 0.0, atol=1e-13 * scale)
        moment = np.cross(state.position, found).sum(axis=0)
        assert_allclose(moment, 0.0, atol=1e-14 * scale)


MOVING = "tolerance = 1e-5"
SOFT = "retardation time = 2 ms"
OBLIQUE = blade((11.2, 5, 5), (1, 0.2, 0.1))


def test_friction_holds_faces_that_lie_across_a_push():
    """The slope of 0.22 is less than the coefficient of 0.5; without friction, they slide."""
    method = "duration = 12 ms; tolerance = 1e-4"
    options = {"method": method, "more": SOFT, "mesh": COARSE}
    expected, held = (pressed(one, ROUGH, **options) for one in ("", OBLIQUE))
    free = pressed(OBLIQUE, **options)
    assert_allclose(held, expected, atol=0.03 * abs(expected[0]))
    assert abs(free[0]) < 0.9 * abs(expected[0])


def test_sliding_faces_bear_the_largest_friction():
    """Forces along and across faces that slide have the ratio μ; the halves bend and turn."""
    text = scene(
        blade((10, 0, 0), (1, 0, 0)), "bodies too; friction = 0.3", mesh=COARSE,
        method="duration = 150 ms; tolerance = 1e-4", more="retardation time = 10 ms",
    )  # fmt: skip
    played = play(
        then(text, "from 30 ms to 160 ms: move far by (0, 0, 5) mm", "constant speed")
    )
    state = played.outcome.state
    normals = face_normals(CutFaces.of(state, "block").places(state.position))
    normal = normals[normals[:, 0] > 0.0].mean(axis=0)
    force = played.log("force of far")[1][-1]
    across = force @ normal / np.linalg.norm(normal)
    along = np.sqrt(force @ force - across**2)
    assert along == pytest.approx(0.3 * abs(across), rel=0.02)


def test_energy_is_balanced():
    text = scene(OBLIQUE, ROUGH, mesh=COARSE, method=f"duration = 12 ms; {MOVING}", more=SOFT)
    assert gap_of_balance(play(text)) < 1e-4


def test_scipy_finds_the_same_motion():
    method = "duration = 2 ms; tolerance = 1e-4"
    text = scene(OBLIQUE, mesh=COARSE, method=method, more=SOFT, way=(-0.3, 0.1, 0))
    text = text.replace("from 1 ms to 10 ms", "from 0 ms to 2 ms").replace("1 ms", "0.2 ms")
    same_motion(text)


STEPS = "duration = 8 ms; integrator is velocity verlet; step = 10 us"
LATER = OBLIQUE + blade((11.2, 4.9, 5), (0.2, 1, 0.1), at="4 ms")


def test_a_run_that_is_resumed_gives_the_same_bytes():
    text = scene(LATER, ROUGH, mesh=COARSE, method=STEPS, more=SOFT)
    same_when_resumed(compiled_scene(text), "force of far", 3, 6)


def test_threads_change_no_bit(threads_in_small_nets):
    text = scene(LATER, ROUGH, method=STEPS, more=SOFT)
    same_on_two_threads(compiled_scene(text), "force of far")


def test_a_tear_that_closes_carries_as_the_whole():
    """Faces of tears touch each other, too; the depth of faces takes 2.3 % of the force."""
    method = "duration = 150 ms; tolerance = 1e-4"
    options = {"mesh": COARSE, "method": method, "more": f"{SOFT}; breaking strain = 10 %"}
    text = scene("", ROUGH, way=(3, 0, 0), **options)
    text = text.replace(
        "tissue is gel }", "tissue is gel; made of elements; rupture by faces }"
    )
    torn = play(then(text, "from 20 ms to 60 ms: move far by (-4, 0, 0) mm"))
    assert len(CutFaces.of(torn.outcome.state, "block").corners)
    found, expected = torn.log("force of far")[1][-1], pressed("", ROUGH, **options)
    assert_allclose(found, expected, atol=0.03 * abs(expected[0]))
