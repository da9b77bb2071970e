"""What follows from the potential of a field: forces, matrices, derivatives."""

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

import numpy as np
import pytest

from tests.derivatives import forces
from tests.every import every
from tests.forces.test_fields import FIELDS, POTENTIALS
from tissuec import forces as room
from tissuec.autodiff import Potential, TracingError
from tissuec.compiled.calls import kernel_on
from tissuec.core.structs import replace
from tissuec.forces.fields import acts_of
from tissuec.forces.matrices import numbers_of, with_numbers
from tissuec.forces.potential_fields import PotentialField, traced_item

SEEDS = (0, 1, 2)


@cache
def example(name):
    """Return a field in a state, small enough for whole matrices."""
    found = FIELDS[name]()
    if name not in POTENTIALS:
        return found.field, found.position, found.size
    field = found.field.only(np.arange(min(found.field.item_count, 12)))
    used, nodes = np.unique(field.nodes, return_inverse=True)
    none = np.zeros(0, dtype=np.int64)
    field = replace(field, nodes=nodes.reshape(field.nodes.shape), walls=none, walled=none)
    return field, found.position[used], found.size


def every_class(base=PotentialField):
    for each in base.__subclasses__():
        yield each
        yield from every_class(each)


def test_every_field_with_a_potential_has_an_example():
    for module in iter_modules(room.__path__, "tissuec.forces."):
        import_module(module.name)
    known = {type(example(name)[0]) for name in POTENTIALS}
    shipped = {
        each
        for each in every_class()
        if each.__module__.startswith("tissuec.") and hasattr(each, "item_potential")
    }
    assert shipped == known


def in_motion(name, seed):
    """Return a field, positions and velocities near its example."""
    field, position, size = example(name)
    chance = np.random.default_rng(seed)
    moved = position + 0.02 * size * chance.normal(size=position.shape)
    return field, moved, 10.0 * size * chance.normal(size=position.shape), size


def difference(function, at, way, step):
    """Return the derivative along a way, by differences of fourth order."""
    near, far = ((function(at + k * step * way) - function(at - k * step * way)) / k / 2.0
                 for k in (1, 2))  # fmt: skip
    return (4.0 * near - far) / (3.0 * step)


CASES = [(name, seed) for name in POTENTIALS for seed in SEEDS]
LEARNT = [*CASES, *(("enclosed", seed) for seed in SEEDS)]


@every(("name", "seed"), CASES)
def test_forces_are_minus_the_slope_of_the_energy_and_cancel(name, seed):
    field, x, v, size = in_motion(name, seed)
    way = np.random.default_rng(9).normal(size=x.shape)
    slope = difference(lambda at: field.energy(0.0, at), x, way, 1e-3 * size)
    found = forces(field, x)
    scale = np.abs(found).sum()
    assert np.vdot(found, way) == pytest.approx(-slope, abs=1e-8 * scale)
    free = not field.touched(x).any()
    for each in (found, forces(field, x, v)):
        turning = np.cross(x, each).sum(axis=0)
        rounding = 1e-12 * np.abs(each).sum()
        assert (np.abs(each.sum(axis=0)).max() < rounding) == free
        assert (np.abs(turning).max() < rounding * np.abs(x).max()) == free
    assert field.energies(x).shape == (len(field.nodes),)


@every(("name", "seed"), CASES)
def test_matrices_and_products_are_derivatives_of_forces(name, seed):
    field, x, v, size = in_motion(name, seed)
    number, count = np.arange(len(x)), len(x)
    ways = np.random.default_rng(9).normal(size=(2, *x.shape))
    step, still = 2e-4 * size, np.zeros_like(x)
    whole = field.matrix(0.0, x, number, count).toarray()
    positive = field.matrix(0.0, x, number, count, exact=False).toarray()
    for each in (whole, positive):
        np.testing.assert_allclose(each, each.T, atol=1e-12 * np.abs(each).max())
    assert np.linalg.eigvalsh(positive)[0] > -1e-12 * np.abs(positive).max()
    slow = field.damping_matrices(x, v, number, count)
    assert (slow is None) == (not field.is_damped)
    by_x, by_v = (0.0 * whole, 0.0 * whole) if slow is None else (m.toarray() for m in slow)
    for way in ways:
        expected = -difference(lambda at: forces(field, at), x, way, step).ravel()
        close(whole @ way.ravel(), expected, whole)
        expected = -difference(lambda at: forces(field, at, v), x, way, step).ravel()
        close((whole + by_x) @ way.ravel(), expected, np.abs(whole) + np.abs(by_x))
        expected = -difference(lambda at: forces(field, x, at), v, way, step).ravel()
        close(by_v @ way.ravel(), expected, np.abs(by_v) + np.abs(whole) * size)
        # Products are loops of their own.
        image = np.zeros_like(x)
        field.stiffening(0.0, x)(way, image)
        np.testing.assert_allclose(image.ravel(), whole @ way.ravel(),
                                   atol=1e-12 * np.abs(whole).max())  # fmt: skip
        if field.is_damped:
            image[:] = 0.0
            field.braking(x)(way, image)
            at_rest = field.damping_matrices(x, still, number, count)[1]
            np.testing.assert_allclose(image.ravel(), at_rest @ way.ravel(),
                                       atol=1e-12 * np.abs(at_rest).max())  # fmt: skip
    assert np.linalg.eigvalsh(by_v)[0] >= -1e-12 * np.abs(by_v).max()


