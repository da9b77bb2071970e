"""Unknowns at which an energy is least: closed forms, derivatives, and compiled iterations."""

from functools import partial

import numpy as np
import pytest

from tests.autodiff.test_emission import called
from tests.every import every
from tissuec.autodiff import Potential, along, exp, gradient, hessian, least, square, unknowns
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Graph
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.loops.items import record_loop
from tissuec.compiled.loops.tables import ItemTable, recorded, room_for

NAMES = ("a", "b", "c")
#: An iteration ends when a step is below 1e-6, whose cube is rounding; so are sums.
ROUNDING = 1e-14


def of_powers(a, b, c, z):
    """Return an energy that is least at z = (b/2a)^(1/3), with 3/2 (2a)^(1/3) b^(2/3) + c."""
    return a * z**2 + b / z + c


def closed(a, b, c):
    """Return z, the least energy, and its derivatives by a, b and c."""
    z = np.cbrt(b / (2.0 * a))
    return z, a * z**2 + b / z + c, np.array([z**2, 1.0 / z, np.ones_like(z)])


def sought(energy=of_powers, start=1.0):
    """Return three inputs, and the least value of an energy of them."""
    graph = Graph()
    inputs = [graph.input(name) for name in NAMES]
    return inputs, least(lambda z: energy(*inputs, z), start + 0.0 * inputs[0] + inputs[1])


def values(count, widest=3.0):
    """Return values of the inputs over many powers of ten."""
    chance = np.random.default_rng(count)
    return dict(zip(NAMES, 10.0 ** chance.uniform(-widest, widest, (3, count)), strict=True))


def test_the_least_energy_has_its_closed_form_with_derivatives():
    inputs, found = sought()
    here = values(200)
    z, energy, slopes = closed(*here.values())
    at, value, slope, bend = evaluate([found.at, found.energy, found.slope, found.bend], here)
    assert at == pytest.approx(z, rel=ROUNDING)
    assert value == pytest.approx(energy, rel=ROUNDING)
    assert (np.abs(slope) < ROUNDING * 10.0 * bend).all()
    found_slopes = evaluate(gradient(found.energy, inputs), here)
    np.testing.assert_allclose(np.broadcast_arrays(*found_slopes), slopes, rtol=ROUNDING)


def test_two_rounds_are_enough_from_one_percent_away(monkeypatch):
    """The error is cubed each time: 1e-2, 1e-6 and rounding, where Newton's would be 1e-8."""
    monkeypatch.setattr(unknowns, "ROUNDS", 2)
    graph = Graph()
    inputs, start = [graph.input(name) for name in NAMES], graph.input("start")
    found, here = least(lambda z: of_powers(*inputs, z), start), values(50)
    z, *_ = closed(*here.values())
    for off in (0.99, 1.01):
        (at,) = evaluate([found.at], here | {"start": off * z})
        assert at == pytest.approx(z, rel=ROUNDING)


def test_second_and_third_derivatives_follow_from_the_equation_of_the_unknown():
    inputs, found = sought()
    here = values(50, 1.0)
    a, b, _ = here.values()
    z, *_ = closed(*here.values())
    by_a, by_b = -z / (3.0 * a), z / (3.0 * b)
    assert np.array(evaluate(gradient(found.at, inputs[:2]), here)) == pytest.approx(
        np.array([by_a, by_b]), rel=ROUNDING
    )
    second = hessian(found.energy, inputs[:2])
    expected = {(0, 0): 2.0 * z * by_a, (1, 0): 2.0 * z * by_b, (1, 1): -by_b / z**2}
    for place, entry in expected.items():
        assert evaluate([second[place]], here)[0] == pytest.approx(entry, rel=2.0 * ROUNDING)
    # z is (b/2a)^(1/3), whose derivatives by b are z/3b, -2z/9b² and 10z/27b³.
    twice = along([second[1, 1]], {inputs[1]: 1.0})
    thrice = 2.0 * by_b**2 / z**3 + 2.0 * z / (9.0 * b**2) / z**2
    assert evaluate(twice, here)[0] == pytest.approx(thrice, rel=1e-13)


def with_fibres(a, b, c, z):
    """Return an energy without a closed form, with a part that only some values have."""
    e = z * b - 0.3 * c
    return a * (z - b) ** 2 + exp(0.2 * e) / z + 0.5 * c * (z * z - 1.0 / z) ** 2


def test_derivatives_agree_with_differences():
    inputs, found = sought(with_fibres)
    here, step = values(40, 0.3), 1e-6
    slopes = gradient(found.energy, inputs)
    second = [gradient(slope, inputs) for slope in slopes]
    for k, name in enumerate(NAMES):
        after, before = (
            evaluate([found.energy, *slopes], here | {name: here[name] + by})
            for by in (step, -step)
        )
        by_steps = [(p - q) / (2.0 * step) for p, q in zip(after, before, strict=True)]
        exact = evaluate([slopes[k], *(row[k] for row in second)], here)
        # Rounding over the step, and its square times third derivatives.
        np.testing.assert_allclose(exact, by_steps, atol=1e-8 * np.abs(by_steps).max())


def of_item(x, v, p):
    found = least(lambda z: with_fibres(p.a, p.b, p.c, z) + square(x[0]) * z, p.start)
    return Potential(found.energy, 0.0)


ITEM = TracedItem(of_item, 1, dict.fromkeys((*NAMES, "start"), 1))
OUTPUTS = [ITEM.energy, *ITEM.forces, *ITEM.matrix.values()]


def item_values(count, widest=1.0):
    chance = np.random.default_rng(count)
    columns = 10.0 ** chance.uniform(-widest, widest, (4, count))
    return columns, 0.3 * chance.normal(size=3)


def of_loop(lanes, columns, x):
    """Return the outputs of items at one node, by the compiled iteration."""
    count = columns.shape[1]
    room, nodes = room_for(len(OUTPUTS), count), np.zeros((count, 1), dtype=np.int64)
    write = partial(record_loop, item=ITEM, outputs=OUTPUTS, constants=(), lanes=lanes)
    called(write, ItemTable.of(nodes, columns), x, np.zeros(3), room.reshape(-1))
    return recorded(room, count)


@every("count", [1, 7, 8, 17, 200])
def test_compiled_iterations_have_the_same_bits_in_any_number_of_lanes(count):
    columns, x = item_values(count)
    eight, four, one = (of_loop(lanes, columns, x) for lanes in (8, 4, 1))
    assert eight.tobytes() == four.tobytes() == one.tobytes()
    names = [str(each.operation.detail) for each in ITEM.numbers]
    given = dict(zip(names, columns, strict=True)) | {f"x.0.{k}": x[k] for k in range(3)}
    expected = np.array(evaluate(OUTPUTS, given)).T
    np.testing.assert_allclose(eight, expected, atol=1e-12 * np.abs(expected).max())


@every("energy", [lambda a, b, c, z: a * z, lambda a, b, c, z: -a * z * z - b])
def test_without_a_least_value_all_is_finite(energy):
    inputs, found = sought(energy)
    slopes = gradient(found.energy, inputs)
    second = [gradient(slope, inputs)[0] for slope in slopes]
    for each in evaluate([found.at, found.energy, *slopes, *second], values(20, 1.0)):
        assert np.isfinite(each).all()
