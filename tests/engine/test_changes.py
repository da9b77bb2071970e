"""A run goes over to another integrator where its own is not made for what is to come."""

import json

import numpy as np
import pytest

from tests.engine.members import those
from tests.engine.running import Bench, chain, pair
from tests.engine.test_closed_forms import relaxation
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.engine.method_trial import MethodTrial, of_other_order
from tissuec.engine.run_arrays import new_progress
from tissuec.forces.acting.foundation import Bed
from tissuec.model.blocks import FieldBlock

NOWHERE = Span(Source("", ""), 0, 0)


@pytest.mark.parametrize("method", those(conservative=True))
@pytest.mark.parametrize("cause", ["viscosity", "drag"])
def test_conservative_member_gives_way_where_energy_is_lost(method, cause):
    bench = Bench(pair(), 1.0, method=method, tolerance=1e-9)
    bench.advance(0.4)
    assert bench.engine.statistics.method == method
    assert len(bench.engine.statistics.changes) == 1  # the first choice
    if cause == "viscosity":
        bench.state.springs = bench.state.springs.changed("damping", 0, 2.0)
    else:
        bench.state.drag = 2.0
    bench.engine.restart(bench.state)
    ran = bench.run()
    _, change = ran.engine.statistics.changes
    assert (change.time, change.method) == (0.4, "dop853")
    assert method in change.reason
    assert ran.engine.statistics.method == "dop853"
    other = Bench(pair(), 1.0, tolerance=1e-9)
    other.advance(0.4)
    other.state.springs = bench.state.springs
    other.state.drag = bench.state.drag
    other.engine.restart(other.state)
    # Both keep 1e-9 of the motion.
    expected = other.run()
    assert np.abs(expected.position - ran.position).max() < 1e-9
    assert ran.work == pytest.approx(expected.work, abs=1e-8)


@pytest.fixture
def explicit_first(monkeypatch):
    """Let runs begin explicitly, however damped the net is."""
    monkeypatch.setattr("tissuec.engine.method_choice.CREEPING", np.inf)


def stiff(duration=20.0, **asked):
    """Return a chain braked so strongly that stability limits explicit steps."""
    bench = Bench(
        chain(24, stiffness=100.0, mass=1e-3, damping=20.0),
        duration,
        method="automatic",
        tolerance=1e-4,
        fixed=[0],
        **asked,
    )
    bench.push([25], [0.2, 0.0, 0.0])
    return bench


def test_automatic_goes_over_to_implicit_steps_where_explicit_ones_are_at_their_limit(
    explicit_first,
):
    ran = stiff().run()
    statistics = ran.engine.statistics
    assert statistics.changes[1].method in those(implicit=True)
    assert "stability" in statistics.changes[1].reason
    assert statistics.method in those(implicit=True)
    far = np.abs(ran.position - stiff_reference()).max()
    assert far < 1e-4 * ran.largest_displacement[-1]


def stiff_reference(*forces, duration=20.0):
    bench = Bench(
        chain(24, stiffness=100.0, mass=1e-3, damping=20.0),
        duration,
        method="esdirk43",
        tolerance=1e-8,
        fixed=[0],
    )
    bench.state.put(*forces)
    bench.push([25], [0.2, 0.0, 0.0])
    return bench.run().position


def bed():
    """Return an elastic foundation under all nodes of the chain that are not fixed."""
    home = chain(24, stiffness=100.0, mass=1e-3, damping=20.0).position
    nodes = np.arange(1, len(home))
    none, stiffness = np.zeros(0, dtype=int), np.full(len(nodes), 0.5)
    field = Bed(none, none, nodes[:, None], home[nodes], stiffness, 0.0 * stiffness)
    return FieldBlock("the force bed", "foundation", field, NOWHERE)


