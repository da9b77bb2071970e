"""Arteries under pressure against felupe and the integral over their wall.

felupe, an independent library of finite elements, solves rings of quadrilaterals with nine
nodes about the axis, under its own follower pressure. Exponential laws and fibres, which it
does not have, are written here with their first and second derivatives. Takes some minutes.
"""

from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Any, cast

import click
import numpy as np
from msgspec import Struct
from scipy.integrate import quad
from scipy.optimize import brentq

import tissuec
from benchmarks.publishing import publish, tell, write_option
from benchmarks.solids import solved_by, towards
from tissuec.core.markdown import table
from tissuec.model.network import Floats

felupe: Any = import_module("felupe")

INNER, OUTER, YOUNG = 4.0, 6.0, 100.0  # [mm], [mm], [kPa]
K1, K2 = 50.0, 0.8  # of fibres of 300 kPa: a quarter of what they add [kPa]; stiffening
STEPS = 14  # of the library from one pressure to the next
MESHES = ((2, 16), (4, 32))  # cells across the wall, and around the whole tube


class Case(Struct, frozen=True):
    """An artery.

    Attributes:
        pressures: [kPa].
        stiffening: Of its exponential law; 0 if it is neo-Hookean.
        angle: Of two families of fibres from around the tube [deg]; None without any.
        drawn: Axial stretch of the tissue as drawn.
        length: Of half of a tube between clamped ends [mm]; 0 if it is long.
        poisson: Poisson's ratio.
    """

    pressures: tuple[float, float, float]
    stiffening: float = 0.0
    angle: float | None = None
    drawn: float = 1.0
    length: float = 0.0
    poisson: float = 0.4999


CASES = {
    "neo-Hookean": Case((2.0, 4.0, 6.0)),
    "exponential, stiffening 2": Case((4.0, 8.0, 16.0), stiffening=2.0),
    "fibres at ±20°": Case((5.0, 10.0, 20.0), angle=20.0),
    "fibres at ±40°": Case((5.0, 10.0, 20.0), angle=40.0),
    "fibres at ±40°, stretched by 25 %": Case((5.0, 10.0, 20.0), angle=40.0, drawn=1.25),
    "the same, 16 mm between clamped ends": Case(
        (5.0, 10.0, 20.0), angle=40.0, drawn=1.25, length=8.0, poisson=0.49
    ),
}


# --- the library ----------------------------------------------------------------------------


class Wall:
    """The law of a case for the library; components are along, radial and around.

    W = μ/2s (exp(s (I - 3)) - 1) + Σ k1/2k2 (exp(k2 e²) - 1) + K/2 (J - 1)² with
    I = tr C/J^(2/3), and e = a C a - 1 where it is positive (G. A. Holzapfel, T. C. Gasser, R.
    W. Ogden, J. Elasticity 61:1, 2000; fibres: D. R. Nolan et al., J. Mech. Behav. Biomed.
    Mater. 39:48, 2014).

    Args:
        case: The artery.
    """

    def __init__(self, case: Case):
        self.x = [np.zeros((3, 3)), np.zeros(0)]
        self.shear = YOUNG / 2.0 / (1.0 + case.poisson)
        self.bulk = YOUNG / 3.0 / (1.0 - 2.0 * case.poisson)
        self.stiffening = case.stiffening
        side = case.drawn**-0.5
        self.first = np.diag([case.drawn, side, side])
        self.along: list[Floats] = []
        if case.angle is not None:
            # Angles are those of the drawn tube.
            for angle in np.radians([case.angle, -case.angle]):
                way = np.array([np.sin(angle) / case.drawn, 0.0, np.cos(angle) / side])
                self.along.append(way / np.linalg.norm(way))

    def _terms(
        self, f: Floats
    ) -> Iterator[tuple[tuple[Floats, Floats, Floats], Floats, Floats, float]]:
        """Yield q = J^(-2m/3) C : M with ∂W/∂q and ∂²W/∂q², ∂q/∂F at fixed J, M, and m."""
        j = np.linalg.det(np.moveaxis(f, (0, 1), (-2, -1)))
        c = np.einsum("ki...,kj...->ij...", f, f)
        for shape in (np.eye(3), *(np.outer(a, a) for a in self.along)):
            power = 1.0 if shape[1, 1] else 0.0  # fibres feel the change of volume
            scale = j ** (-2.0 / 3.0 * power)
            q = scale * np.einsum("ij...,ij->...", c, shape)
            if power:
                rise = 0.5 * self.shear * np.exp(self.stiffening * (q - 3.0))
                bend = self.stiffening * rise
            else:
                e = np.maximum(q - 1.0, 0.0)
                rise = K1 * e * np.exp(K2 * e * e)
                bend = np.where(
                    e > 0.0, K1 * (1.0 + 2.0 * K2 * e * e) * np.exp(K2 * e * e), 0.0
                )
            moved = 2.0 * scale * np.einsum("ik...,kj->ij...", f, shape)
            yield (q, rise, bend), moved, shape, power

    def _of(self, x: Any) -> tuple[Floats, Floats, Floats]:
        """Return F, J and the transposed inverse of F, including the stretch as drawn."""
        f = np.einsum("iK...,KJ->iJ...", x[0], self.first)
        last = np.moveaxis(f, (0, 1), (-2, -1))
        back: Floats = np.moveaxis(cast(Any, np.linalg.inv)(last), (-1, -2), (0, 1))
        return f, np.linalg.det(last), back

    def gradient(self, x: Any) -> list[Any]:
        """Return P relative to the drawn shape [kPa]."""
        f, j, back = self._of(x)
        total = self.bulk * (j - 1.0) * j * back
        for (q, rise, _), moved, _, power in self._terms(f):
            total = total + rise * (moved - 2.0 / 3.0 * power * q * back)
        return [np.einsum("iK...,KJ->iJ...", total, self.first), *x[1:]]

    def hessian(self, x: Any) -> list[Any]:
        """Return its derivative [kPa]."""
        f, j, back = self._of(x)
        squares = np.einsum("ij...,kl...->ijkl...", back, back)
        turned = np.einsum("il...,kj...->ijkl...", back, back)
        total = self.bulk * ((2.0 * j - 1.0) * j * squares - (j - 1.0) * j * turned)
        for (q, rise, bend), moved, shape, power in self._terms(f):
            by = moved - 2.0 / 3.0 * power * q * back
            same = np.einsum("ik,jl->ijkl", np.eye(3), shape)
            scale = 2.0 * j ** (-2.0 / 3.0 * power)
            curved = np.multiply.outer(same, scale) + 2.0 / 3.0 * power * (
                q * turned
                - np.einsum("ij...,kl...->ijkl...", moved, back)
                - np.einsum("ij...,kl...->ijkl...", back, by)
            )
            total = total + rise * curved + bend * np.einsum("ij...,kl...->ijkl...", by, by)
        return [np.einsum("iMkN...,MJ,NL->iJkL...", total, self.first, self.first)]


