"""Physical quantities that are written as numbers, in tissues and in regions."""

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.core.names import key_of
from tissuec.lang import syntax as s
from tissuec.laws.stiffening import LARGEST_STIFFENING
from tissuec.scene import schema
from tissuec.scene.expressions import Scope
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.quantities import (
    FIBRE_DISPERSION,
    POISSONS_RATIO,
    QUANTITIES,
    SHARES,
    STIFFENING,
    TissueQuantity,
)
from tissuec.scene.ranges import refuse_range

LARGEST_SHARE = 0.99  # of a modulus that relaxes: what is left holds a body together
LARGEST_DISPERSION = 0.3  # at 1/3 fibres have no direction, along which there is a modulus
LARGEST_POISSON = 0.4999  # at 1/2 a solid would keep its volume exactly, and never move


def limits_of(quantity: TissueQuantity) -> Real:
    """Return between which limits a quantity can be written."""
    if quantity.name == "prestress":
        return Real(quantity.dimension, above=-10.0, at_most=0.99)
    if quantity.name in SHARES:
        return Real(quantity.dimension, at_least=0.0, at_most=LARGEST_SHARE)
    if key_of(quantity.name) == POISSONS_RATIO:
        return Real(quantity.dimension, above=-1.0, at_most=LARGEST_POISSON)
    if key_of(quantity.name) == FIBRE_DISPERSION:
        return Real(quantity.dimension, at_least=0.0, at_most=LARGEST_DISPERSION)
    if quantity.name == STIFFENING:
        return Real(quantity.dimension, above=0.0, at_most=LARGEST_STIFFENING)
    if quantity.may_be_zero:
        return Real(quantity.dimension, at_least=0.0)
    return Real(quantity.dimension, above=0.0)


def read_given(name: str, item: s.Assign, scope: Scope) -> AssignedQuantity:
    """Return a physical quantity written as a number: ``breaking force = 0.4 N``.

    With ``per 1 mm`` after it, the value is that of springs of this length.

    Args:
        name: Name of the quantity.
        item: The assignment.
        scope: Looks up names of expressions.
    """
    quantity = QUANTITIES[name]
    refuse_range(item, scope.findings)
    value = schema.read_value(limits_of(quantity), item.value, scope, what=quantity.name)
    length = None
    for clause in item.clauses:
        if clause.word != "per" or not quantity.scales:
            scope.findings.reject(
                "TIS303", f'"{clause.word}" is not allowed after {name}', clause.span
            )
        length = schema.read_value(
            Real(units.LENGTH, above=0.0), clause.value, scope, what="the length"
        )
    return AssignedQuantity(quantity, value, quantity.spreads[0], length, "written", item.span)
