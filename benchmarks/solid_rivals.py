"""A load series on a block by felupe or MuJoCo, in a separate process without tissuec.

Reads a JSON object from the command line and prints one.
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


def by_felupe(case: dict[str, Any]) -> dict[str, float]:
    """Return the answers on trilinear hexahedra with the mean volume.

    Args:
        case: ``sides`` and ``cell`` [mm], ``young`` [kPa], ``poisson``, ``axis``, ``kind``:
            "cube", "cantilever" or "torsion", ``steps`` and ``shown``.
    """
    felupe: Any = import_module("felupe")
    mesh = felupe.Grid(
        *(np.linspace(0.0, s, round(s / case["cell"]) + 1) for s in case["sides"])
    )
    field = felupe.FieldContainer([felupe.Field(felupe.RegionHexahedron(mesh), dim=3)])
    shear = case["young"] / 2.0 / (1.0 + case["poisson"])
    bulk = case["young"] / 3.0 / (1.0 - 2.0 * case["poisson"])
    law = felupe.NeoHooke(mu=shear)
    body = felupe.SolidBodyNearlyIncompressible(law, field, bulk=bulk)
    x, axis = mesh.points, "xyz".index(case["axis"])
    near, far = (np.isclose(x[:, axis], end) for end in (0.0, case["sides"][axis]))
    centre = np.argmin(np.abs(x - 0.5 * x.max(axis=0)) @ (1.0, 1.0, 1.0) + 1e3 * ~far)
    shown: dict[str, float] = {}
    total, loads = 0.0, []
    for k, step in enumerate(case["steps"]):
        total += step
        held = [("near", near, np.zeros((near.sum(), 3)))]
        if case["kind"] == "cantilever":
            share = np.outer(np.full(far.sum(), 1.0 / far.sum()), [0.0, 0.0, -total])
            loads = [felupe.PointLoad(field, np.flatnonzero(far), values=share)]
        else:
            held.append(("far", far, _moved(case["kind"], x[far], total)))
        bounds = {
            f"{name} {i}": felupe.Boundary(
                field[0], mask=mask, skip=[int(j != i) for j in range(3)], value=moved[:, i]
            )
            for name, mask, moved in held
            for i in range(3)
        }
        free = felupe.dof.partition(field, bounds)
        values = felupe.dof.apply(field, bounds, free[0])
        felupe.newtonraphson(
            items=[body, *loads], dof0=free[0], dof1=free[1], ext0=values, verbose=0, tol=1e-9,
            maxiter=30,
        )  # fmt: skip
        if str(k) in case["shown"]:
            force = body.assemble.vector(field).toarray().reshape(-1, 3)[far]
            arm = (x[far] + held[-1][2] - 5.0) * (0.0, 1.0, 1.0) if len(held) > 1 else force
            found = {
                "cube": -force[:, 2].sum(), "cantilever": -field[0].values[centre, 2],
                "torsion": np.cross(arm, force)[:, 0].sum(),
            }  # fmt: skip
            shown[case["shown"][str(k)]] = float(found[case["kind"]])
    return shown


def _moved(kind: str, x: Any, total: float) -> Any:
    """Return the displacements of the far end [mm], shape (node, 3)."""
    if kind == "cube":
        return np.broadcast_to([0.0, 0.0, -total], x.shape)
    arm, angle = (x - 5.0) * (0.0, 1.0, 1.0), np.deg2rad(total)
    return (np.cos(angle) - 1.0) * arm + np.sin(angle) * np.cross((1.0, 0.0, 0.0), arm)


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
    answer = {"felupe": by_felupe, "mujoco": by_mujoco}[asked["by"]](asked)
    used = getrusage(RUSAGE_SELF)
    seconds = used.ru_utime + used.ru_stime
    print(json.dumps({"shown": answer, "seconds": seconds, "memory": used.ru_maxrss / 1024}))
