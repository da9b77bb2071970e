"""What instruments do to the nodes that they touch: pressure and friction.

A node at x that is deeper in a shape than its surface is pressed out along the normal n with

    N = k φ(δ) max(0, 1 + b δ'),    φ(δ) = δ² / 2w up to the depth w, δ - w/2 beyond it,

so that force and stiffness pass through zero steadily. The shape gets the opposite force, at
its nodes: capsules by the lever rule, planes as turning them asks for, so that the work of
whoever moves them is exactly what the energy k ∫ φ takes up.

Friction follows Coulomb's law by a bristle z at each node, which bends with the sliding
velocity u and slips where it bears no more:

    z' = u - max(0, u·e) e r⁸,    e = z / |z|,  r = k |z| / μ N,    force -k z min(1, 1/r).

Where it sticks, it really sticks: a bristle under a steady load below μ N does not creep, as a
friction that depends on velocity alone does. (One-sided form of the model of P. R. Dahl, The
Aerospace Corporation TOR-0158, 1968.) Bristles are kept in the velocities of ``memory`` nodes,
as z times ``rate``, so that they are stepped, stored and resumed like all other motion.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tissuec.core.source import Span
from tissuec.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

SHARPNESS = 8  # power of r: how suddenly a bristle begins to slip
LARGEST = 2.0  # r is cut off here
LEAST = 1e-3  # of the pressure at depth w: bristles under no pressure are not endlessly fast


class Place(NamedTuple):
    """Where nodes are in a shape, each of shape (…, node of the contact).

    Attributes:
        depth: [m]; positive where the shape touches.
        normal: Away from the shape, shape (…, node, 3).
        curvature: Of the surface of equal depth, except along ``line`` [1/m].
        line: Unit vector, or zero, shape (…, node, 3).
        weights: Of both points of the shape in where it touches, shape (…, node, 2).
        pressing: Forces on both points by a unit force on the node, shape (…, node, 2, 3).
    """

    depth: Floats
    normal: Floats
    curvature: Floats
    line: Floats
    weights: Floats
    pressing: Floats


class Touch(NamedTuple):
    """What a shape does to the nodes.

    Attributes:
        place: Where they are in it.
        sliding: Velocity against its surface [m/s], shape (…, node, 3).
        pressure: N [N], shape (…, node).
    """

    place: Place
    sliding: Floats
    pressure: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Which nodes can be touched by which shapes, and how hard that is.

    Attributes:
        nodes: Nodes that can be touched, ascending, shape (m,).
        points: Nodes that carry the shapes, two each, shape (shape, 2).
        radius: Of capsules [m]; negative for planes, shape (shape,).
        stiffness: k [N/m].
        layer: w [m].
        damping: b [s/m].
        friction: μ.
        memory: Nodes whose velocities are the bristles, shape (m,), or none without friction.
        rate: Of bristles in those velocities [1/s].
        span: Where it is written.
    """

    nodes: Indices
    points: Indices
    radius: Floats
    stiffness: float
    layer: float
    damping: float
    friction: float
    memory: Indices
    rate: float
    span: Span

    def renumbered(self, place: Indices) -> "Contact":
        """Return the same with other numbers of nodes: node i becomes ``place[i]``."""
        return replace(
            self,
            nodes=place[self.nodes],
            points=place[self.points],
            memory=place[self.memory],
        )

    def touches(self, position: Floats, velocity: Floats) -> list[Touch]:
        """Return what each shape does to the nodes.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (…, node, 3).
        """
        x, v = position[..., self.nodes, :], velocity[..., self.nodes, :]
        found: list[Touch] = []
        for pair, radius in zip(self.points, self.radius, strict=True):
            p, q = position[..., pair[0], None, :], position[..., pair[1], None, :]
            place = _in_plane(x, p, q) if radius < 0.0 else _in_capsule(x, p, q, radius)
            ends = velocity[..., pair, :]
            sliding = v - np.einsum("...np,...pk->...nk", place.weights, ends)
            # Along the normal exactly as the depth changes, of turning planes as well.
            turning = np.einsum("...npk,...pk->...n", place.pressing, ends)
            rate = _dot(place.normal, v) + turning
            sliding += (rate - _dot(place.normal, sliding))[..., None] * place.normal
            factor = np.maximum(1.0 - self.damping * rate, 0.0)
            found.append(Touch(place, sliding, self.pressure(place.depth) * factor))
        return found

    def depths(self, position: Floats) -> list[Place]:
        """Return where the nodes are in each shape."""
        return [touch.place for touch in self.touches(position, np.zeros_like(position))]

    def pressure(self, depth: Floats) -> Floats:
        """Return k φ(δ) [N]."""
        w, d = self.layer, np.maximum(depth, 0.0)
        return self.stiffness * np.where(d < w, d * d / (2.0 * w), d - 0.5 * w)

    def steepness(self, depth: Floats) -> Floats:
        """Return k φ'(δ) [N/m]."""
        return self.stiffness * np.clip(depth / self.layer, 0.0, 1.0)

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the energy of all pressed contacts [J], shape (…)."""
        w, total = self.layer, np.zeros(position.shape[:-2])
        for place in self.depths(position):
            d = np.maximum(place.depth, 0.0)
            deep = 0.5 * d * (d - w) + w * w / 6.0
            each = self.stiffness * np.where(d < w, d**3 / (6.0 * w), deep)
            total = total + np.add.reduce(each, axis=-1)
        return total

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""
        touches = self.touches(position, velocity)
        total, rub = self._rub(touches, velocity)
        on_nodes: Any = (..., self.nodes, slice(None))
        np.add.at(to, on_nodes, rub)
        for touch, pair in zip(touches, self.points, strict=True):
            pressed = touch.pressure[..., None] * touch.place.normal
            np.add.at(to, on_nodes, pressed)
            share = touch.pressure / np.where(total > 0.0, total, 1.0)
            back = np.einsum("...n,...npk->...pk", touch.pressure, touch.place.pressing)
            back -= np.einsum("...n,...np,...nk->...pk", share, touch.place.weights, rub)
            on_points: Any = (..., pair, slice(None))
            np.add.at(to, on_points, back)

    def dissipated(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the power that damping and friction take out [W], shape (…)."""
        touches = self.touches(position, velocity)
        total, rub = self._rub(touches, velocity)
        power = np.zeros(position.shape[:-2])
        for touch in touches:
            rate = _dot(touch.place.normal, touch.sliding)
            damped = (self.pressure(touch.place.depth) - touch.pressure) * rate
            share = touch.pressure / np.where(total > 0.0, total, 1.0)
            rubbed = _dot(rub, touch.sliding - rate[..., None] * touch.place.normal)
            power += np.add.reduce(damped - share * rubbed, axis=-1)
        return power

    def bristle_rates(self, position: Floats, velocity: Floats) -> Floats:
        """Return the rates of the velocities of ``memory`` [m/s²], shape (…, m, 3)."""
        touches = self.touches(position, velocity)
        normal, total = _mean_normal(touches)
        slide = sum(touch.pressure[..., None] * touch.sliding for touch in touches)
        u = slide / np.where(total > 0.0, total, 1.0)[..., None]
        u -= _dot(u, normal)[..., None] * normal
        z = velocity[..., self.memory, :] / self.rate
        length = np.linalg.norm(z, axis=-1)
        e = z / np.where(length > 0.0, length, 1.0)[..., None]
        least = LEAST * self.friction * self.stiffness * self.layer
        r = np.minimum(self.stiffness * length / (self.friction * total + least), LARGEST)
        slip = np.maximum(_dot(u, e), 0.0) * r**SHARPNESS
        bent = np.where((total > 0.0)[..., None], u - slip[..., None] * e, -self.rate * z)
        return self.rate * bent

    def _rub(self, touches: list[Touch], velocity: Floats) -> tuple[Floats, Floats]:
        """Return pressure and friction on each node [N], of shape (…, m) and (…, m, 3)."""
        normal, total = _mean_normal(touches)
        if not len(self.memory):
            return total, np.zeros_like(normal)
        z = velocity[..., self.memory, :] / self.rate
        z = z - _dot(z, normal)[..., None] * normal
        wish, limit = self.stiffness * np.linalg.norm(z, axis=-1), self.friction * total
        bears = np.where(wish > limit, limit / np.where(wish > 0.0, wish, 1.0), 1.0)
        return total, -self.stiffness * np.where(total > 0.0, bears, 0.0)[..., None] * z

    def blocks(self, position: Floats, *, exact: bool) -> Floats:
        """Return the stiffness of each node against its shapes [N/m], shape (m, 3, 3).

        Args:
            exact: Whether round shapes weaken it, as what rolls off them; otherwise it is
                positive semidefinite.
        """
        total = np.zeros((len(self.nodes), 3, 3))
        for place in self.depths(position):
            across = np.einsum("ni,nj->nij", place.normal, place.normal)
            total += self.steepness(place.depth)[:, None, None] * across
            if exact:
                around = np.eye(3) - across - np.einsum("ni,nj->nij", place.line, place.line)
                total -= (self.pressure(place.depth) * place.curvature)[:, None, None] * around
        return total

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return ``blocks`` among the nodes that may move, where the shapes stand still.

        Args:
            number: Of each node of the scene among those that may move, -1 for others.
            size: How many may move; the matrix is of shape (3 size, 3 size).
        """
        from scipy.sparse import coo_matrix

        here = number[self.nodes]
        moves = here >= 0
        place = 3 * here[moves][:, None] + np.arange(3)
        values = self.blocks(position, exact=exact)[moves]
        rows = np.broadcast_to(place[:, :, None], values.shape)
        columns = np.broadcast_to(place[:, None, :], values.shape)
        parts = values.ravel(), (rows.ravel(), columns.ravel())
        return coo_matrix(parts, shape=(3 * size, 3 * size))

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        size = float(np.abs(position).max(initial=0.0))
        pressures = (self.pressure(place.depth).sum() for place in self.depths(position))
        return size * float(sum(pressures))

    def noise(self, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        return self.stiffness * float(np.abs(position).max(initial=0.0))

    def weakening(self, time: float, position: Floats, number: Indices, size: int) -> float:
        """Return how far below zero round shapes may bring an eigenvalue [N/m]."""
        places = self.depths(position)
        each = sum(self.pressure(place.depth) * place.curvature for place in places)
        return float(np.max(each, initial=0.0))

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that is put in beside that of moving nodes [W]: none."""
        return 0.0


