"""What had no effect in a run: notes at its end, which change nothing."""

import json

import numpy as np
import pytest

import tissuec
from tests.test_cli import tissuec as command
from tests.validate.scenes import compiled_scene
from tests.whole_runs import AfterAsking, carried_out
from tissuec.engine.execution import effects

BLOCK = """language 1
tissue gel {{ Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 1 ms }}
body block {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 5) mm }}; tissue is gel
}}
set base = nodes of block where z == 0 mm
set roof = nodes of block where z == 5 mm
tool ball {{ kind is probe; centre = (5, 5, 11) mm; radius = 5 mm }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only; contact stiffness = 1 kN/m }}
script {{
  {script}
}}
simulate {{ duration = 0.1 s; tolerance = 1e-3 }}
output {{ position(roof) every 10 ms; force(ball) every 10 ms }}
"""
AWAY = "from 0 s to 0.1 s: move ball by (0, 0, 10) mm using smooth profile"
DOWN = "from 0 s to 0.1 s: move ball by (0, 0, -2) mm using smooth profile"
GONE_BY = "from 0 s to 0.1 s: move ball by (0, 0, -0.9) mm using smooth profile"


def notes(script, **replaced):
    """Return what had no effect in a block with a script, as sentences without places."""
    text = BLOCK.format(script=f"at 0 s: fix base\n  {script}")
    for old, new in replaced.values():
        text = text.replace(old, new)
    found = tissuec.run(text, companion="off").without_effect
    return [str(one).rpartition(" (")[0] for one in found]


@pytest.mark.parametrize(
    ("way", "touches"),
    [(AWAY, False), (DOWN, True), (GONE_BY, False)],
    ids=["away", "into it", "not quite"],
)
def test_a_tool_that_touches_nothing_is_named(way, touches):
    # Drawn 1 mm above the block; 0.9 mm nearer it is still 0.1 mm away.
    found = notes(way)
    untouched = "ball touched nothing: check where it is drawn, and its way"
    assert (untouched in found) == (not touches)


def test_a_brief_touch_between_two_looks_is_none_that_is_denied():
    # Down and up again within a 32nd of the run, so that no look need see it.
    brief = (
        "from 50 ms to 51 ms: move ball by (0, 0, -2) mm using smooth profile\n"
        "  from 51 ms to 52 ms: move ball by (0, 0, 2) mm using smooth profile"
    )
    assert not [one for one in notes(brief) if "touched nothing" in one]


def test_a_push_on_nodes_that_are_held_is_named_whatever_holds_them():
    push = "from 20 ms to 60 ms: push roof with (1, 0, 0) mN using ramp"
    said = "push roof with (1, 0, 0) mN using ramp acts on held nodes only"
    assert not [one for one in notes(push) if "push" in one]
    held = notes(f"at 10 ms: hold roof\n  {push}")
    assert [one for one in held if one.startswith(said)]
    # Released before it ends, the push acts.
    assert not [
        one
        for one in notes(f"from 10 ms to 50 ms: hold roof\n  {push}")
        if one.startswith("push")
    ]
    pressed = notes(
        "at 10 ms: hold roof\n  from 20 ms to 60 ms: press roof with 1 kPa using ramp"
    )
    assert [one for one in pressed if one.startswith("press roof with 1 kPa")]


def test_a_condition_that_is_never_true_has_the_value_that_is_closest():
    fixed = "when position(ball along (0, 0, 1)) > 15 mm: end the run"
    (found,) = [one for one in notes(f"{GONE_BY}\n  {fixed}") if "never" in one]
    # It goes down from 11 mm, so that it is closest at the start.
    assert found == (
        "when position(ball along (0, 0, 1)) > 15 mm was never true; closest at 0 s: "
        "position(ball along (0, 0, 1)) = 11 mm"
    )
    below = "when position(ball along (0, 0, 1)) < 5 mm: end the run"
    (found,) = [one for one in notes(f"{GONE_BY}\n  {below}") if "never" in one]
    assert found.endswith("closest at 100 ms: position(ball along (0, 0, 1)) = 10.1 mm")
    third = "when position(ball along (0, 0, 1)) / 3 > 15 mm: end the run"
    (found,) = [one for one in notes(f"{GONE_BY}\n  {third}") if "never" in one]
    assert found.endswith("/ 3 = 3.667 mm")
    true = "when position(ball along (0, 0, 1)) > 15 mm: end the run"
    assert not [one for one in notes(f"{AWAY}\n  {true}") if "never" in one]


