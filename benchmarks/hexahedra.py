"""Time of the forces of hexahedra compared with a loop in C, and with two threads.

The loop computes the same formulas for elements of one shape, and nothing else. Engine and loop
take turns; medians of processor times, and of ratios. Takes a minute, and needs a C compiler
(cc) and two processors.
"""

import ctypes
import tempfile
import time
from pathlib import Path
from statistics import median

import click
import numpy as np

from benchmarks.force_costs import SOLID, STEP, compiled_scene
from benchmarks.kernels import compile_loops
from benchmarks.publishing import publish, write_option
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.markdown import table
from tissuec.engine.engine import Engine
from tissuec.engine.method import Method
from tissuec.forces.solids.elements import SolidElements

REPEATS = 15
EVALUATIONS = 2e5  # of one element, in one measurement
CELLS = (12, 24, 47)


class Hexahedra:
    """A block of hexahedra, whose forces are computed by the engine and by the loop in C."""

    def __init__(self, cells: int, loops: ctypes.CDLL):
        mesh = SOLID["mesh"].replace("24, 24, 24", f"{2 * cells}, {2 * cells}, {2 * cells}")
        compiled = compiled_scene({"mesh": mesh})
        self.state = state_at_start(compiled)
        (self.field,) = (
            block.field
            for block in self.state.present_blocks
            if isinstance(block.field, SolidElements)
        )
        self.count = len(self.field.nodes)
        self.one, self.two = (_Engine(compiled, threads) for threads in (1, 2))
        self._loop, random = loops.hexahedra, np.random.default_rng(1)
        moved = self.state.position + 1e-4 * random.standard_normal(self.state.position.shape)
        shape, points = self.field.drawn, self.field.drawn.volume.shape[1]
        moduli = np.array([self.field.shear[0], self.field.bulk[0], self.field.local[0]])
        self._arrays = [
            self.field.nodes.astype(np.int64),
            np.ascontiguousarray(shape.gradients[0]).reshape(points, -1),
            np.ascontiguousarray(shape.volume[0]), moduli, np.ascontiguousarray(moved),
            np.zeros_like(moved),
        ]  # fmt: skip
        self.loop()
        expected = np.zeros_like(moved)
        self.field.add_forces(0.0, moved, np.zeros_like(moved), expected)
        np.testing.assert_allclose(
            self._arrays[-1], expected, atol=1e-12 * np.abs(expected).max()
        )

    def loop(self) -> float:
        """Return the processor time of the loop in C for each element [s]."""
        times = max(1, int(EVALUATIONS / self.count))
        numbers = [ctypes.c_long(n) for n in (times, self.count, self.state.network.node_count)]
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in self._arrays]
        begun = time.process_time()
        self._loop(*numbers, *pointers)
        return (time.process_time() - begun) / times / self.count


class _Engine:
    def __init__(self, compiled: Compiled, threads: int):
        self.state = state_at_start(compiled)
        method = Method("velocity verlet", None, STEP, 1.0, threads=threads)
        self.engine = Engine(
            self.state.network, method, np.zeros(0), lambda samples: None, backend="compiled"
        )
        self.until = STEP
        self.engine.advance(self.state, self.until)

    def seconds(self, steps: int, *, of_processor: bool) -> float:
        """Return the time of an evaluation [s]."""
        before = self.engine.statistics.evaluations
        self.until += steps * STEP
        clock = time.process_time if of_processor else time.perf_counter
        begun = clock()
        self.engine.advance(self.state, self.until)
        return (clock() - begun) / (self.engine.statistics.evaluations - before)


def measure(cells: int, loops: ctypes.CDLL) -> list[str]:
    """Return a row of the table."""
    block = Hexahedra(cells, loops)
    steps = max(4, int(EVALUATIONS / block.count))
    block.one.seconds(4, of_processor=True)
    block.two.seconds(4, of_processor=True)
    engine, loop, gain = list[float](), list[float](), list[float]()
    for _ in range(REPEATS):
        engine.append(1e9 * block.one.seconds(steps, of_processor=True) / block.count)
        loop.append(1e9 * block.loop())
        one, two = (e.seconds(steps, of_processor=False) for e in (block.one, block.two))
        gain.append(one / two)
    ratio = median(a / b for a, b in zip(engine, loop, strict=True))
    shown = [f"{median(loop):.0f} ns", f"{median(engine):.0f} ns ({ratio:.2f})"]
    return [f"{cells}³", str(block.count), *shown, f"{median(gain):.2f}"]


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure blocks of elements."""
    with tempfile.TemporaryDirectory() as folder:
        loops = compile_loops(Path(folder))
        rows = [measure(cells, loops) for cells in CELLS]
    heads = ("block", "hexahedra", "C loop", "engine", "two threads")
    publish("hexahedra", {"hexahedra": table(heads, rows)}, write=write)


if __name__ == "__main__":
    main()
