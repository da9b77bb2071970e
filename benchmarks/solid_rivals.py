"""Equilibria of solids by felupe, NGSolve or MuJoCo, in a separate process without tissuec.

Reads a JSON object from the command line and prints one. Lengths are in mm, moduli in kPa and
forces in mN.
"""

import json
import sys
from importlib import import_module
from math import prod
from resource import RUSAGE_SELF, getrusage
from typing import Any

import numpy as np

SETTLED = 1e-5  # speed of a flex at rest [m/s], and 1e-7 m within 50 ms
LONGEST = 60.0  # time that it has for it [s]
FLEX = """<mujoco>
  <option timestep="{step}" gravity="0 0 0" integrator="discrete"/>
  <size memory="500M"/>
  <worldbody>
    <flexcomp name="bar" type="grid" count="{counts}" spacing="{cell} {cell} {cell}" dim="3"
              radius="1e-4" mass="{mass}">
      <elasticity young="{young}" poisson="{poisson}" damping="1"/>
      <contact selfcollide="none" contype="0" conaffinity="0"/>
      <pin gridrange="0 0 0 0 {last} {last}"/>
    </flexcomp>
  </worldbody>
</mujoco>"""


class Ball:
    """A rigid ball on the nodes of the top of a block: a penalty per area, without friction.

    Args:
        field: Of felupe.
        sole: Nodes of the top, shape (n,).
        area: That each represents [mm²], shape (n,).
        radius: [mm].
        firm: Pressure per depth [kPa/mm].
    """

    def __init__(self, field: Any, sole: Any, area: Any, radius: float, firm: float):
        felupe: Any = import_module("felupe")
        self.field, self.sole, self.area = field, sole, area
        self.radius, self.firm, self.bottom = radius, firm, 0.0
        self.drawn = field.region.mesh.points[sole]
        self.results = felupe.mechanics._helpers.Results()
        self.assemble = felupe.mechanics._helpers.Assemble(
            vector=self.vector, matrix=self.matrix
        )

    def press(self) -> tuple[Any, Any, Any]:
        """Return depths [mm], directions out of the ball, and distances from its centre."""
        away = (
            self.drawn + self.field[0].values[self.sole] - (0.0, 0.0, self.bottom + self.radius)
        )
        distance = np.linalg.norm(away, axis=1)
        return np.maximum(self.radius - distance, 0.0), away / distance[:, None], distance

    def vector(self, field: Any = None, **_: Any) -> Any:
        """Return what is added to the internal forces [mN]."""
        sparse: Any = import_module("scipy.sparse")
        depth, out, _ = self.press()
        force = np.zeros_like(self.field[0].values)
        force[self.sole] = -(self.firm * self.area * depth)[:, None] * out
        return sparse.csr_matrix(force.reshape(-1, 1))

    def matrix(self, field: Any = None, **_: Any) -> Any:
        """Return the derivatives of these forces [mN/mm]."""
        sparse: Any = import_module("scipy.sparse")
        depth, out, distance = self.press()
        along = out[:, :, None] * out[:, None, :]
        stiff, touches = self.firm * self.area, depth > 0.0
        block = stiff[:, None, None] * (
            touches[:, None, None] * along
            - (depth / distance)[:, None, None] * (np.eye(3) - along)
        )
        place = 3 * self.sole[:, None] + np.arange(3)
        rows = np.broadcast_to(place[:, :, None], block.shape).ravel()
        columns = np.broadcast_to(place[:, None, :], block.shape).ravel()
        size = self.field[0].values.size
        return sparse.csr_matrix((block.ravel(), (rows, columns)), shape=(size, size))


