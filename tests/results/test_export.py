"""Exports hold the numbers of the file."""

import csv
import io
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissuec.results import ResultError
from tissuec.results.export import (
    frame_shape,
    table_data,
    table_names,
    table_rows,
    without_rounding,
    write_csv,
)
from tissuec.results.info import summary
from tissuec.results.shapes import write_obj, write_vtu
from tissuec.results.trajectory import Trajectory


@pytest.fixture
def read(tmp_path, example):
    with Trajectory.open(example.saved(tmp_path / "a.vtkhdf", method="dop853")) as trajectory:
        yield trajectory


def table(trajectory, names):
    stream = io.StringIO()
    write_csv(table_rows(trajectory, names), stream)
    return list(csv.reader(io.StringIO(stream.getvalue())))


def test_a_log_comes_back_from_csv_to_the_last_digit(read, example):
    head, *rows = table(read, "force of forceps A")
    assert head == ["time [s]", *(f"force of forceps A {axis} [N]" for axis in "xyz")]
    numbers = np.array(rows, dtype=float)
    assert np.array_equal(numbers[:, 0], [*map(without_rounding, example.time)])
    assert np.array_equal(numbers[:, 1:], example.force[:, 0])


def test_rounding_errors_are_zero_in_csv(tmp_path, example):
    force = example.recording.logs[0].name
    with example.open(tmp_path / "b.vtkhdf") as writer:
        writer.log(force, [0.0, 0.1], [[8.7e-15, -1.08e-27, 2e-12], [1.0, 0.0, -1.25]])
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as trajectory:
        rows = table(trajectory, force)[1:]
        assert trajectory.logs[force].value[0, 0] == 8.7e-15
    assert rows == [["0", "0.0", "0.0", "2e-12"], ["100", "1.0", "0.0", "-1.25"]]


def test_times_are_those_that_the_scene_says(tmp_path, example):
    force, tension = (channel.name for channel in example.recording.logs)
    odd = 4.123456789012345678
    times = [0.1 * 3, 0.1 * 7, 1.1 + 2.2, odd]
    with example.open(tmp_path / "b.vtkhdf") as writer:
        writer.log(force, times, np.arange(12.0).reshape(4, 3))
        writer.log(tension, [0.3], [[7, 8]])
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as trajectory:
        rows = table(trajectory, [force])[1:]
        assert table_data(trajectory, [force])[force]["time"] == times
    assert [row[0] for row in rows] == ["0.3", "0.7", "3.3", repr(odd)]


@given(st.floats(1e-9, 1e6))
def test_a_time_changes_by_two_units_in_the_last_place_at_most(time):
    found = without_rounding(time)
    assert abs(found - time) <= 2.0 * np.spacing(time)
    assert without_rounding(found) == found


@given(st.integers(1, 10**6), st.sampled_from([1e-3, 1e-2, 0.1, 5e-3, 2.5e-4]))
def test_multiples_of_an_interval_have_no_rounding_error(count, interval):
    exact = Decimal(count) * Decimal(repr(interval))
    assert Decimal(repr(without_rounding(count * interval))) == exact


def test_energies_and_several_logs_share_a_table(read, example):
    head, *rows = table(read, ["energies", "tension of a/b"])
    assert head[1] == "energies kinetic [J]"
    assert head[7:] == ["tension of a/b 3 [N]", "tension of a/b 7 [N]"]
    numbers = np.array(rows, dtype=float)
    assert np.array_equal(numbers[:, 1:7], example.tension[:, :6])
    assert np.array_equal(numbers[:, 7:], example.tension[:, 3:5])


def test_logs_of_other_times_leave_fields_empty_and_repeated_times_stay(tmp_path, example):
    force, tension = (channel.name for channel in example.recording.logs)
    with example.open(tmp_path / "b.vtkhdf") as writer:
        writer.log(force, [0.0, 0.2], [[1, 2, 3], [4, 5, 6]])
        writer.log(tension, [0.1, 0.2, 0.2], [[7, 8], [9, 10], [11, np.nan]])
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as trajectory:
        rows = table(trajectory, [force, tension])[1:]
    assert rows == [
        ["0", "1.0", "2.0", "3.0", "", ""],
        ["100", "", "", "", "7.0", "8.0"],
        ["200", "4.0", "5.0", "6.0", "9.0", "10.0"],
        ["200", "", "", "", "11.0", "nan"],
    ]


def test_events_name_springs_as_the_scene_does(read):
    assert table(read, "events") == [
        ["time [s]", "kind", "springs", "cause", "place"],
        [
            "0.68",
            "cut",
            "tube:25 tube:26 tube:27 tube:28",
            "cut tube with shears",
            "scene.tis:8",
        ],
        ["1.16", "rupture", "tube:1", "tension above 2 N", "scene.tis:3"],
    ]


