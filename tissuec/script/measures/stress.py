"""Stress of solid elements."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.mechanics.deformation import COMPONENTS, six, symmetric, von_mises
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.directed import DirectedMeasure
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.stresses import mean_stress

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
    subjects = 1
    takes = "solid"

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
