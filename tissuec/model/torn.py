"""Elements and faces that tears have parted."""

from typing import NamedTuple

import numpy as np

from tissuec.core.source import Span
from tissuec.model.network import Indices


class Peeled(NamedTuple):
    """What became free of an interface or of glue at one time.

    Attributes:
        name: Such as "the interface from wall to pad".
        span: Where it is written.
        elements: As drawn, on one side of it, entities, shape (n,).
        area: As drawn [m²].
        energy: Taken by it [J].
    """

    name: str
    span: Span
    elements: Indices
    area: float
    energy: float


class Torn(NamedTuple):
    """What tore in a body at one time.

    Attributes:
        elements: As drawn, entities, with faces of tears that are free from now on, shape
            (n,).
        edges: Edges that no element has any longer, shape (m,).
        area: Of faces of tears that were tied before, as drawn [m²].
        energy: Taken by these faces [J].
        peeled: Interfaces that became free.
    """

    elements: Indices
    edges: Indices
    area: float = 0.0
    energy: float = 0.0
    peeled: tuple[Peeled, ...] = ()

    @property
    def every_element(self) -> Indices:
        """Return the elements of tears and of interfaces, ascending, shape (n,)."""
        every = [self.elements, *(each.elements for each in self.peeled)]
        return np.unique(np.concatenate(every))
