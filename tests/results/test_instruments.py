"""Instruments and holds in result files."""

import h5py
import numpy as np
import pytest

from tests.engine.execution.test_run_to_file import write
from tests.whole_runs import AfterAsking
from tissuec.core.resources import library
from tissuec.core.source import Source
from tissuec.engine.execution.recorder import Recorder, wishes
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request, simulate
from tissuec.results.recording import Recording
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter
from tissuec.scene.request import Request

SCENE = """language 1
use "tissues/fat"
body pad {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (10, 0, 0) mm; second edge = (0, 10, 0) mm
    rows = 3; columns = 3
  }
  tissue is fat
}
set rim = nodes of pad where x < 1 mm
set other = nodes of pad where x > 9 mm
tool finger { kind is probe; radius = 2 mm; centre = (5, 5, 4) mm }
tool plate { kind is plane; point = (0, 0, -5) mm; normal = (0, 0, 1) }
tool grip { kind is forceps }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only }
script {
  at 0 s: fix rim
  at 10 ms: grasp other with grip
  from 0 s to 40 ms: move finger by (0, 0, -2) mm using constant speed
  at 30 ms: release grip
}
simulate { duration = 40 ms }
output { trajectory every 10 ms }
"""


@pytest.fixture(scope="module")
def compiled():
    request = Request(Source("pad.tis", SCENE))
    return request, compile_request(request)[0]


def test_tools_are_where_the_script_moves_them(compiled, tmp_path):
    request, scene = compiled
    with Trajectory.open(simulate(scene, tmp_path / "pad.vtkhdf", request=request).path) as run:
        finger, plate = run.network.tools
        assert (finger.name, finger.kind, finger.shapes) == (
            "finger",
            "probe",
            (("capsule", 0.002),),
        )
        assert plate.shapes == (("plane", 0.0),)
        height = run.tools[:, 0, 2]
        assert height == pytest.approx(4e-3 - 2e-3 * run.times / 0.04, abs=1e-12)
        assert run.tools.shape == (5, 4, 3)
        assert np.ptp(run.tools[:, 2:], axis=0) == pytest.approx(np.zeros((2, 3)))


def test_frames_contain_nodes_of_bodies_only(compiled, tmp_path):
    request, scene = compiled
    path = simulate(scene, tmp_path / "pad.vtkhdf", request=request).path
    with Trajectory.open(path) as run:
        assert run.nodes.tolist() == list(range(9))
        assert run.network.node_count == 13
    with h5py.File(path) as file:
        assert file["VTKHDF/Points"].shape == (5 * 9, 3)


def test_holds_say_who_holds_what_since_when(compiled, tmp_path):
    request, scene = compiled
    with Trajectory.open(simulate(scene, tmp_path / "pad.vtkhdf", request=request).path) as run:
        drawn = run.network.position[: run.network.body_nodes]
        rim, other = np.flatnonzero(drawn[:, 0] < 1e-3), np.flatnonzero(drawn[:, 0] > 9e-3)
        found = [(hold.time, hold.holder, hold.nodes.tolist()) for hold in run.holds]
        assert found == [
            (0.0, "fix", rim.tolist()),
            (pytest.approx(0.01), "grip", other.tolist()),
            (pytest.approx(0.03), "grip", []),
        ]


@pytest.mark.parametrize("count", [1, 3])
def test_a_run_that_was_interrupted_goes_on_with_both(compiled, tmp_path, count):
    _, scene = compiled
    network, plan = scene.network, scene.plan
    whole = write(tmp_path / "whole.vtkhdf", network, plan)
    partial = write(tmp_path / "run.vtkhdf", network, plan, interrupt=AfterAsking(count))
    with Trajectory(partial) as file:
        checkpoint = file.checkpoint()
        assert not file.finished and len(file.tools) == len(file.times)
    with ResultWriter.resume(partial, checkpoint) as writer:
        outcome = run(network, plan, Recorder(network, plan, writer), resume=checkpoint.state)
        path = writer.close(outcome.message, outcome.kind == "done")
    with Trajectory(whole) as one, Trajectory(path) as other:
        assert np.array_equal(one.tools[:], other.tools[:])
        for first, second in zip(one.holds, other.holds, strict=True):
            assert (first.time, first.holder) == (second.time, second.holder)
            assert np.array_equal(first.nodes, second.nodes)


def test_threads_are_read_back(tmp_path):
    request = Request.file(library() / "scenes" / "ligature.tis")
    network = compile_request(request)[0].network
    recording = Recording(np.arange(0), np.arange(0), False, (), False)
    with ResultWriter(tmp_path / "sling.vtkhdf", network, recording, {}, "") as writer:
        path = writer.close("done", True)
    with Trajectory(path) as file:
        assert file.network.threads == network.threads
        assert np.array_equal(file.network.present, network.present)


def test_nodes_of_tools_are_finite(compiled, tmp_path):
    network = compiled[1].network
    recording = wishes(network, compiled[1].plan)
    with ResultWriter(tmp_path / "bad.vtkhdf", network, recording, {}, "") as writer:
        writer.topology(np.ones(network.entity_count, dtype=bool))
        place = network.position.copy()
        place[network.tools[0].nodes.start, 1] = np.nan
        still, slack = np.zeros_like(place), np.zeros(network.spring_count)
        fields = {"force": still[None], "tension": slack[None]}
        with pytest.raises(ValueError, match="position of node 0 is nan at 0 s"):
            writer.frames([0.0], place[None], still[None], fields)
        writer.close("done", True)
    with Trajectory(tmp_path / "bad.vtkhdf") as file:
        assert not len(file.times)
