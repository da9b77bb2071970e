"""The fields that colour the skin: each is one entry here.

What computes them is imported when it is needed.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from msgspec import Struct

if TYPE_CHECKING:
    from tissuec.model.network import Floats
    from tissuec.view.player.drawn_nodes import DrawnNodes

#: What colours the skin if no field does.
TISSUE = "tissue"


class NodeField(Struct, frozen=True):
    """A number at each node and moment.

    Attributes:
        name: As ``tissuec view --field`` takes it.
        unit: SI unit; "" without one.
        text: What it is.
        value: From the nodes of a film to numbers in the unit, shape (row, node), which are NaN
            where they are unknown; None without any.
        derived: Whether pages compute it from other arrays; see ``web/fields.js``.
    """

    name: str
    unit: str
    text: str
    value: "Callable[[DrawnNodes], Floats | None]"
    derived: bool = False


FIELDS: tuple[NodeField, ...] = (
    NodeField(
        "displacement", "m", "distance from the position before the run",
        lambda nodes: nodes.displacement, derived=True,
    ),
    NodeField("speed", "m/s", "magnitude of the velocity", lambda nodes: nodes.speed),
    NodeField(
        "strain", "", "largest principal strain (Green-Lagrange) of the springs at a node",
        lambda nodes: nodes.strain,
    ),
    NodeField("tension", "N", "mean tension of the springs at a node",
              lambda nodes: nodes.tension),
    NodeField(
        "stress", "Pa", "equivalent stress of von Mises, of bodies that have a volume",
        lambda nodes: nodes.stress,
    ),
    NodeField(
        "force", "N", "magnitude of the sum of the spring forces on a node",
        lambda nodes: nodes.force, derived=True,
    ),
)  # fmt: skip
NAMES = (TISSUE, *(field.name for field in FIELDS))
