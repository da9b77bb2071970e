"""Names of nodes and springs, and the parts of bodies that they belong to."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from tissuec.model.network import Indices
from tissuec.results.names import full_name
from tissuec.view.compare.matching import tools_of
from tissuec.view.compare.sides import Side


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
        """Return the name of a spring or of a marked element: "14 of oviduct"."""
        return f"{self.network.springs.ids[number]} of {self.network.owner(number).name}"

    def broken(self, number: int) -> str:
        """Return the kind of item that a number of springs refers to: "spring" or "element"."""
        return "spring" if number < self.network.first_mark else "element"
