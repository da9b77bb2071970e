"""The paper's example, from its text file to the pictures that other programs make of it."""

import h5py
import numpy as np
import pytest

from tests.vtk_reading import LINE, cells_of
from tissuec.core.structs import replace
from tissuec.pipeline import compile_request
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request

CUT = 0.7


@pytest.fixture
def result(shipped):
    return shipped("sterilisation")


def test_all_expectations_hold_and_nothing_ruptures(result):
    assert result.outcome.kind == "done"
    assert not result.outcome.failures
    assert not [h for _, h in result.outcome.logged_events if h.kind == "rupture"]


def test_the_paper_counts_its_nodes_and_springs_so(result):
    with Trajectory.open(result.path) as trajectory:
        network = trajectory.network
        assert (network.node_count, network.spring_count) == (160, 610)


def test_both_published_layouts_have_610_springs(repository):
    text = (repository / "library" / "scenes" / "sterilisation.tis").read_text()
    request = Request.file(repository / "library" / "scenes" / "sterilisation.tis")
    other = text.replace(
        "diagonals is none; interior is crossed", "diagonals is both; interior is none"
    )
    assert other != text
    request = replace(request, source=replace(request.source, text=other))
    compiled, _ = compile_request(request)
    assert (compiled.network.node_count, compiled.network.spring_count) == (160, 610)


def test_paraviews_reader_returns_every_frame_as_h5py_does(result):
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(result.path))
    reader.UpdateInformation()
    springs = []
    with h5py.File(result.path) as file, Trajectory.open(result.path) as trajectory:
        nodes = trajectory.network.node_count
        assert reader.GetNumberOfSteps() == len(trajectory.times) == 51
        points = file["VTKHDF/Points"][:].reshape(-1, nodes, 3)
        view = file["particles/all/position/value"]
        for frame, time in enumerate(trajectory.times):
            reader.SetStep(frame)
            reader.Update()
            data = reader.GetOutput()
            seen = vtk_to_numpy(data.GetPoints().GetData())
            assert np.array_equal(seen, points[frame])
            assert np.array_equal(seen, view[frame])
            springs.append((time, len(cells_of(data, LINE))))
    assert {count for time, count in springs if time < CUT} == {610}
    assert {count for time, count in springs if time >= CUT} == {580}


def test_the_same_text_compiles_to_the_same_bytes(repository):
    path = repository / "library" / "scenes" / "sterilisation.tis"
    first, second = (compile_request(Request.file(path))[0].network for _ in range(2))
    for name in (
        "position",
        "velocity",
        "mass",
        "ends",
        "stiffness",
        "damping",
        "rest",
        "strength",
    ):
        assert first.array(name).tobytes() == second.array(name).tobytes()


def test_every_array_names_the_line_it_came_from(repository):
    network = compile_request(
        Request.file(repository / "library" / "scenes" / "sterilisation.tis")
    )[0].network
    origin = network.provenance["stiffness"][17]
    assert origin.how == "rules"
    assert origin.span.text.startswith("if hardness is soft and elasticity is big")
    assert network.provenance["rest"][0].span.text == "prestress = 2 %"
