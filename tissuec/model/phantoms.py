"""Nodes and elements in reserve for cuts.

Where a blade divides an element, each part becomes an element with all the nodes of the whole:
those on its own side of the blade are nodes of the body, the others copies of these, *phantom
nodes* (A. Hansbo, P. Hansbo, Comput. Methods Appl. Mech. Eng. 193:3523, 2004; J.-H. Song, P. M.
A. Areias, T. Belytschko, Int. J. Numer. Methods Eng. 67:868, 2006). A body that the script cuts
has them from the start, so that numbers never change. Until a cut uses a phantom node, it is
embedded in the node that it is a copy of, its parent.

Behind them are *riders*: nodes without mass that cuts embed in nodes of parts, so that they
ride at corners of triangles on surfaces of parts (``model.cut_cells``), where forces can act.
"""

from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray


class NotDivisible(Exception):
    """A body cannot be divided further, with the reason as a sentence."""


class Reserve(NamedTuple):
    """Numbers of what a body has in reserve for cuts.

    Attributes:
        nodes: Phantom nodes and riders, behind its nodes as drawn.
        elements: Entities for parts of elements, behind its elements as drawn.
        cuts: How many sentences cut it.
        riders: How many of the nodes, the last ones, are riders.
    """

    nodes: int
    elements: int
    cuts: int
    riders: int = 0


NO_RESERVE = Reserve(0, 0, 0)


class Phantoms(Struct, frozen=True, eq=False):
    """What is in reserve for the cuts of one body.

    Attributes:
        body: Its name.
        nodes: Phantom nodes.
        parents: The node that each is a copy of, shape (phantom,).
        elements: Entities for parts of elements, the last ones of the body.
        cuts: How many sentences cut the body.
        rows: Rows of internal variables for more parts than there are elements.
        riders: The last nodes of the body.
    """

    body: str
    nodes: slice
    parents: NDArray[np.int64]
    elements: slice
    cuts: int = 0
    rows: slice = slice(0, 0)
    riders: slice = slice(0, 0)

    @property
    def reserved(self) -> NDArray[np.int64]:
        """Return all nodes in reserve, phantom nodes and riders, shape (node,)."""
        parts = (self.nodes, self.riders)
        return np.concatenate([np.arange(int(each.start), int(each.stop)) for each in parts])
