"""Parts of sentences, as the classes of verbs declare them in the annotations of their fields.

From one declaration follow what a sentence is read to, the messages about what is missing,
strange or wrong in it, what editors offer at each place, and the forms of the reference. A
part is required unless its type includes None or its field has a default.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal, NamedTuple

from msgspec import Struct

from tissuec.core.arrays import Floats
from tissuec.core.hints import Hint
from tissuec.core.units import LENGTH, NUMBER, Dimension
from tissuec.script.verbs import Group, Mover, Order


class Placeholder(Struct, frozen=True):
    """A capital word of forms, and the kinds of names that can be written for it.

    Attributes:
        names: Kinds of declarations such as "body", or sorts of them: "nodes" are sets of
            nodes, "holding" tools that can be moved, others kinds of tools.
        words: Words of the language that can be written for it.
        about: What these mean.
        new: Kind of the name that is new here, if one is.
    """

    text: str
    names: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    about: str = ""
    new: str = ""


SET = Placeholder("SET", ("nodes", "body"))
SPRINGS = Placeholder("SET", ("set", "body", "joint"))
BODY = Placeholder("BODY", ("body",))
TOOL = Placeholder("TOOL", ("holding",))
THREAD = Placeholder("THREAD", ("body",))
JOINT = Placeholder("JOINT", ("joint", "set"))
REGION = Placeholder("REGION", ("region",))
TISSUE = Placeholder("TISSUE", ("tissue",))
FORCE = Placeholder("FORCE", ("force",))
RULES = Placeholder("RULES", ("rules",))
QUANTITY = Placeholder("QUANTITY", ("quantity", "property"))
WORD = Placeholder("WORD", new="word")


class Part(Struct, frozen=True, kw_only=True):
    """What is written at one place of a sentence.

    Attributes:
        what: Its name in messages, such as "vector of the motion".
        example: The part as it could be written, such as "by (0, 0, 1) mm".
        place: What it is called in forms; without it, the first word of ``what``: VECTOR.
        about: What it means, for editors.
        moves: Whether it is how much an action moves, so that 0 moves nothing.
    """

    what: str = ""
    example: str = ""
    place: str = ""
    about: str = ""
    moves: bool = False

    @property
    def placeholder(self) -> str:
        """The capital word for it in forms."""
        return self.place or self.what.partition(" ")[0].upper()


class ClausePart(Part, frozen=True):
    """A part with a joining word before it.

    Attributes:
        word: The joining word; empty directly after the verb.
    """

    word: str


class SubjectPart(Part, frozen=True):
    """The name of what a verb acts on.

    Attributes:
        kind: "nodes" of a set or body, "springs" of a set, body or joint, or a set or tool
            that is "moved".
        places: What it can be, in forms.
        word: The joining word; empty directly after the verb.
        alone: Whether it is one set or body, and no union.
    """

    kind: Literal["nodes", "springs", "moved"]
    places: tuple[Placeholder, ...]
    word: str = ""
    alone: bool = False


class ToolClause(ClausePart, frozen=True):
    """The name of a tool of a kind.

    Attributes:
        kind: Kind of the tool; "grasping" for all kinds that hold nodes, "cutting" for all that
            cut.
        entries: Whether its entries are read instead of its name.
    """

    kind: str
    entries: bool = False


class NumberClause(ClausePart, frozen=True):
    """A number.

    Attributes:
        dimension: Its dimension, or that for each word of the case in which it is written.
        sign: Which numbers are accepted: all, those above 0, or 0 and those above.
        words: Words that can be written instead, with their values in SI units.
    """

    dimension: Dimension | Mapping[str, Dimension]
    sign: Literal["any", "positive", "not negative"] = "any"
    words: Mapping[str, float] = {}


class AngleClause(ClausePart, frozen=True):
    """An angle; one of more than a whole turn that is written without a unit is doubtful."""


class VectorClause(ClausePart, frozen=True):
    """A vector of three components."""

    dimension: Dimension


class DirectionClause(ClausePart, frozen=True):
    """A vector without a unit, which is read to a unit vector."""


class DirectedClause(ClausePart, frozen=True):
    """A vector, or an amount followed by a clause with a direction.

    Attributes:
        along: The joining word of the direction.
        direction: The clause of the direction as it could be written.
    """

    dimension: Dimension
    along: str
    direction: str


class RangeClause(ClausePart, frozen=True):
    """Two numbers that are not negative, of which the second, after "to", is the larger."""

    dimension: Dimension


class ChoiceClause(ClausePart, frozen=True):
    """One of some words.

    Attributes:
        words: The words, with a description of each.
        what: Name of the kind of word, in the singular.
        in_forms: Whether forms show it, because no other part includes its words.
    """

    words: Mapping[str, str]
    in_forms: bool = True


class NameClause(ClausePart, frozen=True):
    """A name that code of its own looks up.

    Attributes:
        places: What it can be, in forms.
        owners: What can follow the same word again: ``of scar of vessel``.
        listed: Whether it can be a list of names; then it is read as an expression.
        joins: Whether it can be a union, which is read to one name.
    """

    places: tuple[Placeholder, ...] = ()
    owners: tuple[Placeholder, ...] = ()
    listed: bool = False
    joins: bool = False


class ValueClause(ClausePart, frozen=True):
    """An expression that code of its own evaluates.

    Attributes:
        dimension: Of numbers, where it is known.
        places: What it can be beside numbers, in forms.
    """

    dimension: Dimension | None = None
    places: tuple[Placeholder, ...] = ()


class ConditionClause(ClausePart, frozen=True):
    """A condition that code of its own decides; directly after the first words without one."""


class ConcludedClause(ClausePart, frozen=True):
    """What a rule concludes: ``QUANTITY is WORD and …``, which code of its own decides."""


class LimitsClause(ClausePart, frozen=True):
    """Two numbers, ``between LOW and HIGH``, which code of its own evaluates."""


class UnionClause(ClausePart, frozen=True):
    """Names in brackets, ``[A, B]``, which are read to the name of their union.

    Attributes:
        places: What each of them can be, in forms.
        count: How many of them forms show.
    """

    places: tuple[Placeholder, ...]
    count: int = 2


class MeasureClause(ClausePart, frozen=True):
    """A measure, or an expression of several.

    Attributes:
        functions: Functions of which one is called; any expression without them.
        others: What can be measured here beside measures.
    """

    functions: tuple[str, ...] = ()
    others: tuple[str, ...] = ()


class TextClause(ClausePart, frozen=True):
    """A text in quotes, directly after the first words."""


class FilesClause(ClausePart, frozen=True):
    """The name of a file in quotes, or a list of such names after "=".

    Attributes:
        is_new: Whether it need not be there.
    """

    is_new: bool = False


class ColumnsClause(ClausePart, frozen=True):
    """``column "force_N"`` or ``columns "x y z"``, with a unit after ``in``.

    Attributes:
        dimension: Of what the columns contain; ``OWN`` is that of the sentence.
    """

    dimension: Dimension | Mapping[str, Dimension]


class UnitClause(ClausePart, frozen=True):
    """A unit."""

    dimension: Dimension | Mapping[str, Dimension]


class FlagPart(Part, frozen=True):
    """Words that are written or not, such as "with caps"."""

    text: str

    @property
    def word(self) -> str:
        """The joining word."""
        return self.text.partition(" ")[0]


class ProfileClause(Part, frozen=True):
    """A time profile after ``using``.

    Attributes:
        at_once: The profile without the clause, if there is no interval; without a default
            (None), the clause is not allowed then, and an empty one must be written.
        over: The same for an interval.
        path: Joining word of the clause without which a table has the columns of a path.
    """

    at_once: str | None
    over: str
    path: str = ""

    word = "using"


class LastingPart(Part, frozen=True):
    """How long the sentence lasts [s]; None if it happens at once."""


class Amount(NamedTuple):
    """A number and the joining word before it."""

    word: str
    number: float  # in SI units


class EitherClause(Part, frozen=True):
    """Exactly one of several clauses with numbers, which is read to an ``Amount``."""

    clauses: tuple[NumberClause, ...]


class CasePart(Part, frozen=True):
    """The words by which the form of the sentence was chosen."""


class Cases(ClausePart, frozen=True):
    """Words that decide on the rest of a sentence.

    Attributes:
        forms: The class of the sentence for each; an empty text for a sentence without them.
        wrong: Message for other words, with a pair of braces for them.
        code: Its code.
        shown: Those that hints name; all if empty.
        hint: The remedy for a wrong sentence, if it is not one of the words.
    """

    forms: Mapping[str, type[Any]]
    wrong: str
    code: str = "TIS305"
    shown: tuple[str, ...] = ()
    hint: Callable[[Order], Hint] | None = None


class Refusal(Struct, frozen=True):
    """Why a verb does not take a clause that might be expected of it."""

    message: str
    hint: str


#: Time profiles of forces, of motions, and of changes that happen at once without an interval.
STEADY, MOVING = ProfileClause("constant", "constant"), ProfileClause("", "")
CHANGING = ProfileClause("constant", "ramp")

#: The dimension of what a sentence is about, which its reader is given.
OWN: Mapping[str, Dimension] = MappingProxyType({})

Nodes = Annotated[Group, SubjectPart("nodes", (SET,))]
Springs = Annotated[Group, SubjectPart("springs", (SPRINGS,))]
Moved = Annotated[Mover, SubjectPart("moved", (SET, TOOL))]
Lasting = Annotated[float | None, LastingPart()]
Chosen = Annotated[str, CasePart()]


def new_name(kind: str, what: str = "") -> NameClause:
    """Return the place of the name of something that is declared.

    Args:
        kind: What is declared, such as "body".
        what: What messages call the name.
    """
    return NameClause("", what=what, places=(Placeholder("NAME", new=kind),))


def point(word: str, example: str = "(10, 0, 0) mm") -> VectorClause:
    """Return a clause with a position."""
    return VectorClause(word, LENGTH, what="point", example=f"{word} {example}")


def direction(word: str, example: str = "(0, 0, 1)") -> DirectionClause:
    """Return a clause with a direction."""
    return DirectionClause(word, what="direction", example=f"{word} {example}", place="VECTOR")


#: Of what is held in one direction, and of what is held in all but one.
Along = Annotated[Floats | None, direction("along", "(0, 0, 1)")]
Across = Annotated[Floats | None, direction("across", "(1, 0, 0)")]


def factor(word: str, sign: Literal["positive", "not negative"]) -> NumberClause:
    """Return a clause with a number without a dimension."""
    return NumberClause(word, NUMBER, sign, what="factor", example=f"{word} 50 %")
