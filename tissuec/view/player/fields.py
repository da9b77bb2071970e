"""The fields that colour the skin: those of frames, and those that are derived, one entry each.

What computes them is imported when it is needed.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from msgspec import Struct

from tissuec.results.fields import FIELDS, FieldChannel

if TYPE_CHECKING:
    from tissuec.model.network import Floats
    from tissuec.results.trajectory import Trajectory
    from tissuec.view.player.drawn_nodes import DrawnNodes

#: What colours the skin if no field does.
TISSUE = "tissue"
#: What pages compute from the arrows that they draw.
FORCE = "force"


class NodeField(Struct, frozen=True):
    """A number at each node and moment.

    Attributes:
        name: As ``tissuec view --field`` takes it.
        unit: SI unit; "" without one.
        text: What it is.
        value: From the nodes of a film to numbers in the unit, shape (row, node), which are NaN
            where they are unknown; None without any.
        signed: Whether numbers below 0 have a colour of their own.
        derived: Whether pages compute it from other arrays; see ``web/fields.js``.
        titled: What legends call it; its name if empty.
    """

    name: str
    unit: str
    text: str
    value: "Callable[[DrawnNodes], Floats | None]"
    signed: bool = False
    derived: bool = False
    titled: str = ""

    @property
    def title(self) -> str:
        """Return the name in legends."""
        return self.titled or self.name


#: Those that follow from the motion, and are not recorded.
DERIVED: tuple[NodeField, ...] = (
    NodeField(
        "displacement", "m", "distance from the position before the run",
        lambda nodes: nodes.displacement, derived=True,
    ),
    NodeField("speed", "m/s", "magnitude of the velocity", lambda nodes: nodes.speed),
    NodeField(
        "strain", "", "largest principal strain (Green-Lagrange) around a node",
        lambda nodes: nodes.strain, signed=True, titled="largest principal strain",
    ),
    NodeField(
        "stress", "Pa", "equivalent stress of von Mises, of bodies that have a volume",
        lambda nodes: nodes.stress, titled="von Mises stress",
    ),
)  # fmt: skip


def recorded(channel: FieldChannel) -> NodeField:
    """Return a field of frames as one number at each node."""
    return NodeField(
        channel.name, channel.unit, channel.at_nodes,
        lambda nodes: nodes.recorded(channel.name),
        signed=channel.signed and channel.width == 1,
        derived=channel.name == FORCE,
    )  # fmt: skip


def fields_of(trajectory: "Trajectory") -> tuple[NodeField, ...]:
    """Return all fields that a result may have."""
    return (*DERIVED, *map(recorded, trajectory.channels))


def known_fields() -> dict[str, NodeField]:
    """Return the fields that some result may have, by name."""
    known = (*DERIVED, *(recorded(FieldChannel.of(name)) for name in FIELDS))
    return {field.name: field for field in known}
