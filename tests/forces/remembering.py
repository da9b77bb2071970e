"""Elements with internal variables: rates, and checks that solids and walls share."""

import numpy as np
import pytest

from tests.derivatives import forces, slopes, stiffness
from tests.forces.test_elements import deformed
from tissuec.compiled.calls import kernel_on
from tissuec.validate.forces.elements import ElementSolid
from tissuec.validate.yielding import RelaxingFields

FASTEST = 300.0  # [1/s]


def with_rows(made, position):
    """Return elements that remember in rows behind those of nodes, and places of nodes."""
    made, count = made.stored(len(position), FASTEST), len(position)
    assert made.internal_rows.tolist() == list(range(count, count + len(made.internal_rows)))
    return made, position


def at_rest(made, position):
    """Return velocities and variables of elements that have not been deformed."""
    return np.zeros((len(position) + len(made.internal_rows), 3))


def own_tensors(random, size, shape):
    """Return symmetric tensors around 1, each of which is its own; shape (…, axis, axis)."""
    tensors = np.eye(shape[-1]) + size * random.uniform(-1.0, 1.0, shape)
    return tensors @ tensors.swapaxes(-1, -2)


def own_states(made, position, shape, size=0.3, seed=8):
    """Return velocities, and variables in which branches and flow have their own tensors.

    Args:
        shape: Of the tensors of one branch, or of the flow: (element, point, axis, axis).
    """
    random = np.random.default_rng(seed)
    velocity = at_rest(made, position)
    for kept in (made.branches, made.yielding):
        if kept is not None:
            kept.keep(velocity, own_tensors(random, size, shape), np.arange(made.item_count))
    # Every number is changed by some hundredths of the largest.
    other = 0.02 * random.normal(size=(len(made.internal_rows), 3))
    velocity[made.internal_rows] += other * np.abs(velocity[made.internal_rows]).max()
    return velocity


def in_motion(made, velocity):
    """Return velocities in which all other nodes move, too; what is remembered stays."""
    moving, bodies = velocity.copy(), len(velocity) - len(made.internal_rows)
    moving[:bodies] = np.random.default_rng(2).normal(size=(bodies, 3))
    return moving


def moved(made, drawn, size=5e-4):
    """Return places of all nodes in a strained state [m]."""
    return deformed(drawn, size)


def strains(made, drawn, position):
    """Return C and J of points by the reference, C of shape (element, point, 3, 3)."""
    state = ElementSolid(made, drawn)._strained(position)
    return state.c, state.j


def rates(made, position, velocity):
    """Return the rates that the kernel adds to rows of variables [m/s²]."""
    found, power = np.zeros_like(velocity), np.zeros(2)
    table = made.table(np.arange(len(velocity)), None, position)
    places = np.zeros_like(velocity)
    places[: len(position)] = position
    kernel_on(made.kernel, table)(
        0.0, places.ravel(), velocity.ravel(), found.reshape(-1), power
    )
    return found[made.internal_rows]


def drift(made, position, velocity):
    """Return the rates of what is remembered, and of nothing else, shape (node, 3)."""
    way = np.zeros_like(velocity)
    way[made.internal_rows] = rates(made, position, velocity)
    return way


def lost_as_the_energy_falls(made, position, velocity, *, relative, step=None):
    """Return what is lost [W], after comparing it with the fall of the energy in a drift.

    Args:
        relative: Difference that is allowed.
        step: Of differences [s]; without it, the one in which the fastest number changes by
            1e-7 of the largest.
    """
    lost, way = made.powers(0.0, position, velocity)[1], drift(made, position, velocity)
    if step is None:
        step = 1e-7 * np.abs(velocity).max() / np.abs(way).max()
    after, before = (
        made.recalling(velocity + sign * step * way).energy(0.0, position) for sign in (1, -1)
    )
    assert lost == pytest.approx((before - after) / (2.0 * step), rel=relative)
    return lost


