"""Nodes that cross a plane of symmetry.

A body and its mirror image touch only on the plane between them. Nothing holds other nodes on
their side: a dead load, or pressure, can push them through, into the mirror image.
"""

from collections.abc import Iterator
from typing import ClassVar, Self

import numpy as np

from tissuec.core.units import LENGTH, show
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.mechanics.state import State
from tissuec.model.blocks import SYMMETRY
from tissuec.model.network import Floats, Network
from tissuec.script.plan import Plan

KIND = "beyond a plane of symmetry"
#: Part of the size of the scene that nodes may be beyond a plane, by rounding.
ON_PLANE = 1e-6


@WATCHES.member(KIND)
class MirrorPlanes:
    """Watches on which side of planes of symmetry nodes are.

    Args:
        network: With planes.
    """

    kind: ClassVar[str] = KIND

    def __init__(self, network: Network):
        self._network, self._close = network, ON_PLANE * network.extent
        self._sides = [
            np.sign(self._away(number, network.position))
            * ~np.isin(np.arange(network.node_count), plane.nodes)
            for number, plane in enumerate(network.mirrored)
        ]
        spans = (one.span for one in network.blocks if one.kind == SYMMETRY)
        self._span = next(span for span in spans if span is not None)

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without planes of symmetry."""
        has_planes = any(one.kind == SYMMETRY for one in network.blocks)
        return cls(network) if has_planes and network.mirrored else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the bodies that have nodes on the other side of a plane."""
        beyond = np.zeros(len(position), dtype=bool)
        for number, side in enumerate(self._sides):
            beyond |= side * self._away(number, position) < -self._close
        for body in self._network.bodies:
            own = np.arange(self._network.node_count)[body.nodes]
            found = own[beyond[body.nodes]]
            where = ""
            if len(found):
                drawn = self._network.position[found[0]]
                place = ", ".join(show(float(x), LENGTH) for x in drawn)
                where = f"at node {self._network.node_ids[found[0]]}, drawn at ({place})"
            yield Finding(
                body.name, len(found),
                f"nodes of {body.name} are beyond a plane of symmetry, in their mirror image",
                where, "node",
                "nothing separates a body from its mirror image; load it less, or draw the "
                "whole body with contact", self._span,
            )  # fmt: skip

    def _away(self, number: int, position: Floats) -> Floats:
        """Return the distances of nodes from a plane [m], shape (node,)."""
        plane = self._network.mirrored[number]
        return np.asarray((position - plane.origin) @ plane.normal)
