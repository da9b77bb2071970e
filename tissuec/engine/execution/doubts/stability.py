"""Elements that are strained beyond the stability of their law.

Beyond it, a further strain needs less stress, so it localises in single elements and depends on
the mesh. Only bodies with a law that is not stable everywhere are checked.
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.core.units import LENGTH, show
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.script.plan import Plan

if TYPE_CHECKING:  # scenes without elements do not need them
    from tissuec.forces.elements import SolidElements
    from tissuec.forces.membranes import Membranes

KIND = "unstable law"
LARGEST = 6.0  # stretch up to which laws are examined


@WATCHES.member(KIND)
class LawStability:
    """Watches the elements of laws that are not stable at all strains.

    Args:
        parts: Bodies with their elements of such laws, and the numbers of these.
    """

    kind: ClassVar[str] = KIND

    def __init__(
        self,
        network: Network,
        parts: "Sequence[tuple[BodyPart, Sequence[tuple[SolidElements | Membranes, Indices]]]]",
    ):
        self._network, self._parts = network, parts

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None where all laws are stable."""
        parts = [
            (body, concerned)
            for body in network.bodies
            if (concerned := [*_concerned(network.elements_of(body.name))])
        ]
        return cls(network, parts) if parts else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the bodies with elements beyond the stability of their law."""
        for body, concerned in self._parts:
            count, where = 0, ""
            for field, numbers in concerned:
                lost = np.isin(numbers, field.lost_items(state.alive))
                beyond = numbers[_is_beyond(field.only(numbers), position) & ~lost]
                count += len(beyond)
                if len(beyond) and not where:
                    where = self._place(field.nodes[beyond[0]])
            yield Finding(
                body.name, count,
                f"elements of {body.name} are strained beyond the stable range of their law",
                where, "element",
                "results depend on the mesh there; strain the body less, or choose a law whose "
                "stress keeps rising", body.span,
            )  # fmt: skip

    def _place(self, nodes: Indices) -> str:
        centre = self._network.position[nodes].mean(axis=0)
        return f"around ({', '.join(show(float(x), LENGTH) for x in centre)}) as drawn"


def _concerned(
    fields: "Sequence[SolidElements | Membranes]",
) -> "Iterator[tuple[SolidElements | Membranes, Indices]]":
    """Yield the fields that have elements of laws that are not stable everywhere."""
    from tissuec.laws.stability import stable_strains

    for field in fields:
        suspect = [stable_strains(law, LARGEST) is not None for law in field.laws]
        # What yields bears little more than its yield stress.
        numbers = np.flatnonzero(np.array(suspect)[field.law] & ~field.yields)
        if len(numbers):
            yield field, numbers


def _is_beyond(field: "SolidElements | Membranes", position: Floats) -> NDArray[np.bool_]:
    """Return whether a law is not stable at any point of elements, shape (element,)."""
    from tissuec.laws.stability import is_stable

    first, second = field.invariants(position)
    beyond = np.zeros(field.item_count, dtype=bool)
    for number in np.unique(field.law):
        own = field.law == number
        stable = is_stable(field.laws[int(number)], first[own], second[own])
        beyond[own] = ~stable.reshape(int(own.sum()), -1).all(axis=1)
    return beyond
