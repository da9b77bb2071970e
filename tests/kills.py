"""Kill runs of a scene at random moments, resume them, and compare with a run left alone.

    python -m tests.kills SCENE --kills 500 --seed 1

Runs with and without companions are ended by SIGKILL, SIGTERM or SIGINT, at any moment from
first to last; sometimes it is the process of the companion that is ended. Whatever they leave
must open, and the result in the end must be that of an undisturbed run, to the last bit: all of
it but what the clock decides, and what the companion says, which begins where a run is resumed.
Prints what was done as JSON, or exits with 1 and a sentence.
"""

import argparse
import json
import os
import random
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np

import tissuec

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
#: Wall times [s] between checkpoints and between writes, shorter than usual so that kills hit
#: some of each.
CHECKPOINT_EVERY, LONGEST_WAIT = 0.03, 0.01
BY_CLOCK = ("wall_time", "begun", "statistics")
OF_COMPANION = ("promise",)
NOT_COMPARED = ("tissuec/checkpoint", "tissuec/checksums", "tissuec/companion")
MODES = ("off", "inline", "process")  # of companions
SAID = "said.txt"  # what the last command printed, in the folder of the results
DEADLINE = 900.0  # of one run [s]


class Wrong(Exception):
    """A file or an exit code is not what it must be."""


def start(arguments: list[str]) -> int:
    """Fork a process that carries out a command; everything is imported already."""
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    child = os.fork()
    if child:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
        return child
    code: object = 128 + signal.SIGINT  # Ctrl-C before the command has begun
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
        said = os.open(SAID, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(said, 1)
        os.dup2(said, 2)
        sys.argv = ["tissuec", *arguments]
        from tissuec.cli import main

        main()
    except SystemExit as error:
        code = error.code or 0
    finally:  # nothing of the parent's is cleaned up here
        os._exit(code if isinstance(code, int) else 1)


def wait(child: int) -> int:
    """Return the exit code of a process (or minus its signal), which ends in time."""
    deadline = time.monotonic() + DEADLINE
    while time.monotonic() < deadline:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.001)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    raise Wrong(f"a run did not end within {DEADLINE:g} s")


def content(path: Path) -> dict[str, object]:
    """Return every dataset of a result that does not depend on clock or companion."""
    found: dict[str, object] = {}
    with h5py.File(path, "r") as file:

        def visit(name: str, member: object) -> None:
            if isinstance(member, h5py.Dataset) and not name.startswith(NOT_COMPARED):
                found[name] = member[()]

        file.visititems(visit)
    manifest = json.loads(found.pop("tissuec/manifest"))
    statistics = manifest.get("statistics", {})
    found["manifest"] = {
        name: value for name, value in manifest.items() if name not in BY_CLOCK + OF_COMPANION
    }
    found["steps"] = statistics.get("accepted")
    return found


def same(first: Path, second: Path) -> None:
    """Compare two results; Wrong names the first dataset that differs."""
    one, other = content(first), content(second)
    if set(one) != set(other):
        raise Wrong(f"only one result has {sorted(set(one) ^ set(other))}")
    for name, value in one.items():
        try:
            np.testing.assert_equal(other[name], value)
        except AssertionError as error:
            raise Wrong(f"{name} differs: {error}") from error


def check_companion(path: Path) -> None:
    """Raise Wrong unless the error estimate has rows in order, once each."""
    with h5py.File(path, "r") as file:
        times = (
            file["tissuec/companion/time"][()] if "tissuec/companion" in file else np.zeros(0)
        )
    if (np.diff(times) <= 0.0).any():
        raise Wrong("the companion's rows are not in the order of time")


def companion_of(child: int) -> int | None:
    """Return the process that a run has started, if there is one that can be found."""
    try:
        children = Path(f"/proc/{child}/task/{child}/children").read_text().split()
    except OSError:
        return None
    return int(children[0]) if children else None


