"""The forms of an order, an entry or a measure while it is typed, and what comes next."""

import re

from msgspec import Struct

from tissuec.lsp import vocabulary as v
from tissuec.lsp.forms import texts_of
from tissuec.lsp.phrases import prefix_at
from tissuec.lsp.prefix import Prefix
from tissuec.lsp.views import View
from tissuec.lsp.vocabulary import entries
from tissuec.scene.reading.parts import PARTS

#: Placeholders in a form: "SET", "…", "(x, y, z)", a file in quotes.
_PLACEHOLDER = re.compile(r"\b[A-Z]+\b|…|\"[^\"]*\"|\(x, y, z\)")


class WrittenForm(Struct, frozen=True):
    """One way to write a sentence or a measure.

    Attributes:
        text: As the reference has it: "move SET by VECTOR using PROFILE".
        places: Where what is to be filled in begins and ends, with the word before it.
    """

    text: str
    places: tuple[tuple[int, int], ...]

    @property
    def words(self) -> list[str]:
        """Return the fixed words: all but the placeholders."""
        return [word for word in _PLACEHOLDER.sub(" ", self.text).split() if word != "("]


class OfferedForms(Struct, frozen=True):
    """What can be written at a place.

    Attributes:
        forms: All forms.
        active: The first one that fits what is typed.
        place: Which of the places of this form is typed.
        about: What it does, in Markdown.
    """

    forms: tuple[WrittenForm, ...]
    active: int
    place: int
    about: str


def signature(view: View, offset: int) -> OfferedForms | None:
    """Return the forms of the statement that is typed at an offset; None without any."""
    if view.in_remark(offset) or view.structure.in_rows(offset):
        return None
    prefix = prefix_at(view.structure.at(offset), offset)
    return _measure(prefix) or _sentence(prefix)


def _measure(prefix: Prefix) -> OfferedForms | None:
    """Return the form of the measure or function whose bracket is open."""
    if not prefix.call or prefix.call in "([":
        return None
    term = v.measures().get(prefix.call) or v.functions().get(prefix.call)
    if term is None or "(" not in term.form:
        return None
    start, stop = term.form.index("(") + 1, term.form.rindex(")")
    places: list[tuple[int, int]] = []
    for part in term.form[start:stop].split(","):
        lead = len(part) - len(part.lstrip())
        places.append((start + lead, start + len(part)))
        start += len(part) + 1
    place = min(prefix.commas[-1], len(places) - 1)
    return OfferedForms((WrittenForm(term.form, tuple(places)),), 0, place, term.about)


def _sentence(prefix: Prefix) -> OfferedForms | None:
    """Return the forms of an order, an entry of a block, or a statement outside of all."""
    block = prefix.block
    if block.kind == "script":
        entry = prefix.head if prefix.has_verb else ""
        term = v.verbs().get(entry)
    else:
        entry = prefix.subject or ("" if block.kind else prefix.head)
        term = entries(block).get(entry)
    if not entry or (term is None and block.kind):
        return None
    forms = tuple(_form(text) for text in texts_of(block.kind, entry))
    if len(forms) < 2 and not any(form.places for form in forms):
        return None  # nothing to fill in or to choose
    words = {word for form in forms for word in form.words}
    typed = [text for text in prefix.texts if text in words]
    active = next((n for n, form in enumerate(forms) if _fits(form, typed)), 0)
    about = term.about if term is not None else PARTS[entry].about if entry in PARTS else ""
    return OfferedForms(forms, active, _place(forms[active], typed), about)


def _form(text: str) -> WrittenForm:
    places: list[tuple[int, int]] = []
    for found in _PLACEHOLDER.finditer(text):
        before = re.search(r"(?:\b[a-z]+|=) $", text[: found.start()])
        start = before.start() if before and (places or before[0] == "= ") else found.start()
        places.append((start, found.end()))
    return WrittenForm(text, tuple(places))


def _fits(form: WrittenForm, typed: list[str]) -> bool:
    """Return whether a form has the words that are typed, in their order."""
    place = 0
    for word in typed:
        if word not in form.words[place:]:
            return False
        place = form.words.index(word, place) + 1
    return True


def _place(form: WrittenForm, typed: list[str]) -> int:
    """Return the place after the last word of the form that is typed."""
    place = 0
    for word in typed:
        behind = (
            number
            for number, (start, stop) in enumerate(form.places)
            if number >= place and form.text[start:stop].split()[0] == word
        )
        found = next(behind, None)
        place = place if found is None else found + 1
    return max(place - 1, 0)