def by_library(case: Case, factor: int) -> list[float]:
    """Return the increase of the inner radius in the middle at each pressure [mm].

    Args:
        case: The artery.
        factor: Quadrilaterals across the wall.
    """
    x = np.array([0.0, 0.5])
    if case.length:
        x = towards(case.length, 2 * factor)
    y = np.linspace(INNER, OUTER, factor + 1)
    mesh = felupe.Grid(x, y).add_midpoints_edges().add_midpoints_faces()
    field = felupe.FieldContainer(
        [felupe.FieldAxisymmetric(felupe.RegionBiQuadraticQuad(mesh), dim=2)]
    )
    at, lumen = mesh.points, np.isclose(mesh.points[:, 1], INNER)
    skin = felupe.RegionBiQuadraticQuadBoundary(
        mesh, only_surface=True, mask=lumen, ensure_3d=True
    )
    load = felupe.SolidBodyPressure(
        felupe.FieldContainer([felupe.FieldAxisymmetric(skin, dim=2)])
    )
    body, end = felupe.SolidBody(Wall(case), field), np.isclose(at[:, 0], x[-1])
    held = [("middle", np.isclose(at[:, 0], 0.0), (0, 1)), ("end", end, (0, 1))]
    if case.length:
        held.append(("clamp", end, (1, 0)))
    bounds = {
        name: felupe.Boundary(field[0], mask=mask, skip=skip) for name, mask, skip in held
    }
    free = felupe.dof.partition(field, bounds)
    values = felupe.dof.apply(field, bounds, free[0])
    middle = np.flatnonzero(lumen & np.isclose(at[:, 0], 0.0))[0]
    found: list[float] = []
    steps = np.interp(np.arange(1, 3 * STEPS + 1) / STEPS, range(4), (0.0, *case.pressures))
    for number, pressure in enumerate(steps):
        load.update(pressure)
        felupe.newtonraphson(
            items=[body, load], dof0=free[0], dof1=free[1], ext0=values, solver=solved_by,
            verbose=0, tol=1e-7, maxiter=30,
        )  # fmt: skip
        if (number + 1) % STEPS == 0:
            found.append(float(field[0].values[middle, 1]))
    return found


# --- the integral over the wall -------------------------------------------------------------


