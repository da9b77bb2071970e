"""What follows from an energy of sums over items, such as of the volume within some faces.

Each item has shares in the sums s of its group, which stores U(s) [J]. So

    f = -Σ λ ∂s/∂x,    λ = ∂U/∂s,    ∂²E/∂x∂x = Σ λ ∂²s/∂x∂x + Σ ∂s/∂x ∂²U/∂s∂s ∂s/∂x,

and an item acts like one with the energy Σ λ s, λ being given. Items are seen from a point of
their group, which counts as fixed: U must not depend on where it is.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TypeAlias

from tissuec.autodiff.derivatives import along, gradient, hessian
from tissuec.autodiff.graph import Graph, Number
from tissuec.autodiff.potentials import Numbers, Potential, TracedItem, numbers_in
from tissuec.autodiff.tensors import Vector, dot
from tissuec.autodiff.tracing import traced

#: Takes the corners of an item as seen from the point, and its numbers; returns its shares.
ShareFunction: TypeAlias = Callable[[Sequence[Vector], Numbers], Sequence[Number]]
#: Takes the sums of a group, the point, and its numbers; returns U.
WholeFunction: TypeAlias = Callable[[Vector, Vector, Numbers], Number]


class TracedPool:
    """Items with shares in sums of groups.

    Args:
        share, whole: Of an item, and of a group.
        corners: Nodes of an item.
        columns: By name, how many components a number of an item has.
        widths: As the attribute.

    Attributes:
        item: An item, given λ; of its further points, one is that from which it is seen, and
            the other stands for its group.
        shares: In the sums, in the graph of ``item``.
        steepness: λ in that graph.
        graph: Of a group.
        widths: By name, how many components a number of a group has.
        sums, numbers: Inputs of that graph.
        energy: U.
        slopes: λ = ∂U/∂s.
    """

    def __init__(
        self, share: ShareFunction, whole: WholeFunction, corners: int,
        columns: Mapping[str, int], widths: Mapping[str, int],
    ):  # fmt: skip
        def weighed(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
            self.shares = share([each - x[corners] for each in x[:corners]], p)
            inputs = (f"l.{corners + 1}.{k}" for k in range(len(self.shares)))
            self.steepness = [x[0][0].graph.input(each) for each in inputs]
            return Potential(dot(self.steepness, self.shares))

        self.shares: Sequence[Number] = ()
        self.steepness: Sequence[Number] = ()
        self.item = TracedItem(weighed, corners, columns, seen=2)
        self.graph, self.widths = Graph(), dict(widths)
        self.sums = Vector(self.graph.input(f"s.0.{k}") for k in range(len(self.shares)))
        seen = Vector(self.graph.input(f"x.1.{axis}") for axis in range(3))
        self.numbers, given = numbers_in(self.graph, self.widths, changes=True)
        self.energy = traced(whole, lambda: whole(self.sums, seen, given))
        self.slopes = gradient(self.energy, self.sums)

    @cached_property
    def supply(self) -> Number:
        """Return the power that a change of the amount supplies [W]."""
        amount, rate = (self.graph.input(f"a.{k}") for k in range(2))
        return along([self.energy], {amount: rate})[0]

    @cached_property
    def bend(self) -> list[Number]:
        """Return ∂²U/∂s∂s, its lower half row by row."""
        return list(hessian(self.energy, self.sums).values())

    @cached_property
    def pulled(self) -> list[Number]:
        """Return the derivatives of Σ w·f by x and then by λ, w being given."""
        item = self.item
        work = dot(item.weights, item.forces)
        return gradient(work, [*item.x, *self.steepness])

    def pulled_back(self, learnt: Sequence[str]) -> list[Number]:
        """Return minus the derivatives of Σ m λ by the sums, and those by some numbers.

        Args:
            learnt: Names of the numbers.
        """
        moved = [self.graph.input(f"m.0.{k}") for k in range(len(self.sums))]
        found = gradient(dot(moved, self.slopes), [*self.sums, *self._of(learnt)])
        count = len(self.sums)
        return [*(-each for each in found[:count]), *found[count:]]

    def pushed(self, learnt: Sequence[str]) -> tuple[list[Number], list[str]]:
        """Return the changes of λ, and the inputs that are those of sums and of numbers."""
        changed = [*self.sums, *self._of(learnt)]
        names = [f"d{each.operation.detail}" for each in changed]
        rates = (self.graph.input(name) for name in names)
        return along(self.slopes, dict(zip(changed, rates, strict=True))), names

    def _of(self, learnt: Sequence[str]) -> list[Number]:
        """Return the components of some numbers."""
        return [
            self.graph.input(f"p.{name}.{k}")
            for name in learnt
            for k in range(self.widths[name])
        ]
