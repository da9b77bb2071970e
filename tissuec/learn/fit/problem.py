"""Weighted least squares over all experiments: residuals, gradient and Jacobian.

E = ½ Σ w ((y + z - p) / σ)² with the prediction y, the measurement p, the noise σ, the weight w
of a series and its unknown offset z, if it has one. Missing values contribute 0. With σ = w = 1
it is the error function of the paper (Nürnberger, Radetzky & Kruse 1998, section 3.1.5). Priors
add a quadratic term for each parameter that has one; a weak regularisation keeps parameters
that the data does not determine at their start.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.errors import TissueError
from tissuec.learn.derivatives.model import Model, measured, slots_of
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.parameters.blocks import Prior
from tissuec.measurements.experiment import Experiment
from tissuec.model.network import Floats, Indices
from tissuec.script.fit_problem import FitProblem

REACH = 2.0  # of logarithms: a factor of 7
CONSTANT = 1e-9  # of data: a deviation from the mean that is rounding


class FittedExperiment(Struct, frozen=True, eq=False):
    """An experiment with what predicts it."""

    experiment: Experiment
    model: Model


class Problem:
    """Residuals of all experiments as a function of parameters and zeros.

    Parameters of the net come first, then one zero for each fit that has one, in units of
    ``zeros`` (of how far the data deviates from its mean, where not given).

    Attributes:
        fit_of: Place in the fit problem of the fit of each number, shape (number,).
        rows: Number of the row of each number in its series, shape (number,).
        times: Time of each number [s], or displacement [m], shape (number,).
        part: Which numbers are in use, shape (number,).
        noise: Standard deviation by which each fit is measured, by its place in the problem.
        reaches: By how much each parameter may well differ from its start, shape (parameter,):
            a factor of 7 where nothing else is given; infinite for zeros.
        faint: Weight with which each parameter is drawn to its start, shape (parameter,).
        trust: Factor of what was expected: 0 as long as the noise is not known, against which
            it is weighed.
    """

    def __init__(
        self,
        fit_problem: FitProblem,
        trials: Sequence[FittedExperiment],
        parameters: int,
        priors: Sequence[Prior] = (),
        *,
        zeros: Floats | None = None,
        reaches: Floats | None = None,
    ):
        self.fit_problem, self.trials, self.own = fit_problem, tuple(trials), parameters
        self.priors = tuple(priors)
        self.zeroed = [k for k, fit in enumerate(fit_problem.fits) if fit.free_zero]
        self.size = parameters + len(self.zeroed)
        self.data = np.concatenate(
            [np.zeros(0), *(measured(t.experiment.series) for t in trials)]
        )
        self.fit_of = np.concatenate([np.zeros(0, dtype=np.int64), *self._of_fits()])
        self.times = np.concatenate([np.zeros(0), *self._of_times()])
        self.rows = np.concatenate([np.zeros(0, dtype=np.int64), *self._of_rows()])
        self.part = np.ones(len(self.data), dtype=bool)
        self.spread = np.array([self._deviation(k) for k in range(len(fit_problem.fits))])
        self.unit_of_zero = self.spread if zeros is None else zeros
        self.noise = self.first_noise()
        own = np.full(parameters, REACH) if reaches is None else reaches
        self.reaches = np.concatenate([own, np.full(len(self.zeroed), np.inf)])
        self.stop, self.faint, self.trust = np.inf, np.zeros(self.size), 1.0
        self.evaluations = 0
        self._frozen: Floats | None = None
        self._predicted: tuple[bytes, Floats] | None = None
        self._rows: tuple[bytes, Floats] | None = None

    def first_noise(self) -> Floats:
        """Return the scale of residuals at first, in SI units, shape (fit,)."""
        if not self.fit_problem.scaled:
            return np.ones(len(self.fit_problem.fits))
        given = [fit.noise for fit in self.fit_problem.fits]
        return np.array(
            [s if n is None else n for n, s in zip(given, self.spread, strict=True)]
        )

    @property
    def noise_is_given(self) -> bool:
        """Return whether residuals are measured by noise that was given for every fit."""
        return self.fit_problem.scaled and all(
            fit.noise is not None for fit in self.fit_problem.fits
        )

    @property
    def duration(self) -> float:
        """Return the last time of all experiments [s], or the greatest displacement [m]."""
        return float(self.times.max(initial=0.0))

    def limit(self, stop: float) -> None:
        """Use only measurements up to a time [s]."""
        if stop != self.stop:
            self._predicted = self._rows = None
        self.stop = stop
        for trial in self.trials:
            trial.model.limit(stop)

    def limit_to(self, part: float) -> None:
        """Use only a part of the data, from its beginning; 1 is all of it.

        What was measured at 0 s alone has no parts.
        """
        self.limit(np.inf if part == 1.0 or not self.duration else part * self.duration)

    def freeze(self, theta: Floats) -> None:
        """Keep the events of all experiments as they are for these parameters."""
        if self._frozen is None or not np.array_equal(theta, self._frozen):
            self._frozen, self._predicted, self._rows = theta.copy(), None, None
        for trial in self.trials:
            trial.model.freeze(theta[: self.own])

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Return which numbers were measured and are within the horizon, shape (number,)."""
        return np.isfinite(self.data) & (self.times <= self.stop) & self.part

    @property
    def fits(self) -> NDArray[np.int64]:
        """Return the place in the fit problem of the fit of each counted number.

        The shape is (counted,).
        """
        return self.fit_of[self.counted]

    @property
    def scales(self) -> Floats:
        """Return √w / σ of each fit in SI units, shape (fit,)."""
        return np.sqrt([fit.weight for fit in self.fit_problem.fits]) / self.noise

    @property
    def scale(self) -> Floats:
        """Return √w / σ of each counted number in SI units, shape (counted,)."""
        return self.scales[self.fits]

    def many_until(self, time: float) -> int:
        """Return how many numbers were measured up to a time [s]."""
        return int((np.isfinite(self.data) & (self.times <= time) & self.part).sum())

    def predicted(self, theta: Floats) -> Floats:
        """Return all predictions with their zeros, in SI units, shape (number,)."""
        key = theta[: self.own].tobytes()
        if self._predicted is None or self._predicted[0] != key:
            self.evaluations += 1
            parts = [trial.model.predict(theta[: self.own]) for trial in self.trials]
            self._predicted = key, np.concatenate([np.zeros(0), *parts])
        return self._predicted[1] + self._zeros(theta)[self.fit_of]

    def left(self, theta: Floats) -> Floats:
        """Return predictions less measurements in SI units, shape (counted,)."""
        return (self.predicted(theta) - self.data)[self.counted]

    def relative(self, theta: Floats) -> float:
        """Return residuals relative to the deviation of data from its mean; 0 without data."""
        left = self.left(theta) / self.spread[self.fits]
        with np.errstate(over="ignore"):
            return float(np.sqrt(np.mean(np.square(left)))) if len(left) else 0.0

    def rms(self, theta: Floats) -> float:
        """Return the root mean square of residuals in units of the noise."""
        left = self.scale * self.left(theta)
        return float(np.sqrt(np.mean(np.square(left)))) if len(left) else 0.0

    def residuals(self, theta: Floats) -> Floats:
        """Return the residuals whose sum of squares is 2 E, dimensionless.

        The shape is (counted + priors,).
        """
        expected = [self.trust * (theta[p.place] - p.value) / p.spread for p in self.priors]
        return np.concatenate([self.scale * self.left(theta), expected, self.faint * theta])

    def error(self, theta: Floats) -> float:
        """Return E; infinite where it overflows."""
        with np.errstate(over="ignore"):
            return 0.5 * float(np.square(self.residuals(theta)).sum())

    def error_at(self, theta: Floats) -> float:
        """Return E with the events of these parameters."""
        self.freeze(theta)
        return self.error(theta)

    def derivatives(self, theta: Floats) -> Floats:
        """Return the derivatives of predictions in SI units, shape (counted, parameter)."""
        key = theta[: self.own].tobytes()
        if self._rows is None or self._rows[0] != key:
            parts = [trial.model.jacobian(theta[: self.own]) for trial in self.trials]
            self._rows = key, np.concatenate(parts)
        rows = self._rows[1]
        zeros = (self.fits[:, None] == self.zeroed) * self.unit_of_zero[self.zeroed]
        return np.concatenate([rows[self.counted], zeros], axis=1)

    def jacobian(self, theta: Floats) -> Floats:
        """Return the derivatives of the residuals, shape (residual, parameter)."""
        rows = self.derivatives(theta)
        first = len(rows)
        found = np.zeros((first + len(self.priors) + self.size, self.size))
        found[:first] = self.scale[:, None] * rows
        for k, prior in enumerate(self.priors):
            found[first + k, prior.place] = self.trust / prior.spread
        found[first + len(self.priors) :] = np.diag(self.faint)
        return found

    def gradient(self, theta: Floats) -> tuple[float, Floats]:
        """Return E and its derivatives, dimensionless, shape (parameter,)."""
        counted, scale = self.counted, self.scale
        left = scale * self.left(theta)
        weights = np.zeros(len(self.data))
        weights[counted] = scale * left
        slope = np.zeros(self.size)
        start = 0
        for trial in self.trials:
            stop = start + len(measured(trial.experiment.series))
            slope[: self.own] += trial.model.gradient(theta[: self.own], weights[start:stop])
            start = stop
        for k, fit in enumerate(self.zeroed):
            slope[self.own + k] = self.unit_of_zero[fit] * weights[self.fit_of == fit].sum()
        error = 0.5 * float(left @ left)
        for prior in self.priors:
            away = self.trust * (theta[prior.place] - prior.value) / prior.spread
            error += 0.5 * away * away
            slope[prior.place] += self.trust * away / prior.spread
        error += 0.5 * float(np.square(self.faint * theta).sum())
        return error, slope + self.faint**2 * theta

    def influence(self, theta: Floats) -> Floats:
        """Return how much each parameter changes predictions, shape (parameter,).

        It is the root of the mean square, in units of how far the data deviates from its mean.
        """
        rows = self.derivatives(theta) / self.spread[self.fits][:, None]
        return np.sqrt(np.mean(np.square(rows), axis=0))

    def with_zeros(self, theta: Floats) -> Floats:
        """Return the same parameters with the best zeros, by medians.

        Zeros are unchanged where there is no prediction.
        """
        try:
            left = self.left(theta)
        except (Diverged, TissueError):
            return theta
        found = theta.copy()
        for k, fit in enumerate(self.zeroed):
            mine = left[self.fits == fit]
            if len(mine) and np.isfinite(mine).all():
                found[self.own + k] -= float(np.median(mine)) / self.unit_of_zero[fit]
        return found

    def zero(self, theta: Floats, fit: int) -> float:
        """Return the zero of a fit in SI units.

        Args:
            theta: Parameters, dimensionless, shape (parameter,).
            fit: Place of the fit.
        """
        return float(self._zeros(theta)[fit])

    def of_series(self, numbers: Floats) -> Iterator[Floats]:
        """Yield views of the numbers of each series, shape (row, component).

        Args:
            numbers: In any unit, shape (number,).
        """
        start = 0
        for trial in self.trials:
            for slot in slots_of(trial.experiment.series):
                size = slot.rows * slot.width
                yield numbers[start : start + size].reshape(slot.rows, slot.width)
                start += size

    # --- parts --------------------------------------------------------------------------------

    def _zeros(self, theta: Floats) -> Floats:
        found = np.zeros(len(self.fit_problem.fits))
        found[self.zeroed] = theta[self.own :] * self.unit_of_zero[self.zeroed]
        return found

    def _of_fits(self) -> Iterator[NDArray[np.int64]]:
        """Yield the place in the fit problem of the fit of each number, by series."""
        fits = self.fit_problem.fits
        for trial in self.trials:
            series = trial.experiment.series
            for one, slot in zip(series, slots_of(series), strict=True):
                number = next(k for k, fit in enumerate(fits) if fit.span == one.fit.span)
                yield np.full(slot.rows * slot.width, number, dtype=np.int64)

    def _of_rows(self) -> Iterator[Indices]:
        """Yield the number of the row of each number, by series."""
        for trial in self.trials:
            for slot in slots_of(trial.experiment.series):
                yield np.repeat(np.arange(slot.rows), slot.width)

    def _of_times(self) -> Iterator[Floats]:
        """Yield the time of each number [s], by series."""
        for trial in self.trials:
            series = trial.experiment.series
            for one, slot in zip(series, slots_of(series), strict=True):
                yield np.repeat(one.times, slot.width)

    def _deviation(self, fit: int) -> float:
        """Return how far what was measured deviates from its mean, at least a bit."""
        mine = self.data[(self.fit_of == fit) & np.isfinite(self.data)]
        if not len(mine):
            return 1.0
        spread = float(np.sqrt(np.mean(np.square(mine - self._means(fit)))))
        most = float(np.abs(mine).max())
        return spread if spread > CONSTANT * most else most or 1.0

    def _means(self, fit: int) -> Floats:
        """Return the mean in time of each component that a fit measured."""
        parts: list[Floats] = []
        for trial in self.trials:
            for one in trial.experiment.series:
                if one.fit.span == self.fit_problem.fits[fit].span:
                    values = one.values.reshape(len(one.times), -1)
                    known = np.isfinite(values)
                    # A component that was never measured has no mean, and needs none.
                    many = np.maximum(known.sum(axis=0), 1)
                    mean = np.where(known, values, 0.0).sum(axis=0) / many
                    parts.append(np.broadcast_to(mean, values.shape)[known])
        return np.concatenate(parts)
