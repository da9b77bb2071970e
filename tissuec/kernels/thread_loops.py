"""Loops that a team of threads shares; see ``engine.threads``.

What a thread does to a node or spring depends on nothing that another one does at the same
time, and what is summed up is summed in pieces of a fixed size, one after the other. So results
are the same to the last bit for any number of threads.
"""

from collections.abc import Callable
from typing import Any

from tissuec.kernels.records import Team

PIECE = 512  # nodes that are not divided
UNDIVIDED = -1  # ``part`` of a table whose kernel does all at once


def share(team: Team, function: Callable[..., None], arguments: tuple[Any, ...]) -> None:
    """Call ``function(part, parts, *arguments)`` for every part, each in a thread of the team.

    Compiled code replaces this function: ``compiled.team``.

    Args:
        function: A loop over a part.
        arguments: Its other arguments.
    """
    function(0, 1, *arguments)


def part_of(part: int, parts: int, nodes: int) -> tuple[int, int]:
    """Return the first node of a part, and the first one after it.

    Args:
        nodes: Number of nodes.
    """
    first, last = items_of(part, parts, pieces_of(nodes))
    return first * PIECE, min(last * PIECE, nodes)


def items_of(part: int, parts: int, count: int) -> tuple[int, int]:
    """Return the first item of a part, and the first one after it.

    Items of a part are neighbours, so that the same nodes belong to it in all loops.

    Args:
        count: Number of items: groups, chunks or pieces of successive nodes, for example.
    """
    return part * count // parts, (part + 1) * count // parts


def pieces_of(nodes: int) -> int:
    """Return into how many pieces nodes are divided."""
    return (nodes + PIECE - 1) // PIECE
