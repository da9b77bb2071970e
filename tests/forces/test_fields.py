"""What all effects share: kernels, balances of force and power, derivatives, bounds."""

from functools import partial
from typing import NamedTuple

import numpy as np
import pytest
from msgspec import Struct
from scipy.sparse import eye_array

from tests.contact.scenes import contact_with
from tests.derivatives import slopes
from tests.engine.running import Bench
from tests.forces.test_fluids import fluid_in
from tests.forces.test_plates import TUBE, plates
from tests.forces.test_pressure import network_of, pressure_on, shaken
from tests.hand_net import make_net
from tests.test_enclosures import RADIUS, ball
from tests.test_jets import jet_in, net_of, plate
from tissuec.autodiff.evaluation import evaluate
from tissuec.compiled.calls import kernel_on
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.forces.acting import FORCES, Acted, jets
from tissuec.forces.acting.jets import Jet
from tissuec.forces.acting.load import Drag, Load, LoadTerm, Weight
from tissuec.forces.contact import contact
from tissuec.forces.contact.contact import Contact
from tissuec.forces.enclosed.pressure import SurfacePressure, traced_triangle
from tissuec.forces.fields import Field, acts_of
from tissuec.forces.pooled_fields import PooledField
from tissuec.forces.potential_fields import PotentialField
from tissuec.forces.solids.ties import GlueTies, SofteningTies, Ties
from tissuec.geometry.nearest import TRIANGLE
from tissuec.kernels.records import Floats
from tissuec.mechanics.state import State
from tissuec.model.profiles import TimeProfile
from tissuec.validate.forces import FORMULAS

RISING = TimeProfile("smooth", 0.0, 2.0)
NOW = 1.2  # [s]


class Example(Struct, frozen=True):
    """A field in a state in which it does something.

    Attributes:
        size: Of the state [m].
        stores: Whether its forces come from an energy where nothing moves.
        balances: Whether they cancel.
        is_bounded: Whether the bound of what resists counts its carriers, too.
    """

    field: object
    position: Floats
    size: float
    stores: bool = True
    balances: bool = True
    is_bounded: bool = True

    @property
    def velocity(self):
        return np.random.default_rng(5).normal(size=self.position.shape)


def enclosed():
    net, found = ball()
    noise = np.random.default_rng(1).normal(size=net.position.shape)
    return Example(found.swollen(0.2, RISING), net.position * (1.0 + 0.1 * noise), 0.02)


def filled():
    """Return an example of a fluid that rests on a wall and on caps."""
    net = network_of("tube")
    found = fluid_in(net, "tube", caps=True).swollen(0.2, RISING)
    return Example(found, shaken(net, 5e-4), 5e-3, balances=False)


def pressed():
    """Return an example of a pressure on a wall that caps close, which is given."""
    net = network_of("tube")
    found = replace(pressure_on(net, "tube", caps=True), profile=RISING)
    return Example(found, shaken(net, 5e-4), 5e-3, stores=False, is_bounded=False)


def curved():
    field, drawn = plates(TUBE, delay=0.02)
    noise = np.random.default_rng(2).normal(size=drawn.shape)
    return Example(field, drawn + 5e-4 * noise, 0.005)


def tied(kind=Ties, **more):
    """Return an example of ties at points between four nodes on each side."""
    chance, none = np.random.default_rng(7), np.zeros(0, dtype=np.int64)
    sides = [sign * chance.dirichlet(np.ones(4), 5) for sign in (1.0, -1.0)]
    found = kind(
        walls=none, walled=none, name="block", span=Span(Source("", ""), 0, 0),
        nodes=np.array([chance.permutation(16)[:8] for _ in range(5)]),
        weights=np.concatenate(sides, axis=1), stiffness=chance.uniform(20.0, 40.0, 5),
        damping=np.zeros(5), **more,
    )  # fmt: skip
    return Example(found, chance.uniform(size=(16, 3)), 1.0)


