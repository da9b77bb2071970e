"""Blocks whose ``kind`` says which member of a family they describe: tools and forces."""

from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import Annotated, NoReturn

from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.forces.acting import FORCES
from tissuec.lang import syntax as s
from tissuec.scene.model import Tool, WrittenForce
from tissuec.scene.program.declarations import Declarations, Declared
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import SCENE, block_of, declare
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import SET, NameClause, Part
from tissuec.script.tools import KINDS_OF, TOOLS

declare(
    "tool", "An instrument that holds, touches or cuts.", 24,
    block=block_of(TOOLS, "the kind of instrument"),
    read=lambda program, declared: read_tool(program, declared), names=SCENE, entries_vary=True,
)  # fmt: skip


class ActsWords(VerbSentence, frozen=True):
    """What a force acts on."""

    target: Annotated[s.Name, NameClause("on", places=(SET,), joins=True)]


declare(
    "force", "An additional force on nodes, such as that of tissue around a body.", 25,
    block=block_of(
        FORCES, "the kind of force",
        written("acts", "The set or body that it acts on.", ActsWords),
    ),
    names=SCENE, entries_vary=True,
)  # fmt: skip
HOLDING = "forceps"  # the kind of tool that holds nodes, and so can move them


def read_tool(program: ResolvedProgram, declared: Declared) -> Tool:
    """Return a tool from its block; an erroneous one is still known by its name."""
    name, item, scope = declared.name, declared.item, program.constants
    assert isinstance(item, s.Block)
    what, kind, shapes, entries = f"tool {name.text}", "", (), None
    with scope.findings.item():
        kind, others = _kind(what, item, item.items, TOOLS, HOLDING, scope, usual=KINDS_OF)
        read, places = schema.build(TOOLS[kind], others, scope, what=what, where=item.head)
        try:
            shapes = read.shapes()
        except ValueError as error:
            reason = str(error)
            span = schema.blamed(reason, places, item.head)
            scope.findings.reject("TIS309", f"{what}: {reason}", span)
        entries = read
    return Tool(name.text, kind, shapes, entries, item.head)


def read_force(
    name: s.Name, item: s.Item, declarations: Declarations, scope: Scope
) -> WrittenForce:
    """Return a force from its block, or reject it if anything of it is wrong."""
    assert isinstance(item, s.Block)
    what = f"force {name.text}"
    known = (*declarations.of("set").values(), *declarations.of("body").values())
    example = f"acts on {next((one.name.text for one in known), 'SET')}"
    target, others = _target(what, item, example, scope)
    kind, others = _kind(what, item, others, FORCES, "foundation", scope)
    read, places = schema.build(FORCES[kind], others, scope, what=what, where=item.head)
    return WrittenForce(name.text, kind, target, read, places, item.head)


def _target(
    what: str, block: s.Block, example: str, scope: Scope
) -> tuple[s.Name, list[s.Item]]:
    """Return the set or body after ``acts on``, and the other items of a block."""
    near = (i for i in block.items if isinstance(i, s.Sentence))
    item = next((i for i in near if i.name.key.startswith("acts ")), None)
    if item is None:
        item, others = _single(what, "acts", example, block, block.items, scope, "acts on")
        return _ActsReader(item, example, scope).get(ActsWords).target, others
    _ActsReader(item, example, scope).reject_form()


class _ActsReader(SentenceReader):
    """Reads what a force acts on.

    Args:
        item: The entry.
        example: How it could be written.
        scope: Of the scene.
    """

    def __init__(self, item: s.Sentence | s.Assign, example: str, scope: Scope):
        wrong = '"acts" is followed by "on" and one set or body'
        super().__init__(
            "acts", SentenceKind((ActsWords,), examples=(example,), wrong=wrong), item, scope
        )

    def missing(self, part: Part, *, word: str | None = None) -> NoReturn:
        self.reject_form()

    def reject_form(self) -> NoReturn:
        hint = Hint(f"for example: {self.texts[0]}", *_with_on(self.sentence))
        self.scope.findings.reject("TIS312", self.kind.wrong, self.span, hint=hint)


def _with_on(item: object) -> list[Edit]:
    """Return the edit of "acts floor" or "acts = floor" that puts "on" between both."""
    match item:
        case s.Sentence(name=s.Name(quoted=None, words=words), phrase=None, clauses=()):
            return [Edit(f"acts on {words.partition(' ')[2]}")]
        case s.Assign(value=s.Name() as name, clauses=()):
            return [Edit(f"acts on {name.span.text}")]
        case _:
            return []


def _kind(
    what: str,
    block: s.Block,
    items: Sequence[s.Item],
    kinds: Collection[str],
    example: str,
    scope: Scope,
    *,
    usual: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> tuple[str, list[s.Item]]:
    """Return which member of a family a block describes, and its other items.

    Args:
        what: The block, in messages.
        items: Of the block, without those that have been read.
        kinds: Names of the members.
        example: One of them.
        scope: Of the scene.
        usual: Members by other names, which hints give.
    """
    example = f"kind is {example}"
    item, others = _single(what, "kind", example, block, items, scope)
    kind = schema.word_of(item, scope, example=example)
    if kind.key not in kinds:
        family = what.split()[0]
        scope.findings.reject(
            "TIS305",
            f'there is no {family} of the kind "{kind.text}"',
            kind.span,
            hint=alternatives(kind.key, kinds, what="kinds", meant=usual.get(kind.key, ())),
        )
    return kind.key, others


def _single(
    what: str,
    key: str,
    example: str,
    block: s.Block,
    items: Sequence[s.Item],
    scope: Scope,
    called: str = "",
) -> tuple[s.Sentence | s.Assign, list[s.Item]]:
    """Return the entry of a block with this name, and all other items.

    Args:
        what: The block, in messages.
        key: Name of the entry.
        example: How it could be written.
        items: Of the block, without those that have been read.
        scope: Of the scene.
        called: The entry, in messages, if not by its name.
    """
    written = [i for i in items if isinstance(i, s.Sentence | s.Assign) and i.name.key == key]
    if not written:
        scope.findings.reject(
            "TIS304", f'{what} needs "{called or key}"', block.head,
            hint=schema.missing(example, block.head),
        )  # fmt: skip
    for again in written[1:]:
        scope.findings.refuse_second(f'"{key}"', again.span, written[0].span)
    return written[0], [i for i in items if i is not written[0]]
