"""Parameters and derived numbers: ``param``, ``let`` and ``--set``."""

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Annotated, NoReturn

from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.hints import alternatives
from tissuec.core.units import NUMBER, describe
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.program.dependency_order import Definitions
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import SCENE, declare
from tissuec.scene.reading.values import Value
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    LimitsClause,
    Refusal,
    ValueClause,
    new_name,
)

#: Names that every scene knows; its own ones win.
CONSTANTS = {"pi": math.pi}


class LetWords(VerbSentence, frozen=True):
    """A number that is computed."""

    refused = MappingProxyType({
        "between": Refusal(
            "only a param can have limits; a let is computed", "write param, or remove them"
        )
    })  # fmt: skip

    name: Annotated[s.Name, new_name("let")]
    value: Annotated[s.Expression, ValueClause("=", place="NUMBER")]


class ParamWords(VerbSentence, frozen=True):
    """A number that can be set from outside."""

    name: Annotated[s.Name, new_name("param")]
    value: Annotated[s.Expression, ValueClause("=", place="NUMBER")]
    limits: Annotated[s.Bounds | None, LimitsClause("between", place="NUMBER")]


_KINDS = {"param": SentenceKind((ParamWords,)), "let": SentenceKind((LetWords,))}
declare(
    "param",
    "A number that can be set on the command line, optionally with limits.", 50, "sentence",
    sentences=_KINDS["param"].forms, names=SCENE,
)  # fmt: skip
declare(
    "let", "A number computed from others, or a function of numbers.", 51, "sentence",
    sentences=_KINDS["let"].forms, names=SCENE,
)  # fmt: skip


class Parameter(Struct, frozen=True):
    """A ``param`` of the scene with the value that holds in this run."""

    name: str
    value: Value
    overridden: bool
    item: s.Assign