def torn(kind=SofteningTies, **more):
    return tied(
        kind, first=np.full(5, 0.1), last=np.full(5, 2.0),
        sections=np.zeros(5, dtype=np.int64), softens=np.zeros(5, dtype=bool), **more,
    )  # fmt: skip


def glued():
    return torn(GlueTies, elements=np.zeros(5, dtype=np.int64), areas=np.ones(5))


def touching():
    points = np.random.default_rng(3).uniform(size=(12, 3))
    faces = np.array([[9, 10, 11]])
    found = contact_with(TRIANGLE, faces, 9, radius=0.4, damping=0.05)
    return Example(found, points, 1.0, is_bounded=False)


def blowing():
    net = net_of(plate(6, 4e-3, jitter=0.2))
    return Example(
        jet_in(net, profile=RISING), net.position, 0.02, stores=False, balances=False
    )


def on_some(kind, *entries):
    """Return an example of a force on some nodes."""
    points = np.random.default_rng(6).uniform(size=(9, 3))
    own = np.arange(2, 7), points[2:7], np.ones(5), np.linspace(0.1, 0.5, 5)
    acted = Acted(*own, np.zeros((0, 3), dtype=np.int32), np.zeros((0, 2), dtype=np.int32))
    moved = points + 0.1 * np.random.default_rng(7).normal(size=points.shape)
    return Example(FORCES[kind](*entries).on(acted), moved, 1.0, balances=False)


def on_triangles(kind, *entries, balances=True):
    """Return an example of a force on some of the triangles of a sphere."""
    net = ball()[0]
    own = np.arange(30), net.position[:30], net.mass[:30], np.ones(30)
    field = FORCES[kind](*entries).on(Acted(*own, net.skin, net.springs.ends))
    noise = np.random.default_rng(7).normal(size=net.position.shape)
    return Example(field, net.position * (1.0 + 0.1 * noise), RADIUS, balances=balances)


def alone(kind, *numbers):
    """Return an example of what acts on each node by itself."""
    points = np.random.default_rng(9).uniform(size=(6, 3))
    stores = kind is Weight
    return Example(kind(*numbers), points, 1.0, stores=stores, balances=False, is_bounded=False)


MASSES = np.linspace(0.0, 0.5, 6)  # as if the first node were held
WEIGHING = np.linspace(0.8, 1.3, 6)
TERMS = (
    LoadTerm(np.array([0.2, 0.0, -0.1]), RISING),
    LoadTerm(np.ones(3), TimeProfile("constant", 0.0, 2.0)),
)
NODAL = {
    "weight": lambda: alone(Weight, MASSES, np.array([0.3, 0.0, -9.81]), WEIGHING),
    "drag": lambda: alone(Drag, MASSES),
    "load": lambda: alone(Load, np.array([1, 4, 4]), TERMS, Span(Source("", ""), 0, 0)),
}
#: Fields that follow from a potential; see ``test_potential_fields``.
POTENTIALS = {
    "curved": curved,
    "foundation": lambda: on_some("foundation", 30.0, 0.4),
    "tied": tied,
    "torn": torn,
    "glued": glued,
}
FIELDS = {
    "enclosed": enclosed,
    "filled": filled,
    "pressed": pressed,
    "touching": touching,
    "blowing": blowing,
}
FIELDS |= POTENTIALS
EFFECTS = FIELDS | NODAL


@pytest.fixture(params=EFFECTS)
def example(request):
    return EFFECTS[request.param]()


@pytest.fixture(params=FIELDS)
def with_kernel(request):
    return FIELDS[request.param]()


def forces(field, position, velocity=None):
    total = np.zeros_like(position)
    still = np.zeros_like(position) if velocity is None else velocity
    field.add_forces(NOW, position, still, total)
    return total


def called(kernel, table, time, *vectors):
    kernel(time, *vectors, table)


def evaluated(field, place, time, x, v, f, power):
    """Add what the graph of a potential has by NumPy, in place of its compiled form."""
    moved, item = replace(field, nodes=place[field.nodes]), field.traced
    values = moved.inputs(x.reshape(-1, 3), v.reshape(-1, 3))
    *found, lost = evaluate([*item.forces, item.power], values)
    at = (3 * moved.nodes[:, :, None] + np.arange(3)).reshape(len(moved.nodes), -1)
    np.add.at(f, at, np.stack(found, axis=1))
    power[1] += lost.sum()


