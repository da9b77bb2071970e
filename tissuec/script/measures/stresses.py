"""Stress of elements, its largest and smallest principal values, and permanent strain."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tissuec.core import units
from tissuec.mechanics.deformation import COMPONENTS, six, symmetric, von_mises
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import DirectedMeasure, ScalarMeasure, one_column
from tissuec.script.measures.points import around_nodes, at_point
from tissuec.script.measures.snapshot import Snapshot


def mean_stress(subject: Subject, snapshot: Snapshot) -> Floats:
    """Return the mean Cauchy stress around the nodes of a subject [Pa], shape (…, 3, 3).

    Nodes count by the volume of their shares of elements as drawn. The stress is zero where no
    element is left. What is viscous is left out.
    """
    times = np.shape(snapshot.time)
    if subject.of_points is not None:
        own = at_point(snapshot, subject, lambda own, places: own.stresses(places))
        return np.broadcast_to(own, (*times, 3, 3))
    nodes = snapshot.nodes(subject)
    position, velocity = (
        each.reshape(-1, *each.shape[-2:]) for each in (snapshot.position, snapshot.velocity)
    )
    total, volume = np.zeros((len(position), 3, 3)), 0.0
    for field in snapshot.state.elements:
        elements, used = field.intact(snapshot.state.alive).around(nodes)
        own = np.isin(used, nodes)
        drawn = 0.0  # the same at all times
        for row, places, speeds in zip(total, position[:, used], velocity, strict=True):
            stress, share = elements.recalling(speeds).node_stress(places)
            row += stress[own].sum(axis=0)
            drawn = float(share[own].sum())
        volume += drawn
    return (total / (volume or 1.0)).reshape(*times, 3, 3)


#: What the components are called.
STRESS_COLUMNS = tuple("xyz"[i] + "xyz"[j] for i, j in COMPONENTS)


@MEASURES.member("stress")
class Stress(DirectedMeasure):
    """The mean Cauchy stress around the nodes of A, without its viscous part.

    Nodes count by the volume of the elements around them. In conditions, it is the equivalent
    stress of von Mises; `along (x, y, z)` selects the normal stress in that direction, which
    is negative in compression. Logs contain the components xx, yy, zz, xy, yz and xz. It is 0
    where all elements were cut.
    """

    form = "stress(A)"
    dimension = units.PRESSURE
    needs = ("elements",)
    at_points = True

    @staticmethod
    def columns(subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        return STRESS_COLUMNS

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return six(mean_stress(subjects[0], snapshot))

    @staticmethod
    def value(sample: Floats) -> Floats:
        return von_mises(sample)

    @staticmethod
    def along(sample: Floats, direction: Floats) -> Floats:
        return np.einsum("...ij,i,j->...", symmetric(sample), direction, direction)


@MEASURES.member("largest principal stress")
class LargestPrincipalStress(ScalarMeasure):
    """The largest principal value of the mean Cauchy stress around the nodes of A.

    That is the largest normal stress in any direction; it is negative where A is compressed in
    all directions. See `stress(A)`.
    """

    form = "largest principal stress(A)"
    dimension = units.PRESSURE
    needs = ("elements",)
    at_points = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        principal = np.linalg.eigvalsh(mean_stress(subjects[0], snapshot))
        return one_column(principal[..., -1], snapshot)


@MEASURES.member("smallest principal stress")
class SmallestPrincipalStress(ScalarMeasure):
    """The smallest principal value of the mean Cauchy stress around the nodes of A.

    That is the smallest normal stress in any direction, negative where A is compressed in any.
    See `stress(A)`.
    """

    form = "smallest principal stress(A)"
    dimension = units.PRESSURE
    needs = ("elements",)
    at_points = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        principal = np.linalg.eigvalsh(mean_stress(subjects[0], snapshot))
        return one_column(principal[..., 0], snapshot)


@MEASURES.member("plastic strain")
class PlasticStrain(ScalarMeasure):
    """The largest plastic strain at the nodes of A, each averaged over the elements around it.

    It is the equivalent logarithmic strain √(2/3) |log U| of the plastic deformation: for a
    bar, the logarithm of its unloaded length over its drawn length. It is 0 where nothing
    yields.
    """

    form = "plastic strain(A)"
    dimension = units.NUMBER
    needs = ("elements", "yielding")
    at_points = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        if subjects[0].of_points is not None:
            return one_column(at_point(snapshot, subjects[0], _plastic_strains), snapshot)
        nodes = snapshot.nodes(subjects[0])
        own = around_nodes(snapshot, _plastic_strains)[..., nodes]
        return one_column(own.max(axis=-1, initial=0.0), snapshot)


def _plastic_strains(elements: Any, position: Floats) -> Floats:
    return elements.plastic_strains
