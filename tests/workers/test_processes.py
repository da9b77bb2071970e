"""Workers of this machine: equal results, and deaths that cost only what was under way."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from contextlib import ExitStack, closing, suppress

import pytest

from tests.workers import deeds
from tissuec.core.errors import TissueError
from tissuec.core.workers import portions, processes
from tissuec.core.workers.processes import Processes, ProcessExecutor
from tissuec.core.workers.selection import workers_of
from tissuec.core.workers.workers import LOST, OwnProcess

pytestmark = pytest.mark.skipif(os.name == "nt", reason="kills by signals")


pytestmark = pytest.mark.usefixtures("interruptible")


def is_alive(number: int) -> bool:
    """Return whether there is a process, and it has not ended."""
    try:
        with open(f"/proc/{number}/stat", encoding="utf-8") as file:
            return file.read().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def wait_until(condition, seconds=20.0):
    """Wait until a condition holds; fail after some time."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_every_item_has_its_result_whoever_computes_it():
    for workers in (OwnProcess(), Processes(2)):
        with workers:
            found = sorted(workers.map(deeds.doubled, 1, range(200)))
            again = sorted(workers.map(deeds.doubled, 2, range(3)))
        assert found == [(n, 1 + 2 * n) for n in range(200)]
        assert again == [(0, 2), (1, 4), (2, 6)]


def test_processes_are_kept_from_one_map_to_the_next():
    with Processes(2) as workers:
        first = {who for _, who in workers.map(deeds.process_id, None, [0.05] * 4)}
        second = {who for _, who in workers.map(deeds.process_id, None, [0.05] * 4)}
    assert len(first) == 2 and first == second and os.getpid() not in first


def test_one_that_kills_its_worker_twice_is_lost_and_nothing_else(tmp_path):
    with Processes(2) as workers:
        found = dict(workers.map(deeds.killing, tmp_path, range(40)))
    assert found.pop(3) is LOST
    assert (tmp_path / "killed once").exists()
    assert found == {n: n for n in range(40) if n != 3}


def test_a_killed_process_costs_nothing_but_time():
    count = Counter()
    with Processes(2) as workers:
        for number, who in workers.map(deeds.process_id, None, [0.02] * 60):
            count[number] += 1
            if number in (5, 20):
                os.kill(who, signal.SIGKILL)
            assert who is not LOST
    assert count == Counter(range(60))


def test_the_server_of_processes_may_die_too():
    from multiprocessing.forkserver import _forkserver

    with Processes(2) as workers:
        pids = [who for _, who in workers.map(deeds.process_id, None, [0.0] * 4)]
        os.kill(_forkserver._forkserver_pid, signal.SIGKILL)
        for pid in set(pids):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        found = sorted(workers.map(deeds.doubled, 0, range(6)))
    assert found == [(n, 2 * n) for n in range(6)]


def test_exceptions_come_through_even_odd_ones():
    with Processes(2) as workers:
        with pytest.raises(KeyError, match="7"):
            list(workers.map(deeds.raising, None, [7]))
        with pytest.raises(RuntimeError, match="Unpicklable: odd"):
            list(workers.map(deeds.raising_oddly, None, [7]))
        assert list(workers.map(deeds.doubled, 0, [1])) == [(0, 2)]


def test_leaving_ends_busy_processes_at_once(tmp_path):
    with Processes(2) as workers, closing(workers.map(deeds.busy, tmp_path, [1, 2])) as found:
        executor = workers._executor
        executor.submit(deeds.process_id, None, 0.0)
        with pytest.raises(KeyboardInterrupt):
            interrupt_soon(lambda: len(list(tmp_path.iterdir())) == 2, found)
    pids = [int(path.name) for path in tmp_path.iterdir()]
    wait_until(lambda: not any(map(is_alive, pids)), 5.0)


def interrupt_soon(ready, found):
    """Wait for a result, and press Ctrl-C when something is ready."""
    import threading

    def press():
        wait_until(ready)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=press).start()
    next(found)


def test_no_process_outlives_a_killed_parent(tmp_path):
    script = (
        "from tests.workers import deeds\n"
        "from tissuec.core.workers.processes import Processes\n"
        f"list(Processes(2).map(deeds.busy, {str(tmp_path)!r}, [1, 2]))\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", script])
    wait_until(lambda: len(list(tmp_path.iterdir())) == 2)
    parent.kill()
    parent.wait()
    pids = [int(path.name) for path in tmp_path.iterdir()]
    wait_until(lambda: not any(map(is_alive, pids)), 5.0)


def test_processes_that_do_not_start_are_told_about(monkeypatch):
    monkeypatch.setattr(processes, "_work", os._exit)
    executor = ProcessExecutor(1)
    with pytest.raises(TissueError, match=r"no worker process starts.*--workers 1"):
        executor.submit(deeds.doubled, 0, 1).result()
    executor.shutdown()


def test_another_version_is_refused():
    with pytest.raises(TissueError, match=r"a worker has tissuec .*, and the study 0\.0\.1"):
        portions.carried_out("0.0.1", b"", [])


def test_portions_grow_until_they_take_their_time():
    pace = portions._Pace()
    assert pace.size(1000, 2) == 1
    pace.add(0.01, 1)
    assert pace.size(1000, 2) == 30 and pace.size(20, 2) == 5 and pace.size(1, 2) == 1


def test_one_worker_is_this_process():
    assert isinstance(workers_of(1), OwnProcess)
    assert workers_of(3).capacity() == 3


def test_sockets_have_short_names_whatever_the_temporary_folder(tmp_path):
    """Those of batch systems are long, and systems allow about 100 bytes."""
    folder = tmp_path / ("x" * 120)
    folder.mkdir()
    code = (
        "from tissuec.core.workers.processes import Processes\n"
        "from tests.workers import deeds\n"
        "with Processes(2) as workers: print(sorted(workers.map(deeds.doubled, 1, range(3))))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "TMPDIR": str(folder)},
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.stdout.strip() == "[(0, 1), (1, 3), (2, 5)]", done.stderr


def test_executors_in_threads_keep_the_main_module(monkeypatch):
    """They hide it from processes that start, one after the other."""
    main = sys.modules["__main__"]
    before = {name: vars(main).get(name) for name in processes._OF_MAIN}
    with ExitStack() as stack:
        several = [stack.enter_context(Processes(1)) for _ in range(3)]
        threads = [
            threading.Thread(target=lambda one=one: list(one.map(deeds.doubled, 1, range(2))))
            for one in several
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert {name: vars(main).get(name) for name in processes._OF_MAIN} == before
    assert processes._SAFE_PATH not in os.environ
