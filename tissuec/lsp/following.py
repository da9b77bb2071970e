"""Reserved words that can follow at a place, from the forms of its sentence.

The grammar then narrows them.
"""

from collections.abc import Iterator
from itertools import pairwise

from tissuec.lsp.forms import forms_of
from tissuec.lsp.prefix import Prefix
from tissuec.scene.program.repetition import REPEAT
from tissuec.scene.study.entries import AGGREGATES
from tissuec.script.measures import MEASURES

_LOGIC = ("and", "or", "not", "is", "between", "within", "of")
_OF_TRIGGERS = ("to", "every", "and", "or", "not", "between", "along")
#: Words that follow one of some others, in the forms that have those before them.
_SECOND = {"to": ("from",), "and": ("between",), "in": ("using", "along")}
#: Words that a sentence can have several times, by its block: ``of scar of vessel``.
_REPEATED = (("learn", "of"), ("study", "of"))


def following(prefix: Prefix) -> list[str]:
    """Return the reserved words that could follow, in the order of the forms."""
    kind, head = prefix.block.kind, prefix.head
    if prefix.has_verb and "table" in prefix.texts:
        return ["in"]  # the unit of its columns
    if prefix.has_verb and prefix.clause == "using":
        return ["of"]  # the frequency of a sine
    if kind == "rules" and head == "if":
        return (
            ["is", "and", "weighing"]
            if prefix.has("then")
            else ["is", "and", "or", "not", "then"]
        )
    if prefix.has("where"):
        return list(_LOGIC)
    if kind == "script" and not prefix.has_verb and head != REPEAT:
        return list(_OF_TRIGGERS)
    if kind == "study" and prefix.subject == "measure" and prefix.has("="):
        return list(_of_measure(prefix))
    return [*([] if prefix.calls else _clauses_left(prefix)), *_inside(prefix)]


def _of_measure(prefix: Prefix) -> Iterator[str]:
    """Yield the words that may follow what a study measures."""
    start = prefix.texts.index("=") + 1
    first, *_ = (*prefix.texts[start:], "")
    if first == "time":
        yield "of"  # the kind of events, and their springs
        return
    if first in AGGREGATES and not prefix.calls:
        words = ("over", "from", "to" if prefix.has("from") else "until", "every")
    else:
        measure = MEASURES.get(prefix.measure)
        second = ("to",) if measure is not None and measure.subjects > 1 else ()
        words = ("of", *second, "along", *(() if prefix.calls else ("at", "every")))
    yield from (word for word in words if not prefix.has(word))


def _clauses_left(prefix: Prefix) -> Iterator[str]:
    """Yield the joining words of the forms of a sentence that are not written yet."""
    kind = prefix.block.kind
    forms = forms_of(kind, prefix.head if kind in ("", "script") else prefix.subject)
    found = dict[str, None]()
    for form in forms:
        if not form.fits(prefix.object, of_order=prefix.has_verb):
            continue
        words = [word for word, _ in form.clauses]
        for before, word in pairwise(["", *words]):
            if prefix.subject == "vary":
                begun = bool(prefix.object)
                is_behind = begun and (prefix.openers or [""])[-1] in (before, word)
            else:
                is_behind = before not in _SECOND.get(word, ()) or prefix.has(before)
            is_left = not prefix.has(word) or (kind, word) in _REPEATED
            if word != "=" and is_behind and is_left:
                found[word] = None
    yield from found


def _inside(prefix: Prefix) -> tuple[str, ...]:
    """Return the words that may follow what is chosen or measured at a place."""
    if prefix.head == "expect" and prefix.block.kind == "study":
        return ("and", "or", "not", "between")
    if prefix.head == "expect":
        return ("and", "or", "not", "between", "along", "of")
    if prefix.block.kind == "tissue" and prefix.is_choosing:
        return ("between", "and")
    return ("along", "of") if prefix.in_measure else ()