def grouped(field, place, time, x, v, f, power):
    """Do the same for items in groups, or under a pressure."""
    x, v = (each.reshape(-1, 3)[place] for each in (x, v))
    items, every, count = field.grouped, np.arange(len(x)), len(x)
    values = items.inputs(x)
    # Points follow the velocities of nodes without their own constants.
    still = items.points.inputs("v", items.corners, 0.0 * v)
    moved = items.points.inputs("v", items.corners, v)
    values |= {name: moved[name] - still[name] for name in moved}
    item, rate = field.pool.item if isinstance(field, PooledField) else traced_triangle(), 0.0
    if isinstance(field, PooledField):
        of_groups, pool = field._of_groups(time, x), field.pool
        of_groups["a.1"] = sum(amount * curve.at(time)[1] for amount, curve in field.changes)
        for name, slope in zip(
            pool.given, evaluate(pool.whole.factors, of_groups), strict=True
        ):
            values[str(name.operation.detail)] = slope[items.owner]
        rate = evaluate([pool.whole.supply], of_groups)[0].sum()
    else:
        values["a.0"] = field.pressure(time)
    *found, supply = evaluate([*item.forces, item.supply], values)
    wide = np.zeros((count + items.points.count, 3))
    to = items.points.numbers(items.corners, every, count)
    np.add.at(wide, to, np.stack(found, axis=-1).reshape(*to.shape, 3))
    f.reshape(-1, 3)[place] += (items.points.follow(every, count).T @ wide.ravel()).reshape(
        -1, 3
    )
    power[0] += rate + supply.sum()


def by_kernel(example, *, compiled=True):
    """Return the forces and powers of the kernel, with nodes in another order."""
    field, count = example.field, len(example.position)
    place = np.random.default_rng(4).permutation(count)
    table = field.table(place, acts_of(field.changes, 0.0, 2.0), example.position)
    x, v = np.zeros((2, count, 3))
    x[place], v[place] = example.position, example.velocity
    f, power = np.zeros(3 * count), np.zeros(2)
    if compiled:
        call = kernel_on(field.kernel, table)
    elif isinstance(field, PotentialField):
        call = partial(evaluated, field, place)
    elif isinstance(field, PooledField | SurfacePressure):
        call = partial(grouped, field, place)
    else:
        call = partial(called, field.kernel, table)
    call(NOW, x.ravel(), v.ravel(), f, power)
    return f.reshape(-1, 3)[place], power


def test_numbers_of_nodes_do_not_matter(with_kernel):
    example = with_kernel
    found, power = by_kernel(example)
    field, motion = example.field, (example.position, example.velocity)
    expected = forces(field, *motion)
    scale = np.abs(expected).max()
    assert scale > 0.0
    assert found == pytest.approx(expected, abs=1e-12 * scale)
    booked = field.powers(NOW, *motion)
    assert power == pytest.approx(booked, rel=1e-10, abs=1e-12 * scale)


@pytest.mark.parametrize("parts", [2, 9])
def test_parts_do_the_same_to_the_last_bit_in_any_order(with_kernel, parts, monkeypatch):
    for module in (contact, jets):
        monkeypatch.setattr(module, "WORTHWHILE", 0)
    field, (x, v) = with_kernel.field, (with_kernel.position, with_kernel.velocity)
    table = field.table(np.arange(len(x)), acts_of(field.changes, 0.0, 2.0), x)

    def summed(groups):
        total, power = np.zeros_like(x), np.zeros(2)
        for each in (each for group in groups for each in reversed(group)):
            kernel_on(field.kernel, each)(NOW, x.ravel(), v.ravel(), total.ravel(), power)
        return total, power

    groups = field.in_parts(table, parts)
    assert (max(map(len, groups)) == parts) == isinstance(field, Contact | Jet)
    whole, found = summed([[table]]), summed(groups)
    assert np.abs(whole[0]).max() > 0.0
    assert all(np.array_equal(one, other) for one, other in zip(whole, found, strict=True))


