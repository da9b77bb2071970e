"""Springs and dashpots as items, for derivatives by all that they depend on.

A spring from node i to node j has r = x_j - x_i, L = |r|, n = r/L, e = L - L0 - p and
w = n·(v_j - v_i). It acts with T n on i and with -T n on j, where

    T = S + g(e, w),    S = f(e) + Σ c1 (e - q),
    q' = (e - q)/τ,     p' = max(0, |S| - F) sign(S)/η;

see ``springs``. The variables q of branches and p of what yields follow the velocities of
nodes, each times a ``rate``. The engine has loops of its own for these forces, as the
layout of a net in memory decides their speed (``runs_kernel``, ``pairs_kernel``).
"""

from collections.abc import Iterator, Sequence
from functools import cache
from typing import ClassVar, Self

import numpy as np

from tissuec.autodiff import (
    Number,
    Numbers,
    StatedForces,
    Vector,
    dot,
    gradient,
    maximum,
    minimum,
    norm,
    where,
)
from tissuec.autodiff.potentials import PotentialFunction, TracedItem
from tissuec.core.structs import replace
from tissuec.forces.potential_fields import PotentialField, traced_item
from tissuec.laws import Law
from tissuec.laws.tracing import with_slopes
from tissuec.model.network import Floats, Indices, Network

_TINY = 1e-100  # keeps the quotient by a length finite that is not chosen


def constant_name(number: int) -> str:
    """Return the variable of a constant of laws that may change."""
    return f"k[{number}]"


class SpringItems(PotentialField, frozen=True):
    """Springs with the same law that remember alike.

    Attributes:
        law: Theirs, with variables for constants that may change.
        springs: Their numbers in the network, shape (item,).
        slots: Components of velocities that are q of each branch, and last p, shape (item,
            slot).
        yields: Whether the last of these is p.
        memory_rows: Which numbers of what springs of the network remember ``memory`` is, in the
            order given there for all branches, shape (number,).
        stiffness, damping, rest: c [N/m], d [N s/m] and L0 [m], shape (item,).
        memory: c1 [N/m] of each branch, 1/τ [1/s] of each, then F [N] and 1/η [m/(N s)] of what
            yields, shape (item, number).
        constants: Of laws, shape (1, constant).
        rate: What internal variables are multiplied by [1/s], shape (item, slot).
    """

    columns: ClassVar[tuple[str, ...]] = (
        "stiffness", "damping", "rest", "memory", "constants", "rate",
    )  # fmt: skip
    learnt: ClassVar[tuple[str, ...]] = columns[:-1]
    law: Law
    springs: Indices
    slots: Indices
    yields: bool
    memory_rows: Indices
    stiffness: Floats
    damping: Floats
    rest: Floats
    memory: Floats
    constants: Floats
    rate: Floats

    @property
    def traced(self) -> TracedItem:
        """Return a spring as its forces were traced."""
        function = _spring(self.law, self.slots.shape[1], self.yields)
        return traced_item(function, 2, self.widths, self.slots.shape[1])

    def only(self, items: Indices) -> Self:
        """Return some springs, by indices of shape (n,)."""
        kept = super().only(items)
        return replace(kept, springs=self.springs[items], slots=self.slots[items])

    @property
    def internal_variables(self) -> Indices:
        """Return the slots."""
        return self.slots


@cache
def _spring(law: Law, slots: int, yields: bool) -> PotentialFunction:
    """Return the forces of a spring, as a function to be traced.

    Args:
        slots: How many internal variables it has.
        yields: Whether the last one is p.
    """
    branches = slots - yields

    def spring(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> StatedForces:
        way = x[1] - x[0]
        length = norm(way)
        inverse = where(length > 0.0, 1.0 / (length + _TINY), 0.0)
        speed = dot(way, v[1] - v[0]) * inverse
        pairs = zip(_each(p, "internal"), _each(p, "rate"), strict=True)
        internal = [value / rate for value, rate in pairs]
        elongation = length - p.rest - (internal[-1] if yields else 0.0)
        given = {constant_name(k): value for k, value in enumerate(_each(p, "constants"))}
        given |= {"e": elongation, "w": speed, "c": p.stiffness, "d": p.damping, "rest": p.rest}
        pull, memory = with_slopes(law.elastic, given), _each(p, "memory")
        for constant, q in zip(memory, internal[:branches], strict=False):
            pull = pull + constant * (elongation - q)
        # Where both ends are at one place, a spring without length resists in all directions.
        steep = where(p.rest > 0.0, 0.0, gradient(pull, [elongation])[0])
        along = way * where(length > 0.0, pull * inverse, steep)
        against = way * (with_slopes(law.viscous, given) * inverse)
        rates = [
            pace * (elongation - q)
            for pace, q in zip(memory[branches : 2 * branches], internal, strict=False)
        ]
        if yields:
            limit, fluidity = memory[2 * branches :]
            rates.append(fluidity * (maximum(pull - limit, 0.0) + minimum(pull + limit, 0.0)))
        scaled = [scale * rate for scale, rate in zip(_each(p, "rate"), rates, strict=True)]
        return StatedForces((along, -along), (against, -against), scaled)

    return spring


def _each(numbers: Numbers, name: str) -> list[Number]:
    """Return the components of a number; none where items have no such number."""
    found = vars(numbers).get(name, ())
    return [found] if isinstance(found, Number) else list(found)


def items_of(
    network: Network, springs: Indices, laws: Sequence[Law], constants: int, *, remember: bool
) -> Iterator[SpringItems]:
    """Yield some springs of a network, those with the same law and memory together.

    What can be learnt of them is zero until it is set.

    Args:
        springs: Their numbers, shape (n,).
        laws: Of the network, with variables for constants that may change.
        constants: How many these are.
        remember: Whether they have their internal variables, which do not change at rest.
    """
    own, none = network.springs, np.zeros(0, dtype=np.int64)
    inelastic = own.inelastic if remember else None
    slot = np.full((1, len(springs)), -1) if inelastic is None else inelastic.slot[:, springs]
    rate = np.zeros(slot.shape) if inelastic is None else inelastic.rate[:, springs]
    kinds, kind = np.unique(
        np.vstack([own.law[springs], slot >= 0]), axis=1, return_inverse=True
    )
    for number, key in enumerate(kinds.T):
        mine, rows = np.flatnonzero(kind.ravel() == number), np.flatnonzero(key[1:])
        chosen, last = springs[mine].astype(np.int64), len(key) - 2
        branches, yields = rows[rows < last], bool(key[-1])
        flow = 2 * last + np.arange(2 * yields)
        memory = np.concatenate([branches, last + branches, flow])
        yield SpringItems(
            walls=none, walled=none, nodes=own.ends[chosen].astype(np.int64),
            law=laws[int(key[0])], springs=chosen, yields=yields, memory_rows=memory,
            slots=slot[rows][:, mine].T.astype(np.int64), rate=rate[rows][:, mine].T.copy(),
            **dict.fromkeys(("stiffness", "damping", "rest"), np.zeros(len(mine))),
            memory=np.zeros((len(mine), len(memory))), constants=np.zeros((1, constants)),
        )  # fmt: skip
