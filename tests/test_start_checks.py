"""Checks of how a scene starts: what warns, and what rightly does not."""

from pathlib import Path

import pytest

import tissuec
from tissuec.compiler.checks import starts as start_checks

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
tissue soft { spring constant = 5 N/m; density = 1000 kg/m^3; retardation time = 0 s }
tissue stiff { spring constant = 72000 N/m; density = 1000 kg/m^3; retardation time = 0 s }
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
tissue soft { spring constant = 5 N/m; density = 1000 kg/m^3; retardation time = 50 ms }
tissue stiff { spring constant = 72 N/m; density = 1000 kg/m^3; retardation time = 50 ms }
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


FALLING = """language 1
tissue gum { spring constant = 40 N/m; viscosity = 0.01 N*s/m; mass = 10 mg }
body block {
  made of springs
  mesh is lattice {
    kind is sodium chloride; cell = 5 mm; reach is second neighbours
    box from (0, 0, 0) mm to (10, 10, 10) mm
  }
  tissue is gum
}
set side = nodes of block where x < 1 mm
set top = nodes of block where z > 9 mm
tool forceps { kind is forceps }
environment { gravity = (0, 0, -9.81) m/s^2 }
simulate { duration = 0.2 s }
output { position of top every 0.2 s }
"""
WEIGHTLESS = "gravity = (0, 0, 0) m/s^2"
BALL = "tool ball { kind is probe; radius = 4 mm; centre = "
OTHER = FALLING[FALLING.index("body block") : FALLING.index("set side")].replace(
    "body block", "body tray"
)
ABOVE = OTHER.replace("(0, 0, 0) mm to (10, 10, 10)", "(0, 0, 20) mm to (10, 10, 30)")
BELOW = OTHER.replace("(0, 0, 0) mm to (10, 10, 10)", "(0, 0, -30) mm to (10, 10, -20)")
FIXED = "set tray side = nodes of tray where x < 1 mm\nscript { at 0 s: fix tray side }"


def unheld(*more, environment="gravity = (0, 0, -9.81) m/s^2"):
    """Return what is said of bodies that nothing holds."""
    text = FALLING.replace("gravity = (0, 0, -9.81) m/s^2", environment)
    found = tissuec.check("\n".join([text, *more]))
    return [one.message for one in found if one.code == "W310"]


def test_a_body_that_nothing_holds_is_warned_of_where_something_drives_it():
    falls = ["nothing holds block: it falls by 196 mm"]  # g t²/2
    gravity = "gravity = (0, 0, -9.81) m/s^2"
    assert unheld() == falls
    assert not unheld(environment=WEIGHTLESS)
    assert not unheld("script { at 0 s: fix side }")
    assert not unheld("script { when speed(top) > 1 mm/s: fix side }")
    assert not unheld("expect position(top along (0, 0, 1)) < 0 mm at 0.2 s")
    assert unheld("expect pieces(block) == 1 at 0.2 s") == falls
    assert not unheld("script { at 0 s: push top with (0, 0, 1) N }")  # it may be lifted
    assert unheld("script { at 0 s: push top with (1, 0, 0) N }") == falls
    # Within 20 ms it falls by 2 mm, an eighth of its size; within 0.1 s by three times that.
    assert not unheld("script { at 20 ms: grasp side with forceps }")
    assert unheld("script { at 0.1 s: grasp side with forceps }") == [
        "nothing holds block before 100 ms: it falls by 49.1 mm"
    ]
    assert unheld(environment=f"{gravity}; contact is tools only") == falls


def test_a_body_that_contact_can_catch_is_not_warned_of():
    tools = "gravity = (0, 0, -9.81) m/s^2; contact is tools only"
    bodies = tools.replace("tools only", "everywhere")
    assert unheld(f"{BALL}(5, 5, 20) mm }}", environment=tools)
    assert unheld(f"{BALL}(90, 5, -20) mm }}", environment=tools)
    assert not unheld(f"{BALL}(5, 5, -20) mm }}", environment=tools)
    down = "script { from 0 s to 0.1 s: move ball by (0, 0, -20) mm using smooth profile }"
    assert not unheld(f"{BALL}(5, 5, 20) mm }}", down, environment=tools)
    floor = "tool floor { kind is plane; point = (0, 0, -9) mm; normal = (0, 0, 1) }"
    assert not unheld(floor, environment=tools)
    assert not unheld(BELOW, FIXED, environment=bodies)
    assert len(unheld(BELOW, FIXED, environment=tools)) == 1
    assert len(unheld(ABOVE, FIXED, environment=bodies)) == 1
    assert len(unheld(BELOW, environment=bodies)) == 2
    # What lies on what is caught is caught.
    assert not unheld(ABOVE, f"{BALL}(5, 5, -20) mm }}", environment=bodies)
    assert len(unheld(ABOVE, f"{BALL}(5, 5, -20) mm }}", environment=tools)) == 0


