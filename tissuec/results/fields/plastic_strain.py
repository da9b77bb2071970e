"""Permanent strain at nodes of elements that yield."""

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.results.fields import FIELDS, FrameField
from tissuec.script.measures.plastic_strain import plastic_strains
from tissuec.script.measures.snapshot import Snapshot


@FIELDS.member("plastic strain")
class PlasticStrainField(FrameField):
    at = "node"
    dimension = units.NUMBER
    text = "plastic strain of the elements around each node"
    remark = "It is that of the measure of this name, and 0 where nothing yields."

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        return plastic_strains(snapshot)
