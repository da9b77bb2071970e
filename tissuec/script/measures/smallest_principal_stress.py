"""Smallest normal stress in any direction."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.stresses import mean_stress


@MEASURES.member("smallest principal stress")
class SmallestPrincipalStress(ScalarMeasure):
    """The smallest principal value of the mean Cauchy stress around the nodes of A.

    That is the smallest normal stress in any direction, negative where A is compressed in any.
    See `stress(A)`.
    """

    form = "smallest principal stress(A)"
    dimension = units.PRESSURE
    subjects = 1
    takes = "solid"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        principal = np.linalg.eigvalsh(mean_stress(subjects[0], snapshot))
        return one_column(principal[..., 0], snapshot)
