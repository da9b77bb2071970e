"""What is observed never changes what happens: motions are equal to the last bit."""

from functools import cache

import numpy as np
import pytest

from tests.engine.running import Bench, TimeProfile, chain, pair
from tissuec.engine.integrators import INTEGRATORS

METHODS = sorted(INTEGRATORS)
SMOOTH = TimeProfile("smooth", 0.0, 0.1)


def never(time, position, velocity):
    return False


def moved(method, *, backend=None, lossless=False, **observed):
    """Return a run of a short chain that is pulled, driven between held ends, and pushed."""
    options = {"step": 1e-3} if not INTEGRATORS[method].promises else {"tolerance": 1e-4}
    watch = observed.pop("watch", None)
    net = chain(4, stiffness=80.0, damping=0.0 if lossless else 0.05, mass=0.02)
    bench = Bench(net, 0.2, method=method, backend=backend, fixed=[0], **options, **observed)
    bench.move([5], (0.02, 0.01, 0.0), SMOOTH)
    bench.push([3], (0.0, 0.2, 0.0), TimeProfile("sine", 0.0, 1.0, frequency=9.0))
    return bench.run(0.1, watch=watch)


OBSERVED = {
    "energies": {"ledger": True},
    "a condition": {"watch": never},
    "frames at other times": {"times": np.linspace(0.0, 0.2, 1001)},
    "everything": {"ledger": True, "watch": never, "times": np.linspace(0.0, 0.2, 401)},
}


@cache
def unobserved(method):
    return moved(method, lossless=INTEGRATORS[method].conservative, times=[0.0, 0.1, 0.2])


@pytest.mark.parametrize("observed", sorted(OBSERVED))
@pytest.mark.parametrize("method", METHODS)
def test_positions_are_the_same_whatever_is_observed(method, observed):
    lossless = INTEGRATORS[method].conservative
    plain = unobserved(method)
    other = moved(method, lossless=lossless, **{"times": [0.0, 0.1, 0.2], **OBSERVED[observed]})
    assert np.array_equal(plain.state.position, other.state.position)
    assert np.array_equal(plain.state.velocity, other.state.velocity)
    common = np.isin(other.time, plain.time)
    assert common.sum() >= 2
    assert np.array_equal(plain.position, other.position[common])
    assert plain.engine.statistics.accepted == other.engine.statistics.accepted
    assert plain.engine.statistics.rejected == other.engine.statistics.rejected


def test_interpreted_positions_are_the_same_with_and_without_energies():
    plain, other = (
        moved("dop853", backend="interpreted", times=[0.0, 0.1, 0.2], ledger=ledger)
        for ledger in (False, True)
    )
    assert np.array_equal(plain.position, other.position)


def changing(watch=None, **options):
    """Return a run of a stiff chain, for which methods are tried by turns."""
    net = chain(38, stiffness=3e4, damping=30.0, mass=1e-3)
    bench = Bench(net, 0.05, method="automatic", tolerance=1e-4, fixed=[0], **options)
    bench.move([39], (0.03, 0.01, 0.0), TimeProfile("smooth", 0.0, 0.05))
    return bench.run(watch=watch)


@pytest.fixture(scope="module")
def changed():
    return changing(times=[0.0, 0.05])


@pytest.mark.parametrize("observed", sorted(OBSERVED))
def test_changes_of_method_come_at_the_same_step(changed, observed):
    plain = changed
    other = changing(**{"times": [0.0, 0.05], **OBSERVED[observed]})
    assert np.array_equal(plain.state.position, other.state.position)
    assert plain.engine.statistics.changes == other.engine.statistics.changes


def test_an_undamped_long_motion_keeps_its_symmetric_method_with_energies():
    """Errors that grow in proportion to time: more for the energy than for positions."""
    bench = Bench(pair(stretch=0.3), 2000.0, method="automatic", tolerance=1e-5, ledger=True)
    bench.state.velocity[1] = 0.0, 0.4, 0.0
    bench.advance(20.0)
    assert bench.engine.choice.name == "srkn11"


def test_work_on_a_path_that_no_free_node_feels_is_known_without_smaller_steps():
    """A spring between a held and a driven node stores what whoever drives it does."""
    net = pair(stretch=0.0, stiffness=50.0)

    def ran(ledger):
        bench = Bench(
            net, 1.0, tolerance=1e-8, fixed=[0], ledger=ledger, times=[0.0, 0.37, 1.0]
        )
        bench.move([1], (0.5, 0.0, 0.0), TimeProfile("sine", 0.0, 1.0, frequency=3.0))
        return bench.run()

    plain, kept = ran(False), ran(True)
    assert plain.engine.statistics.accepted == kept.engine.statistics.accepted
    reach = kept.position[:, 1, 0] - kept.position[:, 0, 0] - 1.0
    assert kept.work == pytest.approx(25.0 * reach**2, abs=1e-8 * 25.0 * 0.25)
