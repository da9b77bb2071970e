"""Tensions of springs."""

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.results.fields import FIELDS, FrameField
from tissuec.script.measures.snapshot import Snapshot


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
