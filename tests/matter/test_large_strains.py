"""What a cubic lattice of linear springs is at large strains, as ``docs/choosing.md`` says."""

import re

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import tissuec

MODULUS = 10e3  # [Pa]
EDGE = 10e-3  # [m]
SCENE = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body cube {
  made of springs
  mesh is lattice {
    kind is sodium chloride; reach is second neighbours
    cell = 10 mm; box from (0, 0, 0) mm to (10, 10, 10) mm
  }
  tissue is gel
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 s }
"""


@pytest.fixture(scope="module")
def network():
    return tissuec.compile(SCENE).network


def energy(network, stretches):
    """Return the elastic energy under a uniform deformation [J]."""
    first, second = (network.position[ends] * stretches for ends in network.springs.ends.T)
    length = np.linalg.norm(second - first, axis=1)
    return 0.5 * np.sum(network.springs.stiffness * (length - network.springs.rest) ** 2)


def free_sides(network, stretch):
    """Return the energy of a stretch along z with free sides [J]."""

    def of(side):
        return energy(network, (side, side, stretch))

    return minimize_scalar(
        of, bounds=(0.5, 1.5), method="bounded", options={"xatol": 1e-10}
    ).fun


def test_the_page_shows_stresses_relative_to_a_neo_hookean_material(network, repository):
    page = (repository / "docs" / "choosing.md").read_text(encoding="utf-8")
    sentence = re.search(r"a cubic lattice has ([^:]*?)\. A finer mesh", page, re.DOTALL)[1]
    shown = [float(number) for number in re.findall(r"\b[01]\.\d\d\b", sentence)]
    step = 1e-5
    for stretch, ratio in zip((0.8, 0.9, 1.1, 1.2), shown, strict=True):
        above, below = (free_sides(network, stretch + sign * step) for sign in (1, -1))
        stress = (above - below) / (2 * step * EDGE) / EDGE**2
        neo_hookean = MODULUS / 3 * (stretch - stretch**-2)
        assert stress / neo_hookean == pytest.approx(ratio, abs=0.005)  # as rounded there
