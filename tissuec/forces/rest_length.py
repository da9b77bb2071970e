"""Rest lengths that change in time: threads and joints that are tightened or loosened.

Meanwhile the rest length of each spring follows a profile,

    L0(t) = base + change s(t),

and whoever draws does the work -∫ f(L - L0) dL0 on it.
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.core.source import Span
from tissuec.kernels.records import RestLengthActuators
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile


class ChangingRestLengths(Struct, frozen=True, eq=False):
    """Springs that are drawn in or paid out.

    Attributes:
        springs: Shape (n,).
        base, change: What makes their rest lengths [m], shape (n,).
        span: The sentence.
    """

    springs: Indices
    base: Floats
    change: Floats
    profile: TimeProfile
    span: Span

    def rest(self, time: float) -> Floats:
        """Return the rest lengths at a time [m], shape (n,)."""
        return self.base + self.profile.at(time)[0] * self.change

    def rate(self, time: float) -> Floats:
        """Return the rates of the rest lengths [m/s], shape (n,)."""
        return self.profile.at(time)[1] * self.change

    def rate_of(self, spring: int, time: float) -> float:
        """Return the rate of one rest length [m/s], 0 for a spring that is none of these."""
        return float(self.rate(time)[self.springs == spring].sum())

    def lengthened(self, spring: int, by: float) -> "ChangingRestLengths":
        """Return the same with one spring longer by a length [m], if it is one of these."""
        return replace(self, base=self.base + by * (self.springs == spring))


def reels(
    parts: Sequence[ChangingRestLengths], row: Indices, ends: Indices, first_act: int
) -> RestLengthActuators:
    """Return springs whose rest lengths change as tables.

    Args:
        parts: What changes, in the order of the acts.
        row: Where the engine keeps each spring, -1 for those that do not act, shape (spring,).
        ends: Nodes of each spring as the engine keeps them, shape (spring, 2).
        first_act: Number of the profile of the first part among the acts.
    """
    springs = np.concatenate([*(part.springs for part in parts), np.zeros(0, dtype=np.int64)])
    acts = np.repeat(first_act + np.arange(len(parts)), [len(part.springs) for part in parts])
    acting = row[springs] >= 0
    return RestLengthActuators(
        spring=row[springs][acting],
        low=ends[springs, 0][acting],
        high=ends[springs, 1][acting],
        base=np.concatenate([*(part.base for part in parts), np.zeros(0)])[acting],
        change=np.concatenate([*(part.change for part in parts), np.zeros(0)])[acting],
        act=acts[acting].astype(np.int64),
    )
