"""Constants of the laws of a tissue that learning can change."""

from collections.abc import Iterator, Mapping
from math import inf

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in, walk
from tissuec.laws import stress_in
from tissuec.laws.formula import Formula, replaced, variables
from tissuec.scene.model import Scene, Tissue, WrittenLaw
from tissuec.scene.reading.entries import entries_of
from tissuec.scene.tissues.laws import FORMS, LAW_KINDS, FormulaScope, LawKind
from tissuec.scene.tissues.quantities import YOUNGS_MODULUS


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
    """Return the constants of a tissue's laws, and params of its formulas, by key."""
    found: dict[str, LawConstant] = {}
    for kind in LAW_KINDS:
        law = tissue.laws.get(kind.word)
        if law is None:
            continue
        if (formula := _formula(law, scene)) is not None:
            found |= {s.key_of(one.name): one for one in _params(formula, scene)}
        elif law.name in kind.family:
            for entry in entries_of(kind.family[law.name]).values():
                number = entry.kind if isinstance(entry.kind, Real) else None
                found[entry.name] = LawConstant(entry.name, number)
    return found


def force_with_params(law: WrittenLaw, scene: Scene, params: Mapping[str, Formula]) -> Formula:
    """Return a free formula with other formulas in place of params.

    Args:
        law: The law that contains the formula.
        params: Formulas by the names of params.
    """
    written = _formula(law, scene)
    assert written is not None
    form = FORMS[written.name.key]
    known = {s.key_of(name): (f"param {s.key_of(name)}", units.NUMBER) for name in params}
    exponents = [name for name, _ in known.values()]
    scope = FormulaScope(scene.constants, {**known, **form.variables(written)}, exponents)
    formula = scope.formula(written.value)
    values = {f"param {s.key_of(n)}": value for n, value in params.items()}
    return form.as_force(replaced(formula, values))


def calls_functions(tissue: Tissue, scene: Scene) -> bool:
    """Return whether a free formula of a tissue calls functions of the scene."""
    formulas = (_formula(law, scene) for law in tissue.written_laws.values())
    return any(isinstance(part, s.Applied) for one in formulas if one for part in walk(one))


def _formula(law: WrittenLaw, scene: Scene) -> s.Function | None:
    """Return the free formula that a law was written as, wherever it was inherited from."""
    for declared in scene.declarations.of("tissue").values():
        if isinstance(declared.item, s.Block):
            for item in declared.item.items:
                if isinstance(item, s.Function) and item.span == law.span:
                    return item
    return None


def _params(formula: s.Function, scene: Scene) -> Iterator[LawConstant]:
    """Yield the params of a formula, with the limits that they were declared with."""
    constants = scene.constants
    for parameter in constants.parameters():
        names = (name.key for name in names_in(formula.value))
        if parameter.item.name.key not in names:
            continue
        low, high = -inf, inf
        if (bounds := parameter.item.bounds) is not None:
            low, high = (
                float(constants.number(bound).amount) for bound in (bounds.low, bounds.high)
            )
        limits = Real(parameter.value.dimension, at_least=low, at_most=high)
        yield LawConstant(parameter.name, limits)
