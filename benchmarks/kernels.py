"""Time of an evaluation of the forces, beside a plain loop in C over the springs.

Takes some minutes and needs a C compiler (cc). Engine and loop take turns, and medians of times
of the processor are shown, because other work on the machine slows down both.
"""

import ctypes
import subprocess
import tempfile
import time
from pathlib import Path
from statistics import median

import click
import numpy as np

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
from tissuec.core.markdown import table

PLAIN = Path(__file__).with_name("plain.c")


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure all nets."""
    with tempfile.TemporaryDirectory() as folder:
        plain = compile_plain(Path(folder))
        rows = [measure(net, plain) for net in (*nets(), irregular_net())]
    heads = ("net", "nodes", "springs", "C loop", *METHODS)
    publish("kernels", {"kernels": table(heads, rows)}, write=write)


def compile_plain(folder: Path) -> ctypes.CDLL:
    """Return the loop in C, compiled for this processor."""
    library = folder / "plain.so"
    flags = ["-O3", "-march=native", "-fno-math-errno", "-shared", "-fPIC"]
    subprocess.run(["cc", *flags, "-o", str(library), str(PLAIN), "-lm"], check=True)
    return ctypes.CDLL(str(library))


def measure(net: Net, plain: ctypes.CDLL) -> list[str]:
    """Return a row: nanoseconds for each spring and evaluation, everything included."""
    compiled = build(net)
    runs = {method: Stepping(compiled, method) for method in METHODS}
    loop = Loop(plain, runs[METHODS[0]])
    times: dict[str, list[float]] = {name: [] for name in ("C loop", *METHODS)}
    for _ in range(REPEATS):
        times["C loop"].append(loop.time())
        for method, run in runs.items():
            times[method].append(run.time(time.process_time))
    nodes, springs = compiled.network.node_count, compiled.network.spring_count
    best = median(times["C loop"])
    shown = [f"{median(times[m]):.2f} ({median(times[m]) / best:.2f})" for m in METHODS]
    return [net.name, str(nodes), str(springs), f"{best:.2f}", *shown]


class Loop:
    """The loop in C on the springs of an engine, which computes what the engine does."""

    def __init__(self, plain: ctypes.CDLL, run: Stepping):
        stepper = run.engine.stepper
        inputs, work = stepper.inputs, stepper.work
        springs, nodes = inputs.springs, len(inputs.inverse_mass)
        self.evaluate, now = plain.evaluate, stepper.progress.current
        # Copied, because what is the same for all springs takes no room there.
        numbers = map(np.array, (springs.stiffness, springs.damping, springs.rest))
        self.arrays = [
            np.searchsorted(springs.low, np.arange(nodes + 1)).astype(np.int64),
            (3 * springs.high).astype(np.int32),
            *numbers, inputs.inverse_mass, work.x[now].copy(), work.v[now].copy(),
            np.zeros(3 * nodes),
        ]  # fmt: skip
        self.springs, self.nodes = len(springs.ids), nodes
        self.time()
        # Those of the engine belong to velocities that are predicted.
        within = 1e-3 * np.abs(work.a[now]).max()
        np.testing.assert_allclose(self.arrays[-1], work.a[now], atol=within)

    def time(self) -> float:
        """Return nanoseconds for each spring and evaluation."""
        times = max(4, int(WORK / self.springs))
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in self.arrays]
        begun = time.process_time()
        self.evaluate(ctypes.c_long(times), ctypes.c_long(self.nodes), *pointers)
        return (time.process_time() - begun) / times / self.springs * 1e9


if __name__ == "__main__":
    main()
