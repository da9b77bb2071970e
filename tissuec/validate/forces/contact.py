"""Forces of shapes on nodes in contact: pressure, contact damping and friction.

The formulas are those of docs/numerics.md, "Contact", with its symbols. The pairs of nodes and
shapes that are near, and their weights, are given; the positions of nodes in shapes are found
here. Points between nodes are x_q = Σ N_a x_a, by a matrix N; a force f on them acts on nodes
as Nᵀ f.
"""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, identity, vstack

from tissuec.core.arrays import cross
from tissuec.geometry.nearest import CAPSULE, PLANE, TRIANGLE

if TYPE_CHECKING:
    from tissuec.forces.contact.contact import Contact
    from tissuec.forces.contact.pairs import ContactPairs

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

TORN = 2  # of ``ContactPairs.sided``
OVER = 1.0 + 1e-9  # times its length: a bristle that is as long as G/k but for rounding


class Touching(Struct, frozen=True):
    """Forces of contact in one state.

    Attributes:
        force: On all nodes [N], shape (node, 3).
        lost: Power that damping and friction take out [W].
        bristle_rates: Of the velocities that are bristles [m/s²], shape (m, 3).
        ahead: Rates u·e - (G/k)' at which bristles of faces would become too long unless they
            slip [m/s], shape (m,).
        grip: Largest friction G of each [N], shape (m,).
    """

    force: Floats
    lost: float
    bristle_rates: Floats
    ahead: Floats
    grip: Floats


