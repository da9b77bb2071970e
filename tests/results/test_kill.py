"""A process that dies without a warning, or runs out of space, leaves a file that opens."""

import os
import random
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter

# A writer whose frame number i is i everywhere; it says how many frames and rows are flushed.
CHILD = """if True:
    import pathlib, sys
    import numpy as np
    from tissuec.laws import LINEAR
    from tissuec.model.network import Network
    from tissuec.model.springs import Springs
    from tissuec.results import ResultError
    from tissuec.results.recording import LogChannel, Recording
    from tissuec.results.writer import ResultWriter

    path, limit = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    count = 40
    ends = np.stack([np.arange(count - 1), np.arange(1, count)], axis=-1).astype(np.int32)
    ones, zeros, skin = np.ones(count - 1), np.zeros((count, 3)), np.zeros((0, 3), np.int32)
    springs = Springs(ends, *[ones] * 5, np.zeros(count - 1, np.int32), (LINEAR,),
                      np.arange(count - 1))
    network = Network(zeros, zeros, np.ones(count), springs, skin, np.arange(count), (), {})
    log = (LogChannel("log", ("x",), "N", "a log"),)
    if limit:
        import resource
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    recording = Recording(np.arange(count), np.arange(count - 1), False, log, True)
    alive = np.ones(count - 1, dtype=bool)
    try:
        with ResultWriter(path, network, recording, {}, "scene") as writer:
            frame = 0
            while True:
                alive[frame % 39] = not alive[frame % 39]
                writer.topology(alive)
                for _ in range(7):
                    rows = np.full((1, count, 3), float(frame))
                    fields = {"force": rows, "tension": np.full((1, count - 1), frame)}
                    writer.frames([frame], rows, rows, fields)
                    writer.log("log", [frame], [[frame]])
                    writer.event(frame, "cut", range(frame % 3), "because", "here")
                    frame += 1
                writer.checkpoint({"frame": frame, "state": rows[0]})
                print(frame, flush=True)
    except ResultError as error:
        print(error, flush=True)
        print(writer.close("again", True) if not writer._closed else "closed", flush=True)
"""


def start(path, limit=0):
    command = [sys.executable, "-c", CHILD, str(path), str(limit)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def assert_whole(path, at_least):
    """Return how many frames there are, after each was found right."""
    with Trajectory.open(path) as read:
        frames = len(read.times)
        assert frames >= at_least
        expected = np.arange(frames, dtype=float)
        assert np.array_equal(read.times, expected)
        for data in (read.position, read.velocity, read.force):
            assert (data[:] == expected[:, None, None]).all()
        for frame in (0, frames // 2, frames - 1):
            tension, rows = read.spring_force(frame)
            assert (tension == frame).all()
            assert len(rows) == len(read.cells(frame).lines)
        assert np.array_equal(read.logs["log"].value[:, 0], read.logs["log"].time)
        assert [event.time for event in read.events] == read.logs["log"].time.tolist()
        checkpoint = read.checkpoint()
        assert (checkpoint.state["state"] == checkpoint.state["frame"] - 1).all()
        assert checkpoint.rows["/VTKHDF/Steps/Values"] == checkpoint.state["frame"]
    return frames


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no such signal")
@pytest.mark.parametrize(
    "seed", [0, 1, 2, *(pytest.param(k, marks=pytest.mark.slow) for k in range(3, 8))]
)
def test_a_killed_writer_leaves_every_flushed_frame(tmp_path, seed):
    path = tmp_path / "a.vtkhdf"
    child = start(path)
    flushed = [int(child.stdout.readline()) for _ in range(1 + seed)]
    time.sleep(random.Random(seed).uniform(0.0, 0.03))  # anywhere in its work
    os.kill(child.pid, signal.SIGKILL)
    flushed += [int(line) for line in child.communicate()[0].split()]
    frames = assert_whole(tmp_path / "a.partial.vtkhdf", at_least=flushed[-1])
    with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
        checkpoint = read.checkpoint()
        assert "killed" in read.outcome
    with ResultWriter.resume(path, checkpoint) as writer:
        path = writer.close("gone on with", finished=True)
    assert assert_whole(path, at_least=flushed[-1]) == checkpoint.state["frame"] <= frames


@pytest.mark.parametrize("limit", [300_000, 400_000, 517_003])
def test_a_full_disk_is_said_and_leaves_every_flushed_frame(tmp_path, limit):
    pytest.importorskip("resource")
    child = start(tmp_path / "a.vtkhdf", limit)
    *flushed, message, _ = child.communicate()[0].strip().split("\n")
    assert "a.partial.vtkhdf" in message
    assert re.search(r"[\d.]+ kB are needed, [\d.]+ [kMG]B are free", message)
    if flushed:
        assert_whole(tmp_path / "a.partial.vtkhdf", at_least=int(flushed[-1]))
    with Trajectory.open(tmp_path / "a.partial.vtkhdf") as read:
        # What no longer fitted is given up, which leaves room for the reason.
        assert read.outcome == f"stopped: {message}"
    assert not (tmp_path / "a.vtkhdf").exists()