def has_checkpoint(partial: Path) -> bool:
    """Open what a killed run has left, read it all, and tell whether it can be gone on with."""
    from tissuec.results.layout import check_replaceable
    from tissuec.results.trajectory import Trajectory

    if not partial.exists():
        return False
    check_replaceable(partial)
    if not any(partial.read_bytes()[:8]):
        return False  # killed within the first write
    with Trajectory(partial) as begun:
        for array in (begun.position, begun.velocity, begun.force, begun.tension):
            array[:]
        for log in begun.logs.values():
            if log.time.shape != log.value.shape[:1]:
                raise Wrong(f'log "{log.name}" has rows without times')
        len(begun.events)
        return begun.checkpoint() is not None


def mark_checkpoints(marked: Path) -> Path:
    """Let runs make an empty file with each checkpoint; return its path."""
    from tissuec.results.writer import ResultWriter

    checkpoint = ResultWriter.checkpoint

    def mark(self: ResultWriter, *saved: object) -> None:
        checkpoint(self, *saved)
        marked.touch()

    ResultWriter.checkpoint = mark
    return marked


def torment(scene: Path, folder: Path, kills: int, seed: int) -> dict[str, object]:
    """Kill and resume runs of a scene until so many were killed; Wrong if it shows.

    If no earlier one has, the last killed run leaves a checkpoint; it is resumed, too.
    """
    from tissuec.engine.execution import run as running
    from tissuec.results import writer

    random_ = random.Random(seed)
    whole, broken = folder / "whole.vtkhdf", folder / "broken.vtkhdf"
    partial = folder / "broken.partial.vtkhdf"
    plain = ["run", str(scene), "-o", str(broken), "--companion"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tissuec.run(scene, out=whole).close()  # here, so that children find all imported
    began = time.monotonic()
    code = wait(start([*plain, "inline"]))
    usual = time.monotonic() - began
    if code not in (0, 1):
        raise Wrong(f"the undisturbed run exits with {code}")
    same(whole, broken)
    broken.unlink()
    running.CHECKPOINT_EVERY, writer._LONGEST_WAIT = CHECKPOINT_EVERY, LONGEST_WAIT
    marked = mark_checkpoints(folder / "marked")
    killed: Counter[str] = Counter()
    resumed = finished = bereft = 0
    while sum(killed.values()) < kills or not finished or partial.exists():
        goes_on = has_checkpoint(partial)
        resumed += goes_on
        mode = random_.choice(MODES)
        marked.unlink(missing_ok=True)
        child = start([*plain, mode, *(["--resume"] if goes_on else [])])
        if sum(killed.values()) < kills:
            is_awaited = not resumed and sum(killed.values()) + 1 == kills
            if not is_awaited:
                # Short lives after long ones, so that resumed runs die young as well.
                time.sleep(random_.uniform(0.0, 0.6 * usual))
            number = random_.choice(SIGNALS)
            done, status = os.waitpid(child, os.WNOHANG)
            while is_awaited and not (done or marked.exists()):
                time.sleep(0.001)
                done, status = os.waitpid(child, os.WNOHANG)
            companion = companion_of(child) if random_.random() < 0.3 else None
            if not done and companion is not None:
                with suppress(ProcessLookupError):
                    os.kill(companion, number)
                code = wait(child)
                bereft += 1
                if code not in (0, 1):
                    raise Wrong(f"a run whose companion got {number.name} exits with {code}")
            elif not done:
                os.kill(child, number)
                code = wait(child)
                killed[number.name] += not broken.exists()  # it may have been done
                if code not in (0, 1, -number, 128 + number):
                    raise Wrong(f"a run that got {number.name} exits with {code}")
            else:
                code = os.waitstatus_to_exitcode(status)
        else:
            code = wait(child)
        if broken.exists():
            same(whole, broken)
            check_companion(broken)
            finished += 1
            broken.unlink()
        elif code in (0, 1):
            raise Wrong("a run says that it is done and has left no result")
    return {
        "kills": dict(killed), "companions": bereft, "resumed": resumed, "finished": finished,
        "seconds": usual,
    }  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--kills", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        scene = arguments.scene.resolve()
        os.chdir(folder)
        os.environ["TMPDIR"] = folder  # what a killed run leaves of its companion
        try:
            told = torment(scene, Path(folder), arguments.kills, arguments.seed)
        except Wrong as error:
            print(error, Path(SAID).read_text(), sep="\n")
            return 1
    print(json.dumps(told))
    return 0


if __name__ == "__main__":
    sys.exit(main())
