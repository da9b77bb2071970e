"""The block of a statement, from the heads around it."""

from collections.abc import Iterable

from tissuec.core.names import key_of
from tissuec.lang.tree import Statement
from tissuec.lsp.terms import BlockKind
from tissuec.scene.program.repetition import REPEAT
from tissuec.scene.reading.parts import entries_in, parts


def block_of(statement: Statement) -> BlockKind:
    """Return the block that contains a statement."""
    block = BlockKind()
    for head in statement.chain:
        block = inside(head, block)
    return block


def inside(head: Statement, outer: BlockKind) -> BlockKind:
    """Return the block that a head begins."""
    words = head.words
    first = words[0] if words else ""
    if first == REPEAT:
        return outer
    if outer.kind == "script":
        return BlockKind("script", "inner")
    if not outer.kind:
        part = parts("named", "single").get(first)
        if part is None:
            return BlockKind("unknown")
        chooser = part.block.chooser if part.block is not None else ""
        return BlockKind(first, _chosen(head.items, chooser) or " ".join(words[1:]))
    text = " ".join(words)
    for name, entry in entries_in(*outer).items():
        block = entry.inside
        if block is not None and f"{text} ".startswith(f"{name} "):
            by_word = bool(entry.members)
            member = _behind_is(head) if by_word else _chosen(head.items, block.chooser)
            return BlockKind(name, member)
    return BlockKind("unknown")


def _behind_is(statement: Statement) -> str:
    """Return the words after ``is``."""
    texts = [part.text for part in statement.parts]
    if "is" not in texts:
        return ""
    behind = statement.parts[texts.index("is") + 1 :]
    words: list[str] = []
    for part in behind:
        if not part.is_name:
            break
        words.append(part.text)
    return key_of(" ".join(words))


def _chosen(items: Iterable[Statement], entry: str) -> str:
    """Return the choice for an entry among the items of a block; empty if there is none."""
    return next((_behind_is(item) for item in items if entry in item.words[:1]), "")
