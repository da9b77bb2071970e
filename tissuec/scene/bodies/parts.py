"""Parts of a body with tissues of their own: regions, interfaces and chosen springs."""

from collections.abc import Mapping
from typing import Annotated

from tissuec.core import units
from tissuec.core.errors import Note
from tissuec.core.fields import Real
from tissuec.core.hints import Hint, leaving_out
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.model import (
    AssignedQuantity,
    Graded,
    Region,
    RegionInterface,
    SpringPart,
    Tissue,
)
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import Entry, by_name, entry, written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.graded import (
    GRADABLE,
    is_graded,
    read_graded,
    refuse_even,
    with_graded,
)
from tissuec.scene.reading.parts import block
from tissuec.scene.tissues.names import read_tissue, tissue_entry
from tissuec.scene.tissues.quantities import QUANTITIES, TOUGHNESS
from tissuec.scene.tissues.written_numbers import read_given
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    REGION,
    ChoiceClause,
    ConditionClause,
    NameClause,
    Placeholder,
)

INTERFACES = {
    "mean": "The arithmetic mean of each quantity of both sides.",
    "softer": "All quantities of the side with the smaller spring constant.",
    "stiffer": "All quantities of the side with the larger spring constant.",
}
#: A name that is new, of a region.
_NEW = Placeholder("NAME", new="region")


class RegionWords(VerbSentence, frozen=True):
    """A region and its nodes."""

    name: Annotated[s.Name, NameClause("", what="region", places=(_NEW,))]
    where: Annotated[
        s.Expression,
        ConditionClause(
            "where", what="condition of the region", place="CONDITION",
            example="where x > 10 mm",
        ),
    ]  # fmt: skip


class SpringsWords(VerbSentence, frozen=True):
    """Springs of a body."""

    where: Annotated[
        s.Expression,
        ConditionClause(
            "where", what="condition of the springs", place="CONDITION",
            example="where length > 3 mm",
        ),
    ]  # fmt: skip


Rule = Annotated[str, ChoiceClause("is", INTERFACES, what="choice", place="…")]
First = Annotated[s.Name, NameClause("from", what="first region", places=(REGION,))]
Second = Annotated[s.Name, NameClause("to", what="second region", places=(REGION,))]


class InterfaceWords(VerbSentence, frozen=True):
    """What all springs between two regions are made of."""

    rule: Rule


class BlendedWords(VerbSentence, frozen=True):
    """Springs between two regions that are made of the tissues of both."""

    rule: Rule
    first: First
    second: Second


class BetweenWords(VerbSentence, frozen=True):
    """What is between two regions: springs of a tissue, or faces with a toughness."""

    first: First
    second: Second


_PART = " { tissue is … }"
REGION_KIND = SentenceKind((RegionWords,), behind=_PART)
SPRINGS_KIND = SentenceKind(
    (SpringsWords,), wrong="springs with a separate tissue need one condition", behind=_PART
)
_PLAIN = SentenceKind((InterfaceWords,))
INTERFACE_KIND = SentenceKind(
    (BlendedWords, BetweenWords), wrong="a separate interface needs two regions"
)


def _read_plain(item: s.Assign | s.Sentence | s.Block, scope: Scope) -> str:
    said: InterfaceWords = SentenceReader("interface", _PLAIN, item, scope).get()
    return said.rule


def _inside(tissue: str, prestress: str) -> dict[str, Entry]:
    """What the block of a part of a body contains.

    Args:
        tissue, prestress: What these entries mean, in one sentence.
    """
    limits = QUANTITIES["prestress"].limits
    return by_name(tissue_entry(tissue), entry("prestress", limits, prestress))


REGION_ENTRY = written(
    "region", "a part of the body with its own tissue or prestress",
    *REGION_KIND.forms, repeats=True, begins=" ",
    opens=block(with_graded(_inside(
        "the tissue of the region; by default that of the body",
        "initial strain of the springs or elements of the region",
    ))),
)  # fmt: skip
SPRINGS_ENTRY = written(
    "springs", "springs with their own tissue", *SPRINGS_KIND.forms, repeats=True,
    opens=block(
        _inside("the tissue of the selected springs", "initial strain of these springs")
    ),
)  # fmt: skip
_TOUGHNESS = entry(
    TOUGHNESS, Real(units.STIFFNESS, above=0.0, example="5 J/m^2"),
    "energy per area at which two regions of solid elements come apart",
)  # fmt: skip
INTERFACE_ENTRY = written(
    "interface",
    "what joins two regions: the material of springs between them, or a toughness of their "
    "common faces",
    *_PLAIN.forms, *INTERFACE_KIND.forms, default="", reads=_read_plain, repeats=True,
    begins=" ",
    opens=block({
        **_inside(
            "the tissue of the springs between two regions", "initial strain of these springs"
        ),
        **by_name(_TOUGHNESS),
    }),
)  # fmt: skip


#: What an interface of springs can have.
_OF_SPRINGS = ("tissue", "prestress")


def _key(item: s.Item) -> str:
    """Return the key of the name of an entry; "" of what has none."""
    return item.name.key if isinstance(item, s.Assign | s.Sentence | s.Block) else ""


