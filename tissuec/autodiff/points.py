"""What follows from the energy at one point of an element: stress, and rates of what it stores.

With the deformation F = Σ x_a ⊗ ∂N_a/∂X at points of the volume w, by the three directions of
space, or by the two of a wall, or the one of fibres, an element stores

    E = Σ w W(F, T, p) + V U(M, p),    M = Σ w r(F)/V,

for numbers p of the element and tensors T that it remembers, and dissipates by a potential D of
Ḟ per volume. With several functions φ_k of the place, of which V δ_kl = Σ w φ_k φ_l, points
have the projection of r instead of its mean:

    E = Σ w (W(F, T, p) + U(M, p)),    M = Σ_k φ_k m_k,    m_k = Σ w φ_k r(F)/V,

and in what follows, the projection of U'(M) in the place of U'(M). Nodes are pushed by
-Σ w P ∂N_a/∂X with

    P = ∂W/∂F + U'(M) ∂r/∂F + ∂D/∂Ḟ,

and the power that is lost per volume is Ḟ:∂D/∂Ḟ - ∂W/∂T:dT/dt.
"""

from collections.abc import Callable, Container, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple, TypeAlias, cast

from tissuec.autodiff.cells import CellKind, TracedCell
from tissuec.autodiff.derivatives import along, changed, gradient, hessian, jacobian
from tissuec.autodiff.graph import Graph, Number, Operand
from tissuec.autodiff.potentials import Numbers, components, numbers_in
from tissuec.autodiff.tensors import PLACES, Tensor, dot, from_half


class PointState(NamedTuple):
    """What a point stores and dissipates, per volume.

    Attributes:
        energy: W [Pa].
        dissipation: D [W/m³].
        pooled: r, whose mean over the points of an element counts; zero if none does.
        rates: dT/dt [1/s], of which the upper halves count.
        seen: Further numbers that are asked for, by name.
        is_supplied: Whether what pulls takes its energy from outside, and gives it there.
    """

    energy: Number
    dissipation: Operand
    pooled: Operand = 0.0
    rates: Sequence[Tensor] = ()
    seen: Mapping[str, Sequence[Number]] = {}
    is_supplied: bool = False


#: Takes F, dF/dt, the tensors that are remembered, and the numbers of the element.
PointFunction: TypeAlias = Callable[[Tensor, Tensor, Sequence[Tensor], Numbers], PointState]
#: Takes the strains of a point of a cell, their rates, tensors and numbers.
BentFunction: TypeAlias = Callable[
    [Sequence[Number], Sequence[Number], Sequence[Tensor], Numbers], PointState
]
#: Takes the mean of what is pooled, and the numbers; returns U [Pa].
MeanFunction: TypeAlias = Callable[[Number, Numbers], Number]


