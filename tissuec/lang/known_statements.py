"""Statements that were parsed before, for texts that change little by little.

A key stroke changes one statement of a long text, and moves those after it. To move the nodes
of a statement takes a fifth of the time that it takes to parse it.
"""

from collections.abc import Hashable, Sequence
from typing import Any, cast

from msgspec.structs import astuple

from tissuec.core.keeping import Memory
from tissuec.core.source import Source, Span
from tissuec.lang.syntax import Node
from tissuec.lang.tokens import Token

MOST_STATEMENTS = 50_000  # that are remembered


def key_of_tokens(tokens: Sequence[Token]) -> Hashable:
    """Return a key that equal tokens have at any place of a text."""
    first = tokens[0].start if tokens else 0
    return tuple([(one.type, one.text, one.start - first) for one in tokens])


class KnownStatements:
    """The nodes of right statements, by their tokens; not for several threads at once."""

    def __init__(self) -> None:
        self._nodes = Memory(MOST_STATEMENTS)

    def recall(self, key: Hashable, tokens: Sequence[Token], source: Source) -> Any:
        """Return the node of a statement at its place in a text; None if it is not known.

        Args:
            key: The rule of the grammar, and the key of the tokens.
            tokens: Of the statement.
        """
        found = self._nodes.get(key)
        if found is None:
            return None
        start, node = found
        return _moved(node, source, tokens[0].start - start)

    def keep(self, key: Hashable, tokens: Sequence[Token], node: Any) -> None:
        """Remember the node of a statement.

        Args:
            key: The rule of the grammar, and the key of the tokens.
            tokens: Of the statement.
            node: What was made of it, without a problem.
        """
        if tokens:
            self._nodes.keep(key, (tokens[0].start, node))


def _moved(value: Any, source: Source, by: int) -> Any:
    """Return a node, or a part of one, at another place."""
    kind = cast("type[Any]", type(value))
    if kind is Span:
        return Span(source, value.start + by, value.end + by)
    if kind is tuple:
        return tuple([_moved(one, source, by) for one in value])
    if isinstance(value, Node):
        return kind(*[_moved(one, source, by) for one in astuple(value)])
    return value