@pytest.mark.parametrize("creeping", [np.inf, 4.0])
def test_automatic_steps_implicitly_where_fields_act(monkeypatch, creeping):
    monkeypatch.setattr("tissuec.engine.method_choice.CREEPING", creeping)
    monkeypatch.setattr("tissuec.engine.method_control.PATIENT", 0.3)
    bench = stiff(duration=80.0)
    bench.state.put(bed())
    ran = bench.run()
    assert ran.engine.statistics.method in those(implicit=True)
    far = np.abs(ran.position - stiff_reference(bed(), duration=80.0)).max()
    assert far < 1e-4 * ran.largest_displacement[-1]


def test_automatic_tries_implicit_steps_where_fields_act_in_long_runs_only(explicit_first):
    bench = stiff(duration=4.0)
    bench.state.put(bed())
    assert [change.method for change in bench.run().engine.statistics.changes] == ["dop853"]


@pytest.mark.parametrize(
    ("name", "first", "step", "other"),
    [
        ("rkn4", "rkn4", 0.9, "dop853"),  # 0.3 radians per evaluation, against 0.35 of order 8
        ("rkn4", "rkn4", 1.0, None),
        ("dop853", "rkn4", 2.2, "rkn4"),
        ("dop853", "rkn4", 2.0, None),
        ("velocity verlet", "velocity verlet", 0.3, "dop853"),
        ("velocity verlet", "velocity verlet", 0.4, None),
        # Those that began for other reasons go on.
        ("dop853", "dop853", 2.2, None),
        ("srkn11", "srkn11", 0.1, None),
        ("esdirk43", "rkn4", 0.1, None),
        ("rkc2", "rkn4", 0.1, None),
    ],
)
def test_order_8_is_tried_where_its_steps_may_be_longer(name, first, step, other):
    rates = {"omega": 1.0, "zeta": 0.0}
    assert of_other_order(name, first, step, lambda: rates) == other


@pytest.fixture
def order_4_first(monkeypatch):
    """Let runs begin with order 4, and try others at any cost."""
    monkeypatch.setattr("tissuec.engine.method_choice.LARGE", 0)
    monkeypatch.setattr("tissuec.engine.method_trial.WORTHWHILE", 0.0)
    monkeypatch.setattr("tissuec.engine.method_trial.TRIALS", 0.0)


def methods(ran):
    return [change.method for change in ran.engine.statistics.changes]


def test_automatic_goes_over_to_order_8_where_accuracy_limits_the_steps(order_4_first):
    ran = Bench(pair(damping=0.1), 20.0, method="automatic", tolerance=1e-4).run()
    assert methods(ran)[:2] == ["rkn4", "dop853"]
    assert "accuracy" in ran.engine.statistics.changes[1].reason
    exact = 0.1 * (1.0 - relaxation(0.1 / np.sqrt(200.0), np.sqrt(200.0), ran.time))
    assert np.abs(ran.position[:, 0, 0] - exact).max() < 1e-4 * 0.1


def creeping(method, tolerance):
    """Return a chain whose fast motions die away, while the slow ones go on for long."""
    net = chain(24, stiffness=100.0, mass=0.01, damping=0.3)
    bench = Bench(net, 30.0, method=method, tolerance=tolerance, fixed=[0])
    bench.push([25], [0.2, 0.0, 0.0])
    return bench


def test_automatic_goes_back_where_stability_limits_them_again(order_4_first):
    ran = creeping("automatic", 1e-3).run()
    assert methods(ran)[:3] == ["rkn4", "dop853", "rkn4"]
    exact = creeping("dop853", 1e-9).run()
    off = np.abs(ran.position - exact.position).max()
    assert off < 1e-3 * ran.largest_displacement[-1]


def test_a_trial_that_costs_more_than_predicted_and_falls_behind_is_ended():
    """Forty evaluations instead of 180, as each costs ten times what was predicted."""
    trial, start = MethodTrial(), new_progress(0.0)
    trial.begin(start, effort_of(0), "dop853", 0.0)

    def at(time, evaluations, cost, name):
        return trial.decide(
            replace(start, time=time), effort_of(evaluations), cost, name, 100.0,
            lambda pace: ("esdirk43", 0.02),
        )  # fmt: skip

    assert at(0.1, 360, 0.1, "dop853") is None  # steps have grown
    assert at(0.2, 720, 0.2, "dop853").name == "esdirk43"
    assert at(0.2, 735, 0.205, "esdirk43") is None  # within what was predicted
    found = at(0.2, 760, 0.22, "esdirk43")
    assert found.name == "dop853"
    assert "times as fast as esdirk43" in found.reason
    assert at(0.3, 761, 0.23, "dop853") is None


