"""Parts of a body with tissues of their own: regions, interfaces and chosen springs."""

from collections.abc import Mapping
from typing import NoReturn

from tissuec.core.errors import Note
from tissuec.core.fields import OneOf
from tissuec.core.hints import Hint, alternatives
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.model import AssignedQuantity, Graded, Region, SpringPart, Tissue
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.reading import schema
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
from tissuec.scene.tissues.quantities import QUANTITIES
from tissuec.scene.tissues.written_numbers import read_given

INTERFACES = {
    "mean": "The arithmetic mean of each quantity of both sides.",
    "softer": "All quantities of the side with the smaller spring constant.",
    "stiffer": "All quantities of the side with the larger spring constant.",
}


def _inside(tissue: str, prestress: str) -> dict[str, Entry]:
    """What the block of a part of a body contains.

    Args:
        tissue, prestress: What these entries mean, in one sentence.
    """
    limits = QUANTITIES["prestress"].limits
    return by_name(tissue_entry(tissue), entry("prestress", limits, prestress))


REGION_ENTRY = written(
    "region", "a part of the body with its own tissue or prestress",
    "region NAME where CONDITION", repeats=True, begins=" ",
    opens=block(with_graded(_inside(
        "the tissue of the region; by default that of the body",
        "initial strain of the springs or elements of the region",
    ))),
)  # fmt: skip
SPRINGS_ENTRY = written(
    "springs", "springs with their own tissue", "springs where CONDITION", repeats=True,
    opens=block(
        _inside("the tissue of the selected springs", "initial strain of these springs")
    ),
)  # fmt: skip
INTERFACE_ENTRY = entry(
    "interface", OneOf(INTERFACES), "the material of springs between two regions", "",
    more=("interface is MEAN from REGION to REGION", "interface from REGION to REGION"),
    repeats=True, begins=" ",
    opens=block(_inside(
        "the tissue of the springs between two regions", "initial strain of these springs"
    )),
)  # fmt: skip


class PartReader:
    """Reads the parts of one body.

    Args:
        tissues: By name.
        declarations, scope: Of the scene.

    Attributes:
        regions, spring_parts: As read so far.
    """

    def __init__(self, tissues: Mapping[str, Tissue], declarations: Declarations, scope: Scope):
        self._tissues, self._declarations, self._scope = tissues, declarations, scope
        self.findings = scope.findings
        self.regions: list[Region] = []
        self.spring_parts: list[SpringPart] = []

    def read_region(self, name: s.Name, block: s.Block) -> None:
        """Read a region with its tissue."""
        if [clause.word for clause in block.clauses] != ["where"]:
            self.findings.reject(
                "TIS312",
                "a region needs one condition",
                block.head,
                hint=f"region {name.text} where z > 10 mm {{ tissue is … }}",
            )
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
        where = block.clauses[0].value
        self.regions.append(Region(name.text, where, *made_of, block.head, tuple(graded)))

    def read_interface(self, item: s.Sentence | s.Block) -> None:
        """Read what springs between two regions are made of."""
        span = item.head if isinstance(item, s.Block) else item.span
        names = [clause.value for clause in item.clauses]
        if (
            [clause.word for clause in item.clauses] != ["from", "to"]
            or not all(isinstance(name, s.Name) for name in names)
            or (item.phrase is None) != isinstance(item, s.Block)
        ):
            self._wrong_interface(span)
        first, second = (name for name in names if isinstance(name, s.Name))
        for other in self.spring_parts:
            sides = {side.key for side in other.sides or ()}
            if sides == {first.key, second.key}:
                what = f"the interface from {first.text} to {second.text}"
                hint = "remove one of them"  # whose block is more than its place
                self.findings.refuse_second(what, span, other.span, hint=hint)
        name = f"springs from {first.text} to {second.text}"
        if isinstance(item, s.Block):
            made_of = self._made_of(item, "an interface")
            self.spring_parts.append(
                SpringPart(name, (first, second), None, "", *made_of, span)
            )
            return
        assert item.phrase is not None
        word = item.phrase.words[0]
        if item.phrase.kind != "word" or word.key not in INTERFACES:
            self.findings.reject(
                "TIS305",
                f'interface cannot be "{word.text}"',
                item.phrase.span,
                hint=alternatives(word.key, INTERFACES, what="choices"),
            )
        self.spring_parts.append(
            SpringPart(name, (first, second), None, word.key, None, None, span)
        )

    def read_springs(self, item: s.Assign | s.Sentence | s.Block) -> None:
        """Read what chosen springs are made of."""
        is_block = isinstance(item, s.Block) and item.phrase is None
        if not is_block or [clause.word for clause in item.clauses] != ["where"]:
            self.findings.reject(
                "TIS312",
                "springs with a separate tissue need one condition",
                item.span,
                hint="write springs where length > 3 mm { tissue is … }",
            )
        assert isinstance(item, s.Block)
        made_of = self._made_of(item, "springs")
        where = item.clauses[0].value
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
        self, block: s.Block, what: str, graded: list[Graded] | None = None
    ) -> tuple[Tissue | None, AssignedQuantity | None]:
        """Return the tissue and the prestress of a part of the body.

        Args:
            block: Of the part.
            what: The part in messages.
            graded: Takes quantities that depend on the place; None where there can be none.
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
                    graded.append(read_graded(item, graded, self.findings))
                elif isinstance(item, s.Assign) and item.name.key == "prestress":
                    prestress = read_given("prestress", item, self._scope)
                elif (
                    graded is not None
                    and isinstance(item, s.Assign | s.Sentence | s.Block)
                    and item.name.key in GRADABLE
                ):
                    refuse_even(item, "region", self.findings)
                else:
                    self.findings.reject(
                        "TIS303",
                        f"this is not an entry of {what}",
                        item.span,
                        hint="entries: tissue, prestress"
                        + ("" if graded is None else "; quantities as formulas of x, y and z"),
                    )
        return tissue, prestress

    def _wrong_interface(self, span: Span) -> NoReturn:
        self.findings.reject(
            "TIS312",
            "a separate interface needs two regions",
            span,
            hint="write interface is softer from REGION to REGION, "
            "or interface from REGION to REGION { tissue is … }",
        )
