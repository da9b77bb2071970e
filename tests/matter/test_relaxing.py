"""Bars that relax and yield are a Prony series and Bingham's body on every mesh."""

import numpy as np
import pytest

from tests.matter.elastic import scene

GEL = "Young's modulus = 10 kPa; density = 1 g/cm^3; retardation time = 0 ms"
SHARES = (
    "relaxing share = 30 %; relaxation time = 50 ms; "
    "second relaxing share = 20 %; second relaxation time = 5 ms"
)


def thread(tissue, pieces):
    network, _ = scene(
        tissue,
        "mesh is thread { line from (0, 0, 0) mm to (40, 0, 0) mm; thickness = 1 mm; "
        f"pieces = {pieces} }}",
    )
    return network


@pytest.mark.parametrize("pieces", [4, 12])
def test_shares_are_parts_of_the_stress_at_once_of_which_the_modulus_stays(pieces):
    network = thread(f"{GEL}; {SHARES}", pieces)
    plain = thread(GEL, pieces)
    assert np.array_equal(network.springs.stiffness, plain.springs.stiffness)
    stiffness, memory = network.springs.stiffness[:pieces], network.springs.inelastic
    at_once = stiffness + memory.constant.sum(axis=0)[:pieces]
    for row, (share, time) in enumerate([(0.3, 0.05), (0.2, 0.005)]):
        assert memory.constant[row, :pieces] == pytest.approx(share * at_once, rel=1e-12)
        assert memory.time[row, :pieces] == pytest.approx(np.full(pieces, time), rel=1e-12)
    assert stiffness == pytest.approx(0.5 * at_once, rel=1e-12)


@pytest.mark.parametrize("pieces", [4, 12])
def test_springs_yield_at_the_strain_of_the_yield_stress(pieces):
    network = thread(f"{GEL}; yield stress = 2 kPa; flow viscosity = 100 Pa*s", pieces)
    stiffness, memory = network.springs.stiffness[:pieces], network.springs.inelastic
    length = 0.04 / pieces
    assert memory.limit[:pieces] == pytest.approx(0.2 * stiffness * length, rel=1e-12)
    # The rate of strain is the same for every spring: (stress - yield stress) / viscosity.
    assert memory.viscosity[:pieces] / stiffness == pytest.approx(
        np.full(pieces, 100.0 / 10e3), rel=1e-12
    )
