"""Nodes and springs of two networks: how they match, their names, and the parts they belong to.

A node is known by its body and its id, a spring by its body or joint and its two nodes, so that
springs keep their partners where a table loses a row or a body comes in between.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from msgspec import Struct

from tissuec.core.names import key_of
from tissuec.model.network import Indices, Network, numbers_in
from tissuec.results.recording import full_name
from tissuec.view.compare.sides import Side


class MatchedIndices(Struct, frozen=True, eq=False):
    """Network numbers of common items, and of those that only one side has.

    Attributes:
        a, b: Of the same things, shape (pair,).
        only_a, only_b: Of the others, ascending.
    """

    a: Indices
    b: Indices
    only_a: Indices
    only_b: Indices

    @classmethod
    def of(cls, a: Indices, b: Indices, count_a: int, count_b: int) -> "MatchedIndices":
        """Return pairs in the order of ``a`` with what is left.

        Args:
            a, b: Indices of the same things, shape (pair,).
            count_a, count_b: Number of things on either side.
        """
        order = np.argsort(a)
        rest = np.setdiff1d(np.arange(count_a), a), np.setdiff1d(np.arange(count_b), b)
        return cls(a[order], b[order], *rest)

    def __len__(self) -> int:
        return len(self.a)

    def number(self, count: int, side: str) -> Indices:
        """Return the pair of each item of one side, -1 without a pair, shape (item,)."""
        numbers = np.full(count, -1)
        numbers[self.a if side == "a" else self.b] = np.arange(len(self))
        return numbers


def tools_of(side: Side) -> Iterator[tuple[str, Indices]]:
    """Yield the tools that have nodes, with their indices of shape (n,), which come last."""
    for group in side.groups:
        is_set = group.what == "nodes" and not group.body and len(group.indices)
        if is_set and group.indices[0] >= side.network.body_nodes:
            yield group.name, group.indices


def match_nodes(a: Side, b: Side) -> MatchedIndices:
    """Return the nodes of bodies and tools that have the same names and ids."""
    parts_a, parts_b = _node_parts(a), _node_parts(b)
    found: list[tuple[Indices, Indices]] = []
    for key in parts_a.keys() & parts_b.keys():
        here, there = parts_a[key], parts_b[key]
        ids_a, ids_b = a.network.node_ids[here], b.network.node_ids[there]
        _, rows_a, rows_b = np.intersect1d(ids_a, ids_b, return_indices=True)
        found.append((here[rows_a], there[rows_b]))
    shown = a.network.node_count, b.network.node_count
    return MatchedIndices.of(*_joined(found), *shown)


def match_springs(a: Side, b: Side, nodes: MatchedIndices) -> MatchedIndices:
    """Return the springs between the same nodes in bodies and joints of the same names.

    Of several springs between two nodes the first matches the first, and so on.
    """
    keys = [key_of(part.name) for part in a.network.parts]
    codes_a = _spring_codes(a.network, nodes, "a", keys)
    codes_b = _spring_codes(b.network, nodes, "b", keys)
    apart_a, apart_b = _told_apart(codes_a, codes_b)
    _, rows_a, rows_b = np.intersect1d(apart_a, apart_b, return_indices=True)
    known = codes_a[rows_a] >= 0
    counts = a.network.spring_count, b.network.spring_count
    return MatchedIndices.of(rows_a[known], rows_b[known], *counts)


def match_entities(a: Side, b: Side, springs: MatchedIndices) -> MatchedIndices:
    """Return matched springs and, by their numbers in bodies, edges and elements.

    Args:
        springs: As ``match_springs`` returns them.
    """
    bodies = {key_of(body.name): body for body in b.network.bodies}
    pairs = [(springs.a, springs.b)]
    for one in a.network.bodies:
        other = bodies.get(key_of(one.name))
        if other is None or one.element_count != other.element_count:
            continue
        for own, others in (one.edges, other.edges), (one.elements, other.elements):
            numbers = numbers_in(own), numbers_in(others)
            if len(numbers[0]) == len(numbers[1]):
                pairs.append(numbers)
    counts = a.network.entity_count, b.network.entity_count
    return MatchedIndices.of(*_joined(pairs), *counts)


def _node_parts(side: Side) -> dict[str, Indices]:
    bodies: dict[str, Indices] = {
        key_of(body.name): numbers_in(body.nodes) for body in side.network.bodies
    }
    return bodies | {key_of(name): indices for name, indices in tools_of(side)}


def _spring_codes(
    network: Network, nodes: MatchedIndices, which: str, keys: Sequence[str]
) -> Indices:
    """Return a number for body or joint and nodes of each spring, -1 where one is unknown."""
    number, count = nodes.number(network.node_count, which), len(nodes)
    ends = np.sort(number[network.springs.ends], axis=1).reshape(-1, 2)
    codes = np.full(network.spring_count, -1)
    for part in network.parts:
        if (key := key_of(part.name)) in keys:
            low, high = ends[part.springs].T
            codes[part.springs] = (keys.index(key) * count + low) * count + high
    codes[(ends < 0).any(axis=1)] = -1
    return codes


def _told_apart(a: Indices, b: Indices) -> tuple[Indices, Indices]:
    """Return codes in which repeated ones have distinct numbers."""
    again_a, again_b = _occurrence(a), _occurrence(b)
    most = max(int(again_a.max(initial=0)), int(again_b.max(initial=0))) + 1
    return a * most + again_a, b * most + again_b


def _occurrence(codes: Indices) -> Indices:
    """Return the how-manieth of its kind each number is, from 0, shape (number,)."""
    order = np.argsort(codes, kind="stable")
    ordered = codes[order]
    again = np.empty(len(codes), dtype=np.int64)
    again[order] = np.arange(len(codes)) - np.searchsorted(ordered, ordered)
    return again


def _joined(found: Sequence[tuple[Indices, Indices]]) -> tuple[Indices, Indices]:
    nothing = np.zeros(0, dtype=np.int64)
    a, b = zip((nothing, nothing), *found, strict=True)
    return np.concatenate(a), np.concatenate(b)


class SideParts:
    """The parts of one side: its bodies, their regions, joints and tools."""

    def __init__(self, side: Side):
        self.network = side.network
        self._regions = [group for group in side.groups if group.body]
        self._tools = list(tools_of(side))

    @cached_property
    def names(self) -> list[str]:
        """Names of the parts that nodes belong to; those of regions with their bodies."""
        bodies = [body.name for body in self.network.bodies]
        return [*bodies, *map(full_name, self._regions), *(name for name, _ in self._tools)]

    @cached_property
    def of_nodes(self) -> Indices:
        """The part of each node as a place in ``names``, shape (node,); -1 without one."""
        part = np.full(self.network.node_count, -1)
        members: list[slice | Indices] = [body.nodes for body in self.network.bodies]
        members += [region.indices for region in self._regions]
        members += [indices for _, indices in self._tools]
        for number, nodes in enumerate(members):
            part[nodes] = number
        return part

    @cached_property
    def of_springs(self) -> Indices:
        """The parts of both ends of each spring, shape (spring, 2); of a joint its own twice.

        Joints are numbered behind ``names``.
        """
        part = np.sort(self.of_nodes[self.network.springs.ends], axis=1).reshape(-1, 2)
        for number, joint in enumerate(self.network.joints, start=len(self.names)):
            part[joint.springs] = number
        return part

    @cached_property
    def bodies(self) -> list[str]:
        """Names of what nodes belong to altogether: bodies and tools."""
        return [body.name for body in self.network.bodies] + [name for name, _ in self._tools]

    @cached_property
    def body_of_nodes(self) -> Indices:
        """The body or tool of each node as a place in ``bodies``, shape (node,); -1 without."""
        body = np.full(self.network.node_count, -1)
        members: list[slice | Indices] = [body.nodes for body in self.network.bodies]
        for number, nodes in enumerate([*members, *(indices for _, indices in self._tools)]):
            body[nodes] = number
        return body

    @cached_property
    def part_of_springs(self) -> Indices:
        """Return the body or joint of each spring as a place in the network's parts.

        The shape is (spring,).
        """
        parts = self.network.parts
        sizes = [part.springs.stop - part.springs.start for part in parts]
        return np.repeat(np.arange(len(parts)), sizes)

    def named(self, parts: Sequence[int]) -> str:
        """Return the name of a part, or of what lies between two."""
        every = [*self.names, *(joint.name for joint in self.network.joints)]
        names = dict.fromkeys(every[part] if part >= 0 else "" for part in parts)
        return " | ".join(names)

    def node(self, number: int) -> str:
        """Return the name of a node: "57 of oviduct"."""
        body = int(self.body_of_nodes[number])
        name = self.bodies[body] if body >= 0 else "a tool"
        return f"{self.network.node_ids[number]} of {name}"

    def spring(self, number: int) -> str:
        """Return the name of a spring, an edge or an element: "14 of oviduct"."""
        return f"{self.network.number_of(number)} of {self.network.owner(number).name}"

    def broken(self, number: int) -> str:
        """Return the kind of item that a number of springs refers to: "spring" or "element"."""
        return "spring" if number < self.network.line_count else "element"
