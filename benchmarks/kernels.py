"""Measure what a spring and each feature costs, and write it into ``numerics.md``.

    python benchmarks/kernels.py

takes some minutes and needs a C compiler (``cc``). Engine and the plain loop in C take turns,
and medians are shown, because other work on the machine slows down both.
"""

import ctypes
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
from msgspec import Struct

from tissuec.core.markdown import replace_places, table
from tissuec.core.source import Source
from tissuec.engine.engine import Engine
from tissuec.engine.method import Method
from tissuec.integrators import INTEGRATORS
from tissuec.pipeline import Request, compile_request
from tissuec.prediction import situation_at_start

PAGE = Path(__file__).resolve().parent.parent / "docs" / "numerics.md"
REPEATS = 7
WORK = 4e7  # evaluations times springs of one measurement
METHODS = ("velocity verlet", "dop853")
PLAIN = """
#include <math.h>
void evaluate(long times, long nodes, const long *first, const int *other, const double *c,
              const double *d, const double *rest, const double *inverse, const double *x,
              const double *v, double *a) {
  for (long t = 0; t < times; t++) {
    for (long i = 0; i < 3 * nodes; i++) a[i] = 0.0;
    for (long n = 0; n < nodes; n++) {
      const double *xi = x + 3 * n, *vi = v + 3 * n;
      double f0 = 0, f1 = 0, f2 = 0;
      for (long s = first[n]; s < first[n + 1]; s++) {
        const double *xj = x + other[s], *vj = v + other[s];
        double r0 = xj[0] - xi[0], r1 = xj[1] - xi[1], r2 = xj[2] - xi[2];
        double length = sqrt(r0 * r0 + r1 * r1 + r2 * r2), over = 1.0 / (length + 1e-200);
        double w = (r0 * (vj[0] - vi[0]) + r1 * (vj[1] - vi[1]) + r2 * (vj[2] - vi[2])) * over;
        double tension = (c[s] * (length - rest[s]) + d[s] * w) * over;
        double *aj = a + other[s];
        f0 += tension * r0; f1 += tension * r1; f2 += tension * r2;
        aj[0] -= tension * r0; aj[1] -= tension * r1; aj[2] -= tension * r2;
      }
      a[3 * n] += f0; a[3 * n + 1] += f1; a[3 * n + 2] += f2;
    }
    for (long n = 0; n < nodes; n++)
      for (long k = 3 * n; k < 3 * n + 3; k++) a[k] *= inverse[n];
  }
}
"""


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
      prestress = 1 %; fraction force = 1 kN; {tissue} }}
    body block {{ {net.body}; tissue is flesh; rupture is allowed; {body} }}
    environment {{ gravity = (0, 0, 0) m/s^2; {around} }}
    {more}
    simulate {{ duration = 1000 s; tolerance = 1e-3 }}
    """


def main() -> int:
    """Measure all and write the tables."""
    with tempfile.TemporaryDirectory() as folder:
        plain = compile_plain(Path(folder))
        rows = [measure(net, plain) for net in nets()]
    shared = [gain(net) for net in nets()[2:]]
    page = PAGE.read_text(encoding="utf-8")
    heads = ("net", "nodes", "springs", "C loop", *METHODS)
    contents = {
        "kernels": table(heads, rows),
        "threads": table(("net", "springs", *METHODS), shared),
        "skipping": skipping(nets()[0], nets()[2]),
    }
    PAGE.write_text(replace_places(page, contents, mark="timed"), encoding="utf-8")
    return 0


def compile_plain(folder: Path) -> ctypes.CDLL:
    """Return the loop in C, compiled for this processor."""
    source, library = folder / "plain.c", folder / "plain.so"
    source.write_text(PLAIN, encoding="utf-8")
    flags = ["-O3", "-march=native", "-fno-math-errno", "-shared", "-fPIC"]
    subprocess.run(["cc", *flags, "-o", str(library), str(source), "-lm"], check=True)
    return ctypes.CDLL(str(library))


def measure(net: Net, plain: ctypes.CDLL) -> list[str]:
    """Return a row: nanoseconds for each spring and evaluation, everything included."""
    compiled, _ = compile_request(Request(Source("net.tis", scene(net))))
    runs = {method: Stepping(compiled, method) for method in METHODS}
    loop = Loop(plain, runs[METHODS[0]])
    times: dict[str, list[float]] = {name: [] for name in ("C loop", *METHODS)}
    for _ in range(REPEATS):
        times["C loop"].append(loop.time())
        for method, run in runs.items():
            times[method].append(run.time())
    nodes, springs = compiled.network.node_count, compiled.network.spring_count
    best = median(times["C loop"])
    shown = [f"{median(times[m]):.2f} ({median(times[m]) / best:.2f})" for m in METHODS]
    return [net.name, str(nodes), str(springs), f"{best:.2f}", *shown]


def gain(net: Net) -> list[str]:
    """Return a row: how many times as fast two threads are as one, the medians of pairs."""
    compiled, _ = compile_request(Request(Source("net.tis", scene(net))))
    shown = []
    for method in METHODS:
        one, two = (Stepping(compiled, method, threads=threads) for threads in (1, 2))
        shown.append(f"{median(one.time() / two.time() for _ in range(REPEATS)):.2f}")
    return [net.name, str(compiled.network.spring_count), *shown]


class Stepping:
    """An engine on a net, compiled, that can be timed again and again."""

    def __init__(
        self,
        compiled,
        method: str,
        *,
        watched: bool = False,
        ledger: bool = False,
        threads: int = 1,
    ):
        self.network = compiled.network
        self.situation = situation_at_start(compiled)
        # Just below the limit, so that every step is like the others.
        omega = 3e3
        step = 0.1 * INTEGRATORS[method].stability_limit(omega, 0.0)
        self.evaluations = INTEGRATORS[method].evaluations
        self.step = step
        asked = Method(
            method, None, step, 1e3, ledger=ledger, watch_strength=watched, threads=threads
        )
        self.engine = Engine(
            self.network, asked, np.zeros(0), lambda samples: None, tier="compiled"
        )
        self.until = 2.0 * step
        self.engine.advance(self.situation, self.until)

    def time(self) -> float:
        """Return nanoseconds for each spring and evaluation of a few more steps."""
        springs = self.network.spring_count
        steps = max(4, int(WORK / springs / self.evaluations))
        self.until += steps * self.step
        before = self.engine.statistics.evaluations
        begun = time.perf_counter()
        self.engine.advance(self.situation, self.until)
        took = time.perf_counter() - begun
        return took / (self.engine.statistics.evaluations - before) / springs * 1e9


class Loop:
    """The loop in C on the arrays of an engine."""

    def __init__(self, plain: ctypes.CDLL, run: Stepping):
        net = run.engine._acting()
        self.evaluate = plain.evaluate
        x, v = run.engine._work.x[0], run.engine._work.v[0]
        self.arrays = [
            net.first.astype(np.int64), net.other.astype(np.int32), net.stiffness, net.damping,
            net.rest, net.inverse_mass, x.copy(), v.copy(), np.zeros_like(x),
        ]  # fmt: skip
        self.springs, self.nodes = len(net.rest), len(net.inverse_mass)

    def time(self) -> float:
        """Return nanoseconds for each spring and evaluation."""
        times = max(4, int(WORK / self.springs))
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in self.arrays]
        begun = time.perf_counter()
        self.evaluate(ctypes.c_long(times), ctypes.c_long(self.nodes), *pointers)
        return (time.perf_counter() - begun) / times / self.springs * 1e9


class Feature(Struct, frozen=True):
    """Something that a scene may have, as what is added to the text of the plain scene.

    Attributes:
        name: What it is called in the table.
        entries: Of ``scene``.
        script: Sentences that switch it on at 0 s.
        watched, ledger: What the engine is asked for besides.
        closed: Whether it needs cells, which the tube has not.
    """

    name: str
    entries: dict[str, str]
    script: str = ""
    watched: bool = False
    ledger: bool = False
    closed: bool = False


#: Above tube and lattices, out of reach.
PROBE = "tool probe { kind is probe; radius = 1 cm; centre = (1, 1, 60) cm }"
BELOW = "tool floor { kind is plane; point = (0, 0, -3.0) mm; normal = (0, 0, 1) }"
NOZZLE = """tool nozzle {
  kind is nozzle; diameter = 4 mm; tip = (3, 0.5, 40) cm; direction = (0, 0, -1)
}"""
FEATURES = (
    Feature("no viscosity", {"viscosity": "0 N*s/m"}),
    Feature("rupture", {}, watched=True),
    Feature("energies", {}, ledger=True),
    Feature("law `exponential`", {"tissue": "spring law is exponential { stiffening = 12 }"}),
    Feature("free formula", {"tissue": "spring force of e = c * e + 40 kN/m^3 * e^3"}),
    Feature(
        "relaxing branch", {"tissue": "relaxing constant = 100 N/m; relaxation time = 1 s"}
    ),
    Feature("yield", {"tissue": "yield force = 1 N; yield viscosity = 10 N*s/m"}),
    Feature("volume of cells", {}, script="preserve volume of block with 10 kPa", closed=True),
    Feature("a tool far away", {"around": "contact is tools only", "more": PROBE}),
    Feature("a floor that is touched", {"around": "contact is tools only", "more": BELOW}),
    Feature("and friction", {"around": "contact is tools only; friction = 0.3", "more": BELOW}),
    Feature("`bodies too`, one body", {"around": "contact is bodies too"}),
    Feature("`everywhere`", {"around": "contact is everywhere"}),
    Feature("a jet", {"more": NOZZLE}, script="irrigate with 5 ml/s through nozzle"),
)


def skipping(*chosen: Net) -> str:
    """Return the table of what features cost where a scene has them."""
    rows = [["nothing besides", *(["1"] * len(chosen))]]
    rows += [[feature.name] for feature in FEATURES]
    for net in chosen:
        plain = stepping(net, Feature("", {}))
        for row, feature in zip(rows[1:], FEATURES, strict=True):
            if feature.closed and net.name == "tube":
                row.append("")
                continue
            run = stepping(net, feature)
            ratios = [run.time() / plain.time() for _ in range(REPEATS)]
            row.append(f"{median(ratios):.2f}")
            print(net.name, *row, flush=True)
    return table(("scene", *(net.name for net in chosen)), rows)


def stepping(net: Net, feature: Feature) -> Stepping:
    """Return an engine on a net with a feature."""
    entries = dict(feature.entries)
    if feature.script:
        entries["more"] = entries.get("more", "") + f"\nscript {{ at 0 s: {feature.script} }}"
    compiled, _ = compile_request(Request(Source("net.tis", scene(net, **entries))))
    return Stepping(compiled, METHODS[0], watched=feature.watched, ledger=feature.ledger)


if __name__ == "__main__":
    sys.exit(main())
