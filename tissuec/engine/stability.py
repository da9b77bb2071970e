"""Largest angular frequency and damping of a network, from its matrices.

Stiffness and damping act on M^-1/2: the largest eigenvalues of M^-1/2 K M^-1/2 and of
M^-1/2 D M^-1/2, found by the method of Lanczos from a fixed start, without forming a matrix.
"""

from collections.abc import Sequence
from math import sqrt

import numpy as np

from tissuec.engine.integrators.verlet import VelocityVerlet
from tissuec.forces import Resisting
from tissuec.mechanics.state import State
from tissuec.model.network import Floats

MARGIN = 1.05  # an iteration that stops early lies a little low
LEAST_ROUNDS, ROUNDS = 5, 50
CLOSE = 5e-3  # growth of the eigenvalue in a round, as a part of it, that ends the iteration
NOTHING = 1e-12  # of an image, as a part of the eigenvalue, that is rounding only


def spectral_radius(state: State) -> float:
    """Return ω̂ [1/s], a bound of the angular frequencies of small motions about the state."""
    now, position, velocity = state.time, state.position, state.velocity
    parts = [state.acting.stiffening(position, velocity)]
    parts += filter(None, (each.stiffening(now, position) for each in state.effects))
    # Where nothing swings, what only gives way is taken for a motion of damping ratio 1.
    return sqrt(_largest(parts, _root(state))) or 0.5 * _giving(state)


def damping_radius(state: State) -> float:
    """Return λ̂ [1/s], a bound of the rates at which all that brakes does, and springs yield."""
    position, velocity = state.position, state.velocity
    each = [state.acting.braking(position, velocity)]
    each += (effect.braking(position) for effect in state.effects)
    parts = list(filter(None, each))
    # Both together may be as fast as their sum, and are no faster.
    return _giving(state) + (_largest(parts, _root(state)) if parts else 0.0)


def _giving(state: State) -> float:
    """Return a bound of the rates at which springs relax and yield [1/s]."""
    return state.springs(np.flatnonzero(state.alive)).giving(state.position)


def verlet_limit(state: State) -> float:
    """Return the largest stable step of velocity Verlet [s]."""
    omega = spectral_radius(state)
    zeta = damping_radius(state) / (2.0 * omega) if omega else 0.0
    return VelocityVerlet.stability_limit(omega, zeta)


def _root(state: State) -> Floats:
    return np.where(state.held, 0.0, 1.0 / np.sqrt(state.mass))[:, None]


def _largest(parts: Sequence[Resisting], root: Floats) -> float:
    """Return a little more than the largest eigenvalue, by the method of Lanczos.

    G. H. Golub, C. F. Van Loan, *Matrix Computations*, 4th edition 2013, section 10.1: in the
    space of all images so far the operator is tridiagonal.

    Args:
        parts: Whose sum is scaled by the roots of masses on both sides.
        root: 1/√mass, zero for held nodes, shape (node, 1).
    """
    count = len(root)
    # Irregular but fixed, so that no mode is orthogonal to it and runs repeat exactly.
    z = np.sin(1.0 + np.arange(3 * count, dtype=float) ** 2).reshape(count, 3)
    z *= root > 0.0
    last, size, value = np.zeros_like(z), sqrt(_inner(z, z)), 0.0
    diagonal: list[float] = []
    beside: list[float] = []
    while size > NOTHING * value and len(diagonal) < ROUNDS:
        z /= size
        moved, image = z * root, np.zeros_like(z)
        for resist in parts:
            resist(moved, image)
        image *= root
        diagonal.append(_inner(z, image))
        image -= diagonal[-1] * z
        if beside:
            image -= beside[-1] * last
        before, value = value, _top(diagonal, beside)
        if len(diagonal) > LEAST_ROUNDS and value - before < CLOSE * value:
            break
        last, z, size = z, image, sqrt(_inner(image, image))
        beside.append(size)
    return MARGIN * value


def _inner(one: Floats, other: Floats) -> float:
    """Return the inner product; BLAS would add in an order that depends on its threads."""
    return float(np.add.reduce((one * other).ravel()))


def _top(diagonal: list[float], beside: list[float]) -> float:
    """Return the largest eigenvalue of a symmetric tridiagonal matrix."""
    matrix = np.diag(diagonal) + np.diag(beside, -1)  # the lower half is enough
    return float(np.linalg.eigvalsh(matrix)[-1])
