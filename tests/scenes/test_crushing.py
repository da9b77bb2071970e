"""Springs that break under pressure: written, concluded, typed into tables, run and told."""

import numpy as np
import pytest

from tests.findings import finding_of
from tests.validate.scenes import compiled_scene, quantity, validated
from tissuec.compiler.provenance import explain_tissue
from tissuec.core.source import Source
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request, read_words
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request

# Two masses of 5 g on a spring of 40 N/m that is drawn 2 mm too long: the pressure reaches
# 60 mN where cos(w t) = -0.75, with w² = 2 c / m.
SCENE = """language 1
tissue cord {{ spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 5 g
              breaking force = 1 N; {limit} }}
body pair {{ mesh is explicit; tissue is cord; rupture is {rupture} }}
table nodes of pair in mm with columns "id x" {{ 1 0; 2 12; 3 40; 4 52 }}
table springs of pair with columns "a b rest length in mm {column}" {{ {rows} }}
set first = nodes of pair in [1, 2]
set second = nodes of pair in [3, 4]
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ {script} }}
simulate {{ duration = 0.06 s; tolerance = 1e-9 }}
output {{ trajectory every 1 ms; energy every 1 ms }}
{expect}
"""
OMEGA = np.sqrt(2.0 * 40.0 / 5e-3)
TIME = np.arccos(-0.75) / OMEGA


def scene(*, limit="crushing force = 60 mN", rupture="allowed", column="", script="",
          rows="1 2 10; 3 4 12", expect=""):  # fmt: skip
    return SCENE.format(
        limit=limit, rupture=rupture, column=column, rows=rows, script=script, expect=expect
    )


def ran(text):
    compiled = compiled_scene(text)
    recording = MemoryRecording()
    recorder = Recorder(compiled.network, compiled.plan, recording)
    return compiled, run(compiled.network, compiled.plan, recorder)


def broken(outcome):
    return [(t, h) for t, h in outcome.logged_events if h.kind in ("rupture", "crush")]


def test_swinging_spring_is_crushed_at_the_known_time_and_said_to_be():
    _, outcome = ran(scene(expect="expect not ruptured(second) over run"))
    ((time, logged_event),) = broken(outcome)
    assert time == pytest.approx(TIME, rel=1e-8)
    assert (logged_event.kind, logged_event.springs) == ("crush", (0,))
    assert logged_event.cause == "the compression exceeded the crushing force"
    assert logged_event.span.one_line == "crushing force = 60 mN"
    assert outcome.failures == ()


def test_what_is_crushed_counts_as_ruptured():
    _, outcome = ran(scene(expect="expect not ruptured(first) over run"))
    ((failure),) = outcome.failures
    assert failure.time == pytest.approx(TIME, abs=1e-3)


@pytest.mark.parametrize(
    "text",
    [
        scene(limit=""),
        scene(limit="crushing force is none"),
        scene(limit="crushing force = 81 mN"),
        scene(rupture="not allowed"),
    ],
)
def test_nothing_is_crushed_without_a_limit_that_is_reached(text):
    assert broken(ran(text)[1]) == []


def test_a_table_gives_crushing_forces_of_single_springs():
    rows = "1 2 10 60; 3 4 12 -"
    compiled, outcome = ran(scene(limit="", column="crushing force in mN", rows=rows))
    assert compiled.network.springs.crush.tolist() == [0.06, np.inf]
    assert compiled.network.provenance["crush"][0].how == "table"
    assert broken(outcome)[0][0] == pytest.approx(TIME, rel=1e-8)


def test_a_change_brings_and_lifts_a_limit():
    text = scene(limit="", script="at 5 ms: change crushing force of first to 60 mN")
    compiled, outcome = ran(text)
    assert compiled.plan.breakable
    assert broken(outcome)[0][0] == pytest.approx(TIME, rel=1e-8)
    late = scene(script="at 10 ms: change crushing force of first by 10")
    assert broken(ran(late)[1]) == []


def test_without_breaking_forces_pressure_alone_breaks():
    text = scene().replace("breaking force = 1 N", "breaking force is none")
    compiled, outcome = ran(text)
    assert np.isinf(compiled.network.springs.strength).all()
    assert broken(outcome)[0][0] == pytest.approx(TIME, rel=1e-8)


def test_a_vocabulary_concludes_crushing_forces_as_any_quantity():
    text = """language 1
property firmness from 0 to 1 { evenly = [soft, hard] }
quantity crushing force from 0.1 N to 10 N on log scale {
  evenly = [small, big]; applies to each spring
}
rules simple { if firmness is hard then crushing force is big }
tissue bone { described in simple; firmness is hard }
"""
    words, _ = read_words(Request(Source("bone.tis", text)))
    (found,) = explain_tissue(words.tissues["bone"])
    assert (found.quantity, found.how) == ("crushing force", "rules")
    assert 1.0 < found.value < 10.0


def test_a_spring_between_regions_bears_what_the_interface_says():
    text = scene().replace("rupture is", "interface is {}; region far where x > 11 mm "
                           "{{ tissue is chalk }}; rupture is")  # fmt: skip
    text = text.replace("body pair", "tissue chalk like cord {{ spring constant = 20 N/m; "
                        "crushing force = 20 mN }}\nbody pair")  # fmt: skip
    for word, expected in (("softer", 0.02), ("stiffer", 0.06), ("mean", 0.04)):
        compiled = compiled_scene(
            text.replace("{{", "{").replace("}}", "}").replace("{}", word)
        )
        assert compiled.network.springs.crush[0] == pytest.approx(expected)


def test_the_reference_crushes_the_same_spring_at_the_same_time():
    found = validated(scene())
    assert found.comparison.ruptures.run == found.comparison.ruptures.reference == 1
    assert found.comparison.ruptures.error < 1e-10
    assert found.verdict == "kept"
    assert quantity(found, "energy balance").error < 1e-9


def test_the_result_file_holds_limits_and_tells_crushed_from_torn(tmp_path):
    import h5py

    from tissuec.pipeline import simulate

    request = Request(Source("scene.tis", scene()))
    compiled, _ = compile_request(request)
    result = simulate(compiled, tmp_path / "a.vtkhdf", request=request)
    with Trajectory.open(result.path) as trajectory:
        network = trajectory.network
    with h5py.File(result.path) as file:
        kinds = [kind.decode() for kind in file["/tissuec/events/kind"][:]]
    assert np.array_equal(network.springs.crush, compiled.network.springs.crush)
    assert kinds == ["crush"]


def test_a_negative_crushing_force_is_refused_with_its_place():
    finding = finding_of(compiled_scene, scene(limit="crushing force = -3 N"))
    assert (finding.code, finding.message) == (
        "TIS308", "crushing force must be above 0 N, not -3 N",
    )  # fmt: skip


def test_a_run_that_is_resumed_crushes_as_one_that_is_not():
    compiled, whole = ran(scene(script="at 5 ms: change crushing force of first by 0.9"))
    network, plan = compiled.network, compiled.plan
    before, after = MemoryRecording(), MemoryRecording()
    stopped = run(network, plan, Recorder(network, plan, before), interrupt=lambda: True)
    assert stopped.kind == "interrupted"
    resumed = run(network, plan, Recorder(network, plan, after), resume=before.state)
    assert broken(whole) == broken(stopped) + broken(resumed)
    assert len(broken(whole)) == 1