class ContactForce:
    """Contact as a force of positions, velocities and bristles.

    Args:
        contact: Read for its nodes, shapes and numbers.
        is_located: Whether bristles of faces stick or slip until ``slip``, as the caller finds
            out when they change; else they slip as soon as they are long, within a step.

    Attributes:
        slides: Which bristles of faces slip, shape (m,).
    """

    def __init__(self, contact: "Contact", *, is_located: bool = False):
        self._of, self._is_located = contact, is_located
        self._map: csr_matrix | None = None
        self.slides = np.zeros(len(contact.memory), dtype=bool)

    def _to_points(self, nodes: int) -> "csr_matrix | None":
        """Return the matrix of nodes and points by nodes; None without points."""
        if (points := self._of.between) is not None and self._map is None:
            count = len(points.corners)
            rows = np.repeat(np.arange(count), 3), points.corners.ravel()
            own = csr_matrix((points.shares.ravel(), rows), shape=(count, nodes))
            self._map = csr_matrix(vstack([identity(nodes), own]))
        return self._map

    def energy(self, position: Floats, pairs: "ContactPairs") -> float:
        """Return Σ W k ∫ φ dδ [J].

        Args:
            position: Of all nodes [m], shape (node, 3).
            pairs: Nodes and shapes that are near.
        """
        k, w = self._of.stiffness, self._of.layer
        if (points := self._to_points(len(position))) is not None:
            position = points @ position
        touched = _Touched(self._of, position, pairs)
        shallow, over = np.minimum(touched.depth, w), np.maximum(touched.depth - w, 0.0)
        deep = shallow**3 / (6.0 * w) + 0.5 * over * (over + w)
        return float(touched.weight @ (k[touched.node] * deep))

    def at(self, position: Floats, velocity: Floats, pairs: "ContactPairs") -> Touching:
        """Return the touching points and their forces.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
            pairs: All that may touch.
        """
        of, points, bent = self._of, self._to_points(len(position)), velocity[self._of.memory]
        if points is not None:
            position, velocity = points @ position, points @ velocity[: len(position)]
        force = np.zeros_like(position)
        touched = _Touched(of, position, pairs)
        deepening = touched.deepening(velocity)
        closing = touched.by_surface(touched.pressure * deepening) / _divisor(touched.surface)
        factor = np.maximum(0.0, 1.0 + of.damping * closing)
        touched.press(factor, force)
        spent = (factor - 1.0) * touched.by_surface(touched.pressure * deepening)
        lost, rates = float(spent.sum()), np.zeros((len(of.memory), 3))
        ahead, grip = np.zeros(len(rates)), np.zeros(len(rates))
        if len(rates):
            most = touched.friction * factor[touched.group] * touched.pressure  # G of each
            grip = _sums(touched.node_of_surface, touched.whole(most), len(of.nodes))
            lost += self._rub(
                touched, deepening, factor, velocity, bent, most, grip, force, rates, ahead
            )
        acting = force if points is None else points.T @ force
        return Touching(acting, lost, rates, ahead, grip)

    def _rub(
        self, touched: "_Touched", deepening: Floats, factor: Floats, velocity: Floats,
        bent: Floats, most: Floats, grip: Floats, force: Floats, rates: Floats, ahead: Floats,
    ) -> float:  # fmt: skip
        """Add the forces of friction, set the rates of bristles; return the power lost [W].

        ``bent`` are the velocities that are bristles [m/s], shape (m, 3). Sets ``ahead``, too.
        """
        of = self._of
        k, w, count = of.stiffness, of.layer, len(of.nodes)
        pressed = _sums(touched.node_of_surface, factor * touched.surface, count)  # N
        rest = _sums(touched.node_of_surface, touched.surface, count)  # N0
        rubs = grip > 0.0
        part = most / _divisor(grip)[touched.node]
        turning = _Turning(touched, most)
        slide = part[:, None] * touched.along(turning.sliding(velocity))
        u = np.stack([_sums(touched.node, each, count) for each in slide.T], axis=1)
        slope = touched.weight * k[touched.node] * np.minimum(touched.depth / w, 1.0)
        growth = _sums(touched.node, slope * deepening, count) / (rest + k * w / 2000.0)
        growth *= 0.5 * w / (rest / k + 0.5 * w)  # g
        z = bent / of.rate
        if of.between is not None:
            way = np.where(rubs, np.minimum(1.0, 2.0 * pressed / (k * w)), 0.0)[:, None] * u
            size = np.sqrt((z * z).sum(axis=1))
            unit = z / _divisor(size)[:, None]
            rising = touched.friction * factor[touched.group] * slope * deepening
            longer = _sums(touched.node, rising, count) / k  # (G/k)'
            along = (way * unit).sum(axis=1)
            ahead[:] = along - longer
            bears = grip / _divisor(size)
            if self._is_located:
                turns = np.where(rubs, k / _divisor(bears), 0.0)[:, None]
                slid = turns * (way - along[:, None] * unit) + longer[:, None] * unit
                rates[:] = of.rate * np.where(self.slides[:, None], slid, way)
                # What sticks bears no more than G; steps that are tried lead a little beyond.
                bears = np.where(self.slides, bears, np.minimum(k, 2.0 * bears))
            else:
                slips = np.where(self.slides, np.maximum(0.0, ahead), 0.0)
                rates[:] = of.rate * (way - slips[:, None] * unit)
                bears = np.where(slips > 0.0, bears, np.minimum(k, bears))
            pull = -bears[:, None] * z
            turning.drag(part[:, None] * touched.along(pull[touched.node]), force)
            return -float((pull * u).sum())
        depth = pressed / k + 0.5 * w
        size = np.sqrt((z * z).sum(axis=1))
        ratio = size / np.where(rubs, grip / _divisor(pressed) * depth, np.inf)  # r
        unit = z / _divisor(size)[:, None]
        way = u - 0.5 * growth[:, None] * z  # d
        slips = np.maximum(0.0, (way * unit).sum(axis=1)) * np.minimum(ratio, 2.0) ** 8
        stands = -of.rate * z
        rates[:] = of.rate * np.where(rubs[:, None], way - slips[:, None] * unit, stands)
        bears = np.where(rubs, pressed / depth / np.maximum(ratio, 1.0), 0.0)
        pull = -bears[:, None] * z
        turning.drag(part[:, None] * touched.along(pull[touched.node]), force)
        return -float((pull * u).sum())

    def slip(self, position: Floats, velocity: Floats, pairs: "ContactPairs") -> None:
        """Cut bristles of faces to the length G/k at which they slip, and set which do.

        Args:
            position: Of all nodes [m], shape (node, 3).
            velocity: Of all nodes, changed in place [m/s], shape (node, 3).
            pairs: All that may touch.
        """
        found, most, size = self._lengths(position, velocity, pairs)
        onwards = found.ahead >= 0.0
        slips = (most > 0.0) & (size > 0.0) & ((OVER * size >= most) | (self.slides & onwards))
        if self._is_located:
            slips &= onwards
        self._cut(velocity, slips, np.where(slips, most, np.minimum(size, most)), size)

    def change(
        self,
        position: Floats,
        velocity: Floats,
        pairs: "ContactPairs",
        changed: NDArray[np.bool_],
    ) -> None:
        """Let some bristles that stick slip, and some that slip stick, from a length of G/k.

        Args:
            position: Of all nodes [m], shape (node, 3).
            velocity: Of all nodes with bristles [m/s], changed in place, shape (node, 3).
            pairs: All that may touch.
            changed: Which ones, shape (m,).
        """
        _, most, size = self._lengths(position, velocity, pairs)
        length = np.where(self.slides | changed, most, np.minimum(size, most))
        self._cut(velocity, (self.slides ^ changed) & (length > 0.0), length, size)

    def _lengths(
        self, position: Floats, velocity: Floats, pairs: "ContactPairs"
    ) -> tuple[Touching, Floats, Floats]:
        """Return the contact, and the largest and current velocities of bristles [m/s]."""
        of, found = self._of, self.at(position, velocity, pairs)
        size = np.sqrt((velocity[of.memory] ** 2).sum(axis=1))
        return found, of.rate * found.grip / of.stiffness, size

    def _cut(
        self, velocity: Floats, slips: NDArray[np.bool_], length: Floats, size: Floats
    ) -> None:
        self.slides = slips
        velocity[self._of.memory] *= (length / _divisor(size))[:, None]