def _dot(one: Floats, two: Floats) -> Floats:
    return np.einsum("...k,...k->...", one, two)


def _mean_normal(touches: list[Touch]) -> tuple[Floats, Floats]:
    """Return unit normals and pressures [N] of all shapes together."""
    mean = sum(touch.pressure[..., None] * touch.place.normal for touch in touches)
    total = sum(touch.pressure for touch in touches)
    size = np.linalg.norm(mean, axis=-1)
    return mean / np.where(size > 0.0, size, 1.0)[..., None], np.asarray(total)


def _in_capsule(x: Floats, p: Floats, q: Floats, radius: float) -> Place:
    d = q - p
    square = _dot(d, d)
    flat = np.where(square > 0.0, square, 1.0)
    s = np.clip(_dot(x - p, d) / flat, 0.0, 1.0)
    r = x - p - s[..., None] * d
    distance = np.linalg.norm(r, axis=-1)
    # On the line itself there is no direction out of it, and so no force.
    inverse = np.where(distance > 0.0, 1.0 / np.where(distance > 0.0, distance, 1.0), 0.0)
    normal = r * inverse[..., None]
    inside = ((s > 0.0) & (s < 1.0))[..., None]
    line = np.where(inside, d / np.sqrt(flat)[..., None], 0.0)
    weights = np.stack([1.0 - s, s], axis=-1)
    pressing = -weights[..., None] * normal[..., None, :]
    return Place(radius - distance, normal, inverse, line, weights, pressing)


def _in_plane(x: Floats, p: Floats, q: Floats) -> Place:
    d = q - p
    length = np.linalg.norm(d, axis=-1)[..., None]
    normal = np.broadcast_to(d / length, x.shape)
    depth = -_dot(normal, x - p)
    # Force and place on the plane make a moment, which its second point takes up.
    lever = (x - p + depth[..., None] * normal) / length
    pressing = np.stack([-normal - lever, lever], axis=-2)
    weights = np.zeros((*depth.shape, 2))
    weights[..., 0] = 1.0
    return Place(depth, normal, np.zeros_like(depth), np.zeros_like(x), weights, pressing)
