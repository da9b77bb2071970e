"""Elements the strains of whose points depend on all nodes together, not on gradients alone.

An element has vectors z, which are linear in the places of its nodes, and stores and
dissipates, per volume V as drawn,

    E = V (Σ W(Σ_t q_t(z) φ_t)/n + U(z)),    D likewise.

Each strain of its n points is a sum of coefficients q_t times ``TERMS``, φ_t, which are
products of the natural coordinates of the point. So z is pushed by -V Σ_t ∂q_t/∂z
(Σ ∂W/∂q φ_t)/n - V ∂U/∂z.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import accumulate
from typing import NamedTuple, TypeAlias

from tissuec.autodiff.derivatives import along, gradient
from tissuec.autodiff.graph import Graph, Number, Operand
from tissuec.autodiff.potentials import Numbers, numbers_in
from tissuec.autodiff.tensors import Vector, dot


class CellState(NamedTuple):
    """What an element gives its points, and what it stores and dissipates by itself.

    Attributes:
        strains: q, the coefficients of each strain: of the first ``TERMS``.
        energy: U [Pa].
        dissipation: Of the element alone, per volume [W/m³].
        ratio: Its volume over that as drawn.
        volumetric: The part of the energy that depends on the ratio alone.
        between: Numbers of which strains and energy follow.
        inner: Vectors of which most of these follow; linear in those of z, with factors that
            hold for all three components.
    """

    strains: Sequence[Sequence[Number]]
    energy: Number
    dissipation: Operand
    ratio: Number
    volumetric: Number
    between: Sequence[Number]
    inner: Sequence[Vector]


#: Natural coordinates of which the terms of strains are products.
TERMS = ((), (0,), (1,), (2,), (1, 2), (2, 0), (0, 1))

#: Takes z, dz/dt, numbers of the element as drawn, and its numbers.
CellFunction: TypeAlias = Callable[
    [Sequence[Vector], Sequence[Vector], Numbers, Numbers], CellState
]
#: Takes places of nodes, and returns z.
VectorsFunction: TypeAlias = Callable[[Sequence[Vector]], Sequence[Vector]]


class CellKind(NamedTuple):
    """What strains the points of an element.

    Attributes:
        function: What follows from z.
        vectors: Returns z.
        nodes: How many it has.
        widths: By name, how many components a number of the element as drawn has; one of them
            is its ``volume``.
    """

    function: CellFunction
    vectors: VectorsFunction
    nodes: int
    widths: Mapping[str, int]


class TracedCell:
    """An element whose strains were traced.

    Args:
        kind: What strains its points.
        graph: Of its points.
        given: Numbers of the element.

    Attributes:
        places: Components of places of nodes, inputs "node.k", shape (3 node,).
        vectors: Those of z by them.
        x, v: Components of z and dz/dt, shape (3 vector,).
        drawn: Components of numbers as drawn, one after the other.
        state: What follows from them.
        begins: Where the coefficients of each strain begin among all.
        active: The coefficients on which energies and rates of points depend.
    """

    def __init__(self, kind: CellKind, graph: Graph, given: Numbers):
        self.graph = graph
        self.drawn, drawn = numbers_in(graph, kind.widths, letter="c")
        self.places = [graph.input(f"node.{k}") for k in range(3 * kind.nodes)]
        self.vectors = [a for each in kind.vectors(_threes(self.places)) for a in each]
        self.x, self.v = (
            [graph.input(f"{name}.{k}") for k in range(len(self.vectors))] for name in "xv"
        )
        self.state = kind.function(_threes(self.x), _threes(self.v), drawn, given)
        self.volume: Number = drawn.volume
        self.energy = self.volume * self.state.energy
        self.loss = self.volume * graph.number(self.state.dissipation)
        self.begins = [0, *accumulate(map(len, self.state.strains))]
        self.active: Sequence[int] = ()

    @cached_property
    def strains(self) -> list[Number]:
        """Return all q, strain by strain."""
        return [each for own in self.state.strains for each in own]

    @cached_property
    def spread(self) -> list[Number]:
        """Return the forces on nodes; the inputs "push.k" are those on z."""
        pushed = [self.graph.input(f"push.{k}") for k in range(len(self.x))]
        return gradient(dot(pushed, self.vectors), self.places)

    @cached_property
    def rates(self) -> list[Number]:
        """Return dq/dt."""
        return along(self.strains, dict(zip(self.x, self.v, strict=True)))

    @cached_property
    def elastic(self) -> list[Number]:
        """Return forces on z without the braking of the element; "pull.k" are those on q."""
        return gradient(self._work - self.energy, self.x)

    @cached_property
    def braking(self) -> list[Number]:
        """Return forces on z without those of its own energy; "pull.k" are those on q."""
        both = zip(gradient(self._work, self.x), self._lost, strict=True)
        return [a - b for a, b in both]

    @cached_property
    def pull(self) -> list[Number]:
        """Return the forces on z; the inputs "pull.k" are those on q."""
        return [a - b for a, b in zip(self.elastic, self._lost, strict=True)]

    @cached_property
    def _lost(self) -> list[Number]:
        return gradient(self.loss, self.v)

    @property
    def _work(self) -> Number:
        return dot(self.weights("pull"), [self.strains[k] for k in self.active])

    @property
    def swell(self) -> Number:
        """Return the derivative of the energy by the ratio of volumes [Pa]."""
        return gradient(self.state.volumetric, [self.state.ratio])[0]

    @cached_property
    def power(self) -> Number:
        """Return the power that the element alone loses [W]."""
        return along([self.loss], dict(zip(self.v, self.v, strict=True)))[0]

    def weights(self, name: str) -> list[Number]:
        """Return inputs, one for each active coefficient."""
        return [self.graph.input(f"{name}.{k}") for k in self.active]

    # --- matrices: of E by numbers b in between, by vectors, and by nodes ---------------------

    @cached_property
    def shares(self) -> list[list[Number]]:
        """Return the derivatives of each vector of z by each node."""
        return [gradient(each, self.places[::3]) for each in self.vectors[::3]]

    @cached_property
    def inner_shares(self) -> list[list[Number]]:
        """Return the derivatives of each inner vector by each vector of z."""
        return [gradient(each[0], self.x[::3]) for each in self.state.inner]

    @cached_property
    def inner(self) -> list[int]:
        """Return the numbers b that follow from inner vectors, if these are not those of z."""
        by = self._by(is_inner=True)
        if by == self.x:
            return []
        return [
            k
            for k, each in enumerate(self.state.between)
            if all(slope.value == 0.0 for slope in gradient(each, self.x, by))
        ]

    @cached_property
    def strain_slopes(self) -> dict[tuple[int, int], Number]:
        """Return the derivatives of q by b that are not zero, by the places of both."""
        between = self.state.between
        return {
            (q, k): slope
            for q in self.active
            for k, slope in enumerate(gradient(self.strains[q], between, between))
            if slope.value != 0.0
        }

    @cached_property
    def by_between(self) -> list[Number]:
        """Return the derivatives of U V - pull·q by b."""
        return gradient(self.energy - self._work, self.state.between, self.state.between)

    @cached_property
    def between_moduli(self) -> dict[tuple[int, int], Number]:
        """Return second derivatives of U V - pull·q by b that are not zero, i >= j."""
        return _bends(self.by_between, self.state.between)

    def between_slopes(
        self, numbers: Iterable[int], *, is_inner: bool
    ) -> dict[tuple[int, int], Number]:
        """Return the derivatives of some b by components of vectors that are not zero.

        Args:
            numbers: Of b.
            is_inner: By inner vectors, or by those of z.
        """
        by = self._by(is_inner=is_inner)
        return {
            (k, m): slope
            for k in numbers
            for m, slope in enumerate(gradient(self.state.between[k], by, by))
            if slope.value != 0.0
        }

    def vector_moduli(
        self, numbers: Sequence[int], *, is_inner: bool
    ) -> dict[tuple[int, int], Number]:
        """Return second derivatives of Σ by·b likewise; the inputs "by.k" are factors."""
        by = self._by(is_inner=is_inner)
        factors = [self.graph.input(f"by.{k}") for k in numbers]
        total = dot(factors, [self.state.between[k] for k in numbers])
        return _bends(gradient(total, by, by), by)

    def _by(self, *, is_inner: bool) -> list[Number]:
        return [each for vector in self.state.inner for each in vector] if is_inner else self.x

    # --- changes --------------------------------------------------------------------------

    def changed(self, outputs: Sequence[Number], more: Mapping[Number, Number]) -> list[Number]:
        """Return the changes of outputs; those of z and dz/dt are "dx.k", "dv.k".

        Args:
            more: Changes of other inputs.
        """
        return along(outputs, self._changes([*self.x, *self.v]) | dict(more))

    def carried(self, numbers: Sequence[Number] = ()) -> list[Number]:
        """Return the changes of q with z and some numbers."""
        return self.changed(self.strains, self._changes(numbers))

    def turned(self, numbers: Sequence[Number] = ()) -> list[Number]:
        """Return the changes of the rates of q with z, dz/dt and some numbers."""
        return self.changed(self.rates, self._changes(numbers))

    def _changes(self, inputs: Sequence[Number]) -> dict[Number, Number]:
        return {each: self.graph.input(f"d{each.operation.detail}") for each in inputs}

    @cached_property
    def braking_change(self) -> list[Number]:
        """Return the changes of ``braking``; see ``pushed``."""
        return self.changed(self.braking, self._changes(self.weights("pull")))

    def pushed(self, numbers: Sequence[Number]) -> list[Number]:
        """Return the changes of ``pull``, also with those of some numbers.

        Those of forces on strains are "dpull.k".
        """
        return self.changed(self.pull, self._changes([*self.weights("pull"), *numbers]))

    def pulled(self, numbers: Sequence[Number]) -> list[Number]:
        """Return derivatives of Σ w·pull, of "by_q.k" q, and of "by_rate.k" dq/dt.

        They are those by z, dz/dt and numbers; w are the inputs "load.k" of z.
        """
        weights = [self.graph.input(f"load.{k}") for k in range(len(self.x))]
        strains, rates = (
            [every[k] for k in self.active] for every in (self.strains, self.rates)
        )
        total = dot(weights, self.pull) + dot(self.weights("by_q"), strains)
        total = total + dot(self.weights("by_rate"), rates)
        return gradient(total, [*self.x, *self.v, *numbers])


def _threes(components: Sequence[Number]) -> list[Vector]:
    """Return vectors of three components each."""
    return [Vector(components[k : k + 3]) for k in range(0, len(components), 3)]


def _bends(slopes: Sequence[Number], by: Sequence[Number]) -> dict[tuple[int, int], Number]:
    """Return derivatives of a gradient that are not zero, by places i >= j."""
    return {
        (i, j): bend
        for i, slope in enumerate(slopes)
        for j, bend in enumerate(gradient(slope, by[: i + 1], by))
        if bend.value != 0.0
    }
