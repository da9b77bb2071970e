"""Threads along fibres, and fibres that bodies cannot have."""

import numpy as np
import pytest

from tests.every import every
from tests.matter.elastic import scene
from tissuec.core.errors import CompileError

YOUNG, FIBRE = 10e3, 200e3
TISSUE = (
    f"Young's modulus = {YOUNG} Pa; fibre modulus = {FIBRE} Pa; density = 1000 kg/m^3; "
    "retardation time = 2 ms"
)
BAR = (
    "mesh is lattice { kind is sodium chloride; cell = 5 mm; "
    "box from (0, 0, 0) mm to (40, 20, 20) mm }"
)


def test_a_thread_runs_along_its_fibres():
    network, _ = scene(
        TISSUE,
        "mesh is thread { line from (0, 0, 0) mm to (40, 0, 0) mm; thickness = 2 mm; "
        "pieces = 4 }",
    )
    part = network.threads["piece"].pieces
    assert network.springs.stiffness[part] == pytest.approx(FIBRE * np.pi * 1e-6 / 0.01)


WRONG = {
    "fibres without a direction": (TISSUE, BAR, "TIS304"),
    "softer along than across": (
        TISSUE.replace("fibre modulus = 200", "fibre modulus = 2"),
        BAR + "; fibres = (1, 0, 0)",
        "TIS309",
    ),
    "around the axis of a bar": (TISSUE, BAR + "; fibres is axial", "TIS309"),
    "no direction at all": (TISSUE, BAR + "; fibres = (0, 0, 0)", "TIS308"),
    "a direction without fibres": (
        TISSUE.replace("fibre modulus = 200000.0 Pa; ", ""),
        BAR + "; fibres = (1, 0, 0)",
        "TIS306",
    ),
    "fibres in springs one by one": (
        "spring constant = 1 N/m; viscosity = 0 N*s/m; mass = 1 g; fibre modulus = 1 MPa",
        BAR + "; fibres = (1, 0, 0)",
        "TIS304",
    ),
    "unknown word": (TISSUE, BAR + "; fibres is spiral", "TIS305"),
    "across a sheet": (
        TISSUE,
        "mesh is sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = "
        "(0, 20, 0) mm; columns = 9; rows = 5 }; thickness = 1 mm; "
        "fibres = (0, 0, 1)",
        "TIS309",
    ),
}


@every("name", WRONG)
def test_fibres_that_cannot_be_are_told(name):
    tissue, body, code = WRONG[name]
    with pytest.raises(CompileError) as caught:
        scene(tissue, body)
    assert [one.code for one in caught.value.diagnostics if one.severity == "error"] == [code]
