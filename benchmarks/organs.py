"""Elements of wounds, balloons and vibrating bars against felupe.

felupe is an independent library of finite elements. It solves the same laws with hexahedra of
27 nodes on meshes that are finer where stress is large, and the balloon as a ring of
quadrilaterals about its axis. Takes some minutes.
"""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

import click
import numpy as np
from scipy.sparse.linalg import eigsh

import tissuec
from benchmarks.publishing import publish, tell, write_option
from benchmarks.solids import Answers, Solid, between, clamp, solved_by, towards, walls
from tests.forces.solid_cases import CASES, lattice, tetrahedra, text_of
from tests.imports.organs import write_vtk
from tissuec.core.markdown import table
from tissuec.model.network import Floats, Indices

felupe: Any = import_module("felupe")

MESHES = (("hexahedra", 2), ("hexahedra", 4), ("hexahedra", 8), ("tetrahedra", 6))


# --- a wound --------------------------------------------------------------------------------

SKIN, STRETCH = 40.0, 1.25  # Young's modulus [kPa]; of a prestress of 20 %
LONG = 30.0  # half of the skin [mm]; the hole and the slit are 20 mm long, the hole also wide
WOUND = """language 1
tissue skin {
  Young's modulus = 40 kPa; Poisson's ratio = 0.45; density = 1100 kg/m^3; prestress = 20 %
  solid law is neo hookean { volume is quadratic }
}
body flap {
  mesh is imported { file "flap.vtk" in mm; merging is off }
  tissue is skin; prestress along (1, 0, 0)
}
set ends = nodes of flap where x < 0.01 mm or x > 59.99 mm
environment {
  gravity = (0, 0, 0) m/s^2
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)
}
script { at 0 s: { fix ends; settle } }
simulate { duration = 1 us; integrator is dop853 }
output { trajectory every 1 us }
"""


def wound(shape: str, across: int, folder: Path) -> Answers:
    """Return how far wounds of 20 mm in stretched skin open [mm].

    Args:
        shape: "hexahedra" or "tetrahedra".
        across: Cells along a wound.
        folder: Of the scene.
    """
    return {
        name: _opened(*_skin(across, name), shape, across, folder) for name in ("slit", "hole")
    }


def _opened(x: Floats, cells: Indices, shape: str, across: int, folder: Path) -> float:
    """Return by how much the middles of both lips move apart [mm], on the surface."""
    if shape == "tetrahedra":
        cells = _divided(x, cells, across)
    write_vtk(folder / "flap.vtk", x, cells)
    (folder / "wound.tis").write_text(WOUND, encoding="utf-8")
    with tissuec.run(folder / "wound.tis", companion="off") as run:
        drawn, now = 1e3 * run.network.position, 1e3 * run.position[-1]
    lips = np.flatnonzero((np.abs(drawn[:, 1:] - (0.0, 10.0)) < 1e-9).all(axis=1))
    lips = lips[np.argsort(np.abs(drawn[lips, 0] - LONG), kind="stable")[:2]]
    return float(np.ptp(now[lips, 0]) - np.ptp(drawn[lips, 0]))


def _up_to(last: int) -> Indices:
    return np.arange(last + 1)


def _skin(across: int, name: str) -> tuple[Floats, Indices]:
    """Return a quarter of the skin [mm]; both lips of a slit have nodes of their own."""
    cell = 20.0 / across
    counts = np.array([3 * across, across, across // 2])
    grid = np.stack(np.meshgrid(*map(_up_to, counts.tolist()), indexing="ij"), axis=-1)
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:-1])
    corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    ways = [*corners, *((i, j, 1) for i, j, _ in corners)]
    cells = np.stack(
        [number[tuple(slice(w, w + n) for w, n in zip(way, counts, strict=True))].ravel()
         for way in ways], axis=1,
    )  # fmt: skip
    x: Floats = cell * grid.reshape(-1, 3).astype(np.float64)
    centre = x[cells].mean(axis=1)
    if name == "hole":
        is_lost = (np.abs(centre[:, 0] - LONG) < 10.0) & (centre[:, 1] < 10.0)
        return _used(x, cells[~is_lost])
    lip = np.flatnonzero(np.isclose(x[:, 0], LONG) & (x[:, 1] < 10.0 - 1e-9))
    other = np.arange(len(x))
    other[lip] = len(x) + np.arange(len(lip))
    right = centre[:, 0] > LONG
    return np.concatenate([x, x[lip]]), np.where(right[:, None], other[cells], cells)