def test_pushes_on_a_free_body_are_warned_of_unless_they_balance():
    pull = "script { at 0 s: push top with (0, 0, 1) N }"
    assert unheld(pull, environment=WEIGHTLESS) == [
        "nothing holds block: pushes of 1 N in all drive it away"
    ]
    both = "script { at 0 s: { push top with (0, 0, 1) N; push side with (0, 0, -1) N } }"
    assert not unheld(both, environment=WEIGHTLESS)
    later = "script { at 0 s: push top with (0, 0, 1) N; at 0.1 s: fix side }"
    assert not unheld(later.replace("; at", "\nat"), environment=WEIGHTLESS)


EIGHTH = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
body cube {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }; tissue is gel
}
set far = nodes of cube where x > 9.9 mm
environment { gravity = (0, 0, 0) m/s^2; PLANES }
script { at 0 s: push far with WAY N }
simulate { duration = 10 ms }
"""
MIRROR = "symmetric about plane through (0, 0, 0) mm facing"


@pytest.mark.parametrize(
    ("facing", "way", "left"),
    [
        ([], "(1, 0, 0)", "1"),
        (["(1, 0, 0)"], "(1, 0, 0)", ""),
        (["(-1, 0, 0)"], "(1, 0, 0)", ""),
        (["(1, 0, 0)", "(0, 1, 0)"], "(1, 1, 0)", ""),
        (["(1, 0, 0)", "(0, 1, 0)"], "(1, 0, 2)", "2"),
        (["(1, 0, 0)", "(0, 1, 0)", "(0, 0, 1)"], "(1, 2, 3)", ""),
        (["(0, 1, 0)"], "(1, 0, 0)", "1"),
    ],
)
def test_planes_of_symmetry_bear_what_is_across_them(facing, way, left):
    text = EIGHTH.replace("PLANES", "\n".join(f"{MIRROR} {normal}" for normal in facing))
    # What is pushed must stay on the other planes.
    text = text.replace("WAY", way).replace(
        "x > 9.9 mm", "x > 9.9 mm and y > 1 mm and z > 1 mm"
    )
    found = [one.message for one in tissuec.check(text) if one.code == "W310"]
    said = [f"nothing holds cube: pushes of {left} N in all drive it away"] if left else []
    assert found == said


@pytest.mark.parametrize("damping", ["1 nN*s/m", "0.1 mN*s/m", "10 mN*s/m"])
def test_a_body_falls_as_far_as_its_warning_says(damping):
    environment = f"gravity = (0, 0, -9.81) m/s^2; damping = {damping}"
    (text,) = unheld(environment=environment)
    number, unit = text.rpartition("by ")[2].split()
    said = float(number) * {"m": 1.0, "mm": 1e-3, "um": 1e-6}[unit]
    text = FALLING.replace("gravity = (0, 0, -9.81) m/s^2", environment)
    with pytest.warns(tissuec.TissueWarning):
        result = tissuec.run(text.replace("set side = nodes of block where x < 1 mm", ""))
    heights = result.logs["position of top"].value[:, 2]
    assert heights[0] - heights[-1] == pytest.approx(said, rel=5e-3)  # three digits


@pytest.mark.parametrize(
    ("low", "entries", "warns"),
    [
        (12.0, "", False),  # they touch
        (11.7, "", False),  # they overlap by less than a tenth of a cell
        (11.1, "", True),
        (10.9, "", True),
        (11.9, "contact thickness = 0.2 mm", False),
        (11.7, "contact thickness = 0.2 mm", True),
    ],
)
def test_solids_that_are_drawn_into_each_other_are_found(low, entries, warns):
    text = f"""language 1
