"""Predictions of an experiment by a run of the engine."""

import numpy as np

from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.sampling import SAME, join_times
from tissuec.engine.method import Samples
from tissuec.learn.data.experiment import Series
from tissuec.learn.derivatives.model import Slots
from tissuec.model.network import Floats, Network
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import Plan


class ObservingRecorder(Recorder):
    """A recorder that looks at a run as an experiment did.

    Args:
        plan: One without outputs.
        slots: Where each series stands among the predictions.
        stop: Rows that are later are not looked at [s].

    Attributes:
        found: Predictions in SI units, 0 where nothing was looked at, shape (number,).
    """

    takes_notes = False

    def __init__(
        self,
        network: Network,
        plan: Plan,
        series: tuple[Series, ...],
        slots: tuple[Slots, ...],
        stop: float,
    ):
        super().__init__(network, plan, MemoryRecording())
        self._series, self._slots = series, slots
        self.found = np.zeros(sum(slot.rows * slot.width for slot in slots))
        near = SAME * plan.simulation.duration
        wanted = np.concatenate([one.times[one.times <= stop] for one in series])
        # What is measured at the time of an event shows what is after it.
        self.times = join_times(wanted, np.array([event.time for event in plan.events]), near)
        self._places = [np.searchsorted(self.times, one.times - near) for one in series]

    def record(self, samples: Samples) -> None:
        """Look at the next samples of ``times``."""
        assert self._state is not None, "enter comes first"
        first, last = np.searchsorted(self.times, samples.time[[0, -1]])
        snapshot = self._snapshot(samples, self._state)
        for one, slot, places in zip(self._series, self._slots, self._places, strict=True):
            rows = np.flatnonzero((places >= first) & (places <= last))
            if len(rows):
                seen = _seen(one, slot.width, snapshot.pick(places[rows] - first))
                self.found[slot.of(int(rows[0])).start : slot.of(int(rows[-1])).stop] = seen


def _seen(one: Series, width: int, snapshot: Snapshot) -> Floats:
    """Return what a series is of at some snapshots, one after the other."""
    fit = one.fit
    if fit.measure is None:
        values = snapshot.position[..., one.nodes, :]
    else:
        values = fit.measure.sample(fit.subjects, snapshot)
    values = fit.part(values)
    rows = values.reshape(len(snapshot.position), -1)
    if fit.measure is not None and rows.shape[1] != width:
        rows = fit.measure.value(rows)
    return rows.ravel()
