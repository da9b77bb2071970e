"""Reserved words that can follow at a place, from the forms of its sentence.

The grammar then narrows them.
"""

from collections.abc import Iterator

from tissuec.lsp.forms import fitting
from tissuec.lsp.prefix import Prefix
from tissuec.scene.program.repetition import REPEAT

_LOGIC = ("and", "or", "not", "is", "between", "within", "of")
_OF_TRIGGERS = ("to", "every", "and", "or", "not", "between", "along")


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
    return [*([] if prefix.calls else _clauses_left(prefix)), *_inside(prefix)]


def _clauses_left(prefix: Prefix) -> Iterator[str]:
    """Yield the joining words of the forms of a sentence that are not written yet."""
    found = dict[str, None]()
    for form in fitting(prefix):
        words = [one.word for one in form.clauses]
        past = words.index("=") + 1 if "=" in words and prefix.has("=") else 0
        for index, one in enumerate(form.clauses[past:], start=past):
            is_left = prefix.openers.count(one.word) == words[:index].count(one.word)
            is_next = all(prefix.has(word) if word else prefix.object for word in one.needs)
            if is_left and is_next and one.word not in ("", "="):
                found[one.word] = None
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
