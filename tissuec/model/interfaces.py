"""Faces between two regions of a solid that can come apart."""

from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.source import Span


class Interface(Struct, frozen=True, eq=False):
    """The faces between the elements of two regions.

    Attributes:
        name: In words, such as "from wall to pad".
        sides: 1 of elements of the region in front, -1 of the one behind, 0 of others, shape
            (element,), shape by shape.
        toughness: Energy per area as drawn that it takes to part them [J/m²].
        span: Where it is written.
    """

    name: str
    sides: NDArray[np.int8]
    toughness: float
    span: Span


class Parting(NamedTuple):
    """What it takes to part the interfaces of a body.

    Attributes:
        copies: Of a node, at most.
        elements: That get other nodes, each as often as it does.
    """

    copies: int
    elements: int


NO_PARTING = Parting(0, 0)
