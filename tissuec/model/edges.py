"""Edges of finite elements: which elements have some, and which some elements have."""

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Indices, Network
from tissuec.model.topology import PairIndex

_NONE = np.zeros(0, dtype=np.int64)


def elements_at(network: Network, lines: Indices) -> Indices:
    """Return the elements that have an edge among some lines, as entities, shape (n,).

    Args:
        lines: Springs have no elements, shape (m,).
    """
    pairs = network.edges[lines[lines >= network.spring_count] - network.spring_count]
    if not len(pairs):
        return _NONE
    index, is_end = PairIndex(pairs), np.zeros(network.node_count, dtype=bool)
    is_end[pairs] = True
    found = [_NONE]
    for field in network.elements:
        near = np.flatnonzero(np.count_nonzero(is_end[field.nodes], axis=1) > 1)
        edges = field.edges[near]
        _, which = index.between(edges.reshape(-1, 2))
        found.append(field.walls[near[np.unique(which // edges.shape[1])]])
    return np.concatenate(found)


def edges_of(network: Network, entities: Indices) -> Indices:
    """Return the lines that are edges of some elements, ascending, shape (n,).

    Args:
        entities: The elements; others have none, shape (m,).
    """
    chosen = np.zeros(network.entity_count, dtype=bool)
    chosen[entities] = True
    own = (field.edges[chosen[field.walls]].reshape(-1, 2) for field in network.elements)
    pairs = np.concatenate([np.zeros((0, 2), dtype=np.int64), *own])
    found = np.unique(network.pairs.between(pairs)[0])
    return found[found >= network.spring_count]


def bare_edges(network: Network, alive: NDArray[np.bool_], lost: Indices) -> Indices:
    """Return the edges that only lost elements have, ascending, shape (n,).

    Args:
        alive: Which entities there are, without those that are lost, shape (entity,).
        lost: The elements, as entities; others have no edges, shape (m,).
    """
    edges = edges_of(network, lost)
    beside = elements_at(network, edges)
    held = edges_of(network, beside[alive[beside]])
    return np.setdiff1d(edges[alive[edges]], held)


def without(network: Network, alive: NDArray[np.bool_], entities: Indices) -> NDArray[np.bool_]:
    """Return which entities are left without some, and without the elements at them.

    Args:
        alive: Which there were, shape (entity,).
        entities: Those that are lost, shape (n,).
    """
    left = alive.copy()
    left[entities] = False
    left[elements_at(network, entities[entities < network.line_count])] = False
    return left


def joined_pairs(network: Network, alive: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Return the nodes of edges of elements that are there, shape (edge, 2).

    Args:
        alive: Which entities are, shape (entity,).
    """
    there = np.arange(network.line_count, network.entity_count)
    if alive[there].all():
        return network.edges
    return network.edges[edges_of(network, there[alive[there]]) - network.spring_count]
