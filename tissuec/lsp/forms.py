"""The forms of sentences, taken apart: what each joining word of an order or entry holds."""

from functools import cache
from typing import NamedTuple

from tissuec.core import units
from tissuec.core.units import Dimension
from tissuec.lang.words import RESERVED
from tissuec.scene.parts import PARTS, blocks, entries_in
from tissuec.scene.parts import forms_of as part_forms
from tissuec.scene.quantities import QUANTITIES
from tissuec.script.fit_problem import WEIGHTS, WORDS
from tissuec.script.verbs import VERBS
from tissuec.script.verbs.change import PARAMETERS

#: Kinds of names, or sorts of them, that the capital words of forms stand for.
_PLACEHOLDERS: dict[str, tuple[str, ...]] = {
    "SET": ("nodes", "body"), "BODY": ("body",), "TOOL": ("holding",), "THREAD": ("body",),
    "JOINT": ("joint", "set"), "NOZZLE": ("nozzle",),
}  # fmt: skip
#: With which kind of tool verbs do what they do.
_TOOLS = {
    "grasp": "grasping", "release": "grasping", "open": "forceps", "close": "forceps",
    "cut": "scissors",
}  # fmt: skip
#: What is changed of nodes, and not of springs.
_OF_NODES = ("mass", "velocity", "spin")
#: Dimensions of numbers that they stand for.
DIMENSIONS: dict[str, Dimension] = {
    "FORCE": units.FORCE, "FORCES": units.FORCE, "LENGTH": units.LENGTH, "POINT": units.LENGTH,
    "PRESSURE": units.PRESSURE, "FLOW": units.FLOW, "VOLUME": units.VOLUME,
    "DENSITY": units.DENSITY, "ANGLE": units.NUMBER, "FACTOR": units.NUMBER,
}  # fmt: skip
_CHANGES = ("to NUMBER", "by FACTOR")
#: What ``change … to`` takes.
CHANGED = {
    name: quantity.dimension
    for name, quantity in QUANTITIES.items()
    if not quantity.is_of_matter
} | {
    "gravity": units.ACCELERATION, "damping": units.VISCOSITY, "velocity": units.VELOCITY,
    "spin": units.FREQUENCY, "rest length": units.LENGTH,
}  # fmt: skip


class SentenceForm(NamedTuple):
    """One form of a sentence: words and placeholders after its first ones, then clauses."""

    literal: str
    placeholder: str
    clauses: tuple[tuple[str, tuple[str, ...]], ...]

    def fits(self, object_: str, *, of_order: bool) -> bool:
        """Return whether a sentence about something can be of this form.

        Args:
            object_: Words between its first ones and a name, such as "spring constant".
            of_order: Whether it is an order; entries are about more than their forms show.
        """
        if of_order:
            return (self.literal or object_) == object_
        return self.literal == object_ or not {self.literal, object_} & {WORDS, WEIGHTS}


@cache
def forms_of(block: str, entry: str) -> tuple[SentenceForm, ...]:
    """Return the forms of a part, entry or order, taken apart.

    Args:
        block: Kind of the block that it stands in.
        entry: The part, entry or verb.
    """
    return tuple(_form(text, entry) for text in texts_of(block, entry))


def texts_of(block: str, entry: str) -> tuple[str, ...]:
    """Return the forms of a part, entry or order as the reference has them.

    Args:
        block: Kind of the block that it stands in.
        entry: The part, entry or verb.
    """
    if block == "script":
        if entry == "change":  # its forms are examples of what can be changed
            changes = (f"change {name} of SET {how}" for name in PARAMETERS for how in _CHANGES)
            return (*VERBS[entry].forms, *changes)
        return tuple(VERBS[entry].forms) if entry in VERBS else ()
    if not block:
        return part_forms(entry) if entry in PARTS else ()
    found = entries_in(block).get(entry)
    if found is not None:
        return found.forms
    known = blocks().get(block)
    return known.free if known is not None else ()


def _form(text: str, entry: str) -> SentenceForm:
    groups: list[list[str]] = [[]]
    for word in text.removeprefix(entry).replace("(", "( ").split():
        if (word in RESERVED and word != "table") or word == "=":
            groups.append([])
        groups[-1].append(word)
    literal = " ".join(word for word in groups[0] if word.islower())
    placeholder = next((word for word in groups[0] if word.isupper()), "")
    return SentenceForm(
        literal, placeholder, tuple((group[0], tuple(group[1:])) for group in groups[1:])
    )


def kinds_for(verb: str, literal: str, placeholder: str) -> tuple[str, ...]:
    """Return kinds of names that stand for a placeholder of the forms of a verb.

    Args:
        verb: The verb.
        literal: What the verb acts on, as words, such as "spring constant".
        placeholder: Placeholder of a form, such as SET.
    """
    of_springs = verb == "cut" or (verb == "change" and literal not in _OF_NODES)
    if placeholder == "SET" and of_springs:
        return ("set", "body", "joint")
    if placeholder == "TOOL" and verb in _TOOLS:
        return (_TOOLS[verb],)
    return _PLACEHOLDERS.get(placeholder, ())
