"""Active fibres: muscle that pulls along the fibres of elements.

A family of fibres along the unit vector a, as drawn without stress, is stretched by λ = |F a|.
Its active nominal stress S(t) φ(λ) is a force along the fibres per area without stress, so that

    P = S φ(λ) (F a ⊗ a)/λ,    force on node n = -∫ S φ(λ) (F a)/λ (∂N_n/∂X · a) dV.

At a given time it has the potential ∫ S Φ(λ) dV with Φ' = φ, whose change is work from outside:
the metabolism of muscle supplies it. φ = 1 without limits of the stretch; between the limits l
and h it is the bump

    φ = (1 - q²)²,    q = (2 λ - l - h)/(h - l),

which is 1 in the middle, 0 at both limits and beyond, and has no corner. Active stress of this
kind beside the passive law of the tissue: P. J. Hunter, A. D. McCulloch, H. E. D. J. ter Keurs,
Prog. Biophys. Mol. Biol. 69:289, 1998.
"""

from collections.abc import Iterator, Sequence
from functools import cache
from math import inf
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from tissuec.autodiff import Number, Numbers, Tensor, Vector, hessian, maximum, minimum, norm
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.points import PointState, TracedPoint
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops.point_derivatives import pull_loop, push_loop
from tissuec.compiled.loops.point_frame import PointTable
from tissuec.compiled.loops.points import force_loop
from tissuec.compiled.loops.terms import OF_TERMS, term_at, terms_of
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.fields import SECONDS, Items, WalledField
from tissuec.forces.matrices import BlockPattern, ForceDerivatives, whole, without_negative
from tissuec.forces.point_kernels import kernel_of
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.blocks import FieldBlock
from tissuec.model.cut_cells import CutCells
from tissuec.model.network import Floats, Indices, Network
from tissuec.model.profiles import TimeProfile

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

#: Limits of the stretch of fibres that pull at any stretch.
UNLIMITED = (0.0, -inf)


