"""Derivatives of the reference's forces of elements, walls, bending, pressure and volumes."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene
from tests.validate.test_equations import Silent
from tissuec.validate.equations import Equations

GEL = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.4; density = 1000 kg/m^3
  retardation time = 20 ms }}
body one {{ {body}; tissue is gel }}
environment {{ gravity = (0, 0, 0) m/s^2; {environment} }}
script {{ {script} }}
simulate {{ duration = 10 ms }}
"""
SHEET = """mesh is sheet { corner = (0, 0, 0) mm; first edge = (10, 0, 0) mm
  second edge = (0, 10, 0) mm; columns = 3; rows = 3 }; thickness = 1 mm"""
STRIP = """mesh is sheet { corner = (0, 0, 0) mm; first edge = (100, 0, 0) mm
  second edge = (0, 10, 0) mm; columns = 41; rows = 3 }; thickness = 1 mm"""
BLOCK = "mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 5, 5) mm }"
BALL = """mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }
  thickness = 1 mm"""
PLANES = """symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)"""
CASES = {
    "long strip": (STRIP, "", ""),
    "sheet that bends": (SHEET, "", ""),
    "sheet between planes": (SHEET + "; bending is none", PLANES, ""),
    "block between planes": (BLOCK, PLANES, ""),
    "balloon": (BALL, "", "at 0 s: preserve volume of one with 10 kPa"),
    "balloon under pressure": (BALL, "", "at 0 s: press one with 500 Pa"),
}  # fmt: skip


def equations_of(case):
    """Return the equations of a body that is held at its lowest nodes, and its unknowns."""
    body, environment, script = CASES[case]
    text = GEL.format(body=body, environment=environment, script=script)
    scene = compiled_scene(text)
    state = scene.plan.start(scene.network)
    for event in scene.plan.events:
        event.action.apply(state, Silent())
    equations = Equations(state, 0.01)
    return equations, equations.gather(state.position, state.velocity, 0.0, 0.0)


@pytest.mark.parametrize("case", CASES)
def test_the_jacobian_is_the_derivative_of_the_rate(case):
    equations, y = equations_of(case)
    random, size = np.random.default_rng(3), 3 * len(equations.free)
    y[:size] += equations.matrices.kept(random.uniform(-3e-4, 3e-4, size))
    found = equations.jacobian(0.0, y).toarray()[size : 2 * size]
    for first, h in ((0, 1e-8), (size, 1e-4)):
        for column in random.choice(size, 12, replace=False):
            step = np.zeros_like(y)
            step[first + column] = h
            rates = [equations.rate(0.0, y + s)[size : 2 * size] for s in (step, -step)]
            expected = (rates[0] - rates[1]) / (2.0 * h)
            np.testing.assert_allclose(
                found[:, first + column], expected, atol=2e-6 * np.abs(found).max()
            )


def test_viscous_forces_are_differenced_in_few_groups():
    equations, _ = equations_of("long strip")
    (rows, columns), groups = equations.matrices.coupled(0.0, equations.drawn)
    assert sorted(np.concatenate(groups)) == list(range(len(equations.free)))
    assert len(groups) < 40 < len(equations.free)
    for group in groups:
        reached = rows[np.isin(columns, group)]
        assert len(np.unique(reached)) == len(reached)