tissue gel {{ Young's modulus = 6 kPa; density = 1000 kg/m^3; retardation time = 20 ms }}
body cube {{
  mesh is lattice {{ cell = 4 mm; box from (-10, -8, {low}) mm to (10, 8, {low} + 16) mm }}
  tissue is gel
}}
body slab {{
  mesh is lattice {{ cell = 4 mm; box from (-20, -20, 0) mm to (20, 20, 12) mm }}
  tissue is gel
}}
environment {{ gravity = (0, 0, 0) m/s^2; contact is bodies too; {entries} }}
simulate {{ duration = 1 ms }}
"""
    assert ("W406" in codes(text)) is warns


STACK = """language 1
tissue gel { Young's modulus = 6 kPa; density = 1000 kg/m^3; retardation time = 20 ms }
body slab {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 10) mm }; tissue is gel
}
body cube { mesh is lattice { cell = 5 mm; box from BOX mm }; tissue is gel }
environment { gravity = (0, 0, 0) m/s^2; contact is bodies too }
script { SCRIPT }
simulate { duration = 1 ms }
"""


@pytest.mark.parametrize(
    ("box", "script", "said"),
    [  # flush sides, and others
        (
            "(0, 0, 8) mm to (20, 20, 18)",
            "",
            "1.25 mm below the surface, and pushes them apart",
        ),
        ("(0, 0, 8) mm to (20, 20, 18)", "at 0 s: settle", "begins to press 1.25 mm below"),
        ("(5, 5, 8) mm to (15, 15, 18)", "at 0 s: settle", "begins to press 1.25 mm below"),
        ("(0, 0, 9) mm to (20, 20, 19)", "", "this depth has no force"),
        ("(0, 0, 10) mm to (20, 20, 20)", "at 0 s: settle", ""),
        ("(20, 0, 0) mm to (40, 20, 10)", "", ""),
    ],
)
def test_a_drawn_overlap_is_named_with_its_depth_whatever_the_sides_do(box, script, said):
    text = STACK.replace("BOX", box).replace("SCRIPT", script)
    found = [one for one in tissuec.check(text) if one.code == "W406"]
    assert len(found) == bool(said)
    for one in found:
        depth = 10 - int(box.split(")")[0].split()[-1])
        assert one.message.startswith(f"cube is drawn {depth} mm into slab")
        assert said in one.message and one.hint.startswith(
            f"draw them {depth} mm further apart"
        )


@pytest.mark.parametrize("contact", ["off", "bodies too"])
@pytest.mark.parametrize(
    ("low", "joint", "warns"), [("4", "", True), ("21", "", False), ("4", "tied", False)]
)
def test_a_body_inside_of_a_solid_is_found(low, joint, warns, contact):
    text = f"""language 1
tissue gel {{ Young's modulus = 6 kPa; density = 1000 kg/m^3; retardation time = 20 ms }}
tissue fibre {{ spring constant = 1 N/m; viscosity = 1 mN*s/m; mass = 1 mg }}
body slab {{
  mesh is lattice {{ cell = 4 mm; box from (-20, -20, 0) mm to (20, 20, 16) mm }}
  tissue is gel
}}
body cube {{
  mesh is lattice {{ cell = 4 mm; box from (-4, -4, {low}) mm to (4, 4, {low} + 8) mm }}
  tissue is gel
}}
environment {{ gravity = (0, 0, 0) m/s^2; contact is {contact} }}
simulate {{ duration = 1 ms }}
"""
    if joint:
        text += "joint tied { springs from cube to slab; reach = 9 mm; tissue is fibre }"
    found = [each for each in tissuec.check(text) if each.code == "W416"]
    assert len(found) == warns
    for one in found:
        assert one.message.startswith("cube is drawn inside of slab, and neither acts on the")
        region = "region cube where within 4 mm of (0, 0, 8) mm { tissue is gel }"
        assert one.hint == f"write in slab: {region}; or join both by a joint"
        # The way out leads out.
        lines = text.splitlines()
        body = next(n for n, line in enumerate(lines) if line.startswith("body cube"))
        lines[body : body + 4] = []
        mended = "\n".join(lines).replace(
            "to (20, 20, 16) mm }", f"to (20, 20, 16) mm }}; {region}"
        )
        assert "W416" not in codes(mended)


def test_steps_of_a_thin_contact_thickness_are_as_many_as_announced(monkeypatch):
    scene = Path(__file__).parent / "scenes" / "bad" / "contact_thickness_tiny.tis"
    text = scene.read_text(encoding="utf-8").replace("0.1 um", "20 um")
    assert "W414" not in codes(text)
    monkeypatch.setattr("tissuec.compiler.checks.contact_thickness.MANY", 50)
    (found,) = (one for one in tissuec.check(text) if one.code == "W414")
    assert found.message.startswith("the run takes at least 100 steps: something moves by 1 mm")
    assert found.hint.endswith("by default it would be 1 mm")
    with pytest.warns(tissuec.TissueWarning):
        steps = tissuec.run(text, companion="off").manifest["statistics"]["accepted"]
    assert steps >= 100
    # A thinner tool is what limits steps.
    needle = "tool needle { kind is probe; radius = 5 um; centre = (4, 4, 90) mm }"
    assert "W414" not in codes(f"{text}\n{needle}")