class TracedPoint:
    """A point of an element whose energy was traced.

    Attributes:
        widths: By name, how many components a number of the element has. Tensors have a
            ``rate``, the factor of T - 1 among internal variables, and its inverse, which is
            zero in elements without the tensor.
        tensors: How many tensors a point remembers.
        directions: Columns of F: 3, 2 in a wall, or 1 along fibres.
        functions: φ, of which the first is 1: the mean.
        graph: All that follows.
        cell: What strains points instead of F; None without.
        f, rate: F and dF/dt, row by row, shape (3 directions,); or strains of a cell.
        stored: T - 1, the numbers of each tensor.
        state: At the point.
    """

    def __init__(
        self, point: PointFunction | BentFunction, mean: MeanFunction | None,
        widths: Mapping[str, int], tensors: int, directions: int = 3,
        cell: "CellKind | None" = None, functions: int = 1,
    ):  # fmt: skip
        self.functions = functions
        self.widths, self.tensors, self.graph = dict(widths), tensors, Graph()
        self.directions, self.places = directions, PLACES[directions]
        if tensors:
            self.widths |= {"rate": tensors, "inverse_rate": tensors}
        self.numbers, given = numbers_in(self.graph, self.widths)
        self.cell = cell and TracedCell(cell, self.graph, given)
        every = range(3 * directions if self.cell is None else len(self.cell.state.strains))
        self.f = [self.graph.input(f"f.{k}") for k in every]
        self.rate = [self.graph.input(f"g.{k}") for k in every]
        self.stored = [
            [self.graph.input(f"t.{tensor}.{k}") for k in range(len(self.places))]
            for tensor in range(tensors)
        ]
        tensors_of = [self._symmetric(numbers) for numbers in self.stored]
        if self.cell is None:
            strained = self.tensor(self.f), self.tensor(self.rate)
            self.state = cast(PointFunction, point)(*strained, tensors_of, given)
        else:
            bent = cast(BentFunction, point)
            self.state = bent(self.f, self.rate, tensors_of, given)
            first = self.cell.begins
            self.cell.active = [q for k in self.active for q in range(first[k], first[k + 1])]
        self.mean, self.swell = self.graph.input("mean"), self.graph.input("swell")
        self.of_mean = self.graph.number(0.0 if mean is None else mean(self.mean, given))

    def tensor(self, numbers: Sequence[Number]) -> Tensor:
        """Return a tensor like F from its numbers, row by row."""
        width = self.directions
        return Tensor(numbers[k : k + width] for k in range(0, 3 * width, width))

    def _symmetric(self, numbers: Sequence[Number]) -> Tensor:
        """Return 1 and what is stored."""
        parts = zip(numbers, self.places, strict=True)
        return from_half([each + float(i == j) for each, (i, j) in parts], self.directions)

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

    def mean_of(self, number: Number) -> Number:
        """Return the mean of a number of points over the volume of an element.

        It is an input of numbers of the whole element; see ``averaged``.
        """
        return self.graph.input(f"mean.{number.place}")

    def averaged(self, outputs: Sequence[Number]) -> dict[str, Number]:
        """Return the numbers of points on whose means outputs depend, by their inputs."""
        names = (each for each in self.graph.inputs_of(outputs) if each.startswith("mean."))
        places = sorted(int(name.removeprefix("mean.")) for name in names)
        return {f"mean.{place}": Number(self.graph, place) for place in places}

    @cached_property
    def active(self) -> list[int]:
        """Return the numbers of strains on which energies and rates depend."""
        energies = [self.state.energy, self.dissipation, *self.rates]
        return self.needed_by(self.graph.inputs_of(energies))

    def needed_by(self, names: Container[str]) -> list[int]:
        """Return the strains that are inputs, or whose rates, changes or weights are."""
        letters = ("f", "g", "df", "dg", "w")
        return [
            k for k in range(len(self.f)) if any(f"{letter}.{k}" in names for letter in letters)
        ]

    @property
    def pooled(self) -> Number:
        """Return r."""
        return self.graph.number(self.state.pooled)

    @property
    def is_pooled(self) -> bool:
        """Return whether the mean of r counts."""
        return self.of_mean.value != 0.0

    @property
    def dissipation(self) -> Number:
        """Return D."""
        return self.graph.number(self.state.dissipation)

    @cached_property
    def elastic_stress(self) -> list[Number]:
        """Return P without its viscous part, row by row."""
        return gradient(self._elastic, self.f)

    @cached_property
    def stress(self) -> list[Number]:
        """Return P, row by row."""
        viscous = self.viscous_stress
        return [a + b for a, b in zip(self.elastic_stress, viscous, strict=True)]

    @cached_property
    def viscous_stress(self) -> list[Number]:
        """Return the viscous part of P, row by row."""
        return gradient(self.dissipation, self.rate)

    @cached_property
    def viscous_change(self) -> list[Number]:
        """Return the change of ``viscous_stress`` with those of F and dF/dt, "df.k", "dg.k"."""
        every = [*self.f, *self.rate]
        changes = {each: self.graph.input(f"d{each.operation.detail}") for each in every}
        return along(self.viscous_stress, changes)

    @cached_property
    def pull(self) -> list[Number]:
        """Return -w P, row by row; the input "pull" is minus the volume w of the point."""
        graph = self.graph
        stored, lost = (
            graph.input("pull") * each for each in (self._elastic, self.dissipation)
        )
        parts = zip(gradient(stored, self.f), gradient(lost, self.rate), strict=True)
        return [a + b for a, b in parts]

    @cached_property
    def rates(self) -> list[Number]:
        """Return dT/dt of all tensors, number by number [1/s]."""
        return [rate.rows[i][j] for rate in self.state.rates for i, j in self.places]

    @cached_property
    def power(self) -> Number:
        """Return the power that is lost, or supplied, per volume [W/m³]."""
        if self.state.is_supplied:
            return -dot(self.stress, self.rate)
        viscous = along([self.dissipation], dict(zip(self.rate, self.rate, strict=True)))[0]
        if not self.rates:
            return viscous
        flat = [each for numbers in self.stored for each in numbers]
        return viscous - dot(gradient(self.state.energy, flat), self.rates)

    # --- for learning ---------------------------------------------------------------------

    def of(self, names: Sequence[str]) -> list[Number]:
        """Return the components of some numbers."""
        return components(self.graph, self.widths, names)

    def _also(self, letter: str) -> list[list[Number]]:
        """Return inputs beside T - 1, the numbers of each tensor."""
        return [
            [self.graph.input(f"{letter}.{tensor}.{k}") for k in range(len(numbers))]
            for tensor, numbers in enumerate(self.stored)
        ]

    def pulled(self, learnt: Sequence[str]) -> list[Number]:
        """Return the derivatives of -P : W + h · dT/dt + b r by F, Ḟ, T and some numbers.

        The inputs "w.k", "h.t.k" and "share" are W, h and b.

        Args:
            learnt: Names of the numbers.
        """
        graph = self.graph
        weights = [graph.input(f"w.{k}") for k in range(len(self.f))]
        work = graph.input("share") * self.pooled - dot(weights, self.stress)
        for rate, weight in zip(self.state.rates, self._also("h"), strict=True):
            work = work + dot(weight, [rate.rows[i][j] for i, j in self.places])
        stored = [each for numbers in self.stored for each in numbers]
        return gradient(work, [*self.f, *self.rate, *stored, *self.of(learnt)])

    def _changed(self, outputs: Sequence[Number], learnt: Sequence[str]) -> list[Number]:
        """Return how outputs change with what a point depends on."""
        stored = [each for numbers in self.stored for each in numbers]
        every = [*self.f, *self.rate, *stored, *self.of(learnt), self.swell, self.mean]
        return changed(outputs, every)[0]

    def pushed(self, learnt: Sequence[str]) -> list[Number]:
        """Return the changes of P and of all dT/dt.

        The inputs "df.k", "dg.k", "dt.t.k", "dp.name.k" and "dswell" are changes of what these
        depend on.

        Args:
            learnt: Names of the numbers that change.
        """
        return self._changed([*self.stress, *self.rates], learnt)

    def pushed_mean(self, learnt: Sequence[str]) -> tuple[Number, Number]:
        """Return the changes of U'(M), by "dmean" and numbers, and of r."""
        of_mean, of_pooled = self._changed([self.slope_of_mean, self.pooled], learnt)
        return of_mean, of_pooled

    # --- second derivatives -------------------------------------------------------------------

    @property
    def _elastic(self) -> Number:
        return self.state.energy + self.swell * self.state.pooled

    @cached_property
    def moduli(self) -> list[Number]:
        """Return ∂²(W + U' r)/∂F∂F at a constant mean, the lower half of it by rows."""
        return list(hessian(self._elastic, self.f).values())

    @cached_property
    def active_moduli(self) -> dict[tuple[int, int], Number]:
        """Return ∂²W/∂f∂f of active strains where it is not zero, i >= j."""
        some = [self.f[k] for k in self.active]
        every = hessian(self.state.energy, some).items()
        return {
            (self.active[i], self.active[j]): bend
            for (i, j), bend in every if bend.value != 0.0
        }  # fmt: skip

    @cached_property
    def pooling(self) -> list[Number]:
        """Return ∂r/∂F, row by row."""
        return gradient(self.pooled, self.f)

    @cached_property
    def bend_of_mean(self) -> Number:
        """Return U''(M)."""
        return gradient(self.slope_of_mean, [self.mean])[0]

    @cached_property
    def viscous_moduli(self) -> list[Number]:
        """Return ∂²D/∂Ḟ∂Ḟ, the lower half of it by rows."""
        return list(hessian(self.dissipation, self.rate).values())

    @cached_property
    def viscous_by_strain(self) -> list[Number]:
        """Return ∂²D/∂Ḟ∂F, row by row."""
        return jacobian(gradient(self.dissipation, self.rate), self.f)

    @cached_property
    def tangents(self) -> list[Number]:
        """Return ∂P/∂T, ∂(dT/dt)/∂T and ∂(dT/dt)/∂F, column by column.

        Columns are the numbers of each tensor, which have the changes of P and of all rates,
        and then the components of F, which have those of all rates.
        """
        found: list[Number] = []
        for each in (each for numbers in self.stored for each in numbers):
            found += along([*self.stress, *self.rates], {each: 1.0})
        for each in self.f:
            found += along(self.rates, {each: 1.0})
        return found
