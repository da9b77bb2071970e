"""A run that was interrupted and gone on with leaves the file of an uninterrupted one."""

import json
from functools import cache

import h5py
import numpy as np
import pytest

from tests.results.conftest import SCENE, SURFACES, example_of_a_tube
from tissuec.core.structs import replace
from tissuec.results import PlaceError, ResultError
from tissuec.results.resuming import find_checkpoint
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter

CHECKPOINTS = (5, 12, 17, 23, 29, 33)


def content(path):
    """Return every dataset by path; the manifest without what the clock decides."""
    found = {}
    with h5py.File(path, "r") as file:

        def visit(name, member):
            if isinstance(member, h5py.Dataset):
                found[name] = member[()]

        file.visititems(visit)
        found["steps"] = file["VTKHDF/Steps"].attrs["NSteps"]
    manifest = json.loads(found.pop("tissuec/manifest"))
    assert found.pop("tissuec/checkpoint/wall_time") > 0
    assert found.pop("tissuec/checksums")  # of that, too
    by_clock = ("wall_time", "begun")
    found["manifest"] = {name: manifest[name] for name in manifest if name not in by_clock}
    return found


def assert_same(one, second):
    first = content(one)
    assert set(first) == set(second)
    for name in first:
        np.testing.assert_equal(first[name], second[name], err_msg=name)


