"""A run is checked by a method of another kind, or says that it is not."""

import pytest

from tests.contact.scenes import ball
from tests.every import every
from tests.validate.scenes import compiled_scene
from tissuec.engine.execution import companion
from tissuec.engine.execution.companion import Companion
from tissuec.engine.execution.finer_run import counterpart, foreseen, kind_of
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method import MethodChange, Statistics

SLIDING = """{ball}
tool floor {{ kind is plane; point = (0, 0, 0) mm; normal = (0, 0, 1) }}
environment {{
  gravity = (0, 0, -9.81) m/s^2; contact is tools only; friction = {friction}
  contact stiffness = 1 kN/m; contact layer = 1 mm
}}
simulate {{ integrator is {method}; duration = 60 ms; {accuracy} }}
output {{ trajectory every 5 ms }}
"""


def sliding(method="esdirk43", friction=0.3, accuracy="tolerance = 1e-4"):
    """Return a scene in which a mass lands and slides."""
    flying = ball(height="1 mm", velocity="(1, 0, 0) m/s", mass="10 g")
    return compiled_scene(
        SLIDING.format(ball=flying, method=method, friction=friction, accuracy=accuracy)
    )


def checked(ran, promised):
    """Run one scene, and return its error as the companion of another scene estimates it."""
    beside = Companion(promised.network, promised.plan, "inline")
    recorder = Recorder(ran.network, ran.plan, MemoryRecording(), tap=beside.take)
    return beside.estimate(run(ran.network, ran.plan, recorder).statistics)


@every("method", [name for name in INTEGRATORS if INTEGRATORS[name].promises])
def test_every_method_is_checked_by_one_of_another_kind(method):
    scene = sliding(method)
    estimate = checked(scene, scene)
    assert estimate.state == "kept" and estimate.differs
    assert kind_of(estimate.method) != kind_of(method)
    assert estimate.as_dict()["method"] == estimate.method
    assert 0.0 < estimate.error < 1e-4


@pytest.mark.parametrize("method", ["esdirk43", "dop853"])
def test_a_method_that_loses_a_force_breaks_its_promise(method):
    estimate = checked(sliding(method, friction=1e-6), sliding(method))
    assert estimate.state == "broken"
    assert 0.01 < estimate.since < 0.06  # where it lands
    assert estimate.reason.endswith(f" or integrator is {estimate.method}")


def test_what_would_cost_too_much_is_not_called_kept(monkeypatch):
    scene = sliding("dop853")
    monkeypatch.setattr(companion, "LEAST", 0.0)
    monkeypatch.setattr(companion, "MOST", 1e-3)
    estimate = checked(scene, scene)
    assert (estimate.state, estimate.method, estimate.differs) == (
        "not checked",
        "dop853",
        False,
    )
    assert estimate.reason == (
        "rkn4, a method of another kind, takes more than 0.001 times the time of the run, and "
        "finer steps of dop853 alone confirm the result"
    )
    assert 0.0 < estimate.error < 1e-4


def test_fixed_steps_are_compared_with_half_of_them():
    scene = sliding("velocity verlet", accuracy="step = 0.1 ms")
    estimate = checked(scene, scene)
    assert (estimate.state, estimate.method) == ("not checked", "velocity verlet")


def ran_by(*changes, cost=1.0):
    """Return statistics of a run that methods stepped from times on [s]."""
    listed = tuple(MethodChange(time, name, "") for time, name in changes)
    return Statistics(
        changes[-1][1], "", "compiled", 1, 0, 1, 0, 0, 0, 1.0, 1.0, listed, cost=cost
    )  # fmt: skip


@every(
    ("changes", "expected"),
    [
        ([(0.0, "dop853")], "rkn4"),
        ([(0.0, "rkn4")], "dop853"),
        ([(0.0, "rkn4"), (0.01, "dop853")], "velocity verlet"),
        ([(0.0, "dop853"), (0.05, "esdirk43")], "rkn4"),
        ([(0.0, "dop853"), (0.01, "esdirk43")], "rkn4"),
        ([(0.0, "rkc2")], "esdirk43"),
        ([(0.0, "trbdf2")], "dop853"),
    ],
    ids=lambda case: str(case),
)
def test_the_counterpart_is_of_no_kind_that_the_run_used(changes, expected):
    scene = sliding()
    assert counterpart(ran_by(*changes), scene.network, scene.plan) == expected


def test_orders_foretell_how_much_longer_another_method_takes():
    # A step of rkn4 has 3 evaluations, one of dop853 has 12.
    ran = ran_by((0.0, "dop853"))
    assert foreseen("rkn4", ran, 1e-9, 4.0) == pytest.approx(4.7, abs=0.1)
    assert foreseen("rkn4", ran, 1e-4, 4.0) == pytest.approx(1.1, abs=0.1)
