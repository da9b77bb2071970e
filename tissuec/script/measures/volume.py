"""Volume inside a closed surface."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.enclosed import surface_of
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("volume")
class Volume(ScalarMeasure):
    """The present volume inside the closed surface of the body A; 0 if it is open.

    For a lattice, it is the sum of all cells, whether they preserve their volume or not.
    """

    form = "volume(A)"
    dimension = units.VOLUME
    subjects = 1
    takes = "body"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        enclosure = surface_of(snapshot.state.network, subjects[0].name)
        if enclosure is None:
            return one_column(0.0, snapshot)
        return one_column(enclosure.volumes(snapshot.position).sum(axis=-1), snapshot)
