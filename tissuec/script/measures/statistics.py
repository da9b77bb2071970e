"""Statistics of a field over a set or a body, such as ``largest(von Mises stress of A)``."""

import numpy as np

from tissuec.model.network import Floats

LARGEST, SMALLEST, AVERAGE, PERCENTILE = "largest", "smallest", "average", "percentile"
#: With what each of them is.
STATISTICS = {
    LARGEST: "the largest number",
    SMALLEST: "the smallest number",
    AVERAGE: "the mean, by volume in elements",
    PERCENTILE: "the smallest number that is not exceeded in this part of the volume",
}
_ROUNDING = 1e-12  # of the whole volume


def form_of(statistic: str, field: str = "FIELD") -> str:
    """Return how a statistic is written."""
    share = ", 95 %" if statistic == PERCENTILE else ""
    return f"{statistic}({field} of A{share})"


def statistic_of(statistic: str, numbers: Floats, weights: Floats, share: float) -> Floats:
    """Return a statistic of numbers, in their unit, shape (…); NaN without any.

    Args:
        statistic: Of ``STATISTICS``.
        numbers: In any unit, shape (…, n).
        weights: By how much each counts for averages and percentiles, shape (n,).
        share: Of a percentile, from 0 to 1.
    """
    if not len(weights):
        return np.full(numbers.shape[:-1], np.nan)
    match statistic:
        case "largest":
            return np.asarray(numbers.max(axis=-1))
        case "smallest":
            return np.asarray(numbers.min(axis=-1))
        case "average":
            # Not by BLAS, whose sums depend on how many states there are at once.
            parts = np.ascontiguousarray(numbers * weights)
            return np.asarray(parts.sum(axis=-1) / weights.sum())
        case _:
            order = np.argsort(numbers, axis=-1)
            below = np.cumsum(weights[order], axis=-1)
            enough = below >= (share - _ROUNDING) * weights.sum()
            first = np.argmax(enough, axis=-1)[..., None]
            place = np.take_along_axis(order, first, axis=-1)
            return np.take_along_axis(numbers, place, axis=-1)[..., 0]
