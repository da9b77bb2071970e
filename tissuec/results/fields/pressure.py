"""Pressures in the cells of preserved volumes."""

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.results.fields import FIELDS, FrameField, over_cells
from tissuec.script.measures.snapshot import Snapshot


@FIELDS.member("pressure")
class PressureField(FrameField):
    at = "cell"
    dimension = units.PRESSURE
    text = "pressure of each cell of a preserved volume"
    signed = True
    remark = (
        "It is 0 before the volume is preserved and after the cell is torn. A stretched cell "
        "has a negative one."
    )

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        return over_cells(
            snapshot, lambda cells: cells.pressures(snapshot.time, snapshot.position)
        )
