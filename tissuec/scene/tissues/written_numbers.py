"""Physical quantities that are written as numbers, in tissues and in regions."""

from contextlib import suppress

from tissuec.core import units
from tissuec.core.hints import did_you_mean
from tissuec.core.units import Dimension, UnitError, parse_unit
from tissuec.lang import syntax as s
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.ranges import refuse_range
from tissuec.scene.tissues.quantities import QUANTITIES

#: Names of quantities in other texts.
_OTHER_NAMES = tuple(dict.fromkeys(word for one in QUANTITIES.values() for word in one.also))


def quantity_meant(item: s.Assign | s.Sentence) -> str:
    """Return the quantity of a tissue that an entry with another name sets, if it is known."""
    near = did_you_mean(item.name.key, _OTHER_NAMES)
    word = near.edits[0].text if near.edits else item.name.key
    dimension = _dimension(item)
    known = [one for one in QUANTITIES.values() if word in one.also]
    fitting = [one for one in known if one.dimension == dimension]
    fitting += [one for one in known if one.also[0] == word]
    return fitting[0].name if fitting else ""


def _dimension(item: s.Assign | s.Sentence) -> Dimension | None:
    match item:
        case s.Assign(value=s.Quantity(unit=unit)):
            with suppress(UnitError):
                return parse_unit(unit).dimension
        case s.Assign(value=s.Number()):
            return units.NUMBER
        case _:
            pass
    return None


def read_given(name: str, item: s.Assign, scope: Scope) -> AssignedQuantity:
    """Return a physical quantity written as a number: ``breaking force = 0.4 N``.

    With ``per 1 mm`` after it, the value is that of springs of this length.

    Args:
        name: Name of the quantity.
        item: The assignment.
    """
    quantity = QUANTITIES[name]
    refuse_range(item, scope.findings)
    said = SentenceReader(quantity.name, SentenceKind((quantity.number,)), item, scope).get()
    value = schema.read_value(quantity.limits, said.number, scope, what=quantity.name)
    length = getattr(said, "length", None)
    return AssignedQuantity(quantity, value, quantity.spreads[0], length, "written", item.span)
