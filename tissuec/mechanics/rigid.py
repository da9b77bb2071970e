"""Rigid motions that cost a net no energy, so that its rest position is not unique.

A piece of the net that nobody holds, or that is held in one point or along one line only, moves
as a whole without any change of its springs. Loads p that do not follow it do the work
Σ p · (v + ω × x) along a twist (v, ω), which changes along another one (v', ω') by

    Σ p · (ω × (v' + ω' × x)).

A motion is neutral where both vanish, the second for all other motions of the piece. Neutral
motions are taken out of the steps, and in the end each piece is put back along them: to where
Σ m |x - x₀|² is least (W. Kabsch, Acta Cryst. A32:922, 1976), so that the centre of mass of a
free body is where it was, whatever the way that the steps went.
"""

import itertools
from functools import cached_property
from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy.linalg import qr
from scipy.sparse import csc_matrix, csr_matrix, diags_array

from tissuec.core import arrays
from tissuec.core.structs import replace
from tissuec.mechanics.balance import Balance
from tissuec.model.network import Floats, Indices

INDEPENDENT = 1e-6  # singular values below it, of twists in units of the piece, are zero
NEUTRAL = 1e-10  # variations of the work below it, relative to the load and the size, are none


class RigidPiece(Struct, frozen=True, eq=False):
    """Free nodes that springs join, and the fixed nodes next to them.

    Attributes:
        nodes: Numbers among the free nodes, ascending, shape (n,).
        anchors: Nodes of the scene that stay and that springs or contact join to these.
    """

    nodes: Indices
    anchors: NDArray[np.integer]

    @property
    def unknowns(self) -> Indices:
        """Return where the coordinates of its nodes are among those of all, shape (3 n,)."""
        return arrays.unknowns(self.nodes)


class Freedom(Struct, frozen=True, eq=False):
    """Rigid motions of a piece that cost no energy.

    Attributes:
        piece: Which.
        pivot: Where it is held [m], shape (3,); None where nothing holds it.
        axes: Orthonormal directions about which it can turn, shape (3, 0), (3, 1) or (3, 3).
        within: Projection of its shift into the planes of symmetry that it is on, shape (3, 3).
        motion: All of it, orthonormal in the masses [kg^-½], shape (3 n, motion).
    """

    piece: RigidPiece
    pivot: Floats | None
    axes: Floats
    within: Floats
    motion: Floats

    @property
    def is_on_plane(self) -> bool:
        """Return whether a plane of symmetry keeps it from some shifts."""
        return bool(np.trace(self.within) < 2.5)

    def restored(self, x: Floats, start: Floats, mass: Floats) -> Floats:
        """Return the nodes moved as a rigid body, as close to their start as possible [m].

        Args:
            x: Positions of the nodes [m], shape (n, 3).
            start: Positions at the start [m], shape (n, 3).
            mass: Weights of the distances [kg], shape (n,).
        """
        if self.pivot is None:
            after = mass @ x / mass.sum()
            before = after + self.within @ (mass @ start / mass.sum() - after)
        else:
            before = after = self.pivot
        from scipy.spatial.transform import Rotation  # it takes a while to import

        arm: Floats = x - after
        other = start - before
        if self.axes.shape[1] == 3:
            turn = Rotation.align_vectors(other, arm, weights=mass)[0]
            arm = turn.apply(arm)
        elif self.axes.shape[1] == 1:
            axis = self.axes[:, 0]
            sine = mass @ (np.cross(arm, other) @ axis)
            cosine = mass @ ((arm * other).sum(axis=1) - (arm @ axis) * (other @ axis))
            arm = Rotation.from_rotvec(np.arctan2(sine, cosine) * axis).apply(arm)
        return before + arm


def pieces(balance: Balance, *, lone: bool = False) -> tuple[RigidPiece, ...]:
    """Return the pieces of the free nodes.

    Args:
        lone: Whether a node without springs that act is a piece, too.
    """
    free, outer = balance.link_ends >= 0, balance.links
    inner, labels = free.all(axis=1), balance.labels
    to_anchor = free.any(axis=1) & ~inner
    beside = labels[balance.link_ends[to_anchor].max(axis=1)]
    anchors = outer[to_anchor][~free[to_anchor]]
    joined = np.full(len(labels), lone)
    joined[balance.link_ends[free]] = True
    order = np.argsort(labels, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)
    return tuple(
        RigidPiece(nodes, np.unique(anchors[beside == labels[nodes[0]]]).astype(np.int64))
        for nodes in groups
        if joined[nodes[0]]
    )