def test_power_is_put_in_stored_or_lost(example):
    """What forces do to nodes comes out of the energy, or from outside."""
    field, (x, v) = example.field, (example.position, example.velocity)
    done, (given, lost) = np.vdot(forces(field, x, v), v), field.powers(NOW, x, v)
    h = 1e-6 * example.size
    later, sooner = (float(field.energy(NOW + s * h, x + s * h * v)) for s in (1.0, -1.0))
    stored = (later - sooner) / (2.0 * h)
    assert done + stored == pytest.approx(given - lost, abs=1e-6 * abs(done))


def test_forces_come_from_the_energy(example):
    if not example.stores:
        assert not example.field.energy(NOW, example.position)
        return
    nodes = range(0, len(example.position), 4)
    energy, step = partial(example.field.energy, NOW), 1e-6 * example.size
    expected = slopes(energy, example.position, nodes, step)
    found = forces(example.field, example.position)
    assert found[nodes] == pytest.approx(expected, abs=1e-6 * np.abs(found).max())


def test_forces_cancel_and_turn_nothing(example):
    found = forces(example.field, example.position, example.velocity)
    scale = np.abs(found).sum()
    cancels = np.abs(found.sum(axis=0)).max() < 1e-12 * scale
    torque = np.cross(example.position, found).sum(axis=0)
    assert cancels == example.balances
    assert (np.abs(torque).max() < 1e-12 * scale * example.size) == example.balances


def test_what_is_lost_is_not_negative(example):
    assert example.field.powers(NOW, example.position, example.velocity)[1] >= 0.0


def test_what_loses_energy_or_puts_it_in_is_told(example, monkeypatch):
    effect, count = example.field, len(example.position)
    monkeypatch.setattr(State, "effects", property(lambda self: (effect,)))
    state = State.start(
        make_net(example.position, np.zeros((0, 2))), gravity=np.zeros(3), drag=0.0
    )
    assert len(state.position) == count
    lost = effect.powers(NOW, example.position, example.velocity)[1]
    assert bool(state.loss) == (lost > 0.0 or type(effect) is Jet)


@pytest.mark.parametrize("shift", [0, 1])
def test_batches_are_as_single_states(example, shift):
    states = np.stack([example.position, 1.01 * example.position])
    both, times = forces(example.field, states), np.full(2, NOW)
    assert np.array_equal(both[shift], forces(example.field, states[shift]))
    energies = np.broadcast_to(example.field.energy(times, states), 2)
    assert energies[shift] == pytest.approx(
        float(example.field.energy(NOW, states[shift])), rel=1e-14
    )


def test_bounds_are_above_what_resists(example):
    """The operator that bounds frequencies is the matrix, or stiffer.

    Where it is exact, it is not that of the positive parts.
    """
    position, field = example.position, example.field
    resist, number = field.stiffening(NOW, position), np.arange(len(position))
    if not example.is_bounded:
        return
    assert (resist is None) == (not example.stores)
    if resist is None:
        return
    exact = isinstance(field, PotentialField)
    matrix = field.matrix(NOW, position, number, len(position), exact=exact)
    for seed in range(3):
        way = np.random.default_rng(seed).normal(size=position.shape)
        image = np.zeros_like(way)
        resist(way, image)
        work = way.ravel() @ (matrix @ way.ravel())
        assert 0.0 < work <= np.vdot(way, image) * (1.0 + 1e-9)


