"""Volumes that pressure preserves, and their changes.

The target of a drawn volume V0 is Vt = V0 (1 + s), with its relative change s. With the bulk
modulus K, the pressure in the present volume V is p = K (Vt - V)/V0.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Self

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.pooled_fields import PooledField
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats
from tissuec.model.profiles import TimeProfile


class Swelling(Struct, frozen=True, eq=False):
    """A change of target volumes, relative to the drawn ones."""

    amount: float
    profile: TimeProfile


class KeptVolumes(PooledField, frozen=True):
    """Volumes of one body or set; the items of the field.

    Attributes:
        name: Of the body or set.
        drawn: Drawn volumes V0 [m³], shape (item,); positive.
        modulus: Bulk modulus K [Pa].
        swellings: Differences of the target volumes from the drawn ones: at the time when the
            latest change was ordered, and this change.
        span: The sentence.
    """

    name: str
    drawn: Floats
    modulus: float
    swellings: tuple[Swelling, ...]
    span: Span

    @property
    @abstractmethod
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""

    @property
    def item_count(self) -> int:
        """Return the number of volumes."""
        return len(self.drawn)

    @abstractmethod
    def volumes(self, position: Floats) -> Floats:
        """Return the present volumes [m³], shape (…, item)."""

    def swollen(self, amount: float, profile: TimeProfile, since: float = 0.0) -> Self:
        """Return the same with another target volume in place of the present one.

        Args:
            amount: Final excess of the target over the drawn volume, relative to the latter.
            profile: Of the change from the present target.
            since: Present time [s].
        """
        present = float(self.amount(since))
        change = Swelling(amount - present, profile)
        if not present:
            return replace(self, swellings=(change,))
        so_far = Swelling(present, TimeProfile("constant", 0.0, np.inf))
        return replace(self, swellings=(so_far, change))

    @property
    def changes(self) -> Sequence[tuple[float, TimeProfile]]:
        """Return the relative changes of volume."""
        return [(swelling.amount, swelling.profile) for swelling in self.swellings]

    def due(self, time: Floats | float) -> Floats:
        """Return the target volumes [m³], shape (…, item)."""
        return self.drawn * (1.0 + self.amount(time)[..., None])

    def pressures(self, time: Floats | float, position: Floats) -> Floats:
        """Return the pressures p [Pa], shape (…, item)."""
        return self.modulus * (self.due(time) - self.volumes(position)) / self.drawn
