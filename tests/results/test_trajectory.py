"""Reading: the indices of NumPy, and plain words about files that are none of ours."""

import os
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.results.conftest import CUT, example_of_a_tube
from tissuec.results import ResultError, layout
from tissuec.results.datasets import sums_as_text, sums_of_text
from tissuec.results.info import summary
from tissuec.results.schema import SUMS
from tissuec.results.trajectory import Trajectory


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    return example_of_a_tube().saved(tmp_path_factory.mktemp("written") / "a.vtkhdf")


@pytest.fixture
def path(tmp_path, written):
    """Return a result of the test's own, which it may change."""
    return Path(shutil.copy(written, tmp_path))


INDICES = [
    3,
    -1,
    np.int64(7),
    slice(None),
    slice(2, 30, 3),
    slice(None, None, -2),
    slice(10, 5),
    slice(-3, None),
    [0, 39, 5],
    [4],
    np.array([[1, 2], [30, 4]]),
    np.arange(40) % 7 == 0,
    (2, 5),
    (2, 5, 1),
    (slice(3, 8), 4),
    (slice(3, 8), [4, 5, 6], 2),
    (slice(None, None, 20), [1, 2]),
    ([0, 39], [1, 2]),
    ([0, 39], slice(2, 6), 0),
    (Ellipsis, 1),
    (slice(None), Ellipsis, 2),
    (None, 3),
    Ellipsis,
    (),
]


@pytest.mark.parametrize("index", INDICES, ids=str)
def test_frames_take_the_indices_of_arrays(path, example, index):
    with Trajectory.open(path) as read:
        assert np.array_equal(read.position[index], example.position[index])


def test_frames_read_only_what_is_asked_for(path, monkeypatch):
    with Trajectory.open(path) as read:
        frames, read_rows = read.position, []
        plain = type(frames)._read

        def counted(self, low, high):
            read_rows.append(high - low)
            return plain(self, low, high)

        monkeypatch.setattr(type(frames), "_read", counted)
        frames[5, 2]
        frames[[0, 39]]
        frames[3:6]
        assert read_rows == [1, 1, 1, 3]


@pytest.mark.parametrize("index", [40, -41, (0, 23), (0, 0, 3)])
def test_frames_that_are_not_there_are_index_errors(path, index):
    with Trajectory.open(path) as read, pytest.raises(IndexError):
        read.position[index]


@pytest.mark.parametrize("frame", [40, -41])
def test_forces_and_cells_of_no_frame_are_index_errors(path, frame):
    with Trajectory.open(path) as read:
        for ask in (read.spring_force, read.cells):
            with pytest.raises(IndexError, match=f"frame {frame} of 40"):
                ask(frame)


def test_frames_are_arrays_for_numpy(path, example):
    with Trajectory.open(path) as read:
        assert np.array_equal(np.mean(read.position, axis=0), example.position.mean(axis=0))
        assert len(read.position) == 40
        assert read.spring_force(-1)[0].tolist() == read.spring_force(39)[0].tolist()


def test_a_log_has_both_sides_of_an_event_beside_its_rows(path, example):
    with Trajectory.open(path) as read:
        log, other = read.logs.values()
        for one, rows in ((log, example.force[:, 0]), (read.energies, example.tension[:, :6])):
            assert np.array_equal(one.time, example.time)
            assert np.array_equal(one.value, rows)
            assert one.jumps.time.tolist() == [example.time[CUT]]
            assert np.array_equal(one.jumps.before, rows[CUT - 1 : CUT])
            assert np.array_equal(one.jumps.after, rows[CUT : CUT + 1])
            time, line = one.with_jumps()
            assert time[CUT : CUT + 3].tolist() == [example.time[CUT]] * 3
            assert np.array_equal(line, np.insert(rows, [CUT, CUT], rows[CUT - 1 : CUT + 1], 0))
        assert not len(other.jumps.time)
        assert other.jumps.before.shape == other.jumps.after.shape == (0, 2)
        assert np.array_equal(other.with_jumps()[1], other.value, equal_nan=True)


def without_jumps(path):
    """Make a result one of a version that kept no jumps."""
    with h5py.File(path, "r+") as file:
        sums = sums_of_text(file[SUMS.path][()].decode())
        for name in [name for name in sums if "/jumps/" in name]:
            del file[name], sums[name]
        for group in (*file["tissuec/logs"].values(), file["tissuec/energies"]):
            del group["jumps"]
        del file[SUMS.path]
        file[SUMS.path] = np.bytes_(sums_as_text(sums))


def test_a_result_without_jumps_is_read_as_it_was_written(path, example):
    without_jumps(path)
    with Trajectory.open(path) as read:
        log = read.logs["force of forceps A"]
        assert not len(log.jumps.time) and log.jumps.before.shape == (0, 3)
        time, value = log.with_jumps()
        assert np.array_equal(time, example.time)
        assert np.array_equal(value, example.force[:, 0])
        assert summary(read)["logs"]["force of forceps A"]["jumps"] == 0


