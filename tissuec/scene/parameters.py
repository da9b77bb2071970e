"""Parameters and derived numbers: ``param``, ``let`` and ``--set``."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from tissuec.core.errors import CompileError, Note, alternatives
from tissuec.lang import syntax as s
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.scene.declarations import Declarations
from tissuec.scene.expressions import Scope
from tissuec.scene.findings import Findings, Rejected
from tissuec.scene.order import Circle, names_in, needed_first
from tissuec.scene.values import Value

#: Names that every scene knows; its own ones win.
CONSTANTS = {"pi": math.pi}


@dataclass(frozen=True, slots=True)
class Parameter:
    """A ``param`` of the scene with the value that holds in this run."""

    name: str
    value: Value
    overridden: bool
    item: s.Assign


class Constants(Scope):
    """The scope of ``param`` and ``let``; each is evaluated once, when first asked for."""

    def __init__(
        self, declarations: Declarations, overrides: Mapping[str, s.Assign], findings: Findings
    ):
        super().__init__(findings)
        self.declared = {
            key: d.item for kind in ("param", "let") for key, d in declarations.of(kind).items()
        }
        self.overrides = overrides
        self.values: dict[str, Value | None] = {}
        self.used: set[str] = set()

    def name(self, name: s.Name) -> Value:
        if name.key not in self.declared and name.key in CONSTANTS:
            return Value.number(CONSTANTS[name.key])
        if not self.has(name):
            self.unknown(name)
        self.used.add(name.key)
        return self._value(name)

    def has(self, name: s.Name) -> bool:
        return name.key in self.declared or name.key in CONSTANTS

    def names(self) -> Sequence[str]:
        return [item.name.text for item in self.declared.values() if isinstance(item, s.Assign)]

    def evaluate_all(self) -> None:
        """Evaluate what nobody asked for, so that mistakes in it are reported too."""
        for item in self.declared.values():
            assert isinstance(item, s.Assign)
            with self.findings.item():
                self._value(item.name)

    def parameters(self) -> list[Parameter]:
        """Return every ``param`` with its value."""
        return [
            Parameter(item.name.text, value, key in self.overrides, item)
            for key, item in self.declared.items()
            if isinstance(item, s.Assign)
            and item.keyword == "param"
            and (value := self.values.get(key)) is not None
        ]

    def _value(self, name: s.Name) -> Value:
        if name.key not in self.values:
            self._work_out(name.key)
        value = self.values[name.key]
        if value is None:
            raise Rejected
        return value

    def _work_out(self, wanted: str) -> None:
        """Compute a number after all that it needs; None stands for what was rejected."""
        try:
            order = needed_first(wanted, self._needs)
        except Circle as circle:
            self.values.update(dict.fromkeys(circle.keys))
            message = f"these numbers need one another: {circle}"
            self.findings.reject("TIS506", message, circle.name.span)
        for key in order:
            self.values[key] = None
            with self.findings.item():
                self.values[key] = self._compute(key)

    def _needs(self, key: str) -> Iterator[s.Name]:
        """Yield the names in a definition that are still to be worked out."""
        item = self.declared[key]
        assert isinstance(item, s.Assign)
        override = self.overrides.get(key)
        parts = (item.value, item.bounds, override.value if override else None)
        for name in names_in(parts):
            if name.key in self.declared and name.key not in self.values:
                yield name

    def _compute(self, key: str) -> Value:
        item = self.declared[key]
        assert isinstance(item, s.Assign)
        if item.clauses:
            self.findings.reject(
                "TIS303", "a number takes no further words", item.clauses[0].span
            )
        if item.bounds is not None and item.keyword == "let":
            self.findings.reject(
                "TIS303", "limits belong to a param; a let is computed", item.bounds.span
            )
        value = self.evaluate(item.value)
        if key in self.overrides:
            given = self.evaluate(self.overrides[key].value)
            if given.is_vector != value.is_vector:
                self.findings.reject(
                    "TIS312",
                    f"{item.name.text} is {'a vector' if value.is_vector else 'one number'}",
                    self.overrides[key].value.span,
                )
            self.expect(
                given, value.dimension, self.overrides[key].value.span, what=item.name.text
            )
            value = given
        if item.bounds is not None:
            self._check_bounds(item, value, self.overrides.get(key, item))
        return value

    def _check_bounds(self, item: s.Assign, value: Value, written: s.Assign) -> None:
        assert item.bounds is not None
        low, high = self.number(item.bounds.low), self.number(item.bounds.high)
        for bound, part in ((low, item.bounds.low), (high, item.bounds.high)):
            self.expect(bound, value.dimension, part.span, what=f"a limit of {item.name.text}")
        if not low.amount <= value.amount <= high.amount:
            self.findings.reject(
                "TIS308",
                f"{item.name.text} = {value} is not between {low} and {high}",
                written.value.span,
                notes=(Note("the limits", item.bounds.span),),
            )


def read_overrides(
    texts: Sequence[str], declarations: Declarations, findings: Findings
) -> dict[str, s.Assign]:
    """Return the assignments of ``--set name=value`` by parameter name."""
    overrides: dict[str, s.Assign] = {}
    for text in texts:
        with findings.item():
            item = _read_override(text, findings)
            known = [declared.name.text for declared in declarations.of("param").values()]
            if item.name.key not in declarations.of("param"):
                is_let = item.name.key in declarations.of("let")
                what = "it is a let, which is computed" if is_let else "there is no such param"
                findings.reject(
                    "TIS505",
                    f'"{item.name.text}" cannot be set: {what}',
                    None,
                    hint=alternatives(item.name.text, known, what="params")
                    or "the scene has no param",
                )
            overrides[item.name.key] = item
    return overrides


def _read_override(text: str, findings: Findings) -> s.Assign:
    try:
        # The text of a command line is as foreign as that of a file.
        source = normalise(f"language 1\nparam {text}", f'--set "{text}"')
        items = parse(source).items if "=" in text else ()
    except CompileError as error:
        findings.diagnostics.extend(error.diagnostics)
        findings.stop()
    item = items[0] if len(items) == 1 else None
    if not isinstance(item, s.Assign) or item.clauses or item.bounds:
        message = f'cannot read --set "{text}"'
        findings.reject("TIS505", message, None, hint='write --set "name = 0.9 s"')
    return item
