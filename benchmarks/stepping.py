"""Nets that shiver, and engines on them that are timed again and again."""

import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from msgspec import Struct
from scipy.spatial import Delaunay

from tissuec.compiler.compile import Compiled
from tissuec.compiler.prediction import state_at_start
from tissuec.core.source import Source
from tissuec.engine.engine import Engine
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method import Method
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

REPEATS = 21  # short and many: what else the machine does comes and goes
WORK = 2e7  # evaluations times springs of one measurement
METHODS = ("velocity verlet", "dop853")


class Net(Struct, frozen=True):
    """A net to measure.

    Attributes:
        name: As tables show it.
        body: Of its scene.
        mesh: Writes the file that the body imports, if it does.
    """

    name: str
    body: str
    mesh: Callable[[Path], None] | None = None


MESH = "mesh.vtk"


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
        for n in (10, 22, 46, 100)
    ]
    return [Net("tube", tube), *blocks]


def irregular_net() -> Net:
    """Return tetrahedra between points near those of a grid, numbered at random."""
    body = f'mesh is imported {{ file "{MESH}" in m }}'
    return Net("tetrahedra", body, write_tetrahedra)


def write_tetrahedra(path: Path, side: int = 24, cell: float = 0.004) -> None:
    """Write a mesh of tetrahedra in the legacy format of VTK.

    Args:
        path: Of the file.
        side: Points along each edge of the block.
        cell: Distance of points, which are moved by up to a quarter of it [m].
    """
    random = np.random.default_rng(1)
    grid = np.stack(np.meshgrid(*3 * [np.arange(side)], indexing="ij"), -1).reshape(-1, 3)
    points = random.permutation(cell * (grid + random.uniform(-0.25, 0.25, grid.shape)))
    cells = Delaunay(points).simplices
    with path.open("w", encoding="ascii") as file:
        file.write("# vtk DataFile Version 3.0\ntetrahedra\nASCII\nDATASET UNSTRUCTURED_GRID\n")
        file.write(f"POINTS {len(points)} double\n")
        np.savetxt(file, points, "%.9f")
        file.write(f"CELLS {len(cells)} {5 * len(cells)}\n")
        np.savetxt(file, np.insert(cells, 0, 4, axis=1), "%d")
        file.write(f"CELL_TYPES {len(cells)}\n" + "10\n" * len(cells))


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
    if net.mesh is None:
        return compile_request(Request(Source("net.tis", scene(net, **entries))))[0]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "net.tis"
        path.write_text(scene(net, **entries), encoding="utf-8")
        net.mesh(path.with_name(MESH))
        return compile_request(Request.file(path))[0]


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