class _Touched:
    """The elements that touch a node, those of one node and one surface together.

    Attributes:
        node: Number among the nodes of the contact, shape (touch,).
        group: Number of node and surface together, shape (touch,).
        node_of_surface: ``node`` of each of these, shape (group,).
        at: Number of the node in the scene, shape (touch,).
        kind, carriers: Of the element, shapes (touch,) and (touch, 3).
        weight: W.
        share: w of the carriers, shape (touch, 3).
        depth: δ [m].
        normal: n.
        arm: x - p [m], shape (touch, 3).
        ahead: From the first to the second carrier [m], shape (touch, 3).
        corners: Places of the carriers [m], shape (touch, 3, 3).
        pressure: W P [N].
        friction: μ, the smaller one of the node and of its place on the element.
        surface: P_S [N], shape (group,).
    """

    def __init__(self, of: "Contact", position: Floats, pairs: "ContactPairs"):
        x, carriers = position[of.nodes[pairs.node]], of.points[pairs.shape]
        corners, kind = position[carriers], of.kind[pairs.shape]
        share = np.zeros((len(x), 3))
        share[:, 0] = 1.0  # of a plane
        for which in (CAPSULE, TRIANGLE):
            some = np.flatnonzero(kind == which)
            if not len(some):
                continue
            share[some] = nearest(x[some], corners[some, : 2 if which == CAPSULE else 3])
        arm = x - np.einsum("ta,tak->tk", share, corners)
        ahead = corners[:, 1] - corners[:, 0]
        plane = kind == PLANE
        normal = _unit(np.where(plane[:, None], ahead, arm))
        depth: Floats = np.where(plane, 0.0, pairs.radius) - (normal * arm).sum(axis=1)
        if pairs.sided.any():
            _turn_out(of, position, pairs, share, arm, normal, depth)
        inside = depth > 0.0
        self.node, self.kind, self.weight = (
            pairs.node[inside],
            kind[inside],
            pairs.weight[inside],
        )
        self.carriers, self.corners, self.share = (
            carriers[inside],
            corners[inside],
            share[inside],
        )
        self.normal, self.depth, self.ahead = normal[inside], depth[inside], ahead[inside]
        # The place on a plane is straight below the node; what carries it is elsewhere.
        self.off = arm[inside]
        self.arm: Floats = np.where(
            plane[inside, None], -self.depth[:, None] * self.normal, self.off
        )
        self.at = of.nodes[self.node]
        if of.friction is None:
            there = (self.share * of.face_friction[pairs.shape[inside]]).sum(axis=1)
            self.friction = np.minimum(of.node_friction[self.node], there)
        else:
            self.friction = np.full(len(self.node), of.friction)
        surface = of.surface[pairs.shape[inside]]
        many = int(surface.max(initial=0)) + 1
        distinct, self.group = np.unique(self.node * many + surface, return_inverse=True)
        self.node_of_surface = distinct // many
        k, w = of.stiffness, of.layer
        shallow = self.depth < w
        soft: Floats = self.depth**2 / (2.0 * w)
        each: Floats = np.where(shallow, soft, self.depth - 0.5 * w)
        self.pressure = self.weight * k[self.node] * each
        self.surface = self.whole(self.pressure)

    def by_surface(self, values: Floats) -> Floats:
        """Return the sums over the elements of each surface at each node, shape (group,)."""
        return _sums(self.group, values, len(self.node_of_surface))

    def whole(self, values: Floats) -> Floats:
        """Return the same, but no less than the largest one of an element, shape (group,)."""
        largest = np.zeros(len(self.node_of_surface))
        np.maximum.at(largest, self.group, values)
        return np.maximum(self.by_surface(values), largest)

    def along(self, vectors: Floats) -> Floats:
        """Return the parts of vectors along the surface, shape (touch, 3)."""
        return _across(vectors, self.normal)

    def deepening(self, velocity: Floats) -> Floats:
        """Return δ' [m/s]."""
        ends = velocity[self.carriers]
        there = np.einsum("ta,tak->tk", self.share, ends)
        rate = -(self.normal * (velocity[self.at] - there)).sum(axis=1)
        plane = self.kind == PLANE
        # n' of a plane by that of b - a.
        turn = _across(ends[plane, 1] - ends[plane, 0], self.normal[plane])
        turn /= np.linalg.norm(self.ahead[plane], axis=1)[:, None]
        rate[plane] -= (turn * self.off[plane]).sum(axis=1)
        return rate

    def press(self, factor: Floats, force: Floats) -> None:
        """Add the forces of pressure [N], minus the derivatives of the energy times c."""
        push = (factor[self.group] * self.pressure)[:, None] * self.normal
        np.add.at(force, self.at, push)
        self.carry(push, force)
        plane = self.kind == PLANE
        lever = _across(self.off[plane], self.normal[plane])
        lever /= np.linalg.norm(self.ahead[plane], axis=1)[:, None]
        couple = (factor[self.group] * self.pressure)[plane, None] * lever
        np.add.at(force, self.carriers[plane, 0], -couple)
        np.add.at(force, self.carriers[plane, 1], couple)

    def carry(self, push: Floats, force: Floats) -> None:
        """Take forces on nodes [N], shape (touch, 3), from what carries the elements."""
        np.add.at(force, self.carriers, -self.share[:, :, None] * push[:, None, :])