def test_the_matrix_is_minus_the_derivative_of_the_forces(example):
    """Of fields that store energy: the matrix of jets is that of what they light now."""
    field, position, count = example.field, example.position, len(example.position)
    if not example.stores:
        return
    way, step = np.random.default_rng(8).normal(size=position.shape), 1e-6 * example.size
    ahead, behind = (forces(field, position + sign * step * way) for sign in (1.0, -1.0))
    found = field.matrix(NOW, position, np.arange(count), count) @ way.ravel()
    expected = (behind - ahead).ravel() / (2.0 * step)
    assert found == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())
    whole, positive = (
        field.matrix(NOW, position, np.arange(count), count, exact=exact).toarray()
        for exact in (True, False)
    )
    lowest = np.linalg.eigvalsh(whole)[0]
    rounding = 1e-14 * np.abs(whole).max()
    weakening = field.weakening(NOW, position, np.arange(count), count)
    assert lowest >= -weakening * (1 + 1e-9) - rounding
    assert np.linalg.eigvalsh(positive)[0] >= -1e-9 * np.abs(positive).max()


def test_the_reference_has_a_formula_that_agrees(example, request):
    kind = request.node.callspec.params["example"]
    if kind not in FORCES:
        return  # compared elsewhere: tests/validate/test_own_forces.py
    own, field, count = FORMULAS[kind](example.field), example.field, len(example.position)
    motion = example.position, example.velocity
    found = np.zeros_like(example.position)
    own.add_forces(NOW, *motion, found)
    assert found == pytest.approx(forces(field, *motion), abs=1e-12 * np.abs(found).max())
    assert own.energy(NOW, example.position) == pytest.approx(
        float(field.energy(NOW, example.position)), rel=1e-12
    )
    powers = own.pumping(NOW, *motion), own.dissipated(NOW, *motion)
    assert powers == pytest.approx(field.powers(NOW, *motion), rel=1e-12)
    one, other = (
        each.matrix(NOW, example.position, np.arange(count), count).toarray()
        for each in (own, field)
    )
    assert one == pytest.approx(other, abs=1e-12 * np.abs(other).max())


# --- a field that is not shipped --------------------------------------------------------------


class Home(NamedTuple):
    stiffness: float


class Attraction(Field, frozen=True):
    """Springs of no length from all nodes to one place."""

    stiffness = 8.0  # [N/m]

    @property
    def kernel(self):
        return pull_home

    def table(self, place, acts, position):
        return Home(self.stiffness)

    def stiffening(self, position):
        def resist(moved, to):
            to += self.stiffness * moved

        return resist

    def energy(self, time, position):
        return 0.5 * self.stiffness * np.square(position).sum(axis=(-2, -1))

    def matrix(self, time, position, number, size, *, exact=True):
        return self.stiffness * eye_array(3 * size, format="coo")

    def weakening(self, time, position, number, size):
        return 0.0

    def spread(self, time, position):
        return float(self.energy(time, position))

    def noise(self, position):
        return self.stiffness * float(np.abs(position).max())


def pull_home(time, x, v, f, power, home):
    f -= home.stiffness * x


@pytest.fixture
def hung(monkeypatch):
    """Return two masses that a field draws to one place."""
    monkeypatch.setattr(State, "fields", property(lambda self: (Attraction(),)))
    net = make_net([[0.01, 0.0, 0.0], [0.0, 0.02, 0.0]], np.zeros((0, 2)), mass=0.5)
    return Bench(net, 1.0, tolerance=1e-9, times=np.linspace(0.0, 1.0, 21))


def test_a_field_that_is_not_shipped_runs_as_python(hung):
    ran = hung.run()
    swing = np.cos(4.0 * ran.time)[:, None, None] * ran.position[0]
    assert ran.position == pytest.approx(swing, abs=1e-9 * 0.02)


def test_an_error_in_such_a_field_ends_the_run_as_it_is(hung, monkeypatch):
    def fails(time, x, v, f, power, given):
        raise ZeroDivisionError("no centre")

    monkeypatch.setattr(Attraction, "kernel", property(lambda self: fails))
    with pytest.raises(ZeroDivisionError, match="no centre"):
        hung.run()


def test_kernels_are_the_same_compiled_and_as_python(with_kernel):
    found, power = by_kernel(with_kernel)
    expected, booked = by_kernel(with_kernel, compiled=False)
    scale = np.abs(expected).max()
    assert found == pytest.approx(expected, abs=1e-13 * scale)
    assert power == pytest.approx(booked, rel=1e-12, abs=1e-13 * scale)
