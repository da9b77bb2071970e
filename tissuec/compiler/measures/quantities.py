"""Measured quantities, such as ``force(A) - force(B)``.

A quantity is an expression over measures. It is read once, and then evaluated on snapshots.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from msgspec import Struct

from tissuec.compiler.measures.conditions import Conditions
from tissuec.compiler.measures.observed import MeasureScope, ObservedMeasure, Place
from tissuec.core.hints import alternatives
from tissuec.core.units import Dimension
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.reading.expressions import Scope
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot


class ObservedExpression(Struct, frozen=True, eq=False):
    """What is observed at each snapshot, as the log of a run takes it."""

    node: s.Expression
    readings: Mapping[Place, ObservedMeasure]
    constants: Scope
    dimension: Dimension

    @property
    def needs_ledger(self) -> bool:
        """Return whether it needs the energy ledger of a run."""
        return any(reading.needs_ledger for reading in self.readings.values())

    def columns(self, subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        """Return the names of the components of ``sample``."""
        return ("value",)

    def sample(self, subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        """Return the values in SI units, shape (…, 1), with the axes of the snapshot."""
        scope = MeasureScope(self.readings, self.constants, snapshot)
        value = scope.number(self.node).amount
        return np.broadcast_to(value, np.shape(snapshot.time))[..., None]


class ObservedPair(Struct, frozen=True, eq=False):
    """Two quantities that are observed together, of which the slope is of interest."""

    first: ObservedExpression
    over: ObservedExpression

    @property
    def readings(self) -> Mapping[Place, ObservedMeasure]:
        """Return the measures of both."""
        return {**self.first.readings, **self.over.readings}

    @property
    def dimension(self) -> Dimension:
        """Return the dimension of the slope."""
        return self.first.dimension / self.over.dimension

    @property
    def needs_ledger(self) -> bool:
        """Return whether any of them needs the energy ledger of a run."""
        return self.first.needs_ledger or self.over.needs_ledger

    def columns(self, subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        """Return the names of the components of ``sample``."""
        return ("value", "over")

    def sample(self, subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        """Return the values in SI units, shape (…, 2), with the axes of the snapshot."""
        both = [each.sample(subjects, snapshot) for each in (self.first, self.over)]
        return np.concatenate(both, axis=-1)


class QuantityReader:
    """Reads quantities of a scene.

    Args:
        conditions: Of the scene; findings go to its own.
    """

    def __init__(self, conditions: Conditions):
        self._conditions = conditions
        self._findings = conditions.findings

    def read(self, node: s.Expression) -> ObservedExpression:
        """Return an expression over measures.

        Args:
            node: The name or call of a measure, or an expression of such.

        Raises:
            CompileError: It measures nothing.
        """
        readings = self._conditions.readings(node)
        if isinstance(node, s.Name) and not readings and not self._conditions.scope.has(node):
            self._conditions.reading(node)  # which says what might be meant
        if not readings:
            self._findings.reject(
                "TIS701", f'"{node.span.one_line}" measures nothing', node.span,
                hint=alternatives(node.span.one_line, MEASURES, what="measures"),
            )  # fmt: skip
        value = MeasureScope(readings, self._conditions.scope, None).number(node)
        return ObservedExpression(node, readings, self._conditions.scope, value.dimension)
