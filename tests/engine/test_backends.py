"""A further backend is an entry of ``BACKENDS``: forces of springs by NumPy alone."""

import numpy as np
import pytest

from tests.engine.running import Bench, block, chain
from tissuec.core.structs import replace
from tissuec.engine.backends import BACKENDS
from tissuec.engine.operations import OPERATIONS
from tissuec.kernels.records import Net


def springs_by_numpy(x, v, f, power, net):
    """Set the forces of linear springs; see ``springs.springs_kernel.springs``."""
    counts = np.diff(net.first.astype(np.int64))
    low, high = np.repeat(np.arange(len(counts)), counts), net.other.astype(np.int64) // 3
    position, velocity, forces = (each.reshape(-1, 3) for each in (x, v, f))
    reach = position[high] - position[low]
    length = np.linalg.norm(reach, axis=1)
    along = reach / length[:, None]
    closing = ((velocity[high] - velocity[low]) * along).sum(axis=1)
    braking = net.damping * closing
    tension = net.stiffness * (length - net.rest) + braking
    forces[:] = 0.0
    np.add.at(forces, low, tension[:, None] * along)
    np.add.at(forces, high, -tension[:, None] * along)
    power[1] += braking @ closing
    return bool(net.watched and (tension > net.near).any())


@pytest.fixture
def evaluations(monkeypatch):
    """Add the backend; return a list of which each evaluation is an entry."""
    seen = []

    def springs(*arguments):
        seen.append(len(arguments))
        return springs_by_numpy(*arguments)

    further = replace(BACKENDS["interpreted"], operations={"springs": springs})
    monkeypatch.setitem(BACKENDS, "numpy", further)
    return seen


def swinging(backend, **more):
    """Return a damped chain in free fall between two nodes that are held."""
    net = chain(6, damping=0.05, velocity=0.0, **more)
    return Bench(
        net, 0.2, gravity=(0.0, 0.0, -9.81), fixed=[0, 7], ledger=True, backend=backend,
        ruptures="strength" in more,
    )  # fmt: skip


def pulled(backend):
    """Return a solid in runs of springs, one of whose sides is pushed."""
    bench = Bench(block(5), 0.02, method="velocity verlet", backend=backend)
    bench.push([0, 1, 2], (0.0, 0.0, 0.05))
    return bench


@pytest.mark.parametrize("make", [swinging, pulled])
def test_it_gives_the_compiled_results_to_rounding(make, evaluations):
    ran, expected = make("numpy").run(), make("compiled").run()
    assert len(evaluations) >= ran.engine.statistics.evaluations > 0
    assert ran.engine.statistics.backend == "numpy"
    size = np.abs(expected.position - expected.position[0]).max()
    assert size > 0.0
    assert ran.position == pytest.approx(expected.position, abs=1e-9 * size)
    for name in ("work", "dissipated"):
        there = getattr(expected, name)
        assert getattr(ran, name) == pytest.approx(there, abs=1e-9 * np.abs(there).max())


def test_springs_are_by_themselves_where_they_are_in_runs(evaluations):
    bench = pulled("numpy")
    bench.run()
    assert bench.engine.stepper.inputs.features.in_runs


def test_a_spring_breaks_at_the_same_time(evaluations):
    ran, expected = (swinging(name, strength=0.4).run() for name in ("numpy", "compiled"))
    assert ran.end.kind == expected.end.kind == "ruptured"
    assert ran.end.springs.tolist() == expected.end.springs.tolist()
    assert ran.end.time == pytest.approx(expected.end.time, rel=1e-9)


def test_an_error_in_it_ends_the_run_as_it_is(monkeypatch):
    def fails(x, v, f, power, net):
        raise ZeroDivisionError("no springs")

    broken = replace(BACKENDS["compiled"], operations={"springs": fails})
    monkeypatch.setitem(BACKENDS, "broken", broken)
    with pytest.raises(ZeroDivisionError, match="no springs"):
        swinging("broken").run()


def test_operations_take_only_the_records_that_they_are_given_with():
    with pytest.raises(TypeError, match="more records"):
        OPERATIONS["solve"].by(print, Net(*[None] * len(Net._fields[:-1])))