class _Turning:
    """How the elements of a surface turn, and take up couples.

    Args:
        touched: The elements.
        most: Largest friction of each [N], shape (touch,).
    """

    def __init__(self, touched: _Touched, most: Floats):
        count = np.where(touched.kind == CAPSULE, 2.0, 3.0)[:, None]
        there = (np.arange(3) < count)[:, :, None]
        middle = (touched.corners * there).sum(axis=1) / count
        self._arm = (touched.corners - middle[:, None]) * there
        square: Floats = (self._arm**2).sum(axis=(1, 2))
        twice: Floats = np.linalg.norm(cross(self._arm[:, 0], self._arm[:, 1]), axis=1)
        # Neither a point nor a triangle without area.
        size: Floats = np.where(touched.kind == CAPSULE, square, twice)
        wide = size > 1e-6 * square
        takes = wide & (touched.weight > 0.0) & (touched.kind != PLANE)
        outer = np.einsum("tai,taj->tij", self._arm, self._arm)
        inertia = square[:, None, None] * np.eye(3) - outer
        self._inverse = np.zeros_like(inertia)
        if takes.any():
            self._inverse[takes] = np.linalg.pinv(inertia[takes], rcond=1e-12, hermitian=True)
        shares = most * takes
        self._share = shares / _divisor(touched.by_surface(shares))[touched.group]
        self._touched = touched

    def sliding(self, velocity: Floats) -> Floats:
        """Return s [m/s], shape (touch, 3)."""
        touched, ends = self._touched, velocity[self._touched.carriers]
        spins = np.einsum("tij,tj->ti", self._inverse, cross(self._arm, ends).sum(axis=1))
        spin = self._added(self._share[:, None] * spins)
        there = np.einsum("ta,tak->tk", touched.share, ends)
        return velocity[touched.at] - there - cross(spin, touched.arm)

    def drag(self, drags: Floats, force: Floats) -> None:
        """Add forces along the surface on nodes [N], shape (touch, 3), and their reactions."""
        touched = self._touched
        np.add.at(force, touched.at, drags)
        touched.carry(drags, force)
        couple = self._added(-cross(touched.arm, drags))
        turned = self._share[:, None] * np.einsum("tij,tj->ti", self._inverse, couple)
        np.add.at(force, touched.carriers, cross(turned[:, None], self._arm))

    def _added(self, vectors: Floats) -> Floats:
        """Return the sum over the surface of each element, shape (touch, 3)."""
        of = self._touched
        sums = np.stack([of.by_surface(each) for each in vectors.T], axis=1)
        return sums[of.group]


