"""Params and sets that nothing uses: the scene's own, those of files, and with ``--set``."""

from pathlib import Path

import pytest

from tissuec.pipeline import check_request
from tissuec.scene.request import Request

SCENE = """language 1
use "./preset"
param k = 100 N/m
param bed stiffness = 1 MPa/m
let softer = bed stiffness / 2
param fineness = 1e-3
tissue gum { spring constant = k; viscosity = 0 N*s/m; mass = mass }
body net { mesh is lattice { kind is braced cubes; cell = 5 mm
  box from (0, 0, 0) mm to (10, 10, 10) mm }
  tissue is gum }
set low = nodes of net where z < 1 mm
set lower = nodes of net where z < 2 mm
force bed { kind is foundation; acts on low; stiffness = softer }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms; tolerance = fineness; integrator is velocity verlet }
output { position of lower every 1 ms }
"""
PRESET = """language 1
param mass = 1 mg
param idle mass = 2 mg
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "preset.tis").write_text(PRESET)
    path = tmp_path / "scene.tis"
    path.write_text(SCENE)
    return path


def unused(path: Path, *overrides: str) -> list[str]:
    warnings = check_request(Request.file(path, overrides=overrides))[1]
    return [w.message for w in warnings if w.code in ("W501", "W502")]


@pytest.mark.parametrize(
    "override",
    ["stiffness of bed = 3 MPa/m", "spring constant of gum = 2 N/m", "tolerance = 1e-4",
     "step = 1 us", "k = 3 N/m", "mass = 3 mg"],
)  # fmt: skip
def test_what_an_entry_used_before_it_was_set_is_no_mistake_of_the_scene(scene, override):
    assert unused(scene, override) == []


def test_what_nothing_uses_is_reported(scene):
    scene.write_text(SCENE + "param idle = 1\nset nobody = nodes of net where z < 3 mm\n")
    expected = ['the param "idle" is never used', 'the set "nobody" is never used']
    assert unused(scene, "stiffness of bed = 3 MPa/m") == expected


def test_a_param_of_a_file_is_reported_only_if_it_is_set(scene):
    assert unused(scene) == []
    assert unused(scene, "idle mass = 3 mg") == ['the param "idle mass" is never used']