def test_unknown_logs_are_missing_keys(path):
    with Trajectory.open(path) as read:
        assert "force" not in read.logs
        with pytest.raises(KeyError):
            read.logs["force"]


def test_a_missing_file_is_said_and_an_unfinished_one_is_pointed_at(tmp_path, example):
    with pytest.raises(ResultError, match=r'there is no file ".*a.vtkhdf"$'):
        Trajectory.open(tmp_path / "a.vtkhdf")
    example.open(tmp_path / "a.vtkhdf").close("interrupted", finished=False)
    with pytest.raises(ResultError, match=r'an unfinished result: ".*a\.partial\.vtkhdf"'):
        Trajectory.open(tmp_path / "a.vtkhdf")


def test_other_files_are_told_from_results(tmp_path):
    text, plain = tmp_path / "text.vtkhdf", tmp_path / "plain.vtkhdf"
    text.write_text("language 1\n")
    with pytest.raises(ResultError, match="it is not an HDF5 file"):
        Trajectory.open(text)
    with h5py.File(plain, "w") as file:
        file["VTKHDF"] = 1
    with pytest.raises(ResultError, match="is an HDF5 file, but not a result of tissuec"):
        Trajectory.open(plain)
    (tmp_path / "empty.vtkhdf").touch()
    with pytest.raises(ResultError, match="cannot read"):
        Trajectory.open(tmp_path / "empty.vtkhdf")


def test_a_truncated_file_is_told(path):
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 2 // 3])
    with pytest.raises(ResultError, match="it is truncated"):
        Trajectory.open(path)


def test_another_layout_is_told(path):
    with h5py.File(path, "r+") as file:
        file["tissuec"].attrs["layout_version"] = 2
        file["tissuec/manifest"].attrs["tissuec"] = "0.1.0"
    with pytest.raises(ResultError) as refused:
        Trajectory.open(path)
    assert str(refused.value) == (
        f'"{path}" has layout 2 (of tissuec 0.1.0), but this version of tissuec reads layout '
        "4; read it with the version that wrote it, or run the scene again"
    )


@pytest.mark.parametrize("name", ["VTKHDF/Points", "VTKHDF/Steps", "tissuec/recording"])
def test_a_damaged_file_names_what_is_missing(path, name):
    with h5py.File(path, "r+") as file:
        del file[name]
    with pytest.raises(ResultError, match=f'"/{name}.*missing'):
        Trajectory.open(path)


def test_frames_are_flushed_in_batches_by_themselves(tmp_path, example, monkeypatch):
    # However slow the machine is: sooner only if they waited long.
    monkeypatch.setattr("tissuec.results.writer._LONGEST_WAIT", 1e9)
    with example.open(tmp_path / "a.vtkhdf") as writer:
        writer.topology(example.alive(0))
        state = example.position[:1], example.velocity[:1], example.fields(slice(1))
        shown = []
        for frame in range(130):
            writer.frames([frame], *state)
            if frame % 9 == 0 or frame in (62, 64, 127):  # just before and after, and between
                with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
                    shown.append(len(read.times))
    assert sorted(set(shown)) == [0, 64, 128]


@pytest.mark.parametrize("limit", ["_LONGEST_WAIT", "_MOST_WAITING"])
def test_rows_are_flushed_when_they_wait_long_or_are_many(
    tmp_path, example, monkeypatch, limit
):
    monkeypatch.setattr(f"tissuec.results.writer.{limit}", 0)
    with example.open(tmp_path / "a.vtkhdf") as writer:
        writer.log("force of forceps A", [0.5], [[1.0, 2.0, 3.0]])
        with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
            assert read.logs["force of forceps A"].value.tolist() == [[1.0, 2.0, 3.0]]


def test_a_file_is_open_to_other_readers_while_it_is_written(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        for first in range(0, 40, 10):
            example.write(writer, first=first, last=first + 10)
            writer.flush()
            with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
                assert np.array_equal(read.position[:], example.position[: first + 10])


def test_a_file_that_is_changed_while_it_is_opened_is_opened_again(path, monkeypatch):
    opened, times = layout._open_whole, []

    def open_amid_a_change(path, through):
        times.append(os.utime(path, ns=(len(times), len(times))))
        if len(times) < 3:
            raise ResultError("half of it is new")
        return opened(path, through)

    monkeypatch.setattr(layout, "_open_whole", open_amid_a_change)
    with Trajectory(path) as run:
        assert len(run.times)
    assert len(times) == 3


def test_a_file_without_content_is_said_to_hold_nothing_yet(tmp_path):
    begun = tmp_path / "a.partial.vtkhdf"
    for content in (b"", bytes(4096)):
        begun.write_bytes(content)
        with pytest.raises(ResultError, match="it is still empty"):
            Trajectory(begun)
