"""Nodes that are held or moved in some directions, and free in the others."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import tissuec
from tests.every import every
from tests.findings import finding_of
from tests.validate.scenes import compiled_scene, validated
from tests.whole_runs import same_on_two_threads, same_when_resumed

#: Lamé's constants of the gel [Pa].
YOUNG, POISSON = 10e3, 0.3
LAMBDA = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
MU = YOUNG / (2.0 * (1.0 + POISSON))
SCENE = """language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  solid law is coupled neo hookean{tissue}
}}
body block {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }}
  made of elements; tissue is gel{body}
}}
set bottom = nodes of block where z < 0.01 mm
set top = nodes of block where z > 9.99 mm
set left = nodes of block where x < 0.01 mm
set right = nodes of block where x > 9.99 mm
set front = nodes of block where y < 0.01 mm
environment {{ gravity = {gravity} m/s^2{damping} }}
script {{
{script}
}}
simulate {{ duration = {duration} ms{method} }}
output {{
  trajectory every 10 ms; force(top) every 10 ms; force(left) every 10 ms; energy every 1 ms
}}
"""
ROLLERS = """at 0 s: {
  fix bottom along (0, 0, 1); fix left along (1, 0, 0); fix front along (0, 1, 0)
}"""
PATH = "from 0 s to 50 ms: move top by (0, 0, -3) mm along (0, 0, 1) using"
SMOOTH = f"{ROLLERS}\n{PATH} smooth profile"
EVEN = f"{ROLLERS}\n{PATH} constant speed"
STATIC = "; integrator is equilibrium; step = 10 ms"


def scene(script=SMOOTH, method="", duration=60, tissue="", gravity="(0, 0, 0)", damping="",
          body=""):  # fmt: skip
    return SCENE.format(
        script=script, method=method, duration=duration, tissue=tissue, gravity=gravity,
        damping=damping, body=body,
    )  # fmt: skip


def run(text):
    return tissuec.run(text, companion="off")


def width_and_stress(height):
    """Return the stretch across and the nominal stress [Pa] of a block with free sides.

    Nominal stresses are μ (λ - 1/λ) + Λ ln J/λ; the one across is zero.
    """
    from scipy.optimize import brentq

    def across(wide):
        return MU * (wide - 1.0 / wide) + LAMBDA * np.log(wide**2 * height) / wide

    wide = float(brentq(across, 0.5, 2.0, xtol=1e-15))
    volume = np.log(wide**2 * height)
    return wide, MU * (height - 1.0 / height) + LAMBDA * volume / height


def test_smooth_plates_press_a_block_as_the_closed_form_says():
    """All strains are homogeneous: equilibria are exact but for the tolerance of Newton's
    method.
    """
    found = run(scene(EVEN, STATIC))
    wide, stress = width_and_stress(0.7)
    stretch = np.array([wide, wide, 0.7])
    assert_allclose(found.position[-1], found.position[0] * stretch, rtol=0, atol=1e-11)
    force = np.array(found.logs["force of top"].value)[-1]
    assert_allclose(force, [0.0, 0.0, stress * 1e-4], rtol=1e-9, atol=1e-9 * 0.4)


def test_sides_that_are_held_bear_their_part():
    """Between rollers on both sides, the block cannot widen along x."""
    script = EVEN + "\nat 0 s: fix right along (1, 0, 0)"
    found = run(scene(script, STATIC))
    force = np.array(found.logs["force of left"].value)[-1, 0]
    sides = found.position[-1][:, 0] - found.position[0][:, 0]
    assert np.abs(sides).max() < 1e-15
    # By the energy μ (I - 3)/2 - μ ln J + Λ ln² J/2 with stretches 1, w and 0.7.
    from scipy.optimize import brentq

    def across(wide):
        return MU * (wide - 1.0 / wide) + LAMBDA * np.log(0.7 * wide) / wide

    wide = float(brentq(across, 0.5, 2.0, xtol=1e-15))
    pressure = LAMBDA * np.log(0.7 * wide)  # nominal, with the stretch 1: μ (1 - 1) + Λ ln J
    assert force == pytest.approx(-pressure * 10e-3 * 10e-3, rel=1e-9)


def test_planes_of_symmetry_hold_the_same():
    planes = " ".join(
        f"\n  symmetric about plane through (0, 0, 0) mm facing {way}"
        for way in ("(1, 0, 0)", "(0, 1, 0)", "(0, 0, 1)")
    )
    moved = f"{PATH} smooth profile"
    one, other = run(scene(SMOOTH, STATIC)), run(scene(moved, STATIC, damping=planes))
    assert_allclose(one.position, other.position, rtol=0, atol=1e-11)


def test_the_balance_of_energy_is_closed():
    """The work of what moves the top is what is stored and moves, to the tolerance."""
    way = "move top by (0, 0, 1) mm along (0, 0, 1) using sine of 40 Hz"
    script = f"{ROLLERS}\nfrom 0 s to 60 ms: {way}"
    weighed = {"gravity": "(0, 0, -9.81)", "damping": "; damping = 1 mN*s/m"}
    found = run(scene(script, "; tolerance = 1e-6", **weighed))
    kinetic, stored, gravity, work, lost, switched = np.array(found.energies.value).T
    total = kinetic + stored + gravity
    assert_allclose(total - total[0], work - lost + switched, rtol=0, atol=1e-5 * work.max())
    assert work.max() > 10.0 * np.abs(kinetic).min()


def test_free_directions_keep_their_momentum():
    """A block that can only slide along x goes on as it began, whatever it weighs."""
    script = "at 0 s: fix block across (1, 0, 0)"
    text = scene(script, gravity="(0, 0, -9.81)", body="; velocity = (0.1, 0, 0.3) m/s")
    found = run(text)
    shift = found.position[-1] - found.position[0]
    mass = compiled_scene(text).network.mass
    assert_allclose(mass @ shift / mass.sum(), [6e-3, 0.0, 0.0], rtol=0, atol=1e-12)
    assert np.abs(shift[:, 1:]).max() < 1e-15


def test_directions_turn_with_the_scene():
    """Oblique directions, of which no two are perpendicular, hold as the axes do."""
    script = """at 0 s: {
  fix bottom along (0, 0, 1); fix left along (1, 0, 0); fix front along (0, 1, 0)
  fix edge along (1, 1, 1)
}
from 0 s to 50 ms: move top by (0, 0, -3) mm along (0, 0, 1) using smooth profile"""
    text = scene(script, STATIC).replace(
        "environment",
        "set edge = nodes of block where z > 9.99 mm and x > 9.99 mm\nenvironment",
    )
    found = run(text)
    shift = found.position[-1] - found.position[0]
    edge = (found.position[0][:, 2] > 9.99e-3) & (found.position[0][:, 0] > 9.99e-3)
    assert_allclose(shift[edge].sum(axis=1), 0.0, rtol=0, atol=1e-15)
    assert_allclose(shift[edge][:, 2], -3e-3, rtol=0, atol=1e-15)


METHODS = ("dop853", "esdirk43", "rkc2", "rkn4", "srkn11", "trbdf2")


@every("method", METHODS)
def test_every_method_follows_the_same_path(method):
    found = run(scene(SMOOTH, f"; integrator is {method}", tissue="; retardation time = 1 ms"))
    exact = run(scene(SMOOTH, "; tolerance = 1e-7", tissue="; retardation time = 1 ms"))
    assert_allclose(found.position[-1], exact.position[-1], rtol=0, atol=3e-4 * 3e-3)
    top = exact.position[0][:, 2] > 9.99e-3
    assert_allclose(found.position[-1][top, 2], 7e-3, rtol=0, atol=1e-15)


@pytest.mark.parametrize("script", [SMOOTH, f"{ROLLERS}\nat 0 s: push top with (0, 0, -0.2) N"])
def test_scipy_finds_the_same_motion(script):
    found = validated(scene(script, "; tolerance = 1e-5", tissue="; retardation time = 2 ms"))
    assert found.verdict == "kept", found.reasons


def test_scipy_finds_the_same_equilibria():
    found = validated(scene(SMOOTH, STATIC))
    for one in found.comparison.quantities:
        if one.name != "force of left":  # which is zero
            assert one.error < 1e-9, one.name


def test_a_hold_ends_and_nodes_go_on():
    script = "\n".join([
        "at 0 s: fix bottom",
        "from 0 s to 20 ms: hold top along (0, 0, 1)",
        "at 0 s: push top with (0.01, 0, 0.01) N",
    ])  # fmt: skip
    found = run(scene(script))
    top = found.position[0][:, 2] > 9.99e-3
    shift = found.position - found.position[0]
    held = found.times < 0.0201
    assert np.abs(shift[held][:, top, 2]).max() < 1e-15
    assert np.abs(shift[held][:, top, 0]).max() > 1e-6
    assert np.abs(shift[-1][top, 2]).max() > 1e-6


@every(
    ("ends", "is_free"),
    [("free top", True), ("release top", True), ("stop moving top", False)],
)
def test_motions_in_a_direction_end(ends, is_free):
    script = f"{SMOOTH.replace('smooth profile', 'constant speed')}\nat 20 ms: {ends}"
    found = run(scene(script))
    top = found.position[0][:, 2] > 9.99e-3
    height = found.position[:, top, 2]
    assert_allclose(height[2], 10e-3 - 1.2e-3, rtol=0, atol=1e-12)
    assert (np.abs(height[-1] - height[2]).max() > 1e-6) == is_free


def test_a_later_order_along_the_same_direction_wins():
    script = f"{ROLLERS}\nat 0 s: fix top across (1, 0, 0)\n{PATH} smooth profile"
    found = run(scene(script, STATIC))
    top = found.position[0][:, 2] > 9.99e-3
    shift = (found.position[-1] - found.position[0])[top]
    assert_allclose(shift[:, 2], -3e-3, rtol=0, atol=1e-15)
    assert np.abs(shift[:, 1]).max() < 1e-15 and np.abs(shift[:, 0]).max() > 1e-4


def test_threads_and_resuming_change_no_bit(threads_in_small_nets):
    fine = scene(SMOOTH, "; integrator is dop853", duration=2)
    compiled = compiled_scene(fine.replace("cell = 5 mm", "cell = 0.5 mm"))
    same_on_two_threads(compiled, "force of top")
    same_when_resumed(compiled_scene(scene()), "force of top", 4, 7)


@every(
    ("sentence", "said"),
    [
        ("at 0 s: fix top along (0, 0, 1) across (1, 0, 0)", "along a direction, or across"),
        ("from 0 s to 9 ms: move top by (1, 0, 1) mm along (0, 0, 1) using constant speed",
         "the motion leaves the directions in which the nodes are held"),
        ("from 0 s to 9 ms: move top by (0, 0, 1) mm across (0, 0, 1) using constant speed",
         "the motion leaves the directions in which the nodes are held"),
        ("at 0 s: fix top along (0, 0, 0)", "direction"),
        ("at 0 s: { fix top along (0, 0, 1); fix top along (1, 0, 0) }\n"
         "at 0 s: fix top along (1, 0, 1)",
         "the directions in which these nodes are held depend on one another"),
    ],
)  # fmt: skip
def test_wrong_directions_are_refused(sentence, said):
    assert said in finding_of(compiled_scene, scene(sentence)).message
