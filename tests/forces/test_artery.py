"""A thick tube under pressure from within, against the integral over its incompressible wall.

In plane strain, a point at R comes to r = √(a² + R² - A²), with λ = r/R, I1 = λ² + 1/λ² + 1 and

    p = ∫_A^B 2 ∂W/∂I1 (λ² - 1/λ²) R/r² dR.

(R. W. Ogden, Non-Linear Elastic Deformations, 1984, section 5.3.)
"""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out

INNER, OUTER, YOUNG = 4e-3, 6e-3, 100e3
SCENE = """language 1
tissue media {{
  Young's modulus = 100 kPa; Poisson's ratio = 0.4999; density = 1100 kg/m^3
  {law}
}}
body artery {{
  mesh is thick tube {{
    axis from (0, 0, 0) mm to (0, 0, 1) mm; outer radius = 6 mm
    rings = 2; {mesh}; part is quarter
  }}
  tissue is media
  {fibres}
}}
environment {{
  gravity = (0, 0, 0) m/s^2
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)
  symmetric about plane through (0, 0, 1) mm facing (0, 0, -1)
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}}
script {{
{steps}
}}
simulate {{ duration = 6 us; integrator is dop853 }}
output {{ trajectory every 2 us }}
"""
RADIUS = "inner radius = 4 mm"
LAWS = {
    "neo-Hookean": ("", lambda z: 0.5, (2e3, 4e3, 6e3)),
    "exponential": (
        "solid law is exponential { stiffening = 2 }",
        lambda z: 0.5 * np.exp(2.0 * z),
        (4e3, 8e3, 16e3),
    ),
}


def radii(law, pressures, mesh=RADIUS, fibres=""):
    """Return the inner radius under each pressure [m], found by ``settle``.

    It is that of a circle with the area of the lumen, not that of its corners.
    """
    added = np.diff([0.0, *pressures])
    steps = "\n".join(
        f"  at {2 * k} us: {{ press inside of artery with {one} Pa; settle }}"
        for k, one in enumerate(added)
    )
    compiled = compiled_scene(SCENE.format(law=law, steps=steps, mesh=mesh, fibres=fibres))
    outcome, recording = carried_out(compiled)
    assert outcome.kind == "done", outcome.message
    drawn = np.linalg.norm(compiled.network.position[:, :2], axis=1)
    inner = drawn < 1.001 * drawn.min()
    position = recording.frame_arrays()[1]
    corners = np.linalg.norm(position[:, inner, :2], axis=2).mean(axis=1)[: len(pressures)]
    return INNER / drawn.min() * corners


def exact(slope, pressure, fibres=lambda square: 0.0):
    """Return the inner radius under a pressure [m].

    Args:
        slope: 1/μ ∂W/∂I1 of I1 - 3.
        pressure: [Pa].
        fibres: Their part of λ ∂W/∂λ [Pa], of λ².
    """

    def held(radius):
        def of(drawn):
            now = np.sqrt(radius**2 + drawn**2 - INNER**2)
            square = (now / drawn) ** 2
            stress = 2.0 * slope(square + 1.0 / square - 2.0) * (square - 1.0 / square)
            return (YOUNG / 3.0 * stress + fibres(square)) * drawn / now**2

        return quad(of, INNER, OUTER)[0]

    return brentq(lambda radius: held(radius) - pressure, INNER, 3.0 * INNER)


@pytest.mark.parametrize("name", LAWS)
def test_an_artery_widens_as_its_incompressible_wall_does(name):
    law, slope, pressures = LAWS[name]
    wanted = np.array([exact(slope, pressure) for pressure in pressures]) - INNER
    wrong = [
        np.abs((radii(law, pressures, mesh) - INNER) / wanted - 1.0).max()
        for mesh in (f"{RADIUS}; sides = 16; layers = 2", RADIUS, f"{RADIUS}; layers = 6")
    ]
    # By default, 32 cells are around the tube, and three across its wall. Pressure alone
    # needs cells across it, and none around.
    assert wrong[0] < 0.03 and wrong[1] < 0.01
    assert wrong[1] < 0.5 * wrong[0] and wrong[2] < 0.3 * wrong[1]


@pytest.mark.parametrize("angle", [20.0, 40.0])
def test_two_families_of_fibres_stiffen_an_artery_as_they_should(angle):
    law = "fibre modulus = 300 kPa; fibre stiffening = 0.8"
    around = np.cos(np.radians(angle)) ** 2

    def fibres(square):
        e = around * (square - 1.0)  # |F a|² - 1 in plane strain
        return 2.0 * (50e3 * e * np.exp(0.8 * e * e)) * 2.0 * square * around

    pressures = (5e3, 10e3, 20e3)
    wanted = [exact(lambda z: 0.5, pressure, fibres) - INNER for pressure in pressures]
    families = f"fibres = {angle} deg; second fibres = -{angle} deg"
    found = radii(law, pressures, fibres=families)
    assert found - INNER == pytest.approx(wanted, rel=0.01)