def follow_from_the_energy(made, position, velocity, *, every, matrix, rounding):
    """Check forces and an exact matrix of a state that is remembered by differences.

    Args:
        every: One in so many columns of the matrix is checked.
        matrix: Differences that are allowed, relative to the largest entry.
        rounding: Asymmetry of the matrix that is allowed, likewise.
    """
    known = made.recalling(velocity)
    count = bodies = len(position)
    by_energy = slopes(lambda x: known.energy(0.0, x), position, range(bodies), 1e-8)
    found = forces(made, position, velocity)
    np.testing.assert_allclose(found, by_energy, atol=2e-6 * np.abs(found).max())
    exact = known.matrix(0.0, position, np.arange(count), count).toarray()
    np.testing.assert_allclose(exact, exact.T, atol=rounding * np.abs(exact).max())

    class AtOnce:
        def add_forces(self, time, x, v, to):
            made.add_forces(time, x, velocity, to)

    for column in range(0, 3 * bodies, every):
        by_force = stiffness(AtOnce(), position, column, 1e-9)
        np.testing.assert_allclose(
            exact[:, column], by_force, atol=matrix * np.abs(exact).max()
        )


def tangents_agree(made, position, velocity, *, relative):
    """Compare the derivatives that implicit steps use with differences of the loops.

    Args:
        relative: Differences that are allowed.
    """
    found, chance = made.memory_tangents(position, velocity), np.random.default_rng(3)
    has = found.slots >= 0
    bodies = len(position)

    def kept(of):
        return np.where(has, of.reshape(-1)[np.where(has, found.slots, 0)], 0.0)

    def change(way_x, way_v):
        """Return how forces and the rates of what is remembered change."""
        after, before = (
            (forces(made, position + s * way_x, velocity + s * way_v)[:bodies],
             drift(made, position + s * way_x, velocity + s * way_v))
            for s in (1.0, -1.0)
        )  # fmt: skip
        return (after[0] - before[0]) / 2.0, kept(after[1] - before[1]) / 2.0

    none, way_x = np.zeros((2, *position.shape))
    way_v = np.zeros_like(velocity)
    size = np.ptp(position[:bodies], axis=0).max()
    way_x[:bodies] = 1e-7 * size * chance.normal(size=(bodies, 3))
    way_v[made.internal_rows] = (
        1e-6 * np.abs(velocity).max() * chance.normal(size=(len(made.internal_rows), 3))
    )
    _, rate = change(way_x, 0.0 * velocity)
    exact = np.einsum("ivax,iax->iv", found.by_position, way_x[found.nodes])
    np.testing.assert_allclose(exact, rate, atol=relative * np.abs(rate).max())
    force, rate = change(none, way_v)
    exact = -np.einsum("ivw,iw->iv", found.giving, kept(way_v))
    np.testing.assert_allclose(exact, rate, atol=relative * np.abs(rate).max())
    exact = np.zeros_like(position)
    np.add.at(exact, found.nodes, np.einsum("iaxv,iv->iax", found.pull, kept(way_v)))
    np.testing.assert_allclose(exact[:bodies], force, atol=relative * np.abs(force).max())


def parts_agree(made, position, velocity):
    """Check that elements remember the same when they are taken one by one or by halves."""
    whole = forces(made, position, velocity)
    halves = [made.only(np.arange(k, made.item_count, 2)) for k in (0, 1)]
    parts = [forces(half, position, velocity) for half in halves]
    np.testing.assert_allclose(sum(parts), whole, atol=1e-12 * np.abs(whole).max())
    energies = [half.recalling(velocity).energy(0.0, position) for half in halves]
    energy = made.recalling(velocity).energy(0.0, position)
    assert sum(energies) == pytest.approx(energy, rel=1e-13)
    assert (
        sorted(np.concatenate([half.internal_rows for half in halves]))
        == made.internal_rows.tolist()
    )
    known = made.recalling(velocity)
    for item, half in enumerate(halves):
        alone = half.only(np.array([0])).recalling(velocity).energy(0.0, position)
        chosen = known.only(np.array([item])).energy(0.0, position)
        assert chosen == pytest.approx(alone, rel=1e-13)


def give_way_for_good(made, position, velocity, *, force, energy, lost):
    """Let all branches give way; check that they leave no stress, and lose nothing.

    Args:
        force, energy, lost: Relative differences that are allowed; of ``lost``, in 1/s.
    """
    made.let_relax(velocity, position, np.ones(len(position), dtype=bool))
    found, bare = forces(made, position, velocity), forces(made.relaxed, position)
    np.testing.assert_allclose(found, bare, atol=force * np.abs(bare).max())
    known = made.recalling(velocity).energy(0.0, position)
    assert known == pytest.approx(made.energy(0.0, position), rel=energy)
    assert made.powers(0.0, position, velocity)[1] < lost * made.spread(0.0, position)


