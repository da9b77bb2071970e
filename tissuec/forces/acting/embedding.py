"""Embedded nodes: their places are fixed weighted sums of those of other nodes, their hosts.

    x_e = Σ_j W_ej x_j,    v_e = Σ_j W_ej v_j,    F_j += Σ_e W_ej F_e,    Σ_j W_ej = 1.

By the principle of virtual work, forces on embedded nodes act on their hosts by the same
weights, so that forces, their moments and their power are the same (J. F. Abel, M. S. Shephard,
Int. J. Numer. Meth. Eng. 14:464, 1979). Masses, weights and ambient damping of embedded nodes
are lumped at hosts, by shares that are not negative within elements, as W may be: the mass
matrix stays diagonal, and the centre of mass where it is drawn. Embedded nodes are no unknowns:
a matrix K of all nodes becomes Tᵀ K T with x = T x_free.

Forces are collected after all others have been added, but for planes of symmetry, whose nodes
may be hosts. As nothing of its own acts, there is no potential, and the loops are written by
hand.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up
from tissuec.core.structs import replace
from tissuec.forces.acting.embedding_kernel import collect
from tissuec.forces.acting.load import Load
from tissuec.forces.fields import Field
from tissuec.kernels.records import BoundaryConditions, EmbeddingTable
from tissuec.model.cut_cells import WeightedSums
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix, csr_matrix


class EmbeddedNodes(Field, WeightedSums, frozen=True):
    """Nodes that are embedded in others, none of which is embedded itself.

    Attributes:
        nodes: Ascending, shape (n,).
        shares: Of masses at each of the hosts, which add up to 1 likewise, shape (host,).
    """

    nodes: Indices
    shares: Floats

    @classmethod
    def alone(cls, nodes: Indices, hosts: Indices) -> Self:
        """Return nodes that have a single host each, shape (n,) each."""
        ones = np.ones(len(nodes))
        first = np.arange(len(nodes) + 1)
        return cls(nodes=nodes, first=first, hosts=hosts, weights=ones, shares=ones)

    def joined_with(self, others: Self) -> Self:
        """Return these nodes and others; hosts of others that are embedded here are replaced.

        Args:
            others: None of them among these nodes.
        """
        if not len(self.nodes):
            return others
        row = np.minimum(np.searchsorted(self.nodes, others.hosts), len(self.nodes) - 1)
        follows = self.nodes[row] == others.hosts
        # Entries of both, one behind the other: runs of counts[k] from starts[k], each by a
        # factor.
        both, own = len(self.hosts), np.ones(len(self.nodes))
        starts = np.where(follows, self.first[row], both + np.arange(len(row)))
        starts = np.append(self.first[:-1], starts)
        counts = np.append(self.counts, np.where(follows, self.counts[row], 1))
        of = np.append(np.arange(len(self.nodes)), len(self.nodes) + others.owners)
        by_weight = np.concatenate([own, np.where(follows, others.weights, 1.0)])
        by_share = np.concatenate([own, np.where(follows, others.shares, 1.0)])
        nodes = np.append(self.nodes, others.nodes)
        order = np.argsort(nodes[of], kind="stable")
        starts, counts = starts[order], counts[order]
        entries = np.repeat(starts, counts) + counted_up(counts)
        rank = np.argsort(nodes)
        totals = np.bincount(np.searchsorted(nodes[rank], nodes[of[order]]), counts, len(nodes))
        return type(self)(
            nodes=nodes[rank],
            first=np.append(0, np.cumsum(totals)).astype(np.int64),
            hosts=np.append(self.hosts, others.hosts)[entries],
            weights=np.append(self.weights, others.weights)[entries]
            * np.repeat(by_weight[order], counts),
            shares=np.append(self.shares, others.shares)[entries]
            * np.repeat(by_share[order], counts),
        )

    def without(self, nodes: Indices) -> Self:
        """Return these without some nodes, shape (n,)."""
        stays = ~np.isin(self.nodes, nodes)
        own = stays[self.owners]
        return type(self)(
            nodes=self.nodes[stays],
            first=np.append(0, np.cumsum(self.counts[stays])),
            hosts=self.hosts[own],
            weights=self.weights[own],
            shares=self.shares[own],
        )

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return collect

    def table(
        self, place: Indices, acts: BoundaryConditions, position: Floats
    ) -> EmbeddingTable:
        """Return nodes and weights, which are the same at any position."""
        return EmbeddingTable(place[self.nodes], self.first, place[self.hosts], self.weights)

    @property
    def neighbours(self) -> Indices:
        """Return the first host of a node beside each of its hosts, shape (host, 2)."""
        return np.stack([self.hosts[self.first[:-1]][self.owners], self.hosts], axis=1)

    def follow(self, vectors: Floats) -> None:
        """Set the vectors of embedded nodes to the sums of those of their hosts.

        Args:
            vectors: Of all nodes in any unit, shape (node, 3); changed in place.
        """
        vectors[self.nodes] = self.weighted(vectors)

    def shared(self, forces: Floats) -> Floats:
        """Return forces with those on embedded nodes moved to their hosts.

        Args:
            forces: Of all nodes in any unit, shape (node, …).
        """
        return self._moved(forces, self.weights)

    def lumped(self, masses: Floats) -> Floats:
        """Return masses with those of embedded nodes lumped at their hosts.

        Args:
            masses: Or whatever adds up, of all nodes in any unit, shape (node,).
        """
        return self._moved(masses, self.shares)

    def _moved(self, values: Floats, parts: Floats) -> Floats:
        """Return values of nodes, with parts of those of embedded nodes added to hosts."""
        found = values.copy()
        parts = parts.reshape(-1, *(1,) * (values.ndim - 1))
        np.add.at(found, self.hosts, parts * values[self.nodes[self.owners]])
        found[self.nodes] = 0.0
        return found

    def any_of(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which embedded nodes have a chosen host, shape (n,).

        Args:
            chosen: Of all nodes, shape (node,).
        """
        return np.logical_or.reduceat(chosen[self.hosts], self.first[:-1])

    def carried(self, load: Load) -> Load:
        """Return a load on embedded nodes as one on their hosts."""
        number = np.full(int(max(self.nodes.max(), load.nodes.max(initial=0))) + 1, -1)
        number[self.nodes] = np.arange(len(self.nodes))
        embedded = number[load.nodes]
        on = embedded >= 0
        if not on.any():
            return load
        counts = self.counts[embedded[on]]
        entries = np.repeat(self.first[embedded[on]], counts) + counted_up(counts)
        factors = load.factors
        shares = np.repeat(factors[on], counts) * self.weights[entries]
        return replace(
            load,
            nodes=np.concatenate([load.nodes[~on], self.hosts[entries]]),
            shares=np.concatenate([factors[~on], shares]),
        )

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Move the forces on embedded nodes to their hosts [N].

        Args:
            time, position, velocity: Without effect.
            to: Sums of all other inner forces, shape (…, node, 3); changed in place.
        """
        pulled = self.weights[:, None] * to[..., self.nodes[self.owners], :]
        np.add.at(to, (..., self.hosts, slice(None)), pulled)
        to[..., self.nodes, :] = 0.0

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…): none."""
        return np.zeros(position.shape[:-2])

    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the powers that are put in from outside and lost [W], shape (…, 2): none."""
        return np.zeros((*position.shape[:-2], 2))

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return nothing [N/m]: matrices of all else are reduced; see ``reduction``."""
        from scipy.sparse import csc_matrix

        return csc_matrix((3 * size, 3 * size))

    def reduction(self, free: NDArray[np.bool_]) -> "tuple[Indices, csr_matrix]":
        """Return the numbers of moving nodes, and T with x = T x_free for these.

        Args:
            free: The nodes that are unknowns, none of which is embedded, shape (node,).

        Returns:
            Numbers of the free nodes and, behind them, of embedded ones that have a free host,
            -1 of others, shape (node,); and T, dimensionless, shape (3 moving, 3 free).
        """
        from scipy.sparse import coo_matrix, identity, kron

        number = np.where(free, np.cumsum(free) - 1, -1)
        count, riding = int(np.count_nonzero(free)), self.any_of(free)
        row = np.full(len(self.nodes), -1)
        row[riding] = count + np.arange(np.count_nonzero(riding))
        number[self.nodes] = row
        rows, moves = row[self.owners], free[self.hosts]
        each = np.concatenate([np.ones(count), self.weights[moves]])
        at = (
            np.concatenate([np.arange(count), rows[moves]]),
            np.concatenate([np.arange(count), number[self.hosts[moves]]]),
        )
        spread = coo_matrix((each, at), shape=(count + int(riding.sum()), count))
        return number, kron(spread, identity(3), format="csr")
