"""Whole runs of solid elements against felupe, an independent library of finite elements.

felupe solves the same law with hexahedra of 27 nodes on meshes that become finer towards the
edges of clamped ends. Takes a quarter of an hour, and needs what the tests need.
"""

import json
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from benchmarks.publishing import publish, tell, write_option
from tests.forces import solid_cases
from tests.forces.solid_cases import CASES, Case, answers
from tissuec.core.markdown import table
from tissuec.model.network import Floats

KNOWN = Path(solid_cases.__file__).with_name("solid_references.json")
MESHES = (("hexahedra", 2), ("hexahedra", 4), ("tetrahedra", 2), ("tetrahedra", 3))
GRAVITY = 9.81
Answers = dict[str, float]
Held = dict[tuple[str, int], tuple[NDArray[np.bool_], Any]]


class Solid:
    """A block of 27-node hexahedra of the library, in mm, kPa and mN.

    Args:
        case: Its material.
        axes: Places of the corners of elements [mm], three of shape (corner,); or a mesh of the
            library.
        law: Of the library; by default, the neo-Hookean one of the case.
        is_mixed: Whether pressure and volume are unknowns of their own, which lets answers
            converge where little can change its volume.
    """

    def __init__(
        self,
        case: Case,
        axes: Sequence[Floats] | Any,
        law: Any = None,
        *,
        is_mixed: bool = False,
    ):
        self.felupe: Any = import_module("felupe")
        mesh = self.felupe.Grid(*axes) if isinstance(axes, Sequence) else axes
        if mesh.cell_type == "tetra10":
            region = self.felupe.RegionQuadraticTetra(mesh)
        else:
            for add in ("edges", "faces", "volumes"):
                mesh = getattr(mesh, f"add_midpoints_{add}")()
            region = self.felupe.RegionTriQuadraticHexahedron(mesh)
        field = self.felupe.Field(region, dim=3)
        self.field: Any = self.felupe.FieldContainer([field])
        if is_mixed:
            self.field = self.felupe.FieldsMixed(region, n=3)
        self.x: Floats = mesh.points
        if law is None:
            high = self.x[mesh.cells][:, :8, 2].mean(axis=1) > 10.0
            young = np.where(high & bool(case.region), 100.0, case.young)
            shear = young / 2.0 / (1.0 + case.poisson)
            bulk = young / 3.0 / (1.0 - 2.0 * case.poisson)
            law = self.felupe.NeoHooke(mu=shear, bulk=None if is_mixed else bulk)
            if is_mixed:
                law = self.felupe.NearlyIncompressible(law, bulk=bulk)
        self.body: Any = self.felupe.SolidBody(law, self.field)
        self.end: NDArray[np.bool_] = np.isclose(
            self.x[:, "xyz".index(case.axis)], case.sides["xyz".index(case.axis)]
        )

    def moved(self) -> Floats:
        """Return the displacements [mm], shape (node, 3)."""
        return self.field[0].values

    def forces(self) -> Floats:
        """Return the forces that hold the nodes [mN], shape (node, 3)."""
        found = self.body.assemble.vector(self.field).toarray().ravel()
        return found[: self.x.size].reshape(-1, 3)

    def balance(self, held: Held, *more: Any) -> None:
        """Find the equilibrium.

        Args:
            held: Nodes and displacements [mm], by a name and a component.
            more: Loads.
        """
        bounds: dict[str, Any] = {}
        for (name, axis), (mask, value) in held.items():
            skip = [int(k != axis) for k in range(3)]
            bounds[f"{name} {axis}"] = self.felupe.Boundary(
                self.field[0], mask=mask, skip=skip, value=value
            )
        free = self.felupe.dof.partition(self.field, bounds)
        values = self.felupe.dof.apply(self.field, bounds, free[0])
        self.felupe.newtonraphson(
            items=[self.body, *more], dof0=free[0], dof1=free[1], ext0=values,
            solver=solved_by, verbose=0, tol=1e-9, maxiter=30,
        )  # fmt: skip


