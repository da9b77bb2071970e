"""The forms of sentences, taken apart: what each joining word of an order or entry holds."""

from functools import cache
from typing import NamedTuple

from tissuec.core import units
from tissuec.core.units import Dimension
from tissuec.lang.words import RESERVED
from tissuec.lsp.entries import entries
from tissuec.lsp.terms import BlockKind
from tissuec.scene import learn_entries, study_entries
from tissuec.scene.element_bodies import MADE_OF
from tissuec.scene.laws import FORMS
from tissuec.scene.quantities import QUANTITIES
from tissuec.scene.settings import SYMMETRIC
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

#: Forms of parts and entries that no schema describes; "" are those of all others in a block.
_FORMS: dict[tuple[str, str], tuple[str, ...]] = {
    ("", "hedge"): ("hedge NAME = SHAPE",),
    ("", "property"): ("property NAME from NUMBER to NUMBER on log scale",),
    ("", "quantity"): ("quantity NAME from NUMBER to NUMBER on log scale",),
    ("", "tissue"): ("tissue NAME like TISSUE",),
    ("", "param"): ("param NAME = NUMBER between NUMBER and NUMBER",),
    ("", "set"): ("set NAME = nodes of DRAWN in LIST where CONDITION",),
    ("", "table"): ("table nodes of BODY in UNIT with columns",),
    ("", "expect"): (
        "expect CONDITION at TIME", "expect CONDITION from TIME to TIME",
        "expect CONDITION until TIME", "expect CONDITION over run",
    ),
    ("tissue", ""): ("NAME is WORD", "NAME = NUMBER per LENGTH"),
    ("tissue", "described"): ("described in RULES",),
    ("tissue", "known"): (
        "known NAME = NUMBER by SOURCE", "known NAME from NUMBER to NUMBER",
        "known stress in MODE at LIST from LIST to LIST by SOURCE",
        "known relaxation at LIST from LIST to LIST by SOURCE",
    ),
    ("law", ""): ("NAME is LAW",),
    ("body", "region"): ("region NAME where CONDITION",),
    ("body", "made"): tuple(f"made of {word}" for word in MADE_OF),
    ("body", "springs"): ("springs where CONDITION",),
    ("body", "interface"): ("interface is MEAN from REGION to REGION",),
    ("environment", SYMMETRIC): (f"{SYMMETRIC} through POINT facing VECTOR",),
    ("joint", "springs"): ("springs from SET to SET",),
    ("force", "acts"): ("acts on SET",),
    ("output", ""): ("MEASURE of MEASURED to MEASURED every TIME",),
    ("output", "surface"): ("surface of BODY every TIME",),
    ("output", "trajectory"): ("trajectory of SET with FIELD every TIME",),
    ("output", "precision"): ("precision is CHOICE",),
    ("output", "compress"): ("compress",),
    ("output", "blocks"): ("blocks",),
    ("quantity", "applies"): ("applies to SPREAD of LENGTH",),
    ("quantity", "otherwise"): ("otherwise is WORD",),
    ("quantity", ""): ("WORD from NUMBER to NUMBER until NUMBER",),
    ("property", ""): ("WORD from NUMBER to NUMBER until NUMBER",),
}  # fmt: skip
_SENTENCES = {"learn": learn_entries.SENTENCES, "study": study_entries.SENTENCES}


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
    if entry in _SENTENCES.get(block, ()):
        return _SENTENCES[block][entry].forms
    if (block, entry) in _FORMS:
        return _FORMS[block, entry]
    if block in ("tissue", "law") and entry in FORMS:
        return tuple(f"{head} = NUMBER" for head in FORMS[entry].heads)
    if (block, "") in _FORMS:
        return _FORMS[block, ""]
    term = entries(BlockKind(block)).get(entry)
    return (term.form or f"{term.label}{term.behind}…",) if term is not None else ()


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
