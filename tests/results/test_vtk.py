"""ParaView's own reader sees every frame as it was written."""

import h5py
import numpy as np
import pytest

from tissuec.core.structs import replace

pytest.importorskip("vtkmodules.vtkIOHDF")
from vtkmodules.util.numpy_support import vtk_to_numpy

from tests.vtk_reading import LINE, TRIANGLE, VERTEX, cells_of, opened
from tissuec.laws import LINEAR
from tissuec.model.springs import Springs
from tissuec.results.recording import Recording
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter


def shown(reader, frame):
    reader.SetStep(frame)
    reader.Update()
    return reader.GetOutput()


def assert_frame_is(data, example, frame, nodes):
    """Compare one frame of a recording of ``nodes`` with what was given."""
    kind = np.float32 if example.recording.single else np.float64
    assert np.array_equal(
        vtk_to_numpy(data.GetPoints().GetData()), example.position[frame, nodes].astype(kind)
    )
    points = data.GetPointData()
    for name, source in (("velocity", example.velocity), ("force", example.force)):
        assert np.array_equal(
            vtk_to_numpy(points.GetArray(name)), source[frame, nodes].astype(kind)
        )
    identities = vtk_to_numpy(points.GetArray("node_id"))
    assert np.array_equal(identities, example.network.node_ids[nodes])
    springs = example.recording.lines[example.alive(frame)[example.recording.lines]]
    lines = cells_of(data, LINE)
    assert np.array_equal(nodes[lines], example.network.springs.ends[springs])
    first = len(cells_of(data, VERTEX))
    tension = vtk_to_numpy(data.GetCellData().GetArray("spring_force"))
    assert len(tension) == first + len(lines) + len(cells_of(data, TRIANGLE))
    assert np.array_equal(
        tension[first : first + len(lines)], example.tension[frame, springs].astype(kind)
    )
    assert not tension[first + len(lines) :].any()
    numbers = vtk_to_numpy(data.GetCellData().GetArray("spring_id"))
    assert np.array_equal(
        numbers[first : first + len(lines)], example.network.springs.ids[springs]
    )


def assert_all_frames(path, example, nodes):
    reader = opened(path)
    assert reader.GetNumberOfSteps() == len(example.time)
    order = np.random.default_rng(1).permutation(len(example.time))
    for frame in [*range(len(example.time)), *order.tolist()]:
        assert_frame_is(shown(reader, frame), example, frame, nodes)
        assert reader.GetTimeValue() == example.time[frame]


@pytest.mark.parametrize("single", [False, True])
def test_every_frame_is_seen_through_a_cut_in_any_order(tmp_path, example, single):
    example = example.recorded(single=single)
    path = example.saved(tmp_path / "a.vtkhdf")
    assert_all_frames(path, example, example.recording.nodes)
    reader = opened(path)
    assert len(cells_of(shown(reader, 0), TRIANGLE)) == len(example.network.skin)
    assert len(cells_of(shown(reader, 20), TRIANGLE)) == len(example.network.skin) - 8
    with Trajectory.open(path) as read:
        for frame in (0, 20, 35):
            polygons = cells_of(shown(reader, frame), TRIANGLE)
            assert np.array_equal(polygons, read.cells(frame).triangles)


def test_the_filter_of_the_manual_leaves_springs_with_numbers_alone(tmp_path, example):
    filters = pytest.importorskip("vtkmodules.vtkFiltersExtraction")
    reader = opened(example.saved(tmp_path / "a.vtkhdf"))
    lines = filters.vtkExtractCellsByType()
    lines.SetInputConnection(reader.GetOutputPort())
    lines.AddCellType(3)  # VTK_LINE
    lines.Update()
    tension = vtk_to_numpy(lines.GetOutput().GetCellData().GetArray("spring_force"))
    assert len(tension) == example.alive(0).sum()
    assert np.isfinite(tension).all()


