"""How fast the network can swing and how strongly it is damped, from its matrices.

Stiffness and damping act on M^-1/2: the largest eigenvalues of M^-1/2 K M^-1/2 and of
M^-1/2 D M^-1/2, found by the method of Lanczos from a fixed start, without forming a matrix.
"""

from math import inf, sqrt

import numpy as np
from msgspec import Struct

from tissuec.forces import Resisting
from tissuec.forces.branches import elongated, flat, pulled
from tissuec.integrators.verlet import VelocityVerlet
from tissuec.mechanics import lengths
from tissuec.network import Floats, Indices
from tissuec.situation import Situation

MARGIN = 1.05  # an iteration that stops early lies a little low
LEAST_ROUNDS, ROUNDS = 5, 50
CLOSE = 5e-3  # growth of the eigenvalue in a round, as a part of it, that ends the iteration
NOTHING = 1e-12  # of an image, as a part of the eigenvalue, that is rounding only


class _Operator(Struct, frozen=True):
    """Σ over springs of the force per displacement, scaled by the root of the masses."""

    low: Indices  # where the coordinates of the lower nodes are, shape (3 spring,)
    high: Indices
    direction: Floats
    along: Floats
    across: Floats | None  # None if springs resist along themselves only
    root: Floats  # 1/√mass, zero for held nodes, shape (node, 1)
    uniform: Floats  # added to the diagonal, shape (node, 1)
    fields: tuple[Resisting, ...] = ()  # beside springs

    def __call__(self, z: Floats) -> Floats:
        """Return the operator applied to a vector of shape (node, 3)."""
        y = z * self.root
        relative = (y.take(self.high) - y.take(self.low)).reshape(-1, 3)
        part = np.einsum("sk,sk->s", self.direction, relative)
        force = (self.along * part)[:, None] * self.direction
        if self.across is not None:
            force += self.across[:, None] * (relative - part[:, None] * self.direction)
        flat = force.ravel()
        out = np.zeros(z.shape)
        out += np.bincount(self.high, flat, z.size).reshape(z.shape)
        out -= np.bincount(self.low, flat, z.size).reshape(z.shape)
        for resist in self.fields:
            resist(y, out)
        return out * self.root + self.uniform * z


def spectral_radius(situation: Situation) -> float:
    """Return ω̂ [1/s], a bound of the angular frequencies of small motions about the state.

    Springs under tension also resist sideways (T / L); what pressed springs lose is ignored.
    """
    low, high, direction, length, alive = _geometry(situation)
    behaviour = situation.behaviour(alive)
    elongation, closing = length - behaviour.rest, _closing(situation, low, high, direction)
    memory, velocity = situation.memory(alive), flat(situation.velocity)
    tension = pulled(behaviour, memory, elongation, velocity)
    stiffness = behaviour.steepness(elongated(memory, elongation, velocity), closing)
    if memory is not None:
        stiffness = stiffness + memory.sudden
    across = np.maximum(tension, 0.0) / np.where(length > 0.0, length, inf)
    root = _root(situation)
    uniform = np.zeros_like(root)
    each = (field.stiffening(situation.time, situation.position) for field in situation.fields)
    fields = tuple(filter(None, each))
    sideways = across if across.any() else None
    low, high = _coordinates(low), _coordinates(high)
    operator = _Operator(low, high, direction, stiffness, sideways, root, uniform, fields)
    # Where nothing swings, what only gives way is taken for a motion of damping ratio 1.
    return sqrt(_largest(operator)) or 0.5 * _giving(situation)


def damping_radius(situation: Situation) -> float:
    """Return λ̂ [1/s], a bound of the rates at which all that brakes does, and springs yield."""
    low, high, direction, length, alive = _geometry(situation)
    behaviour, root = situation.behaviour(alive), _root(situation)
    stretch, velocity = length - behaviour.rest, flat(situation.velocity)
    elongation = elongated(situation.memory(alive), stretch, velocity)
    damping = behaviour.sluggishness(elongation, _closing(situation, low, high, direction))
    giving = _giving(situation)  # both together may be as fast as their sum, and are no faster
    each = (field.braking(situation.position) for field in situation.fields)
    fields = tuple(filter(None, each))
    braking = situation.braking
    if not damping.any() and not braking.any() and not fields:
        return giving
    uniform = braking[:, None] * root * root
    low, high = _coordinates(low), _coordinates(high)
    operator = _Operator(low, high, direction, damping, None, root, uniform, fields)
    return giving + _largest(operator)