class PartReader:
    """Reads the parts of one body.

    Args:
        tissues: By name.
        declarations, scope: Of the scene.

    Attributes:
        regions, spring_parts, interfaces: As read so far.
    """

    def __init__(self, tissues: Mapping[str, Tissue], declarations: Declarations, scope: Scope):
        self._tissues, self._declarations, self._scope = tissues, declarations, scope
        self.findings = scope.findings
        self.regions: list[Region] = []
        self.spring_parts: list[SpringPart] = []
        self.interfaces: list[RegionInterface] = []

    def read_region(self, block: s.Block) -> None:
        """Read a region with its tissue."""
        said = SentenceReader("region", REGION_KIND, block, self._scope).get(RegionWords)
        name = said.name
        for other in self.regions:
            if s.key_of(other.name) == name.key:
                self.findings.reject(
                    "TIS503",
                    f'region "{name.text}" is defined twice',
                    name.span,
                    notes=(Note("first here", other.span),),
                )
        graded: list[Graded] = []
        made_of = self._made_of(block, "a region", graded)
        self.regions.append(Region(name.text, said.where, *made_of, said.span, tuple(graded)))

    def read_interface(self, item: s.Sentence | s.Block) -> None:
        """Read what joins two regions."""
        reader = SentenceReader("interface", INTERFACE_KIND, item, self._scope)
        if (item.phrase is None) != isinstance(item, s.Block):
            reader.reject_form()
        said = reader.get(BlendedWords if item.phrase is not None else BetweenWords)
        first, second, span = said.first, said.second, said.span
        for other in (*self.spring_parts, *self.interfaces):
            sides = {side.key for side in other.sides or ()}
            if sides == {first.key, second.key}:
                what = f"the interface from {first.text} to {second.text}"
                hint = "remove one of them"  # whose block is more than its place
                self.findings.refuse_second(what, span, other.span, hint=hint)
        name = f"springs from {first.text} to {second.text}"
        if isinstance(item, s.Block):
            if any(_key(one) == TOUGHNESS for one in item.items):
                self._read_toughness((first, second), item)
                return
            made_of = self._made_of(item, "an interface", more=f", {TOUGHNESS}")
            self.spring_parts.append(
                SpringPart(name, (first, second), None, "", *made_of, span)
            )
        else:
            self.spring_parts.append(
                SpringPart(name, (first, second), None, said.rule, None, None, span)
            )

    def _read_toughness(self, sides: tuple[s.Name, s.Name], block: s.Block) -> None:
        """Read the toughness of an interface, which has nothing else.

        Args:
            sides: The regions.
            block: Of the interface.
        """
        item, *more = (one for one in block.items if _key(one) == TOUGHNESS)
        if more:
            self.findings.refuse_second(f'"{TOUGHNESS}"', more[0].span, item.span)
        toughness = schema.read_entry(_TOUGHNESS, item, self._scope)
        for other in (one for one in block.items if one is not item):
            if (key := _key(other)) in _OF_SPRINGS:
                self.findings.reject(
                    "TIS306",
                    f"an interface of springs has a {key}, one of elements a toughness",
                    other.span,
                    hint=leaving_out("remove one of them", other.span, item.span),
                    notes=(Note("the toughness", item.span),),
                )
            message = "this is not allowed in an interface with a toughness"
            self.findings.reject("TIS303", message, other.span, hint="remove it")
        self.interfaces.append(RegionInterface(sides, toughness, block.head))

    def read_springs(self, item: s.Assign | s.Sentence | s.Block) -> None:
        """Read what chosen springs are made of."""
        reader = SentenceReader("springs", SPRINGS_KIND, item, self._scope)
        if not isinstance(item, s.Block):
            reader.reject_form()
        where = reader.get(SpringsWords).where
        made_of = self._made_of(item, "springs")
        self.spring_parts.append(
            SpringPart(f"springs where {where.span.text}", None, where, "", *made_of, item.head)
        )

    def require_interface(self, body: str, head: Span) -> bool:
        """Return whether something says what springs between regions are made of.

        Otherwise report it.

        Args:
            body: Its name.
            head: Of its block.
        """
        if any(part.sides for part in self.spring_parts):
            return True
        missing = [schema.missing(f"interface is {word}", head) for word in INTERFACES]
        self.findings.add(
            "TIS304",
            f'body {body} has regions, so it needs "interface"',
            head,
            hint=Hint(
                "write interface is mean, softer or stiffer, which sets "
                "the material of springs between two regions",
                *(edit for hint in missing for edit in hint.edits),
            ),
        )
        return False

    def _made_of(
        self, block: s.Block, what: str, graded: list[Graded] | None = None, more: str = ""
    ) -> tuple[Tissue | None, AssignedQuantity | None]:
        """Return the tissue and the prestress of a part of the body.

        Args:
            block: Of the part.
            what: The part in messages.
            graded: Takes quantities that depend on the place; None where there can be none.
            more: Of other entries, for hints.
        """
        tissue: Tissue | None = None
        prestress: AssignedQuantity | None = None
        for item in block.items:
            with self.findings.item():  # a part is there whatever it is made of
                if (
                    isinstance(item, s.Assign | s.Sentence | s.Block)
                    and item.name.key == "tissue"
                ):
                    tissue = read_tissue(item, self._tissues, self._declarations, self._scope)
                elif graded is not None and isinstance(item, s.Assign) and is_graded(item):
                    graded.append(read_graded(item, graded, self._scope))
                elif isinstance(item, s.Assign) and item.name.key == "prestress":
                    prestress = read_given("prestress", item, self._scope)
                elif (
                    graded is not None
                    and isinstance(item, s.Assign | s.Sentence | s.Block)
                    and item.name.key in GRADABLE
                ):
                    refuse_even(item, "region", self.findings)
                else:
                    hint = f"entries: tissue, prestress{more}" + (
                        "" if graded is None else "; quantities as formulas of x, y and z"
                    )
                    if not isinstance(item, s.Assign | s.Sentence | s.Block):
                        message = f"this is not allowed in {what}"
                        self.findings.reject("TIS303", message, item.span, hint=hint)
                    self.findings.refuse_entry(item.name, what, hint=hint)
        return tissue, prestress
