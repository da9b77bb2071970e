"""Contact of faces where forces balance, against closed forms and limits."""

import numpy as np
import pytest

import tissuec
from benchmarks.solid_costs import INDENTED, PROBLEMS
from tests.validate.scenes import compiled_scene
from tissuec.compiler.contact.points import AT_REST, HARDNESS

PRESSED = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body block {{ mesh is lattice {{ cell = 4 mm; box from (0, 0, 0) mm to (8, 8, 4) mm }}
  tissue is gel }}
tool ball {{ kind is probe; radius = 6 mm; centre = (4, 4, 9.8) mm }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only; {entry} }}
script {{ at 0 s: fix block
  {script} }}
simulate {{ duration = 1 ms; {integrator} }}
output {{ force of ball every 1 ms }}
"""
HERTZ = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body block {{
  mesh is lattice {{
    cell = {wide:.15g} mm; box from (0, 0, 0) mm to ({high}, {high}, {high}) mm
    fine cell = {fine:.15g} mm; fine box from (0, 0, {below}) mm to (2.5, 2.5, {high}) mm
  }}
  tissue is gel
}}
set base = nodes of block where z == 0 mm
tool ball {{ kind is probe; radius = 20 mm; centre = (0, 0, {centre}) mm }}
environment {{
  gravity = (0, 0, 0) m/s^2; contact is tools only; friction = 0
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}}
script {{
  at 0 s: fix base
  from 0 us to 1 us: move ball by (0, 0, -{depth:.15g}) mm using constant speed
  at 1 us: settle
}}
simulate {{ duration = 2 us; integrator is dop853 }}
output {{ force of ball every 2 us; force(base) every 2 us }}
"""


def hardness(script="", integrator="", entry=""):
    """Return k h/E* of the points of a scene, shape (point,)."""
    network = compiled_scene(
        PRESSED.format(script=script, integrator=integrator, entry=entry)
    ).network
    points = network.contact.between
    own = network.contact.stiffness[-len(points.areas) :]
    return own / points.areas * 4e-3 / (10e3 / 0.91)


@pytest.mark.parametrize(
    ("script", "integrator"),
    [
        ("at 0.5 ms: settle", "integrator is dop853"),
        ("at 0.5 ms: settle block", ""),
        ("from 0.2 ms to 0.5 ms: settle", ""),
        ("when force(ball) > 1 N: settle", ""),
        ("", "integrator is equilibrium"),
    ],
)
def test_contact_is_firmer_where_forces_are_to_balance(script, integrator):
    assert hardness(script, integrator) == pytest.approx(AT_REST, rel=1e-12)


@pytest.mark.parametrize("integrator", ["", "integrator is dop853", "integrator is trbdf2"])
def test_it_does_not_shorten_the_steps_of_what_only_moves(integrator):
    assert hardness(integrator=integrator) == pytest.approx(HARDNESS, rel=1e-12)


def test_what_is_written_holds_everywhere():
    written = "contact surface stiffness = 20 MPa/m"
    alike = [hardness(script, entry=written) for script in ("", "at 0.5 ms: settle")]
    assert alike[0] == pytest.approx(20e6 * 4e-3 / (10e3 / 0.91), rel=1e-12)
    assert (alike[0] == alike[1]).all()


def indented(cells, friction=0):
    """Return the force [mN] of a ball that indents a block by a fifth, by cells in 4 mm."""
    text = INDENTED.format(cell=4.0 / cells)
    text = text.replace("friction = 0\n", f"friction = {friction}\n")
    with tissuec.run(text, companion="off") as run:
        assert run.finished
        return -4e3 * float(run.logs["force of ball"].value[-1, 2])


#: With ever stiffer contact, the force tends to 205.6, 197.6 and 195.2 mN with 2, 3 and 4 cells
#: in 4 mm, and from there with the square of the cells to this one, within 0.5 mN. The
#: axisymmetric solution of ``benchmarks.indentation`` tends to 192.0 mN for a cylinder.
RIGID = 192.0


def test_a_ball_on_few_cells_presses_as_a_rigid_one_on_smooth_tissue():
    assert PROBLEMS["ball, 20 %, ν = 0.3"].known == RIGID
    assert indented(2) == pytest.approx(RIGID, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0, 0.3])
def test_a_ball_on_more_cells_is_within_a_percent(friction):
    # After the motion, ``settle`` ignores friction.
    assert indented(3, friction) == pytest.approx(RIGID, rel=0.01)


def of_a_layer(radius, depth, height, young, nu):
    """Return the force [N] of a rigid ball on an elastic layer whose base is held.

    Hertz's law with the terms of the height by E. K. Dimitriadis et al., Biophys. J. 82:2798
    (2002), equation 8.
    """
    alpha = -(1.2876 - 1.4678 * nu + 1.3442 * nu**2) / (1.0 - nu)
    beta = (0.6387 - 1.0277 * nu + 1.5164 * nu**2) / (1.0 - nu)
    chi, pi = np.sqrt(radius * depth) / height, np.pi
    hertz = 4.0 / 3.0 * young / (1.0 - nu**2) * np.sqrt(radius) * depth**1.5
    cubic = alpha**3 + 4.0 * pi**2 / 15.0 * beta
    quartic = alpha**3 + 3.0 * pi**2 / 5.0 * beta
    return hertz * (
        1.0 - 2.0 * alpha / pi * chi + 4.0 * (alpha / pi * chi) ** 2
        - 8.0 / pi**3 * cubic * chi**3 + 16.0 * alpha / pi**4 * quartic * chi**4
    )  # fmt: skip


def hertz_error(cells, depth, high):
    """Return the relative error of the force of a ball on a block.

    Args:
        cells: In 2 mm.
        depth: Of the ball [mm].
        high: Height of the block [mm], half its width.
    """
    text = HERTZ.format(
        fine=2.0 / cells, depth=depth, wide=high / 4, high=high, below=high - 1,
        centre=high + 20,
    )  # fmt: skip
    with tissuec.run(text, companion="off") as run:
        assert run.finished
        on_ball, on_base = (run.logs[name].value[-1, 2] for name in run.logs)
    # What is observed is what acts: the base bears what the ball does.
    assert on_base == pytest.approx(-on_ball, rel=1e-6)
    return -4.0 * float(on_ball) / of_a_layer(20e-3, 1e-3 * depth, 1e-3 * high, 10e3, 0.3) - 1.0


def test_a_ball_whose_contact_has_a_radius_of_two_cells_presses_as_hertz_says():
    # With the firmness of scenes that only move, it would press with 2.5 % less.
    assert abs(hertz_error(3, 0.1, 20)) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("depth", [0.1, 0.2, 0.28])
def test_on_eight_cells_hertz_holds_within_three_percent(depth):
    # The contact has a radius of 5.7, 8 and 9.5 cells.
    assert abs(hertz_error(8, depth, 40)) < 0.03
