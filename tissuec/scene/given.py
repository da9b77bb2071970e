"""Physical quantities that are written as numbers, in tissues and in regions."""

from tissuec.core import units
from tissuec.core.fields import Measure
from tissuec.lang import syntax as s
from tissuec.scene import schema
from tissuec.scene.expressions import Scope
from tissuec.scene.model import Given
from tissuec.scene.quantities import QUANTITIES


def read_given(name: str, item: s.Assign, scope: Scope) -> Given:
    """Return a physical quantity written as a number: ``fraction force = 0.4 N``.

    ``per 1 mm`` behind it makes it a value for springs of that length.
    """
    quantity = QUANTITIES[name]
    low = {"at_least": 0.0} if quantity.may_be_zero and name != "prestress" else {"above": 0.0}
    limits = {"above": -10.0, "at_most": 0.99} if name == "prestress" else low
    value = schema.read_value(
        Measure(quantity.dimension, **limits), item.value, scope, what=name
    )
    length = None
    for clause in item.clauses:
        if clause.word != "per" or not quantity.scales:
            scope.findings.reject(
                "TIS303", f'"{clause.word}" cannot stand behind {name}', clause.span
            )
        length = schema.read_value(
            Measure(units.LENGTH, above=0.0), clause.value, scope, what="the length"
        )
    return Given(quantity, value, quantity.spreads[0], length, "written", item.span)
