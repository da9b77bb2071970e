"""Detects a net at rest with compressed springs, whose equilibrium may be unstable.

Needed in every run, hence without SciPy; ``stability`` answers the rest.
"""

import numpy as np

from tissuec.core.arrays import norm
from tissuec.forces.springs.springs import flat, pulled
from tissuec.mechanics import observables
from tissuec.mechanics.state import State
from tissuec.model.network import Floats

LOOSE = 1e-10  # of the stiffest: a motion that resists less is said not to be held
DENSE = 900  # unknowns up to which all of them are solved at once: about 0.05 s
AT_REST = 1e-3  # of the largest tension: a force that is none; of the energy: none in motion


def rests_pressed(state: State) -> bool:
    """Return whether springs are pressed, forces balance, and hardly anything moves.

    False wherever there is contact, whose stiffness says little of what buckles.

    Args:
        state: With held nodes where they belong; not changed.
    """
    if state.touching is not None:
        return False
    free, memory = state.free, state.network.internal_rows
    still = np.zeros_like(state.velocity)
    still[memory] = state.velocity[memory]  # what springs and friction remember
    length = observables.lengths(state.springs.ends, state.position)
    tension = _still_tension(state, length, still)
    largest = float(np.abs(tension).max(initial=0.0))
    if tension.min(initial=0.0) >= -AT_REST * largest:
        return False
    force = observables.applied_forces(state)
    _add_pulls(state, length, tension, force)
    for acting in state.fields:
        acting.add_forces(state.time, state.position, still, force)
    if norm(force[free]).max(initial=0.0) > AT_REST * largest:
        return False
    energy = observables.energies(state, state.time, state.position, state.velocity)
    return bool(energy.kinetic <= AT_REST * energy.elastic)


def pulls(state: State) -> tuple[Floats, Floats]:
    """Return tensions of springs, and their sums at nodes, where nothing moves.

    Args:
        state: With held nodes where they belong; not changed.

    Returns:
        Tensions [N], shape (spring,), and forces on all nodes [N], shape (node, 3).
    """
    still = np.zeros_like(state.velocity)
    length = observables.lengths(state.springs.ends, state.position)
    tension, force = _still_tension(state, length, still), np.zeros_like(state.position)
    _add_pulls(state, length, tension, force)
    return tension, force


def _still_tension(state: State, length: Floats, still: Floats) -> Floats:
    """Return tensions where nothing moves [N], shape (spring,).

    Checks of scenes need only this of springs, hence without compiled loops, which
    take longer to load.

    Args:
        length: Of springs [m], shape (spring,).
        still: Velocities of all nodes, zero but for what springs remember [m/s], shape
            (node, 3).
    """
    springs = state.springs
    stretch = length - springs.rest
    tension = pulled(springs.behaviour, springs.inelastic, stretch, flat(still))
    return np.where(state.alive_springs & (length > 0.0), tension, 0.0)


def _add_pulls(state: State, length: Floats, tension: Floats, to: Floats) -> None:
    """Add what springs pull at their ends, without compiled loops either.

    Args:
        length: Of springs [m], shape (spring,).
        tension: Of springs [N], 0 for those of no length, shape (spring,).
        to: Forces on all nodes [N], shape (node, 3), changed in place.
    """
    low, high = state.springs.ends.T
    share = tension / np.where(length > 0.0, length, 1.0)
    for place, force in zip(state.position.T, to.T, strict=True):
        pull = share * (place[high] - place[low])
        force += np.bincount(low, pull, len(to)) - np.bincount(high, pull, len(to))


def is_stable(state: State) -> bool:
    """Return whether the equilibrium of a small net is surely stable.

    Its matrix K then has no eigenvalue below ``-LOOSE`` times the stiffest, which a Cholesky
    factor of K with that on its diagonal shows.

    Args:
        state: As for ``rests_pressed``.
    """
    size = 3 * int(np.count_nonzero(state.free))
    if size > DENSE or state.fields:
        return False
    from tissuec.mechanics.balance import Balance  # which most nets do not need

    balance = Balance(state, np.ones(state.network.node_count, dtype=bool))
    values, rows, columns = balance.springs.entries(balance.bars(balance.start), exact=True)
    places = rows * size + columns
    # Sums of nothing are whole numbers.
    matrix = np.bincount(places, values, size * size).astype(float).reshape(size, size)
    diagonal = np.einsum("ii->i", matrix)
    diagonal += LOOSE * diagonal.max(initial=0.0)
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return False
    return True
