"""Springs of a net: their nodes and numbers, one record from the build to the kernels."""

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import behind_one_another, uniform
from tissuec.core.structs import replace
from tissuec.laws import LINEAR, Law
from tissuec.laws.evaluation import Behaviour
from tissuec.model.inelastic import Inelastic

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Columns with a number for each spring.
NUMBERS = ("stiffness", "damping", "rest", "strength", "crush")
COLUMNS = ("ends", *NUMBERS, "law")


class Springs(Struct, frozen=True, eq=False):
    """Springs between pairs of nodes, in SI units.

    A net has them with the numbers of the scene, a state with the present ones, and the engine
    those that act, by the places of nodes there. Columns that nobody changes are shared.

    Attributes:
        ends: Node pair of each spring, shape (spring, 2).
        stiffness: Spring constants c [N/m], shape (spring,).
        damping: Viscosities d [N s/m], shape (spring,).
        rest: Rest lengths L0 [m], shape (spring,), or (…, spring) at several times.
        strength: Breaking forces [N], shape (spring,); infinite where nothing may rupture.
        crush: Crushing forces [N], shape (spring,): the pressures that springs bear; infinite
            where nothing is crushed.
        law: Law of each spring as a number among ``laws``, shape (spring,).
        laws: The laws of springs and dashpots; the first is the linear one.
        ids: Ids of the author (table ids, or the number within the body), shape (spring,).
        inelastic: What springs remember; None where none does.
    """

    ends: NDArray[np.int32]
    stiffness: Floats
    damping: Floats
    rest: Floats
    strength: Floats
    crush: Floats
    law: NDArray[np.int32]
    laws: tuple[Law, ...]
    ids: Indices
    inelastic: Inelastic | None = None

    @property
    def sudden(self) -> Floats:
        """Return the stiffness of springs before their branches relax [N/m].

        The shape is (spring,).
        """
        return self.stiffness + (0.0 if self.inelastic is None else self.inelastic.sudden)

    @property
    def behaviour(self) -> Behaviour:
        """Return their laws with their numbers."""
        return Behaviour(self.laws, self.law, self.stiffness, self.damping, self.rest)

    @classmethod
    def of(
        cls,
        ends: NDArray[np.int32],
        numbers: Mapping[str, Floats],
        law: NDArray[np.int32],
        laws: tuple[Law, ...],
        ids: Indices,
    ) -> "Springs":
        """Return springs that remember nothing.

        Args:
            ends: Node pair of each, shape (spring, 2).
            numbers: Columns by name in SI units, of which only ``NUMBERS`` are taken, shape
                (spring,).
            law: Law of each as a number among ``laws``, shape (spring,).
            laws: Those that they have.
            ids: Of the author, shape (spring,).
        """
        stiffness, damping, rest, strength, crush = (numbers[name] for name in NUMBERS)
        return cls(ends, stiffness, damping, rest, strength, crush, law, laws, ids)

    @classmethod
    def none(cls) -> "Springs":
        """Return no springs at all."""
        return cls.joined([])

    @classmethod
    def joined(cls, parts: Sequence["Springs"]) -> "Springs":
        """Return springs that remember nothing, one part after the other.

        A column with one number for all takes no room.
        """
        laws = tuple(dict.fromkeys([LINEAR, *(law for part in parts for law in part.laws)]))
        law = [np.array([laws.index(law) for law in part.laws])[part.law] for part in parts]

        def column(name: str) -> NDArray[Any]:
            return uniform(behind_one_another([getattr(part, name) for part in parts], float))

        return cls.of(
            behind_one_another([part.ends for part in parts], np.int32, (2,)),
            {name: column(name) for name in NUMBERS},
            uniform(behind_one_another(law, np.int32)),
            laws,
            uniform(behind_one_another([part.ids for part in parts], np.int64)),
        )

    def behind(self, nodes: int) -> Self:
        """Return the same with the numbers that their nodes have after other nodes."""
        return replace(self, ends=self.ends + np.int32(nodes)) if nodes else self

    def some(self, chosen: NDArray[np.integer] | slice) -> Self:
        """Return some of the springs.

        Args:
            chosen: Indices of shape (n,), or a slice, whose numbers are not copied.
        """
        if isinstance(chosen, slice) and chosen == slice(None):
            return self
        columns = {name: getattr(self, name)[..., chosen] for name in (*NUMBERS, "law", "ids")}
        # Rows are taken ten times as fast as they are indexed.
        whole, memory = self.ends, self.inelastic
        ends = whole[chosen] if isinstance(chosen, slice) else whole.take(chosen, axis=0)
        inelastic = None if memory is None else memory.some(chosen)
        return replace(self, ends=ends, **columns, inelastic=inelastic)

    def changed(self, name: str, chosen: Indices | int, numbers: Floats | float) -> Self:
        """Return the same with other numbers of some springs; the column is copied.

        Args:
            name: One of ``NUMBERS``.
            chosen: Indices of shape (n,), or one.
            numbers: In the unit of the column, shape (n,), or the same for all.
        """
        values = getattr(self, name).copy()
        values[chosen] = numbers
        return replace(self, **{name: values})
