"""Time of the forces of hexahedra in blocks of several sizes.

Medians of processor times. Takes a minute.
"""

import time
from statistics import median

import click
import numpy as np

from benchmarks.force_costs import SOLID, STEP, compiled_scene
from benchmarks.publishing import publish, write_option
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.markdown import table
from tissuec.engine.engine import Engine
from tissuec.engine.method import Method

REPEATS = 15
EVALUATIONS = 2e5  # of one element, in one measurement
CELLS = (12, 24, 47)


class _Engine:
    def __init__(self, compiled: Compiled):
        self.state = state_at_start(compiled)
        method = Method("velocity verlet", None, STEP, 1.0, threads=1)
        self.engine = Engine(
            self.state.network, method, np.zeros(0), lambda samples: None, backend="compiled"
        )
        self.until = STEP
        self.engine.advance(self.state, self.until)

    def seconds(self, steps: int) -> float:
        """Return the processor time of an evaluation [s]."""
        before = self.engine.statistics.evaluations
        self.until += steps * STEP
        begun = time.process_time()
        self.engine.advance(self.state, self.until)
        spent = time.process_time() - begun
        return spent / (self.engine.statistics.evaluations - before)


def measure(cells: int) -> list[str]:
    """Return a row of the table."""
    compiled = compiled_scene(
        {"mesh": SOLID["mesh"].replace("24, 24, 24", ", ".join([str(2 * cells)] * 3))}
    )
    count, steps = cells**3, max(4, int(EVALUATIONS / cells**3))
    engine = _Engine(compiled)
    engine.seconds(4)
    found = median(engine.seconds(steps) for _ in range(REPEATS))
    return [f"{cells}³", str(count), f"{1e9 * found / count:.0f} ns"]


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure blocks of elements."""
    rows = [measure(cells) for cells in CELLS]
    heads = ("block", "hexahedra", "time")
    publish("hexahedra", {"hexahedra": table(heads, rows)}, write=write)


if __name__ == "__main__":
    main()
