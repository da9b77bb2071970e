"""Nets that shiver, and engines on them that are timed again and again."""

import time
from collections.abc import Callable

import numpy as np
from msgspec import Struct

from tissuec.compiler.compile import Compiled
from tissuec.compiler.prediction import state_at_start
from tissuec.core.source import Source
from tissuec.engine.engine import Engine
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method import Method
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

REPEATS = 41  # short and many: what else the machine does comes and goes
WORK = 4e6  # evaluations times springs of one measurement
METHODS = ("velocity verlet", "dop853")


class Net(Struct, frozen=True):
    """A net to measure: its name and the body of its scene."""

    name: str
    body: str


def nets() -> list[Net]:
    """Return the tube of the paper and lattices of growing size."""
    tube = """mesh is tube {
      axis from (0, 0, 0) mm to (64, 0, 0) mm
      radius = 3 mm; rings = 16; sides = 10; interior is crossed
    }"""
    blocks = [
        Net(
            f"lattice {n}³",
            f"""mesh is lattice {{
              kind is sodium chloride; cell = 1 cm; reach is second neighbours
              box from (0, 0, 0) cm to ({n - 1}, {n - 1}, {n - 1}) cm
            }}""",
        )
        for n in (10, 22, 46)
    ]
    return [Net("tube", tube), *blocks]


def scene(
    net: Net,
    *,
    viscosity: str = "10 mN*s/m",
    tissue: str = "",
    body: str = "",
    around: str = "contact is off",
    more: str = "",
) -> str:
    """Return the text of a scene in which the net shivers."""
    return f"""language 1
    tissue flesh {{ spring constant = 500 N/m; viscosity = {viscosity}; mass = 1 g;
      prestress = 1 %; breaking force = 1 kN; {tissue} }}
    body block {{ {net.body}; tissue is flesh; rupture is allowed; {body} }}
    environment {{ gravity = (0, 0, 0) m/s^2; {around} }}
    {more}
    simulate {{ duration = 1000 s; tolerance = 1e-3 }}
    """


def build(net: Net, **entries: str) -> Compiled:
    """Return the scene of a net, compiled; see ``scene`` for further entries."""
    return compile_request(Request(Source("net.tis", scene(net, **entries))))[0]


class Stepping:
    """An engine on a net, by compiled kernels, that can be timed again and again."""

    def __init__(
        self,
        compiled: Compiled,
        method: str,
        *,
        watched: bool = False,
        ledger: bool = False,
        threads: int = 1,
    ):
        self.network = compiled.network
        self.state = state_at_start(compiled)
        # Just below the limit, so that every step is like the others.
        omega = 3e3
        step = 0.1 * INTEGRATORS[method].stability_limit(omega, 0.0)
        self.evaluations = INTEGRATORS[method].evaluations
        self.step = step
        asked = Method(
            method, None, step, 1e3, ledger=ledger, watch_strength=watched, threads=threads
        )
        self.engine = Engine(
            self.network, asked, np.zeros(0), lambda samples: None, backend="compiled"
        )
        self.until = 2.0 * step
        self.engine.advance(self.state, self.until)

    def time(self, clock: Callable[[], float] = time.perf_counter) -> float:
        """Return nanoseconds for each spring and evaluation of a few more steps.

        Args:
            clock: Returns a time [s].
        """
        springs = self.network.spring_count
        steps = max(4, int(WORK / springs / self.evaluations))
        self.until += steps * self.step
        before = self.engine.statistics.evaluations
        begun = clock()
        self.engine.advance(self.state, self.until)
        took = clock() - begun
        return took / (self.engine.statistics.evaluations - before) / springs * 1e9
