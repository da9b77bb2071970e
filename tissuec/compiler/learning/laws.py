"""Constants of the laws of a tissue that learning can change.

A constant is the entry of a law, or a param in an entry or a formula.
"""

from collections.abc import Iterator, Mapping
from math import inf
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.fields import Real
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in, walk
from tissuec.laws import stress_in
from tissuec.laws.formula import Formula, given, replaced, variables
from tissuec.scene.model import Scene, Tissue, WrittenLaw
from tissuec.scene.reading.entries import entries_of
from tissuec.scene.reading.expressions import InnerScope, Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.values import Value
from tissuec.scene.tissues.laws import (
    FORMS,
    LAW_KINDS,
    SOLID_LAW,
    Entry,
    FormulaScope,
    LawKind,
    read_law,
)
from tissuec.scene.tissues.quantities import YOUNGS_MODULUS

_KINDS = {kind.word: kind for kind in LAW_KINDS}


class LawConstant(Struct, frozen=True):
    """A number in a law.

    Attributes:
        name: Of the entry, or of the param.
        kind: Its dimension and limits; None if it is no single number.
    """

    name: str
    kind: Real | None


def uses(tissue: Tissue, quantity: str) -> str | None:
    """Return which law of a tissue makes no use of a quantity that laws use; None if all do."""
    for kind in LAW_KINDS:
        law = tissue.laws.get(kind.word)
        if law is None:
            continue
        stress = stress_in(law.formula)
        used = _variable(kind, quantity, is_stress=stress is not None)
        if used and used not in variables(stress or law.formula):
            return kind.word
    return None


def _variable(kind: LawKind, quantity: str, *, is_stress: bool) -> str:
    """Return as what formulas of a law use a quantity; empty if they cannot."""
    if quantity == YOUNGS_MODULUS and not is_stress:
        return ""  # it is in the spring constant
    used = (form.names[quantity][0] for form in kind.forms if quantity in form.names)
    return next(used, "")


def constants_of(tissue: Tissue, scene: Scene) -> dict[str, LawConstant]:
    """Return the constants of a tissue's laws, and params in these, by key."""
    found: dict[str, LawConstant] = {}
    for kind in LAW_KINDS:
        law = tissue.laws.get(kind.word)
        if law is None:
            continue
        if (item := _item(law, scene)) is not None:
            found |= {s.key_of(one.name): one for one in _params(item, scene)}
        if law.law is not None and law.name in kind.family:
            for entry in entries_of(kind.family[law.name]).values():
                number = entry.kind if isinstance(entry.kind, Real) else None
                found[entry.name] = LawConstant(entry.name, number)
    return found


def constant_of(tissue: Tissue, name: str, scene: Scene) -> float:
    """Return the value of a constant of a tissue's laws, or of a param in these [SI]."""
    for law in tissue.laws.values():
        entry = entries_of(type(law.law)).get(name) if law.law is not None else None
        if entry is not None:
            return float(getattr(law.law, entry.field))
    params = {s.key_of(p.name): p.value for p in scene.constants.parameters()}
    return float(params[s.key_of(name)].amount)


def is_variable(tissue: Tissue, name: str, scene: Scene) -> bool:
    """Return whether a constant can be a variable of compiled laws, with exact derivatives.

    Those of solids are numbers of elements instead. Params from which entries of laws of
    springs are computed cannot be variables.
    """
    for word, law in tissue.laws.items():
        is_entry = law.law is not None and name in entries_of(type(law.law))
        if not is_entry and s.key_of(name) not in params_in(law, scene):
            continue
        if word == SOLID_LAW or (law.law is not None and not is_entry):
            return False
    bodies = (body for body in scene.bodies.values() if body.elements is not None)
    return tissue.name not in {one.name for body in bodies for one in body.tissues}


