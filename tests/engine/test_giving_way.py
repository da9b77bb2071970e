"""Signals are obeyed wherever they come: in a settle, an equilibrium, a step, a companion."""

import os
import signal
import warnings
from itertools import count
from threading import Event

import numpy as np
import pytest

import tissuec
from tests.every import every
from tissuec.core import signals
from tissuec.core.signals import (
    Halted,
    StopRequest,
    asked_to_stop,
    ending,
    give_way,
    waiting_for,
)
from tissuec.core.source import Source
from tissuec.engine.execution import run as running
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.stepper import PAUSE, Stepper
from tissuec.pipeline import compile_request
from tissuec.results.places import partial_path
from tissuec.scene.request import Request

TISSUE = "Young's modulus = 20 kPa; density = 1000 kg/m^3; retardation time = 5 ms"
BLOCK = """\
language 1
tissue gel { TISSUE }
body b {
  mesh is lattice {
    kind is sodium chloride; cell = 2 mm; box from (0, 0, 0) mm to (8, 2, 2) mm
  }
  tissue is gel
  made of elements
}
set low = nodes of b where x < 0.1 mm
set high = nodes of b where x > 7.9 mm
environment { gravity = (0, 0, -9.81) m/s^2 }
SCRIPT
simulate { duration = 20 ms; INTEGRATOR }
output { trajectory every 1 ms; energy every 1 ms }
"""
SCRIPTS = {
    "settle": ("script { at 0 s: { fix low; settle } }", ""),
    "settle later": ("script { at 0 s: fix low; at 10 ms: settle }", ""),
    "equilibrium": (
        "script { at 0 s: fix low; from 0 s to 20 ms: move high by (0, 0, -1) mm using ramp }",
        "integrator is equilibrium",
    ),
    "relaxation": (
        "script { at 0 s: fix low; from 0 s to 20 ms: move high by (0, 0, -1) mm using ramp }",
        "integrator is relaxation; step = 1 ms",
    ),
    "implicit": ("script { at 0 s: fix low }", "integrator is trbdf2"),
    "explicit": ("script { at 0 s: fix low }", "integrator is rkn4"),
}


def scene_of(name: str) -> str:
    script, integrator = SCRIPTS[name]
    text = BLOCK.replace("TISSUE", TISSUE).replace("SCRIPT", script)
    text = text.replace("; INTEGRATOR", f"; {integrator}")
    if name == "relaxation":
        springs = "spring constant = 40 N/m; viscosity = 5 mN*s/m; mass = 0.2 g"
        text = text.replace("made of elements", "").replace(TISSUE, springs)
    return text


def outcome_of(name, interrupt):
    compiled, _ = compile_request(Request(Source("a.tis", scene_of(name)), ()))
    network, plan = compiled.network, compiled.plan
    return run(network, plan, Recorder(network, plan, MemoryRecording()), interrupt=interrupt)


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    """Let loops give way at each query, however little time has passed."""
    monkeypatch.setattr(signals, "PATIENCE", 0.0)