class Activation(WalledField, frozen=True):
    """Active stress in elements of one shape, along all of their families of fibres.

    Attributes:
        key: Name of the block; no two have the same.
        name: Of the set or body that is active.
        nodes: Of the elements, shape (element, node).
        slopes: ∂N/∂X · a [1/m], shape (element, line, node); a line is a family at a point.
        weight: Volume without stress of the point [m³], shape (element, line).
        amount: S where the profile is 1 [Pa].
        low, high: Limits of λ; ``UNLIMITED`` without.
        profile: Of S.
        span: The sentence.
    """

    key: str
    name: str
    nodes: Indices
    slopes: Floats
    weight: Floats
    amount: float
    low: float
    high: float
    profile: TimeProfile
    span: Span

    @classmethod
    def of(
        cls,
        key: str,
        name: str,
        elements: Any,
        items: Indices,
        amount: float,
        limits: tuple[float, float],
        profile: TimeProfile,
        span: Span,
    ) -> Self:
        """Return the activation of some elements.

        Args:
            key, name, amount, profile, span: As of the class.
            elements: Of a solid or a wall, with fibres.
            items: Numbers of those that are active, ascending, shape (n,).
            limits: Of λ.
        """
        count = elements.item_count
        others = np.setdiff1d(np.arange(int(count)), items)
        own = elements.without(others) if len(others) else elements
        slopes, weight = own.fibre_lines
        return cls(
            own.walls, own.walled, key, name, own.nodes, slopes, weight, amount, *limits,
            profile, span,
        )  # fmt: skip

    def with_parts(self, fields: Sequence[Any], parts: CutCells) -> Self:
        """Return the activation with the elements that cuts have made of its own.

        Args:
            fields: Elements that cuts have made.
            parts: All parts that cuts have made.
        """
        drawn = np.flatnonzero(~np.isin(self.walls, parts.parts))
        found = [self.without(np.setdiff1d(np.arange(self.item_count), self.walled[drawn]))]
        for each in fields:
            if each.nodes.shape[1] != self.nodes.shape[1]:
                continue
            active = np.isin(parts.wholes_of(each.walls), found[0].walls)
            own = each.without(np.flatnonzero(~active))
            slopes, weight = own.fibre_lines
            found.append(
                replace(
                    self, walls=own.walls, walled=own.walled, nodes=own.nodes, slopes=slopes,
                    weight=weight,
                )
            )  # fmt: skip
        first = np.cumsum([0, *(each.item_count for each in found)])
        walled = [each.walled + k for each, k in zip(found, first, strict=False)]
        names = ("walls", "nodes", "slopes", "weight")
        columns = {
            name: np.concatenate([getattr(one, name) for one in found]) for name in names
        }
        return replace(self, **columns, walled=np.concatenate(walled))

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(self.key, "activation", self, self.span)

    @property
    def item_count(self) -> int:
        """Return the number of elements."""
        return len(self.nodes)

    def stress(self, time: Floats | float) -> Floats:
        """Return S [Pa], shape (…)."""
        return np.asarray(self.amount * self.profile.at(time)[0])

    # --- forces at rest -----------------------------------------------------------------------

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…): none."""
        return np.zeros(position.shape[:-2])

    def potential(self, time: Floats | float, position: Floats) -> Floats:
        """Return ∫ S (Φ(λ) - Φ(1)) dV [J], shape (…)."""
        found = np.zeros(position.shape[:-2])
        for _, own in self.in_blocks():
            ((longer,), (rest,)) = (own._seen("pull", f) for f in (own._along(position), _ONE))
            found += (own.weight * (longer - rest)).sum(axis=(-1, -2))
        return self.stress(time) * found

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return ∂²/∂x∂x of the potential [N/m], shape (3 size, 3 size).

        Without ``exact``, negative eigenvalues of each line count as zero.
        """
        pattern = BlockPattern.of(number[self.nodes], size)
        room = pattern.room
        for part, own in self.in_blocks():
            bends = own._seen("bends", own._along(position))
            each = float(self.stress(time)) * whole(np.stack(bends, axis=-1))
            if not exact:
                each = without_negative(each)
            each = own.weight[..., None, None] * each
            blocks = np.einsum("ela,elxy,elb->eaxby", own.slopes, each, own.slopes)
            pattern.add(blocks, part, room)
        return pattern.matrix(room)

    # --- for the engine -----------------------------------------------------------------------

    @property
    def kernel(self) -> GeneratedKernel:
        """Return the loop that adds forces and the power that they supply."""
        return kernel_of(force_loop, traced_line, self._is_limited, *self._shape)

    @property
    def derivatives(self) -> ForceDerivatives:
        """Return the derivatives of forces by positions."""
        loops = (
            kernel_of(each, traced_line, self._is_limited, (), *self._shape)
            for each in (pull_loop, push_loop)
        )
        return ForceDerivatives((), *loops)

    @property
    def changes(self) -> Sequence[tuple[float, TimeProfile]]:
        """Return the stress and its profile."""
        return ((self.amount, self.profile),)

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]."""
        return SECONDS * 3 * self.slopes.size

    def items(self, place: Indices) -> Items:
        """Return the nodes of the elements."""
        return Items.of(place[self.nodes])

    def only(self, items: Indices) -> Self:
        """Return some elements, by indices of shape (n,), with the walls of all."""
        return replace(
            self, nodes=self.nodes[items], slopes=self.slopes[items], weight=self.weight[items]
        )

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> PointTable:
        """Return the record of the kernel, which is valid at any position."""
        every = np.arange(self.item_count)
        numbers = np.append([self.low, self.high], terms_of(acts))
        columns = np.repeat(numbers[:, None], len(every), axis=1)
        none, slopes = every[None][:0], self.slopes[..., None]
        return PointTable.of(place[self.nodes], columns, every, slopes, self.weight, none)

    # --- parts --------------------------------------------------------------------------------

    @property
    def _is_limited(self) -> bool:
        return self.high > self.low

    @property
    def _shape(self) -> tuple[int, int]:
        """Return the numbers of nodes and lines of an element."""
        lines, nodes = self.slopes.shape[1:]
        return nodes, lines

    def _along(self, position: Floats) -> Floats:
        """Return F a of each line, shape (…, element, line, 3)."""
        return np.asarray(self.slopes @ position[..., self.nodes, :])

    def _seen(self, name: str, along: Floats) -> list[Floats]:
        """Return numbers of lines for S = 1, of the shape of F a without its last axis."""
        values = {f"f.{k}": along[..., k] for k in range(3)}
        values |= {"p.low.0": self.low, "p.high.0": self.high}
        return evaluate(traced_line(self._is_limited).state.seen[name], values)


#: F a, the stretched direction of a line, as drawn.
_ONE = np.array([1.0, 0.0, 0.0])


@cache
def traced_line(is_limited: bool) -> TracedPoint:
    """Return a point of a line of fibres, whose F is F a."""

    def point(f: Tensor, rate: Tensor, tensors: Sequence[Tensor], p: Numbers) -> PointState:
        along = Vector(f.flat)
        pull = _pull(norm(along), p) if is_limited else norm(along)
        seen = {"pull": [pull], "bends": list(hessian(pull, along).values())}
        stored = term_at(p, pull.graph) * pull
        return PointState(stored, 0.0, seen=seen, is_supplied=True)

    return TracedPoint(point, None, {"low": 1, "high": 1, **OF_TERMS}, 0, directions=1)


def _pull(stretch: Number, p: Numbers) -> Number:
    """Return Φ between limits."""
    width = p.high - p.low
    q = (2.0 * stretch - p.low - p.high) / width
    q = minimum(maximum(q, -1.0), 1.0)
    return 0.5 * width * (q - 2.0 / 3.0 * q**3 + 0.2 * q**5)


def activated(network: Network, nodes: Indices) -> Iterator[tuple[Any, Indices]]:
    """Yield elements that have fibres, with the numbers of those among some nodes.

    Args:
        nodes: Numbers of nodes, shape (node,); an element is active if all of its nodes are
            among them.

    Yields:
        Elements of one shape, and the numbers of the active ones, ascending, shape (n,).
    """
    inside = np.zeros(network.node_count, dtype=bool)
    inside[nodes] = True
    for field in network.elements:
        if not field.fibres.along.shape[1]:
            continue
        items = np.flatnonzero(inside[field.nodes].all(axis=1))
        if len(items):
            yield field, items
