"""What a result file holds, where it stands, and what it refuses."""

import json
from hashlib import sha256
from importlib import metadata

import h5py
import numpy as np
import pytest

from tissuec.core.structs import replace
from tissuec.results import PlaceError, ResultError
from tissuec.results.manifest import PACKAGES
from tissuec.results.recording import ENERGIES, LogChannel
from tissuec.results.store import GrowingDataset
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter

CUT_FRAME = 17


def everything(path):
    """Return all datasets of a file by path, views and second names included."""
    found = {}

    def visit(name, member):
        if isinstance(member, h5py.Dataset):
            found[name] = member

    file = h5py.File(path, "r")
    file.visititems(visit)
    return file, found


def test_what_is_written_is_what_is_read(tmp_path, example):
    path = example.saved(tmp_path / "a.vtkhdf", method="dop853", overrides={"lift": "7 mm"})
    network = example.network
    with Trajectory.open(path) as read:
        assert np.array_equal(read.times, example.time)
        assert np.array_equal(read.position[:], example.position)
        assert np.array_equal(read.velocity[:], example.velocity)
        assert np.array_equal(read.force[:], example.force)
        assert np.array_equal(read.ends, network.springs.ends)
        assert np.array_equal(read.node_ids, network.node_ids)
        for frame in range(len(example.time)):
            tension, rows = read.spring_force(frame)
            alive = np.flatnonzero(example.alive(frame))
            assert np.array_equal(rows, alive)
            assert np.array_equal(tension, example.tension[frame, alive])
        force, tension = read.logs.values()
        assert (force.name, force.columns, force.unit) == (
            "force of forceps A",
            tuple("xyz"),
            "N",
        )
        assert np.array_equal(force.value, example.force[:, 0])
        assert tension.columns == (3, 7)
        assert np.array_equal(tension.time, example.time)
        assert np.array_equal(read.energies.value, example.tension[:, :6])
        assert read.energies.columns == ENERGIES
        cut, rupture = read.events
        assert (cut.kind, cut.springs, cut.time) == ("cut", example.along, example.time[17])
        assert (rupture.kind, rupture.springs, rupture.place) == (
            "rupture",
            (0,),
            "scene.tis:3",
        )
        assert read.finished
        assert read.outcome == "the run reached its end"


def test_what_repeats_itself_in_large_nets_is_compressed_and_read_alike(
    tmp_path, example, monkeypatch
):
    plain = example.saved(tmp_path / "plain.vtkhdf")
    monkeypatch.setattr("tissuec.results.store.LARGE", 4)
    monkeypatch.setattr("tissuec.results.store.LEAST_COMPRESSED", 4)
    path = example.saved(tmp_path / "large.vtkhdf")
    (one, former), (two, written) = everything(plain), everything(path)
    with one, two:
        assert written.keys() == former.keys()
        for name, dataset in written.items():
            if name not in ("tissuec/manifest", "tissuec/checksums"):
                np.testing.assert_array_equal(dataset[()], former[name][()], err_msg=name)
        lists = ("tissuec/network/ends", "VTKHDF/Connectivity", "VTKHDF/Offsets")
        for name in (*lists, "VTKHDF/CellData/spring_id", "tissuec/recording/lines"):
            assert written[name].compression == "gzip", name
        assert written["VTKHDF/Points"].compression is None
    with Trajectory.open(path) as read:
        assert np.array_equal(read.ends, example.network.springs.ends)
        assert np.array_equal(read.position[:], example.position)


def test_the_file_says_where_it_comes_from(tmp_path, example):
    plan = {"kernels": ["springs"], "ratio": np.float64(0.25), "limit": float("inf")}
    path = example.saved(tmp_path / "a.vtkhdf", method="verlet", plan=plan, long="x" * 100_000)
    with Trajectory.open(path) as read:
        assert read.text.startswith("language 1")
        assert read.manifest["digest"] == sha256(read.text.encode()).hexdigest()
        assert read.manifest["plan"] == {"kernels": ["springs"], "ratio": 0.25, "limit": None}
        told = read.manifest["versions"]
        assert {name: told[name] for name in PACKAGES} == {
            name: metadata.version(name) for name in PACKAGES
        }
        assert read.manifest["wall_time"] > 0.0
        assert len(read.manifest["long"]) == 100_000
        for name in ("position", "ends", "mass", "stiffness", "damping", "rest", "strength"):
            assert np.array_equal(read.network.array(name), example.network.array(name)), name
        assert [b.name for b in read.network.bodies] == ["tube", "rod"]
        assert read.network.bodies[1].nodes == example.network.bodies[1].nodes
    with h5py.File(path) as file:
        attributes = file["tissuec/manifest"].attrs
        assert attributes["numpy"] == np.__version__
        assert attributes["outcome"] == "the run reached its end"
        assert json.loads(attributes["plan"])["ratio"] == 0.25