def _used(x: Floats, cells: Indices) -> tuple[Floats, Indices]:
    """Return the nodes that cells use, and the cells with these."""
    used, place = np.unique(cells, return_inverse=True)
    return x[used], place.reshape(cells.shape)


def _divided(x: Floats, cells: Indices, across: int) -> Indices:
    """Return hexahedra divided into six tetrahedra each, mirrored."""
    orders = [(a, b, 3 - a - b) for a in range(3) for b in range(3) if a != b]
    paths = np.array([[np.eye(3, dtype=int)[list(order[:k])].sum(axis=0) for k in range(4)]
                      for order in orders])  # fmt: skip
    low = np.round(x[cells[:, 0]] * across / 20.0).astype(int)[:, None, None]
    at = np.where(low % 2 == 0, paths, 1 - paths)
    corner = np.array([[0, 4], [3, 7], [1, 5], [2, 6]]).reshape(2, 2, 2)
    which = corner[at[..., 0], at[..., 1], at[..., 2]]
    return np.take_along_axis(cells[:, None], which, axis=2).reshape(-1, 4)


class Prestretched:
    """A law of the library for a material that is stretched along x as drawn."""

    def __init__(self, law: Any):
        self._law, self.x = law, law.x
        self.stretch_by(1.0)

    def stretch_by(self, stretch: float) -> None:
        """Set the stretch."""
        self._first = np.diag([stretch, stretch**-0.5, stretch**-0.5])

    def _of(self, x: Any) -> list[Any]:
        return [np.einsum("iK...,KJ->iJ...", x[0], self._first), *x[1:]]

    def gradient(self, x: Any) -> list[Any]:
        """Return P relative to the drawn shape [kPa]."""
        found, *more = self._law.gradient(self._of(x))
        return [np.einsum("iK...,KJ->iJ...", found, self._first), *more]

    def hessian(self, x: Any) -> list[Any]:
        """Return its derivative [kPa]."""
        found = self._law.hessian(self._of(x))[0]
        return [np.einsum("iMkN...,MJ,NL->iJkL...", found, self._first, self._first)]


def wound_by_library(factor: int) -> Answers:
    """Return the same from an eighth of the skin, by elements along half of a wound."""
    far = LONG - towards(LONG, factor)[::-1]
    hole = np.concatenate([towards(10.0, factor), 10.0 + far[1:] * (1.0 - 10.0 / LONG)])
    y = np.concatenate([towards(10.0, factor), 20.0 - towards(10.0, factor)[-2::-1]])
    found: Answers = {}
    for name, x in (("slit", far), ("hole", hole)):
        mesh = felupe.Grid(x, y, towards(10.0, factor))
        centre = mesh.points[mesh.cells].mean(axis=1)
        is_lost = (centre[:, 0] < 10.0) & (centre[:, 1] < 10.0) & (name == "hole")
        mesh = felupe.Mesh(*_used(mesh.points, mesh.cells[~is_lost]), "hexahedron")
        law = Prestretched(felupe.NeoHooke(mu=SKIN / 2.9, bulk=SKIN / 0.3))
        solid = Solid(CASES["cube, ν = 0.45"], mesh, law)
        lip = np.array([10.0 if name == "hole" else 0.0, 0.0, 10.0])
        whole = np.isclose(solid.x[:, 0], 0.0) & (solid.x[:, 1] > 10.0 - 1e-9)
        held = walls(solid, "yz") | {("whole", 0): (whole, 0.0)}
        held |= clamp(np.isclose(solid.x[:, 0], LONG), np.zeros(3), "end")
        for stretch in np.linspace(1.0, STRETCH, 6)[1:]:
            law.stretch_by(stretch)
            solid.balance(held)
        middle = np.flatnonzero((np.abs(solid.x - lip) < 1e-9).all(axis=1))
        found[name] = 2.0 * float(solid.moved()[middle[0], 0])
    return found


