"""Fields at nodes and at springs."""

import numpy as np

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


@FIELDS.member("spring constant")
class SpringConstantField(FrameField):
    at = "spring"
    dimension = units.STIFFNESS
    text = "spring constant of each spring at rest"
    remark = "It is without branches that relax."
    needs = ("springs",)

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        stiffness = snapshot.state.network.springs.stiffness
        return np.broadcast_to(stiffness, (*np.shape(snapshot.time), len(stiffness)))


@FIELDS.member("tension")
class TensionField(FrameField):
    at = "spring"
    dimension = units.FORCE
    text = "tension of each spring"
    signed = True
    always = True
    stored = "spring_force"
    remark = "A compressed spring has a negative one."
    needs = ("springs",)

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        return snapshot.tension
