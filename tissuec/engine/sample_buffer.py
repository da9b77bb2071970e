"""A buffer of samples that the stepping code fills for the recorder."""

from collections.abc import Callable

import numpy as np
from msgspec.structs import replace

from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import Samples
from tissuec.engine.run_arrays import glances, new_buffer
from tissuec.kernels.records import GLANCES, Progress
from tissuec.model.network import Floats


class SampleBuffer:
    """Holds samples until there are enough to hand over.

    Args:
        times: When to record [s], ascending without repetitions, shape (sample,).
        inputs: How the stepping code keeps nodes.
        record: Takes the batches, in the order of the network.
    """

    def __init__(self, times: Floats, inputs: KernelInputs, record: Callable[[Samples], None]):
        self.buffer = new_buffer(times, len(inputs.layout.order), inputs.spring_count)
        self._inputs, self._record = inputs, record
        self._aside: list[Samples] = []

    def make_room(self, steps: int) -> None:
        """Allocate room for states within some steps."""
        buffer = self.buffer
        if buffer.glance_time.size < GLANCES * steps:
            self.buffer = buffer._replace(**glances(steps, buffer.position.shape[1]))

    def set_aside(self, progress: Progress) -> Progress:
        """Keep the samples so far in the order of the network, before places change.

        Call ``fit`` once they have. Returns the updated progress.
        """
        if progress.filled:
            self._aside.append(self._samples(progress.filled))
        return replace(progress, filled=0)

    def fit(self) -> None:
        """Make room for samples of the nodes that have places now."""
        count, size = len(self.buffer.time), 3 * len(self._inputs.layout.order)
        position, velocity = np.zeros((2, count, size))
        rows = {"position": position, "velocity": velocity} | glances(0, size)
        self.buffer = self.buffer._replace(**rows)

    def is_due(self, progress: Progress, until: float) -> bool:
        """Return whether the next sample comes before a time [s]."""
        times = self.buffer.times
        return progress.sample < times.size and bool(times[progress.sample] < until)

    def enter(self, progress: Progress, x: Floats, v: Floats, ledger: Floats) -> Progress:
        """Append the next sample; return the updated progress.

        Args:
            progress: State of the step loop.
            x: Positions [m], flat, shape (3 node,).
            v: Velocities [m/s], flat, shape (3 node,).
            ledger: Work and dissipated energy [J], shape (2,).
        """
        buffer = self.buffer
        if progress.filled == buffer.time.size:
            progress = self.flush(progress)
        index = progress.filled
        buffer.time[index] = buffer.times[progress.sample]
        buffer.position[index], buffer.velocity[index], buffer.ledger[index] = x, v, ledger
        buffer.error[index], buffer.reach[index] = progress.error, progress.displacement
        return replace(progress, sample=progress.sample + 1, filled=index + 1)

    def flush(self, progress: Progress) -> Progress:
        """Hand over the samples so far; return the updated progress."""
        parts = [*self._aside, *([self._samples(progress.filled)] if progress.filled else [])]
        self._aside = []
        if len(parts) == 1:
            self._record(parts[0])
        elif parts:
            columns = map(np.concatenate, zip(*parts, strict=True))
            self._record(Samples(*columns))
        return replace(progress, filled=0)

    def _samples(self, count: int) -> Samples:
        """Return the first samples of the buffer."""
        buffer = self.buffer
        return Samples(
            time=buffer.time[:count].copy(),
            position=self._inputs.positions(buffer.position[:count]),
            velocity=self._inputs.outwards(buffer.velocity[:count]),
            work=buffer.ledger[:count, 0].copy(),
            dissipated=buffer.ledger[:count, 1].copy(),
            error=buffer.error[:count].copy(),
            reach=buffer.reach[:count].copy(),
        )
