"""Joints: springs between bodies, by which they hang on one another or are sewn together."""

from itertools import pairwise
from math import inf
from typing import Any, NoReturn

from tissuec.core import units
from tissuec.core.fields import OneOf, Real
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene import schema
from tissuec.scene.body_entries import RUPTURE, SECTION
from tissuec.scene.declarations import Declared
from tissuec.scene.entries import by_name, entry, written
from tissuec.scene.entry_hints import unknown_entry
from tissuec.scene.model import Joint
from tissuec.scene.parts import SCENE, block, declare
from tissuec.scene.resolved import ResolvedProgram
from tissuec.scene.tissue_names import read_tissue, tissue_entry

PAIRS = ("nearest", "all")
_FORM = "springs from SET to SET"
ENTRIES = by_name(
    written("springs", "the sets or bodies that are joined", _FORM),
    tissue_entry("the tissue of the springs"),
    RUPTURE,
    entry(
        "reach", Real(units.LENGTH, above=0.0), "maximum distance of joined nodes as drawn"
    ),
    entry(
        "pairs", OneOf(PAIRS),
        "which nodes are joined: each to the nearest one, or all within reach", PAIRS[0],
    ),
    SECTION,
)  # fmt: skip
declare(
    "joint", "Springs that join bodies.", 23,
    block=block(ENTRIES), read=lambda program, declared: _JointReader(program, declared).read(),
    names=SCENE, entries_vary=True,
)  # fmt: skip


class _JointReader:
    """One reading of one joint block."""

    def __init__(self, program: ResolvedProgram, declared: Declared):
        assert isinstance(declared.item, s.Block)
        self.name, self.block = declared.name, declared.item
        self.tissues, self.declarations = program.tissues, program.declarations
        self.scope, self.findings = program.constants, program.constants.findings
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
            case _:
                self.found[key] = schema.read_entry(ENTRIES[key], item, self.scope)

    def _ends(self, item: s.Assign | s.Sentence | s.Block) -> tuple[s.Name, s.Name]:
        """Return the names of the sets or bodies on either side."""
        if not isinstance(item, s.Sentence) or item.phrase is not None:
            self._wrong_ends(item)
        if [clause.word for clause in item.clauses] != ["from", "to"]:
            self._wrong_ends(item)
        first, second = (s.as_name(clause.value) for clause in item.clauses)
        if first is None or second is None:
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
