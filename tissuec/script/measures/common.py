"""Common code of measures: bases of those of a number, of a vector, and along a direction."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tissuec.model.network import Floats
from tissuec.script.measures import Subject
from tissuec.script.measures.snapshot import Snapshot


class OfNodes:
    """What most measures take: one subject, of which they need the nodes."""

    subjects = 1
    takes = "nodes"


class DirectedMeasure(OfNodes):
    """Base of the measures that can be followed by ``along (x, y, z)``."""

    @staticmethod
    def along(sample: Floats, direction: Floats) -> Floats:
        """Return the part along a direction in the unit of the measure, shape (…).

        Args:
            sample: Components in the unit of the measure, shape (…, column).
            direction: Unit vector, shape (3,).
        """
        raise NotImplementedError


def is_directed(measure: object) -> bool:
    """Return whether a measure can be followed by ``along (x, y, z)``."""
    return isinstance(measure, type) and issubclass(measure, DirectedMeasure)


class ScalarMeasure(OfNodes):
    """Base of the measures that have one component."""

    @staticmethod
    def columns(subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        return ("value",)

    @staticmethod
    def value(sample: Floats) -> Floats:
        return sample[..., 0]


def one_column(value: ArrayLike, snapshot: Snapshot) -> Floats:
    """Return a number per sample, or the same one for all samples, as a column.

    Args:
        value: In any unit, shape (…) or a number.
        snapshot: The samples.

    Returns:
        The numbers in the same unit, shape (…, 1).
    """
    return np.broadcast_to(np.asarray(value, dtype=float), np.shape(snapshot.time))[..., None]


class VectorMeasure(DirectedMeasure):
    """Base of the measures whose components are x, y and z and whose value is the length."""

    @staticmethod
    def columns(subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        return ("x", "y", "z")

    @staticmethod
    def value(sample: Floats) -> Floats:
        return np.asarray(np.linalg.norm(sample, axis=-1))

    @staticmethod
    def along(sample: Floats, direction: Floats) -> Floats:
        return np.asarray(sample @ direction)