@pytest.mark.parametrize(
    ("name", "other", "reason"),
    [
        ("rkn4", "dop853", "accuracy limits the steps of rkn4"),
        ("dop853", "rkn4", "stability, not accuracy, limits the steps of dop853"),
        ("dop853", "esdirk43", "stability, not accuracy, limits the steps of dop853"),
        ("esdirk43", "dop853", "explicit steps at the stability limit may advance faster"),
    ],
)
def test_a_trial_says_why_it_is_made(name, other, reason):
    trial, start = MethodTrial(), new_progress(0.0)
    trial.begin(start, effort_of(0), name, 0.0)
    found = None
    for time in (1.0, 2.0):
        found = trial.decide(
            replace(start, time=time), effort_of(int(1000 * time)), time, name, 1e4,
            lambda pace: (other, 0.02),
        )  # fmt: skip
    assert found is not None
    assert found.name == other
    assert found.reason.startswith(reason)


def test_a_trial_that_costs_more_than_predicted_but_leads_goes_on():
    trial, start = MethodTrial(), new_progress(0.0)
    trial.begin(start, effort_of(0), "dop853", 0.0)
    for time, evaluations, cost, name, expected in (
        (0.1, 360, 0.1, "dop853", None),
        (0.2, 720, 0.2, "dop853", "esdirk43"),
        (2.0, 760, 0.5, "esdirk43", None),
        (5.0, 920, 1.0, "esdirk43", None),
        (9.0, 1100, 2.0, "esdirk43", None),
    ):
        found = trial.decide(
            replace(start, time=time), effort_of(evaluations), cost, name, 100.0,
            lambda pace: ("esdirk43", 0.02),
        )  # fmt: skip
        assert (found and found.name) == expected


def effort_of(evaluations):
    return np.array([evaluations, 0, 0, 0, 0])


def test_contests_are_decided_by_counts_so_that_runs_repeat():
    one, two = stiff().run(), stiff().run()
    assert one.position.tobytes() == two.position.tobytes()
    assert one.engine.statistics == two.engine.statistics


def test_run_resumed_in_mid_contest_gives_the_same_bytes(explicit_first):
    whole = stiff(times=np.linspace(0.0, 20.0, 401))
    kept = whole.keep_checkpoints(8)
    complete = whole.run()
    # The first method is entered as a change as well.
    changed = [len(json.loads(entry[-1]["changes"])) > 1 for entry in kept]
    before = [entry for entry, is_after in zip(kept, changed, strict=True) if not is_after]
    after = [entry for entry, is_after in zip(kept, changed, strict=True) if is_after]
    assert after
    for count, time, position, velocity, state in [*before[:1], *after[:2]]:
        later = stiff(times=np.linspace(0.0, 20.0, 401))
        later.restore(time, position, velocity, state)
        rest = later.run()
        recorded = sum(len(batch.time) for batch in whole.batches[:count])
        assert rest.position.tobytes() == complete.position[recorded:].tobytes()
        costs = [one.engine.statistics.cost for one in (rest, complete)]
        # The first part of a sum that is resumed has been rounded, by half a last digit.
        assert costs[0] == pytest.approx(costs[1], rel=1e-15 * 4)
        one, other = (replace(each.engine.statistics, cost=0.0) for each in (rest, complete))
        assert one == other


def test_not_stiff_scenes_are_left_to_their_method():
    ran = Bench(pair(), 3.0, method="automatic", tolerance=1e-6).run()
    assert len(ran.engine.statistics.changes) == 1
    exact = 0.1 * (1.0 - relaxation(0.0, np.sqrt(200.0), ran.time))
    assert ran.position[:, 0, 0] == pytest.approx(exact, abs=2e-7)
