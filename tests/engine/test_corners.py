"""Corners of laws are landed on: motions keep their promise, by SciPy with located corners."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.engine.running import Bench
from tests.hand_net import make_net
from tissuec.engine.backends import BACKENDS
from tissuec.laws import LINEAR, SPRING_LAWS, C, D, E, Law, W
from tissuec.laws.code import sides
from tissuec.laws.formula import apply

STIFFNESS, MASS, REST = 4e4, 5e-3, 10e-3
DURATION = 0.06
TIMES = np.linspace(0.0, DURATION, 13)
INF = np.inf


def dead_band(slack):
    pieces = [
        (-INF, -slack, lambda e: STIFFNESS * (e + slack)),
        (-slack, slack, lambda e: 0.0),
        (slack, INF, lambda e: STIFFNESS * (e - slack)),
    ]
    return SPRING_LAWS["dead band"](slack=slack).force(), pieces


def one_sided(formula):
    return formula, [(-INF, 0.0, lambda e: 0.0), (0.0, INF, lambda e: STIFFNESS * e)]


CORNERED = {
    "dead band of 1 um": dead_band(1e-6),
    "dead band of 0.3 mm": dead_band(3e-4),
    "tension only": one_sided(SPRING_LAWS["tension only"]().force()),
    "max": one_sided(C * apply("max", (E, E * 0.0))),
}


@cache
def located(name):
    """Return places of a mass on the spring, solved from corner to corner, shape (time, 2)."""
    times, (_, pieces) = TIMES, CORNERED[name]

    def elongation(y):
        return np.hypot(y[0], y[1]) - REST

    def crossing(limit, direction):
        def event(t, y):
            return elongation(y) - limit

        event.terminal, event.direction = True, direction
        return event

    time, y = 0.0, np.array([14e-3, 0.0, 0.0, 0.3])
    found = np.tile(y[:2], (len(times), 1))
    piece = next(k for k, (low, high, _) in enumerate(pieces) if low <= elongation(y) < high)
    while time < times[-1]:
        low, high, force = pieces[piece]

        def rate(t, y, force=force):
            length = np.hypot(y[0], y[1])
            pull = force(length - REST) / MASS / length
            return [y[2], y[3], -pull * y[0], -pull * y[1]]

        run = solve_ivp(
            rate, (time, times[-1]), y, method="DOP853", rtol=1e-13, atol=1e-16, max_step=1e-4,
            events=[crossing(low, -1.0), crossing(high, 1.0)], dense_output=True,
        )  # fmt: skip
        inside = (times > time) & (times <= run.t[-1])
        if inside.any():
            found[inside] = run.sol(times[inside])[:2].T
        time, y = run.t[-1], run.y[:, -1]
        piece += 0 if run.status == 0 else 1 if len(run.t_events[1]) else -1
    return found


def swinging(formula, *, duration=DURATION, **options):
    """Return a run of a mass that swings and turns about a held one."""
    law = Law("cornered", formula, LINEAR.viscous)
    net = make_net(
        [[0.0, 0.0, 0.0], [14e-3, 0.0, 0.0]], [[0, 1]],
        mass=MASS, stiffness=STIFFNESS, rest=REST, law=law,
        velocity=[[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]],
    )  # fmt: skip
    return Bench(net, duration, fixed=[0], times=TIMES[duration >= TIMES], **options).run()


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("name", CORNERED)
def test_a_law_with_corners_keeps_the_promise(name, tolerance):
    ran = swinging(CORNERED[name][0], duration=TIMES[6], tolerance=tolerance)
    off = np.linalg.norm(ran.position[:, 1, :2] - located(name)[: len(ran.time)], axis=1)
    assert (off[1:] < tolerance * ran.largest_displacement[1:]).all()


@pytest.mark.parametrize("method", ["esdirk43", "trbdf2", "rkc2"])
def test_other_methods_keep_it_as_well(method):
    """Steps of order 2 are so small that ten swings through both corners show it."""
    name, last = "dead band of 0.3 mm", -1 if method == "esdirk43" else 4
    ran = swinging(CORNERED[name][0], duration=TIMES[last], tolerance=1e-3, method=method)
    off = np.linalg.norm(ran.position[:, 1, :2] - located(name)[: len(ran.time)], axis=1)
    assert (off[1:] < 1e-3 * ran.largest_displacement[1:]).all()


def test_both_tiers_land_on_corners():
    formula, duration = CORNERED["tension only"][0], TIMES[6]
    runs = [
        swinging(formula, duration=duration, tolerance=1e-6, backend=backend)
        for backend in BACKENDS
    ]
    # Roundings differ, and with them which steps are taken: each within its promise.
    assert np.abs(runs[0].position - runs[1].position).max() < 1e-6 * 14e-3


def test_a_dashpot_that_brakes_one_way_only_is_landed_on():
    """Under a constant force a mass comes to rest at the closed form's place and is let go."""
    law = Law("one way", LINEAR.elastic, D * apply("max", (W, W * 0.0)))
    net = make_net(
        [[0, 0, 0], [1, 0, 0]], [[0, 1]], mass=1.0, stiffness=0.0, damping=2.0,
        law=law, velocity=[[0, 0, 0], [1.0, 0, 0]],
    )  # fmt: skip
    bench = Bench(net, 2.0, fixed=[0], tolerance=1e-8, times=[0.0, 2.0])
    bench.push([1], (-1.0, 0.0, 0.0))
    ran = bench.run()
    # v' = -1 - 2 v until v = 0, at t = ln(3)/2 and x = 1/2 - ln(3)/4; then free fall.
    turn = 0.5 * np.log(3.0)
    expected = 1.0 + 0.5 - 0.25 * np.log(3.0) - 0.5 * (2.0 - turn) ** 2
    assert ran.position[-1, 1, 0] == pytest.approx(expected, abs=1e-8)


def test_sides_change_at_every_corner_and_nowhere_else():
    formula = C * apply("abs", (E - 0.1,)) + apply("max", (E, 0.3 - E)) * apply("min", (E, C))
    e = np.linspace(-1.0, 1.0, 4001)
    found = sides(formula, "e").at({"c": 0.7, "e": e, "rest": 1.0})
    corners = e[1:][np.diff(found) != 0.0]
    assert corners == pytest.approx([0.1, 0.15, 0.7], abs=1e-3)


def test_smooth_laws_are_not_looked_at():
    ran = swinging(C * E * (E * E * 1e4 + 1.0), tolerance=1e-6)
    assert not ran.engine.stepper.inputs.features.cornered