def by_felupe(case: dict[str, Any]) -> float:
    """Return the answer on hexahedra of 8 nodes with mean volumes, or of 27 nodes.

    Args:
        case: ``kind``, bending, twist or indentation; ``sides``, ``young``, ``poisson``,
            ``order`` 1 or 2, ``cells`` across 10 mm, or 4 mm of an indentation, and ``steps``
            of the load.
    """
    felupe: Any = import_module("felupe")
    kind, sides, order = case["kind"], case["sides"], case["order"]
    cell = (4.0 if kind == "indentation" else 10.0) / case["cells"]
    mesh = felupe.Grid(*(np.linspace(0.0, s, round(s / cell) + 1) for s in sides))
    shear = case["young"] / 2.0 / (1.0 + case["poisson"])
    bulk = case["young"] / 3.0 / (1.0 - 2.0 * case["poisson"])
    if order == 1:
        field = felupe.FieldContainer([felupe.Field(felupe.RegionHexahedron(mesh), dim=3)])
        body = felupe.SolidBodyNearlyIncompressible(felupe.NeoHooke(mu=shear), field, bulk=bulk)
    else:
        for add in ("edges", "faces", "volumes"):
            mesh = getattr(mesh, f"add_midpoints_{add}")()
        region = felupe.RegionTriQuadraticHexahedron(mesh)
        field = felupe.FieldContainer([felupe.Field(region, dim=3)])
        body = felupe.SolidBody(felupe.NeoHooke(mu=shear, bulk=bulk), field)
    x = mesh.points
    axis = 2 if kind == "indentation" else 0
    near, far = (np.isclose(x[:, axis], end) for end in (0.0, sides[axis]))
    held: list[tuple[str, Any, Any, tuple[int, ...]]] = [
        ("near", near, np.zeros((near.sum(), 3)), (0, 1, 2))
    ]
    loads: list[Any] = []
    if kind == "twist":
        held.append(("far", far, np.zeros((far.sum(), 3)), (0, 1, 2)))
    if kind == "indentation":
        for k in (0, 1):
            wall = np.isclose(x[:, k], 0.0)
            held.append((f"wall {k}", wall, np.zeros((wall.sum(), 3)), (k,)))
        sole = np.flatnonzero(far)
        spacing = cell / order
        shares = [_shares(x[sole, k], sides[k], spacing, order) for k in (0, 1)]
        loads = [Ball(field, sole, shares[0] * shares[1], case["radius"], case["firm"] / cell)]
    for step in range(1, case["steps"] + 1):
        load = case["load"] * step / case["steps"]
        if kind == "bending":
            loads = [felupe.SolidBodyForce(field, values=np.array([0.0, 0.0, -load]))]
        if kind == "twist":
            held[1][2][:] = _turned(x[far], np.deg2rad(load))
        if kind == "indentation":
            loads[0].bottom = sides[2] - load
        bounds = {
            f"{name} {i}": felupe.Boundary(
                field[0], mask=mask, skip=[int(j != i) for j in range(3)], value=moved[:, i]
            )
            for name, mask, moved, axes in held
            for i in axes
        }
        free = felupe.dof.partition(field, bounds)
        values = felupe.dof.apply(field, bounds, free[0])
        felupe.newtonraphson(
            items=[body, *loads], dof0=free[0], dof1=free[1], ext0=values, verbose=0, tol=1e-8,
            maxiter=50,
        )  # fmt: skip
    if kind == "indentation":
        return float(loads[0].vector().toarray().reshape(-1, 3)[:, 2].sum()) * 4.0
    if kind == "bending":
        centre = np.argmin(np.abs(x - np.multiply(sides, (1.0, 0.5, 0.5))).sum(axis=1))
        return -float(field[0].values[centre, 2])
    force = body.assemble.vector(field).toarray().reshape(-1, 3)[far]
    return float(np.cross(x[far] + held[1][2] - 5.0, force)[:, 0].sum())


def _turned(x: Any, angle: float) -> Any:
    """Return the displacements of a section that is turned about the axis of the bar [mm]."""
    arm = (x - 5.0) * (0.0, 1.0, 1.0)
    return (np.cos(angle) - 1.0) * arm + np.sin(angle) * np.cross((1.0, 0.0, 0.0), arm)


def _shares(place: Any, side: float, spacing: float, order: int) -> Any:
    """Return the weights of nodes along a side [mm], by the trapezoidal or Simpson's rule."""
    number = np.rint(place / spacing).astype(int)
    last = round(side / spacing)
    inner = np.where(number % 2 == 1, 4.0, 2.0) / 3.0 if order == 2 else np.ones(len(number))
    ends = (1.0 / 3.0) if order == 2 else 0.5
    return spacing * np.where((number == 0) | (number == last), ends, inner)


def _scaled(sides: Any) -> Any:
    """Return the map of the unit cube to a block."""

    def mapping(x: float, y: float, z: float) -> tuple[float, float, float]:
        return sides[0] * x, sides[1] * y, sides[2] * z

    return mapping


