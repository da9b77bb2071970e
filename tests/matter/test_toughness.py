"""Bars break at the toughness of their tissue."""

import numpy as np
import pytest

from tests.matter.elastic import findings, scene

YOUNG, TOUGH = 10e3, 8.0
TISSUE = f"Young's modulus = {YOUNG} Pa; density = 1000 kg/m^3; retardation time = 1 ms"
WIDTH, HEIGHT = 96.0, 40.0  # of strips that are drawn across [mm]


BAR = (
    "mesh is thread { line from (0, 0, 0) mm to (40, 0, 0) mm; thickness = 2 mm; pieces = 4 }; "
    "rupture is allowed"
)


@pytest.mark.parametrize(
    "law",
    ["", "; stress of strain = 10 kPa * strain + 100 kPa * strain^3"],
    ids=["line", "curve"],
)
def test_a_bar_breaks_where_it_holds_the_energy_of_its_section(law):
    network, _ = scene(f"{TISSUE}; toughness = 2 J/m^2{law}", BAR)
    pieces = network.springs.ends[:, 1] - network.springs.ends[:, 0] == 1
    length, section = 10e-3, np.pi * 1e-6
    # ½ 1e4 ε² + ¼ 1e5 ε⁴ per volume, or only the first, times the length is the toughness.
    root = np.roots([0.25e5, 0.5e4, -2.0 / length]) if law else [2.0 * 2.0 / (length * 1e4)]
    strain = np.sqrt(max(root))
    stress = 1e4 * strain + (1e5 * strain**3 if law else 0.0)
    assert network.springs.strength[pieces] == pytest.approx(section * stress, rel=1e-9)


def test_toughness_says_the_same_as_the_force_of_springs():
    found = findings(f"{TISSUE}; toughness = 2 J/m^2; breaking force = 3 N", BAR)
    assert [one.code for one in found] == ["TIS306"]
