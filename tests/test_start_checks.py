"""Checks of how a scene starts: what warns, and what rightly does not."""

import pytest

import tissuec
from tissuec.compiler import start_checks

STRIP = """language 1
tissue cord {{ spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 10 mg; prestress = {p} }}
body strip {{
  mesh is sheet {{
    corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = 5; rows = 3; diagonals is both
  }}
  tissue is cord
}}
set left = nodes of strip where x < 1 mm
set right = nodes of strip where x > 19 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: {{ fix left; hold right{settle} }}
  {later} }}
simulate {{ duration = 1 s }}
output {{ force of left every 1 ms }}
"""
PULL = "from 0 s to 0.1 s: move right by (1, 0, 0) mm using smooth profile"
LATER = "from 0.5 s to 0.6 s: move right by (1, 0, 0) mm using smooth profile"


def codes(text):
    return [finding.code for finding in tissuec.check(text)]


@pytest.mark.parametrize(
    ("p", "settle", "later", "warns"),
    [
        ("5 %", "", "", True),
        ("5 %", "", PULL, True),
        ("5 %", "; settle", PULL, False),
        ("5 %", "", LATER, False),  # it waits for the net to come to rest
        ("0 %", "", PULL, False),
    ],
)
def test_prestress_out_of_balance_is_warned_of(p, settle, later, warns):
    text = STRIP.format(p=p, settle=settle, later=later)
    assert ("W309" in codes(text)) is warns


def test_a_straight_cord_between_its_ends_is_in_balance():
    text = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 10 mg; prestress = 5 % }
body rope { mesh is explicit; tissue is cord }
table nodes of rope in mm with columns "id x" { 1 0; 2 5; 3 10 }
table springs of rope with columns "a b" { 1 2; 2 3 }
set ends = nodes of rope in [1, 3]
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix ends }
simulate { duration = 1 s }
"""
    assert "W309" not in codes(text)
    assert "W309" in codes(text.replace("3 10 }", "3 11 }"))


def test_a_long_run_names_the_tissue_that_causes_it():
    text = """language 1
tissue soft { Young's modulus = 5 kPa; density = 1000 kg/m^3; retardation time = 0 s }
tissue stiff { Young's modulus = 72 MPa; density = 1000 kg/m^3; retardation time = 0 s }
body block {
  mesh is lattice {
    kind is sodium chloride; cell = 2 mm; reach is second neighbours
    box from (0, 0, 0) mm to (20, 20, 10) mm
  }
  tissue is soft
  region layer where z > 7 mm { tissue is stiff }
  interface is mean
}
set base = nodes of block where z < 0.1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix base }
simulate { duration = 100 s; integrator is dop853 }
"""
    (found,) = (one for one in tissuec.check(text) if one.code == "W413")
    assert found.notes[0].span.line == 3
    assert "W413" not in codes(text.replace("100 s;", "10 ms;"))


def test_expensive_implicit_steps_name_the_largest_body(monkeypatch):
    text = """language 1
tissue soft { Young's modulus = 5 kPa; density = 1000 kg/m^3; retardation time = 50 ms }
tissue stiff { Young's modulus = 72 kPa; density = 1000 kg/m^3; retardation time = 50 ms }
body small { mesh is LATTICE to (10, 10, 4) mm }; tissue is stiff }
body large { mesh is LATTICE to (20, 20, 10) mm }; tissue is soft }
environment { gravity = (0, 0, 0) m/s^2; contact is off }
simulate { duration = 1 ms; integrator is esdirk43 }
""".replace(
        "LATTICE",
        "lattice { kind is sodium chloride; cell = 2 mm; reach is second neighbours; "
        "box from (0, 0, 0) mm",
    )
    assert "W413" not in codes(text)
    monkeypatch.setattr(start_checks, "MANY_SPRINGS", 100)
    assert "W413" not in codes(text)  # 100 steps take less than a minute
    monkeypatch.setattr(start_checks, "LONG", 1e-2)
    (found,) = (one for one in tissuec.check(text) if one.code == "W413")
    assert "a step of esdirk43 takes about" in found.message
    assert "of large" in found.message
    assert found.notes[0].span.line == 2