def with_constants(
    word: str, law: WrittenLaw, constants: Mapping[str, Any], scene: Scene
) -> WrittenLaw:
    """Return a law with other constants, as far as they are its own.

    Args:
        word: The entry of the law, such as "solid law".
        constants: Values by name, in SI units; of ``is_variable`` ones, also formulas.

    Raises:
        CompileError: The law does not exist with these constants.
    """
    if law.law is None:
        params = {name: given(one) for name, one in constants.items()}
        return replace(law, formula=force_with_params(law, scene, params))
    entries, inner = entries_of(type(law.law)), params_in(law, scene)
    params = {s.key_of(name): one for name, one in constants.items() if name not in entries}
    if inner & params.keys():
        law = _read_again(_KINDS[word], law, params, scene)
    own = {entries[name].field: one for name, one in constants.items() if name in entries}
    if not own:
        return law
    former: Any = law.law  # which is a Struct
    try:
        changed: Any = replace(former, **own)
    except ValueError as error:
        wrong = Diagnostic("TIS309", f"{word} {law.name}: {error}", law.span)
        raise CompileError([wrong]) from error
    return replace(law, law=changed, formula=_KINDS[word].formula(changed))


class _ParamScope(InnerScope):
    """A scope in which some params have other values.

    Args:
        values: In SI units, by key.
    """

    def __init__(self, constants: Scope, values: Mapping[str, float], findings: Findings):
        super().__init__(constants, findings)
        self.values = values

    def name(self, name: s.Name) -> Value:
        found = self.constants.name(name)
        if name.key not in self.values:
            return found
        return Value(np.asarray(self.values[name.key]), found.dimension)

    def has(self, name: s.Name) -> bool:
        return self.constants.has(name)

    def names(self) -> list[str]:
        return [*self.constants.names()]


def _read_again(
    kind: LawKind, law: WrittenLaw, params: Mapping[str, float], scene: Scene
) -> WrittenLaw:
    """Return a law from its text, with other values of params."""
    item, findings = _item(law, scene), Findings()
    assert item is not None
    found: list[WrittenLaw] = []
    with findings.item():
        found.append(read_law(kind, item, _ParamScope(scene.constants, params, findings)))
    findings.raise_errors()
    return found[0]


def force_with_params(law: WrittenLaw, scene: Scene, params: Mapping[str, Formula]) -> Formula:
    """Return a free formula with other formulas in place of params.

    Args:
        law: The law that contains the formula.
        params: Formulas by the names of params.
    """
    written = _item(law, scene)
    assert isinstance(written, s.Function)
    form = FORMS[written.name.key]
    known = {s.key_of(name): (f"param {s.key_of(name)}", units.NUMBER) for name in params}
    exponents = [name for name, _ in known.values()]
    scope = FormulaScope(scene.constants, {**known, **form.variables(written)}, exponents)
    formula = scope.formula(written.value)
    values = {f"param {s.key_of(n)}": value for n, value in params.items()}
    return form.as_force(replaced(formula, values))


def calls_functions(tissue: Tissue, scene: Scene) -> bool:
    """Return whether a free formula of a tissue calls functions of the scene."""
    items = (_item(law, scene) for law in tissue.written_laws.values())
    formulas = (one for one in items if isinstance(one, s.Function))
    return any(isinstance(part, s.Applied) for one in formulas for part in walk(one))


def params_in(law: WrittenLaw, scene: Scene) -> set[str]:
    """Return the keys of params in a formula, or in the entries of a law."""
    item = _item(law, scene)
    return set() if item is None else {s.key_of(one.name) for one in _params(item, scene)}


def _item(law: WrittenLaw, scene: Scene) -> Entry | None:
    """Return the entry that a law was written as, wherever it was inherited from."""
    for declared in scene.declarations.of("tissue").values():
        if isinstance(declared.item, s.Block):
            for item in declared.item.items:
                if isinstance(item, Entry) and item.span == law.span:
                    return item
    return None


def _params(item: Entry, scene: Scene) -> Iterator[LawConstant]:
    """Yield the params in a law, with the limits that they were declared with."""
    constants, used = scene.constants, {name.key for name in names_in(values_of(item))}
    for parameter in constants.parameters():
        if parameter.item.name.key not in used:
            continue
        low, high = -inf, inf
        if (bounds := parameter.item.bounds) is not None:
            low, high = (
                float(constants.number(bound).amount) for bound in (bounds.low, bounds.high)
            )
        limits = Real(parameter.value.dimension, at_least=low, at_most=high)
        yield LawConstant(parameter.name, limits)


def values_of(item: s.Item) -> tuple[s.Expression, ...]:
    """Return the formula that a law is, or the values of its entries."""
    match item:
        case s.Function() | s.Assign():
            return (item.value,)
        case s.Block():
            return tuple(value for inner in item.items for value in values_of(inner))
        case _:
            return ()
