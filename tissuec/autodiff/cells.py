"""Elements whose points are strained by what their nodes do together, not by gradients alone.

An element at x stores and dissipates, per volume V as drawn,

    E = V (Σ W(q(x), at)/n + U(x)),    D likewise,

with strains q of the whole element, and n points that differ in where they are; see
``TracedPoint``. So its nodes are pushed by -V ∂q/∂x (Σ ∂W/∂q)/n - V ∂U/∂x.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple, TypeAlias

from tissuec.autodiff.derivatives import along, gradient
from tissuec.autodiff.graph import Graph, Number, Operand
from tissuec.autodiff.potentials import Numbers, numbers_in
from tissuec.autodiff.tensors import Vector, dot


class CellState(NamedTuple):
    """What an element gives its points, and what it stores and dissipates by itself.

    Attributes:
        strains: q.
        energy: U [Pa].
        dissipation: Of the element alone, per volume [W/m³].
        ratio: Its volume over that as drawn.
        volumetric: The part of the energy that depends on the ratio alone.
    """

    strains: Sequence[Number]
    energy: Number
    dissipation: Operand
    ratio: Number
    volumetric: Number


#: Takes positions and velocities of nodes, numbers of the element as drawn, and its numbers.
CellFunction: TypeAlias = Callable[
    [Sequence[Vector], Sequence[Vector], Numbers, Numbers], CellState
]


class CellKind(NamedTuple):
    """What strains the points of an element.

    Attributes:
        function: What follows from its nodes.
        nodes: How many it has.
        widths: By name, how many components a number of the element as drawn has; one of them
            is its ``volume``.
    """

    function: CellFunction
    nodes: int
    widths: Mapping[str, int]


class TracedCell:
    """An element whose strains were traced.

    Args:
        kind: What strains its points.
        graph: Of its points.
        given: Numbers of the element.

    Attributes:
        x, v: Components of positions and velocities of nodes, shape (3 node,).
        drawn: Components of numbers as drawn, one after the other.
        state: What follows from them.
    """

    def __init__(self, kind: CellKind, graph: Graph, given: Numbers):
        nodes = kind.nodes
        self.graph, self.nodes = graph, nodes
        self.x, self.v = (
            [graph.input(f"{name}.{k}") for k in range(3 * nodes)] for name in "xv"
        )
        self.drawn, drawn = numbers_in(graph, kind.widths, letter="c")
        places, moving = (
            [Vector(each[3 * a : 3 * a + 3]) for a in range(nodes)] for each in (self.x, self.v)
        )
        self.state = kind.function(places, moving, drawn, given)
        self.volume: Number = drawn.volume
        self.energy = self.volume * self.state.energy
        self.loss = self.volume * graph.number(self.state.dissipation)

    @property
    def strains(self) -> Sequence[Number]:
        """Return q."""
        return self.state.strains

    @cached_property
    def rates(self) -> list[Number]:
        """Return dq/dt."""
        return along(self.strains, dict(zip(self.x, self.v, strict=True)))

    @cached_property
    def elastic(self) -> list[Number]:
        """Return forces without the braking of the element; "pull.k" are those on strains."""
        return gradient(self._work - self.energy, self.x)

    @cached_property
    def braking(self) -> list[Number]:
        """Return forces without those of its own energy; "pull.k" are those on strains."""
        both = zip(gradient(self._work, self.x), self._lost, strict=True)
        return [a - b for a, b in both]

    @cached_property
    def pull(self) -> list[Number]:
        """Return the forces on nodes; the inputs "pull.k" are those on strains."""
        return [a - b for a, b in zip(self.elastic, self._lost, strict=True)]

    @cached_property
    def _lost(self) -> list[Number]:
        return gradient(self.loss, self.v)

    @property
    def _work(self) -> Number:
        return dot(self.weights("pull"), self.strains)

    @property
    def swell(self) -> Number:
        """Return the derivative of the energy by the ratio of volumes [Pa]."""
        return gradient(self.state.volumetric, [self.state.ratio])[0]

    @cached_property
    def power(self) -> Number:
        """Return the power that the element alone loses [W]."""
        return along([self.loss], dict(zip(self.v, self.v, strict=True)))[0]

    def weights(self, name: str) -> list[Number]:
        """Return inputs, one for each strain."""
        return [self.graph.input(f"{name}.{k}") for k in range(len(self.strains))]

    def changed(self, outputs: Sequence[Number], more: Mapping[Number, Number]) -> list[Number]:
        """Return the changes of outputs; those of places and velocities are "dx.k", "dv.k".

        Args:
            more: Changes of other inputs.
        """
        return along(outputs, self._changes([*self.x, *self.v]) | dict(more))

    def carried(self, numbers: Sequence[Number] = ()) -> list[Number]:
        """Return the changes of q with places and some numbers."""
        return self.changed(self.strains, self._changes(numbers))

    def turned(self, numbers: Sequence[Number] = ()) -> list[Number]:
        """Return the changes of the rates of q with places, velocities and some numbers."""
        return self.changed(self.rates, self._changes(numbers))

    def _changes(self, inputs: Sequence[Number]) -> dict[Number, Number]:
        return {each: self.graph.input(f"d{each.operation.detail}") for each in inputs}

    def stiffened(self, forces: str) -> list[Number]:
        """Return the changes of forces, "elastic" or "braking"; see ``pushed``."""
        return self.changed(getattr(self, forces), self._changes(self.weights("pull")))

    def pushed(self, numbers: Sequence[Number]) -> list[Number]:
        """Return the changes of ``pull``, also with those of some numbers.

        Those of forces on strains are "dpull.k".
        """
        return self.changed(self.pull, self._changes([*self.weights("pull"), *numbers]))

    def pulled(self, numbers: Sequence[Number]) -> list[Number]:
        """Return derivatives of Σ w·pull, of "by_q.k" q, and of "by_rate.k" dq/dt.

        They are those by places, velocities and numbers; w are the inputs "load.k" of nodes.
        """
        weights = [self.graph.input(f"load.{k}") for k in range(len(self.x))]
        total = dot(weights, self.pull) + dot(self.weights("by_q"), self.strains)
        total = total + dot(self.weights("by_rate"), self.rates)
        return gradient(total, [*self.x, *self.v, *numbers])
