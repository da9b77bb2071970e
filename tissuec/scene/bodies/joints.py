"""Joints: springs between bodies, or nodes of one that are glued to another."""

from collections.abc import Callable
from itertools import pairwise
from math import inf
from typing import Annotated

from tissuec.core import units
from tissuec.core.fields import OneOf, Real
from tissuec.core.hints import Edit, Hint
from tissuec.lang import syntax as s
from tissuec.scene.bodies.entries import RUPTURE, SECTION
from tissuec.scene.model import Glue, Joint
from tissuec.scene.program.declarations import Declared
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import by_name, entry, written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import SCENE, block, declare
from tissuec.scene.tissues.names import reading_tissues, tissue_entry
from tissuec.scene.tissues.quantities import TOUGHNESS
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import SET, NameClause

PAIRS = ("nearest", "all")
EndsReader = Callable[[s.Assign | s.Sentence | s.Block, Scope], tuple[s.Name, s.Name]]
#: Entries of a joint that say nothing of glue.
OF_SPRINGS = ("springs", "tissue", "rupture", "pairs", "section")


class JoinedWords(VerbSentence, frozen=True):
    """The sets or bodies on either side of a joint."""

    first: Annotated[
        s.Name, NameClause("from", what="first set or body", places=(SET,), joins=True)
    ]
    second: Annotated[
        s.Name, NameClause("to", what="second set or body", places=(SET,), joins=True)
    ]


_GLUED = SentenceKind((JoinedWords,), wrong="glue leads from a set or body to another")
_JOINED = SentenceKind(
    (JoinedWords,), wrong="the springs of a joint connect two sets or bodies"
)


def _ends_of(first: str, kind: SentenceKind) -> EndsReader:
    """Return the reader of the names of the sets or bodies on either side."""

    def read(item: s.Assign | s.Sentence | s.Block, scope: Scope) -> tuple[s.Name, s.Name]:
        reader = SentenceReader(first, kind, item, scope)
        if isinstance(item, s.Block):
            reader.reject_form()
        _refuse_reserved_words(item, scope)
        said = reader.get(JoinedWords)
        return said.first, said.second

    return read


def _refuse_reserved_words(item: s.Assign | s.Sentence, scope: Scope) -> None:
    """Reject a name that contains a reserved word: ``from base of wall``."""
    for first, second in pairwise(item.clauses):
        if first.word in ("from", "to") and second.word not in ("from", "to"):
            name = first.value.span.to(second.span)
            hint = f'write a name with "{second.word}" in quotes: "{name.text}"'
            message = f'a name cannot contain the reserved word "{second.word}"'
            scope.findings.reject(
                "TIS115", message, name, hint=Hint(hint, Edit(f'"{name.text}"'))
            )


ENTRIES = by_name(
    written(
        "springs", "the sets or bodies that are joined", *_JOINED.forms,
        reads=_ends_of("springs", _JOINED),
    ),
    written(
        "glue", "the set or body whose nodes follow, and that which they are glued to",
        *_GLUED.forms, reads=_ends_of("glue", _GLUED),
    ),
    tissue_entry("the tissue of the springs"),
    RUPTURE,
    entry(
        "reach", Real(units.LENGTH, above=0.0), "maximum distance of what is joined as drawn"
    ),
    entry(
        "pairs", OneOf(PAIRS),
        "which nodes are joined: each to the nearest one, or all within reach", PAIRS[0],
    ),
    SECTION,
    entry(
        TOUGHNESS, Real(units.STIFFNESS, above=0.0, example="5 J/m^2"),
        "energy per area at which glued faces come apart",
    ),
)  # fmt: skip
declare(
    "joint", "Springs or glue that join bodies.", 23,
    block=block(ENTRIES), read=lambda program, declared: read_joint(program, declared),
    names=SCENE, entries_vary=True,
)  # fmt: skip


def read_joint(program: ResolvedProgram, declared: Declared) -> Joint | Glue:
    """Return a joint from its block, or reject it if anything of it is wrong."""
    name, item, scope = declared.name, declared.item, program.constants
    assert isinstance(item, s.Block)
    findings = scope.findings
    entries = reading_tissues(ENTRIES, program.tissues, program.declarations)
    with findings.together():  # what is missing may be what was misspelt
        found, places = schema.read(entries, item.items, scope, what="a joint")
    if "glue" in found:
        for key in filter(found.__contains__, OF_SPRINGS):
            message = f'glue has no "{key}": it is as firm as what it joins'
            findings.reject("TIS304", message, places[key], hint=f'remove "{key}"')
        of_glue = found.get("reach"), found.get(TOUGHNESS)
        return Glue(name.text, found["glue"], *of_glue, item.head)
    if TOUGHNESS in found:
        findings.reject(
            "TIS304",
            "only glue has a toughness: springs break by their forces",
            places[TOUGHNESS],
            hint="write glue in place of springs, or a breaking force in the tissue",
        )
    example = f"tissue is {next(iter(program.tissues), 'silk')}"
    hints = {
        "springs": f"for example: {ENTRIES['springs'].example} or: glue from FACE to BODY",
        "tissue": schema.missing(example, item.head),
    }
    with findings.together():
        for key, hint in hints.items():
            if key not in found:
                message = f'joint {name.text} needs "{key}"'
                findings.add("TIS304", message, item.head, hint=hint)
    joins_all = found.get("pairs") == "all"
    if joins_all and "reach" not in found:
        findings.reject(
            "TIS304",
            "all pairs of nodes would be joined at any distance",
            places["pairs"],
            hint="limit the distance, for example: reach = 8 mm",
        )
    return Joint(
        name=name.text,
        ends=found["springs"],
        reach=found.get("reach", inf),
        joins_all=joins_all,
        tissue=found["tissue"],
        section=found.get("section"),
        rupture=found.get("rupture", ""),
        span=item.head,
    )
