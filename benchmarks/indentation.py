"""A ball pressed into a block, with and without friction, against felupe.

felupe is an independent library of finite elements. Here it solves an axisymmetric mesh of
quadrilaterals, finest below the ball, of a cylinder with the thickness and the base area of the
block; contact acts on its nodes, by penalties per area, with Coulomb's friction. Takes ten
minutes.
"""

from collections.abc import Iterator
from importlib import import_module
from typing import Any, NamedTuple

import click
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import spsolve

import tissuec
from benchmarks.publishing import publish, tell, write_option
from tissuec.core.markdown import table
from tissuec.model.network import Floats

felupe: Any = import_module("felupe")

YOUNG, RATIO = 10.0, 0.3  # [kPa], dimensionless
BALL, WIDE, THICK = 6.0, 32.0, 12.0  # [mm]: radius of the ball, sides of the block
DEPTHS = (0.75, 1.5, 3.0)  # [mm]
FRICTIONS = (0.0, 0.3, 1.0)
CELLS = (2.0, 16.0 / 12.0)  # [mm]

BLOCK = """language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 1 ms; solid law is neo hookean {{ volume is quadratic }}
}}
body block {{
  mesh is lattice {{ cell = {cell:.15g} mm; box from (0, 0, 0) mm to (16, 16, 12) mm }}
  tissue is gel
}}
set base = nodes of block where z == 0 mm
tool ball {{ kind is probe; radius = 6 mm; centre = (0, 0, 18) mm }}
environment {{
  gravity = (0, 0, 0) m/s^2; contact is tools only; friction = {friction:g}
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}}
script {{
  at 0 s: fix base
{moves}
}}
simulate {{ duration = {duration} ms; tolerance = 1e-4 }}
output {{ force of ball every {every} ms }}
"""
SLIDING = 0.1  # traction per slip before sliding, in pressure per depth
MOVING, RESTING = 40, 20  # [ms]: to the next depth, and there


def pressed(cell: float, friction: float, depths: tuple[float, ...] = DEPTHS) -> Floats:
    """Return the forces on a ball at depths [mN], shape (depth,), of slow runs.

    Args:
        cell: Side of the hexahedra [mm].
        friction: Between ball and block.
        depths: Ascending [mm].
    """
    every = MOVING + RESTING
    moves = "\n".join(
        f"  from {n * every} ms to {n * every + MOVING} ms: move ball by (0, 0, {-way:g}) mm "
        "using smooth profile"
        for n, way in enumerate(np.diff(depths, prepend=0.0))
    )
    text = BLOCK.format(
        cell=cell, friction=friction, moves=moves, duration=len(depths) * every, every=every
    )
    with tissuec.run(text, companion="off") as run:
        assert run.finished
        force = run.logs["force of ball"].value[1:, 2]
    return np.asarray(-4e3 * force)


# --- the independent solution -----------------------------------------------------------------


class Sole(NamedTuple):
    """Nodes of the top, and where they stick to the ball.

    Attributes:
        area: The area that each represents [mm²], shape (node,).
        stuck: Arc on the ball, from its lowest point, where the node would bear no friction
            [mm], NaN if it does not touch, shape (node,).
    """

    area: Floats
    stuck: Floats


def touched(
    x: Any, centre: float, sole: Sole, firm: float, friction: float
) -> tuple[Any, Any, Any]:
    """Return the forces of the ball on nodes [mN], arcs [mm] and friction over firmness [mm].

    Args:
        x: Nodes of the top, along and from the axis [mm], shape (node, 2); complex for
            derivatives.
        centre: Of the ball along the axis [mm].
        sole: The same nodes.
        firm: Pressure per depth [kPa/mm].
        friction: Between ball and nodes.
    """
    down, out = centre - x[:, 0], x[:, 1]
    away = np.sqrt(down * down + out * out)
    depth: Any = np.where(np.real(away) < BALL, BALL - away, 0.0)
    arc = BALL * np.arctan(out / down)
    bent = np.where(np.isnan(sole.stuck), 0.0, arc - sole.stuck)
    most = friction * depth / SLIDING
    bent = np.where(np.abs(np.real(bent)) > most.real, np.sign(np.real(bent)) * most, bent)
    push = firm * sole.area * depth / away
    rub = SLIDING * firm * sole.area * np.where(depth.real > 0.0, bent, 0.0) / away
    # The normal is (-down, out) / away; the arc grows along (out, down) / away.
    force = np.stack([-push * down - rub * out, push * out - rub * down], axis=1)
    return force, arc, bent