class Constants(Scope):
    """The scope of ``param`` and ``let``; each is evaluated once, on first use."""

    def __init__(
        self, declarations: Declarations, overrides: Mapping[str, s.Assign], findings: Findings
    ):
        super().__init__(findings)
        self.library = declarations.library
        self.declared = {
            key: declared.item
            for kind in ("param", "let")
            for key, declared in declarations.of(kind).items()
            if isinstance(declared.item, s.Assign)
        }
        self.overrides, self._written = overrides, declarations.needs
        self.definitions = Definitions("numbers", self._needs, self._compute, findings)
        self.used: set[str] = set()
        self._functions = declarations.functions

    def name(self, name: s.Name) -> Value:
        if name.key not in self.declared and name.key in CONSTANTS:
            return Value.number(CONSTANTS[name.key])
        if not self.has(name):
            self.unknown(name)
        self.used.add(name.key)
        return self.definitions.find(name.key)

    def look_up(self, name: s.Name) -> Value:
        """Return the value of a param that is set, without marking it as used."""
        return self.definitions.find(name.key)

    def has(self, name: s.Name) -> bool:
        return name.key in self.declared or name.key in CONSTANTS

    @property
    def functions(self) -> Sequence[str]:
        return () if self._functions is None else self._functions.known

    def is_set(self, item: s.Item) -> bool:
        if not self.overrides or not isinstance(item, s.Assign):
            return False
        todo = list(names_in(item.value))
        seen: set[str] = set()
        while todo:
            key = todo.pop().key
            if key in self.overrides:
                return True
            if key in self.declared and key not in seen:
                seen.add(key)
                todo.extend(self._needs(key))
        return False

    def names(self) -> Sequence[str]:
        return [item.name.text for item in self.declared.values()]

    def evaluate_all(self) -> None:
        """Evaluate unused definitions, so that mistakes in them are reported too."""
        for key in self.declared:
            with self.findings.item():
                self.definitions.find(key)
        for name in () if self._functions is None else self._functions.names():
            with self.findings.item():
                if not self.has(name):
                    self.unknown(name)

    def parameters(self) -> list[Parameter]:
        """Return every ``param`` with its value."""
        return [
            Parameter(item.name.text, value, key in self.overrides, item)
            for key, item in self.declared.items()
            if item.keyword == "param"
            and (value := self.definitions.values.get(key)) is not None
        ]

    def try_override(self, item: s.Assign) -> None:
        """Reject what could not be set on the command line in the place of a param."""
        params = {p.item.name.key: p.item.name.text for p in self.parameters()}
        key = item.name.key
        if key not in params:
            self.findings.pass_over_doubtful(key)
            if key in self.declared and self.declared[key].keyword == "param":
                self.findings.stop()  # it was found wrong itself
            refuse_override(item, list(params.values()), self.findings, key in self.declared)
        declared = self.declared[key]
        value = self._overridden(item.name.text, self.definitions.find(key), item.value)
        if declared.bounds is not None:
            self._check_bounds(declared, declared.bounds, value, item)

    def _needs(self, key: str) -> Iterable[s.Name]:
        """Return the names in a definition that are params or lets."""
        if key not in self._written:
            item = self.declared[key]
            self._written[key] = self._numbers_in(item.value, item.bounds)
        override = self.overrides.get(key)
        return (
            *self._written[key],
            *(() if override is None else self._numbers_in(override.value)),
        )

    def _numbers_in(self, *nodes: s.Expression | s.Bounds | None) -> tuple[s.Name, ...]:
        return tuple(name for name in names_in(nodes) if name.key in self.declared)

    def _compute(self, key: str) -> Value:
        item = self.declared[key]
        said = SentenceReader(item.keyword, _KINDS[item.keyword], item, self).get()
        value = self.evaluate(said.value)
        override = self.overrides.get(key)
        if override is not None:
            value = self._overridden(item.name.text, value, override.value)
        if isinstance(said, ParamWords) and said.limits is not None:
            self._check_bounds(item, said.limits, value, override or item)
        return value

    def _overridden(self, name: str, value: Value, node: s.Expression) -> Value:
        """Return the value of ``--set``, which must be of the same kind as the scene's own."""
        given = self.evaluate(node)
        if given.is_vector != value.is_vector:
            kind = "a vector" if value.is_vector else "one number"
            self.findings.reject("TIS312", f"{name} must be {kind}", node.span)
        self.expect(given, value.dimension, node.span, what=name)
        return given

    def _check_bounds(
        self, item: s.Assign, bounds: s.Bounds, value: Value, written: s.Assign
    ) -> None:
        low, high = self.number(bounds.low), self.number(bounds.high)
        if value.dimension == NUMBER and low.dimension == high.dimension != NUMBER:
            self.findings.reject(
                "TIS502",
                f"{item.name.text} = {value} has no unit, but its limits are "
                f"{describe(low.dimension)}",
                written.value.span,
                notes=(Note("the limits", bounds.span),),
                hint=f"write a unit, as in {bounds.high.span.one_line}",
            )
        for bound, part in ((low, bounds.low), (high, bounds.high)):
            self.expect(bound, value.dimension, part.span, what=f"a limit of {item.name.text}")
        if low.amount > high.amount:
            self.refuse_reversed(bounds.low.span, bounds.high.span)
        if not low.amount <= value.amount <= high.amount:
            self.findings.reject(
                "TIS308",
                f"{item.name.text} = {value} is not between {low} and {high}",
                written.value.span,
                notes=(Note("the limits", bounds.span),),
                hint="write a number between its limits, or other limits",
            )


def refuse_override(
    item: s.Assign | s.Sentence | s.Block,
    known: Sequence[str],
    findings: Findings,
    is_let: bool,
) -> NoReturn:
    """Reject an assignment to a name that is no param.

    Args:
        is_let: Whether the name is that of a let.
    """
    what = "it is a let, which is computed" if is_let else "there is no such param"
    findings.reject(
        "TIS505",
        f'"{item.name.text}" cannot be set: {what}',
        item.name.span,
        hint=alternatives(item.name.text, known, what="params") or "the scene has no param",
    )