# --- a balloon ------------------------------------------------------------------------------

BALLOON = """language 1
tissue rubber {{ Young's modulus = 300 kPa; Poisson's ratio = 0.4997; density = 1000 kg/m^3 }}
body balloon {{
  made of elements
  mesh is sphere {{ centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = {subdivisions} }}
  tissue is rubber; thickness = 0.1 mm
}}
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: preserve volume of balloon with 3 MPa
  at 0 s: {{ inflate balloon to 1.2^3 * {drawn} ml; settle }}
  at 1 ms: {{ inflate balloon to 1.4^3 * {drawn} ml; settle }}
  at 2 ms: {{ inflate balloon to 2^3 * {drawn} ml; settle }}
}}
simulate {{ duration = 3 ms; integrator is dop853 }}
output {{ pressure of balloon every 1 ms; volume of balloon every 1 ms }}
"""
WIDE = (1.2, 1.4, 2.0)


def balloon(subdivisions: int) -> Answers:
    """Return the pressures at prescribed volumes [Pa]."""
    still = BALLOON.format(subdivisions=subdivisions, drawn=1.0).split("script")[0]
    end = "simulate { duration = 1 us }\noutput { volume of balloon every 1 us }\n"
    with tissuec.run(still + end, companion="off") as run:
        drawn = 1e6 * run.logs["volume of balloon"].value[0].item()
    text = BALLOON.format(subdivisions=subdivisions, drawn=f"{drawn:.12g}")
    with tissuec.run(text, companion="off") as run:
        assert run.finished
        pressure = run.logs["pressure of balloon"].value[:3].ravel()
    return {f"{wide:g} times as wide": float(p) for wide, p in zip(WIDE, pressure, strict=True)}


def balloon_by_library(factor: int) -> Answers:
    """Return the same from a ring of nine-node quadrilaterals, from pole to equator."""
    inner, middle, outer = 9.95, 10.0, 10.05
    mesh = felupe.Grid(np.linspace(inner, outer, 3), np.linspace(0.0, 0.5 * np.pi, factor + 1))
    mesh = mesh.add_midpoints_edges().add_midpoints_faces()
    radius, angle = mesh.points.T
    x = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    mesh.update(points=x)
    region = felupe.RegionBiQuadraticQuad(mesh)
    field = felupe.FieldContainer([felupe.FieldAxisymmetric(region, dim=2)])
    shear, bulk = 300.0 / 2.0 / 1.4997, 300.0 / 3.0 / (1.0 - 2.0 * 0.4997)
    body = felupe.SolidBody(felupe.NeoHooke(mu=shear, bulk=bulk), field)
    held = np.isclose(radius, inner)
    found: Answers = {}
    for wide in WIDE:
        size = np.cbrt((wide**3 - 1.0) * middle**3 + inner**3)
        moved = (size / inner - 1.0) * x[held]
        # Newton's method begins where the volume is kept.
        now = np.cbrt((wide**3 - 1.0) * middle**3 + radius**3)
        field[0].values[:] = (now / radius - 1.0)[:, None] * x
        bounds = {
            "equator": felupe.Boundary(field[0], mask=np.isclose(x[:, 0], 0.0), skip=[0, 1]),
            "axis": felupe.Boundary(field[0], mask=np.isclose(x[:, 1], 0.0), skip=[1, 0]),
            "x": felupe.Boundary(field[0], mask=held, skip=[0, 1], value=moved[:, 0]),
            "y": felupe.Boundary(field[0], mask=held, skip=[1, 0], value=moved[:, 1]),
        }
        free = felupe.dof.partition(field, bounds)
        values = felupe.dof.apply(field, bounds, free[0])
        felupe.newtonraphson(
            items=[body], dof0=free[0], dof1=free[1], ext0=values, solver=solved_by,
            verbose=0, tol=1e-7, maxiter=30,
        )  # fmt: skip
        force = body.assemble.vector(field).toarray().reshape(-1, 2)[held]
        push = float((force * x[held]).sum()) / inner
        found[f"{wide:g} times as wide"] = 1e3 * push / (2.0 * np.pi * size**2)
    return found


