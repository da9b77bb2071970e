"""Contact of solids that blades divide: their parts, and faces of cuts."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.contact.scenes import gap_of_balance, play
from tests.cuts.scenes import begun, cut
from tests.cuts.test_divided_solids import BLADES, LATTICE
from tests.validate.scenes import compiled_scene, same_motion
from tests.whole_runs import same_on_two_threads, same_when_resumed
from tissuec.core.errors import CompileError

GEL = """language 1
tissue gel {
  Young's modulus = 10 kPa; Poisson's ratio = 0; density = 1000 kg/m^3
  retardation time = 1 ms
}
"""
CUT = "at 0 s: cut block along plane through (X, 0, 0) mm facing (1, 0, 0)"
BALL = "tool ball { kind is probe; radius = 4 mm; centre = (CENTRE) mm }"
PLATE = "tool plate { kind is plane; point = (0, 0, 10.1) mm; normal = (0, 0, -1) }"
END = """output { force(TOOL) every 0.5 ms; energy every 1 ms; trajectory every 5 ms }
simulate { duration = 10 ms; tolerance = 1e-6 }
"""


def scene(tool, orders, mesh=LATTICE, law="contact is tools only", end=END, more=""):
    name = tool.split()[1]
    return (
        f"{GEL}body block {{ mesh is {mesh}; tissue is gel }}\n{more}{tool}\n"
        "set base = nodes of block where z < 0.01 mm\n"
        "set side = nodes of block where x < 0.01 mm\n"
        f"environment {{ gravity = (0, 0, 0) m/s^2; {law} }}\n"
        f"script {{ {orders} }}\n" + end.replace("TOOL", name)
    )


def forces(state):
    """Return forces of contact on all nodes, those on riders on their hosts."""
    found = np.zeros_like(state.position)
    touching = state.touching
    touching.add_forces(0.0, state.position, state.velocity, found)
    return state.embedding.shared(found)


def on_top(state):
    """Return the areas and pressures of points on the upper face, and which press in full."""
    contact = state.touching
    pairs, place = contact.pressed(state.position)
    point = pairs.node - (len(contact.nodes) - len(contact.between.corners))
    corners = state.drawn[contact.between.triangles[contact.between.face[point]]]
    top = np.ptp(corners[..., 2], axis=1) < 1e-9
    area = contact.between.areas[point[top]]
    hard = contact.stiffness[pairs.node[top]] / area
    pressure = contact.pressure(pairs, place.depth)[top] / area
    return area, pressure, hard > 0.999 * hard.max()


@pytest.mark.parametrize("blade", BLADES)
def test_a_plate_presses_on_a_cut_surface_as_on_a_whole_one(blade):
    """What is pressed is the same area, and action and reaction are equal to rounding."""
    state = begun(scene(PLATE, f"{CUT.replace('X', '1000')}\n{CUT.replace('X', '1000')}"))
    state.position[state.network.tools[0].nodes, 2] -= 0.4e-3
    area, expected, _ = on_top(state)
    assert area.sum() == pytest.approx(200e-6, rel=1e-12)
    for one in (blade, ((10.3, 4.4, 5.2), (0.1, 1, 0.3))):
        cut(state, *one)
        found = forces(state)
        scale = np.abs(found).sum()
        assert_allclose(found.sum(axis=0), 0.0, atol=1e-13 * scale)
        moment = np.cross(state.position, found).sum(axis=0)
        assert_allclose(moment, 0.0, atol=1e-14 * scale)
        area, pressure, full = on_top(state)
        assert area.sum() == pytest.approx(200e-6, rel=1e-12)
        assert_allclose(pressure[full], expected[0], rtol=1e-9)
        assert area[full].sum() > 0.97 * 200e-6


def indented(orders, tool, mesh=LATTICE, **options):
    played = play(scene(tool, orders, mesh, **options))
    assert gap_of_balance(played) < 1e-4
    return played.log(f"force of {tool.split()[1]}")[1]


PRESS = "\nfrom 0 s to 8 ms: move plate by (0, 0, -1) mm using smooth profile"


def test_a_cut_that_is_held_closed_carries_as_the_whole():
    """A plate on a block of ν = 0 does not open a cut along its push, in equilibrium.

    Points on the faces of the cut that are less deep than the plate add the share that those on
    the sides of the block have.
    """
    end = END.replace("tolerance = 1e-6", "integrator is equilibrium")
    orders = "at 0 s: { fix base; press side with 20 Pa }"
    found, expected = (
        play(scene(PLATE, orders + one + PRESS, end=end)).log("force of plate")[1][-1]
        for one in ("\n" + CUT.replace("X", "11.2"), "")
    )
    assert expected[2] < -0.1
    assert_allclose(found, expected, atol=5e-4 * np.abs(expected).max())


def faced(x, mesh):
    """Return the force on a ball that is pushed onto a face at x [mm], cut or drawn."""
    orders, more = "at 0 s: fix side\n", ""
    if mesh == LATTICE:
        orders += CUT.replace("X", str(x)) + "\n"
        orders += "from 0 s to 2 ms: move far by (15, 0, 0) mm using smooth profile\n"
        more = f"set far = nodes of block where x > {x + 0.1} mm\n"
    orders += (
        "from 0 s to 2 ms: move ball by (0, 0, -20) mm using smooth profile\n"
        "from 2 ms to 9 ms: move ball by (-1, 0, 0) mm using smooth profile"
    )
    tool = BALL.replace("CENTRE", f"{x + 4.1}, 5, 25")
    text = scene(tool, orders, mesh, more=more, end=END.replace("10 ms", "40 ms"))
    played = play(text.replace("= 1 ms", "= 5 ms"))
    if mesh == LATTICE:
        assert played.outcome.state.contact.bounds.size == 0  # there are no triangles to touch
        assert played.outcome.state.contact.between.bounds.size > 0
    return played.log("force of ball")[1][-1]


@pytest.mark.parametrize(("x", "within"), [(10, 0.005), (8.75, 0.05)])
def test_a_tool_feels_the_face_of_a_cut(x, within):
    """Once all is at rest, the face of a cut bears what a drawn one does.

    Between elements, only the diagonals differ, through which points share their forces; half
    elements bend less well than drawn ones of the same size.
    """
    short = LATTICE.replace("(20,", f"({x},")
    if x != 10:
        short = short.replace("cell = 2.5 mm", f"cell = ({x / 4}, 2.5, 2.5) mm")
    found, expected = faced(x, LATTICE), faced(x, short)
    assert expected[0] < -5e-3
    assert_allclose(found, expected, atol=within * np.abs(expected).max())


RUBBED = """at 0 s: fix base
from 1 ms to 4 ms: move ball by (0.3, 0.5, -1) mm using smooth profile
from 1 ms to 3 ms: cut block along line from (9.2, -1, 0) mm to (9.2, 6, 0) mm """ + (
    """facing (1, 0, 0) using constant speed
