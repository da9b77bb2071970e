"""Measured quantities, written as functions or as sentences: ``force of forceps A``.

A quantity is an expression over measures. It is read once, and then evaluated on snapshots.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.compiler.measures.conditions import Conditions
from tissuec.compiler.measures.observed import MeasureScope, ObservedMeasure, Place
from tissuec.core.hints import alternatives
from tissuec.core.source import Span
from tissuec.core.units import Dimension
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.reading.expressions import Scope
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot

FORM = "MEASURE of A [along (x, y, z)], or an expression such as force(A) - force(B)"


class ObservedExpression(Struct, frozen=True, eq=False):
    """What is observed at each snapshot, as the log of a run takes it."""

    node: s.Expression
    readings: Mapping[Place, ObservedMeasure]
    constants: Scope
    dimension: Dimension

    def columns(self, subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        """Return the names of the components of ``sample``."""
        return ("value",)

    def sample(self, subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        """Return the values in SI units, shape (…, 1), with the axes of the snapshot."""
        scope = MeasureScope(self.readings, self.constants, snapshot)
        value = scope.number(self.node).amount
        return np.broadcast_to(value, np.shape(snapshot.time))[..., None]


class QuantityReader:
    """Reads quantities of a scene.

    Args:
        conditions: Of the scene; findings go to its own.
        form: What messages say that a quantity looks like.
    """

    def __init__(self, conditions: Conditions, form: str = FORM):
        self._conditions, self._form = conditions, form
        self._findings = conditions.findings

    def read(
        self, node: s.Expression, clauses: Sequence[s.Clause], span: Span
    ) -> ObservedExpression:
        """Return the measured expression, written as a sentence or as a function.

        Args:
            node: A function, an expression, or the name of a measure.
            clauses: After the name of a measure: of, to, along.
            span: Of all of it.

        Raises:
            CompileError: It measures nothing.
        """
        if isinstance(node, s.Name) and clauses:
            node = self._as_call(node, clauses)
        elif clauses:
            message = f'"{clauses[0].word}" is not allowed here'
            self._findings.reject(
                "TIS303", message, clauses[0].span, hint=f"write: {self._form}"
            )
        readings = self._conditions.readings(node)
        if not readings:
            self._findings.reject(
                "TIS701", f'"{node.span.one_line}" measures nothing', node.span,
                hint=alternatives(node.span.one_line, MEASURES, what="measures"),
            )  # fmt: skip
        value = MeasureScope(readings, self._conditions.scope, None).number(node)
        return ObservedExpression(node, readings, self._conditions.scope, value.dimension)

    def _as_call(self, name: s.Name, clauses: Sequence[s.Clause]) -> s.Call:
        """Return ``position of tip along (0, 0, 1)`` as ``position(tip along (0, 0, 1))``."""
        arguments: list[s.Argument] = []
        for clause in clauses:
            if clause.word in ("of", "to"):
                arguments.append(s.Argument(clause.value, (), clause.value.span))
            elif clause.word == "along" and arguments:
                last = arguments.pop()
                arguments.append(replace(last, clauses=(clause,)))
            else:
                self._findings.reject("TIS303", f'unexpected "{clause.word}"', clause.span)
        for argument in arguments:
            if not isinstance(argument.value, s.Name):
                measured = f"{name.text}({argument.value.span.one_line})"
                self._findings.reject(
                    "TIS312", "a name is needed here", argument.span,
                    hint=f"write the measure as a function, such as {measured}",
                )  # fmt: skip
        return s.Call(name, tuple(arguments), name.span.to(clauses[-1].span))
