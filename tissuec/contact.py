"""What instruments, threads and surfaces do to nodes that they touch: pressure and friction.

A node at x that is deeper in a shape than its surface is pressed out along the normal n with

    N = k φ(δ) max(0, 1 + b δ'),    φ(δ) = δ² / 2w up to the depth w, δ - w/2 beyond it,

so that force and stiffness pass through zero steadily. Shapes are carried by nodes, which get
the opposite force: capsules and triangles by the weights of the nearest point, planes as
turning them asks for. So the work of whoever moves them is what the energy k ∫ φ takes up, and
nothing depends on whether these nodes are held, driven or free.

Friction follows Coulomb's law by a bristle z at each node, which bends with the sliding
velocity u and slips where it bears no more:

    z' = s (u - max(0, u·e) e r⁸) - (1 - s) rate z,    e = z / |z|,  r = k |z| / μ N,
    force -k z min(1, 1/r),    1 - s = exp(-1000 N / k w):  without pressure it stands up again.

Where it sticks, it really sticks: a bristle under a steady load below μ N does not creep, as a
friction that depends on velocity alone does. (One-sided form of the model of P. R. Dahl, The
Aerospace Corporation TOR-0158, 1968.) Bristles are kept in the velocities of ``memory`` nodes,
as z times ``rate``, so that they are stepped, stored and resumed like all other motion.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.source import Span
from tissuec.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

CAPSULE, PLANE, TRIANGLE = range(3)
SHARPNESS = 8  # power of r: how suddenly a bristle begins to slip
LARGEST = 2.0  # r is cut off here
LEAST = 1e-3  # of the pressure at depth w: bristles under no pressure are not endlessly fast
FEW = 12  # shapes up to which all pairs are looked at


class Pairs(NamedTuple):
    """Nodes and shapes that may touch, ascending by node and then by shape.

    Attributes:
        node: Numbers among the nodes of the contact, shape (pair,).
        shape: Numbers of shapes, shape (pair,).
    """

    node: Indices
    shape: Indices


class Place(NamedTuple):
    """Where nodes are in shapes, for each pair.

    Attributes:
        depth: [m]; positive where the shape touches, shape (pair,).
        normal: Away from the shape, shape (pair, 3).
        curvature: Of the surface of equal depth, except along ``line`` [1/m], shape (pair,).
        line: Unit vector, or zero, shape (pair, 3).
        weights: Of the points of the shape in where it touches, shape (pair, 3).
        pressing: Forces on these points by a unit force on the node, shape (pair, 3, 3).
    """

    depth: Floats
    normal: Floats
    curvature: Floats
    line: Floats
    weights: Floats
    pressing: Floats


class Touch(NamedTuple):
    """What shapes do to nodes, for each pair.

    Attributes:
        pairs: Which.
        place: Where they are.
        sliding: Velocity against the surface [m/s], shape (pair, 3).
        rate: Its part along the normal, minus the rate of the depth [m/s], shape (pair,).
        pressure: N [N], shape (pair,).
    """

    pairs: Pairs
    place: Place
    sliding: Floats
    rate: Floats
    pressure: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Which nodes can be touched by which shapes, and how hard that is.

    Attributes:
        nodes: Nodes that can be touched, ascending, shape (m,).
        owner: Body of each, shape (m,).
        kind: ``CAPSULE``, ``PLANE`` or ``TRIANGLE``, shape (shape,).
        points: Nodes that carry each shape, shape (shape, 3): both ends of a capsule, a point
            of a plane and one straight in front of it, with the second one again; corners.
        radius: Around the line of a capsule or the face of a triangle [m], shape (shape,).
        spared: Body whose nodes a shape does not touch, -1 without one, shape (shape,).
        joined: Pairs of nodes of one body that springs join, so that what one of them carries
            does not touch the other, shape (pair, 2).
        stiffness: k [N/m].
        layer: w [m].
        damping: b [s/m].
        friction: μ.
        stride: Longest way of a node in a step, lest it passes through a shape unseen [m].
        memory: Nodes whose velocities are the bristles, shape (m,), or none without friction.
        rate: Of bristles in those velocities [1/s].
        span: Where it is written.
        bonds: Springs of which one must be there for a shape to touch, -1 for none; shape
            (shape, 2).
        pairs: Those that are looked at; None for all that are near.
    """

    nodes: Indices
    owner: Indices
    kind: Indices
    points: Indices
    radius: Floats
    spared: Indices
    joined: Indices
    stiffness: float
    layer: float
    damping: float
    friction: float
    stride: float
    memory: Indices
    rate: float
    span: Span
    bonds: Indices
    pairs: Pairs | None = None

    def with_whole(self, alive: NDArray[np.bool_]) -> "Contact":
        """Return the same without the shapes whose springs are gone.

        Args:
            alive: Springs that are there, shape (spring,).
        """
        bound = self.bonds >= 0
        holding = np.zeros_like(bound)
        holding[bound] = alive[self.bonds[bound]]
        whole = holding.any(axis=1) | ~bound.any(axis=1)
        if whole.all():
            return self
        kept = ("kind", "points", "radius", "spared", "bonds")
        return replace(self, **{name: getattr(self, name)[whole] for name in kept})

    def renumbered(self, place: Indices) -> "Contact":
        """Return the same with other numbers of nodes: node i becomes ``place[i]``."""
        return replace(
            self,
            nodes=place[self.nodes],
            points=place[self.points],
            joined=place[self.joined],
            memory=place[self.memory],
        )

    def near(self, position: Floats, margin: float) -> Pairs:
        """Return the nodes that are less than a margin [m] outside of shapes.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        if len(self.kind) <= FEW:
            shape, node = np.divmod(
                np.arange(len(self.kind) * len(self.nodes)), len(self.nodes)
            )
        else:
            node, shape = self._around(position, margin)
        node, shape = node[allowed := self._allowed(node, shape)], shape[allowed]
        reach = margin * (1.0 + self._lever(position, node, shape))
        close = self.places(position, Pairs(node, shape)).depth > -reach
        node, shape = node[close], shape[close]
        order = np.lexsort((shape, node))
        return Pairs(node[order], shape[order])

    def _around(self, position: Floats, margin: float) -> tuple[Indices, Indices]:
        """Return pairs whose node is in a ball about the shape; planes are about everywhere."""
        from scipy.spatial import cKDTree  # pyright: ignore[reportAttributeAccessIssue]

        x, corners = position[self.nodes], position[self.points]
        middle = corners.mean(axis=1)
        size = np.sqrt(((corners - middle[:, None]) ** 2).sum(axis=2).max(axis=1))
        endless = self.kind == PLANE
        found = cKDTree(x).query_ball_point(
            middle[~endless], size[~endless] + self.radius[~endless] + margin
        )
        everywhere = [np.arange(len(x))] * int(endless.sum())
        lists = [*map(np.asarray, found), *everywhere]
        numbers = np.concatenate([np.flatnonzero(~endless), np.flatnonzero(endless)])
        node = np.concatenate([np.zeros(0, dtype=np.int64), *lists]).astype(np.int64)
        return node, np.repeat(numbers, [len(each) for each in lists])

    def _lever(self, position: Floats, node: Indices, shape: Indices) -> Floats:
        """Return how much further than its points a plane goes where nodes are, turning."""
        lever = np.zeros(len(node))
        flat = self.kind[shape] == PLANE
        point, ahead = position[self.points[shape[flat], :2]].swapaxes(0, 1)
        away = np.linalg.norm(position[self.nodes[node[flat]]] - point, axis=1)
        lever[flat] = away / np.linalg.norm(ahead - point, axis=1)
        return lever

    def _allowed(self, node: Indices, shape: Indices) -> Any:
        """Return which pairs may touch: none of a body that is spared, nor of neighbours."""
        here, corners = self.nodes[node][:, None], self.points[shape]
        apart = (corners != here).all(axis=1) & (self.owner[node] != self.spared[shape])
        if len(self.joined):
            size = 1 + int(max(self.nodes.max(), self.points.max()))
            ends = np.sort(self.joined, axis=1).astype(np.int64)
            keys = np.minimum(here, corners) * size + np.maximum(here, corners)
            apart &= ~np.isin(keys, ends[:, 0] * size + ends[:, 1]).any(axis=1)
        return apart

    def places(self, position: Floats, pairs: Pairs) -> Place:
        """Return where the nodes of pairs are in their shapes."""
        x, corners = position[self.nodes[pairs.node]], position[self.points[pairs.shape]]
        kind, radius = self.kind[pairs.shape], self.radius[pairs.shape]
        parts = [np.zeros((len(x), *rest)) for rest in ((), (3,), (), (3,), (3,), (3, 3))]
        for which, look in (
            (CAPSULE, _in_capsule),
            (PLANE, _in_plane),
            (TRIANGLE, _in_triangle),
        ):
            some = kind == which
            if some.any():
                for part, values in zip(
                    parts, look(x[some], corners[some], radius[some]), strict=True
                ):
                    part[some] = values
        return Place(*parts)

    def touches(self, position: Floats, velocity: Floats) -> Touch:
        """Return what shapes do to nodes.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        pairs = self.near(position, 0.0) if self.pairs is None else self.pairs
        place = self.places(position, pairs)
        v, ends = velocity[self.nodes[pairs.node]], velocity[self.points[pairs.shape]]
        sliding = v - np.einsum("np,npk->nk", place.weights, ends)
        # Along the normal exactly as the depth changes, of turning planes as well.
        rate = _dot(place.normal, v) + np.einsum("npk,npk->n", place.pressing, ends)
        sliding += (rate - _dot(place.normal, sliding))[:, None] * place.normal
        factor = np.maximum(1.0 - self.damping * rate, 0.0)
        return Touch(pairs, place, sliding, rate, self.pressure(place.depth) * factor)

    def pressure(self, depth: Floats) -> Floats:
        """Return k φ(δ) [N]."""
        w, d = self.layer, np.maximum(depth, 0.0)
        return self.stiffness * np.where(d < w, d * d / (2.0 * w), d - 0.5 * w)

    def steepness(self, depth: Floats) -> Floats:
        """Return k φ'(δ) [N/m]."""
        return self.stiffness * np.clip(depth / self.layer, 0.0, 1.0)

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the energy of all pressed contacts [J], shape (…).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        total = np.zeros(position.shape[:-2])
        for state in np.ndindex(total.shape):
            place = self.touches(position[state], np.zeros_like(position[state])).place
            w, d = self.layer, np.maximum(place.depth, 0.0)
            deep = 0.5 * d * (d - w) + w * w / 6.0
            total[state] = self.stiffness * np.where(d < w, d**3 / (6.0 * w), deep).sum()
        return total

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""
        for state in np.ndindex(position.shape[:-2]):
            self.push(
                self.touches(position[state], velocity[state]), velocity[state], to[state]
            )

    def push(self, touch: Touch, velocity: Floats, to: Floats) -> None:
        """Add the forces of one state on all nodes [N], shape (node, 3)."""
        rub = self._rub(touch, velocity)
        pressed = touch.pressure[:, None] * touch.place.normal
        np.add.at(to, self.nodes[touch.pairs.node], pressed + rub)
        back = touch.pressure[:, None, None] * touch.place.pressing
        back -= touch.place.weights[:, :, None] * rub[:, None, :]
        np.add.at(to, self.points[touch.pairs.shape], back)

    def dissipated(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the power that damping and friction take out [W], shape (…)."""
        power = np.zeros(position.shape[:-2])
        for state in np.ndindex(power.shape):
            touch = self.touches(position[state], velocity[state])
            power[state] = self.loss(touch, velocity[state])
        return power

    def loss(self, touch: Touch, velocity: Floats) -> float:
        """Return the power that damping and friction take out of one state [W]."""
        damped = (self.pressure(touch.place.depth) - touch.pressure) * touch.rate
        return float((damped - _dot(self._rub(touch, velocity), touch.sliding)).sum())

    def bends(self, touch: Touch) -> int:
        """Return how many bends of their law all pressures together have passed."""
        depth = touch.place.depth
        return int((depth > 0.0).sum() + (depth >= self.layer).sum())

    def bristle_rates(self, touch: Touch, velocity: Floats) -> Floats:
        """Return the rates of the velocities of ``memory`` [m/s²], shape (m, 3).

        Args:
            velocity: Of all nodes [m/s], shape (node, 3).
        """
        total, slide = self._total(touch), np.zeros((len(self.nodes), 3))
        along = _along(touch.sliding, touch.place.normal)
        np.add.at(slide, touch.pairs.node, touch.pressure[:, None] * along)
        u = slide / np.where(total > 0.0, total, 1.0)[:, None]
        z = velocity[self.memory] / self.rate
        length = np.linalg.norm(z, axis=1)
        e = z / np.where(length > 0.0, length, 1.0)[:, None]
        least = LEAST * self.friction * self.stiffness * self.layer
        r = np.minimum(self.stiffness * length / (self.friction * total + least), LARGEST)
        slip = np.maximum(_dot(u, e), 0.0) * r**SHARPNESS
        lifted = np.exp(-total / (LEAST * self.stiffness * self.layer))[:, None]
        bent = (1.0 - lifted) * (u - slip[:, None] * e) - lifted * self.rate * z
        return self.rate * bent

    def _rub(self, touch: Touch, velocity: Floats) -> Floats:
        """Return the friction of each pair on its node [N], shape (pair, 3).

        Shapes share the force of the bristle as they press, each along its own surface: so
        none does more than Coulomb's law allows, nor pulls along its normal.
        """
        if not len(self.memory):
            return np.zeros_like(touch.sliding)
        total, z = self._total(touch), velocity[self.memory] / self.rate
        wish, limit = self.stiffness * np.linalg.norm(z, axis=1), self.friction * total
        bears = np.where(wish > limit, limit / np.where(wish > 0.0, wish, 1.0), 1.0)
        pull = -self.stiffness * bears[:, None] * z
        share = touch.pressure / np.where(total > 0.0, total, 1.0)[touch.pairs.node]
        return share[:, None] * _along(pull[touch.pairs.node], touch.place.normal)

    def _total(self, touch: Touch) -> Floats:
        """Return the pressure of all shapes together on each node [N], shape (m,)."""
        total = np.bincount(touch.pairs.node, touch.pressure, len(self.nodes))
        return total.astype(float, copy=False)  # without pairs NumPy counts in integers

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return the stiffness of pressed contacts [N/m] among the nodes that may move.

        Args:
            number: Of each node of the scene among those that may move, -1 for others.
            size: How many may move; the matrix is of shape (3 size, 3 size).
            exact: Whether round shapes weaken it, as what rolls off them; otherwise it is
                positive semidefinite. Where the nearest point lies is taken as fixed in it.
        """
        from scipy.sparse import coo_matrix

        pairs, place = self._pressed(position)
        block = self.steepness(place.depth)[:, None, None] * _square(place.normal)
        if exact:
            around = np.eye(3) - _square(place.normal) - _square(place.line)
            block -= (self.pressure(place.depth) * place.curvature)[:, None, None] * around
        shares = np.concatenate([np.ones((len(block), 1)), -place.weights], axis=1)
        here = np.concatenate([self.nodes[pairs.node][:, None], self.points[pairs.shape]], 1)
        values = np.einsum("na,nb,nij->naibj", shares, shares, block)
        rows = 3 * number[here][:, :, None] + np.arange(3)
        every = rows.reshape(len(rows), 12)
        row = np.broadcast_to(every[:, :, None], (len(rows), 12, 12))
        column = np.broadcast_to(every[:, None, :], row.shape)
        moves = (row >= 0) & (column >= 0)
        entries = values.reshape(row.shape)[moves], (row[moves], column[moves])
        return coo_matrix(entries, shape=(3 * size, 3 * size))

    def _pressed(self, position: Floats) -> tuple[Pairs, Place]:
        touch = self.touches(position, np.zeros_like(position))
        return touch.pairs, touch.place

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        size = float(np.abs(position).max(initial=0.0))
        return size * float(self.pressure(self._pressed(position)[1].depth).sum())

    def noise(self, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        return self.stiffness * float(np.abs(position).max(initial=0.0))

    def weakening(self, time: float, position: Floats, number: Indices, size: int) -> float:
        """Return how far below zero round shapes may bring an eigenvalue [N/m]."""
        pairs, place = self._pressed(position)
        total = np.zeros(len(position))
        each = 2.0 * self.pressure(place.depth) * place.curvature
        np.add.at(total, self.nodes[pairs.node], each)
        np.add.at(total, self.points[pairs.shape], each[:, None] * place.weights)
        return float(total.max(initial=0.0))

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that is put in beside that of moving nodes [W]: none."""
        return 0.0


def _dot(one: Floats, two: Floats) -> Floats:
    return np.einsum("...k,...k->...", one, two)


def _along(vector: Floats, normal: Floats) -> Floats:
    """Return the part of vectors along a surface."""
    return vector - _dot(vector, normal)[:, None] * normal


def _square(vector: Floats) -> Floats:
    return vector[:, :, None] * vector[:, None, :]


def _from_point(r: Floats, radius: Floats, weights: Floats, line: Floats) -> Iterator[Floats]:
    """Yield the parts of a place from the vector that leads from the nearest point [m]."""
    distance = np.linalg.norm(r, axis=1)
    # On the point itself there is no direction out of it, and so no force.
    inverse = np.where(distance > 0.0, 1.0 / np.where(distance > 0.0, distance, 1.0), 0.0)
    normal = r * inverse[:, None]
    yield radius - distance
    yield normal
    yield inverse
    yield line
    yield weights
    yield -weights[:, :, None] * normal[:, None, :]


def _in_capsule(x: Floats, corners: Floats, radius: Floats) -> Iterator[Floats]:
    p, d = corners[:, 0], corners[:, 1] - corners[:, 0]
    square = _dot(d, d)
    flat = np.where(square > 0.0, square, 1.0)
    s = np.clip(_dot(x - p, d) / flat, 0.0, 1.0)
    inside = ((s > 0.0) & (s < 1.0))[:, None]
    line = np.where(inside, d / np.sqrt(flat)[:, None], 0.0)
    weights = np.stack([1.0 - s, s, np.zeros_like(s)], axis=1)
    return _from_point(x - p - s[:, None] * d, radius, weights, line)


def _in_plane(x: Floats, corners: Floats, radius: Floats) -> Iterator[Floats]:
    p, d = corners[:, 0], corners[:, 1] - corners[:, 0]
    length = np.linalg.norm(d, axis=1)[:, None]
    normal = d / length
    depth = -_dot(normal, x - p)
    # Force and place on the plane make a moment, which its second point takes up.
    lever = (x - p + depth[:, None] * normal) / length
    none = np.zeros_like(x)
    yield depth
    yield normal
    yield none[:, 0]
    yield none
    yield np.broadcast_to([1.0, 0.0, 0.0], x.shape)
    yield np.stack([-normal - lever, lever, none], axis=1)


def _in_triangle(x: Floats, corners: Floats, radius: Floats) -> Iterator[Floats]:
    """Look from the nearest of the face and the three edges."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, ac, ax = b - a, c - a, x - a
    d00, d01, d11 = _dot(ab, ab), _dot(ab, ac), _dot(ac, ac)
    d20, d21 = _dot(ax, ab), _dot(ax, ac)
    area = d00 * d11 - d01 * d01
    flat = np.where(area > 0.0, area, 1.0)
    v, w = (d11 * d20 - d01 * d21) / flat, (d00 * d21 - d01 * d20) / flat
    weights = np.stack([1.0 - v - w, v, w], axis=1)
    on_face = (area > 0.0) & (weights >= 0.0).all(axis=1)
    nearest = np.where(on_face, 0.0, np.inf)
    line = np.zeros_like(x)
    for i in range(3):
        j = (i + 1) % 3
        p, d = corners[:, i], corners[:, j] - corners[:, i]
        square = _dot(d, d)
        s = np.clip(_dot(x - p, d) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        apart = np.linalg.norm(x - p - s[:, None] * d, axis=1)
        takes = apart < nearest
        nearest = np.where(takes, apart, nearest)
        edge = np.zeros_like(weights)
        edge[:, i], edge[:, j] = 1.0 - s, s
        weights = np.where(takes[:, None], edge, weights)
        along = np.where(((s > 0.0) & (s < 1.0))[:, None], d, 0.0)
        length = np.linalg.norm(along, axis=1)[:, None]
        line = np.where(takes[:, None], along / np.where(length > 0.0, length, 1.0), line)
    parts = list(
        _from_point(x - np.einsum("np,npk->nk", weights, corners), radius, weights, line)
    )
    parts[2] = np.where(on_face, 0.0, parts[2])  # above a face nothing is curved
    return iter(parts)
