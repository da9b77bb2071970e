"""One tissue on all meshes at four resolutions: how far its properties spread.

Takes about ten minutes, and needs what the tests need.
"""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import numpy as np

import tissuec
from benchmarks.publishing import publish, tell, write_option
from tests.matter.shapes import as_obj, as_vtk, surface, tetrahedra
from tissuec.core.markdown import table
from tissuec.forces.enclosed.volume import Enclosure
from tissuec.matter.elasticity import Elasticity
from tissuec.mechanics.observables import force_on
from tissuec.mechanics.settling import settle
from tissuec.mechanics.state import State
from tissuec.model.network import Network
from tissuec.model.profiles import TimeProfile

LENGTH, SIDE = 48.0, 16.0  # of bars and sheets [mm]
SCENE = """language 1
tissue gel {
  Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms
  breaking strain = 30 %
}
body piece { mesh is MESH; tissue is gel; rupture is allowed }
set left = nodes of piece where x < 0.01 mm
environment { gravity = (0, 0, 0) m/s^2; DAMPING }
script { at 0 s: SCRIPT }
simulate { duration = 1 s }
"""
BAR = "box from (0, 0, 0) mm to (48, 16, 16) mm"
#: Of each mesh: its name, how it is written for a length of cells, and the lengths [mm].
MESHES = {
    "sheet": (
        "sheet { corner = (0, 0, 0) mm; first edge = (48, 0, 0) mm; "
        "second edge = (0, 16, 0) mm; columns = COLUMNS; rows = ROWS; diagonals is both }; "
        "thickness = 2 mm",
        (8.0, 4.0, 2.0, 1.0),
    ),
    "tube": (
        "tube { axis from (0, 0, 0) mm to (48, 0, 0) mm; radius = 5 mm; rings = COLUMNS; "
        "sides = SIDES; diagonals is both }; thickness = 2 mm",
        (4.0, 2.0, 4 / 3, 1.0),
    ),
    "cubic lattice": (
        "lattice { kind is sodium chloride; reach is second neighbours; cell = CELL mm; "
        f"{BAR} }}",
        (8.0, 4.0, 8 / 3, 2.0),
    ),
    "body-centred lattice": (
        "lattice { kind is caesium chloride; reach is second neighbours; cell = CELL mm; "
        f"{BAR} }}",
        (8.0, 4.0, 8 / 3, 2.0),
    ),
    "diamond lattice": (
        f"lattice {{ kind is diamond; reach is third neighbours; cell = CELL mm; {BAR} }}",
        (8.0, 16 / 3, 4.0, 3.2),
    ),
    "tetrahedra": ('imported { file "bar.vtk" in mm }', (8.0, 4.0, 8 / 3, 2.0)),
    "surface filled with a cubic lattice": (
        'imported { file "bar.obj" in mm; filling is sodium chloride; '
        "reach is second neighbours; cell = CELL mm }",
        (8.0, 4.0, 8 / 3, 2.0),
    ),
    "surface filled with tetrahedra": (
        'imported { file "bar.obj" in mm; filling is tetrahedra; cell = CELL mm }',
        (8.0, 4.0, 8 / 3, 2.0),
    ),
}


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure everything."""
    head = ("mesh", "quantity", "at four resolutions", "spread", "of the two finest")
    publish("meshes", {"meshes": table(head, list(rows()))}, write=write)


def rows() -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table."""
    for name, (mesh, cells) in MESHES.items():
        found = [measured(mesh, cell) for cell in cells]
        for quantity in found[0]:
            yield row(name, quantity, [one[quantity] for one in found])
    yield row("sphere", "pressure inside [Pa]", [pressure(times) for times in (2, 3, 4, 5)])


def row(name: str, quantity: str, values: list[float]) -> tuple[str, ...]:
    """Return a row with the spread of values in per cent."""
    shown = ", ".join(f"{value:.4g}" for value in values)
    spread = (100.0 * (max(part) / min(part) - 1.0) for part in (values, values[-2:]))
    found = (name, quantity, shown, *(f"{value:.1f} %" for value in spread))
    tell(" | ".join(found))
    return found