# --- modes ----------------------------------------------------------------------------------


def _named(frequency: Floats) -> Answers:
    """Return the first five frequencies [Hz] by names; bending occurs in pairs."""
    first, _, *three = np.sort(frequency)[:5]
    pair = int(three[2] - three[1] < three[1] - three[0])
    return {
        "bending": float(first), "second bending": float(three[pair]),
        "torsion": float(three[0] if pair else three[2]),
    }  # fmt: skip


def modes(shape: str, across: int, folder: Path) -> Answers:
    """Return frequencies of the cantilever [Hz]."""
    case = CASES["cantilever"]
    mesh = lattice(case, across) if shape == "hexahedra" else tetrahedra(case, across, folder)
    scene = folder / "modes.tis"
    scene.write_text(
        text_of(case, mesh, (0.0,)).replace("at 1 us: settle", ""), encoding="utf-8"
    )
    return _named(np.array([mode.frequency for mode in tissuec.modes(scene, count=6)]))


def modes_by_library(factor: int) -> Answers:
    """Return the same from the whole bar, with elements across it."""
    x = 60.0 * np.linspace(0.0, 1.0, 3 * factor + 1) ** 1.3
    solid = Solid(CASES["cantilever"], [x, *[between(10.0, factor, 1.3)] * 2])
    body = felupe.SolidBody(solid.body.umat, solid.field, density=1e-6)  # [kg/mm³]
    free = np.flatnonzero(np.repeat(~np.isclose(solid.x[:, 0], 0.0), 3))
    stiff, mass = (
        each.tocsc()[free][:, free] for each in (body.assemble.matrix(), body.assemble.mass())
    )
    squares: Floats = cast(Any, eigsh)(stiff, 6, mass, sigma=0.0)[0]
    return _named(np.sqrt(squares) / (2.0 * np.pi))


# --- tables ---------------------------------------------------------------------------------


def rows() -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table of blocks: errors of whole runs."""
    for name, unit, own, by_library in (
        ("wound", "mm", wound, wound_by_library), ("modes", "Hz", modes, modes_by_library),
    ):  # fmt: skip
        coarse, known = by_library(2), by_library(4)
        changes = {k: f"{100.0 * (v / coarse[k] - 1.0):+.2f} %" for k, v in known.items()}
        tell(f"{name}: {known}, changed by {changes}")
        with TemporaryDirectory() as folder:
            found = [own(shape, across, Path(folder)) for shape, across in MESHES]
        for shown, due in known.items():
            errors = [f"{100.0 * (each[shown] / due - 1.0):+.1f} %" for each in found]
            yield name, shown, f"{due:.4g} {unit}", *errors
            tell(" | ".join((name, shown, f"{due:.4g} {unit}", *errors)))


def balloon_rows() -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table of the balloon: pressures, and their errors."""
    coarse, known = balloon_by_library(8), balloon_by_library(16)
    tell(f"balloon: {coarse}, {known}")
    found = [balloon(subdivisions) for subdivisions in (1, 2, 3)]
    for shown, due in known.items():
        errors = [f"{100.0 * (each[shown] / due - 1.0):+.1f} %" for each in found]
        yield shown, f"{due:.1f} Pa", *errors


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Compare everything."""
    tables = {
        "blocks": (("case", "", "felupe", *(f"{n} {shape}" for shape, n in MESHES)), rows),
        "balloon": (("balloon", "felupe", "42 nodes", "162 nodes", "642 nodes"), balloon_rows),
    }  # fmt: skip
    made = {name: table(heads, list(lines())) for name, (heads, lines) in tables.items()}
    publish("organs", made, write=write)


if __name__ == "__main__":
    main()