def _turn_out(
    of: "Contact", position: Floats, pairs: "ContactPairs", share: Floats, arm: Floats,
    normal: Floats, depth: Floats,
) -> None:  # fmt: skip
    """Change normals and depths where points are inside of what keeps them outside.

    Where the surface has a hole, nothing is inside whose nearest place is on the rim: on an
    edge of one triangle only.

    Args:
        position: Of all nodes and points [m], shape (n, 3).
        pairs: All that may touch.
        share: w of the carriers, shape (pair, 3).
        arm: x - p [m], shape (pair, 3).
        normal: n, changed in place, shape (pair, 3).
        depth: δ, changed in place [m], shape (pair,).
    """
    away = np.linalg.norm(arm, axis=1)
    faces, close = np.arange(len(of.radius)), 1e-11 * of.stride
    decides = pairs.sided > 0
    for surface in np.unique(of.surface[pairs.shape[decides]]):
        skin = of.points[faces[(of.surface[faces] == surface) & (of.kind[faces] == TRIANGLE)]]
        rows = np.flatnonzero(decides & (of.surface[pairs.shape] == surface))
        least = np.full(len(of.nodes), np.inf)
        np.minimum.at(least, pairs.node[rows], away[rows])
        # Faces with a side in common are equally far away but for rounding: the first counts.
        rows = rows[away[rows] <= least[pairs.node[rows]] + close]
        _, first, count = np.unique(pairs.node[rows], return_index=True, return_counts=True)
        rows = rows[first]
        on_rim = (pairs.sided[rows] == TORN) & (count == 1) & (share[rows].min(axis=1) <= 1e-9)
        rows = rows[~on_rim]
        # Seen from a place in a plane of symmetry, half of what is around it is missing.
        angle = solid_angles(position[of.nodes[pairs.node[rows]]], position[skin])
        rows = rows[angle > np.pi]
        normal[rows] *= -1.0
        depth[rows] = pairs.radius[rows] + away[rows]


def solid_angles(x: Floats, corners: Floats) -> Floats:
    """Return the solid angles that a surface spans as seen from points, shape (n,).

    It is 4π inside of a closed surface and 0 outside. By E. Eriksson, Math. Mag. 63:184 (1990).

    Args:
        x: Points [m], shape (n, 3).
        corners: Of the triangles of the surface [m], shape (triangle, 3, 3).
    """
    a, b, c = (_unit(corners[None, :, i] - x[:, None]) for i in range(3))
    volume = (a * cross(b, c)).sum(axis=-1)
    rest = 1.0 + (a * b).sum(axis=-1) + (b * c).sum(axis=-1) + (c * a).sum(axis=-1)
    return 2.0 * np.arctan2(volume, rest).sum(axis=1)


def nearest(x: Floats, corners: Floats) -> Floats:
    """Return barycentric weights of the nearest points of lines or triangles, shape (n, 3).

    Args:
        x: Points [m], shape (n, 3).
        corners: [m], shape (n, 2, 3) or (n, 3, 3).
    """
    found, least = np.zeros((len(x), 3)), np.full(len(x), np.inf)
    count = corners.shape[1]
    for i in range(count if count == 3 else 1):
        j = (i + 1) % count
        start, along = corners[:, i], corners[:, j] - corners[:, i]
        part = ((x - start) * along).sum(axis=1) / _divisor((along**2).sum(axis=1))
        part = np.minimum(np.maximum(part, 0.0), 1.0)
        away = np.linalg.norm(x - start - part[:, None] * along, axis=1)
        nearer = away < least
        least[nearer] = away[nearer]
        found[nearer] = 0.0
        found[nearer, i], found[nearer, j] = 1.0 - part[nearer], part[nearer]
    if count == 3:
        # By the areas that a point above the face spans with its edges.
        normal = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        square = (normal**2).sum(axis=1)
        to = corners - x[:, None]
        areas = [cross(to[:, (a + 1) % 3], to[:, (a + 2) % 3]) for a in range(3)]
        inner = np.stack([(area * normal).sum(axis=1) for area in areas], axis=1)
        above = (square > 0.0) & (inner >= 0.0).all(axis=1)
        found[above] = inner[above] / square[above, None]
    return found


def _sums(rows: Indices, values: Floats, count: int) -> Floats:
    """Return the sums of values by rows, shape (count,)."""
    return np.bincount(rows, values, count).astype(float)


def _divisor(values: Floats) -> Floats:
    """Return values that are above zero, and 1 for others."""
    return np.where(values > 0.0, values, 1.0)


def _unit(vectors: Floats) -> Floats:
    """Return unit vectors; on a point itself there is no direction, and so no force."""
    return vectors / _divisor(np.linalg.norm(vectors, axis=-1))[..., None]


def _across(vectors: Floats, normal: Floats) -> Floats:
    return vectors - (vectors * normal).sum(axis=1)[:, None] * normal
