"""Volume of a body."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.forces.pressed_sides import enclosed
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.enclosed import capped_surface_of, surface_of
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("volume")
class Volume(ScalarMeasure):
    """The present volume inside the body A.

    Open ends of a wall count as closed by flat caps; it is 0 for a sheet. For a lattice and for
    a solid of elements, it is the sum of all cells or elements.
    """

    form = "volume(A)"
    dimension = units.VOLUME
    subjects = 1
    takes = "body"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        network, name = snapshot.state.network, subjects[0].name
        elements = [each for each in network.of_kind("elements") if each.name == name]
        if elements:
            every = sum(each.whole_volume(snapshot.position) for each in elements)
            return one_column(every, snapshot)
        enclosure = surface_of(network, name)
        if enclosure is not None:
            return one_column(enclosure.volumes(snapshot.position).sum(axis=-1), snapshot)
        faces = capped_surface_of(network, name)
        if faces is None:
            return one_column(0.0, snapshot)
        volume = enclosed(snapshot.position, faces.triples, faces.rims, crossing=faces.crossing)
        return one_column(volume, snapshot)