def test_every_dataset_says_its_unit_and_what_it_is(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, checkpoints=(20,))
        file, found = everything(writer.close("done", finished=True))
    with file:
        assert len(found) > 70
        for name, dataset in found.items():
            assert dataset.attrs["description"], name
            # MDAnalysis refuses H5MD values in units other than its own.
            view = name.startswith("particles/") and name.endswith("/value")
            assert "unit" in (dataset.parent if view else dataset).attrs, name
            assert not (view and "unit" in dataset.attrs), name
        units = {
            "VTKHDF/Points": "m",
            "tissuec/network/mass": "kg",
            "tissuec/energies/value": "J",
        }
        for name, unit in units.items():
            assert found[name].attrs["unit"] == unit
        for name, unit in {"position": "m", "velocity": "m/s", "force": "N"}.items():
            assert file[f"particles/all/{name}"].attrs["unit"] == unit


def test_an_earlier_result_stays_until_the_new_one_is_complete(tmp_path, example):
    path = example.saved(tmp_path / "a.vtkhdf", author="the earlier one")
    before = path.read_bytes()
    partial = tmp_path / "a.partial.vtkhdf"
    with example.open(path) as writer:
        example.write(writer)
        writer.flush()
        assert path.read_bytes() == before
        with Trajectory.open(partial) as read:
            assert read.outcome.startswith("unfinished")
            assert np.array_equal(read.position[:], example.position)
        assert writer.close("done", finished=True) == path
    assert not partial.exists()
    with Trajectory.open(path) as read:
        assert len(read.times) == len(example.time)


def test_a_run_that_fails_leaves_a_readable_partial_file_with_the_reason(tmp_path, example):
    path = tmp_path / "a.vtkhdf"
    writer = example.open(path)
    example.write(writer, last=20)
    with pytest.raises(ArithmeticError), writer:
        raise ArithmeticError("it diverged at spring 7")
    assert not path.exists()
    with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
        assert read.outcome == "stopped: it diverged at spring 7"
        assert not read.finished
        assert np.array_equal(read.position[:], example.position[:20])


def test_an_interruption_is_an_outcome(tmp_path, example):
    writer = example.open(tmp_path / "a.vtkhdf")
    example.write(writer, last=5)
    with pytest.raises(KeyboardInterrupt), writer:
        raise KeyboardInterrupt
    with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
        assert read.outcome == "interrupted"
        assert len(read.times) == 5


