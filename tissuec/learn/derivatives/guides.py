"""Guided nodes in derivatives: the part of forces in held directions counts for nothing.

Forward, guides project the sum of the forces of all other fields; backwards, the weights of
these forces, before all other fields. These loops run as Python: they are called once in an
evaluation, and their nodes are few.
"""

import numpy as np

from tissuec.kernels.records import Floats, GuideTable


def project_weights(
    time: float, x: Floats, v: Floats, weight: Floats, by_x: Floats, by_v: Floats, by: Floats,
    guides: GuideTable,
) -> None:  # fmt: skip
    """Leave the part of weights in free directions; a ``pull_back`` that comes first."""
    _project(weight.reshape(-1, 3, 1), guides)


def project_changes(
    time: float, x: Floats, v: Floats, dx: Floats, dv: Floats, dn: Floats, df: Floats,
    room: Floats, guides: GuideTable,
) -> None:  # fmt: skip
    """Leave that part of changes of forces; a ``push_forward`` that comes last."""
    _project(df.reshape(-1, 3, room.size), guides)


def project_forces(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, guides: GuideTable
) -> None:
    """Leave that part of the forces that are there already."""
    _project(f.reshape(-1, 3, 1), guides)


def add_nothing(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, guides: GuideTable
) -> None:
    """Leave forces as they are."""


def pull_nothing(
    time: float, x: Floats, v: Floats, weight: Floats, by_x: Floats, by_v: Floats, by: Floats,
    guides: GuideTable,
) -> None:  # fmt: skip
    """Leave weights as they are."""


def push_nothing(
    time: float, x: Floats, v: Floats, dx: Floats, dv: Floats, dn: Floats, df: Floats,
    room: Floats, guides: GuideTable,
) -> None:  # fmt: skip
    """Leave changes as they are."""


def _project(vectors: Floats, guides: GuideTable) -> None:
    """Project vectors of shape (node, 3, change) in place."""
    within = np.asarray(guides.within).reshape(-1, 3, 3)
    vectors[guides.nodes] = within @ vectors[guides.nodes]
