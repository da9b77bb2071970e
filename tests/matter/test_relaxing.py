"""Matter that relaxes and yields is a Prony series and Bingham's body on every mesh."""

import numpy as np
import pytest

from tests.matter.elastic import scene

GEL = "Young's modulus = 10 kPa; density = 1 g/cm^3; retardation time = 0 ms"
SHARES = (
    "relaxing share = 30 %; relaxation time = 50 ms; "
    "second relaxing share = 20 %; second relaxation time = 5 ms"
)


def sheet(tissue, columns):
    rows = columns // 2 + 1
    network, _ = scene(
        tissue,
        "mesh is sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; "
        f"second edge = (0, 20, 0) mm; columns = {columns + 1}; rows = {rows}; "
        "diagonals is both }; thickness = 1 mm",
    )
    return network


@pytest.mark.parametrize("columns", [4, 12])
def test_shares_are_parts_of_the_stress_at_once_of_which_the_modulus_stays(columns):
    network = sheet(f"{GEL}; {SHARES}", columns)
    plain = sheet(GEL, columns)
    assert np.array_equal(network.springs.stiffness, plain.springs.stiffness)
    memory = network.springs.inelastic
    at_once = network.springs.stiffness + memory.constant.sum(axis=0)
    for row, (share, time) in enumerate([(0.3, 0.05), (0.2, 0.005)]):
        assert memory.constant[row] == pytest.approx(share * at_once, rel=1e-12)
        assert memory.time[row] == pytest.approx(np.full(len(at_once), time), rel=1e-12)
    assert network.springs.stiffness == pytest.approx(0.5 * at_once, rel=1e-12)


@pytest.mark.parametrize("columns", [4, 12])
def test_springs_yield_at_the_strain_of_the_yield_stress(columns):
    network = sheet(f"{GEL}; yield stress = 2 kPa; flow viscosity = 100 Pa*s", columns)
    memory = network.springs.inelastic
    length = np.linalg.norm(
        np.diff(network.position[network.springs.ends], axis=1)[:, 0], axis=1
    )
    assert memory.limit == pytest.approx(0.2 * network.springs.stiffness * length, rel=1e-12)
    # The rate of strain is the same for every spring: (stress - yield stress) / viscosity.
    assert memory.viscosity / network.springs.stiffness == pytest.approx(
        np.full(len(length), 100.0 / 10e3), rel=1e-12
    )
