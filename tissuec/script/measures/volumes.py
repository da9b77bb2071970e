"""Volumes of bodies, and pressures inside of them."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.core.keeping import kept_on_owner
from tissuec.core.source import Source, Span
from tissuec.forces.pressed_faces import PressedFaces
from tissuec.forces.pressed_sides import (
    NoSide,
    Pressed,
    closed_by_caps,
    enclosed,
    pressed_faces,
)
from tissuec.forces.volume import Enclosure
from tissuec.model.network import Floats, Network, numbers_in
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.stresses import mean_stress

_NOWHERE = Span(Source("", ""), 0, 0)


@kept_on_owner(16)
def surface_of(network: Network, name: str) -> Enclosure | None:
    """Return the closed surface of a body, None where it is open."""
    try:
        return Enclosure.of(network, name, 1.0, _NOWHERE)
    except ValueError:
        return None


@kept_on_owner(16)
def capped_surface_of(network: Network, name: str) -> PressedFaces | None:
    """Return the faces of a wall that caps or planes of symmetry can close, else None."""
    part = next((body for body in network.bodies if body.name == name), None)
    if part is None:
        return None
    try:
        faces = pressed_faces(network, Pressed(name, numbers_in(part.nodes)))
        if faces.rims.count or not faces.planes:
            closed_by_caps(network, name, faces)
    except NoSide:
        return None
    return faces


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


@MEASURES.member("pressure")
class Pressure(ScalarMeasure):
    """The pressure inside of the body A, which preserves its volume or presses it.

    Of a solid of elements and of nodes of one, it is the hydrostatic pressure, minus a third of
    the trace of their mean stress. It is 0 if there is neither.
    """

    form = "pressure(A)"
    dimension = units.PRESSURE
    subjects = 1
    takes = "body or solid"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        name, state = subjects[0].name, snapshot.state
        enclosure = state.enclosure(name)
        whole = next((body for body in state.network.bodies if body.name == name), None)
        is_solid = whole is None or (whole.is_made_of_elements and not whole.is_wall)
        if is_solid and enclosure is None:
            trace = np.trace(mean_stress(subjects[0], snapshot), axis1=-2, axis2=-1)
            return one_column(0.0 - trace / 3.0, snapshot)
        total = np.zeros(np.shape(snapshot.time))
        if enclosure is not None:
            each = enclosure.pressures(snapshot.time, snapshot.position) * enclosure.drawn
            total = total + each.sum(axis=-1) / enclosure.drawn.sum()
        for acting in () if is_solid else state.of_kind("pressure"):
            if acting.name == name:
                total = total + acting.pressure(snapshot.time)
        return one_column(total, snapshot)
