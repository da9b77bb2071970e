"""The forms of orders: the object of a verb, and its clauses."""

from functools import cache
from typing import NamedTuple

from tissuec.core import units
from tissuec.core.units import Dimension
from tissuec.lang.words import RESERVED
from tissuec.scene.quantities import QUANTITIES
from tissuec.script.verbs import VERBS
from tissuec.script.verbs.change import PARAMETERS

#: Kinds of names, or sorts of them, that the capital words of forms stand for.
_PLACEHOLDERS: dict[str, tuple[str, ...]] = {
    "SET": ("nodes", "body"), "BODY": ("body",), "TOOL": ("holding",), "THREAD": ("body",),
    "JOINT": ("joint", "set"), "NOZZLE": ("nozzle",),
}  # fmt: skip
#: With which kind of tool verbs do what they do.
_TOOLS = {
    "grasp": "forceps", "release": "forceps", "open": "forceps", "close": "forceps",
    "cut": "scissors",
}  # fmt: skip
#: What is changed of nodes, and not of springs.
_OF_NODES = ("mass", "velocity", "spin")
#: Dimensions of numbers that they stand for.
DIMENSIONS: dict[str, Dimension] = {
    "FORCE": units.FORCE, "FORCES": units.FORCE, "LENGTH": units.LENGTH, "POINT": units.LENGTH,
    "PRESSURE": units.PRESSURE, "FLOW": units.FLOW, "VOLUME": units.VOLUME,
    "ANGLE": units.NUMBER, "FACTOR": units.NUMBER,
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


class Form(NamedTuple):
    """One form of a verb's sentence: words and placeholders after it, then clauses."""

    literal: str
    placeholder: str
    clauses: tuple[tuple[str, tuple[str, ...]], ...]


@cache
def forms_of(verb: str) -> tuple[Form, ...]:
    """Return the forms of a verb, taken apart."""
    if verb not in VERBS:
        return ()
    forms = list(VERBS[verb].forms)
    if verb == "change":  # its forms are examples of what can be changed
        forms += (f"change {name} of SET {how}" for name in PARAMETERS for how in _CHANGES)
    return tuple(map(_form, forms))


def _form(text: str) -> Form:
    groups: list[list[str]] = [[]]
    for word in text.split()[1:]:
        if word in RESERVED and word != "table":
            groups.append([])
        groups[-1].append(word)
    literal = " ".join(word for word in groups[0] if word.islower())
    placeholder = next((word for word in groups[0] if word.isupper()), "")
    return Form(
        literal, placeholder, tuple((group[0], tuple(group[1:])) for group in groups[1:])
    )