def uninterrupted(folder, example):
    """Return the content of the file of a whole run."""
    with example.open(folder / "whole.vtkhdf", method="dop853") as writer:
        example.write(writer, checkpoints=CHECKPOINTS)
        return content(writer.close("done", finished=True))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return what the file of a whole run with surfaces holds, in either precision."""

    @cache
    def written(single):
        recorded = example_of_a_tube().recorded(single=single, surfaces=SURFACES)
        return uninterrupted(tmp_path_factory.mktemp("whole"), recorded)

    return written


def go_on(example, path):
    """Resume the file at ``path`` and write the rest of it."""
    with Trajectory.open(path) as read:
        checkpoint = read.checkpoint()
    with ResultWriter.resume(path, checkpoint) as writer:
        first = checkpoint.state["frame"]
        assert np.array_equal(checkpoint.state["position"], example.position[first])
        example.write(writer, first=first, checkpoints=CHECKPOINTS)
        return writer.close("done", finished=True)


@pytest.mark.parametrize(
    ("last", "single"),
    [
        *((last, False) for last in (6, 17, 31)),
        (17, True),
        *(
            pytest.param(last, single, marks=pytest.mark.slow)
            for single, lasts in ((False, (12, 16, 18, 22, 28, 29, 39)), (True, (6, 31)))
            for last in lasts
        ),
    ],
)
def test_an_interrupted_run_gone_on_with_equals_an_uninterrupted_one(
    tmp_path, example, whole, last, single
):
    example = example.recorded(single=single, surfaces=SURFACES)
    with example.open(tmp_path / "a.vtkhdf", method="dop853") as writer:
        example.write(writer, last=last, batch=4, checkpoints=CHECKPOINTS)
        partial = writer.close("interrupted", finished=False)
    assert_same(go_on(example, partial), whole(single))


def test_a_run_can_be_gone_on_with_again_and_again(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf", method="dop853") as writer:
        example.write(writer, last=6, checkpoints=CHECKPOINTS)
        path = writer.close("interrupted", finished=False)
    for last in (14, 20, 31):
        with Trajectory.open(path) as read:
            checkpoint = read.checkpoint()
        with ResultWriter.resume(tmp_path / "a.vtkhdf", checkpoint) as writer:
            first = checkpoint.state["frame"]
            example.write(writer, first=first, last=last, checkpoints=CHECKPOINTS)
            writer.close("interrupted", finished=False)
    assert_same(go_on(example, path), uninterrupted(tmp_path, example))


def test_what_a_companion_said_is_forgotten_where_a_run_killed_at_its_end_goes_on(
    tmp_path, example
):
    with example.open(tmp_path / "a.vtkhdf", method="dop853") as writer:
        example.write(writer, last=20, checkpoints=CHECKPOINTS)
        writer.companion([0.1, 0.2], [[1e-6], [2e-6]])
        path = writer.close("done", finished=False, facts={"promise": {"state": "kept"}})
    result = go_on(example, path)
    with Trajectory.open(result) as read:
        assert read.companion is None and read.promise.state == "not checked"


def test_a_cut_that_no_frame_has_shown_is_not_forgotten(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=17)
        writer.topology(example.alive(17))
        writer.checkpoint({"frame": 17})
        path = writer.close("interrupted", finished=False)
    with Trajectory.open(path) as read:
        checkpoint = read.checkpoint()
    rows = slice(17, 18)
    with ResultWriter.resume(path, checkpoint) as writer:
        state = example.position[rows], example.velocity[rows], example.fields(rows)
        writer.frames(example.time[rows], *state)
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as read:
        assert not set(example.along) & set(read.spring_force(17)[1].tolist())


def test_values_of_a_checkpoint_come_back_as_they_were(tmp_path, example):
    state = {
        "array": np.arange(6.0).reshape(2, 3),
        "numbers": np.arange(4, dtype=np.int32),
        "mask": np.array([True, False]),
        "empty": np.zeros((0, 3)),
        "real": 0.1 + 0.2,
        "whole": 2**60 + 1,
        "flag": True,
        "infinite": float("inf"),
        "text": 'größe "λ"\n' * 3000,
        "nothing": "",
        "a/b": 1,
    }
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=3)
        writer.checkpoint({"former": 1, "array": 2})
        writer.checkpoint(state)
        path = writer.close("interrupted", finished=False)
    with Trajectory.open(path) as read:
        back = read.checkpoint().state
    assert set(back) == set(state)
    for name, value in state.items():
        assert type(back[name]) is type(value), name
        np.testing.assert_array_equal(back[name], value)
        if isinstance(value, np.ndarray):
            assert back[name].dtype == value.dtype


@pytest.mark.parametrize("value", [None, object(), [1, "a"], 1j])
def test_a_state_that_cannot_be_kept_is_refused(tmp_path, example, value):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=3)
        with pytest.raises(ValueError, match='"odd" is not a number, text or array'):
            writer.checkpoint({"odd": value})


def test_the_time_of_both_runs_is_counted(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=3)
        writer.checkpoint({"frame": 3})
        path = writer.close("interrupted", finished=False)
    with Trajectory.open(path) as read:
        checkpoint = replace(read.checkpoint(), wall_time=1000.0)
    with ResultWriter.resume(path, checkpoint) as writer:
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as read:
        assert 1000.0 < read.manifest["wall_time"] < 1060.0


def test_a_checkpoint_of_another_file_is_refused_and_changes_nothing(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=30, checkpoints=(30,))
        path = writer.close("interrupted", finished=False)
    with Trajectory.open(path) as read:
        checkpoint = read.checkpoint()
    with example.open(tmp_path / "b.vtkhdf") as writer:
        example.write(writer, last=10, checkpoints=(5,))
        other = writer.close("interrupted", finished=False)
    before = other.read_bytes()
    with pytest.raises(ResultError, match="must come from another file"):
        ResultWriter.resume(other, checkpoint)
    assert other.read_bytes() == before


def test_a_run_is_gone_on_with_only_where_nothing_has_changed_since(tmp_path, example):
    now = {"scene": "a.tis", "sources": {"skin.tis": "s"}, "overrides": ["pull=2 mm"]}
    now["files"] = {"liver.obj": "digest"}
    path = tmp_path / "a.vtkhdf"
    with pytest.raises(PlaceError, match="no interrupted run"):
        find_checkpoint(path, SCENE, now, example.network)
    with example.open(path, **now) as writer:
        writer.topology(example.alive(0))
        with pytest.raises(PlaceError, match="it has no checkpoint; without --resume"):
            find_checkpoint(path, SCENE, now, example.network)
        example.write(writer, last=6, checkpoints=(5,))
        writer.close("interrupted", finished=False)
    assert find_checkpoint(path, SCENE, now, example.network).state["frame"] == 5
    changed = {"sources": {"skin.tis": "t"}, "overrides": []}
    for text, change, message in (
        ("other", {}, '"a.tis" has changed since; without --resume the run starts again'),
        (SCENE, {"sources": {}}, '"skin.tis" has changed since; without'),
        (SCENE, {"files": {"liver.obj": "other"}}, '"liver.obj" has changed since; without'),
        (SCENE, {"overrides": []}, 'it was run with --set "pull=2 mm"; without'),
        (
            "other",
            changed,
            'since, and "skin.tis" has changed since, and it was run with --set',
        ),
    ):
        with pytest.raises(PlaceError, match=message):
            find_checkpoint(path, text, now | change, example.network)


def test_there_is_nothing_to_go_on_with_without_a_file(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=6, checkpoints=(5,))
        path = writer.close("interrupted", finished=False)
    with Trajectory.open(path) as read:
        checkpoint = read.checkpoint()
    with pytest.raises(ResultError, match="there is no file"):
        ResultWriter.resume(tmp_path / "c.vtkhdf", checkpoint)


def changed(path, change):
    """Change a file with plain HDF5, as nobody should."""
    with h5py.File(path, "r+") as file:
        change(file["tissuec/checkpoint"])


def other_version(checkpoint):
    name = "version"
    checkpoint[name][()] = checkpoint[name][()].replace(b"0.", b"9.")


def other_number(checkpoint):
    checkpoint["state/position"][0, 0] += 1e-4


def other_rows(checkpoint):
    checkpoint["rows"][()] = checkpoint["rows"][()].replace(b": 5", b": 4")


def other_springs(checkpoint):
    checkpoint["alive"][0] = not checkpoint["alive"][0]


@pytest.mark.parametrize("change", [other_version, other_number, other_rows, other_springs])
def test_a_checkpoint_is_gone_on_with_only_as_it_was_written(tmp_path, example, change):
    path, manifest = tmp_path / "a.vtkhdf", {"scene": "a.tis", "overrides": []}
    with example.open(path, **manifest) as writer:
        example.write(writer, last=6, checkpoints=(5,))
        partial = writer.close("interrupted", finished=False)
    assert find_checkpoint(path, SCENE, manifest, example.network).state["frame"] == 5
    changed(partial, change)
    message = "has changed since it was written; without --resume the run starts again"
    with pytest.raises(PlaceError, match=message):
        find_checkpoint(path, SCENE, manifest, example.network)
    assert example.saved(path).exists()


def test_a_checkpoint_is_gone_on_with_only_by_the_version_that_wrote_it(
    tmp_path, example, monkeypatch
):
    path, manifest = tmp_path / "a.vtkhdf", {"scene": "a.tis", "overrides": []}
    with monkeypatch.context() as patch, example.open(path, **manifest) as writer:
        patch.setattr("tissuec.results.checkpoint.__version__", "9.1")
        example.write(writer, last=6, checkpoints=(5,))
        writer.close("interrupted", finished=False)
    with pytest.raises(PlaceError, match=r"has a checkpoint of tissuec 9\.1, but this is 0"):
        find_checkpoint(path, SCENE, manifest, example.network)


def test_a_run_of_another_network_is_not_gone_on_with(tmp_path, example):
    """The same text can be compiles to another network by another library of meshes."""
    path, manifest = tmp_path / "a.vtkhdf", {"scene": "a.tis", "overrides": []}
    with example.open(path, **manifest) as writer:
        example.write(writer, last=6, checkpoints=(5,))
        writer.close("interrupted", finished=False)
    other = example.network.with_arrays({"rest": example.network.springs.rest * (1 + 1e-15)})
    with pytest.raises(PlaceError, match="compiles to another network"):
        find_checkpoint(path, SCENE, manifest, other)