at 5 ms: cut block along plane through (10, 5, 0) mm facing (0.2, 1, 0)
from 5 ms to 7 ms: move ball by (1, 0, -0.5) mm using smooth profile"""
)
COARSE = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }"
ON_TOP = BALL.replace("CENTRE", "10, 5, 9.02")
LOGS = """output { trajectory every 2 ms; force of base every 1 ms; force(ball) every 1 ms
  energy every 1 ms }
"""
FREE, ROUGH = "contact is tools only", "contact is tools only; friction = 0.3"


def rubbed(law, method, mesh=COARSE):
    return scene(
        ON_TOP, RUBBED, mesh, law, LOGS + f"simulate {{ duration = 8 ms; {method} }}\n"
    )


def test_energy_is_balanced_where_a_tool_presses_on_parts():
    """Cuts switch what elements store; all else is integrated."""
    assert gap_of_balance(play(rubbed(FREE, "tolerance = 1e-5"))) < 1e-4


def test_scipy_finds_the_same_motion():
    orders = (
        "at 0 s: fix base\n"
        + CUT.replace("X", "9.2")
        + """
    from 0 ms to 0.4 ms: move ball by (0.1, 0.2, -0.3) mm using smooth profile"""
    )
    end = LOGS.replace("1 ms", "0.1 ms") + "simulate { duration = 0.5 ms; tolerance = 1e-4 }\n"
    same_motion(scene(ON_TOP, orders, COARSE, FREE, end))


STEPS = "integrator is velocity verlet; step = 5 us"


def test_friction_on_parts_keeps_a_tool_from_gliding():
    """Its force along the surface is not 0, as it would be without friction."""
    force = play(rubbed(ROUGH, STEPS)).log("force of ball")[1][-3:]
    along = np.linalg.norm(force[:, :2], axis=1)
    assert (along > 0.05 * -force[:, 2]).all()


def test_a_run_that_is_resumed_gives_the_same_bytes():
    same_when_resumed(compiled_scene(rubbed(ROUGH, STEPS)), "force of base", 3, 8)


def test_threads_change_no_bit(threads_in_small_nets):
    mesh = "lattice { cell = 2.5 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }"
    same_on_two_threads(compiled_scene(rubbed(ROUGH, STEPS, mesh)), "force of base")


BODIES = """body lid {
  mesh is lattice { cell = 3 mm; box from (7, 2, 10.1) mm to (13, 8, 13.1) mm }
  tissue is gel
}
"""


def test_a_body_that_lies_on_a_cut_surface_presses_with_an_equal_force():
    """Forces and moments of contact between bodies add up to nothing."""
    law = "contact is bodies too; friction = 0.2"
    state = begun(
        scene(
            BALL.replace("CENTRE", "0, 0, 99"), CUT.replace("X", "1000"), law=law, more=BODIES
        )
    )
    cut(state, (10.3, 5, 5), (1, 0.2, 0.1))
    lid = state.network.bodies[1].nodes
    state.position[lid, 2] -= 0.4e-3
    found = forces(state)
    assert found[lid, 2].sum() > 1e-3
    scale = np.abs(found).sum()
    assert_allclose(found.sum(axis=0), 0.0, atol=1e-13 * scale)
    assert_allclose(np.cross(state.position, found).sum(axis=0), 0.0, atol=1e-14 * scale)


def test_a_solid_that_is_cut_touches_with_its_faces():
    law = "contact is tools only; contact stiffness = 1 N/m"
    with pytest.raises(CompileError, match="its nodes are touched, of which cuts make copies"):
        compiled_scene(scene(PLATE, CUT.replace("X", "1000") + PRESS, law=law))