def pressed_by_library(
    friction: float, fine: float = 0.15, steps: int = 64, depths: tuple[float, ...] = DEPTHS
) -> Floats:
    """Return the forces on a ball at depths [mN], shape (depth,).

    Args:
        friction: Between ball and block.
        fine: Side of the elements below the ball [mm].
        steps: Of equal size to the last depth, of which the others are multiples.
        depths: Ascending [mm].
    """
    near = np.sqrt(2.0 * BALL * depths[-1])
    down = -_widening(THICK, fine, 2.0 * fine)[::-1]
    out = _widening(WIDE / np.sqrt(np.pi), fine, near)
    mesh = felupe.Grid(down, out)
    field = felupe.FieldContainer([felupe.FieldAxisymmetric(felupe.RegionQuad(mesh), dim=2)])
    shear, bulk = YOUNG / 2.0 / (1.0 + RATIO), YOUNG / 3.0 / (1.0 - 2.0 * RATIO)
    law = felupe.NeoHooke(mu=shear, bulk=bulk)
    body, x = felupe.SolidBody(law, field), mesh.points
    base = np.isclose(x[:, 0], -THICK)
    held = np.stack([base, base | (x[:, 1] == 0.0)], axis=1)
    free, top = np.flatnonzero(~held.ravel()), np.flatnonzero(x[:, 0] == 0.0)
    assert (np.diff(x[top, 1]) > 0.0).all()
    sole = Sole(_areas(out), np.full(len(top), np.nan))
    firm, loads = 20.0 * YOUNG / fine, list[float]()
    before = field[0].values.copy()
    for step in range(1, steps + 1):
        depth = depths[-1] * step / steps
        # Newton's method begins on the straight line through the last two balances.
        now = field[0].values.copy()
        field[0].values[:] += now - before
        before = now
        for attempt in range(100):
            force, slope, arc, bent = _with_slopes(
                x[top] + field[0].values[top], BALL - depth, sole, firm, friction
            )
            residual = body.assemble.vector(field).toarray().ravel()
            matrix = csr_matrix(body.assemble.matrix(field))
            residual[(2 * top[:, None] + (0, 1)).ravel()] -= force.ravel()
            rows = np.broadcast_to(2 * top[:, None, None] + np.arange(2)[:, None], slope.shape)
            columns = np.broadcast_to(2 * top[:, None, None] + np.arange(2), slope.shape)
            matrix -= csr_matrix(
                (slope.ravel(), (rows.ravel(), columns.ravel())), shape=matrix.shape
            )
            load = -float(force[:, 0].sum())
            if np.abs(residual[free]).max() < 1e-7 * max(load, 1e-3):
                break
            moved = np.zeros(2 * len(x))
            moved[free] = spsolve(matrix[free][:, free].tocsc(), -residual[free])
            # Nodes that stick and slip in turn come to rest with shorter steps.
            most = 0.5 * fine / (1.0 + attempt // 10)
            moved *= min(0.5 if attempt > 10 else 1.0, most / float(np.abs(moved).max()))
            field[0].values[:] += moved.reshape(-1, 2)
        else:
            raise RuntimeError(f"no balance at a depth of {depth:g} mm")
        # What slipped sticks where it is now; what has just touched has no friction yet.
        touches = np.abs(force).max(axis=1) > 0.0
        sole = sole._replace(stuck=np.where(touches, arc - bent, np.nan))
        loads.append(load)
    return np.array([loads[round(depth / depths[-1] * steps) - 1] for depth in depths])


def _with_slopes(x: Floats, *rest: Any) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the results of ``touched``, with derivatives of the forces [kPa mm] second."""
    tiny, sides = 1e-30, list[Floats]()
    for axis in range(2):
        turned = x.astype(np.complex128)
        turned[:, axis] += 1j * tiny
        sides.append(touched(turned, *rest)[0].imag / tiny)
    force, arc, bent = touched(x.astype(np.complex128), *rest)
    return force.real, np.stack(sides, axis=2), arc.real, bent.real


def _widening(length: float, fine: float, near: float) -> Floats:
    """Return places from 0 to a length [mm], even up to ``near``, then ever further apart."""
    even = np.arange(0.0, near + fine, fine)
    steps = fine * 1.15 ** np.arange(1, 100)
    far = even[-1] + np.cumsum(steps)
    far = far[: int(np.searchsorted(far, length)) + 1]
    far = even[-1] + (far - even[-1]) * (length - even[-1]) / (far[-1] - even[-1])
    return np.concatenate([even, far])


def _areas(r: Floats) -> Floats:
    """Return ∫ N 2πr dr of linear functions between radii, shape (node,)."""
    inner, outer = r[:-1], r[1:]
    long = outer - inner
    areas = np.zeros(len(r))
    areas[:-1] += np.pi * long * (2.0 * inner + outer) / 3.0
    areas[1:] += np.pi * long * (inner + 2.0 * outer) / 3.0
    return areas


# --- both -------------------------------------------------------------------------------------


def compared() -> Iterator[tuple[str, ...]]:
    """Yield a row for each coefficient of friction."""
    for friction in FRICTIONS:
        tell(f"friction {friction:g}")
        other = pressed_by_library(friction)
        errors = [100.0 * (pressed(cell, friction) / other - 1.0) for cell in CELLS]
        forces = ", ".join(f"{force:.1f}" for force in other)
        yield (
            f"{friction:g}", forces,
            *(", ".join(f"{e:.1f}".replace("-", "−") for e in each) for each in errors),
        )  # fmt: skip


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Compare all coefficients of friction."""
    heads = ("friction", "felupe [mN]", *(f"cells of {cell:.3g} mm" for cell in CELLS))
    publish("indentation", {"ball": table(heads, list(compared()))}, write=write)


if __name__ == "__main__":
    main()
