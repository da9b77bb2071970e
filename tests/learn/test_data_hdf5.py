"""HDF5 as data: results of tissuec by their logs and frames, H5MD by particles and names."""

from contextlib import suppress
from random import Random

import h5py
import numpy as np
import pytest

from tests.damage import attribute, regroup, remove, reshape, retype
from tests.damage import replace as replaced
from tests.hand_net import make_net
from tests.learn.lessons import NET, data, fit, fit_problem
from tissuec.core.errors import CompileError
from tissuec.core.structs import replace
from tissuec.measurements.reading import read_experiment
from tissuec.results.recording import LogChannel, Recording
from tissuec.results.writer import ResultWriter

TIME = np.array([0.0, 0.01, 0.02, 0.03])
POSITIONS = fit("positions")
LOGS = (
    LogChannel("force of pressed", ("x", "y", "z"), "N", "support force"),
    LogChannel("distance of net to pressed", ("value",), "m", "distance"),
    LogChannel("tension of net", (500, 501), "N", "tensions"),
)


def read(path, *fits, **axis):
    return read_experiment(data(path), fit_problem(*fits, **axis), NET).series


def refused(path, *fits, **axis):
    with pytest.raises(CompileError) as caught:
        read(path, *fits, **axis)
    assert all(finding.span is not None for finding in caught.value.diagnostics)
    return [f"{one.message}; {one.hint}" for one in caught.value.diagnostics]


def places(count, nodes):
    return np.random.default_rng(3).normal(size=(count, nodes, 3))


@pytest.fixture
def result(tmp_path):
    """A result that shows three of four nodes, in frames and logs of the same times."""
    path = tmp_path / "bench.h5"
    shown = np.array([0, 2, 3])
    recording = Recording(shown, np.zeros(0, dtype=np.int64), False, LOGS, False)
    frames = places(4, 4)
    with ResultWriter(path, NET, recording, {}, "language 1\n") as writer:
        writer.topology(np.ones(3, dtype=bool))
        fields = {"force": frames, "tension": np.zeros((4, 3))}
        writer.frames(TIME, frames, frames, fields)
        for log in LOGS:
            writer.log(log.name, TIME, frames[:, 0, : len(log.columns)])
        return writer.close("the run reached its end", finished=True)


def test_a_result_gives_the_places_of_the_nodes_in_its_frames(result):
    (one,) = read(result, POSITIONS)
    np.testing.assert_array_equal(one.nodes, [0, 2, 3])
    np.testing.assert_array_equal(one.times, TIME)
    np.testing.assert_array_equal(one.values, places(4, 4)[:, [0, 2, 3]])
    (few,) = read(result, replace(POSITIONS, every=0.02))
    np.testing.assert_array_equal(few.values, places(4, 4)[[0, 2]][:, [0, 2, 3]])


def test_nodes_of_a_result_are_known_by_body_and_id(result):
    # Another drawing: node 103 stands first, and 101 is missing.
    net = replace(NET, node_ids=np.array([103, 100, 102, 7]))
    (one,) = read_experiment(data(result), fit_problem(POSITIONS), net).series
    np.testing.assert_array_equal(one.nodes, [0, 1, 2])
    np.testing.assert_array_equal(one.values, places(4, 4)[:, [3, 0, 2]])


def test_logs_of_a_result_are_found_by_what_a_fit_is_called(result):
    force = fit("force", of="pressed")
    up = fit("force", of="pressed", along=(0, 0, 1))
    vector = fit("force", "x", "y", "z", of="pressed")
    values = places(4, 4)[:, 0]
    one, two, three = read(result, force, up, vector)
    np.testing.assert_allclose(one.values, np.linalg.norm(values, axis=1))
    np.testing.assert_array_equal(two.values, values[:, 2])
    np.testing.assert_array_equal(three.values, values)


def test_the_number_of_a_log_of_several_is_that_of_its_measure(result):
    (one,) = read(result, fit("tension", of="net"))
    np.testing.assert_array_equal(one.values, places(4, 4)[:, 0, :2].max(axis=1))
    between = fit("distance", of="net")
    pressed = replace(between.subjects[0], name="pressed")
    (one,) = read(result, replace(between, subjects=(between.subjects[0], pressed)))
    np.testing.assert_array_equal(one.values, places(4, 4)[:, 0, 0])