def measured(mesh: str, cell: float) -> dict[str, float]:
    """Return what a body is at one resolution, by the names of quantities."""
    with TemporaryDirectory() as folder:
        for name, text in files(cell).items():
            Path(folder, name).write_text(text, encoding="utf-8")

        def scene(script: str = "fix left", damping: str = "contact is off") -> Path:
            text = SCENE.replace("MESH", written(mesh, cell))
            path = Path(folder, "piece.tis")
            path.write_text(
                text.replace("SCRIPT", script).replace("DAMPING", damping), encoding="utf-8"
            )
            return path

        (body,) = tissuec.properties(scene(), frequencies=0)
        assert body.elasticity is not None and body.breaking is not None
        compiled = tissuec.compile(scene())
        network = compiled.network
        direction = body.elasticity.directions.index(along(body.elasticity))
        speed = body.wave_speeds[direction]
        lowest = 0.6 * speed / (4e-3 * LENGTH)
        # A tube has many modes that bend its wall below those that stretch it.
        count = 150 if mesh.startswith("tube") else 8
        modes = tissuec.modes(scene(), above=lowest, count=count)
        mass = modes.state.mass
        first = max(modes, key=lambda mode: abs(mass @ mode.shape[:, 0]))
        assert first.frequency is not None and first.damping_ratio is not None
        braked = tissuec.compile(scene(damping="surface damping = 1 Pa*s/m")).network
        assert braked.drag is not None
        return {
            "mass [g]": 1e3 * body.mass,
            "force at 10 % [mN]": 1e3 * stretched(network),
            "wave speed [m/s]": speed,
            "first mode along [Hz]": first.frequency,
            "its decay time [ms]": 1e3 / (2 * np.pi * first.frequency * first.damping_ratio),
            "drag over mass [1/s]": float(braked.drag.sum() / braked.mass.sum()),
            "breaks at, times its length": body.breaking.stretch[1],
        }


def along(elasticity: Elasticity) -> str:
    """Return how the direction along x is called."""
    known = ("x", "along", "first edge")
    return next(name for name in elasticity.directions if name in known)


def stretched(network: Network) -> float:
    """Return the force that draws a body out by a tenth between its clamped ends [N]."""
    state = State.start(network, gravity=np.zeros(3), drag=0.0)
    x = network.position[:, 0]
    ends = x < 1e-5, x > x.max() - 1e-5
    state.holders = {"left": np.flatnonzero(ends[0]), "right": np.flatnonzero(ends[1])}
    state.position[:, 0] *= 1.1
    settle(state, np.ones(len(x), dtype=bool))
    pull = force_on(state, 0.0, state.position, state.velocity, state.holders["left"])
    return float(pull[0])


def written(mesh: str, cell: float) -> str:
    """Return a mesh in the language for a length of its cells [mm]."""
    columns, rows = round(LENGTH / cell) + 1, round(SIDE / cell) + 1
    sides = max(6, round(2 * np.pi * 5.0 / cell))
    for name, value in (("COLUMNS", columns), ("ROWS", rows), ("SIDES", sides)):
        mesh = mesh.replace(name, str(value))
    return mesh.replace("CELL", f"{cell:.15g}")


def files(cell: float) -> dict[str, str]:
    """Return the mesh files of a resolution, by name."""
    sides = np.array([LENGTH, SIDE, SIDE])
    return {
        "bar.vtk": as_vtk(*tetrahedra(sides, cell, 0.15)),
        "bar.obj": as_obj(*surface(sides, cell)),
    }


def pressure(times: int) -> float:
    """Return the pressure [Pa] in a sphere of a wall whose volume grew by a tenth."""
    text = SCENE.replace("; rupture is allowed", "; thickness = 1 mm").replace(
        "MESH", f"sphere {{ centre = (0, 0, 0) mm; radius = 20 mm; subdivisions = {times} }}"
    )
    text = text.replace("set left = nodes of piece where x < 0.01 mm\n", "")
    text = text.replace("SCRIPT", "preserve volume of piece with 1 MPa")
    network = tissuec.compile(text.replace("DAMPING", "contact is off")).network
    state = State.start(network, gravity=np.zeros(3), drag=0.0)
    kept = Enclosure.of(network, "piece", 1e6, network.bodies[0].span)
    state.put(kept.swollen(0.1, TimeProfile("constant", 0.0, np.inf)).block)
    settle(state, np.ones(network.node_count, dtype=bool))
    return float(state.enclosures["piece"].pressures(0.0, state.position)[0])


if __name__ == "__main__":
    main()
