"""Elements that turn inside out.

Finite elements push back where they are pressed flat, and also beyond that, but where the
volume at one of their points is not positive, their law no longer describes any material. Those
that have lost an edge are not counted.
"""

from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import cross, dot, norm
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.engine.execution.doubts.elements import INSIDE_OUT
from tissuec.engine.execution.doubts.following import ElementFollower, FollowedBody
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.script.plan import Plan

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements

_PART = 2048  # elements whose sides are in memory at a time


class _Volumes:
    """The volumes at the points of elements."""

    def __init__(self, field: "SolidElements"):
        self.field = field

    def found(self, position: Floats, alive: NDArray[np.bool_]) -> tuple[Indices, float]:
        """Return elements that are inside out; as of ``ElementTest``.

        With Z = Σ x_a ⊗ ∂N_a/∂ξ, moving each node by less than r changes Z by less than
        r Σ |∂N_a/∂ξ|; det Z keeps its sign while this is less than the smallest singular value
        of Z, which is at least 1/|Z⁻¹| = det Z/|cof Z|.
        """
        field = self.field
        is_out = np.zeros(field.item_count, dtype=bool)
        is_lost = np.zeros(field.item_count, dtype=bool)
        is_lost[field.lost_items(alive)] = True
        slope = norm(field.shape.gradients).sum(axis=-1)  # of each point
        margin = np.inf
        for first in range(0, field.item_count, _PART):
            part = np.arange(first, min(first + _PART, field.item_count))
            sides = field.shape.sides(position[field.nodes[part]])
            cofactors = cross(np.roll(sides, -1, axis=-2), np.roll(sides, -2, axis=-2))
            volume = dot(sides[..., 0, :], cofactors[..., 0, :])
            is_out[part] = (volume <= 0.0).any(axis=1)
            room = volume / (norm(cofactors.reshape(*volume.shape, 9)) * slope)
            margin = min(margin, float(room[~is_lost[part]].min(initial=np.inf)))
        return np.flatnonzero(is_out & ~is_lost), margin


@WATCHES.member("elements inside out")
class InvertedElements(ElementFollower):
    """Watches finite elements of solids."""

    kind: ClassVar[str] = INSIDE_OUT

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without elements."""
        bodies = [
            FollowedBody(network, body, list(map(_Volumes, network.elements_of(body.name))))
            for body in network.bodies
            if body.is_made_of_elements and not body.is_wall
        ]
        return cls(bodies) if bodies else None

    def describe(self, state: State, body: BodyPart, count: int, place: str) -> Finding:
        """Return the finding for a body; see ``ElementFollower``."""
        return Finding(
            body.name, count, f"elements of {body.name} are inside out", place, "element",
            "forces are wrong there; press, pull or twist the body less, or use smaller "
            "elements", body.span,
        )  # fmt: skip
