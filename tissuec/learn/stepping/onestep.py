"""What all methods have in common whose steps work out their own accelerations."""

import numpy as np

from tissuec.kernels.sensitivity import Seeds, Values
from tissuec.learn.stepping import Act, State
from tissuec.network import Floats


class OneStep:
    """A beginning with nothing to work out; see ``Stepping``."""

    lands = True

    def begin(self, act: Act, x: Floats, v: Floats) -> Floats:
        """Return no accelerations: each step works out its own."""
        return np.zeros_like(x)

    def begin_back(
        self, act: Act, x: Floats, v: Floats, a: Floats, due: State, by: Values
    ) -> tuple[Floats, Floats]:
        """Return what is due to the state: nothing else was worked out."""
        return due.x, due.v

    def begin_change(
        self, act: Act, x: Floats, v: Floats, a: Floats, seeds: Seeds, tx: Floats, tv: Floats
    ) -> Floats:
        """Return zeros, as ``begin`` does."""
        return np.zeros_like(tx)
