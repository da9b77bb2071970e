"""The stiff Fermi-Pasta-Ulam chain: energies wander between stiff springs for a long time.

Six masses between walls, stiff linear and soft quartic springs in turn, frequency 50; Hairer,
Lubich & Wanner, Geometric Numerical Integration (2006), I.5.1. The methods are run on its
forces in place of those of springs, since a linear spring law cannot express them.
"""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.engine.running import Bench
from tests.hand_net import make_net
from tissuec.compiled.binding import Binder
from tissuec.engine import backends, stepper
from tissuec.engine import step as loop
from tissuec.engine.integrators import INTEGRATORS

PAIRS, OMEGA, DURATION = 3, 50.0, 200.0
MASSES = 2 * PAIRS
TIMES = np.linspace(0.0, DURATION, 401)
APART = 20.0  # of the masses, so that none meets its neighbour
CLOSE = 1e-4  # part of the whole oscillatory energy


def pull(q):
    """Return the forces on the masses at displacements, shape (…, mass)."""
    q = np.asarray(q)
    walls = np.zeros((*q.shape[:-1], 1))
    stretch = np.diff(np.concatenate([walls, q, walls], axis=-1), axis=-1)
    tension = 4.0 * stretch**3
    tension[..., 1::2] = 0.5 * OMEGA**2 * stretch[..., 1::2]
    return np.diff(tension, axis=-1)


def paired(q):
    """Return sums and differences of the pairs over √2, each of shape (…, pair)."""
    first, second = q[..., 0::2], q[..., 1::2]
    return (second + first) / np.sqrt(2.0), (second - first) / np.sqrt(2.0)


def unpaired(slow, fast):
    q = np.empty((*slow.shape[:-1], MASSES))
    q[..., 0::2], q[..., 1::2] = (slow - fast) / np.sqrt(2.0), (slow + fast) / np.sqrt(2.0)
    return q


def oscillatory(q, p):
    """Return the energies of the stiff springs, shape (…, pair)."""
    return 0.5 * (paired(p)[1] ** 2 + OMEGA**2 * paired(q)[1] ** 2)


def start():
    one = np.eye(PAIRS)[0]
    return unpaired(one, one / OMEGA), unpaired(one, one)


@cache
def by_scipy():
    """Return the energies at ``TIMES`` by SciPy's DOP853."""
    found = solve_ivp(
        lambda _, y: np.concatenate([y[MASSES:], pull(y[:MASSES])]),
        (0.0, DURATION),
        np.concatenate(start()),
        "DOP853",
        TIMES,
        rtol=1e-13,
        atol=1e-14,
    )
    return oscillatory(found.y[:MASSES].T, found.y[MASSES:].T)


@cache
def by_splitting():
    """Return them by exact swings of the pairs and kicks by what is quartic, composed.

    Yoshida's sixth-order composition (1990) of seven symmetric steps.
    """
    w = 0.784513610477560, 0.235573213359357, -1.17767998417887
    parts = [*w, 1.0 - 2.0 * sum(w), *reversed(w)]
    each = 150  # steps from one time to the next
    h = TIMES[1] / each
    (slow, fast), (slow_p, fast_p) = (paired(part) for part in start())
    turns = [(np.cos(OMEGA * h * part), np.sin(OMEGA * h * part)) for part in parts]
    kicks = 0.5 * h * (np.array([*parts, 0.0]) + np.array([0.0, *parts]))
    found = [oscillatory(*start())]
    for _ in TIMES[1:]:
        for _ in range(each):
            for k in range(len(kicks)):
                quartic = pull(unpaired(slow, fast))
                more_slow, more_fast = paired(quartic)
                slow_p = slow_p + kicks[k] * more_slow
                fast_p = fast_p + kicks[k] * (more_fast + OMEGA**2 * fast)
                if k < len(parts):
                    cosine, sine = turns[k]
                    slow = slow + h * parts[k] * slow_p
                    fast, fast_p = (
                        cosine * fast + sine / OMEGA * fast_p,
                        cosine * fast_p - OMEGA * sine * fast,
                    )
        found.append(oscillatory(unpaired(slow, fast), unpaired(slow_p, fast_p)))
    return np.array(found)


def chain():
    """Return masses in a row, their displacements from even distances being those of q."""
    q, p = start()
    position, velocity = np.zeros((2, MASSES + 2, 3))
    position[:, 0] = APART * np.arange(MASSES + 2)
    position[1:-1, 0] += q
    velocity[1:-1, 0] = p
    ends = [[i, i + 1] for i in range(MASSES + 1)]
    return make_net(position, ends, stiffness=0.5 * OMEGA**2, velocity=velocity)


def on_chain(integrator, backend):
    """Return the loop over steps with the forces of the chain."""

    def force(time, x, v, a, power, net):
        a[:] = 0.0
        order = np.argsort(x[0::3])
        q = x[3 * order[1:-1]] - APART * np.arange(1, MASSES + 1)
        a[3 * order[1:-1]] = pull(q)
        return False

    force.__module__ = "tests"
    replaced = backends.names_in_python(integrator) | {"force": force}
    return Binder(replaced).bind(loop.drive)


@pytest.mark.parametrize(
    ("method", "tolerance"),
    [pytest.param("dop853", 1e-7, marks=pytest.mark.slow), ("srkn11", 1e-5)],
)
def test_energies_wander_as_in_two_other_solutions(method, tolerance, monkeypatch):
    monkeypatch.setattr(stepper, "bound_drive", on_chain)
    bench = Bench(
        chain(), DURATION, method=method, tolerance=tolerance, times=TIMES, fixed=[0, 7]
    )
    ran = bench.run()
    assert ran.end.kind == "reached"
    q = ran.position[:, 1:-1, 0] - APART * np.arange(1, MASSES + 1)
    found = oscillatory(q, ran.velocity[:, 1:-1, 0])
    total = found[0].sum()
    assert np.abs(by_scipy() - by_splitting()).max() < 0.1 * CLOSE * total
    # All three take part: what is compared is no standstill.
    assert (np.ptp(found, axis=0) > 0.2 * total).all()
    assert np.abs(found - by_scipy()).max() < CLOSE * total
    assert INTEGRATORS[method].promises
