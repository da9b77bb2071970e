"""Forces on nodes."""

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.results.fields import FIELDS, FrameField
from tissuec.script.measures.snapshot import Snapshot


@FIELDS.member("force")
class ForceField(FrameField):
    at = "node"
    dimension = units.FORCE
    text = "sum of the spring forces on each node"
    width = 3
    always = True

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        return snapshot.node_force
