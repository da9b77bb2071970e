"""What a tear has parted."""

from typing import NamedTuple

from tissuec.model.network import Indices


class Torn(NamedTuple):
    """What has torn of a body.

    Attributes:
        elements: As drawn, entities, through which faces are free from now on, shape (n,).
        edges: Of elements that they were the last to have, shape (m,).
        area: Of faces that were tied before, as drawn [m²].
        energy: That they have taken [J].
    """

    elements: Indices
    edges: Indices
    area: float = 0.0
    energy: float = 0.0
