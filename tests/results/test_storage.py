"""Frames are rounded, or compressed without loss, where that is asked for, and logs are not."""

import json

import numpy as np
import pytest

from tests.engine.execution.test_run_to_file import write
from tests.results.test_instruments import SCENE
from tests.test_cli import tissuec
from tests.vtk_reading import opened
from tests.whole_runs import AfterAsking
from tissuec.compiler.prediction import predict
from tissuec.core.resources import library
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter
from tissuec.scene.request import Request

VECTORS = ("position", "velocity", "force")
SCENES = (
    "sterilisation", "bladder", "hanging_net", "indentation", "ligature", "liver", "palpation",
    "rupture", "suture", "tubal_ligation",
)  # fmt: skip
STORAGES = [(True, False), (False, True), (True, True)]


def stored(compiled, *, single, compress):
    output = replace(compiled.plan.output, single=single, compress=compress)
    return replace(compiled, plan=replace(compiled.plan, output=output))


def of_scene(stem):
    request = Request.file(library() / "scenes" / f"{stem}.tis")
    return request, compile_request(request)[0]


@pytest.mark.parametrize(
    ("stem", "single", "compress"),
    [
        (SCENES[0], True, False),
        *(pytest.param(SCENES[0], *how, marks=pytest.mark.slow) for how in STORAGES[1:]),
        *(
            pytest.param(stem, *how, marks=pytest.mark.slow)
            for stem in SCENES[1:]
            for how in STORAGES
        ),
    ],
)
def test_results_are_as_large_as_foretold(
    stem, single, compress, tmp_path, shipped, monkeypatch
):
    # Whether a run lasts long enough for a checkpoint depends on the machine.
    monkeypatch.setattr("tissuec.engine.execution.run.CHECKPOINT_EVERY", np.inf)
    request, compiled = of_scene(stem)
    compiled = stored(compiled, single=single, compress=compress)
    path = tmp_path / "a.vtkhdf"
    simulate(compiled, path, request=request, companion="off")
    foretold, size = predict(compiled).bytes, path.stat().st_size
    if compress:  # how much smaller it is depends on the motion
        assert size < foretold
    else:
        assert foretold == pytest.approx(size, rel=0.1)
    kind = np.float32 if single else np.float64
    with Trajectory.open(path) as trajectory, Trajectory.open(shipped(stem).path) as exact:
        for name in VECTORS:
            found = getattr(trajectory, name)[:]
            assert found.dtype == kind
            assert np.array_equal(found, getattr(exact, name)[:].astype(kind))
        for name, log in exact.logs.items():
            assert np.array_equal(
                np.asarray(log.value), np.asarray(trajectory.logs[name].value)
            )


