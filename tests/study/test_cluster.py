"""The same study by a dask scheduler with two workers."""

import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from tests.study.scenes import carried_out, prepared
from tissuec.core.errors import TissueError
from tissuec.core.workers import cluster, portions
from tissuec.core.workers.cluster import Cluster
from tissuec.core.workers.selection import workers_of
from tissuec.studies.study import run_study

MANY = ("vary lift = 2 mm to 9 mm in 20 steps",)  # times two tissues: 40 runs


def dask(*words, folder):
    """Start a program of dask."""
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *words, "--no-dashboard"],
        cwd=folder,
        stderr=subprocess.DEVNULL,
    )


@pytest.fixture
def scheduler(tmp_path):
    """Return the address of a scheduler, the processes of its two workers, and its own."""
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    place = tmp_path / "scheduler.json"
    words = ("--port", "0", "--host", "127.0.0.1", "--scheduler-file", str(place))
    processes = [dask("scheduler", *words, folder=tmp_path)]
    wait_until(lambda: place.exists() and place.stat().st_size)
    time.sleep(0.1)
    address = json.loads(place.read_text("utf-8"))["address"]
    processes += [dask("worker", address, "--nthreads", "1", folder=tmp_path) for _ in range(2)]
    yield address, processes
    for process in reversed(processes):
        process.terminate()
    for process in processes:
        try:
            process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def wait_until(condition, seconds=30.0):
    """Wait until a condition holds; fail after some time."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def found(address, count=2):
    """Return the workers of a scheduler, as soon as there are so many."""
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=30)
        pids = client.run(os.getpid)
    return sorted(pids.values())


class Client:
    """A client of dask whose only worker is a thread, and goes and comes as the test says."""

    def __init__(self):
        self.threads, self.looks = {"tcp://worker": 1}, 0
        self.executor = ThreadPoolExecutor(1)

    def get_executor(self, *, pure):
        return self

    def submit(self, call, *given):
        self.threads = {}
        return self.executor.submit(self._late, call, *given)

    def _late(self, call, *given):
        """Begin as soon as the worker is back."""
        wait_until(lambda: self.threads)
        return call(*given)

    def nthreads(self):
        self.looks += 1
        return self.threads

    def run(self, call, *, on_error):
        return {worker: call() for worker in self.threads}

    def shutdown(self, *, wait):
        self.executor.shutdown(wait=wait)

    def close(self): ...


def test_a_study_whose_workers_are_all_gone_says_so_again_and_again(monkeypatch, tmp_path):
    client, told = Client(), []
    monkeypatch.setattr(cluster, "_client", lambda address: client)
    for module, name in ((cluster, "LOOK"), (cluster, "REMINDER"), (portions, "ROUND")):
        monkeypatch.setattr(module, name, 0.01)

    def tell(text):
        told.append(text)
        if len(told) >= 3:
            client.threads = {"tcp://another": 1}

    workers = Cluster("tcp://somewhere:1", tell)
    found = run_study(prepared("vary lift = [2 mm]"), workers, out=tmp_path / "table.csv")
    assert set(found.table.outcome) == {"done"} and len(found.table) == 2
    assert len(told) >= 3
    assert 'the scheduler at "tcp://somewhere:1" has had no workers for' in told[0]
    assert "dask worker tcp://somewhere:1" in told[0]


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ("0.0.1", r"worker tcp://worker has tissuec 0\.0\.1, and here is .*same version"),
        (ImportError("no tissuec"), r"worker tcp://worker cannot import tissuec: no tissuec"),
    ],
)
def test_workers_with_something_else_are_told_before_any_run(monkeypatch, answer, said):
    client = Client()
    client.run = lambda call, *, on_error: {"tcp://worker": answer}
    monkeypatch.setattr(cluster, "_client", lambda address: client)
    with pytest.raises(TissueError, match=said):
        Cluster("tcp://somewhere:1")
    client.threads = {}
    with pytest.raises(TissueError, match=r"has no workers; start some with: dask worker"):
        Cluster("tcp://somewhere:1")


@pytest.mark.slow
def test_workers_that_come_back_finish_a_study(tmp_path, scheduler, monkeypatch):
    address, processes = scheduler
    found(address)
    carried_out(*MANY, out=tmp_path / "one.csv")
    monkeypatch.setattr(cluster, "LOOK", 0.2)
    monkeypatch.setattr(cluster, "REMINDER", 0.5)
    told = []

    def tell(text):
        told.append(text)
        if len(told) == 2:
            processes.append(dask("worker", address, "--nthreads", "1", folder=tmp_path))

    def end(done, failed, planned):
        if done >= 5 and not told:
            for process in processes[1:3]:
                process.terminate()  # with the worker that it watches
                process.wait(timeout=20)

    workers = Cluster(address, tell)
    run_study(prepared(*MANY), workers, out=tmp_path / "many.csv", progress=end)
    assert len(told) >= 2
    assert (tmp_path / "many.csv").read_bytes() == (tmp_path / "one.csv").read_bytes()


@pytest.mark.slow
def test_a_cluster_writes_what_one_process_writes_also_if_a_worker_dies(tmp_path, scheduler):
    address, _ = scheduler
    pids = found(address)
    carried_out(*MANY, out=tmp_path / "one.csv")
    one = (tmp_path / "one.csv").read_bytes()
    run_study(prepared(*MANY), Cluster(address), out=tmp_path / "many.csv")
    assert (tmp_path / "many.csv").read_bytes() == one
    killed = []

    def kill(done, failed, planned):
        if done >= 5 and not killed:
            killed.append(pids[0])
            os.kill(pids[0], signal.SIGKILL)  # its nanny starts another one

    run_study(prepared(*MANY), Cluster(address), out=tmp_path / "killed.csv", progress=kill)
    assert killed and (tmp_path / "killed.csv").read_bytes() == one


@pytest.mark.slow
def test_a_scheduler_that_ends_is_told_about_and_no_row_is_lost(tmp_path, scheduler):
    address, processes = scheduler
    found(address)

    def kill(done, failed, planned):
        if done == 5:
            processes[0].kill()

    path = tmp_path / "table.csv"
    with pytest.raises(TissueError, match=r"scheduler at .* does not answer any more"):
        run_study(prepared(*MANY), Cluster(address), out=path, progress=kill)
    rest = carried_out(*MANY, out=path)
    assert 5 <= rest.taken_over < 40 and set(rest.table.outcome) == {"done"}


@pytest.mark.slow
def test_a_scheduler_without_workers_or_with_other_versions_is_refused(scheduler, monkeypatch):
    address, processes = scheduler
    found(address)
    monkeypatch.setattr(cluster, "__version__", "9.9.9")
    with pytest.raises(TissueError, match=r"worker tcp.* has tissuec .*, and here is 9\.9\.9"):
        Cluster(address)
    monkeypatch.undo()
    for process in processes[1:]:
        process.terminate()
        process.wait(timeout=20)
    with pytest.raises(TissueError, match="has no workers; start some with: dask worker"):
        Cluster(address)


def test_a_scheduler_that_is_not_there_is_told_about_at_once(monkeypatch):
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    monkeypatch.setattr(cluster, "PATIENCE", 0.3)
    for address in ("tcp://127.0.0.1:9", "nonsense://x"):
        with pytest.raises(TissueError, match=f'no scheduler answers at "{address}"'):
            workers_of(scheduler=address)


def test_without_dask_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(TissueError, match=r'pip install "tissuec\[cluster\]"'):
        workers_of(scheduler="tcp://127.0.0.1:9")
