"""Predictions of one experiment with derivatives: moving, at rest, or by differences."""

from typing import NamedTuple, Protocol

import numpy as np

from tissuec.measurements.experiment import Series
from tissuec.model.network import Floats


class Model(Protocol):
    """Predictions of one experiment as a function of the parameters.

    All measurements are in one vector, one series after the other and in each
    row by row; gaps have predictions, too.
    """

    name: str  # how derivatives are found, for people

    def freeze(self, theta: Floats) -> None:
        """Find the events of the script, and keep them for all following calls."""
        ...

    def limit(self, stop: float) -> None:
        """Predict only up to a time [s]; later predictions are 0 and have no derivatives."""
        ...

    def predict(self, theta: Floats) -> Floats:
        """Return the predictions in SI units, shape (number,)."""
        ...

    def step_error(self, theta: Floats) -> Floats:
        """Return the change of predictions with other steps, in SI units, shape (number,)."""
        ...

    def gradient(self, theta: Floats, weights: Floats) -> Floats:
        """Return the derivatives of Σ weights · predictions, shape (parameter,)."""
        ...

    def jacobian(self, theta: Floats) -> Floats:
        """Return the derivatives of all predictions, in SI units, shape (number, parameter)."""
        ...


class Slots(NamedTuple):
    """Place of a series in the vector.

    Attributes:
        start: Its first number.
        rows: How many rows it has.
        width: How many numbers a row has.
    """

    start: int
    rows: int
    width: int

    def of(self, row: int) -> slice:
        """Return the part of one row."""
        first = self.start + row * self.width
        return slice(first, first + self.width)


def slots_of(series: tuple[Series, ...]) -> tuple[Slots, ...]:
    """Return the place of each series."""
    found: list[Slots] = []
    start = 0
    for one in series:
        rows = len(one.times)
        width = int(np.prod(one.values.shape[1:]))
        found.append(Slots(start, rows, width))
        start += rows * width
    return tuple(found)


def measured(series: tuple[Series, ...]) -> Floats:
    """Return the measured values in SI units, NaN in gaps, shape (number,)."""
    return np.concatenate([np.zeros(0), *(one.values.ravel() for one in series)])