def close(found, expected, matrix):
    assert found == pytest.approx(expected, abs=1e-8 * np.abs(matrix).max())


@every(("name", "seed"), CASES)
def test_what_is_dissipated_is_the_work_of_damping_forces(name, seed):
    field, x, v, _ = in_motion(name, seed)
    given, lost = field.powers(0.0, x, v)
    work = np.vdot(forces(field, x, v) - forces(field, x), v)
    assert given == 0.0 and lost >= 0.0
    assert lost == pytest.approx(-work, rel=1e-9)
    assert not field.powers(0.0, x, np.zeros_like(v)).any()


@every(("name", "seed"), LEARNT)
def test_derivatives_for_learning_are_transposes_and_agree_with_differences(name, seed):
    field, x, v, size = in_motion(name, seed)
    if not field.learnt:
        return
    found, chance = field.derivatives, np.random.default_rng(seed)
    columns, numbers = found.columns, numbers_of(field, found.columns)
    table = field.table(np.arange(len(x)), acts_of(field.changes, 0.0, 0.0), x)
    weight = chance.normal(size=x.size)
    sizes, scales = (x.size, x.size, numbers.size), (size, 10.0 * size, np.abs(numbers))
    by = [np.zeros(n) for n in sizes]
    kernel_on(found.pull_back, table, 6)(0.0, x.ravel(), v.ravel(), weight, *by)
    changes = 3
    ways = [np.reshape(s, (-1, 1)) * chance.normal(size=(n, changes))
            for n, s in zip(sizes, scales, strict=True)]  # fmt: skip
    df = np.zeros((x.size, changes))
    given = [each.ravel() for each in (*ways, df)]
    kernel_on(found.push_forward, table, 7)(
        0.0, x.ravel(), v.ravel(), *given, np.zeros(changes)
    )
    pushed = given[-1].reshape(df.shape)
    pulled = sum(slope @ way for slope, way in zip(by, ways, strict=True))
    scale = np.abs(weight) @ np.abs(pushed)
    np.testing.assert_allclose(weight @ pushed, pulled, atol=1e-12 * scale.max())

    def moved(part):
        dx, dv, dn = (part * way[:, 0] for way in ways)
        other = with_numbers(field, columns, numbers + dn)
        return forces(other, x + dx.reshape(x.shape), v + dv.reshape(v.shape)).ravel()

    expected = difference(moved, 0.0, 1.0, 2e-4)
    np.testing.assert_allclose(pushed[:, 0], expected, atol=1e-8 * np.abs(expected).max())


def test_power_that_is_supplied_is_refused():
    def blows(x, v, p):
        return Potential(0.0, supply=v[0][0])

    with pytest.raises(TracingError, match=r"test_potential_fields\.py:.*supplies power"):
        traced_item(blows, 1, ())


# --- degenerate items -------------------------------------------------------------------------


def degenerate(position, size):
    """Yield states in which items have no length, area or order."""
    yield 0.0 * position
    for k in range(len(position) - 1):
        moved = position.copy()
        moved[k] = moved[k + 1]
        yield moved
    for axis in range(3):
        moved = position.copy()
        moved[:, axis] = 0.0
        yield moved  # without volume, folded flat
        line = 0.0 * position
        line[:, axis] = position[:, axis]
        yield line  # without area
    yield -position
    yield position[::-1]
    for scale in (1e-60, 1e-9, 1e30):
        yield scale * position


@every("name", POTENTIALS)
def test_degenerate_items_have_finite_forces_and_matrices(name):
    field, position, size = example(name)
    velocity = 10.0 * size * np.random.default_rng(0).normal(size=position.shape)
    number, count = np.arange(len(position)), len(position)
    for k, state in enumerate(degenerate(position, size)):
        slow = field.damping_matrices(state, velocity, number, count) or ()
        matrices = field.matrix(0.0, state, number, count), *slow
        found = [field.energy(0.0, state), field.powers(0.0, state, velocity)]
        found += [forces(field, state, velocity), *(each.data for each in matrices)]
        if field.learnt:
            sizes = state.size, state.size, numbers_of(field, field.learnt).size
            found += (by := [np.zeros(n) for n in sizes])
            pull = kernel_on(field.derivatives.pull_back, field.table(number, None, state), 6)
            pull(0.0, state.ravel(), velocity.ravel(), velocity.ravel(), *by)
        assert all(np.isfinite(each).all() for each in found), k
    field.check(position)
