"""Time of an evaluation of the forces, beside two loops in C over the springs.

One does a spring after the other, and one those in runs by vector instructions. Takes some
minutes and needs a C compiler (cc). Engine and loops take turns, and medians of times of the
processor are shown, because other work on the machine slows down all.
"""

import ctypes
import subprocess
import tempfile
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from benchmarks.publishing import publish, write_option
from benchmarks.stepping import (
    METHODS,
    REPEATS,
    WORK,
    Net,
    Stepping,
    build,
    irregular_net,
    nets,
)
from tissuec.compiled.record_tables import LINE, aligned_zeros
from tissuec.core.markdown import table
from tissuec.forces.springs.runs_kernel import LANES, NO_SPRING
from tissuec.model.network import Floats

LOOPS = Path(__file__).with_name("loops.c")


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure all nets."""
    with tempfile.TemporaryDirectory() as folder:
        loops = compile_loops(Path(folder))
        rows = [measure(net, loops) for net in (*nets(), irregular_net())]
    heads = ("net", "nodes", "springs", "C loop", "C vectors", *METHODS)
    publish("kernels", {"kernels": table(heads, rows)}, write=write)


def compile_loops(folder: Path) -> ctypes.CDLL:
    """Return the loops in C, compiled for this processor."""
    library = folder / "loops.so"
    flags = ["-O3", "-march=native", "-fno-math-errno", "-shared", "-fPIC"]
    subprocess.run(["cc", *flags, "-o", str(library), str(LOOPS), "-lm"], check=True)
    return ctypes.CDLL(str(library))


def measure(net: Net, loops: ctypes.CDLL) -> list[str]:
    """Return a row: nanoseconds for each spring and evaluation, everything included."""
    compiled = build(net)
    runs = {method: Stepping(compiled, method) for method in METHODS}
    first = runs[METHODS[0]]
    timed = {"C loop": Loop(loops.one_by_one, *one_by_one(first), first).time}
    if first.engine.stepper.inputs.acting.places.is_worthwhile:
        timed["C vectors"] = Loop(loops.in_runs, *in_runs(first), first).time
    for method, run in runs.items():
        timed[method] = partial(run.time, time.process_time)
    times: dict[str, list[float]] = {name: [] for name in timed}
    for _ in range(REPEATS):
        for name, take in timed.items():
            times[name].append(take())
    nodes, springs = compiled.network.node_count, compiled.network.spring_count
    found = {name: median(each) for name, each in times.items()}
    best = found["C loop"]
    shown = [f"{found[m]:.2f} ({found[m] / best:.2f})" for m in METHODS]
    vectors = f"{found['C vectors']:.2f}" if "C vectors" in found else "-"
    return [net.name, str(nodes), str(springs), f"{best:.2f}", vectors, *shown]


class Loop:
    """A loop in C on the springs of an engine, which computes what the engine does.

    Args:
        evaluate: The loop, which takes how often, numbers, and arrays.
        numbers: The numbers.
        arrays: The arrays; the last one is set to accelerations [m/s²].
        places: Where those of all nodes are in it, shape (3 node,).
        run: The engine with its state.
    """

    def __init__(
        self,
        evaluate: Any,
        numbers: Sequence[int],
        arrays: Sequence[NDArray[Any]],
        places: NDArray[np.integer],
        run: Stepping,
    ):
        self.evaluate, self.numbers, self.arrays = evaluate, numbers, arrays
        stepper = run.engine.stepper
        self.springs = len(stepper.inputs.springs.ids)
        self.time()
        # Those of the engine belong to velocities that are predicted.
        expected = stepper.work.a[stepper.progress.current]
        within = 1e-3 * np.abs(expected).max()
        np.testing.assert_allclose(arrays[-1][places], expected, atol=within)

    def time(self) -> float:
        """Return nanoseconds for each spring and evaluation."""
        times = max(4, int(WORK / self.springs))
        numbers = [ctypes.c_long(number) for number in (times, *self.numbers)]
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in self.arrays]
        begun = time.process_time()
        self.evaluate(*numbers, *pointers)
        return (time.process_time() - begun) / times / self.springs * 1e9


Arguments = tuple[list[int], list[NDArray[Any]], NDArray[np.integer]]


def one_by_one(run: Stepping) -> Arguments:
    """Return what ``Loop`` takes for springs one after the other."""
    stepper = run.engine.stepper
    inputs, work, now = stepper.inputs, stepper.work, stepper.progress.current
    springs, nodes = inputs.springs, len(inputs.inverse_mass)
    # Copied, because what is the same for all springs takes no room there.
    numbers = map(np.array, (springs.stiffness, springs.damping, springs.rest))
    arrays = [
        np.searchsorted(springs.ends[:, 0], np.arange(nodes + 1)).astype(np.int64),
        (3 * springs.ends[:, 1]).astype(np.int32),
        *numbers, inputs.inverse_mass, work.x[now].copy(), work.v[now].copy(),
        np.zeros(3 * nodes),
    ]  # fmt: skip
    return [nodes], arrays, np.arange(3 * nodes)


def in_runs(run: Stepping) -> Arguments:
    """Return what ``Loop`` takes for springs in runs."""
    stepper = run.engine.stepper
    inputs, work, now = stepper.inputs, stepper.work, stepper.progress.current
    springs, found, nodes = inputs.springs, inputs.acting.places, len(inputs.inverse_mass)
    row = (nodes + 2 * LANES) // LINE * LINE + LINE

    def filled(values: Floats, nothing: float) -> Floats:
        whole = aligned_zeros(found.size)
        whole.fill(nothing)
        whole[found.place] = values
        return whole

    def apart(vector: Floats) -> Floats:
        rows = aligned_zeros(3, row)
        rows[:, :nodes] = vector.reshape(-1, 3).T
        return rows.ravel()

    arrays = [
        found.first, found.first + found.offset, found.length, found.at,
        filled(springs.stiffness, 0.0), filled(springs.damping, 0.0),
        filled(springs.rest, NO_SPRING), inputs.inverse_mass,
        apart(work.x[now]), apart(work.v[now]), aligned_zeros(3 * row),
    ]  # fmt: skip
    places = (np.arange(nodes)[:, None] + row * np.arange(3)).ravel()
    return [nodes, row, len(found.first)], arrays, places


if __name__ == "__main__":
    main()
