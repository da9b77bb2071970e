"""Nodes and elements in reserve for cuts.

Where a blade divides an element, each part becomes an element with all the nodes of the whole:
those on its own side of the blade are nodes of the body, the others copies of these, *phantom
nodes* (A. Hansbo, P. Hansbo, Comput. Methods Appl. Mech. Eng. 193:3523, 2004; J.-H. Song, P. M.
A. Areias, T. Belytschko, Int. J. Numer. Methods Eng. 67:868, 2006). A body that the script cuts
has them from the start, so that numbers never change. Until a cut uses a phantom node, it is
embedded in the node that it is a copy of, its parent.
"""

from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray


class Reserve(NamedTuple):
    """Numbers of what a body has in reserve for cuts.

    Attributes:
        nodes: Phantom nodes, behind its nodes as drawn.
        elements: Entities for parts of elements, behind its elements as drawn.
        cuts: How many sentences cut it.
    """

    nodes: int
    elements: int
    cuts: int


NO_RESERVE = Reserve(0, 0, 0)


class Phantoms(Struct, frozen=True, eq=False):
    """What is in reserve for the cuts of one body.

    Attributes:
        body: Its name.
        nodes: Phantom nodes, the last ones of the body.
        parents: The node that each is a copy of, shape (phantom,).
        elements: Entities for parts of elements, the last ones of the body.
        cuts: How many sentences cut the body.
        rows: Rows of internal variables for more parts than there are elements.
    """

    body: str
    nodes: slice
    parents: NDArray[np.int64]
    elements: slice
    cuts: int = 0
    rows: slice = slice(0, 0)