def by_integral(case: Case) -> list[float]:
    """Return the same of a long tube that cannot change its volume [mm].

    With λ = r/R and r² = a² + R² - A², p = ∫ λ ∂W/∂λ R/r² dR from A to B (R. W. Ogden,
    Non-Linear Elastic Deformations, 1984, section 5.3).
    """
    law, z = Wall(case), case.drawn

    def stress(square: float) -> float:
        i = z * z + (square + 1.0 / square) / z
        found = YOUNG / 3.0 * np.exp(law.stiffening * (i - 3.0)) * (square - 1.0 / square) / z
        for way in law.along:
            around = way[2] ** 2 * square / z
            e = max(around + (way[0] * z) ** 2 - 1.0, 0.0)
            found += 2.0 * K1 * e * np.exp(K2 * e * e) * around
        return float(found)

    def missing(radius: float, pressure: float) -> float:
        def of(drawn: float) -> float:
            now = radius**2 + drawn**2 - INNER**2
            return stress(now / drawn**2) * drawn / now

        return float(quad(of, INNER, OUTER)[0]) - pressure

    return [
        float(brentq(missing, 0.8 * INNER, 3.0 * INNER, args=(pressure,))) - INNER
        for pressure in case.pressures
    ]


# --- whole runs -----------------------------------------------------------------------------

SCENE = """language 1
tissue media {{
  Young's modulus = 100 kPa; Poisson's ratio = {poisson}; density = 1100 kg/m^3
  {law}
}}
body artery {{
  mesh is thick tube {{
    axis from (0, 0, 0) mm to (0, 0, {length}) mm; inner radius = 4 mm; outer radius = 6 mm
    rings = {rings}; sides = {sides}; layers = {layers}; part is quarter
  }}
  tissue is media
  {body}
}}
{held}
environment {{
  gravity = (0, 0, 0) m/s^2
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
  {end}
}}
script {{
{steps}
}}
simulate {{ duration = 6 us; integrator is dop853 }}
output {{ trajectory every 2 us }}
"""


def text_of(case: Case, layers: int, sides: int) -> str:
    """Return the scene of a case."""
    kind = f"exponential {{ stiffening = {case.stiffening:g}; " if case.stiffening else ""
    law = f"solid law is {kind or 'neo hookean { '}volume is quadratic }}"
    body = ""
    if case.angle is not None:
        law += "\n  fibre modulus = 300 kPa; fibre stiffening = 0.8"
        body = f"fibres = {case.angle:g} deg; second fibres = -{case.angle:g} deg"
    if case.drawn != 1.0:
        law += f"\n  prestress = {100.0 * (1.0 - 1.0 / case.drawn):.12g} %"
        body += "; prestress along (0, 0, 1)"
    length = case.length or 0.5
    end = f"symmetric about plane through (0, 0, {length:g}) mm facing (0, 0, -1)"
    added = np.diff([0.0, *case.pressures])
    steps = [
        f"  at {2 * k} us: {{ {'fix end; ' * bool(case.length and not k)}"
        f"press inside of artery with {one:.12g} kPa; settle }}"
        for k, one in enumerate(added)
    ]
    return SCENE.format(
        poisson=case.poisson, law=law, length=length, sides=sides, layers=layers, body=body,
        rings=2 * layers * round(length / 4.0) + 1 if case.length else 2,
        held=f"set end = nodes of artery where z > {length:g} mm - 1 um" * bool(case.length),
        end="" if case.length else end, steps="\n".join(steps),
    )  # fmt: skip


def by_run(case: Case, layers: int, sides: int) -> list[float]:
    """Return the same from a whole run [mm]."""
    with tissuec.run(text_of(case, layers, sides), companion="off") as run:
        assert run.finished
        drawn, now = 1e3 * run.network.position, 1e3 * run.position[:3]
    radius = np.hypot(drawn[:, 0], drawn[:, 1])
    middle = np.isclose(radius, INNER) & np.isclose(drawn[:, 2], 0.0)
    wide = np.linalg.norm(now[:, middle, :2], axis=2).mean(axis=1)
    return [float(one) - INNER for one in wide]


def rows(names: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table: widenings, and errors of whole runs."""
    for name in names:
        case = CASES[name]
        coarse, known = by_library(case, 4), by_library(case, 8)
        changes = [
            f"{100.0 * (fine / due - 1.0):+.2f} %"
            for due, fine in zip(coarse, known, strict=True)
        ]
        tell(f"{name}: {known}, changed by {changes}")
        closed = ["" for _ in known]
        if not case.length:
            closed = [f"{one:.3f}" for one in by_integral(case)]
        found = [by_run(case, *mesh) for mesh in MESHES]
        for k, (pressure, due) in enumerate(zip(case.pressures, known, strict=True)):
            errors = [f"{100.0 * (each[k] / due - 1.0):+.1f} %" for each in found]
            yield name, f"{pressure:g}", f"{due:.3f}", closed[k], *errors
            tell(" | ".join((name, f"{pressure:g}", f"{due:.3f}", closed[k], *errors)))


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Compare everything."""
    heads = (
        "artery", "pressure [kPa]", "felupe [mm]", "integral [mm]",
        *(f"{layers} cells across, {sides} around" for layers, sides in MESHES),
    )  # fmt: skip
    publish("arteries", {"felupe": table(heads, list(rows(list(CASES))))}, write=write)


if __name__ == "__main__":
    main()
