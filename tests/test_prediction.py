"""What a run is said to do before it runs is what it does."""

import math

import pytest

import tissuec
from tissuec.compiler.prediction import predict, skipped
from tissuec.core.resources import library
from tissuec.core.source import Source
from tissuec.engine.run_cost import FIRST, MORE
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.view.scene_summary import cost

SCENE = """language 1
tissue gum { spring constant = 40 N/m; viscosity = 0.01 N*s/m; mass = 10 mg }
body vessel {
  mesh is tube { axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 3 mm; rings = 4; sides = 8 }
  tissue is gum
}
set root = nodes of vessel where x < 1 mm
environment { gravity = (0, 0, GRAVITY) m/s^2 }
script { at 0 s: fix root }
simulate { duration = 50 ms; tolerance = 1e-2 }
"""


def compiled(text):
    return compile_request(Request(Source("scene.tis", text)))[0]


@pytest.mark.parametrize(
    "output",
    [
        "",
        "output { trajectory every 1 ms }",
        "output { force of root every 1 ms; energy every 1 ms }",
    ],
    ids=["nothing", "a trajectory", "logs"],
)
def test_a_result_file_is_about_as_large_as_said(output, tmp_path):
    text = SCENE.replace("GRAVITY", "-9.81") + output + "\n"
    tissuec.run(text, out=tmp_path / "run.vtkhdf", companion="off").close()
    written = (tmp_path / "run.vtkhdf").stat().st_size
    assert predict(compiled(text)).bytes == pytest.approx(written, rel=0.2)


@pytest.mark.parametrize(
    "name",
    [
        *("two_masses", "published_net", "sterilisation"),
        *(pytest.param(one, marks=pytest.mark.slow) for one in ("rupture", "suture", "liver")),
    ],
)
def test_results_of_shipped_scenes_are_about_as_large_as_said(name, shipped):
    """Frames, logs, energies, tools, events and cuts together."""
    scene = library() / "scenes" / f"{name}.tis"
    said = predict(compile_request(Request.file(scene))[0]).bytes
    assert said == pytest.approx(shipped(name).path.stat().st_size, rel=0.1)


def test_a_run_without_output_writes_no_large_file(tmp_path):
    run = tissuec.run(SCENE.replace("GRAVITY", "0"), out=tmp_path / "run.vtkhdf")
    run.close()
    # Of that, 110 kB are what HDF5 needs for a hundred columns, most of them without rows.
    assert (tmp_path / "run.vtkhdf").stat().st_size < 170_000


def test_gravity_is_left_out_where_there_is_none():
    weightless, heavy = (compiled(SCENE.replace("GRAVITY", one)) for one in ("0", "-9.81"))
    assert any("gravity" in line for line in skipped(weightless))
    assert not any("gravity" in line for line in skipped(heavy))


@pytest.mark.parametrize(
    ("method", "choices"),
    [
        ("relaxation { threshold = 1 uN }", ["threshold = 1 uN", "activities is none"]),
        (
            "propagation { growth = 1.25 }",
            [
                "compared forces is all", "former force is kept", "repeated is step",
                "first step is whole frame", "growth = 1.25", "frame end is exact",
                "smallest step = 0.015625",
            ],
        ),
    ],
)  # fmt: skip
def test_every_choice_of_a_procedure_is_stated(method, choices):
    text = SCENE.replace("GRAVITY", "-9.81")
    text = text.replace("tolerance = 1e-2", f"step = 1 ms; integrator is {method}")
    assert list(predict(compiled(text)).choices) == choices


@pytest.mark.parametrize("method", ["esdirk43", "trbdf2"])
def test_implicit_steps_cost_about_what_is_said_and_their_number_is_not_estimated(method):
    """What they cost depends on how many iterations and factorisations motions need."""
    text = SCENE.replace("GRAVITY", "-9.81").replace("1e-2", f"1e-2; integrator is {method}")
    plan = predict(compiled(text))
    assert math.isnan(plan.steps)
    assert math.isnan(plan.seconds)
    assert "no estimate of the computing time" in cost(plan)
    counts = tissuec.run(text, companion="off").manifest["statistics"]
    assert 0.2 < counts["cost"] / counts["accepted"] / plan.step_seconds < 5.0


def test_explicit_steps_cost_their_evaluations():
    text = SCENE.replace("GRAVITY", "-9.81").replace("1e-2", "1e-2; integrator is dop853")
    plan = predict(compiled(text))
    first = FIRST / 12.0 * plan.step_seconds
    assert plan.cost.motion == pytest.approx(MORE * plan.steps * plan.step_seconds + first)
    assert plan.seconds == pytest.approx(sum(plan.cost))
    counts = tissuec.run(text, companion="off").manifest["statistics"]
    per_step = counts["cost"] / counts["accepted"]
    assert plan.step_seconds == pytest.approx(per_step, rel=0.5)


def cost_of(text, **changes):
    for old, new in changes.items():
        text = text.replace(old, new)
    return predict(compiled(text)).cost


def test_each_part_of_a_plan_depends_on_what_it_is_of():
    text = SCENE.replace("GRAVITY", "-9.81")
    bare = cost_of(text)
    assert bare.equilibria == bare.output == bare.events == 0.0
    # Rows of logs, frames and energies: in proportion to their number, and nothing else.
    logged = [
        cost_of(text + f"output {{ force of root every {each} }}")
        for each in ("1 ms", "0.5 ms")
    ]
    assert logged[1].output / logged[0].output == pytest.approx(101 / 51)
    for one in logged:
        assert one._replace(output=0.0) == bare
    kept = cost_of(text + "output { energy every 1 ms }")
    assert kept.output > 0.0
    assert kept.motion == bare.motion
    # Events after the start.
    moved = cost_of(text, **{"fix root": "fix root; at 10 ms: free root; at 20 ms: fix root"})
    assert moved.events > 0.0
    assert moved._replace(events=0.0) == bare
    # Larger nets take longer to prepare.
    large = cost_of(text, **{"rings = 4": "rings = 8"})
    assert large.preparation / bare.preparation == pytest.approx(2.0, abs=0.2)
    assert large.start == bare.start


def test_a_jet_is_foreseen_while_it_blows():
    scene = (library() / "scenes" / "tubal_ligation.tis").read_text(encoding="utf-8")
    without = "\n".join(line for line in scene.splitlines() if "irrigate" not in line)
    dry = cost_of(without)
    short, long = (
        cost_of(scene),
        cost_of(scene, **{"to 1.3 s: irrigate": "to 1.25 s: irrigate"}),
    )
    assert (short.motion - dry.motion) / (long.motion - dry.motion) == pytest.approx(2.0)


def test_fixed_steps_are_as_many_as_they_are():
    text = SCENE.replace("GRAVITY", "-9.81")
    text = text.replace("tolerance = 1e-2", "step = 1 ms; integrator is velocity verlet")
    plan = predict(compiled(text))
    assert plan.cost.motion == pytest.approx(50 * plan.step_seconds)