def give_way_beside_what_stays(made, position, kept, element, tensors):
    """Check that only elements at the nodes of one give way for good, where these may.

    Args:
        kept: Velocities of all nodes, shape (node, 3).
        element: Whose nodes move.
        tensors: What branches keep in such velocities, shape (branch, element, …).
    """
    other, bodies = kept.copy(), np.zeros(len(position), dtype=bool)
    bodies[made.nodes[element]] = True
    made.let_relax(other, position, bodies)
    same = (tensors(other) == tensors(kept)).all(axis=(-1, -2))
    touches = bodies[made.nodes].any(axis=1)
    there = made.branches.shear > 0.0
    assert not same[there & touches].any()
    assert same[:, ~touches].all()


def flow_is_kept_when_settled(made, position, velocity, *, points, force, energy):
    """Let elements settle; check that branches bear nothing then, and that flow stays.

    Args:
        points: Of one element.
        force, energy: Relative differences that are allowed.
    """
    before = made.yielding.tensors(velocity, points)
    made.let_relax(velocity, position, np.ones(len(position), dtype=bool))
    assert (made.yielding.tensors(velocity, points) == before).all()
    rest = made.relaxed
    assert rest.powers(0.0, position, velocity)[1] == 0.0
    found, bare = forces(made, position, velocity), forces(rest, position, velocity)
    np.testing.assert_allclose(found, bare, atol=force * np.abs(bare).max())
    energies = [each.recalling(velocity).energy(0.0, position) for each in (made, rest)]
    assert energies[0] == pytest.approx(energies[1], rel=energy)


def rates_are_bounded(made, drawn, rate, *, least):
    """Check the bound of rates of a fluid in tension, and that of its drawn shape.

    Args:
        made: Elements that yield at no stress.
        rate: Returns the rate of the logarithm of the plastic stretch [1/s] and the bound, of
            a stretch and a plastic one.
        least: The smallest share of the fastest rate that the bound may be.
    """
    for stretch in (0.7, 1.0, 1.5):
        step = 1e-6
        fastest = (rate(stretch, 1.0 - step)[0] - rate(stretch, 1.0 + step)[0]) / (2.0 * step)
        assert least * fastest <= rate(stretch, 1.0)[1] < 10.0 * fastest
    drawn_rate = 3.0 * made.shear[0] / made.yielding.viscosity[0]
    assert rate(1.0, 1.0)[1] == pytest.approx(drawn_rate, rel=1e-6)
    assert made.relaxed.giving(drawn, at_rest(made, drawn)) == 0.0


def matrices_agree(made, reference, position, velocity, *, relative):
    """Compare the matrix of a remembered state with the reference, of the same state.

    Args:
        relative: Difference that is allowed.
    """
    number = np.arange(len(position))
    found = made.recalling(velocity).matrix(0.0, position, number, len(number)).toarray()
    other = reference.matrix(0.0, position, number, len(number)).toarray()
    np.testing.assert_allclose(found, other, atol=relative * np.abs(other).max())


def agree(made, reference, position, velocity, *, force, energy, lost, kept, step=1e-7):
    """Check forces, energy, dissipation and rates of elements against the reference.

    Args:
        force, energy, lost: Relative differences that are allowed.
        kept: What reads and writes the unknowns of the reference.
        step: Of differences of these unknowns [s].
    """
    found, own = forces(made, position, velocity), np.zeros_like(position)
    reference.add_forces(0.0, position, velocity, own)
    np.testing.assert_allclose(found, own, atol=force * np.abs(own).max())
    due = reference.energy(0.0, position) + reference.remembered_energy(position, velocity)
    assert made.recalling(velocity).energy(0.0, position) == pytest.approx(due, rel=energy)
    dissipated = made.powers(0.0, position, velocity)[1]
    due = reference.dissipated(0.0, position, velocity)
    assert dissipated == pytest.approx(due, rel=lost)
    # Its unknowns are the inverses, whose rates follow from those of the tensors.
    copied = np.zeros_like(velocity)
    kept.write(kept.read(velocity), copied)
    np.testing.assert_allclose(
        copied[made.internal_rows], velocity[made.internal_rows], rtol=1e-9, atol=1e-9
    )
    way = drift(made, position, velocity)
    after, before = (kept.read(velocity + sign * step * way) for sign in (1, -1))
    expected = (after - before) / (2.0 * step)
    np.testing.assert_allclose(
        RelaxingFields((reference,)).rates(position, velocity),
        expected,
        atol=1e-6 * np.abs(expected).max(),
    )