@every("name", SCRIPTS)
def test_a_run_asks_often_and_ends_at_the_first_yes(name):
    asked = count(1)
    assert outcome_of(name, lambda: next(asked) < 0).kind == "done"
    total = next(asked) - 1
    # A settle and each equilibrium take several rounds, and each of them asks; so does whatever
    # solves with the matrix of an implicit step.
    assert total >= {"equilibrium": 40, "relaxation": 40, "implicit": 300}.get(name, 5)
    for last in (1, total // 2):
        asked = count(1)
        found = outcome_of(name, lambda asked=asked, last=last: next(asked) >= last)
        assert found.kind == "interrupted", last
        # A step that is left leads back to its start, which is saved.
        assert name != "implicit" or "can be resumed" in found.message
        # The answer is asked for again only on the way out: by the other operation of a matrix
        # that was left, the pause and the run.
        assert next(asked) - 1 <= last + 3, last


def test_work_that_takes_little_time_is_brought_to_its_end(monkeypatch):
    monkeypatch.setattr(signals, "PATIENCE", 0.5)
    with asked_to_stop(lambda: True) as stop:
        give_way()
        stop.asked -= 0.6
        with pytest.raises(Halted):
            give_way()


def test_nobody_gives_way_outside_of_a_block_that_waits():
    give_way()
    with asked_to_stop(lambda: True), pytest.raises(Halted):
        give_way()
    with asked_to_stop(lambda: True), asked_to_stop(lambda: False):
        give_way()
    give_way()


def test_work_without_python_is_left_alone_after_a_signal():
    """Such as a factor of many unknowns, which nothing can end."""
    assert waiting_for(lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        waiting_for(lambda: 1 // 0)
    has_begun, may_end = Event(), Event()

    def work():
        has_begun.set()
        may_end.wait()

    try:
        with asked_to_stop(has_begun.is_set), pytest.raises(Halted):
            waiting_for(work)
        assert any(thread.is_alive() for thread in signals._left)
    finally:
        may_end.set()


def test_calls_of_the_loop_become_as_long_as_a_pause_may_wait():
    stepper = Stepper.__new__(Stepper)
    stepper._allowed = 1
    for allowed in (8, 64, 512, 4096):  # evaluations that take no time
        stepper._pace(stepper._allowed, 0.0)
        assert stepper._allowed == allowed
    stepper._pace(4096, 2.0 * PAUSE)
    assert stepper._allowed == 2048
    stepper._pace(1, 100.0 * PAUSE)  # a single one takes longer
    assert stepper._allowed == 1
    stepper._pace(0, 1.0)  # none was made
    assert stepper._allowed == 1


def signalled(name, companion, places, folder, monkeypatch):
    """Send SIGTERM at some queries of a run, given as parts of all of them; resume it.

    The resumed result is that of a run left alone.
    """
    monkeypatch.setattr(running, "CHECKPOINT_EVERY", 0.0)
    query, asked, at = StopRequest.__call__, 0, 0

    def ask(stop):
        nonlocal asked
        asked += 1
        if asked == at:
            os.kill(os.getpid(), signal.SIGTERM)
        return query(stop)

    monkeypatch.setattr(StopRequest, "__call__", ask)

    def result(out):
        nonlocal asked
        asked, resume = 0, False
        if (partial := partial_path(out)).exists():
            with tissuec.load(partial) as begun:
                resume = begun.checkpoint() is not None
        with ending(), warnings.catch_warnings(action="ignore"):
            return tissuec.run(scene_of(name), out=out, resume=resume, companion=companion)

    with result(folder / "alone.vtkhdf") as run_:
        expected = run_.position[:], run_.times
    total = asked
    assert total > 10
    for place in places:
        at, out = 1 + int(place * (total - 1)), folder / f"{place}.vtkhdf"
        with pytest.raises(SystemExit) as ended:
            result(out)
        assert ended.value.code == 128 + signal.SIGTERM
        assert asked <= at + 9, (at, asked)  # nothing goes on after the signal
        at = 0
        with tissuec.load(out) if out.exists() else result(out) as run_:
            assert np.array_equal(run_.position[:], expected[0])
            assert np.array_equal(run_.times, expected[1])


posix = pytest.mark.skipif(os.name != "posix", reason="signals as on POSIX")


@posix
@every("name", ["settle later", "implicit"])
def test_a_signal_within_a_settle_or_a_step_ends_a_run_that_can_be_resumed(
    name, tmp_path, monkeypatch
):
    (tmp_path / name).mkdir()
    signalled(name, "off", (0.6,), tmp_path / name, monkeypatch)


@posix
@pytest.mark.slow
@every(
    ("name", "companion"),
    [
        ("settle", "off"),
        ("settle later", "off"),
        ("implicit", "off"),
        ("equilibrium", "off"),
        ("settle later", "inline"),
    ],
)
def test_a_signal_at_any_query_ends_a_run_that_can_be_resumed(
    name, companion, tmp_path, monkeypatch
):
    folder = tmp_path / f"{name} {companion}"
    folder.mkdir()
    signalled(name, companion, (0.0, 0.1, 0.4, 0.7, 0.95), folder, monkeypatch)
