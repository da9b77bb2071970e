"""Fields that follow from the positions and velocities of frames, and are never recorded."""

from collections.abc import Mapping

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.results.fields import FrameField
from tissuec.script.measures.snapshot import Snapshot


class DisplacementField(FrameField):
    at = "node"
    dimension = units.LENGTH
    text = "way of each node from its position as drawn"
    width = 3

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        return snapshot.position - snapshot.state.network.position


class SpeedField(FrameField):
    at = "node"
    dimension = units.VELOCITY
    text = "velocity of each node"
    width = 3

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        return snapshot.velocity


#: By the names of their sizes.
OF_MOTION: Mapping[str, type[FrameField]] = {
    "displacement": DisplacementField,
    "speed": SpeedField,
}
