"""Elements that break within steps: looked for in each step, and located as springs are.

Their loads (``forces.element_limits``) are no part of the forces of a step. They are found at
states within it that are interpolated without evaluating forces, and only where one of them
comes close to a limit, on its dense output.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissuec.compiled.calls import kernel_on
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.step_events import AcceptedStep, parabola_tops
from tissuec.engine.stepper import Stepper
from tissuec.kernels.records import GLANCES
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:  # scenes without elements do not need them
    from tissuec.forces.element_limits import BreakableElements

FINE_LOOKS = 8  # of methods whose steps are long
MARGIN = 0.999  # of a limit: loads above which a step is examined closely
_STILL = np.zeros(0)


class Loads:
    """The loads of the elements of a state that can break, divided by their limits.

    Args:
        shapes: Intact elements, shape by shape.
        place: Index of each node in flat arrays, shape (node,).
    """

    def __init__(self, shapes: "Sequence[BreakableElements]", place: Indices):
        self._shapes, self._place = shapes, place
        self._calls: list[tuple[Callable[..., None], int]] = [
            (kernel_on(each.kernel, each.table(place)), len(each.limits.marks))
            for each in shapes
        ]
        marks = [each.limits.marks for each in shapes]
        self.marks: Indices = np.concatenate([np.zeros(0, dtype=np.int64), *marks])

    @classmethod
    def of(cls, inputs: KernelInputs) -> "Loads | None":
        """Return those of the present state; None where no element can break."""
        shapes = (field.breakable for field in inputs.state.fields)
        able = [each for each in shapes if each is not None]
        return cls(able, inputs.layout.place) if able else None

    def at(self, x: Floats) -> Floats:
        """Return the loads, shape (element,); ``x`` are flat positions [m], shape (3 node,)."""
        found = np.empty(len(self.marks))
        first = 0
        for (call, count), shape in zip(self._calls, self._shapes, strict=True):
            own = found[first : first + count]
            call(0.0, x, _STILL, own, _STILL)
            if not shape.is_coded():
                # Nodes of elements keep their places; hidden ones may have none any more.
                position = x.reshape(-1, 3).take(self._place, axis=0, mode="clip")
                np.maximum(own, shape.by_energy(position), out=own)
            first += count
        return found

    def some(self, chosen: Indices) -> "Loads":
        """Return some of them, by ascending indices of shape (n,)."""
        found: list[BreakableElements] = []
        first = 0
        for each in self._shapes:
            count = len(each.limits.marks)
            own = chosen[(chosen >= first) & (chosen < first + count)] - first
            if len(own):
                found.append(each.some(own))
            first += count
        return Loads(found, self._place)


class LoadedElements:
    """Limits of elements within an accepted step; the interface is that of ``Limits``.

    Attributes:
        force: What loads are compared with: 1, shape (element,).
    """

    def __init__(self, loads: Loads):
        self._loads = loads
        self.force = np.ones(len(loads.marks))

    def __len__(self) -> int:
        return len(self.force)

    @property
    def springs(self) -> Indices:
        """Return the springs that die with them, shape (element,)."""
        return self._loads.marks

    def loads(self, within: AcceptedStep, when: float) -> Floats:
        """Return the loads at a time in a step [s], shape (element,)."""
        return self._loads.at(within.state(when)[0])

    def some(self, chosen: NDArray[np.bool_] | list[int]) -> "LoadedElements":
        """Return a selection, by a mask of shape (element,) or by indices."""
        return LoadedElements(self._loads.some(np.arange(len(self.force))[chosen]))


def may_break(loads: Loads, stepper: Stepper, start: Floats, steps: int) -> bool:
    """Return whether an element may break in the last steps that were glanced at.

    Args:
        loads: The loads.
        stepper: It has computed states within the steps.
        start: Positions at the start of the first of them [m], flat, shape (3 node,).
        steps: How many of the last ones.
    """
    glanced: Any = stepper.buffer.buffer.glance_position
    last = stepper.progress.glanced
    # Shorter steps are examined in their middle and at their end.
    every = 2 if stepper.integrator.looks < FINE_LOOKS else 1
    rows = range(last - GLANCES * steps + every - 1, last, every)
    seen = np.array([loads.at(x) for x in (start, *(glanced[row] for row in rows))])
    return bool((parabola_tops(seen[:-2], seen[1:-1], seen[2:]) > MARGIN).any())