def test_one_body_of_two_is_seen_alone(tmp_path, example):
    nodes = np.arange(4, 23)
    springs = np.flatnonzero(np.isin(example.network.springs.ends, nodes).all(axis=1))
    example = example.recorded(nodes=nodes, lines=springs)
    assert_all_frames(example.saved(tmp_path / "a.vtkhdf"), example, nodes)


def test_a_partial_file_is_seen_while_it_is_written(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        opened(tmp_path / "a.partial.vtkhdf").Update()
        example.write(writer, last=30)
        writer.flush()
        reader = opened(tmp_path / "a.partial.vtkhdf")
        assert reader.GetNumberOfSteps() == 30
        for frame in (29, 3, 17):
            assert_frame_is(shown(reader, frame), example, frame, example.recording.nodes)
        writer.close("stopped", finished=False)
    assert opened(tmp_path / "a.partial.vtkhdf").GetNumberOfSteps() == 30


def test_single_nodes_are_seen_as_vertices(tmp_path, example):
    alive = example.alive(0)
    alive[-2:] = False
    with example.open(tmp_path / "a.vtkhdf") as writer:
        writer.topology(alive)
        state = example.position[:1], example.velocity[:1], example.fields(slice(1))
        writer.frames(example.time[:1], *state)
        path = writer.close("done", finished=True)
    data = shown(opened(path), 0)
    assert cells_of(data, VERTEX).ravel().tolist() == [20, 21, 22]
    numbers = vtk_to_numpy(data.GetCellData().GetArray("spring_id"))
    expected = np.concatenate([[-1] * 3, example.network.springs.ids[:-2], [-1] * 32])
    assert np.array_equal(numbers, expected)


@pytest.mark.parametrize("nodes", [0, 1, 3])
@pytest.mark.parametrize("frames", [0, 1])
def test_files_without_springs_or_frames_open(tmp_path, example, nodes, frames):
    recording = Recording(np.arange(nodes), np.arange(0), False, (), False)
    with ResultWriter(tmp_path / "a.vtkhdf", example.network, recording, {}, "") as writer:
        writer.topology(example.alive(0))
        state = [data[:frames] for data in (example.position, example.velocity)]
        writer.frames(example.time[:frames], *state, example.fields(slice(frames)))
        path = writer.close("done", finished=True)
    reader = opened(path)
    reader.Update()
    assert len(cells_of(reader.GetOutput(), LINE)) == 0
    if frames and nodes:
        points = vtk_to_numpy(shown(reader, 0).GetPoints().GetData())
        assert np.array_equal(points, example.position[0, :nodes])


def test_a_large_network_fills_chunks_that_do_not_end_with_frames(tmp_path, example):
    network = example.network
    count, frames = 10_001, 3
    random = np.random.default_rng(0)
    position = random.normal(size=(count, 3))
    chain = np.stack([np.arange(count - 1), np.arange(1, count)], axis=-1).astype(np.int32)
    ones = np.ones(count - 1)
    large = replace(
        network,
        position=position,
        velocity=np.zeros((count, 3)),
        mass=np.ones(count),
        springs=Springs(
            chain, *[ones] * 5, np.zeros(count - 1, np.int32), (LINEAR,), np.arange(count - 1)
        ),
        skin=network.skin[:0],
        node_ids=np.arange(count),
        bodies=(),
    )
    recording = Recording(np.arange(count), np.arange(count - 1), False, (), False)
    states = random.normal(size=(frames, count, 3))
    with ResultWriter(tmp_path / "a.vtkhdf", large, recording, {}, "") as writer:
        writer.topology(np.ones(count - 1, dtype=bool))
        for frame in range(frames):
            rows = states[frame : frame + 1]
            fields = {"force": rows, "tension": np.zeros((1, count - 1))}
            writer.frames([frame * 0.1], rows, rows, fields)
        path = writer.close("done", finished=True)
    reader = opened(path)
    for frame in (2, 0, 1):
        points = vtk_to_numpy(shown(reader, frame).GetPoints().GetData())
        assert np.array_equal(points, states[frame])
    with h5py.File(path) as file:
        assert file["VTKHDF/Points"].chunks[0] == 8192
