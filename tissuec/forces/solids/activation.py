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

from collections.abc import Callable, Iterator, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from msgspec.structs import replace

from tissuec.core.source import Span
from tissuec.forces.fields import SECONDS, Items, WalledField
from tissuec.forces.matrices import assembled
from tissuec.forces.solids.activation_kernel import ActivationTable, contract_fibres
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices, Network
from tissuec.model.profiles import TimeProfile

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

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
            stretch = np.linalg.norm(own._along(position), axis=-1)
            longer = self._integral(stretch) - self._integral(np.ones(1))
            found += (own.weight * longer).sum(axis=(-1, -2))
        return self.stress(time) * found

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return ∂²/∂x∂x of the potential [N/m], shape (3 size, 3 size).

        Without ``exact``, negative eigenvalues of each line count as zero.
        """
        from scipy.sparse import coo_matrix, csr_matrix

        stress, total = float(self.stress(time)), csr_matrix((3 * size, 3 * size))
        for _, own in self.in_blocks():
            along = own._along(position)
            stretch = np.linalg.norm(along, axis=-1)
            safe = np.where(stretch > 0.0, stretch, 1.0)
            share, slope = self._share(stretch)
            lengthwise = stress * own.weight * np.where(stretch > 0.0, slope, 0.0)
            across = stress * own.weight * np.where(stretch > 0.0, share / safe, 0.0)
            if not exact:
                lengthwise, across = np.maximum(lengthwise, 0.0), np.maximum(across, 0.0)
            unit = along / safe[..., None]
            each = (
                (lengthwise - across)[..., None, None] * unit[..., :, None] * unit[..., None, :]
            )
            each += across[..., None, None] * np.eye(3)
            blocks = np.einsum("ela,elxy,elb->eaxby", own.slopes, each, own.slopes)
            total = total + assembled(blocks, number[own.nodes], size).tocsr()
        return coo_matrix(total)

    # --- for the engine -----------------------------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return contract_fibres

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
        count = self.nodes.shape[1]
        return Items(place[self.nodes].ravel(), count * np.arange(self.item_count + 1))

    def only(self, items: Indices) -> Self:
        """Return some elements, by indices of shape (n,), with the walls of all."""
        return replace(
            self, nodes=self.nodes[items], slopes=self.slopes[items], weight=self.weight[items]
        )

    def table(
        self, place: Indices, acts: BoundaryConditions, position: Floats
    ) -> ActivationTable:
        """Return the record of the kernel, which is valid at any position."""
        nodes = np.ascontiguousarray(place[self.nodes])
        return ActivationTable(acts, nodes, self.slopes, self.weight, self.low, self.high)

    # --- parts --------------------------------------------------------------------------------

    def _along(self, position: Floats) -> Floats:
        """Return F a of each line, shape (…, element, line, 3)."""
        return np.asarray(self.slopes @ position[..., self.nodes, :])

    def _share(self, stretch: Floats) -> tuple[Floats, Floats]:
        """Return φ and its derivative by λ, of the shape of λ."""
        if self.high <= self.low:
            return np.ones_like(stretch), np.zeros_like(stretch)
        width = self.high - self.low
        q = np.clip((2.0 * stretch - self.low - self.high) / width, -1.0, 1.0)
        return (1.0 - q * q) ** 2, -8.0 * q * (1.0 - q * q) / width

    def _integral(self, stretch: Floats) -> Floats:
        """Return Φ, of the shape of λ."""
        if self.high <= self.low:
            return stretch
        width = self.high - self.low
        q = np.clip((2.0 * stretch - self.low - self.high) / width, -1.0, 1.0)
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
