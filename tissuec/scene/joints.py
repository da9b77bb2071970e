"""Joints: springs between bodies, by which they hang on one another or are sewn together."""

from collections.abc import Mapping
from itertools import pairwise
from math import inf
from typing import Any, NoReturn

from tissuec.core import units
from tissuec.core.fields import OneOf, Real
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene import schema
from tissuec.scene.body_entries import SECTION, read_rupture
from tissuec.scene.declarations import Declarations
from tissuec.scene.entry_meanings import unknown_entry
from tissuec.scene.expressions import Scope
from tissuec.scene.model import Joint, Tissue
from tissuec.scene.tissue_names import read_tissue

PAIRS = ("nearest", "all")
#: Entries of a joint beside springs, tissue and rupture.
JOINT_ENTRIES: dict[str, schema.Entry] = {
    "reach": schema.Entry(
        "reach",
        "reach",
        Real(units.LENGTH, above=0.0),
        None,
        "maximum distance of joined nodes as drawn",
    ),
    "pairs": schema.Entry(
        "pairs",
        "pairs",
        OneOf(PAIRS),
        PAIRS[0],
        "which nodes are joined: each to the nearest one, or all within reach",
    ),
    "section": SECTION,
}
ENTRIES = ("springs", "tissue", "rupture", *JOINT_ENTRIES)
_FORM = "springs from SET to SET"


def read_joint(
    name: s.Name,
    item: s.Item,
    tissues: Mapping[str, Tissue],
    declarations: Declarations,
    scope: Scope,
) -> Joint:
    """Return a joint from its block, or reject it if anything of it is wrong."""
    assert isinstance(item, s.Block)
    return _JointReader(name, item, tissues, declarations, scope).read()


class _JointReader:
    """One reading of one joint block."""

    def __init__(
        self,
        name: s.Name,
        block: s.Block,
        tissues: Mapping[str, Tissue],
        declarations: Declarations,
        scope: Scope,
    ):
        self.name, self.block = name, block
        self.tissues, self.declarations = tissues, declarations
        self.scope, self.findings = scope, scope.findings
        self.found: dict[str, Any] = {}
        self.places: dict[str, Span] = {}

    def read(self) -> Joint:
        with self.findings.together():  # what is missing may be what was misspelt
            for item in self.block.items:
                with self.findings.item():
                    self._item(item)
        with self.findings.together():
            for key, example in (
                ("springs", _FORM),
                ("tissue", f"tissue is {next(iter(self.tissues), 'silk')}"),
            ):
                if key not in self.found:
                    self.findings.add(
                        "TIS304",
                        f'joint {self.name.text} needs "{key}"',
                        self.block.head,
                        hint=(
                            f"for example: {example}"
                            if key == "springs"
                            else schema.missing(example, self.block.head)
                        ),
                    )
        joins_all = self.found.get("pairs") == "all"
        if joins_all and "reach" not in self.found:
            self.findings.reject(
                "TIS304",
                "all pairs of nodes would be joined at any distance",
                self.places["pairs"],
                hint="limit the distance, for example: reach = 8 mm",
            )
        return Joint(
            name=self.name.text,
            ends=self.found["springs"],
            reach=self.found.get("reach", inf),
            joins_all=joins_all,
            tissue=self.found["tissue"],
            section=self.found.get("section"),
            rupture=self.found.get("rupture", ""),
            span=self.block.head,
        )

    def _item(self, item: s.Item) -> None:
        if not isinstance(item, s.Assign | s.Sentence | s.Block):
            self.findings.reject("TIS303", "this is not allowed in a joint", item.span)
        key = item.name.key
        if key not in ENTRIES:
            self.findings.reject(
                "TIS303",
                f'"{item.name.text}" is not an entry of a joint',
                item.name.span,
                hint=unknown_entry(item, ENTRIES),
            )
        if key in self.places:
            self.findings.refuse_second(f'"{key}"', item.span, self.places[key])
        self.places[key] = item.span
        match key:
            case "springs":
                self.found[key] = self._ends(item)
            case "tissue":
                self.found[key] = read_tissue(item, self.tissues, self.declarations, self.scope)
            case "rupture":
                self.found[key] = read_rupture(item, self.findings)
            case _:
                self.found[key] = schema.read_entry(JOINT_ENTRIES[key], item, self.scope)

    def _ends(self, item: s.Assign | s.Sentence | s.Block) -> tuple[s.Name, s.Name]:
        """Return the names of the sets or bodies on either side."""
        if not isinstance(item, s.Sentence) or item.phrase is not None:
            self._wrong_ends(item)
        if [clause.word for clause in item.clauses] != ["from", "to"]:
            self._wrong_ends(item)
        first, second = (clause.value for clause in item.clauses)
        if not isinstance(first, s.Name) or not isinstance(second, s.Name):
            self._wrong_ends(item)
        return first, second

    def _wrong_ends(self, item: s.Item) -> NoReturn:
        clauses = item.clauses if isinstance(item, s.Sentence) else ()
        for first, second in pairwise(clauses):
            if first.word in ("from", "to") and second.word not in ("from", "to"):
                name = first.value.span.to(second.span)
                hint = f'write a name with "{second.word}" in quotes: "{name.text}"'
                message = f'a name cannot contain the reserved word "{second.word}"'
                self.findings.reject(
                    "TIS115", message, name, hint=Hint(hint, Edit(f'"{name.text}"'))
                )
        self.findings.reject(
            "TIS312",
            "the springs of a joint connect two sets or bodies",
            item.span,
            hint=f"write {_FORM}",
        )
