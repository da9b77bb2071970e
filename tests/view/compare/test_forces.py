"""Forces of two sides: which there are, and how their numbers differ."""

import json

import pytest

from tests.test_cli import tissuec
from tissuec.core.structs import replace
from tissuec.view.compare.parameters import compare_forces, forces_alone
from tissuec.view.compare.report import as_dict

BED = "force bed { kind is foundation; acts on low; stiffness = k; damping = 20 Pa*s/m }"
SCENE = f"""language 1
param k = 1 MPa/m
tissue gum {{ spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 5 mg }}
body net {{ mesh is lattice {{ kind is braced cubes; cell = 5 mm
  box from (0, 0, 0) mm to (5, 5, 5) mm }}
  tissue is gum }}
set low = nodes of net where z < 1 mm
set high = nodes of net where z > 4 mm
{BED}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
output {{ position of low every 1 ms; position of high every 1 ms }}
"""


@pytest.mark.parametrize("run", [False, True])
def test_numbers_of_forces_are_compared_and_told_with_their_lines(compared, told, run):
    found = compared(SCENE, SCENE.replace("stiffness = k", "stiffness = 4 * k"), run=run)
    (change,) = found.changes
    assert (change.quantity, change.part, change.what) == ("stiffness", "bed", "force")
    assert (change.a, change.b, change.relative) == (1e6, 4e6, 0.75)
    lines = told(found).splitlines()
    at = lines.index("  stiffness of the force bed: 1 MPa/m -> 4 MPa/m, 75 %")
    assert lines[at + 1].endswith(":9, written: stiffness = k")
    assert lines[at + 2].endswith(":9, written: stiffness = 4 * k")
    (plain,) = as_dict(found)["parameters"]
    assert (plain["a"], plain["dimension"]) == (1e6, "Pa/m")


def test_what_a_param_changes_and_what_is_left_out_is_found_too(compared, told):
    (change,) = compared(SCENE, SCENE.replace("k = 1", "k = 2")).changes
    assert (change.a, change.b) == (1e6, 2e6)
    found = compared(SCENE, SCENE.replace("; damping = 20 Pa*s/m", ""))
    assert "damping of the force bed: 20 Pa*s/m -> 0 Pa*s/m, 100 %" in told(found)
    assert told(found).count("default") == 1


def test_targets_and_forces_of_one_side_alone_are_told(compared, told):
    found = compared(SCENE, SCENE.replace("acts on low", "acts on high"))
    assert "target of the force bed: low -> high" in told(found)
    alone = told(compared(SCENE, SCENE.replace("force bed", "force bench")))
    assert "  only in a: the force bed\n  only in b: the force bench" in alone
    assert "identical: settings, nodes and springs, script" in alone


def test_results_without_numbers_of_forces_are_compared_otherwise(compared):
    a = compared(SCENE, SCENE).a
    older = replace(a, forces=None)
    assert not [*compare_forces(a, older), *compare_forces(older, a), *forces_alone(a, older)]


def test_explain_lists_the_numbers_of_forces_and_where_they_come_from(tmp_path):
    (tmp_path / "net.tis").write_text(SCENE.replace("; damping = 20 Pa*s/m", ""))
    lines = tissuec("explain", "net.tis", cwd=tmp_path).stdout.splitlines()
    at = next(
        n for n, line in enumerate(lines) if line.startswith("force bed: foundation on low")
    )
    assert lines[at].endswith("net.tis:9")
    assert lines[at + 1].split() == [
        "stiffness", "1", "MPa/m", "written", "stiffness", "=", "k", "net.tis:9"
    ]  # fmt: skip
    assert lines[at + 2].split() == ["damping", "0", "Pa*s/m", "default", "net.tis:9"]
    done = tissuec("explain", "net.tis", "--json", "--set", "k = 3 MPa/m", cwd=tmp_path)
    force = json.loads(done.stdout)["forces"]["bed"]
    stiffness = force["entries"]["stiffness"]
    assert (stiffness["value"], stiffness["unit"]) == (3e6, "Pa/m")
    assert force["acts_on"] == "low"
