"""Pressures: in the cells of preserved volumes, and of contact on faces."""

import numpy as np

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


@FIELDS.member("contact pressure")
class ContactPressureField(FrameField):
    at = "node"
    dimension = units.PRESSURE
    text = "pressure of contact on the faces around each node"
    remark = (
        "It is 0 where contact acts on nodes, and without contact. Normal forces of the faces "
        "around a node are divided by their present areas. Faces with four nodes are divided "
        "into triangles: at a corner of a body, the pressure can be wrong by a half."
    )
    needs = ("faces",)

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        contact = snapshot.state.touching
        if contact is None:
            return np.zeros(snapshot.position.shape[:-1])
        from tissuec.forces.contact.readings import pressures  # where something touches

        return pressures(contact, snapshot.position)
