"""Scenes of solid elements whose answers an independent library knows, and what is read there.

Whole runs: every load is applied at once and followed by ``settle``, so that the run is a
series of equilibria. A motion takes 1 us and is settled at once; frames are 1 us later.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from msgspec import Struct

import tissuec
from tests.imports.organs import write_vtk
from tissuec.results.trajectory import Trajectory

BAR = (60.0, 10.0, 10.0)  # [mm]
CUBE = (20.0, 20.0, 20.0)
SLAB = (40.0, 40.0, 20.0)
SCENE = """language 1
tissue gel {{
  solid law is neo hookean {{ volume is quadratic }}  # as that of the references
  Young's modulus = {young} kPa; Poisson's ratio = {poisson}; density = 1000 kg/m^3
}}
tissue hard like gel {{ Young's modulus = 100 kPa }}
body piece {{
  mesh is {mesh}
  tissue is gel; made of elements
  {region}
}}
set near = nodes of piece where {axis} < 0.01 mm
set far = nodes of piece where {axis} > {end} mm
environment {{ gravity = (0, 0, {gravity}) m/s^2 }}
script {{
  {script}
}}
simulate {{ duration = {duration} us; integrator is dop853 }}
output {{ trajectory every 2 us; force of far every 2 us; torque of far every 2 us }}
"""


class Case(Struct, frozen=True):
    """A load series on a block, and the quantity that is compared.

    Attributes:
        name: In tables and in the file of references.
        sides: Of the block [mm].
        unit: Of the quantity.
        steps: Loads one behind the other, as a part of the script or its variable part.
        shown: Numbers of the steps that are compared, and what they are called.
        measure: Quantity in a trajectory at a frame.
        verb: Sentence of the script for a step.
        start: Orders at 0 s.
        across: Side that the cells are counted along [mm].
        young: [kPa].
        poisson: Poisson's ratio.
        axis: From the held end to the other.
        region: More of the body.
        gravity: [m/s²].
    """

    name: str
    sides: tuple[float, float, float]
    unit: str
    steps: tuple[float, ...]
    shown: dict[int, str]
    measure: Callable[[Trajectory, int], float]
    verb: str = "move far by (0, 0, -{:.12g}) mm using constant speed"
    start: str = "fix near; hold far"
    across: float = 20.0
    young: float = 10.0
    poisson: float = 0.3
    axis: str = "z"
    region: str = ""
    gravity: float = 0.0


def pushed(run: Trajectory, frame: int) -> float:
    """Return the force that holds the far end down [mN]."""
    return -1e3 * float(run.logs["force of far"].value[frame, 2])


def drawn(run: Trajectory, frame: int) -> float:
    """Return the force that draws the far end [mN]."""
    return 1e3 * float(run.logs["force of far"].value[frame, 0])


def twisted(run: Trajectory, frame: int) -> float:
    """Return the torque that turns the far end [mN mm]."""
    return 1e6 * float(run.logs["torque of far"].value[frame, 0])


def lowered(run: Trajectory, frame: int) -> float:
    """Return by how much the centre of the far end has sunk [mm].

    A mean of nodes would weigh the edges of the end too much.
    """
    far = run.nodes_of("far")
    drawn = run.network.position[far]
    middle = np.argmin(
        np.linalg.norm(drawn - 0.5 * (drawn.min(axis=0) + drawn.max(axis=0)), axis=1)
    )
    centre = far[middle]
    return 1e3 * float(run.network.position[centre, 2] - run.position[frame, centre, 2])


def _cube(poisson: float) -> Case:
    return Case(
        f"cube, ν = {poisson:g}", CUBE, "mN", (0.2, 0.8, *[1.0] * 7),
        {0: "1 %", 4: "20 %", 8: "40 %"}, pushed, poisson=poisson,
    )  # fmt: skip


CASES = {
    case.name: case
    for case in (
        *(_cube(poisson) for poisson in (0.3, 0.45, 0.49)),
        Case("cantilever", BAR, "mm", (0.5, 1.8, 4.7), {0: "0.5 mN", 1: "2.3 mN", 2: "7 mN"},
             lowered, "push far with (0, 0, -{:.12g}) mN", "fix near", across=10.0, axis="x"),
        Case("torsion", BAR, "mN mm", (5.0, 15.0, 20.0, 20.0), {0: "5°", 3: "60°"}, twisted,
             "turn far by {:.12g} deg around (1, 0, 0) using constant speed", across=10.0,
             axis="x"),
        Case("two layers", SLAB, "mN", (0.2, 0.8, 1.0, 1.0, 1.0), {0: "1 %", 4: "20 %"}, pushed,
             region="region top where z > 10 mm { tissue is hard }"),
        Case("own weight", CUBE, "mm", (0.0,), {0: "1 g"}, lowered, "", "fix near", young=1.0,
             poisson=0.45, gravity=-9.81),
        Case("drawn bar, ν = 0.499", BAR, "mN", (0.6, 5.4, 6.0), {0: "1 %", 2: "20 %"}, drawn,
             "move far by ({:.12g}, 0, 0) mm using constant speed", across=10.0, poisson=0.499,
             axis="x"),
    )
}  # fmt: skip


def text_of(case: Case, mesh: str, steps: tuple[float, ...] | None = None) -> str:
    """Return a scene.

    Args:
        mesh: Of the body, in the language.
        steps: Others than those of the case.
    """
    steps = case.steps if steps is None else steps
    orders = [f"at 0 s: {{ {case.start} }}"]
    for k, step in enumerate(steps):
        when = (
            f"from {2 * k} us to {2 * k + 1} us" if "using" in case.verb else f"at {2 * k} us"
        )
        orders += [f"{when}: {case.verb.format(step)}"] * bool(case.verb)
        orders.append(f"at {2 * k + 1} us: settle")
    return SCENE.format(
        young=case.young, poisson=case.poisson, mesh=mesh, region=case.region, axis=case.axis,
        end=case.sides["xyz".index(case.axis)] - 0.01, gravity=case.gravity,
        script="\n  ".join(orders), duration=2 * len(steps),
    )  # fmt: skip


def lattice(case: Case, cells: int) -> str:
    """Return a lattice in the language, with cells across a side."""
    to = ", ".join(f"{side:g}" for side in case.sides)
    cell = case.across / cells
    return f"lattice {{ cell = {cell:.12g} mm; box from (0, 0, 0) mm to ({to}) mm }}"


def tetrahedra(case: Case, cells: int, folder: Path) -> str:
    """Return a mesh file in the language: cubes divided into six tetrahedra, mirrored.

    Faces of neighbours match, and no direction of bending is preferred.
    """
    counts = [round(cells * side / case.across) for side in case.sides]
    grid = np.stack(
        np.meshgrid(*map(np.arange, (n + 1 for n in counts)), indexing="ij"), axis=-1
    )
    position = grid.reshape(-1, 3) * (case.across / cells)
    orders = [(a, b, 3 - a - b) for a in range(3) for b in range(3) if a != b]
    paths = np.array([[np.eye(3, dtype=int)[list(order[:k])].sum(axis=0) for k in range(4)]
                      for order in orders])  # fmt: skip
    low = grid[:-1, :-1, :-1].reshape(-1, 1, 1, 3)
    corners = np.where(low % 2 == 0, low + paths, low + 1 - paths)
    strides = np.array([(counts[1] + 1) * (counts[2] + 1), counts[2] + 1, 1])
    path = folder / f"{case.sides[0]:g}_{case.sides[2]:g}_{cells}.vtk"
    write_vtk(path, position, (corners @ strides).reshape(-1, 4))
    return f'imported {{ file "{path.name}" in mm }}'


def answers(case: Case, shape: str, cells: int, folder: Path) -> dict[str, float]:
    """Return the quantity of a case at the steps that are compared, by a whole run.

    Args:
        shape: "hexahedra" or "tetrahedra".
        cells: Across a side; tetrahedra have a node more between.
        folder: Of the scene.
    """
    mesh = lattice(case, cells) if shape == "hexahedra" else tetrahedra(case, cells, folder)
    scene = folder / "solid.tis"
    scene.write_text(text_of(case, mesh), encoding="utf-8")
    with tissuec.run(scene, companion="off") as run:
        assert run.finished
        return {shown: case.measure(run, k + 1) for k, shown in case.shown.items()}
