"""What tests share: where the repository is, and a browser."""

import atexit
import gc
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

# Where none may be written beside the code, processes share a folder of bytecode. Without it,
# each one that tests start compiles all that it imports, which takes longer than what it does.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    sys.pycache_prefix = os.environ["PYTHONPYCACHEPREFIX"] = tempfile.mkdtemp()
    sys.dont_write_bytecode = False
    atexit.register(shutil.rmtree, sys.pycache_prefix, ignore_errors=True)

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy; workers share processors

import pytest
from hypothesis import HealthCheck, settings

from tests.browser import browser as browser
from tests.browser import page as page
from tests.browser import tab as tab
from tissuec.core.resources import library
from tissuec.core.signals import SIGNALS
from tissuec.engine import spring_runs, threads
from tissuec.kernels.thread_loops import PIECE
from tissuec.pipeline import Result, compile_request, simulate
from tissuec.scene.request import Request

# How long an example takes depends on what else the machine does.
settings.register_profile("tests", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("tests")

# Files need not outlive a loss of power here, and waiting for the disk takes a long time.
os.fsync = lambda _: None

SLOW = Path(__file__).with_name("slow.txt")


def long_ones() -> set[str]:
    """Return the tests that ``slow.txt`` names."""
    lines = SLOW.read_text(encoding="utf-8").splitlines()
    return {line.partition("  |")[0] for line in lines if not line.startswith("#")}


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark long tests before those of the default run are chosen."""
    named = long_ones()
    for item in items:
        if item.nodeid in named:
            item.add_marker(pytest.mark.slow)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Look for garbage in what tests make, not in what pytest keeps: a fifth of the time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(50_000, 20, 20)
        gc.enable()


@pytest.fixture
def threads_in_small_nets(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let threads share the loops of nets from 2048 nodes on."""
    monkeypatch.setattr(threads, "LEAST_SPRINGS", 1)
    monkeypatch.setattr(threads, "NODES", PIECE)
    monkeypatch.setattr(threads, "BLOCK_NODES", PIECE)
    monkeypatch.setattr(spring_runs, "LEAST_OF_GROUP", 1)


@pytest.fixture(scope="session")
def repository() -> Path:
    return Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def shipped(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Result]:
    """Return what gives the result of a shipped scene, which is run once; nobody changes it."""

    @cache
    def run(stem: str) -> Result:
        request = Request.file(library() / "scenes" / f"{stem}.tis")
        compiled, _ = compile_request(request)
        path = tmp_path_factory.mktemp(stem) / f"{stem}.vtkhdf"
        return simulate(compiled, path, request=request, companion="off")

    return run


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Have signals mean what they do at a prompt; shells make background jobs ignore some."""
    meaning = dict.fromkeys(SIGNALS, signal.SIG_DFL)
    meaning[signal.SIGINT] = signal.default_int_handler
    before = {number: signal.signal(number, meant) for number, meant in meaning.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
