"""Coefficients of Runge-Kutta methods."""

from typing import NamedTuple

import numpy as np

from tissuec.network import Floats


class Tableau(NamedTuple):
    """A method.

    Attributes:
        name: Of the integrator whose coefficients these are.
        weights: A, shape (stage, stage).
        result: b, shape (stage,).
    """

    name: str
    weights: Floats
    result: Floats

    @property
    def is_explicit(self) -> bool:
        """Return whether each stage follows from those before."""
        return not np.triu(self.weights).any()

    @property
    def rows(self) -> tuple[Floats, Floats, Floats]:
        """Return the weights of accelerations in x and in v, and the times of stages.

        Those of the result stand last; shapes (stage + 1, stage) and (stage + 1,).
        """
        a, b = self.weights, self.result
        nodes = np.append(a.sum(axis=1), 1.0)
        return np.vstack([a @ a, b @ a]), np.vstack([a, b]), nodes
