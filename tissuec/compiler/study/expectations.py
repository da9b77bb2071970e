"""Expectations of a study: conditions over all its runs, such as ``max(pull) < 2 N``."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NoReturn

import numpy as np
from msgspec import Struct

from tissuec.compiler.measures.observed import describe_sides
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.units import NUMBER, parse_unit
from tissuec.lang import syntax as s
from tissuec.scene.reading.expressions import InnerScope, Scope
from tissuec.scene.reading.findings import Findings, Rejected
from tissuec.scene.reading.values import Value

QUANTILE, SHARE = "quantile", "share"
#: Functions of a column over all runs that have a value, with their forms.
OVER_RUNS = {
    "max": "max(NAME)",
    "min": "min(NAME)",
    "mean": "mean(NAME)",
    QUANTILE: "quantile(NAME, 0.95)",
    SHARE: "share(NAME < 2 N)",
}
_NUMBERS = {"max": np.max, "min": np.min, "mean": np.mean}

#: Values of columns in SI units, shape (row,), and their units as in the table.
Columns = Mapping[str, tuple[np.ndarray, str]]


class Verdict(Struct, frozen=True):
    """Whether an expectation of a study holds.

    Attributes:
        expect: As it is written.
        measured: What was found, such as "max(pull) = 2.1 N".
    """

    expect: str
    holds: bool
    measured: str
    span: Span


class RunsScope(InnerScope):
    """A scope of columns of a table; without values, dimensions and names are checked.

    Args:
        columns: By name; None is the value 1 in a unit.
        constants: Params and lets of the scene.
    """

    is_known = False

    def __init__(self, columns: Columns, constants: Scope, findings: Findings):
        super().__init__(constants, findings)
        self.columns = {key_of(name): column for name, column in columns.items()}
        self.titles = list(columns)

    def name(self, name: s.Name) -> Value:
        if name.key in self.columns:
            numbers, unit = self.columns[name.key]
            found = parse_unit(unit) if unit else None
            factor, dimension = (found.factor, found.dimension) if found else (1.0, NUMBER)
            return Value.number(numbers * factor, dimension)
        if self.constants.has(name):
            return self.constants.name(name)
        self.findings.reject(
            "TIS301", f'the study has no column "{name.text}"', name.span,
            hint=alternatives(name.text, self.titles, what="columns"),
        )  # fmt: skip

    def has(self, name: s.Name) -> bool:
        return name.key in self.columns or self.constants.has(name)

    def names(self) -> Sequence[str]:
        return [*self.titles, *self.constants.names()]

    def evaluate(self, node: s.Expression) -> Value:
        if isinstance(node, s.Call) and node.function.key in OVER_RUNS:
            plain = len(node.arguments) == 1 or node.function.key == QUANTILE
            if plain:
                return self._over_runs(node)
        return super().evaluate(node)

    def _over_runs(self, call: s.Call) -> Value:
        kind, first = call.function.key, call.arguments[0].value
        count = 2 if kind == QUANTILE else 1
        if len(call.arguments) != count or any(one.clauses for one in call.arguments):
            self._wrong(call)
        if kind == SHARE:
            held = np.atleast_1d(self.decide(first))
            return Value.number(float(np.mean(held)) if len(held) else np.nan)
        value = self.number(first)
        numbers = np.atleast_1d(value.amount)
        numbers = numbers[~np.isnan(numbers)]
        if kind == QUANTILE:
            part = self.number(call.arguments[1].value)
            self.expect(part, NUMBER, call.arguments[1].span, what="the part of a quantile")
            if not 0.0 <= float(part.amount) <= 1.0:
                message = "the part of a quantile must be between 0 and 1"
                self.findings.reject("TIS308", message, call.arguments[1].span)
            found = np.quantile(numbers, float(part.amount)) if len(numbers) else np.nan
        else:
            found = _NUMBERS[kind](numbers) if len(numbers) else np.nan
        return Value.number(float(found), value.dimension)

    def _wrong(self, call: s.Call) -> NoReturn:
        name = call.function.key
        hint = f"the form is {OVER_RUNS[name]}"
        self.findings.reject("TIS312", f"wrong form of {name}", call.span, hint=hint)


def check_expectations(
    expects: Iterable[s.Expect], units: Mapping[str, str], constants: Scope
) -> None:
    """Report what is wrong with expectations of a study.

    Args:
        expects: As they are written.
        units: Of the columns of numbers, by name.
        constants: Params and lets of the scene, and its findings.
    """
    columns = {name: (np.ones(2), unit) for name, unit in units.items()}
    scope = RunsScope(columns, constants, constants.findings)
    for expect in expects:
        with scope.findings.item():
            if scope.decide(expect.condition).ndim:
                scope.findings.reject(
                    "TIS312", "an expectation of a study compares single numbers",
                    expect.condition.span,
                    hint=f"write for example: {', '.join(OVER_RUNS.values())}",
                )  # fmt: skip


def judge(
    expects: Iterable[s.Expect], columns: Columns, constants: Scope
) -> tuple[Verdict, ...]:
    """Return whether the expectations of a study hold; what has no value does not.

    Args:
        expects: As they are written.
        columns: Of the table, shape (row,) each, in the units beside them.
        constants: Params and lets of the scene.
    """
    scope, found = RunsScope(columns, constants, Findings()), list[Verdict]()
    for expect in expects:
        condition, span = expect.condition, expect.span
        try:
            holds = bool(np.all(scope.decide(condition)))
            measured = describe_sides(condition, scope)
        except Rejected:
            holds, measured = False, "it has no value"
        found.append(Verdict(span.with_values, holds, measured, span))
    return tuple(found)
