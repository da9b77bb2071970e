"""What measures of a single number share."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tissuec.model.network import Floats
from tissuec.script.measures import Subject
from tissuec.script.measures.moment import Moment


class Scalar:
    """Base of the measures that have one component."""

    @staticmethod
    def columns(subjects: Sequence[Subject], moment: Moment) -> tuple[str, ...]:
        return ("value",)

    @staticmethod
    def value(sample: Floats) -> Floats:
        return sample[..., 0]


def one_column(value: ArrayLike, moment: Moment) -> Floats:
    """Return a number per sample, or the same one for all of them, as shape (…, 1)."""
    return np.broadcast_to(np.asarray(value, dtype=float), np.shape(moment.time))[..., None]
