"""Common code of measures of a single number."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tissuec.model.network import Floats
from tissuec.script.measures import Subject
from tissuec.script.measures.snapshot import Snapshot


class ScalarMeasure:
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
