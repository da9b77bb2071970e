"""Finite elements that turn inside out.

Elements push back where they are pressed flat, and also beyond that, but where the volume at
one of their points is not positive, their law no longer describes any material. Those that have
lost an edge are not counted.
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.core.units import LENGTH, show
from tissuec.core.vectors import norm
from tissuec.engine.execution.doubts import Finding
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network

if TYPE_CHECKING:  # scenes without elements do not need them
    from tissuec.forces.elements import SolidElements

_PART = 2048  # elements whose sides are in memory at a time


class ElementOrientation:
    """The elements of one body.

    Args:
        network: With the body as drawn.
        body: Is made of elements.
    """

    def __init__(self, network: Network, body: BodyPart):
        self._network, self._body = network, body
        self._shapes: Sequence[SolidElements] = network.elements_of(body.name)
        self._seen: Floats | None = None
        self._close = 0.0
        self._is_out = False

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the elements that are inside out; as ``Watch.look``."""
        own = position[self._body.nodes]
        if self._seen is not None and not self._is_out:
            moved = own - self._seen
            if norm(moved - moved.mean(axis=0)).max() < self._close:
                return
        out = [self._inverted(field, position, state.alive) for field in self._shapes]
        self._seen = own.copy()
        self._close = min(margin for _, margin in out)
        numbers = [which for which, _ in out]
        count = sum(map(len, numbers))
        if not count and not self._is_out:
            return
        self._is_out = bool(count)
        name = self._body.name
        yield Finding(
            name, count, f"elements of {name} are inside out", self._place(numbers), "element",
            "forces are wrong there; press, pull or twist the body less, or use smaller "
            "elements", self._body.span,
        )  # fmt: skip

    def _inverted(
        self, field: "SolidElements", position: Floats, alive: NDArray[np.bool_]
    ) -> tuple[Indices, float]:
        """Return elements that are inside out, and how far nodes can move before others are.

        With Z = Σ x_a ⊗ ∂N_a/∂ξ, moving each node by less than r changes Z by less than
        r Σ |∂N_a/∂ξ|; det Z keeps its sign while this is less than the smallest singular value
        of Z, which is at least 1/|Z⁻¹| = det Z/|cof Z|.
        """
        from tissuec.forces.solid_strain import SolidStrain

        is_out = np.zeros(field.item_count, dtype=bool)
        is_lost = np.zeros(field.item_count, dtype=bool)
        is_lost[field.lost_items(alive)] = True
        slope = norm(field.shape.gradients).sum(axis=-1)  # of each point
        margin = np.inf
        for first in range(0, field.item_count, _PART):
            part = np.arange(first, min(first + _PART, field.item_count))
            sides = SolidStrain(field.shape.sides(position[field.nodes[part]]))
            is_out[part] = (sides.j <= 0.0).any(axis=1)
            room = sides.j / (np.sqrt(sides.i2) * slope)
            margin = min(margin, float(room[~is_lost[part]].min(initial=np.inf)))
        return np.flatnonzero(is_out & ~is_lost), margin

    def _place(self, numbers: Sequence[Indices]) -> str:
        """Return where the first element is, as drawn; "" without any."""
        for field, which in zip(self._shapes, numbers, strict=True):
            if len(which):
                corners = self._network.position[field.nodes[which[0]]]
                centre = ", ".join(show(float(x), LENGTH) for x in corners.mean(axis=0))
                return f"in {field.shape.name} {which[0] + 1} around ({centre})"
        return ""
