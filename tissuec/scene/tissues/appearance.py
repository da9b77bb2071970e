"""How tissues look in pictures: entries without influence on a run."""

import re
from typing import Annotated

from tissuec.core.fields import Real
from tissuec.core.hints import Edit, Hint, did_you_mean
from tissuec.core.structs import replace
from tissuec.core.units import NUMBER
from tissuec.lang import syntax as s
from tissuec.scene.model import Appearance
from tissuec.scene.reading import schema
from tissuec.scene.reading.entries import by_name, entry, written
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ValueClause

COLOUR, GLOSS = "colour", "gloss"
_HEX = re.compile(r"#(?:[0-9a-fA-F]{3}|[0-9a-fA-F]{6})")
#: Colours that people name, as organs have them.
_NAMED = {
    "red": "#b3342d", "dark red": "#7a2a26", "brown": "#7a3b34", "pink": "#e39c96",
    "yellow": "#e8c766", "white": "#f2ede3", "green": "#6f8f4e", "blue": "#4a6fa5",
    "grey": "#9a9a9a", "gray": "#9a9a9a", "orange": "#d98545", "purple": "#7d5a86",
    "black": "#2b2b2b",
}  # fmt: skip


class ColourWords(VerbSentence, frozen=True):
    """A colour in hexadecimal digits."""

    colour: Annotated[s.Expression, ValueClause("=", place='"#7a3b34"')]


def read_appearance(
    item: s.Sentence | s.Assign, before: Appearance, scope: Scope
) -> Appearance:
    """Return how a tissue looks with one more entry.

    Args:
        item: The entry, ``colour`` or ``gloss``.
        before: How it looked without.
    """
    key = item.name.key
    return replace(before, **{key: schema.read_entry(APPEARANCE[key], item, scope)})


def _colour(item: s.Sentence | s.Assign, scope: Scope) -> str:
    """Return a colour as "#rrggbb"."""
    text = ""
    if isinstance(item, s.Assign) and isinstance(item.value, s.Name) and not item.clauses:
        text = item.value.quoted or ""
        if _HEX.fullmatch(text):
            return text.lower() if len(text) == 7 else "#" + "".join(2 * x for x in text[1:])
    written = text or item.span.text.partition("is" if isinstance(item, s.Sentence) else "=")[2]
    near = did_you_mean(written.strip(' "').lower(), _NAMED).edits
    named = _NAMED.get(written.strip(' "').lower()) or _NAMED.get(near[0].text if near else "")
    form = f'colour = "{named or "#7a3b34"}"'
    what = "write" if named else "for example:"
    scope.findings.reject(
        "TIS312",
        'a colour is written as red, green and blue in hexadecimal digits, "#rrggbb"',
        item.span,
        hint=Hint(f"{what} {form}", Edit(form, item.span)) if named else f"{what} {form}",
    )


#: Entries of a tissue without influence on a run.
APPEARANCE = by_name(
    written(
        COLOUR, 'The colour in pictures, in hexadecimal digits: colour = "#7a3b34".',
        ColourWords, begins=' = "#', reads=_colour,
    ),
    entry(
        GLOSS, Real(NUMBER, at_least=0.0, at_most=1.0, example="0.3"),
        "how much it shines in pictures",
    ),
)  # fmt: skip