def _giving(situation: Situation) -> float:
    """Return a bound of the rates at which springs relax and yield [1/s]."""
    alive = np.flatnonzero(situation.alive)
    memory = situation.memory(alive)
    if memory is None:
        return 0.0
    behaviour = situation.behaviour(alive)
    stretch = lengths(situation.network.ends[alive], situation.position) - behaviour.rest
    return float(memory.fastest(behaviour.steepness(stretch)).max(initial=0.0))


def verlet_limit(situation: Situation) -> float:
    """Return the largest stable step of velocity Verlet [s]."""
    omega = spectral_radius(situation)
    zeta = damping_radius(situation) / (2.0 * omega) if omega else 0.0
    return VelocityVerlet.stability_limit(omega, zeta)


def _geometry(
    situation: Situation,
) -> tuple[np.ndarray, np.ndarray, Floats, Floats, np.ndarray]:
    """Return ends, direction and length of the springs that act on a free node, and which."""
    ends = situation.network.ends
    alive = np.flatnonzero(situation.alive & ~situation.held[ends].all(axis=1))
    low, high = ends[alive, 0], ends[alive, 1]
    r = situation.position[high] - situation.position[low]
    length = np.sqrt(np.einsum("sk,sk->s", r, r))
    return low, high, r / np.where(length > 0.0, length, 1.0)[:, None], length, alive


def _closing(
    situation: Situation, low: np.ndarray, high: np.ndarray, direction: Floats
) -> Floats:
    """Return how fast springs lengthen [m/s], shape (spring,)."""
    relative = situation.velocity[high] - situation.velocity[low]
    return np.asarray(np.einsum("sk,sk->s", direction, relative))


def _coordinates(nodes: Indices) -> Indices:
    """Return where the coordinates of nodes are in a flat vector, shape (3 node,)."""
    return (3 * nodes.astype(np.int64)[:, None] + np.arange(3)).ravel()


def _root(situation: Situation) -> Floats:
    return np.where(situation.held, 0.0, 1.0 / np.sqrt(situation.mass))[:, None]


def _largest(operator: _Operator) -> float:
    """Return a little more than the largest eigenvalue, by the method of Lanczos.

    G. H. Golub, C. F. Van Loan, *Matrix Computations*, 4th edition 2013, section 10.1: in the
    space of all images so far the operator is tridiagonal.
    """
    count = len(operator.root)
    # Irregular but fixed, so that no mode is orthogonal to it and runs repeat exactly.
    z = np.sin(1.0 + np.arange(3 * count, dtype=float) ** 2).reshape(count, 3)
    z *= operator.root > 0.0
    last, size, value = np.zeros_like(z), float(np.linalg.norm(z)), 0.0
    diagonal, beside = [], []
    while size > NOTHING * value and len(diagonal) < ROUNDS:
        z /= size
        image = operator(z)
        diagonal.append(float(np.vdot(z, image)))
        image -= diagonal[-1] * z
        if beside:
            image -= beside[-1] * last
        before, value = value, _top(diagonal, beside)
        if len(diagonal) > LEAST_ROUNDS and value - before < CLOSE * value:
            break
        last, z, size = z, image, float(np.linalg.norm(image))
        beside.append(size)
    return MARGIN * value


def _top(diagonal: list[float], beside: list[float]) -> float:
    """Return the largest eigenvalue of a symmetric tridiagonal matrix."""
    matrix = np.diag(diagonal) + np.diag(beside, -1)  # the lower half is enough
    return float(np.linalg.eigvalsh(matrix)[-1])
