"""Planes of symmetry in derivatives: the part of forces across them counts for nothing.

Forward, they project the sum of the forces of all other fields; backwards, the weights of
these forces, before all other fields. These loops run as Python: they are called once in an
evaluation, and their nodes are few.
"""

import numpy as np

from tissuec.forces.acting.symmetry_kernel import SymmetryTable
from tissuec.kernels.records import Floats


def project_weights(
    time: float, x: Floats, v: Floats, weight: Floats, by_x: Floats, by_v: Floats, by: Floats,
    planes: SymmetryTable,
) -> None:  # fmt: skip
    """Leave the part within planes of weights; a ``pull_back`` that comes first."""
    _project(weight.reshape(-1, 3, 1), planes)


def project_changes(
    time: float, x: Floats, v: Floats, dx: Floats, dv: Floats, dn: Floats, df: Floats,
    room: Floats, planes: SymmetryTable,
) -> None:  # fmt: skip
    """Leave the part within planes of changes of forces; a ``push_forward`` that comes last."""
    _project(df.reshape(-1, 3, room.size), planes)


def add_nothing(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, planes: SymmetryTable
) -> None:
    """Leave forces as they are."""


def pull_nothing(
    time: float, x: Floats, v: Floats, weight: Floats, by_x: Floats, by_v: Floats, by: Floats,
    planes: SymmetryTable,
) -> None:  # fmt: skip
    """Leave weights as they are."""


def push_nothing(
    time: float, x: Floats, v: Floats, dx: Floats, dv: Floats, dn: Floats, df: Floats,
    room: Floats, planes: SymmetryTable,
) -> None:  # fmt: skip
    """Leave changes as they are."""


def _project(vectors: Floats, planes: SymmetryTable) -> None:
    """Project vectors of shape (node, 3, change) in place."""
    within = np.asarray(planes.within).reshape(-1, 3, 3)
    vectors[planes.nodes] = within @ vectors[planes.nodes]