def solved_by(matrix: Any, force: Any) -> Floats:
    """Return the solution of linear equations."""
    factor = splu(
        csc_matrix(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )  # fmt: skip
    return factor.solve(np.asarray(force).ravel())


def towards(end: float, count: int, power: float = 2.0) -> Floats:
    """Return corners from 0 to an end, closer there."""
    return end * (1.0 - (1.0 - np.linspace(0.0, 1.0, count + 1)) ** power)


def between(end: float, count: int, power: float = 1.5) -> Floats:
    """Return corners from 0 to an end, closer at both; the count is even."""
    half = towards(0.5 * end, count // 2, power)
    return np.concatenate([0.5 * end - half[::-1], 0.5 * end + half[1:]])


def walls(solid: Solid, axes: str) -> Held:
    """Return planes of symmetry through the origin."""
    return {("wall", k): (np.isclose(solid.x[:, k], 0.0), 0.0) for k in map("xyz".index, axes)}


def clamp(mask: NDArray[np.bool_], moved: Floats, name: str) -> Held:
    """Return an end that is held at displacements [mm], shape (3,) or (node, 3)."""
    moved = np.broadcast_to(moved, (int(mask.sum()), 3))
    return {(name, k): (mask, moved[:, k]) for k in range(3)}


# --- the cases -------------------------------------------------------------------------------


def strained(case: Case, factor: int, sign: float) -> Answers:
    """Move the ends of a block, an eighth of which is computed.

    Args:
        case: The block.
        factor: Elements along half of a short side.
        sign: Of the strain.
    """
    counts = [factor * (2 if side > 40.0 else 1) for side in case.sides]
    axes = [towards(0.5 * s, n) for s, n in zip(case.sides, counts, strict=True)]
    solid = Solid(case, axes, is_mixed=case.poisson > 0.3)
    axis = "xyz".index(case.axis)
    half = 0.5 * case.sides[axis]
    solid.end = np.isclose(solid.x[:, axis], half)
    found: list[float] = []
    for strain in (0.01, 0.05, 0.1, 0.15, 0.2):
        way = np.eye(3)[axis] * sign * strain * half
        solid.balance(walls(solid, "xyz") | clamp(solid.end, way, "end"))
        found.append(4.0 * sign * float(solid.forces()[solid.end, axis].sum()))
    return {"1 %": found[0], "20 %": found[-1]}


def cube(case: Case, factor: int) -> Answers:
    """Compress a cube between plates that stick."""
    return strained(case, factor, -1.0)


def simpson(corners: Floats, places: Floats) -> Floats:
    """Return the weights of nodes at places for a sum along a side, by Simpson's rule."""
    nodes = np.sort(np.concatenate([corners, 0.5 * (corners[1:] + corners[:-1])]))
    weight, size = np.zeros(len(nodes)), np.diff(corners) / 6.0
    weight[:-1:2] += size
    weight[1::2] += 4.0 * size
    weight[2::2] += size
    return weight[np.abs(nodes - places[:, None]).argmin(axis=1)]


def cantilever(case: Case, factor: int) -> Answers:
    """Bend half of a bar by a load that is spread evenly over its end."""
    y, z = towards(5.0, factor // 2, 1.5), between(10.0, factor)
    solid = Solid(case, [60.0 * np.linspace(0.0, 1.0, 2 * factor + 1) ** 1.5, y, z])
    tip = np.flatnonzero(solid.end)
    share = simpson(y, solid.x[tip, 1]) * simpson(z, solid.x[tip, 2])
    centre = tip[np.argmin(np.abs(solid.x[tip, 1]) + np.abs(solid.x[tip, 2] - 5.0))]
    held = walls(solid, "y") | clamp(np.isclose(solid.x[:, 0], 0.0), np.zeros(3), "root")
    found: list[float] = []
    for load in (0.5, 1.4, 2.3, 3.8, 5.4, 7.0):
        values = np.outer(share / share.sum(), [0.0, 0.0, -0.5 * load])
        solid.balance(held, solid.felupe.PointLoad(solid.field, tip, values=values))
        found.append(-float(solid.moved()[centre, 2]))
    return {"0.5 mN": found[0], "2.3 mN": found[2], "7 mN": found[-1]}


def torsion(case: Case, factor: int) -> Answers:
    """Turn one end of a bar, which cannot warp."""
    solid = Solid(case, [between(60.0, 3 * factor), *[between(10.0, factor, 1.3)] * 2])
    root = clamp(np.isclose(solid.x[:, 0], 0.0), np.zeros(3), "root")
    arm = (solid.x[solid.end] - 5.0) * (0.0, 1.0, 1.0)
    found: list[float] = []
    for angle in np.deg2rad([5.0, 30.0, 60.0]):
        side = np.cross((1.0, 0.0, 0.0), arm)
        turned = np.cos(angle) * arm + np.sin(angle) * side
        solid.balance(root | clamp(solid.end, turned - arm, "end"))
        found.append(float(np.cross(turned, solid.forces()[solid.end])[:, 0].sum()))
    return {"5°": found[0], "60°": found[-1]}


def layers(case: Case, factor: int) -> Answers:
    """Press a quarter of a slab of two layers."""
    z = between(10.0, factor, 2.0)
    solid = Solid(case, [*[towards(20.0, factor)] * 2, np.concatenate([z, 10.0 + z[1:]])])
    base = clamp(np.isclose(solid.x[:, 2], 0.0), np.zeros(3), "base")
    found: list[float] = []
    for strain in (0.01, 0.05, 0.1, 0.15, 0.2):
        top = clamp(solid.end, np.array([0.0, 0.0, -20.0 * strain]), "top")
        solid.balance(walls(solid, "xy") | base | top)
        found.append(-4.0 * float(solid.forces()[solid.end, 2].sum()))
    return {"1 %": found[0], "20 %": found[-1]}


def weight(case: Case, factor: int) -> Answers:
    """Let a quarter of a block sag."""
    z = 20.0 * np.linspace(0.0, 1.0, 2 * factor + 1) ** 2
    solid = Solid(case, [*[towards(10.0, factor)] * 2, z])
    base = clamp(np.isclose(solid.x[:, 2], 0.0), np.zeros(3), "base")
    for part in (0.5, 1.0):
        pull = np.array([0.0, 0.0, -1e-3 * GRAVITY * part])  # [mN/mm³]
        solid.balance(
            walls(solid, "xy") | base, solid.felupe.SolidBodyForce(solid.field, values=pull)
        )
    top = np.flatnonzero(solid.end)
    centre = top[np.argmin(solid.x[top, 0] + solid.x[top, 1])]
    return {"1 g": -float(solid.moved()[centre, 2])}


def drawn(case: Case, factor: int) -> Answers:
    """Draw a bar between ends that cannot become narrower."""
    return strained(case, factor, 1.0)


SOLVED = {"cantilever": cantilever, "torsion": torsion, "two layers": layers,
          "own weight": weight, "drawn bar, ν = 0.499": drawn}  # fmt: skip


# --- tables ----------------------------------------------------------------------------------


def solved() -> dict[str, Answers]:
    """Return the answers of the library, after telling how far they have converged."""
    known: dict[str, Answers] = {}
    for name, case in CASES.items():
        coarse, known[name] = (SOLVED.get(name, cube)(case, factor) for factor in (2, 4))
        change = {k: f"{100 * (v / coarse[k] - 1):+.2f} %" for k, v in known[name].items()}
        tell(f"{name}: {known[name]}, changed by {change}")
    return known


def rows(known: dict[str, Answers]) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table: errors of whole runs."""
    for name, case in CASES.items():
        with TemporaryDirectory() as folder:
            found = [
                answers(case, shape, cells, Path(folder))
                for shape, cells in MESHES
                if shape == "hexahedra" or not case.region
            ]
        for shown, due in known[name].items():
            errors = [f"{100 * (one[shown] / due - 1.0):+.1f} %" for one in found]
            line = (name, shown, f"{due:.4g} {case.unit}", *errors)
            yield (*line, *[""] * (3 + len(MESHES) - len(line)))
            tell(" | ".join(line))


@click.command(help=__doc__)
@click.option("--library", is_flag=True, help="Let the library compute its answers anew.")
@write_option
def main(*, library: bool, write: bool) -> None:
    """Compare everything."""
    start = process_time()
    known: dict[str, Answers] = json.loads(KNOWN.read_text(encoding="utf-8"))
    if library:
        known = solved()
        tell(f"the library took {process_time() - start:.0f} s")
        if write:
            text = json.dumps(known, indent=2, ensure_ascii=False)
            KNOWN.write_text(text + "\n", encoding="utf-8")
    heads = ("case", "load", "felupe", *(f"{cells} {shape}" for shape, cells in MESHES))
    publish("solids", {"felupe": table(heads, list(rows(known)))}, write=write)


if __name__ == "__main__":
    main()
