"""Expectations about learning: ``expect error(held out) < 8 %``."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from msgspec import Struct

from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.learning.errors import ERROR, errors_in
from tissuec.scene.learning.model import VocabularyFit, WrittenFitProblem
from tissuec.scene.reading.expressions import InnerScope, Scope
from tissuec.scene.reading.values import Value
from tissuec.script.fit_problem import Demand, Errors
from tissuec.script.measures import MEASURES

HELD_OUT, ALL = "held out", "data"
FORM = "error(held out) < 8 %"


class ExpectableErrors(Struct, frozen=True):
    """Errors of a fit problem that expectations can refer to.

    Attributes:
        files: Names of the files, by the names as written.
        tissues: Lower-case names of tissues whose numbers are fitted.
        holds_out: Whether there is anything that the learning does not see.
        is_whole: Whether the fit problem could be read without errors.
    """

    files: Mapping[str, str]
    holds_out: bool
    is_whole: bool
    tissues: Collection[str] = ()

    @classmethod
    def of(cls, written: WrittenFitProblem | VocabularyFit) -> "ExpectableErrors":
        """Return which errors of a learn block can be expected."""
        if isinstance(written, VocabularyFit):
            tissues = {target.tissue for target in written.targets}
            holds_out = any(target.held_out for target in written.targets)
            return cls({}, holds_out, written.is_whole, tissues)
        files = {name: file for file, name in written.names.items()}
        holds_out = written.last_part > 0.0 or any(one.held_out for one in written.data)
        return cls(files, holds_out, written.is_whole)

    def name_of(self, key: s.Name) -> str | None:
        """Return the name of an error in ``Errors``; None if it does not exist."""
        if key.words:
            known = dict.fromkeys(self.tissues, True) | {ALL: True, HELD_OUT: self.holds_out}
            return key.key if key.quoted is None and known.get(key.key) else None
        return self.files.get(key.quoted or "")


class ErrorScope(InnerScope):
    """A scope of errors; without any, each is 1."""

    is_known = False

    def __init__(self, constants: Scope, judged: ExpectableErrors, errors: Errors | None):
        super().__init__(constants)
        self.judged, self.errors = judged, errors

    def name(self, name: s.Name) -> Value:
        if name.key in MEASURES:
            self._mixed(name)
        return self.constants.name(name)

    def has(self, name: s.Name) -> bool:
        return self.constants.has(name)

    def names(self) -> Sequence[str]:
        return self.constants.names()

    def call(self, call: s.Call) -> Value:
        if call.function.key != ERROR:
            self._mixed(call)
        name = self.judged.name_of(argument_of(call, self))
        return Value.number(1.0 if self.errors is None else self.errors[name or ""])

    def _mixed(self, node: s.Call | s.Name) -> None:
        self.findings.reject(
            "TIS803", "the error of a learn block cannot be combined with a measure of the run",
            node.span, hint="write them on separate lines",
        )  # fmt: skip


def argument_of(call: s.Call, scope: Scope) -> s.Name:
    """Return the argument of an error, or reject the call."""
    first = call.arguments[0] if len(call.arguments) == 1 else None
    if first is None or first.clauses or not isinstance(first.value, s.Name):
        scope.findings.reject(
            "TIS803", "wrong form of error", call.span,
            hint='forms: error(held out), error(data), error("file.csv"), error(TISSUE)',
        )  # fmt: skip
    return first.value


class _Judgement(Struct, frozen=True):
    """A condition as a function of errors."""

    condition: s.Expression
    constants: Scope
    judged: ExpectableErrors

    def __call__(self, errors: Errors) -> bool:
        scope = ErrorScope(self.constants, self.judged, errors)
        return bool(np.all(scope.decide(self.condition)))

    def describe(self, errors: Errors) -> str:
        scope = ErrorScope(self.constants, self.judged, errors)
        shown = {
            call.span.one_line: 100.0 * float(scope.call(call).amount)
            for call in errors_in(self.condition)
        }
        return ", ".join(f"{text} = {percent:.3g} %" for text, percent in shown.items())


class DemandReader:
    """Reads expectations about errors."""

    def __init__(self, scope: Scope, fit_problems: Mapping[str, ExpectableErrors]):
        self.scope, self.fit_problems, self.findings = scope, fit_problems, scope.findings

    def read(self, item: s.Expect) -> dict[str, Demand]:
        """Return the demand on each fit problem that has the error, by name."""
        if not self.fit_problems:
            if self.findings.may_be_misspelt("learn"):
                self.findings.stop()
            self.findings.reject(
                "TIS803", "there is no learn block whose error could be tested",
                item.condition.span, hint="for example: learn fat { data = …; fit = …; … }",
            )  # fmt: skip
        words = [(clause.word, clause.value.span.text.lower()) for clause in item.clauses]
        if words not in ([], [("over", "run")]):
            timed = Span(item.span.source, item.condition.span.end, item.clauses[-1].span.end)
            self.findings.reject(
                "TIS803", "the error of a learn block has no time", item.clauses[0].span,
                hint=Hint(f"write only: expect {FORM}", Edit("", timed)),
            )  # fmt: skip
        names = [argument_of(call, self.scope) for call in errors_in(item.condition)]
        found = {
            key: self._demand(item, judged)
            for key, judged in self.fit_problems.items()
            if all(judged.name_of(name) is not None for name in names)
        }
        return found or self._refuse(names)

    def _demand(self, item: s.Expect, judged: ExpectableErrors) -> Demand:
        ErrorScope(self.scope, judged, None).decide(item.condition)
        judgement = _Judgement(item.condition, self.scope, judged)
        return Demand(judgement, judgement.describe, item.span)

    def _refuse(self, names: Sequence[s.Name]) -> dict[str, Demand]:
        """Reject an expectation that no fit problem can meet."""
        every = self.fit_problems.values()
        members = (name for one in every for name in (*one.files, *sorted(one.tissues)))
        known = [HELD_OUT, ALL, *members]
        if not all(one.is_whole for one in every):
            self.findings.stop()  # what was found wrong there may be what is missing here
        bad = next((n for n in names if not any(one.name_of(n) for one in every)), names[0])
        if bad.key == HELD_OUT and bad.quoted is None:
            self.findings.reject(
                "TIS803", "nothing is held out", bad.span,
                hint='in the learn block: hold out "three.csv", or hold out = 20 %'
                if not any(one.tissues for one in every)
                else "in the learn block: hold out TISSUE",
            )  # fmt: skip
        self.findings.reject(
            "TIS803", f'there is no error of "{bad.text}"', bad.span,
            hint=alternatives(bad.text, known, what="errors"),
        )  # fmt: skip


def demands_of(
    scope: Scope,
    blocks: Mapping[str, WrittenFitProblem | VocabularyFit],
    expects: Sequence[s.Expect],
) -> dict[str, list[Demand]]:
    """Return the expectations of each learn block.

    Args:
        blocks: All learn blocks of a program.
        expects: Expectations about errors of learning.
    """
    reader = DemandReader(scope, {key: ExpectableErrors.of(one) for key, one in blocks.items()})
    found: dict[str, list[Demand]] = {key: [] for key in blocks}
    for item in expects:
        with scope.findings.item():
            for key, demand in reader.read(item).items():
                found[key].append(demand)
    return found
