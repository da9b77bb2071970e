"""The twin tells the error of a run, and whether anybody can know better."""

import os

import h5py
import numpy as np
import pytest

from tests.hand_net import chain
from tests.hand_plan import make_plan
from tests.running.test_run import OMEGA, oscillator
from tissuec.core.source import Source
from tissuec.pipeline import Request, compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.running.memory import MemoryRecording
from tissuec.running.recording import Recorder
from tissuec.running.run import run
from tissuec.running.twin import accompanied

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system that forks")


def accompany(network, plan):
    """Run a plan with a twin; return its frames and how alike both were."""
    with accompanied(network, plan, wanted=True) as twin:
        recording = MemoryRecording()
        run(network, plan, Recorder(network, plan, recording, tap=twin.take))
        return recording.frame_arrays(), twin.compare()


@pytest.mark.parametrize(
    ("method", "tolerance", "step"),
    [("velocity verlet", 1e-3, None), ("velocity verlet", None, 0.01), ("trbdf2", 1e-3, None)],
)
def test_the_difference_is_about_the_error_against_the_closed_form(method, tolerance, step):
    network = oscillator()
    plan = make_plan(network, 2.0, every=0.1, integrator=method, tolerance=tolerance, step=step)
    (time, position, *_), likeness = accompany(network, plan)
    exact = 0.8 + 0.2 * np.cos(OMEGA * time)
    # The lighter of the two masses, 1 and 3 kg, has three quarters of the error of the length.
    error = 0.75 * np.abs(position[:, 1, 0] - position[:, 0, 0] - exact).max()
    assert likeness.verdict == "alike"
    # Orders of 2: a twin of a quarter of the error is three quarters of the error away.
    assert 0.5 * error < likeness.apart[-1] < 1.2 * error
    assert np.isfinite(likeness.allowed) == (step is None)


def test_a_chaotic_motion_is_recognised_and_from_when_on():
    velocity = np.random.default_rng(0).normal(size=(5, 3)) * 5.0
    network = chain(5, mass=0.1, stiffness=300.0, rest=1.0, velocity=velocity)
    plan = make_plan(
        network, 30.0, gravity=(0.0, -9.81, 0.0), every=0.1, tolerance=1e-6, ledger=False
    )
    _, likeness = accompany(network, plan)
    assert likeness.verdict == "apart"
    assert 0.5 < likeness.parting < 30.0
    assert likeness.relative[-1] > 1e3 * likeness.allowed


def test_a_twin_ends_with_the_run_that_it_belongs_to():
    network = oscillator()
    plan = make_plan(network, 1e5, every=1e4)
    with accompanied(network, plan, wanted=True) as twin:
        process = twin._process
        os.kill(process, 0)  # it is there
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_where_nothing_is_looked_at_there_is_no_twin():
    network = oscillator()
    with accompanied(network, make_plan(network, 1.0), wanted=True) as twin:
        assert twin is None


def test_a_result_holds_both_errors(tmp_path):
    text = """language 1
    tissue cord { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 10 g }
    body pair { mesh is explicit; tissue is cord }
    table nodes of pair in mm with columns "id x" { 1 0; 2 11 }
    table springs of pair in mm with columns "a b rest length" { 1 2 10 }
    environment { gravity = (0, 0, 0) m/s^2 }
    simulate { duration = 0.5 s; tolerance = 1e-5 }
    output { trajectory every 10 ms }
    """
    request = Request(Source("pair.tis", text))
    compiled, _ = compile_request(request)
    result = simulate(compiled, tmp_path / "pair.vtkhdf", request=request, twin=True)
    with Trajectory.open(result.path) as trajectory:
        assert trajectory.manifest["twin"]["verdict"] == "alike"
    with h5py.File(result.path) as file:
        steps = file["/tissuec/errors/value"][:, 0]
        assert len(steps) == 51 and (np.diff(steps) >= 0.0).all() and steps[-1] > 0.0
        assert file["/tissuec/twin/value"][-1, 0] == result.likeness.apart[-1]
