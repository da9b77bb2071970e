"""What follows from the energy at one point of an element: stress, and rates of what it stores.

With the deformation F = Σ x_a ⊗ ∂N_a/∂X at points of the volume w, an element stores

    E = Σ w W(F, T, p) + V U(M, p),    M = Σ w r(F)/V,

for numbers p of the element and tensors T that it remembers, and dissipates by a potential D of
Ḟ per volume. So its nodes are pushed by -Σ w P ∂N_a/∂X with

    P = ∂W/∂F + U'(M) ∂r/∂F + ∂D/∂Ḟ,

and what is lost per volume is Ḟ:∂D/∂Ḟ - ∂W/∂T:dT/dt.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple, TypeAlias

from tissuec.autodiff.derivatives import along, gradient, hessian
from tissuec.autodiff.graph import Graph, Number, Operand
from tissuec.autodiff.potentials import Numbers
from tissuec.autodiff.tensors import Tensor, Vector, dot

#: Rows and columns of the six numbers of a symmetric tensor.
SIX = (0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)


class PointState(NamedTuple):
    """What a point stores and dissipates, per volume.

    Attributes:
        energy: W [Pa].
        dissipation: D [W/m³].
        pooled: r, whose mean over the points of an element counts.
        rates: dT/dt [1/s], of which the upper halves count.
        seen: Further numbers that are asked for, by name.
    """

    energy: Number
    dissipation: Operand
    pooled: Number
    rates: Sequence[Tensor] = ()
    seen: Mapping[str, Sequence[Number]] = {}


#: Takes F, dF/dt, the tensors that are remembered, and the numbers of the element.
PointFunction: TypeAlias = Callable[[Tensor, Tensor, Sequence[Tensor], Numbers], PointState]
#: Takes the mean of what is pooled, and the numbers; returns U [Pa].
MeanFunction: TypeAlias = Callable[[Number, Numbers], Number]


class TracedPoint:
    """A point of an element whose energy was traced.

    Attributes:
        widths: By name, how many components a number of the element has. Tensors have a
            ``rate``, the factor of T - 1 in the velocities of hidden nodes, and its inverse,
            which is zero in elements without the tensor.
        tensors: How many tensors a point remembers.
        graph: All that follows.
        f, rate: F and dF/dt, row by row, nine numbers each.
        stored: T - 1, six numbers for each tensor.
        state: At the point.
    """

    def __init__(
        self, point: PointFunction, mean: MeanFunction, widths: Mapping[str, int], tensors: int
    ):
        self.widths, self.tensors, self.graph = dict(widths), tensors, Graph()
        if tensors:
            self.widths |= {"rate": tensors, "inverse_rate": tensors}
        nine = range(9)
        self.f = [self.graph.input(f"f.{k}") for k in nine]
        self.rate = [self.graph.input(f"g.{k}") for k in nine]
        self.stored = [
            [self.graph.input(f"t.{tensor}.{k}") for k in range(len(SIX))]
            for tensor in range(tensors)
        ]
        vectors = {name: self._number(name, width) for name, width in self.widths.items()}
        self.numbers = [each for vector in vectors.values() for each in vector]
        given = Numbers(
            {
                name: each if self.widths[name] != 1 else each[0]
                for name, each in vectors.items()
            }
        )
        f, rate = (Tensor((nine[:3], nine[3:6], nine[6:])) for nine in (self.f, self.rate))
        self.state = point(f, rate, [_symmetric(six) for six in self.stored], given)
        self.mean, self.swell = self.graph.input("mean"), self.graph.input("swell")
        self.of_mean = mean(self.mean, given)

    def _number(self, name: str, width: int) -> Vector:
        return Vector(self.graph.input(f"p.{name}.{k}") for k in range(width))

    @property
    def scales(self) -> list[Number]:
        """Return the rates of T - 1 and their inverses."""
        names = ("rate", "inverse_rate") if self.tensors else ()
        return [
            self.graph.input(f"p.{name}.{k}") for name in names for k in range(self.tensors)
        ]

    @cached_property
    def slope_of_mean(self) -> Number:
        """Return U'(M), the input ``swell`` of what follows."""
        return gradient(self.of_mean, [self.mean])[0]

    @property
    def dissipation(self) -> Number:
        """Return D."""
        return self.graph.number(self.state.dissipation)

    @cached_property
    def stress(self) -> list[Number]:
        """Return P, nine numbers."""
        elastic = gradient(self._elastic, self.f)
        viscous = gradient(self.dissipation, self.rate)
        return [a + b for a, b in zip(elastic, viscous, strict=True)]

    @cached_property
    def rates(self) -> list[Number]:
        """Return dT/dt of all tensors, six numbers each [1/s]."""
        return [rate.rows[i][j] for rate in self.state.rates for i, j in SIX]

    @cached_property
    def power(self) -> Number:
        """Return what is lost per volume [W/m³]."""
        viscous = along([self.dissipation], dict(zip(self.rate, self.rate, strict=True)))[0]
        if not self.rates:
            return viscous
        flat = [each for six in self.stored for each in six]
        return viscous - dot(gradient(self.state.energy, flat), self.rates)

    # --- second derivatives -------------------------------------------------------------------

    @property
    def _elastic(self) -> Number:
        return self.state.energy + self.swell * self.state.pooled

    @cached_property
    def moduli(self) -> list[Number]:
        """Return ∂²(W + U' r)/∂F∂F at a constant mean, the lower half of 9 x 9 by rows."""
        found = hessian(self._elastic, self.f)
        return [found[i, j] for i in range(9) for j in range(i + 1)]

    @cached_property
    def pooling(self) -> list[Number]:
        """Return ∂r/∂F, nine numbers."""
        return gradient(self.state.pooled, self.f)

    @cached_property
    def bend_of_mean(self) -> Number:
        """Return U''(M)."""
        return gradient(self.slope_of_mean, [self.mean])[0]

    @cached_property
    def viscous_moduli(self) -> list[Number]:
        """Return ∂²D/∂Ḟ∂Ḟ, the lower half of 9 x 9 by rows."""
        found = hessian(self.dissipation, self.rate)
        return [found[i, j] for i in range(9) for j in range(i + 1)]

    @cached_property
    def tangents(self) -> list[Number]:
        """Return ∂P/∂T, ∂(dT/dt)/∂T and ∂(dT/dt)/∂F, column by column.

        Columns are the six numbers of each tensor, which have the changes of P and of all
        rates, and then the components of F, which have those of all rates.
        """
        found: list[Number] = []
        for each in (each for six in self.stored for each in six):
            found += along([*self.stress, *self.rates], {each: 1.0})
        for each in self.f:
            found += along(self.rates, {each: 1.0})
        return found


def _symmetric(six: Sequence[Number]) -> Tensor:
    """Return 1 and what is stored."""
    rows = (0, 5, 4), (5, 1, 3), (4, 3, 2)
    return Tensor(
        [six[k] + 1.0 if i == j else six[k] for j, k in enumerate(row)]
        for i, row in enumerate(rows)
    )
