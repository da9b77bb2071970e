"""An experiment in time, with exact derivatives of every step."""

from collections.abc import Callable, Iterator

import numpy as np
from scipy import sparse

from tissuec.learn.derivatives.event_recording import EventRecorder
from tissuec.learn.derivatives.event_schedule import EventSchedule
from tissuec.learn.derivatives.methods import ChosenMethod
from tissuec.learn.derivatives.model import Slots, measured, slots_of
from tissuec.learn.derivatives.motion import Diverged, Motion, SampledStates
from tissuec.learn.derivatives.observables import Observable, StateView, pull, push
from tissuec.learn.derivatives.stepping import Stepping
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.measurements.experiment import Series
from tissuec.model.network import Floats, Network
from tissuec.script.plan import Plan

CHANGES = 256  # that are carried through the steps at once


class DynamicModel:
    """Predictions of a motion.

    Args:
        looks: What each series is of.
        stepping, step: The method, and its largest step [s].
        choose: Returns both for the numbers at which events are found anew; None: they stay.
    """

    name = "exact derivatives of every step"

    def __init__(
        self,
        shaping: Parametrisation,
        series: tuple[Series, ...],
        looks: tuple[Observable, ...],
        stepping: Stepping,
        step: float,
        choose: Callable[[Network, Plan], ChosenMethod] | None = None,
    ):
        self.shaping, self.series, self.looks, self.stepping = shaping, series, looks, stepping
        self.step, self.choose = step, choose
        self.slots = slots_of(series)
        self.size = len(measured(series))
        self.times = np.unique(np.concatenate([one.times for one in series]))
        self._stop = self.stop = float(self.times[-1]) or step
        self._theta: Floats | None = None  # at which everything is frozen
        self._schedule: EventSchedule | None = None
        self._motion: Motion | None = None
        self._known: tuple[bytes, Floats, SampledStates] | None = None

    @property
    def motion(self) -> Motion:
        """Return the motion up to the limit; raises Diverged where the script leads nowhere."""
        if self._motion is None:
            times = self.times[self.times <= self._stop]
            schedule, order = self._frozen(), self.shaping.order
            self._motion = Motion(schedule, self.stepping, order, self.step, times)
        return self._motion

    def freeze(self, theta: Floats) -> None:
        """Keep the events for these numbers, once they are needed.

        Steps are chosen anew: those for a soft start are too long where the truth is stiff.
        """
        if self._theta is not None and np.array_equal(theta, self._theta):
            return
        self._theta, self._schedule = theta.copy(), None
        self._motion, self._known = None, None
        if self.choose is not None:
            present = self.shaping.present(theta)
            self.stepping, self.step = self.choose(present.network, present.plan)

    def _frozen(self) -> EventSchedule:
        """Return the events up to the limit; later ones are not computed."""
        if self._schedule is None or self._schedule.stop < self._stop:
            assert self._theta is not None, "freeze comes first"
            compiled = self.shaping.compiled
            if compiled.plan.triggers or compiled.plan.breakable:
                compiled = self.shaping.present(self._theta)
            freezer = EventRecorder(compiled.plan, self.stepping, self.shaping.order, self.step)
            vector = self.shaping.vector(self._theta)
            self._schedule = freezer.schedule(compiled.network, vector, self._stop)
        return self._schedule.until(self._stop)

    def limit(self, stop: float) -> None:
        """Predict only up to a time [s]."""
        if min(stop, self.stop) != self._stop:
            self._stop = min(stop, self.stop)
            self._motion, self._known = None, None

    def predict(self, theta: Floats) -> Floats:
        """Return the predictions; raises Diverged."""
        vector, samples = self._samples(theta)
        found = np.zeros(self.size)
        for look, slot, rows in self._rows():
            for row, sample in rows:
                found[slot.of(row)] = look.at(self._view(vector, samples, sample))
        return found

    def gradient(self, theta: Floats, weights: Floats) -> Floats:
        """Return the derivatives of Σ weights · predictions, by one pass backwards."""
        vector, samples = self._samples(theta)
        order = self.shaping.order
        by_x, by_v = np.zeros_like(samples.x), np.zeros_like(samples.v)
        direct = np.zeros(order.size)
        for look, slot, rows in self._rows():
            for row, sample in rows:
                weight = weights[slot.of(row)]
                if not weight.any():
                    continue
                view = self._view(vector, samples, sample)
                slope = pull(look, view, weight)
                by_x[sample] += slope.x
                by_v[sample] += slope.v
                if slope.numbers is not None:
                    direct += slope.numbers
        direct += self.motion.backward(by_x, by_v)
        return np.asarray(self.shaping.change(theta).T @ direct)

    def jacobian(self, theta: Floats) -> Floats:
        """Return the derivatives of all predictions, by changes carried through the steps."""
        vector, samples = self._samples(theta)
        found, change = np.zeros((self.size, self.shaping.size)), self.shaping.change(theta)
        by_sample: dict[int, list[tuple[Observable, slice]]] = {}
        for look, slot, rows in self._rows():
            for row, sample in rows:
                by_sample.setdefault(sample, []).append((look, slot.of(row)))
        for first in range(0, self.shaping.size, CHANGES):
            columns = slice(first, min(first + CHANGES, self.shaping.size))
            some = sparse.csr_matrix(change[:, columns])

            def visit(
                sample: int, tx: Floats, tv: Floats,
                columns: slice = columns, some: sparse.csr_matrix = some,
            ) -> None:  # fmt: skip
                view = self._view(vector, samples, sample)
                for look, part in by_sample.get(sample, ()):
                    found[part, columns] = push(look, view, tx, tv, some)

            self.motion.forward_with(vector, some, visit)
        return found

    def step_error(self, theta: Floats) -> Floats:
        """Return the difference to predictions with half the steps; infinite without any."""
        half = 0.5 * self.motion.longest
        finer = DynamicModel(self.shaping, self.series, self.looks, self.stepping, half)
        try:
            finer.freeze(theta)
            return finer.predict(theta) - self.predict(theta)
        except Diverged:
            return np.full(self.size, np.inf)

    # --- parts --------------------------------------------------------------------------------

    def _samples(self, theta: Floats) -> tuple[Floats, SampledStates]:
        """Return the numbers of the net and the observed states."""
        key = theta.tobytes()
        if self._known is None or self._known[0] != key:
            vector = self.shaping.vector(theta)
            self._known = None  # of the motion, only the last one is remembered
            self._known = key, vector, self.motion.forward(vector)
        return self._known[1:]

    def _rows(self) -> Iterator[tuple[Observable, Slots, list[tuple[int, int]]]]:
        """Yield each series' look and place, and its rows with the number of their samples."""
        times = self.motion.times
        for one, look, slot in zip(self.series, self.looks, self.slots, strict=True):
            rows = np.flatnonzero(one.times <= self._stop)
            samples = np.searchsorted(times, one.times[rows])
            yield look, slot, list(zip(rows.tolist(), samples.tolist(), strict=True))

    def _view(self, vector: Floats, samples: SampledStates, sample: int) -> StateView:
        motion = self.motion
        leg = motion.schedule.legs[int(motion.leg_of[sample])]
        time = float(motion.times[sample])
        return StateView(leg, vector, samples.x[sample], samples.v[sample], time)
