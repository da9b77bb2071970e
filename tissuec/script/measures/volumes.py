"""Volumes of bodies, and pressures inside of them."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.stresses import mean_stress


@MEASURES.member("volume")
class Volume(ScalarMeasure):
    """The present volume inside the body A.

    Open ends of a wall count as closed by flat caps. For a lattice and for
    a solid of elements, it is the sum of all cells or elements.
    """

    form = "volume(A)"
    dimension = units.VOLUME
    takes = "body"
    needs = ("inside",)

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        from tissuec.mechanics.enclosing_surfaces import enclosed_volume  # where it is asked

        network, name = snapshot.state.network, subjects[0].name
        elements = [each for each in network.of_kind("elements") if each.name == name]
        if elements:
            every = sum(each.whole_volume(snapshot.position) for each in elements)
            return one_column(every, snapshot)
        return one_column(enclosed_volume(network, name, snapshot.position), snapshot)


@MEASURES.member("pressure")
class Pressure(ScalarMeasure):
    """The pressure inside of the body A, which preserves its volume or presses it.

    Of nodes of a solid of elements, and of one whose enclosed volume is not preserved, even if
    it is pressed, it is the hydrostatic pressure: minus a third of the trace of the mean
    stress. It is 0 if there is neither.
    """

    form = "pressure(A)"
    dimension = units.PRESSURE
    needs = ("pressure",)
    at_points = True

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
        if not is_solid:
            total = _with_applied(total, name, snapshot)
        return one_column(total, snapshot)


@MEASURES.member("applied pressure")
class AppliedPressure(ScalarMeasure):
    """The pressure that `press` applies to the set or body A, with its sign; 0 without any.

    Pressures on one surface add up. Over the pressure, any other measure gives a curve such as
    that of the diameter of an artery.
    """

    form = "applied pressure(A)"
    dimension = units.PRESSURE
    needs = ("load",)

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        none = np.zeros(np.shape(snapshot.time))
        return one_column(_with_applied(none, subjects[0].name, snapshot), snapshot)


def _with_applied(pressure: Floats, name: str, snapshot: Snapshot) -> Floats:
    """Return a pressure and all that is applied to a set or body of this name [Pa], (…)."""
    for acting in snapshot.state.of_kind("pressure"):
        if acting.name == name:
            pressure = pressure + acting.pressure(snapshot.time)
    return pressure