MIXED = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
tissue net { spring constant = 40 N/m; viscosity = 5 mN*s/m; mass = 0.2 g }
body block {
  mesh is lattice { cell = 2 mm; box from (0, 0, 0) mm to (24, 24, 24) mm }; tissue is gel
}
body cloth {
  mesh is sheet {
    corner = (0, 0, 40) mm; first edge = (20, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = 5; rows = 5; diagonals is both
  }
  tissue is net
}
environment { gravity = (0, 0, 0) m/s^2 }
script { from 0 s to 1 ms: push cloth with (0, 0, 1) N
  at 0.55 ms: cut cloth along line from (12, -1, 40) mm to (12, 9, 40) mm facing (1, 0, 0) }
simulate { duration = 1 ms; integrator is velocity verlet; step = 50 us }
output { trajectory with stress tensor every 0.1 ms }
"""


def test_cells_without_numbers_take_no_room(tmp_path):
    """Forces of springs at elements, and stresses of elements at springs."""
    request = Request(Source("mixed.tis", MIXED))
    compiled = compile_request(request)[0]
    path = tmp_path / "a.vtkhdf"
    simulate(compiled, path, request=request, companion="off")
    assert predict(compiled).bytes == pytest.approx(path.stat().st_size, rel=0.03)
    part = write(tmp_path / "b.vtkhdf", compiled.network, compiled.plan,
                 interrupt=AfterAsking(2))  # fmt: skip
    with Trajectory(part) as file:
        checkpoint = file.checkpoint()
    with ResultWriter.resume(part, checkpoint) as writer:
        recorder = Recorder(compiled.network, compiled.plan, writer)
        outcome = run(compiled.network, compiled.plan, recorder, resume=checkpoint.state)
        resumed = writer.close(outcome.message, outcome.kind == "done")
    with Trajectory(path) as one, Trajectory(resumed) as other:
        data, again = (each.content.raw["VTKHDF/CellData"] for each in (one, other))
        for name, most in (("spring_force", 0.4), ("stress", 1.1)):
            assert np.array_equal(data[name][()], again[name][()])
            for frame in range(len(one.times)):
                drawn, grid = data[name], one.drawing(frame).grid
                first = one.content.raw[f"VTKHDF/Steps/CellDataOffsets/{name}"][frame]
                rows = drawn[first : first + len(grid)]
                at = "spring" if name == "spring_force" else "element"
                there = np.zeros(len(grid), dtype=bool)
                there[grid.rows[at]] = True
                assert not rows[~there].any()
            assert drawn.id.get_storage_size() < most * drawn.nbytes
        assert np.abs(np.nan_to_num(one.tension[:])).max() > 0.0


@pytest.fixture(scope="module")
def pad():
    return compile_request(Request(Source("pad.tis", SCENE)))[0]


@pytest.mark.parametrize(("single", "compress"), STORAGES)
def test_vtk_reads_frames_however_they_are_stored(pad, single, compress, tmp_path):
    pytest.importorskip("vtkmodules.vtkIOHDF")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    scene = stored(pad, single=single, compress=compress)
    path = write(tmp_path / "a.vtkhdf", scene.network, scene.plan)
    reader = opened(path)
    with Trajectory.open(path) as trajectory:
        assert trajectory.is_compressed == compress
        for frame in (0, 3, 4):
            reader.SetStep(frame)
            reader.Update()
            points = vtk_to_numpy(reader.GetOutputDataObject(0).GetPoints().GetData())
            assert np.array_equal(points, trajectory.position[frame])
            assert points.dtype == trajectory.tools.dtype == ("f4" if single else "f8")


@pytest.mark.parametrize("count", [1, 3])
def test_an_interrupted_run_goes_on_storing_as_it_began(pad, count, tmp_path):
    scene = stored(pad, single=True, compress=True)
    network, plan = scene.network, scene.plan
    whole = write(tmp_path / "whole.vtkhdf", network, plan)
    part = write(tmp_path / "run.vtkhdf", network, plan, interrupt=AfterAsking(count))
    with Trajectory(part) as file:
        checkpoint = file.checkpoint()
    with ResultWriter.resume(part, checkpoint) as writer:  # the plan says otherwise
        outcome = run(network, pad.plan, Recorder(network, pad.plan, writer),
                      resume=checkpoint.state)  # fmt: skip
        path = writer.close(outcome.message, outcome.kind == "done")
    with Trajectory(whole) as one, Trajectory(path) as other:
        for name in (*VECTORS, "tools"):
            assert np.array_equal(getattr(one, name)[:], getattr(other, name)[:])
        sides = other.content.raw["tissuec/sides/position"]
        assert (sides.dtype, sides.compression) == ("f4", "gzip")


def test_the_command_line_says_how_frames_are_stored(tmp_path):
    (tmp_path / "pad.tis").write_text(SCENE)
    done = tissuec(
        "run", "pad.tis", "--precision", "single", "--compress", "--companion", "off",
        cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    frames = json.loads(tissuec("--json", "info", "pad.vtkhdf", cwd=tmp_path).stdout)["frames"]
    assert (frames["precision"], frames["compressed"]) == ("single", True)
    again = tissuec("run", "pad.tis", "--resume", "--compress", cwd=tmp_path)
    assert again.returncode == 2 and "keeps the storage with which it began" in again.stderr
    (tmp_path / "bare.tis").write_text(SCENE.replace("trajectory every 10 ms", ""))
    bare = tissuec("run", "bare.tis", "--compress", cwd=tmp_path)
    assert bare.returncode == 2 and "records no frames for --compress" in bare.stderr