def test_an_unknown_log_is_an_error_with_the_known_ones(read):
    with pytest.raises(
        ResultError, match=r'no log "forc of forceps A".*did you mean "force of'
    ):
        table(read, "forc of forceps A")


def test_tables_as_data_hold_what_the_file_holds(read, example):
    assert table_names(read) == ["force of forceps A", "tension of a/b", "energies", "events"]
    data = table_data(read, ["energies", "events"])
    assert np.array_equal(data["energies"]["value"], example.tension[:, :6])
    assert data["energies"]["time"] == example.time.tolist()
    assert data["events"][1] == {
        "time": 1.16,
        "kind": "rupture",
        "springs": "tube:1",
        "cause": "tension above 2 N",
        "place": "scene.tis:3",
    }


def test_events_among_other_tables_are_refused_with_the_remedy(read):
    with pytest.raises(ResultError, match="export it alone"):
        table(read, ["energies", "events"])


def test_names_of_tables_are_only_those_that_hold_something(tmp_path, example):
    path = example.recorded(energies=False, logs=()).open(tmp_path / "b.vtkhdf")
    with Trajectory.open(path.close("nothing happened", finished=True)) as trajectory:
        assert table_names(trajectory) == []


@pytest.mark.parametrize("frame", [0, 20, -1])
def test_a_vtu_file_holds_a_frame(tmp_path, read, example, frame):
    xml = pytest.importorskip("vtkmodules.vtkIOXML")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    path = tmp_path / "frame.vtu"
    write_vtu(frame_shape(read, frame), path)
    reader = xml.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()

    def of(data, name):
        return vtk_to_numpy(data.GetArray(name))

    assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), example.position[frame])
    for name in ("velocity", "force"):
        assert np.array_equal(of(grid.GetPointData(), name), getattr(example, name)[frame])
    assert np.array_equal(of(grid.GetPointData(), "node_id"), example.network.node_ids)
    assert of(grid.GetFieldData(), "TimeValue") == [example.time[frame]]
    cells = read.cells(frame)
    total, lines = len(cells.lines) + len(cells.triangles), slice(len(cells.lines))
    kinds = [grid.GetCellType(cell) for cell in range(grid.GetNumberOfCells())]
    assert kinds == [3] * len(cells.lines) + [5] * len(cells.triangles)
    connectivity = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    expected = np.concatenate([cells.lines.ravel(), cells.triangles.ravel()])
    assert np.array_equal(connectivity, expected)
    force = of(grid.GetCellData(), "spring_force")
    assert np.array_equal(force[lines], example.tension[frame, cells.line_numbers])
    assert len(force) == total
    assert not force[len(cells.lines) :].any()
    ids = of(grid.GetCellData(), "spring_id")
    assert np.array_equal(ids[lines], example.network.springs.ids[cells.line_numbers])


def test_an_obj_file_holds_a_frame(tmp_path, read, example):
    path = tmp_path / "frame.obj"
    write_obj(frame_shape(read, 20), path)
    lines = [line.split() for line in path.read_text().splitlines()]

    def of(letter):
        return np.array([line[1:] for line in lines if line[0] == letter], dtype=float)

    assert np.array_equal(of("v"), example.position[20])
    assert np.array_equal(of("l") - 1, read.cells(20).lines)
    assert np.array_equal(of("f") - 1, read.cells(20).triangles)


@pytest.mark.parametrize("write", [write_vtu, write_obj])
def test_exports_say_what_is_wrong(tmp_path, read, write):
    with pytest.raises(IndexError, match="frame 99 of 40"):
        frame_shape(read, 99)
    with pytest.raises(ResultError, match="No such file or directory"):
        write(frame_shape(read, 0), tmp_path / "missing" / "frame")


def test_the_summary_counts_what_the_file_holds(read, example):
    short = summary(read)
    assert short["frames"] == {
        "count": 40,
        "nodes": 23,
        "springs": 42 - 4,
        "precision": "double",
        "compressed": False,
        "first_time": 0.0,
        "last_time": example.time[-1],
        "fields": ["force", "tension"],
    }
    assert short["events"] == {"cut": 1, "rupture": 1}
    assert short["logs"]["tension of a/b"]["columns"] == [3, 7]
    assert short["energies"]["rows"] == 40
    assert short["network"] == {"nodes": 23, "springs": 38, "bodies": ["tube", "rod"]}
    assert (short["method"], short["finished"], short["can_resume"]) == ("dop853", True, False)
    assert short["versions"]["numpy"] == np.__version__


def test_the_summary_of_an_empty_run_has_no_times(tmp_path, example):
    path = example.recorded(energies=False, logs=()).open(tmp_path / "b.vtkhdf")
    with Trajectory.open(path.close("nothing happened", finished=True)) as trajectory:
        short = summary(trajectory)
    assert short["frames"]["first_time"] is None
    assert short["energies"] is None
    assert short["events"] == {}