class NeutralMotions:
    """The rigid motions of a net that cost no energy where it is.

    Attributes:
        freedoms: Of the pieces that have any.
    """

    def __init__(self, freedoms: tuple[Freedom, ...], mass: Floats):
        self.freedoms, self._mass = freedoms, mass

    @cached_property
    def basis(self) -> csc_matrix:
        """Return Z, the motions: Zᵀ M Z = 1 [kg^-½], shape (3 free, motion)."""
        return assembled(self.freedoms, len(self._mass))

    @classmethod
    def of(cls, balance: Balance, x: Floats, mass: Floats | None = None) -> Self:
        """Return the neutral motions with the free nodes at given positions.

        Args:
            balance: The free nodes and what acts on them.
            x: Positions of the free nodes [m], shape (free, 3).
            mass: Weights of the motions [kg], shape (free,); the masses of the nodes if None.
        """
        mass = balance.mass if mass is None else mass
        if balance.holds_slides:
            return cls(sliding(balance, x, mass), mass)
        position = balance.bars(x).position
        touched, load, off = (
            balance.touched(position),
            balance.present_load,
            balance.held_directions,
        )
        found = (
            _freedom(
                piece, x[nodes], position[piece.anchors], mass[nodes], off[nodes], load[nodes]
            )
            for piece in pieces(balance)
            for nodes in (piece.nodes,)
            # What presses on a piece resists, or takes part in its motion.
            if not touched[nodes].any()
        )
        return cls(tuple(filter(None, found)), mass)

    def restored(self, x: Floats, start: Floats) -> Floats:
        """Return places with each piece put back along its neutral motions [m], (free, 3).

        Args:
            x: Where the free nodes are [m], shape (free, 3).
            start: Where they were [m], shape (free, 3).
        """
        x = x.copy()
        for freedom in self.freedoms:
            nodes = freedom.piece.nodes
            x[nodes] = freedom.restored(x[nodes], start[nodes], self._mass[nodes])
        return x

    @property
    def count(self) -> int:
        """Return the number of motions."""
        return sum(freedom.motion.shape[1] for freedom in self.freedoms)

    def without(self, step: Floats) -> Floats:
        """Return a step without its part along neutral motions [m], shape (free, 3)."""
        if not self.count:
            return step
        return step - (self.basis @ (self._weighted.T @ step.ravel())).reshape(-1, 3)

    def balanced(self, force: Floats) -> Floats:
        """Return forces without what would move pieces as a whole [N], shape (free, 3)."""
        if not self.count:
            return force
        return force - (self._weighted @ (self.basis.T @ force.ravel())).reshape(-1, 3)

    def supports(self, size: float) -> Floats:
        """Return springs to the ground that just hold each piece [N/m], shape (3 free,).

        On the diagonal of K, they change no solution of K u = F but by a neutral motion if F is
        balanced: each is one of a determinate support, and carries nothing.

        Args:
            size: Of those that are there [N/m].
        """
        held = np.zeros(3 * len(self._mass))
        held[self._supports] = size
        return held

    @cached_property
    def _weighted(self) -> csr_matrix:
        """Return M Z [kg^½], shape (3 free, motion)."""
        return csr_matrix(diags_array(np.repeat(self._mass, 3)) @ self.basis)

    @cached_property
    def _supports(self) -> Indices:
        """Return unknowns that fix all neutral motions, one for each, shape (motion,)."""
        chosen: list[Indices] = []
        for freedom in self.freedoms:
            order = np.asarray(qr(freedom.motion.T, mode="economic", pivoting=True)[-1])
            chosen.append(freedom.piece.unknowns[order[: freedom.motion.shape[1]]])
        return np.concatenate([np.zeros(0, dtype=np.int64), *chosen])


SLIDING = 1e-2  # of the stiffest: motions of a piece that contact resists less than that slide


def sliding(balance: Balance, x: Floats, mass: Floats) -> tuple[Freedom, ...]:
    """Return how pieces that contact alone holds can slide along what they touch.

    These are the rigid motions along which the normals of contact hardly move.

    Args:
        x: Where the free nodes are [m], shape (free, 3).
        mass: Weights of the motions [kg], shape (free,).
    """
    stiffness, off = balance.contact_matrix(x), balance.held_directions
    found: list[Freedom] = []
    for piece in pieces(balance):
        place = x[piece.nodes]
        if len(piece.anchors):
            continue
        none = np.zeros((0, 3))
        rigid = _freedom(piece, place, none, mass[piece.nodes], off[piece.nodes])
        if rigid is None:
            continue
        own = stiffness[piece.unknowns][:, piece.unknowns]
        size, way = np.linalg.eigh(rigid.motion.T @ (own @ rigid.motion))
        slides = way[:, size <= SLIDING * size[-1]]
        if slides.shape[1] and size[-1] > 0.0:
            found.append(replace(rigid, motion=rigid.motion @ slides))
    return tuple(found)


def rigid_motions(balance: Balance, x: Floats) -> tuple[Freedom, ...]:
    """Return how pieces can move as a whole, whatever loads and contact do then.

    Args:
        x: Where the free nodes are [m], shape (free, 3).
    """
    position, off, mass = balance.bars(x).position, balance.held_directions, balance.mass
    found = (
        _freedom(piece, x[nodes], position[piece.anchors], mass[nodes], off[nodes])
        for piece in pieces(balance, lone=True)
        for nodes in (piece.nodes,)
    )
    return tuple(filter(None, found))