def test_a_position_without_a_log_is_the_mean_of_the_frames(result):
    place, right = fit("position", nodes=[2, 3]), fit("position", nodes=[2, 3], along=(1, 0, 0))
    mean = places(4, 4)[:, 2:].mean(axis=1)
    one, two = read(result, place, right)
    np.testing.assert_allclose(one.values, mean)
    np.testing.assert_allclose(two.values, mean[:, 0])
    assert one.nodes is None


def test_what_a_result_does_not_hold_is_told(result):
    assert refused(result, fit("force", of="presed")) == [
        'bench.h5 has no log "force of presed"; did you mean "force of pressed"?  its logs: '
        "force of pressed, distance of net to pressed, tension of net"
    ]
    hidden = "the frames of bench.h5 do not contain 1 of {} nodes of net; "
    hidden += "they contain 3 nodes of net"
    assert refused(result, fit("positions", nodes=[1])) == [hidden.format(1)]
    assert refused(result, fit("position", nodes=[1, 2])) == [hidden.format(2)]
    (told,) = refused(result, fit("force", of="pressed"), moved=[3])
    assert told.startswith("bench.h5 has times, but this block uses a displacement")


def test_a_damaged_file_is_told(result):
    whole = result.read_bytes()
    result.write_bytes(whole[: len(whole) // 2])
    (told,) = refused(result, POSITIONS)
    assert told.startswith("bench.h5 cannot be read: ") and "truncated" in told


# --- H5MD -------------------------------------------------------------------------------------


@pytest.fixture
def foreign(tmp_path):
    """Return a function that opens a new H5MD file of others for writing."""
    path = tmp_path / "sim.h5"

    class Foreign:
        def __init__(self, group="tissue"):
            self.path, self.group = path, group

        def write(self, value, time, *, ids=None, unit=None, time_unit=None, name=None):
            with h5py.File(path, "a") as file:
                home = name or f"particles/{self.group}/position"
                stored = file.create_dataset(f"{home}/value", data=value)
                times = file.create_dataset(f"{home}/time", data=time)
                for member, text in ((stored, unit), (times, time_unit)):
                    if text is not None:
                        member.attrs["unit"] = text
                if ids is not None:
                    file[f"particles/{self.group}/id"] = ids
            return path

    return Foreign


def test_particles_are_nodes_by_their_ids_and_units(foreign):
    values = places(4, 4)
    path = foreign().write(
        values, TIME * 1e3, ids=[103, 9, 101, 100], unit="nm", time_unit="ms"
    )
    (one,) = read(path, POSITIONS)
    np.testing.assert_array_equal(one.nodes, [0, 1, 3])
    np.testing.assert_allclose(one.values, values[:, [3, 2, 0]] * 1e-9)
    np.testing.assert_allclose(one.times, TIME)


def test_particles_that_change_places_are_followed(foreign):
    values, ids = places(3, 2), np.array([[100, 101], [101, 100], [-1, 100]])
    path = foreign().write(values, TIME[:3])
    with h5py.File(path, "a") as file:
        file["particles/tissue/id/value"] = ids
    (one,) = read(path, POSITIONS)
    np.testing.assert_array_equal(one.nodes, [0, 1])
    np.testing.assert_array_equal(one.values[:2], [values[0], values[1, ::-1]])
    np.testing.assert_array_equal(one.values[2, 0], values[2, 1])
    assert np.isnan(one.values[2, 1]).all()


def test_particles_without_ids_are_those_of_the_set_or_of_its_body(foreign):
    path = foreign().write(places(4, 4), TIME)
    (one,) = read(path, fit("positions", nodes=[1, 3]))
    np.testing.assert_array_equal(one.values, places(4, 4)[:, [1, 3]])
    (told,) = refused(path.with_name("sim.h5"), replace(POSITIONS, every=None), FORCE_TIP)
    assert told.startswith('sim.h5 has no observable "force of tip"')
    other = make_net(np.zeros((9, 3)), [])
    with pytest.raises(CompileError, match=r"the 4 particles of sim\.h5 have no ids"):
        read_experiment(data(path), fit_problem(fit("positions", nodes=range(9))), other)


FORCE_TIP = fit("force", of="tip")


def test_places_in_a_plane_leave_the_third_axis_open(foreign):
    path = foreign().write(places(4, 4)[:, :, :2], TIME)
    (one,) = read(path, POSITIONS)
    assert np.isnan(one.values[:, :, 2]).all() and not np.isnan(one.values[:, :, :2]).any()


def test_times_may_be_a_step_and_a_start(foreign):
    path = foreign().write(places(4, 4), 2.0, time_unit="ms")
    with h5py.File(path, "a") as file:
        file["particles/tissue/position/time"].attrs["offset"] = 1.0
    (one,) = read(path, POSITIONS)
    np.testing.assert_allclose(one.times, [1e-3, 3e-3, 5e-3, 7e-3])


def test_observables_are_found_by_what_a_fit_is_called(foreign):
    value = places(4, 1)[:, 0]
    path = foreign().write(value, TIME, name="observables/tissue/Force_tip", unit="mN")
    with h5py.File(path, "a") as file:
        file.move("observables/tissue/Force_tip", "observables/force_of_tip")
    (one,) = read(path, FORCE_TIP)
    np.testing.assert_allclose(one.values, 1e-3 * np.linalg.norm(value, axis=1))
    foreign().write(value[:, 0], TIME, name="observables/load_cell")
    (one,) = read(path, fit("force", "load_cell", of="sample"))
    np.testing.assert_array_equal(one.values, value[:, 0])


def test_a_position_is_the_mean_of_its_particles(foreign):
    path = foreign().write(places(4, 4), TIME)
    (one,) = read(path, fit("position", nodes=[0, 3], along=(0, 1, 0)))
    np.testing.assert_allclose(one.values, places(4, 4)[:, [0, 3], 1].mean(axis=1))


def test_what_an_h5md_file_does_not_hold_is_told(foreign):
    path = foreign().write(places(4, 4), TIME, unit="N")
    (told,) = refused(path, POSITIONS)
    assert "is in N; a length (m) is needed" in told
    (told,) = refused(path, FORCE_TIP)
    assert told.startswith('sim.h5 has no observable "force of tip"')
    path.unlink()
    path = foreign().write(places(4, 4), TIME, unit="parsec")
    (told,) = refused(path, POSITIONS)
    assert "is in parsec, an unknown unit" in told
    path.unlink()
    path = foreign().write(places(4, 4), [0.0, 1.0, 1.0, 2.0])
    (told,) = refused(path, POSITIONS)
    assert "do not ascend at row 3" in told
    path.unlink()
    path = foreign().write(places(4, 4), TIME, ids=[1, 2, 3, 4])
    (told,) = refused(path, POSITIONS)
    assert told == "no node of net is a particle of sim.h5; "


@pytest.mark.parametrize(
    ("shape", "times", "ids", "message"),
    [
        ((4, 4), TIME, None, "does not contain vectors for each frame"),
        ((4, 4, 5), TIME, None, "does not contain vectors for each frame"),
        ((0, 4, 3), TIME[:0], None, "contains no values"),
        ((4, 4, 3), TIME[:2], None, "do not ascend"),
        ((4, 4, 3), TIME * np.nan, None, "do not ascend"),
        ((4, 4, 3), TIME, [100, 101], "does not have one id per particle"),
        ((4, 4, 3), 0.0, None, "do not ascend"),
    ],
)
def test_an_h5md_file_of_another_shape_is_refused(foreign, shape, times, ids, message):
    path = foreign().write(np.ones(shape), times, ids=ids)
    (told,) = refused(path, POSITIONS)
    assert message in told


def test_several_groups_of_particles_are_told_apart_by_name(foreign):
    foreign("net").write(places(4, 4), TIME)
    path = foreign("water").write(2 * places(4, 4), TIME)
    (one,) = read(path, POSITIONS)
    np.testing.assert_array_equal(one.values, places(4, 4))
    with h5py.File(path, "a") as file:
        file.move("particles/net", "particles/oil")
    (told,) = refused(path, POSITIONS)
    assert told.startswith('sim.h5 has no particles "net" that move; ')
    assert "oil, water" in told


def test_an_hdf5_file_of_something_else_is_refused(tmp_path):
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file["numbers"] = np.arange(3)
    (told,) = refused(tmp_path / "x.h5", POSITIONS)
    assert told.startswith("x.h5 is an HDF5 file, but neither a result of tissuec nor H5MD")


@pytest.mark.parametrize("change", [remove, retype, replaced, regroup, reshape, attribute])
def test_whatever_is_wrong_with_an_h5md_file_is_told(foreign, change):
    path = foreign().write(
        places(4, 4), TIME * 1e3, ids=[103, 9, 101, 100], unit="nm", time_unit="ms"
    )
    foreign().write(places(4, 1), TIME, unit="N", name="observables/force of tip")
    whole = path.read_bytes()
    for seed in range(12):
        path.write_bytes(whole)
        with suppress(ValueError, TypeError), h5py.File(path, "r+") as file:
            change(Random(seed), file)
        with suppress(CompileError):
            read(path, POSITIONS, FORCE_TIP)