def test_a_scene_in_which_nothing_acts_says_so():
    assert "no body moved: nothing acts on them: write what does" in notes("")
    every = ("fix base", "fix [base, roof]")
    assert "no body moved: every node is held: fix only a part of each body" in notes(
        "", every=every
    )
    assert not [one for one in notes(DOWN) if "moved" in one]


BAG = """language 1
tissue rubber { spring constant = 100 N/m; viscosity = 0.2 N*s/m; mass = 0.1 g }
body bag {
  mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }; tissue is rubber
}
set base = nodes of bag where z < -9 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 10 mN*s/m }
script {
  at 0 s: { fix base; preserve volume of bag with MODULUS }
  from 0 s to 0.5 s: inflate bag to 8 ml using constant speed
}
simulate { duration = 0.5 s; tolerance = 1e-3 }
output { volume(bag) every 50 ms }
"""


def test_a_volume_that_pressure_does_not_reach_is_named_with_both_numbers():
    soft = tissuec.run(BAG.replace("MODULUS", "1 kPa"), companion="off")
    (found,) = soft.without_effect
    reached = soft.logs["volume of bag"].value[-1, 0]
    assert reached < 0.95 * 8e-6
    assert found.kind == "volume" and f"{reached * 1e6:.3g} ml" in found.what
    assert found.what.endswith("at the end, instead of 8 ml")
    stiff = tissuec.run(BAG.replace("MODULUS", "10 MPa"), companion="off")
    assert stiff.logs["volume of bag"].value[-1, 0] == pytest.approx(8e-6, rel=0.05)
    assert not stiff.without_effect


HALVES = """language 1
tissue gel {
  Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms
  breaking strain = 50 %
}
tissue glue { spring constant = 9 N/m; viscosity = 10 mN*s/m; mass = 1 mg }
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, TOP) mm }; tissue is gel
  RUPTURE
}
MORE
set base = nodes of block where z == 0 mm
environment { gravity = (0, 0, -9.81) m/s^2; contact is CONTACT }
script {
  at 0 s: fix base
  at 2 ms: CUT
}
simulate { duration = 4 ms; tolerance = 1e-2 }
"""
BY_FACES = "rupture by faces"
ACROSS = "at 2 ms: cut block along plane through (0, 0, 7) mm facing (0, 0, 1)"
TWO = """body upper {
  mesh is lattice { cell = 5 mm; box from (0, 0, 10.5) mm to (10, 10, 15.5) mm }; tissue is gel
}
set top = nodes of block where z == 10 mm
set low = nodes of upper where z == 10.5 mm
joint seam { springs from top to low; reach = 1 mm; tissue is glue }"""


@pytest.mark.parametrize(
    ("contact", "top", "more", "cut", "said"),
    [
        ("everywhere", 15, "", ACROSS, True),
        ("everywhere", 15, BY_FACES, ACROSS, False),
        ("everywhere", 15, "", "", False),
        ("tools only", 15, "tool ball { kind is probe; centre = (0, 0, 90) mm; radius = 1 mm }",
         ACROSS, False),
        # The way out that it names.
        ("everywhere", 10, TWO, "at 2 ms: cut seam", False),
    ],
)  # fmt: skip
def test_faces_that_lost_elements_leave_and_nothing_touches_are_named_once(
    contact, top, more, cut, said
):
    by_faces = more == BY_FACES
    text = HALVES.replace("RUPTURE", BY_FACES if by_faces else "rupture is allowed")
    text = text.replace("MORE", "") if by_faces else text
    text = text.replace("CONTACT", contact).replace("TOP", str(top)).replace("MORE", more)
    text = text.replace("at 2 ms: CUT", cut)
    found = tissuec.run(text, companion="off").without_effect
    bared = [one for one in found if one.kind == "cut faces"]
    assert len(bared) == said
    if said:
        assert "faces of block that lost elements leave from 2 ms on" in bared[0].what
        assert "bodies with a joint between them" in bared[0].remedy