def by_ngsolve(case: dict[str, Any]) -> float:
    """Return the answer of hexahedra of some order.

    Args:
        case: As before, without indentation.
    """
    ngsolve, meshes = import_module("ngsolve"), import_module("ngsolve.meshes")
    ng: Any = ngsolve
    ng.SetNumThreads(1)
    sides, order, kind = case["sides"], case["order"], case["kind"]
    counts = [round(side / 10.0 * case["cells"]) for side in sides]
    mesh = meshes.MakeStructured3DMesh(
        hexes=True, nx=counts[0], ny=counts[1], nz=counts[2],
        mapping=_scaled(sides),
    )  # fmt: skip
    ends = "back|front" if kind == "twist" else "back"
    space = ng.VectorH1(mesh, order=order, dirichlet=ends)
    u, _ = space.TnT()
    shear = case["young"] / 2.0 / (1.0 + case["poisson"])
    bulk = case["young"] / 3.0 / (1.0 - 2.0 * case["poisson"])
    deformation = ng.Id(3) + ng.Grad(u)
    volume = ng.Det(deformation)
    square = ng.InnerProduct(deformation, deformation)
    load = ng.Parameter(0.0)
    energy = shear / 2.0 * (square * volume ** (-2.0 / 3.0) - 3.0)
    energy += bulk / 2.0 * (volume - 1.0) ** 2
    form = ng.BilinearForm(space, symmetric=True)
    form += ng.Variation(energy.Compile() * ng.dx)
    if kind == "bending":
        form += ng.Variation(load * u[2] * ng.dx)
    moved = ng.GridFunction(space)
    if kind == "twist":  # a start that turns evenly, which keeps both ends
        angle = np.deg2rad(case["load"]) * ng.x / sides[0]
        (y, z), sine, versed = (ng.y - 5.0, ng.z - 5.0), ng.sin(angle), 1.0 - ng.cos(angle)
        moved.Set(ng.CF((0.0, -versed * y - sine * z, -versed * z + sine * y)))
    steps = case["steps"] if kind == "bending" else 1
    for step in range(1, steps + 1):
        load.Set(case["load"] * step / steps)
        ng.solvers.Newton(
            form, moved, inverse="sparsecholesky", maxit=30, maxerr=1e-8, printing=False
        )
    if kind == "bending":
        return -float(moved(mesh(sides[0], 0.5 * sides[1], 0.5 * sides[2]))[2])
    force = moved.vec.CreateVector()
    form.Apply(moved.vec, force)
    # The power of a turn of the end with the present forces.
    turn = ng.GridFunction(space)
    place = (ng.y + moved[1] - 5.0, ng.z + moved[2] - 5.0)
    turn.Set(ng.CF((0.0, -place[1], place[0])), definedon=mesh.Boundaries("front"))
    return float(ng.InnerProduct(force, turn.vec))


def by_mujoco(case: dict[str, Any]) -> dict[str, float]:
    """Return how far the end of a bar of linear tetrahedra sinks [mm].

    Args:
        case: As before, with the time ``step`` [s].
    """
    mujoco: Any = import_module("mujoco")
    counts = [round(s / case["cell"]) + 1 for s in case["sides"]]
    text = FLEX.format(
        step=case["step"], counts=" ".join(map(str, counts)), cell=1e-3 * case["cell"],
        mass=1e-6 * prod(case["sides"]), young=1e3 * case["young"],
        poisson=case["poisson"], last=counts[1] - 1,
    )  # fmt: skip
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    drawn = np.array(data.flexvert_xpos)
    far = np.flatnonzero(np.isclose(drawn[:, 0], drawn[:, 0].max()))
    centre = far[np.argmin(np.abs(drawn[far] - drawn[far].mean(axis=0)).sum(axis=1))]
    shown: dict[str, float] = {}
    total, every = 0.0, round(0.05 / case["step"])
    for k, load in enumerate(case["steps"]):
        total += load
        for node in far:
            body = model.flex_vertbodyid[node]
            data.xfrc_applied[body, :3] = (0.0, 0.0, -1e-3 * total / len(far))
        start, before, sunk = data.time, np.inf, 0.0
        while data.time < start + LONGEST:
            for _ in range(every):
                mujoco.mj_step(model, data)
            sunk = drawn[centre, 2] - data.flexvert_xpos[centre, 2]
            if abs(sunk - before) < 1e-7 and np.abs(data.qvel).max() < SETTLED:
                break
            before = sunk
        shown[case["shown"][str(k)]] = 1e3 * float(sunk)
    return shown


if __name__ == "__main__":
    asked = json.loads(sys.argv[1])
    answer = {"felupe": by_felupe, "ngsolve": by_ngsolve, "mujoco": by_mujoco}[asked["by"]](
        asked
    )
    used = getrusage(RUSAGE_SELF)
    seconds = used.ru_utime + used.ru_stime
    found = {"shown": answer, "seconds": seconds, "memory": used.ru_maxrss / 1024}
    print(json.dumps(found, allow_nan=False))  # an error where Newton's method diverged
