"""What follows from the potential of a pair, such as a node and a face, of which groups brake.

A surface brakes a node by the sums over its pairs with it: with δ, on which E depends, p =
∂E/∂δ, and c = ∂E/∂x·v,

    f = -F ∂E/∂x,    F = max(0, 1 + b Σ c / s),    s = max(Σ p, max p).
"""

from collections.abc import Sequence
from functools import cached_property

from tissuec.autodiff.derivatives import along, gradient
from tissuec.autodiff.functions import maximum, where
from tissuec.autodiff.graph import Number
from tissuec.autodiff.potentials import TracedItem, by_name
from tissuec.autodiff.tensors import dot

ALIKE = 1e-9  # relative difference of pressures that are equal


class TracedPair(TracedItem):
    """An item of a group; see ``TracedItem``. Where groups brake, it has a number "damping", b.

    Attributes:
        depth, bends: δ, and the bends of E that it has passed, which a member sets where its
            potential is traced.
    """

    depth: Number
    bends: Number

    # --- of a pair --------------------------------------------------------------------------

    @cached_property
    def pressure(self) -> Number:
        """Return p."""
        return gradient(self.energy, [self.depth])[0]

    @cached_property
    def closing(self) -> Number:
        """Return c."""
        return dot(self.stored, self.v)

    @cached_property
    def work(self) -> Number:
        """Return ∂E/∂x·w, with the weights w of forces."""
        return dot(self.stored, self.weights)

    @cached_property
    def steepness(self) -> list[Number]:
        """Return ∂²E/∂δ², and ∂δ/∂x, of which its positive part ∂²E/∂δ² ∂δ/∂x ∂δ/∂x is made."""
        return [gradient(self.pressure, [self.depth])[0], *gradient(self.depth, self.x)]

    # --- of a group -------------------------------------------------------------------------

    @property
    def has_pace(self) -> bool:
        """Return whether groups brake."""
        return "damping" in self.widths

    def pooled(self, name: str) -> Number:
        """Return a quantity of all pairs of a group.

        Args:
            name: "pressure", "closing", "work" and "bends" as sums; "most" of p; "factor" F,
                and "by_steady" and "by_closing", the changes of it by s and Σ c.
        """
        return self.graph.input(f"g.{name}")

    def added(self, name: str) -> Number:
        """Return a pooled quantity after this pair is included; names as for ``pooled``."""
        known = self.pooled(name)
        return maximum(known, self.pressure) if name == "most" else known + getattr(self, name)

    @cached_property
    def _steady(self) -> Number:
        return maximum(self.pooled("pressure"), self.pooled("most"))

    @cached_property
    def pace(self) -> list[Number]:
        """Return F, ∂F/∂s and ∂F/∂Σc."""
        steady, closing, factor = self._steady, self.pooled("closing"), self.graph.number(1.0)
        if self.has_pace:
            slowed = self.of(["damping"])[0] * closing / where(steady > 0.0, steady, 1.0)
            factor = maximum(1.0 + slowed, 0.0)
        factor = where(steady > 0.0, factor, 0.0)
        return [factor, *gradient(factor, [steady, closing])]

    @cached_property
    def ends(self) -> list[Number]:
        """Return -F, the power that is dissipated, and the bends that are passed."""
        factor, lost = self.pace[0], self.graph.number(0.0)
        if self.has_pace:
            lost = where(self._steady > 0.0, (factor - 1.0) * self.pooled("closing"), 0.0)
        return [-factor, lost, self.pooled("bends") + where(factor > 0.0, 1.0, 0.0)]

    @cached_property
    def _part(self) -> Number:
        """Return the part of p that counts in s: none beside a larger one, where that is s."""
        # With room for the last digits, in which sums and what is computed again differ.
        most, total = self.pooled("most"), self.pooled("pressure")
        is_less = (1.0 - ALIKE) * most > self.pressure
        return where((1.0 - ALIKE) * most > total, where(is_less, 0.0, 1.0), 1.0)

    def pulled(self, learnt: Sequence[str]) -> list[Number]:
        """Return the derivatives of w·f, with those by what is pooled; see ``TracedItem``."""
        by_steady, by_closing = self.pooled("by_steady"), self.pooled("by_closing")
        more = by_steady * self._part * self.pressure + by_closing * self.closing
        work = -(self.pooled("factor") * self.work + self.pooled("work") * more)
        return gradient(work, [*self.x, *self.v, *self.of(learnt)])

    def pushed(self, learnt: Sequence[str]) -> tuple[list[Number], dict[str, Number]]:
        """Return the changes of f and of F, given that of F; see ``TracedItem``."""
        changes = self.changes(learnt)
        pressure, closing, *stored = along([self.pressure, self.closing, *self.stored], changes)
        pace = self.pooled("by_steady") * self._part * pressure
        pace = pace + self.pooled("by_closing") * closing
        factor, change = self.pooled("factor"), self.pooled("change")
        moved = [
            -(factor * more + change * own)
            for more, own in zip(stored, self.stored, strict=True)
        ]
        return [*moved, pace], by_name(changes.values())