def test_watching_changes_no_bit(monkeypatch):
    text = BLOCK.format(
        script=f"at 0 s: fix base\n  {DOWN}\n  when force(ball) > 1 N: end the run"
    )
    compiled = compiled_scene(text)
    _, watched = carried_out(compiled)
    nothing = lambda *given: None  # noqa: E731
    for name in ("enter", "look", "measure"):
        monkeypatch.setattr(effects.EffectWatcher, name, nothing)
    _, unwatched = carried_out(compiled)
    for log in ("force of ball", "position of roof"):
        assert np.array_equal(watched.log_arrays(log)[1], unwatched.log_arrays(log)[1])


def test_a_resumed_run_knows_what_was_seen_before():
    push = "from 1 ms to 2 ms: push roof with (1, 0, 0) mN using ramp"
    compiled = compiled_scene(BLOCK.format(script=f"at 0 s: fix base\n  {push}\n  {AWAY}"))
    whole, _ = carried_out(compiled)
    first, before = carried_out(compiled, interrupt=AfterAsking(3))
    assert first.kind == "interrupted" and not first.without_effect
    second, _ = carried_out(compiled, resume=before.state)
    assert second.without_effect == whole.without_effect
    assert [one.kind for one in whole.without_effect] == ["contact"]


def test_every_door_lists_them(tmp_path):
    scene = tmp_path / "block.tis"
    scene.write_text(BLOCK.format(script=f"at 0 s: fix base\n  {AWAY}"))
    ran = command("--json", "run", scene, cwd=tmp_path)
    (entry,) = [
        one for one in json.loads(ran.stdout)["without_effect"] if one["kind"] == "contact"
    ]
    assert entry["what"] == "ball touched nothing"
    assert ran.returncode == 0  # nothing is wrong with the numbers
    shown = command("run", scene, cwd=tmp_path)
    assert "note: ball touched nothing: check" in shown.stderr
    result = tissuec.Trajectory(tmp_path / "block.vtkhdf")
    assert "ball touched nothing" in [one.what for one in result.without_effect]
    told = command("info", tmp_path / "block.vtkhdf", cwd=tmp_path).stdout
    assert "ball touched nothing" in told


STUDY = """language 1
param lift = 1 mm
param hint = 2 mm
tissue gum { spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 1 g }
body pair { mesh is explicit; tissue is gum }
table nodes of pair in mm with columns "id x y z" { 1 0 0 0; 2 10 0 0 }
table springs of pair with columns "a b" { 1 2 }
set left = nodes of pair in [1]
set right = nodes of pair in [2]
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix left
  from 0 s to 10 ms: move right by (lift, 0 mm, 0 mm) using smooth profile
}
simulate { duration = 10 ms; tolerance = 1e-3 }
study s {
  vary lift = [1 mm, 2 mm]
  vary hint = [1 mm, 2 mm]
  measure peak = max(force(right))
}
"""


def test_a_study_names_what_it_varies_in_vain(tmp_path):
    scene = tmp_path / "pair.tis"
    scene.write_text(STUDY)
    ran = command("study", scene, "--workers", "1", cwd=tmp_path)
    assert "note: hint changes no measure" in ran.stderr
    assert "lift changes no measure" not in ran.stderr
    assert 'the param "hint" is never used' in ran.stderr
