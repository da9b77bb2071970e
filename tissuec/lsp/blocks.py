"""The block of a statement, from the heads around it."""

from collections.abc import Iterable

from tissuec.core.names import key_of
from tissuec.lang.tree import Statement
from tissuec.lsp.terms import BlockKind
from tissuec.scene.declarations import NAMED, SINGLE


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
    match outer.kind, first:
        case "", _ if first in (*NAMED, *SINGLE):
            has_kind = first in ("tool", "force")
            member = _chosen(head.items, "kind") if has_kind else " ".join(words[1:])
            return BlockKind(first, member)
        case "body", "mesh":
            return BlockKind("mesh", _behind_is(head))
        case "body", "region":
            return BlockKind("region", words[1] if words[1:] else "")
        case "body", ("interface" | "springs"):
            return BlockKind(first)
        case (("tissue" | "law"), ("spring" | "viscosity" | "solid")):
            return BlockKind(" ".join(words[:2]), _behind_is(head))
        case "simulate", "integrator":
            return BlockKind("integrator", _behind_is(head))
        case "output", "surface":
            return BlockKind("surface", _chosen(head.items, "kind"))
        case "learn", "data":
            return BlockKind("data")
        case "script", _:
            return BlockKind("script", "inner")
        case _:
            return BlockKind("unknown")


def _behind_is(statement: Statement) -> str:
    """Return the words behind ``is``."""
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
    """Return what is chosen for an entry among the items of a block."""
    return next((_behind_is(item) for item in items if item.words[:1] == [entry]), "")
