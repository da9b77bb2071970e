"""Relaxation: nodes move with their forces, layer by layer, until nothing changes.

The first approach of the paper, after propagation in Hopfield networks: a sweep starts at the
node with the greatest force and continues layer by layer, a layer being what springs join to
the one before. The next sweep starts at the node whose force has changed most, as long as that
is more than a threshold. (Nürnberger, Radetzky & Kruse 1998, section 3.1.4.)

The paper does not say how a node gives way. Here it moves by F / Σ c, where springs to a node
of the same layer count twice: the minimum of Σ ½ c |r' - L0 u|² with the present directions u.
That function is nowhere below the energy and equals it here, so that the energy falls in every
layer, however stiff the net. Where volumes are enclosed, Σ c has a bound of what they resist.
Springs that are not linear count with their largest slope within the reach of the last sweep,
or, where that is none, within as little of their length as has one; and where the energy rises
nevertheless, as twice as stiff. But soft motions of large nets come slowly, so that a sweep
begins ahead of where the last one ended, along what it has moved, unless that leads uphill.
(Y. Nesterov, Soviet Math. Dokl. 27:372, 1983; B. O'Donoghue, E. Candès, Found. Comput. Math.
15:715, 2015.)
"""

from collections.abc import Iterator
from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import shortest_path

from tissuec.core.signals import give_way
from tissuec.forces.springs.resting_springs import Bars
from tissuec.mechanics.balance import Balance, NodeSprings
from tissuec.model.network import Floats

WIDER = (0.01, 0.03, 0.1, 0.3, 1.0)  # of the rest length, where nearby slopes are none


class Relaxed(NamedTuple):
    """Result of relaxation.

    Attributes:
        x: Of the free nodes [m], shape (free, 3).
        sweeps: How many it took.
        change: The largest change of a force in the last one [N].
    """

    x: Floats
    sweeps: int
    change: float


def relax(balance: Balance, x: Floats, *, threshold: float, most: int) -> Relaxed:
    """Move the free nodes towards equilibrium until forces hardly change.

    Args:
        balance: The free nodes and what acts on them.
        x: Their positions at the start [m], shape (free, 3).
        threshold: Change of a force within a sweep below which no further sweep starts [N].
        most: Largest number of sweeps.
    """
    if not len(x):
        return Relaxed(x, 0, 0.0)
    layers, ahead, pace = Layers(balance), x, 1.0
    bars = balance.bars(x)
    force, (energy, _) = balance.force(bars), balance.energy(x, bars)
    urge = _sizes(force)
    for sweep in range(1, most + 1):
        give_way()
        there = _sweep(balance, layers, ahead, urge)
        bars = balance.bars(there)
        after, rounding = balance.energy(there, bars)
        falls = isfinite(after) and after <= energy + rounding
        if not falls and (pace > 1.0 or layers.are_curved):
            if pace == 1.0:
                layers.doubt *= 2.0
            ahead, pace = x, 1.0
            continue
        if np.vdot(ahead - there, there - x) > 0.0:
            pace = 1.0  # the lead goes uphill
        layers.look(bars, float(_sizes(there - x).max()))
        faster = 0.5 * (1.0 + sqrt(1.0 + 4.0 * pace * pace))
        ahead = there + (pace - 1.0) / faster * (there - x)
        x, energy, pace = there, after, faster
        before, force = force, balance.force(bars)
        urge = _sizes(force - before)
        if urge.max() <= threshold and layers.doubt == 1.0:
            return Relaxed(x, sweep, float(urge.max()))
    return Relaxed(x, most, float(urge.max()))


def _sweep(balance: Balance, layers: "Layers", x: Floats, urge: Floats) -> Floats:
    """Return where the free nodes are after each layer gave way once [m], shape (free, 3)."""
    x = x.copy()
    for layer in layers.beginning_with(urge):
        resists = layers.doubt * layer.weight[:, None]
        x[layer.star.nodes] += balance.force_on(layer.star, x) / resists
    return x


