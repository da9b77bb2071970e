"""What follows from items whose groups weigh what they push by, such as faces of a volume.

Items have parts in sums s of their group, or in maxima over it, on which factors λ of what its
items store, q, depend:

    f = -Σ λ ∂q/∂x,    λ = λ(s).

Where a group stores U(s) [J], q = s and λ = ∂U/∂s, so that the matrix is

    ∂²E/∂x∂x = Σ λ ∂²s/∂x∂x + Σ ∂s/∂x ∂²U/∂s∂s ∂s/∂x.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple, TypeAlias

from tissuec.autodiff.derivatives import along, changed, gradient, hessian
from tissuec.autodiff.functions import where
from tissuec.autodiff.graph import Graph, Number, Operand
from tissuec.autodiff.potentials import Numbers, Potential, TracedItem, components, numbers_in
from tissuec.autodiff.tensors import Vector, dot
from tissuec.autodiff.tracing import traced

ALIKE = 1e-9  # relative difference of numbers of items that are equal


class Shares(NamedTuple):
    """What an item has a part in.

    Attributes:
        stored: q [J], or in any unit that λ makes one of energy.
        summed: Its parts in s.
        greatest: Which of these their greatest one counts of, by their places.
        acts: Positive where the item has any part in anything; None if it always may.
        bends: How many points it has passed at which a formula changes; None to count none.
    """

    stored: Sequence[Number]
    summed: Sequence[Number]
    greatest: frozenset[int] = frozenset()
    acts: Number | None = None
    bends: Number | None = None


class Factors(NamedTuple):
    """What a group does by its sums.

    Attributes:
        factors: λ.
        supply, lost: Power that is supplied from outside, and that is dissipated [W].
        bends: As that of ``Shares``.
    """

    factors: Sequence[Number]
    supply: Operand = 0.0
    lost: Operand = 0.0
    bends: Operand = 0.0


#: Takes all points of an item, their velocities, and its numbers.
PartsFunction: TypeAlias = Callable[[Sequence[Vector], Sequence[Vector], Numbers], Shares]
#: Takes the sums of a group, the point from which it is seen, and its numbers.
FactorsFunction: TypeAlias = Callable[[Vector, Vector, Numbers], Factors]


class TracedPool:
    """Items with parts in sums of groups.

    Args:
        parts, factors: Of an item, and of a group.
        corners: Nodes of an item.
        columns: By name, how many components a number of an item has.
        widths, learnt: As the attributes.

    Attributes:
        item: An item that stores Σ λ q, given λ; of its further points, one is that from which
            it is seen, and the other stands for its group.
        group: Place of the latter among its points.
        shares: In the graph of ``item``.
        given: λ in that graph.
        graph: Of a group.
        widths: By name, how many components a number of a group has.
        sums, numbers: Inputs of that graph.
        whole: λ and powers, in that graph.
        learnt: Numbers of items by which there are derivatives. The place of each among all
            learnt numbers follows the points of an item.
    """

    def __init__(
        self, parts: PartsFunction, factors: FactorsFunction, corners: int,
        columns: Mapping[str, int], widths: Mapping[str, int], learnt: Sequence[str] = (),
    ):  # fmt: skip
        self.group, self.learnt = corners + 1, tuple(learnt)

        def weighed(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
            self.shares = parts(x, v, p)
            self.given = self._of_group("l", len(self.shares.stored), x[0][0].graph)
            return Potential(dot(self.given, self.shares.stored))

        self.shares, self.given = Shares((), ()), list[Number]()
        self.item = TracedItem(weighed, corners, columns, seen=2)
        self.graph, self.widths = Graph(), dict(widths)
        self.sums = Vector(self.graph.input(f"s.0.{k}") for k in range(self.count))
        seen = Vector(self.graph.input(f"x.1.{axis}") for axis in range(3))
        self.numbers, own = numbers_in(self.graph, self.widths, changes=True)
        self.whole = traced(factors, lambda: factors(self.sums, seen, own))

    def _of_group(self, letter: str, count: int, graph: Graph | None = None) -> list[Number]:
        """Return inputs of an item that are numbers of its group."""
        graph = graph or self.item.graph
        return [graph.input(f"{letter}.{self.group}.{k}") for k in range(count)]

    @property
    def places(self) -> int:
        """Return how many places an item has: of its points, and of its learnt numbers."""
        return self.group + 1 + len(self.learnt)

    @property
    def count(self) -> int:
        """Return the number of sums."""
        return len(self.shares.summed)

    @property
    def ends(self) -> list[Number]:
        """Return λ, both powers, and the bends that groups pass."""
        factors, *others = self.whole
        return [*factors, *(self.graph.number(each) for each in others)]

    @cached_property
    def slopes(self) -> list[list[Number]]:
        """Return ∂q/∂x of each q, shape (3 corner,)."""
        return [gradient(each, self.item.x) for each in self.shares.stored]

    @cached_property
    def rows(self) -> list[Number]:
        """Return the stored numbers of an item: its activity, parts, bends, and ∂q/∂x."""
        shares = self.shares
        first = [
            each for each in (shares.acts, *shares.summed, shares.bends) if each is not None
        ]
        every = [*first, *(slope for slopes in self.slopes for slope in slopes)]
        return list({each.place: each for each in every}.values())

    # --- derivatives --------------------------------------------------------------------------

    @cached_property
    def _moving(self) -> list[Number]:
        """Return the parts by which sums change with an item: 0 beside a greater one."""
        found = list(self.shares.summed)
        sums = self._of_group("s", self.count)
        for k in self.shares.greatest:
            # With room for the last digits, in which those computed again differ.
            is_less = (1.0 - ALIKE) * sums[k] > found[k]
            found[k] = where(is_less, 0.0, found[k])
        return found

    @property
    def pulled(self) -> list[Number]:
        """Return the derivatives of Σ w·f by x, λ, and learnt numbers of items, w given."""
        item = self.item
        work = dot(item.weights, item.forces)
        return gradient(work, [*item.x, *self.given, *item.of(self.learnt)])

    def pulled_groups(self, learnt: Sequence[str]) -> list[Number]:
        """Return the derivatives of Σ m λ by the sums, and those by some numbers of groups."""
        factors = self.whole.factors
        moved = [self.graph.input(f"m.0.{k}") for k in range(len(factors))]
        return gradient(
            dot(moved, factors), [*self.sums, *components(self.graph, self.widths, learnt)]
        )

    @property
    def pulled_sums(self) -> list[Number]:
        """Return the derivatives of Σ b s by x, v, and learnt numbers of items, b given."""
        item = self.item
        work = dot(self._of_group("b", self.count), self._moving)
        return gradient(work, [*item.x, *item.v, *item.of(self.learnt)])

    @property
    def pushed_sums(self) -> tuple[list[Number], dict[str, Number]]:
        """Return the changes of sums, and the inputs that are those of x, v and numbers."""
        item = self.item
        return changed(self._moving, [*item.x, *item.v, *item.of(self.learnt)])

    def pushed_groups(self, learnt: Sequence[str]) -> tuple[list[Number], dict[str, Number]]:
        """Return the changes of λ, and the inputs that are those of sums and of numbers."""
        return changed(
            self.whole.factors, [*self.sums, *components(self.graph, self.widths, learnt)]
        )

    @property
    def pushed(self) -> tuple[list[Number], dict[str, Number]]:
        """Return the changes of f, and the inputs that are those of x, λ and numbers."""
        item = self.item
        return changed(item.forces, [*item.x, *self.given, *item.of(self.learnt)])


#: Takes the corners of an item as seen from the point, and its numbers; returns its shares.
ShareFunction: TypeAlias = Callable[[Sequence[Vector], Numbers], Sequence[Number]]
#: Takes the sums of a group, the point, and its numbers; returns U.
WholeFunction: TypeAlias = Callable[[Vector, Vector, Numbers], Number]


class StoringPool(TracedPool):
    """Items whose groups store an energy of sums, which is that of an amount that changes, too.

    Items are seen from a point of their group, which counts as fixed: U must not depend on
    where it is.

    Args:
        share, whole: Of an item, and of a group.
        corners, columns, widths: Those of ``TracedPool``.

    Attributes:
        energy: U.
    """

    energy: Number

    def __init__(
        self, share: ShareFunction, whole: WholeFunction, corners: int,
        columns: Mapping[str, int], widths: Mapping[str, int],
    ):  # fmt: skip
        def parts(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Shares:
            found = share([each - x[corners] for each in x[:corners]], p)
            return Shares(found, found)

        def factors(sums: Vector, seen: Vector, p: Numbers) -> Factors:
            self.energy = traced(whole, lambda: whole(sums, seen, p))
            amount, rate = (self.graph.input(f"a.{k}") for k in range(2))
            supply = along([self.energy], {amount: rate})[0]
            return Factors(gradient(self.energy, sums), supply)

        super().__init__(parts, factors, corners, columns, widths)

    @cached_property
    def bend(self) -> list[Number]:
        """Return ∂²U/∂s∂s, its lower half row by row."""
        return list(hessian(self.energy, self.sums).values())
