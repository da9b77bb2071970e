"""Elements and faces that tears have parted."""

from typing import NamedTuple

from tissuec.model.network import Indices


class Torn(NamedTuple):
    """What tore in a body at one time.

    Attributes:
        elements: As drawn, entities, with faces that are free from now on, shape (n,).
        edges: Edges that no element has any longer, shape (m,).
        area: Of faces that were tied before, as drawn [m²].
        energy: Taken by these faces [J].
    """

    elements: Indices
    edges: Indices
    area: float = 0.0
    energy: float = 0.0
