"""A run is checked by a method of another kind, or says that it is not."""

import pytest

from tests.contact.scenes import ball
from tests.every import every
from tests.validate.scenes import compiled_scene
from tissuec.engine.execution import companion
from tissuec.engine.execution.companion import Companion
from tissuec.engine.execution.finer_run import (
    LEAST,
    MOST,
    Allowance,
    Progressed,
    counterpart,
    foreseen,
    kind_of,
    own_steps,
)
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method import MethodChange, Statistics
from tissuec.engine.stepper import PAUSE

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
    recorder = Recorder(ran.network, ran.plan, MemoryRecording(), tap=beside.tap)
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


RUBBED = """language 1
tissue gel {
  Young's modulus = 20 kPa; Poisson's ratio = 0.45; density = 1000 kg/m^3
  retardation time = 2 ms
}
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }; tissue is gel
}
set low = nodes of block where z < 0.1 mm
tool ball { kind is probe; radius = 6 mm; centre = (5, 5, 16.1) mm }
environment { gravity = (0, 0, -9.81) m/s^2; contact is tools only; friction = 0.3 }
script {
  at 0 s: fix low
  from 0 s to 20 ms: move ball by (0, 0, -1) mm using smooth profile
}
simulate { duration = 30 ms; tolerance = 1e-6; integrator is dop853 }
output { trajectory every 2 ms; force(ball) every 2 ms }
"""


def test_companions_end_where_they_would_cost_more_than_four_times_the_run(monkeypatch):
    """By counts of operations: with friction, ``rkn4`` would cost forty times as much."""
    scene, spent = compiled_scene(RUBBED), []
    watch = Allowance.watch

    def watched(self, time, ran):
        watch(self, time, ran)
        spent.append((ran.method, ran.cost))

    beside = Companion(scene.network, scene.plan, "inline")
    recorder = Recorder(scene.network, scene.plan, MemoryRecording(), tap=beside.tap)
    ran = run(scene.network, scene.plan, recorder, watch=beside.tick).statistics
    monkeypatch.setattr(Allowance, "watch", watched)
    estimate = beside.estimate(ran)
    assert estimate.state == "not checked" and estimate.method == "dop853"
    other = max(cost for method, cost in spent if method == "rkn4")
    own = max(cost for method, cost in spent if method == "dop853")
    pause = 2.0 * PAUSE  # after which a companion is looked at
    assert other <= max(MOST * ran.cost, LEAST) + pause
    assert other + own <= max(MOST * ran.cost, LEAST) + own_steps(ran, 4.0) + 2.0 * pause


def test_what_a_companion_will_cost_is_told_from_how_the_run_spent_its_own():
    progress = Progressed()
    for part in range(1, 11):  # nearly all of it in the first tenth of the time
        progress.note(0.01 * part, 0.1 * part)
    progress.note(1.0, 1.1)
    allowance = Allowance(lambda: 4.0, progress)
    fast, slow = (ran_by((0.0, "rkn4"), cost=cost) for cost in (2.0, 3.0))
    allowance.watch(0.05, fast)  # 0.5 of 1.1: 4.4 in all
    assert not allowance.is_spent
    allowance.watch(0.05, slow)  # 6.6 in all
    assert allowance.is_spent
    assert Progressed().part(0.5) == 1.0  # unknown