class Layer(NamedTuple):
    """Nodes that give way at once.

    Attributes:
        star: The nodes, and the springs that pull at them.
        weight: What resists each of them [N/m], shape (node,).
    """

    star: NodeSprings
    weight: Floats


class Layers:
    """The layers of a net, from any node outwards.

    Attributes:
        are_curved: Whether some springs are not linear, so that weights change with places.
        doubt: By what weights are multiplied, because the energy has risen with smaller ones.
    """

    def __init__(self, balance: Balance):
        self._balance, self._count = balance, len(balance.free)
        self._ends = balance.springs.ends
        self.are_curved, self.doubt = not balance.springs.behaviour.is_linear, 1.0
        bars = balance.bars(balance.start)
        self._stiffness = self._steepest(bars, 0.0)
        self._pressing = balance.pressing(bars)
        low, high = balance.link_ends[(balance.link_ends >= 0).all(axis=1)].T
        joined = np.ones(len(low), dtype=np.int8)
        shape = (self._count, self._count)
        self._graph = csr_matrix((joined, (low, high)), shape=shape)
        self._known: dict[int, tuple[Floats, tuple[NodeSprings, ...]]] = {}
        self._weight: dict[int, Floats] = {}

    def look(self, bars: Bars, reach: float) -> None:
        """Update with the result of a sweep that moved nodes by at most ``reach`` [m]."""
        if self.are_curved:
            self.doubt = max(1.0, 0.5 * self.doubt)
            self._stiffness = self._steepest(bars, reach)
            self._weight.clear()

    def _steepest(self, bars: Bars, reach: float) -> Floats:
        """Return the largest slopes of springs within a reach, or within more [N/m]."""
        behaviour, rest = self._balance.springs.behaviour, self._balance.springs.rest
        e = bars.length - rest
        if not self.are_curved:
            return behaviour.steepness(e)
        found = np.zeros_like(e)
        for way in (0.0 * rest + reach, *(part * rest for part in WIDER)):
            slopes = [behaviour.steepness(at) for at in (e - way, e, e + way)]
            found = np.where(found > 0.0, found, np.max(slopes, axis=0))
            if found.all():
                break
        across = bars.tension / np.where(bars.length > 0.0, bars.length, np.inf)
        return np.maximum(found, across)

    def beginning_with(self, urge: Floats) -> Iterator[Layer]:
        """Yield layers, beginning with the node of the largest urge in each piece.

        Args:
            urge: Priority of each node, a force [N], shape (free,).
        """
        waiting = np.ones(self._count, dtype=bool)
        while waiting.any():
            first = int(np.argmax(np.where(waiting, urge, -1.0)))
            if first not in self._known:
                self._known[first] = self._from(first)
            depth, stars = self._known[first]
            if first not in self._weight:
                self._weight[first] = self._weights(depth)
            for star in stars:
                waiting[star.nodes] = False
                yield Layer(star, self._weight[first][star.nodes])

    def _from(self, first: int) -> tuple[Floats, tuple[NodeSprings, ...]]:
        """Return how many springs away each node is, and the nodes by that."""
        depth = shortest_path(self._graph, directed=False, unweighted=True, indices=first)
        last = int(depth[np.isfinite(depth)].max())
        stars = (self._balance.star(np.flatnonzero(depth == k)) for k in range(last + 1))
        return depth, tuple(stars)

    def _weights(self, depth: Floats) -> Floats:
        """Return Σ c of each node, springs within a layer counted twice, shape (free,).

        What volumes add is a bound that holds for all nodes at once.
        """
        total = self._pressing.copy()
        inner = (self._ends >= 0).all(axis=1)
        within = inner & (depth[self._ends[:, 0]] == depth[self._ends[:, 1]])
        counted = np.where(within, 2.0, 1.0) * self._stiffness
        for end in (0, 1):
            moves = self._ends[:, end] >= 0
            np.add.at(total, self._ends[moves, end], counted[moves])
        # A node on which no spring acts stays: its force is none, or nothing holds it.
        return np.where(total > 0.0, total, np.inf)


def _sizes(vectors: Floats) -> Floats:
    return np.sqrt(np.einsum("nk,nk->n", vectors, vectors))
