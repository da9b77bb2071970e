"""``preserve`` and ``inflate``: targets that follow one another, and bodies that are torn."""

import pytest

from tests.test_cli import tissuec
from tests.validate.scenes import compiled_scene
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run

SCENE = """language 1
tissue rubber { spring constant = 20 N/m; viscosity = 0.2 N*s/m; mass = 0.1 g; TISSUE }
body bag { mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }
  tissue is rubber; RUPTURE }
body sponge { mesh is lattice { kind is sodium chloride; cell = 5 mm
  box from (30, 0, 0) mm to (40, 5, 5) mm }
  tissue is rubber }
environment { gravity = (0, 0, 0) m/s^2 }
script { SCRIPT }
simulate { duration = 10 ms }
output { volume of bag every 1 ms }
"""
CUT = "cut bag along plane through (0, 0, 2) mm facing (0, 0, 1)"
TORN = f"torn at 1 ms by: {CUT} (scene.tis:9)"


def scene(script, tissue="", rupture=""):
    text = SCENE.replace("SCRIPT", script)
    return text.replace("TISSUE", tissue).replace("RUPTURE", rupture)


def ran(*parts):
    compiled = compiled_scene(scene(*parts))
    return run(
        compiled.network,
        compiled.plan,
        Recorder(compiled.network, compiled.plan, MemoryRecording()),
    )


def causes(outcome, *kinds):
    return [event.cause for _, event in outcome.logged_events if event.kind in kinds]


@pytest.mark.parametrize("second", ["from 4 ms to 9 ms:", "at 4 ms:", "from 4 ms to 5 ms:"])
def test_inflating_again_replaces_what_is_under_way(second):
    script = f"""at 0 s: preserve volume of bag with 10 kPa
  from 2 ms to 8 ms: inflate bag to 5 ml using smooth profile
  {second} inflate bag to 4 ml"""
    bag = ran(script).state.enclosures["bag"]
    drawn = bag.drawn.sum()
    assert drawn * (1.0 + bag.amount(0.01)) == pytest.approx(4e-6)
    if "from" in second:  # it begins where the first had come, a third of its way
        assert drawn * (1.0 + bag.amount(0.004)) == pytest.approx(
            drawn + (5e-6 - drawn) * 17.0 / 81.0
        )


def test_a_third_order_begins_where_the_second_is():
    script = """at 0 s: { preserve volume of bag with 10 kPa; inflate bag to 4 ml }
  from 2 ms to 6 ms: inflate bag to 5 ml
  from 4 ms to 8 ms: inflate bag to 4.1 ml"""
    bag = ran(script).state.enclosures["bag"]
    targets = [bag.drawn.sum() * (1.0 + bag.amount(t)) for t in (0.004, 0.006, 0.01)]
    assert targets == pytest.approx([4.5e-6, 4.3e-6, 4.1e-6])


def test_preserving_again_returns_to_the_drawn_volume_and_says_so():
    again = "at 2 ms: preserve volume of bag with 20 kPa"
    (note,) = causes(ran(f"at 0 s: preserve volume of bag with 10 kPa\n  {again}"), "note")
    assert note == "replaced: preserve volume of bag with 10 kPa"
    inflate = "at 1 ms: inflate bag to 5 ml"
    outcome = ran(f"at 0 s: preserve volume of bag with 10 kPa\n  {inflate}\n  {again}")
    (note,) = causes(outcome, "note")
    assert note == (
        "replaced: preserve volume of bag with 10 kPa; "
        "the target is the drawn volume of 3.66 ml again, no longer 5 ml"
    )
    assert outcome.state.enclosures["bag"].amount(0.01) == 0.0


def test_a_leak_names_what_tore_the_surface():
    keep = "preserve volume of bag with 10 kPa"
    torn = "the surface of bag is torn and no longer holds pressure; "
    before = ran(f"at 1 ms: {CUT}\n  at 2 ms: {keep}")
    assert causes(before, "leak") == [torn + TORN]
    assert before.state.enclosures == {}
    after = ran(f"at 0 s: {keep}\n  at 1 ms: {CUT}")
    assert causes(after, "leak") == [f"{torn}torn by: {CUT} (scene.tis:10)"]
    burst = ran(
        f"at 0 s: {{ {keep}; inflate bag to 9 ml }}",
        "breaking force = 5 mN",
        "rupture is allowed",
    )
    (leak,) = causes(burst, "leak")
    assert leak == f"{torn}ruptured, as the tension exceeded the breaking force (scene.tis:2)"


@pytest.mark.parametrize("keep", ["at 0 s:", "at 2 ms:", "at 3 ms:"])
def test_what_is_torn_cannot_be_inflated(keep):
    outcome = ran(
        f"at 1 ms: {CUT}\n  {keep} preserve volume of bag with 10 kPa\n"
        "  at 3 ms: inflate bag to 5 ml"
    )
    assert outcome.message == (
        "the run stopped at 3 ms; bag cannot be inflated: its surface is torn; "
        f"{TORN}; requested in scene.tis:11"
    )


def test_what_a_trigger_has_not_preserved_yet_cannot_be_inflated():
    outcome = ran(
        "at 3 ms: inflate bag to 5 ml\n"
        "  when volume(bag) > 9 ml: preserve volume of bag with 10 kPa"
    )
    assert outcome.message == (
        "the run stopped at 3 ms; bag cannot be inflated: nothing preserves its volume yet; "
        "requested in scene.tis:9"
    )


def test_intact_cells_share_the_volume_also_at_the_time_of_a_cut():
    cut = "cut sponge along plane through (32, 0, 0) mm facing (1, 0, 0)"
    outcome = ran(
        f"at 0 s: preserve volume of sponge with 10 kPa\n"
        f"  at 1 ms: {{ {cut}; inflate sponge to 0.15 ml }}"
    )
    (leak,) = causes(outcome, "leak")
    assert leak.startswith(
        "1 cell of sponge is torn and no longer holds pressure; torn by: cut"
    )
    (sponge,) = outcome.state.enclosures.values()
    assert sponge.drawn.sum() * (1.0 + sponge.amount(0.01)) == pytest.approx(0.15e-6)


def test_a_run_prints_the_first_leak_of_a_body(tmp_path):
    script = "at 0 s: preserve volume of sponge with 10 kPa"
    for time, x in (1, 32), (2, 37):
        script += (
            f"\n  at {time} ms: cut sponge along plane through ({x}, 0, 0) mm facing (1, 0, 0)"
        )
    (tmp_path / "scene.tis").write_text(scene(script))
    done = tissuec("run", "scene.tis", cwd=tmp_path)
    (line,) = [line for line in done.stderr.splitlines() if "leak" in line]
    assert done.returncode == 0 and line.startswith("  1 ms: leak: 1 cell of sponge is torn")
