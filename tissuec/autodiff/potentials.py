"""What follows from the potential of one item, such as a hinge: forces, powers, matrices.

A potential is a function of points, velocities and numbers of an item. It returns the energy E
that the item stores [J], or this with the potential D of what it dissipates [W]. From them
follow, with the operations of ``derivatives``,

    f = -∂E/∂x - ∂D/∂v,    P = v·∂D/∂v,    ∂²E/∂x∂x,    ∂²D/∂v∂x,    ∂²D/∂v∂v,

and the derivatives of Σ w·f by everything, or the changes of f with everything. A force that
follows from neither, such as a pressure that turns with a face, is stated by the power L that
it supplies from outside at any velocities, by which it adds ∂L/∂v to f. Where E has no formula,
such as for a spring whose law is any curve, the function states the forces.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from tissuec.autodiff.derivatives import along, changed, gradient, jacobian, lower_half
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Graph, Inequality, Number, Operand, TracingError
from tissuec.autodiff.tensors import Vector, dot
from tissuec.autodiff.tracing import traced

#: Of an operation that is worth being done once for an item instead of in each evaluation.
_COSTLY = ("quotient", "sqrt", "exp", "log", "power", "sin", "cos")


class Potential(NamedTuple):
    """What an item stores and dissipates.

    Attributes:
        energy: E [J].
        dissipation: D, whose derivatives by velocities are forces against these [W].
        supply: L, proportional to velocities, whose derivatives by these are forces [W].
    """

    energy: Operand
    dissipation: Operand = 0.0
    supply: Operand = 0.0


class StatedForces(NamedTuple):
    """Forces of an item, in the place of potentials from which they follow.

    Attributes:
        elastic: -∂E/∂x of each corner [N].
        braking: -∂D/∂v of each corner [N].
        rates: Rates of internal variables.
    """

    elastic: Sequence[Vector]
    braking: Sequence[Vector]
    rates: Sequence[Operand] = ()


class Numbers:
    """Numbers of an item, as attributes; those with several components are vectors."""

    def __init__(self, numbers: Mapping[str, Number | Vector]):
        self.__dict__.update(numbers)

    def __getattr__(self, name: str) -> Any:
        raise TracingError(f'an item has no number "{name}"; it has {", ".join(vars(self))}')


def numbers_in(
    graph: Graph, widths: Mapping[str, int], *, changes: bool = False, letter: str = "p"
) -> tuple[list[Number], Numbers]:
    """Return numbers that are inputs of a graph: their components in order, and by name.

    Args:
        widths: By name, how many components a number has.
        changes: Whether there is an ``amount``, too, that changes in time.
        letter: With which the names of inputs begin.
    """
    found = {name: _number(graph, f"{letter}.{name}", width) for name, width in widths.items()}
    given = {name: each[0] if len(each) == 1 else each for name, each in found.items()}
    if changes:
        given["amount"] = graph.input("a.0")
    return [each for number in found.values() for each in number], Numbers(given)


def _number(graph: Graph, name: str, width: int) -> Vector:
    return Vector(graph.input(f"{name}.{k}") for k in range(width))


def components(graph: Graph, widths: Mapping[str, int], names: Iterable[str]) -> list[Number]:
    """Return the components of some numbers, one after the other."""
    return [each for name in names for each in _number(graph, f"p.{name}", widths[name])]


#: Takes positions and velocities of the corners, and the numbers.
PotentialFunction: TypeAlias = Callable[
    [Sequence[Vector], Sequence[Vector], Numbers], Potential | StatedForces | Number
]


class TracedItem:
    """An item whose potential was traced.

    Args:
        function: The potential.
        corners, widths, seen, slots: As the attributes.
        graph: An empty one.
        changes: Whether the numbers have an ``amount`` that changes in time.

    Attributes:
        function: The potential.
        corners: Nodes of an item.
        seen: Further points of it, which count as fixed: no force acts on them.
        widths: By name, how many components a number of the item has.
        slots: How many internal variables an item has. They are components of velocities, which
            functions find as the number ``internal``.
        graph: All that follows.
        x, v: Components of positions and of velocities, node by node, shape (3 corner,).
        internal: The internal variables, shape (slot,).
        numbers: Components of the numbers, one after the other.
        potential: E, D and L, or the forces.
    """

    def __init__(
        self, function: PotentialFunction, corners: int, widths: Mapping[str, int],
        graph: Graph | None = None, *, seen: int = 0, changes: bool = False, slots: int = 0,
    ):  # fmt: skip
        self.function, self.corners, self.widths = function, corners, dict(widths)
        self.graph, self.seen, self.slots = graph or Graph(), seen, slots
        points, rates = self._points("x", seen), self._points("v", seen)
        self.x, self.v = self._flat(points[:corners]), self._flat(rates[:corners])
        self.internal = self._slots("v")
        self.numbers, given = numbers_in(self.graph, self.widths, changes=changes)
        if slots:
            vars(given)["internal"] = Vector(self.internal)
        self.potential = traced(function, lambda: self._checked(function(points, rates, given)))

    def _checked(self, found: Potential | StatedForces | Operand) -> Potential | StatedForces:
        """Return the result of a function; raises TracingError if it is of another kind."""
        if isinstance(found, StatedForces):
            return found
        if not isinstance(found, Potential):
            found = Potential(found)
        if any(not isinstance(each, Number | float | int) or isinstance(each, Inequality)
               for each in found):  # fmt: skip
            raise TracingError("it has to return an energy, or Potential(energy, dissipation)")
        energy, dissipation, supply = (self.graph.number(each) for each in found)
        if any(name.startswith("v.") for name in self.graph.inputs_of([energy])):
            raise TracingError(
                "its energy depends on velocities: return Potential(energy, dissipation)"
            )
        return Potential(energy, dissipation, supply)

    def _points(self, name: str, seen: int = 0) -> list[Vector]:
        return [
            Vector(self.graph.input(f"{name}.{corner}.{axis}") for axis in range(3))
            for corner in range(self.corners + seen)
        ]

    def _slots(self, name: str) -> list[Number]:
        """Return components of a vector, which are named by their places behind all points."""
        return [self.graph.input(f"{name}.slot.{place}") for place in self.places_of_slots]

    @property
    def places_of_slots(self) -> range:
        """Return the places of the internal variables behind those of points."""
        first = self.corners + self.seen
        return range(first, first + self.slots)

    def _flat(self, points: Sequence[Vector]) -> list[Number]:
        return [each for point in points for each in point]

    @property
    def energy(self) -> Number:
        """Return E."""
        return self._stated("energy")

    @property
    def dissipation(self) -> Number:
        """Return D."""
        return self._stated("dissipation")

    @property
    def supply(self) -> Number:
        """Return L."""
        return self._stated("supply")

    def _stated(self, name: str) -> Number:
        """Return a potential; zero where forces are stated instead."""
        return self.graph.number(getattr(self.potential, name, 0.0))

    @cached_property
    def is_held(self) -> bool:
        """Return whether E changes where all corners move alike: items then hold their nodes.

        This is tried in states drawn at random.
        """
        chance, count = np.random.default_rng(0), 64
        values = {str(each.operation.detail): chance.normal(size=count) for each in self.x}
        for each in self.numbers:
            values[str(each.operation.detail)] = chance.uniform(0.5, 1.5, count)
        slopes = np.stack(np.broadcast_arrays(*evaluate(self.stored, values)))
        left = slopes.reshape(self.corners, 3, -1).sum(axis=0)
        return bool((np.abs(left) > 1e-9 * np.abs(slopes).sum(axis=0)).any())

    @property
    def is_damped(self) -> bool:
        """Return whether anything is dissipated."""
        return any(each.value != 0.0 for each in self.braking)

    @cached_property
    def braking(self) -> list[Number]:
        """Return ∂D/∂v, shape (3 corner,)."""
        if isinstance(self.potential, StatedForces):
            return self._flat([-each for each in self.potential.braking])
        return gradient(self.dissipation, self.v)

    @cached_property
    def stored(self) -> list[Number]:
        """Return ∂E/∂x, shape (3 corner,)."""
        if isinstance(self.potential, StatedForces):
            return self._flat([-each for each in self.potential.elastic])
        return gradient(self.energy, self.x)

    @cached_property
    def pushing(self) -> list[Number]:
        """Return ∂L/∂v, shape (3 corner,)."""
        return gradient(self.supply, self.v)

    @cached_property
    def forces(self) -> list[Number]:
        """Return f, and the rates of internal variables, shape (3 corner + slot,)."""
        parts = zip(self.pushing, self.stored, self.braking, strict=True)
        found = [c - (a + b) if c.value != 0.0 else -(a + b) for c, a, b in parts]
        rates = self.potential.rates if isinstance(self.potential, StatedForces) else ()
        return found + [self.graph.number(each) for each in rates]

    @cached_property
    def power(self) -> Number:
        """Return the power that is dissipated, v·∂D/∂v, but for internal variables [W]."""
        if isinstance(self.potential, StatedForces):
            return dot(self.v, self.braking)
        # It is dD(s v)/ds at s = 1.
        changes = dict(zip(self.v, self.v, strict=True))
        return along([self.dissipation], changes)[0]

    @cached_property
    def matrix(self) -> dict[tuple[int, int], Number]:
        """Return ∂²E/∂x∂x, the entries of its lower half."""
        return lower_half(self.stored, self.x)

    @cached_property
    def damping_by_position(self) -> list[Number]:
        """Return ∂²D/∂v∂x, row by row, shape (3 corner · 3 corner,)."""
        return jacobian(self.braking, self.x)

    @cached_property
    def turning(self) -> list[Number]:
        """Return -∂²L/∂v∂x, row by row, shape (3 corner · 3 corner,)."""
        return [-each for each in jacobian(self.pushing, self.x)]

    @cached_property
    def damping_by_velocity(self) -> dict[tuple[int, int], Number]:
        """Return ∂²D/∂v∂v, the entries of its lower half."""
        return lower_half(self.braking, self.v)

    @cached_property
    def weights(self) -> list[Number]:
        """Return the weights w of forces and rates, shape (3 corner + slot,)."""
        return [*self._flat(self._points("w")), *self._slots("w")]

    def pulled(self, learnt: Sequence[str]) -> list[Number]:
        """Return the derivatives of w·f by x, v, internal variables and some numbers in turn.

        Args:
            learnt: Names of the numbers.
        """
        work = dot(self.weights, self.forces)
        return gradient(work, [*self.x, *self.v, *self.internal, *self.of(learnt)])

    def pushed(self, learnt: Sequence[str]) -> tuple[list[Number], dict[str, Number]]:
        """Return the changes of f, and the inputs that are those of what it depends on.

        Args:
            learnt: Names of the numbers that change.
        """
        return changed(self.forces, [*self.x, *self.v, *self.internal, *self.of(learnt)])

    def of(self, names: Sequence[str]) -> list[Number]:
        """Return the components of some numbers."""
        return components(self.graph, self.widths, names)

    @cached_property
    def constants(self) -> list[Number]:
        """Return costly results that depend on numbers alone: one computation an item."""
        graph, operations = self.graph, self.graph.operations
        order = graph.reached([*self.forces, self.power])
        varies, is_costly = set[int](), set[int]()
        for place in order:
            name, _, detail = operations[place]
            arguments = graph.arguments_of(place, by_rules=False)
            if name == "input" and not str(detail).startswith("p."):
                varies.add(place)
            needs_costly = not is_costly.isdisjoint(arguments)
            # Tables have numbers and no conditions.
            if not varies.isdisjoint(arguments) or (name == "greater" and needs_costly):
                varies.add(place)
            elif name in _COSTLY or needs_costly:
                is_costly.add(place)
        needed = {
            each
            for place in varies
            for each in graph.arguments_of(place, by_rules=False)
            if each in is_costly
        }
        return [Number(graph, place) for place in sorted(needed)]