def assembled(freedoms: tuple[Freedom, ...], count: int) -> csc_matrix:
    """Return the motions of all pieces side by side, shape (3 count, motion)."""
    rows = [np.repeat(f.piece.unknowns, f.motion.shape[1]) for f in freedoms]
    first = np.cumsum([0, *(f.motion.shape[1] for f in freedoms)])
    columns: list[Indices] = [
        np.tile(np.arange(int(start), int(stop)), 3 * len(f.piece.nodes))
        for f, (start, stop) in zip(freedoms, itertools.pairwise(first.tolist()), strict=True)
    ]
    none = [np.zeros(0, dtype=np.int64)]
    values = np.concatenate([np.zeros(0), *(f.motion.ravel() for f in freedoms)])
    where = np.concatenate([*none, *rows]), np.concatenate([*none, *columns])
    return csc_matrix((values, where), shape=(3 * count, int(first[-1])))


def _freedom(
    piece: RigidPiece,
    x: Floats,
    anchors: Floats,
    mass: Floats,
    off: Floats,
    load: Floats | None = None,
) -> Freedom | None:
    """Return how a piece can move as a whole at no cost, loads included if there are any."""
    twists = _neutral_twists(x, anchors, off, np.zeros_like(x) if load is None else load)
    if not twists.shape[1]:
        return None
    turning = np.linalg.svd(twists[3:], full_matrices=False)
    is_axis = INDEPENDENT * turning.S.max(initial=0.0) < turning.S
    total: Floats = off.sum(axis=0)
    within: Floats = np.eye(3) - np.linalg.pinv(total) @ total
    return Freedom(
        piece,
        anchors[0] if len(anchors) else None,
        turning.U[:, is_axis],
        within,
        _orthonormal(arrays.rigid_motions(x).reshape(-1, 6) @ twists, np.repeat(mass, 3)),
    )


def _neutral_twists(x: Floats, anchors: Floats, off: Floats, load: Floats) -> Floats:
    """Return the twists (v, ω) of a piece that cost no energy, shape (6, motion)."""
    middle = x.mean(axis=0)
    # A single node has no size: its anchors say what is far.
    sizes = (float(np.abs(part - middle).max(initial=0.0)) for part in (x, anchors))
    size = next(filter(None, sizes), 1.0)
    stays = arrays.rigid_motions((anchors - middle) / size).reshape(-1, 6)
    if len(mirrored := np.flatnonzero(off.any(axis=(1, 2)))):
        moves = arrays.rigid_motions((x[mirrored] - middle) / size)
        stays = np.concatenate([stays, (off[mirrored] @ moves).reshape(-1, 6)])
    twists = _null_space(stays, INDEPENDENT)
    if not twists.shape[1]:
        return twists
    # What does not move the piece is no motion of it, such as a turn about its own line.
    moves = arrays.rigid_motions((x - middle) / size).reshape(-1, 6) @ twists
    _, sizes, kept = np.linalg.svd(moves, full_matrices=False)
    twists = twists @ kept[sizes > INDEPENDENT * np.sqrt(len(x))].T
    limit = NEUTRAL * float(np.abs(load).sum())
    if limit > 0.0 and twists.shape[1]:
        twists = twists @ _free_of_work(twists, load, (x - middle) / size, limit)
    return _about_origin(twists, middle, size)


def _free_of_work(twists: Floats, load: Floats, x: Floats, limit: float) -> Floats:
    """Return the combinations of twists along which loads do no work, shape (twist, motion)."""
    moves = np.einsum("nkt,nk->t", arrays.rigid_motions(x) @ twists, load)
    shift, turn = twists[:3], twists[3:]
    total, moment = load.sum(axis=0), np.einsum("ni,nj->ij", load, x)
    # Of the work along each twist (column), by moving along each other one first (row).
    second = turn.T @ (moment - np.trace(moment) * np.eye(3)) @ turn
    second += shift.T @ np.cross(total, turn.T).T
    second = np.vstack((second, moves))
    return _null_space(second / limit, 1.0)


def _null_space(matrix: Floats, limit: float) -> Floats:
    """Return an orthonormal basis of what a matrix makes no larger than a limit."""
    # The other side of many rows, which is not needed, would be as large as their square.
    is_wide = len(matrix) < matrix.shape[1]
    _, sizes, modes = np.linalg.svd(matrix, full_matrices=is_wide)
    sizes = np.concatenate((sizes, np.zeros(len(modes) - len(sizes))))
    return modes[sizes <= limit].T


def _about_origin(twists: Floats, middle: Floats, size: float) -> Floats:
    """Return twists of (x - middle) / size as twists of x."""
    turn = twists[3:] / size
    return np.vstack((twists[:3] - np.cross(turn.T, middle).T, turn))


def _orthonormal(motion: Floats, mass: Floats) -> Floats:
    """Return a basis of the same motions that is orthonormal in the masses."""
    root = np.sqrt(mass)[:, None]
    basis, _ = np.linalg.qr(root * motion)
    return basis / root
