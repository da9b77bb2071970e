"""Fields at nodes and at springs."""

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.results.fields import FIELDS, FrameField
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.stresses import plastic_strains


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


@FIELDS.member("modulus")
class ModulusField(FrameField):
    at = "node"
    dimension = units.PRESSURE
    text = "mean Young's modulus at rest of the elements around each node"
    remark = "The mean is by volume, without fibres, and 0 where there is no element."
    needs = ("elements",)

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        shape = snapshot.velocity.shape[:-1]
        total, volume = np.zeros(shape[-1]), np.zeros(shape[-1])
        for field in snapshot.state.elements:
            for _, own in field.intact(snapshot.state.alive).in_blocks():
                share = own.node_volumes
                np.add.at(total, own.nodes, own.young[:, None] * share)
                np.add.at(volume, own.nodes, share)
        return np.broadcast_to(total / np.where(volume > 0.0, volume, 1.0), shape)


@FIELDS.member("plastic strain")
class PlasticStrainField(FrameField):
    at = "node"
    dimension = units.NUMBER
    text = "plastic strain of the elements around each node"
    remark = "It is that of the measure of this name, and 0 where nothing yields."
    needs = ("elements",)

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        return plastic_strains(snapshot)


@FIELDS.member("spring constant")
class SpringConstantField(FrameField):
    at = "spring"
    dimension = units.STIFFNESS
    text = "spring constant of each spring at rest"
    remark = "It is 0 for the edges of elements, and without branches that relax."
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

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        return snapshot.tension