def test_an_interruption_inside_a_write_gives_up_only_what_was_not_flushed(
    tmp_path, example, monkeypatch
):
    writer = example.open(tmp_path / "a.vtkhdf")
    example.write(writer, last=10)
    writer.flush()
    example.write(writer, first=10, last=12)
    plain, calls = GrowingDataset.write, []

    def interrupted(column):
        calls.append(column)
        if len(calls) == 20:
            raise KeyboardInterrupt
        plain(column)

    monkeypatch.setattr(GrowingDataset, "write", interrupted)
    with pytest.raises(KeyboardInterrupt), writer:
        writer.flush()
    monkeypatch.undo()
    with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
        assert read.outcome == "interrupted"
        assert np.array_equal(read.position[:], example.position[:10])


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("quantity", ["position", "velocity", "force"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_number_that_is_none_is_refused_with_node_and_time(
    tmp_path, example, quantity, value, single
):
    example = example.recorded(single=single)
    getattr(example, quantity)[9, 21, 1] = value
    with example.open(tmp_path / "a.vtkhdf") as writer:
        message = rf'the {quantity} of node 2 of "rod" is {value}.* at 0.36 s'
        with pytest.raises(ValueError, match=message):
            example.write(writer)
        writer.close("stopped", finished=False)
    with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
        assert len(read.times) == 9  # the batch with the bad frame is left out as a whole
        assert np.isfinite(getattr(read, quantity)[:]).all()


def test_a_tension_that_is_none_is_refused_while_its_spring_lives(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.tension[CUT_FRAME:, example.along[0]] = np.nan  # dead by then
        example.write(writer, last=25)
        example.tension[26, 5] = np.nan
        with pytest.raises(ValueError, match=r'spring 6 of "tube" is nan at 1\.04 s'):
            example.write(writer, first=25)


def test_numbers_beyond_single_precision_are_refused(tmp_path, example):
    example.velocity[3, 0, 0] = 1e39
    writer = example.recorded(single=True).open(tmp_path / "a.vtkhdf")
    with writer, pytest.raises(ValueError, match=r"is inf in single precision at 0\.12 s"):
        example.write(writer)


def test_frames_do_not_go_back_in_time(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=5)
        with pytest.raises(ValueError, match="must ascend"):
            example.write(writer, first=3, last=5)


def test_wrong_shapes_are_refused(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        with pytest.raises(ValueError, match="before the first frame"):
            writer.frames([0.0], *(example.position[:1],) * 2, example.fields(slice(1)))
        writer.topology(example.alive(0))
        with pytest.raises(ValueError, match=r"velocity has shape \(1, 23\)"):
            writer.frames(
                [0.0],
                example.position[:1],
                example.velocity[:1, :, 0],
                example.fields(slice(1)),
            )
        with pytest.raises(ValueError, match=r"rows of shape \(2, 3\), not \(2, 2\)"):
            writer.log("force of forceps A", [0, 1], np.zeros((2, 2)))
        with pytest.raises(ValueError, match='no log is called "force"'):
            writer.log("force", [0], np.zeros((1, 3)))
        with pytest.raises(ValueError, match="two rows of 3 numbers"):
            writer.log_jump("force of forceps A", 0.1, np.zeros(3), np.zeros(2))
        with pytest.raises(ValueError, match="alive has shape"):
            writer.topology(np.ones(3))


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("missing/a.vtkhdf", 'the folder ".*missing" does not exist; create it'),
        ("file/a.vtkhdf", 'file" is not a folder'),
        ("folder.vtkhdf", "it is a folder"),
    ],
)
def test_a_place_where_nothing_can_be_written_is_refused_at_once(
    tmp_path, example, place, message
):
    (tmp_path / "file").touch()
    (tmp_path / "folder.vtkhdf").mkdir()
    with pytest.raises(ResultError, match=message):
        example.open(tmp_path / place)


@pytest.mark.parametrize("name", ["a.vtkhdf", "a.partial.vtkhdf"])
@pytest.mark.parametrize("content", [b"language 1\n", None])
def test_a_file_that_is_no_result_is_never_replaced(tmp_path, example, name, content):
    place = tmp_path / name
    if content is None:
        h5py.File(place, "w").close()
    else:
        place.write_bytes(content)
    before = place.read_bytes()
    with pytest.raises(PlaceError, match=f'{name}": it exists and is not a result'):
        example.open(tmp_path / "a.vtkhdf")
    assert [found.name for found in tmp_path.iterdir()] == [name]
    assert place.read_bytes() == before


def test_an_empty_file_can_be_replaced(tmp_path, example):
    (tmp_path / "a.vtkhdf").touch()
    (tmp_path / "a.partial.vtkhdf").touch()  # as a run that was killed at once leaves it
    assert example.saved(tmp_path / "a.vtkhdf").stat().st_size


@pytest.mark.parametrize("kept", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("begins", [True, False])
def test_a_first_write_that_was_torn_can_be_replaced(tmp_path, example, kept, begins):
    """The first page comes last; earlier versions wrote it first."""
    partial = tmp_path / "a.partial.vtkhdf"
    whole = example.saved(tmp_path / "a.vtkhdf").read_bytes()
    torn = whole[: int(kept * len(whole)) + 4096]
    partial.write_bytes(torn if begins else bytes(4096) + torn[4096:])
    (tmp_path / "a.vtkhdf").unlink()
    assert example.saved(tmp_path / "a.vtkhdf").read_bytes()


def test_a_closed_folder_is_refused_at_once(tmp_path, example, monkeypatch):
    monkeypatch.setattr("os.access", lambda *_: False)  # a superuser may write everywhere
    with pytest.raises(ResultError, match="no permission to write"):
        example.open(tmp_path / "a.vtkhdf")


def test_a_closed_writer_takes_nothing_more(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        writer.close("done", finished=True)
        for action in (writer.flush, lambda: writer.close("again", finished=True)):
            with pytest.raises(ResultError, match="is already closed"):
                action()


@pytest.mark.parametrize("names", [("a", "a"), ("",)])
def test_logs_need_names_of_their_own(tmp_path, example, names):
    logs = tuple(LogChannel(name, ("x",), "N", "force") for name in names)
    with pytest.raises(ValueError, match="a unique name"):
        example.recorded(logs=logs).open(tmp_path / "a.vtkhdf")


@pytest.mark.parametrize("name", ["a/b", ".", "..", "%2F", "größe λ", "x" * 300, "time"])
def test_any_log_name_can_be_written(tmp_path, example, name):
    logs = (LogChannel(name, ("x",), "N", "force"), LogChannel("other", (), "", "nothing"))
    example = example.recorded(logs=logs)
    with example.open(tmp_path / "a.vtkhdf") as writer:
        writer.log(name, [0.0, 1.0], [[2.0], [3.0]])
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as read:
        assert list(read.logs) == [name, "other"]
        assert read.logs[name].value.tolist() == [[2.0], [3.0]]


def test_changes_that_no_frame_shows_make_no_part(tmp_path, example):
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=5)
        for spring in range(4):
            alive = example.alive(0)
            alive[: spring + 1] = False
            writer.topology(alive)
        writer.topology(example.alive(0))
        example.write(writer, first=5, last=8)
        path = writer.close("done", finished=True)
    with h5py.File(path) as file:
        assert len(file["VTKHDF/NumberOfPoints"]) == 1


def test_the_same_run_gives_the_same_content(tmp_path, example):
    first, one = everything(example.saved(tmp_path / "a.vtkhdf"))
    second, other = everything(example.saved(tmp_path / "b.vtkhdf"))
    with first, second:
        assert set(one) == set(other)
        for name in set(one) - {"tissuec/manifest", "tissuec/checksums"}:
            np.testing.assert_array_equal(one[name][()], other[name][()], err_msg=name)


def test_repeated_checkpoints_do_not_make_the_file_grow(tmp_path, example):
    partial = tmp_path / "a.partial.vtkhdf"
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=3)
        state = {"position": example.position[0], "step": 1e-3, "note": "x" * 500}
        writer.checkpoint(state)
        before = partial.stat().st_size
        for step in range(50):
            writer.checkpoint({**state, "step": step * 1e-3})
        assert partial.stat().st_size < before + 10_000
        writer.close("done", finished=True)


def test_a_result_that_no_longer_fits_its_name_is_kept(tmp_path, example, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("os.replace", refuse)
    with example.open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer)
        with pytest.raises(ResultError, match="complete under the first name"):
            writer.close("done", finished=True)
    with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
        assert read.finished


def test_one_of_two_bodies_is_numbered_by_itself(tmp_path, example):
    nodes = np.arange(20, 23)
    springs = np.arange(example.network.spring_count - 2, example.network.spring_count)
    path = example.recorded(nodes=nodes, lines=springs).saved(tmp_path / "a.vtkhdf")
    with Trajectory.open(path) as read:
        assert read.ends.tolist() == [[0, 1], [1, 2]]
        assert read.cells(5).lines.tolist() == [[0, 1], [1, 2]]
        assert read.node_ids.tolist() == [1, 2, 3]
        assert np.array_equal(read.position[:], example.position[:, 20:])
        tension, rows = read.spring_force(30)
        assert rows.tolist() == [0, 1]
        assert np.array_equal(tension, example.tension[30, -2:])
        assert read.network.node_count == 23


def reduced(example, nodes):
    """The first nodes alone, without springs or skin."""
    network = example.network
    arrays = {
        name: getattr(network, name)[:nodes]
        for name in ("position", "velocity", "mass", "node_ids")
    }
    springs = network.springs.some(slice(0, 0))
    body = replace(network.bodies[0], nodes=slice(0, nodes), springs=slice(0, 0))
    return replace(network, **arrays, springs=springs, skin=network.skin[:0], bodies=(body,))


@pytest.mark.parametrize("nodes", [1, 5])
@pytest.mark.parametrize("frames", [0, 1, 3])
def test_free_nodes_without_any_spring_are_written(tmp_path, example, nodes, frames):
    network = reduced(example, nodes)
    recording = replace(
        example.recording, nodes=np.arange(nodes), lines=np.arange(0), logs=(), energies=False
    )
    with ResultWriter(tmp_path / "a.vtkhdf", network, recording, {}, "") as writer:
        writer.topology(np.ones(0, dtype=bool))
        state = [data[:frames, :nodes] for data in (example.position, example.velocity)]
        fields = {"force": state[1], "tension": np.zeros((frames, 0))}
        writer.frames(example.time[:frames], *state, fields)
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as read:
        assert read.position.shape == (frames, nodes, 3)
        assert np.array_equal(read.position[:], example.position[:frames, :nodes])
        if frames:
            assert read.cells(0).vertices.ravel().tolist() == list(range(nodes))
            assert read.spring_force(0)[0].shape == (0,)


def test_a_run_without_a_trajectory_keeps_its_logs(tmp_path, example):
    path = example.recorded(nodes=np.arange(0), lines=np.arange(0)).saved(tmp_path / "a.vtkhdf")
    with Trajectory.open(path) as read:
        assert read.times.shape == (0,)
        assert read.position[:].shape == (0, 0, 3)
        assert len(read.logs["force of forceps A"].time) == len(example.time)
