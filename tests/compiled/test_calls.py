"""Compiled operations that Python calls by their addresses do what their loops say."""

import numpy as np
import pytest

from tests.hand_net import make_net
from tissuec.compiled.record_tables import RecordTable
from tissuec.core.structs import replace
from tissuec.engine.integrators import INTEGRATORS, banded
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.operations import FUNCTIONS, OPERATIONS, operations
from tissuec.forces.springs import springs_kernel
from tissuec.laws import LINEAR, REST, SPRING_LAWS, VISCOSITY_LAWS, E, Law, code
from tissuec.laws.formula import exp
from tissuec.mechanics.state import State

NODES, SPRINGS = 9, 24
CURVED = Law(
    "curved",
    SPRING_LAWS["exponential"](stiffening=3.0).force(),
    VISCOSITY_LAWS["power"](exponent=1.7, speed=0.5).force() * exp(E / REST),
)
CALLED = frozenset(("force", "find_sides", "kinetic", "place", "slack", "tension"))


@pytest.fixture(params=["linear", "curved"])
def net(request, monkeypatch):
    """Return a net in motion, whose springs may break, and its layout."""
    rng = np.random.default_rng(4)
    pairs = np.array([(i, j) for i in range(NODES) for j in range(i + 1, NODES)])
    ends = pairs[rng.choice(len(pairs), SPRINGS, replace=False)]
    made = make_net(
        rng.normal(size=(NODES, 3)),
        ends,
        mass=rng.uniform(1.0, 2.0, NODES),
        stiffness=rng.uniform(1.0, 3.0, SPRINGS),
        damping=rng.uniform(0.0, 1.0, SPRINGS),
        rest=rng.uniform(0.5, 2.0, SPRINGS),
        strength=rng.uniform(50.0, 60.0, SPRINGS),
        velocity=rng.normal(size=(NODES, 3)),
    )
    if request.param == "curved":
        law = rng.integers(0, 2, SPRINGS).astype(np.int32)
        springs = replace(made.springs, laws=(LINEAR, CURVED), law=law)
        made = replace(made, springs=springs)
    for name, function in code.functions(made.springs.laws).items():
        monkeypatch.setattr(springs_kernel, name, function)
    layout = KernelInputs(made, watched=True, ledger=True)
    layout.update(State.start(made, gravity=np.array([0.0, 0.0, -9.81]), drag=0.3))
    return layout


def table(layout, *more):
    called = operations(CALLED | set(more), layout.features)
    return RecordTable(layout.net(INTEGRATORS["dop853"])._replace(operations=called))


def random_state(layout):
    state = layout.state
    return layout.inwards(state.position), layout.inwards(state.velocity)


def test_forces_powers_and_nearness_are_those_of_the_loops(net):
    acting, (x, v) = table(net), random_state(net)
    said = []
    for strength in (1e9, 0.1):
        acting.near[:] = strength
        found, expected = np.zeros((2, x.size + 2))
        near = OPERATIONS["force"](0.0, x, v, found[2:], found[:2], acting)
        assert near == FUNCTIONS["force"](0.0, x, v, expected[2:], expected[:2], acting)
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)
        said.append(near)
    assert said == [False, True]


def test_arrays_of_one_and_two_axes_are_written(net):
    acting, (x, v) = table(net), random_state(net)
    for name, shape in (("tension", (SPRINGS,)), ("find_sides", (3, SPRINGS))):
        found, expected = np.zeros((2, *shape))
        given = (0.0, x, v) if name == "find_sides" else (x, v)
        if net.features.cornered or name == "tension":
            OPERATIONS[name](*given, found, acting)
            FUNCTIONS[name](*given, expected, acting)
            assert np.ptp(found) > 0.0
            assert found == pytest.approx(expected, rel=1e-12)


def test_numbers_are_returned(net):
    acting, (x, v) = table(net), random_state(net)
    mass, speed = net.state.mass, net.state.velocity
    expected = 0.5 * float(np.sum(mass[:, None] * speed**2))
    assert OPERATIONS["kinetic"](v, acting) == pytest.approx(expected, rel=1e-14)
    assert OPERATIONS["slack"](x, x, acting) == FUNCTIONS["slack"](x, x, acting) > 0.0
    assert OPERATIONS["place"](0.0, x, v, acting) is None


def test_matrices_are_made_solved_with_and_refused(net):
    solver = RecordTable(net.solver())
    acting, (x, v) = table(net, "assemble", "solve"), random_state(net)
    right = np.random.default_rng(2).normal(size=x.size)
    found, expected = right.copy(), right.copy()
    assert OPERATIONS["assemble"](0.1, x, v, acting, solver) is True
    assert OPERATIONS["solve"](found, acting, solver) is True
    assert banded.assemble(0.1, x, v, acting, solver)
    banded.solve(expected, acting, solver)
    assert found == pytest.approx(expected, rel=1e-10)
    assert OPERATIONS["assemble"](0.1, x + np.nan, v, acting, solver) is False


@pytest.mark.parametrize(
    "wrong",
    [np.zeros(3 * NODES, dtype=np.float32), np.zeros((NODES, 3)), np.zeros(6 * NODES)[::2]],
    ids=["numbers", "axes", "gaps"],
)
def test_an_array_that_is_not_as_the_operation_says_is_refused(net, wrong):
    with pytest.raises(TypeError, match="v of kinetic is no contiguous array"):
        OPERATIONS["kinetic"](wrong, table(net))


def test_what_a_net_has_nothing_of_is_refused(net):
    solver = RecordTable(net.solver())
    with pytest.raises(TypeError, match="nothing that solve is needed for"):
        OPERATIONS["solve"](np.zeros(3 * NODES), table(net), solver)
