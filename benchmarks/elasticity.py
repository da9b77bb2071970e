"""Solids and walls of matter against the theory of elasticity.

Takes about two minutes, and needs what the tests need. All is linear statics with code of its
own (see tests/matter).
"""

from collections.abc import Callable, Iterator
from functools import cache
from math import pi, tanh
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix, diags
from scipy.sparse.linalg import eigsh

import tissuec
from benchmarks.publishing import publish, tell, write_option
from tests.matter.elastic import moved, stiffness
from tests.matter.shapes import as_vtk, tetrahedra
from tissuec.core.markdown import table
from tissuec.model.network import Floats, Network

YOUNG, RATIO, DENSITY = 10e3, 0.25, 1000.0
SHEAR = YOUNG / (2.0 * (1.0 + RATIO))
SIDE = 16e-3  # of the section of bars [m]
LENGTH = 64e-3
SCENE = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body piece { mesh is MESH; tissue is gel }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""
KINDS = ("sodium chloride", "caesium chloride", "tetrahedra")
CELLS = (4, 6, 8)  # across a section
ROUNDS = 20  # until it is known which nodes a ball touches
Held = dict[int, float]
Test = Callable[[str, float], tuple[float, float]]


# --- bodies -----------------------------------------------------------------------------------


@cache
def block(kind: str, sides: tuple[float, float, float], cell: float) -> Network:
    """Return a block of matter with a corner at the origin.

    Args:
        sides: Its lengths [m].
        cell: Length of its cells [m].
    """
    shown = 1e3 * np.array(sides)
    with TemporaryDirectory() as folder:
        if kind == "tetrahedra":
            Path(folder, "bar.vtk").write_text(
                as_vtk(*tetrahedra(shown, 1e3 * cell, 0.15)), encoding="utf-8"
            )
            mesh = 'imported { file "bar.vtk" in mm }'
        else:
            to = ", ".join(f"{side:.12g}" for side in shown)
            mesh = (
                f"lattice {{ kind is {kind}; reach is second neighbours; "
                f"cell = {1e3 * cell:.12g} mm; box from (0, 0, 0) mm to ({to}) mm }}"
            )
        path = Path(folder, "piece.tis")
        path.write_text(SCENE.replace("MESH", mesh), encoding="utf-8")
        return tissuec.compile(path).network


@cache
def matrix(network: Network) -> csc_matrix:
    """Return the matrix of a net [N/m]."""
    return stiffness(network)


@cache
def elements(sides: tuple[float, float, float], cell: float) -> tuple[Floats, csc_matrix]:
    """Return nodes and matrix of a block of trilinear finite elements.

    Args:
        sides, cell: As of ``block``.
    """
    counts = [round(side / cell) for side in sides]
    axes = [
        np.linspace(0.0, side, count + 1) for side, count in zip(sides, counts, strict=True)
    ]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(x)).reshape([count + 1 for count in counts])
    places = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    corners = np.array(places, dtype=np.float64)
    nodes = np.stack(
        [
            number[i : i + counts[0], j : j + counts[1], k : k + counts[2]].ravel()
            for i, j, k in places
        ],
        axis=1,
    )
    lame = YOUNG * RATIO / ((1.0 + RATIO) * (1.0 - 2.0 * RATIO))
    law = np.diag([2.0 * SHEAR] * 3 + [SHEAR] * 3)
    law[:3, :3] += lame
    one = np.zeros((24, 24))
    for point in 0.5 + (corners - 0.5) / np.sqrt(3.0):
        shares: Floats = corners * point + (1.0 - corners) * (1.0 - point)
        signs = 2.0 * corners - 1.0
        slopes = np.stack(
            [
                signs[:, axis] * np.delete(shares, axis, axis=1).prod(axis=1) / cell
                for axis in range(3)
            ],
            axis=1,
        )
        strain = np.zeros((6, 24))
        for node, (a, b, c) in enumerate(slopes):
            strain[:, 3 * node : 3 * node + 3] = [
                [a, 0, 0], [0, b, 0], [0, 0, c], [0, c, b], [c, 0, a], [b, a, 0],
            ]  # fmt: skip
        one += strain.T @ law @ strain * cell**3 / 8.0
    places = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), 24)
    rows, columns = np.repeat(places, 24, axis=1).ravel(), np.tile(places, (1, 24)).ravel()
    values = np.tile(one.ravel(), len(nodes))
    return x, csc_matrix(coo_matrix((values, (rows, columns)), shape=(x.size, x.size)))


# --- tests: the measured quantity and that of the theory --------------------------------------


def faces(x: Floats, axis: int) -> tuple[list[int], list[int]]:
    """Return the nodes in both end faces along an axis."""
    low, high = (np.isclose(x[:, axis], end) for end in (x[:, axis].min(), x[:, axis].max()))
    return np.flatnonzero(low).tolist(), np.flatnonzero(high).tolist()


def between_plates(x: Floats, held: csc_matrix, axis: int, along: int) -> float:
    """Return the force that moves one of two clamped plates by 1 m [N].

    Args:
        axis: From plate to plate.
        along: In which direction one is moved.
    """
    low, high = faces(x, axis)
    at: Held = {3 * node + k: 0.0 for node in (*low, *high) for k in range(3)}
    at |= {3 * node + along: 1.0 for node in high}
    _, force = moved(held, at)
    return float(force[high, along].sum())


def tension(kind: str, cell: float) -> tuple[float, float]:
    """A bar that is drawn out, free to become narrower: F = E A ε."""
    network = block(kind, (LENGTH, SIDE, SIDE), cell)
    low, high = faces(network.position, 0)
    at: Held = {3 * node: 0.0 for node in low} | {3 * node: LENGTH for node in high}
    _, force = moved(matrix(network), at)
    return float(force[high, 0].sum()), YOUNG * SIDE**2


def bending(kind: str, cell: float) -> tuple[float, float]:
    """A bar whose ends are turned against each other: M = E I κ."""
    network = block(kind, (LENGTH, SIDE, SIDE), cell)
    x = network.position
    low, high = faces(x, 0)
    at: Held = {3 * node: 0.0 for node in low}
    at |= {3 * node: x[node, 2] - SIDE / 2.0 for node in high}
    _, force = moved(matrix(network), at)
    moment = float(force[high, 0] @ (x[high, 2] - SIDE / 2.0))
    return moment, YOUNG * SIDE**4 / 12.0 / LENGTH


def torsion(kind: str, cell: float) -> tuple[float, float]:
    """A bar whose ends are turned about its axis, and free to warp: M = G J θ / L.

    J of a square (Timoshenko & Goodier, Theory of Elasticity, section 109).
    """
    network = block(kind, (LENGTH, SIDE, SIDE), cell)
    x = network.position
    low, high = faces(x, 0)
    at: Held = {}
    for nodes, angle in ((low, -0.5), (high, 0.5)):
        for node in nodes:
            y, z = x[node, 1:] - SIDE / 2.0
            at |= {3 * node + 1: -angle * z, 3 * node + 2: angle * y}
    _, force = moved(matrix(network), at)
    y, z = (x[high, 1:] - SIDE / 2.0).T
    moment = float(y @ force[high, 2] - z @ force[high, 1])
    odd = np.arange(1, 40, 2)
    sum_of = sum(tanh(n * pi / 2.0) / n**5 for n in odd.tolist())
    constant = SIDE**4 / 3.0 * (1.0 - 192.0 / pi**5 * sum_of)
    return moment, SHEAR * constant / LENGTH


def against_elements(sides: tuple[float, float, float], axis: int, along: int) -> Test:
    """Return a test of a block between plates, against finite elements."""

    @cache
    def theory() -> float:
        # The error falls with the square of the cells but for corners.
        coarse, fine = (
            between_plates(*elements(sides, SIDE / count), axis, along) for count in (8, 12)
        )
        return (12**2 * fine - 8**2 * coarse) / (12**2 - 8**2)

    def test(kind: str, cell: float) -> tuple[float, float]:
        network = block(kind, sides, cell)
        return between_plates(network.position, matrix(network), axis, along), theory()

    return test


def hertz(kind: str, cell: float) -> tuple[float, float]:
    """A ball that is pressed into a half space to the depth a²/R: F = 4/3 E a³ / R (1 - ν²).

    Cells are half as large as given, so that there are some below the ball. A quarter of the
    space is a block of 4 a, whose outer faces move as Boussinesq's solution for the whole force
    says. No node is within the ball, and it pulls at none.
    """
    a, ball = SIDE / 4.0, SIDE
    size = 4.0 * a
    network = block(kind, (size, size, size), 0.5 * cell)
    x = network.position
    r = np.hypot(x[:, 0], x[:, 1])
    depth = size - x[:, 2]
    force = 4.0 / 3.0 * YOUNG / (1.0 - RATIO**2) * a**3 / ball
    at: Held = {}
    for axis in (0, 1):
        at |= {3 * node + axis: 0.0 for node in faces(x, axis)[0]}
    outer = {*faces(x, 0)[1], *faces(x, 1)[1], *faces(x, 2)[0]}
    for node in sorted(outer):
        far = np.hypot(r[node], depth[node])
        about = force * (1.0 + RATIO) / (2.0 * pi * YOUNG * far)
        down = about * (2.0 * (1.0 - RATIO) + depth[node] ** 2 / far**2)
        out = about * (
            r[node] * depth[node] / far**2 - (1.0 - 2.0 * RATIO) * r[node] / (far + depth[node])
        )
        at |= {3 * node + axis: out * x[node, axis] / max(r[node], 1e-9) for axis in (0, 1)}
        at[3 * node + 2] = -down
    top = np.array(faces(x, 2)[1])
    surface = r[top] ** 2 / (2.0 * ball) - a**2 / ball  # of the ball, above that of the block
    touches: NDArray[np.bool_] = r[top] <= a
    stiffness = matrix(network)
    found = np.zeros_like(x)
    for _ in range(ROUNDS):
        pressed = {3 * top[k] + 2: surface[k] for k in np.flatnonzero(touches)}
        way, found = moved(stiffness, at | pressed)
        pushed, inside = found[top, 2] < 0.0, way[top, 2] > surface
        kept: NDArray[np.bool_] = (touches & pushed) | (~touches & inside)
        kept &= ~np.isin(top, list(outer))
        if np.array_equal(kept, touches):
            break
        touches = kept
    return -4.0 * float(found[top[touches], 2].sum()), force


def wave(kind: str, cell: float) -> tuple[float, float]:
    """The first frequency of a free bar along its axis: √(E/ρ) / 2 L, less a little.

    What is less: Rayleigh's correction for the motion across, ½ (ν π k / L)² with k² = a²/6.
    """
    network = block(kind, (LENGTH, SIDE, SIDE), cell)
    theory = np.sqrt(YOUNG / DENSITY) / (2.0 * LENGTH)
    theory *= 1.0 - 0.5 * (RATIO * pi / LENGTH) ** 2 * SIDE**2 / 6.0
    mass = np.repeat(network.mass, 3)
    values, shapes = eigsh(
        matrix(network), k=12, M=diags(mass, format="csc"), sigma=(2.0 * pi * theory) ** 2
    )
    x = network.position[:, 0] - LENGTH / 2.0
    best = max(
        range(12), key=lambda k: abs(shapes[::3, k] @ (network.mass * np.sin(pi * x / LENGTH)))
    )
    return float(np.sqrt(values[best])) / (2.0 * pi), float(theory)


TESTS: dict[str, Test] = {
    "tension": tension,
    "pure bending": bending,
    "torsion": torsion,
    "clamped compression": against_elements((SIDE, SIDE, SIDE), 2, 2),
    "clamped shear": against_elements((SIDE, SIDE, SIDE), 2, 0),
    "cantilever": against_elements((LENGTH, SIDE, SIDE), 0, 2),
    "Hertz": hertz,
    "wave along a bar": wave,
}


def laplace(times: int) -> float:
    """Return the pressure in a widened sphere over 2 E t ε / (1 - ν) R, with ν = 1/3."""
    mesh = f"sphere {{ centre = (0, 0, 0) mm; radius = 20 mm; subdivisions = {times} }}"
    text = SCENE.replace("MESH", mesh).replace("is gel }", "is gel; thickness = 1 mm }")
    network = tissuec.compile(text).network
    x, strain = network.position, 1e-3
    force = (matrix(network) @ (strain * x).ravel()).reshape(-1, 3)
    a, b, c = np.moveaxis(x[network.skin], 1, 0)
    volume = np.einsum("fk,fk->", a, np.cross(b, c)) / 6.0
    # The work against a pressure: p dV = f · dx, with dV = 3 V ε.
    pressure = float(np.vdot(force, strain * x)) / (3.0 * volume * strain)
    radius = 20e-3
    return pressure / (2.0 * YOUNG * 1e-3 * strain / ((1.0 - 1.0 / 3.0) * radius))


def rows() -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table: measured over theory, at three resolutions."""
    for name, test in TESTS.items():
        for kind in KINDS:
            found = [test(kind, SIDE / count) for count in CELLS]
            yield row(name, kind, [measured / theory for measured, theory in found])
    yield row("Laplace's law", "sphere", [laplace(times) for times in (1, 2, 3)])


def row(name: str, kind: str, parts: list[float]) -> tuple[str, ...]:
    """Return a row, and tell it."""
    found = (name, kind, *(f"{part:.3f}" for part in parts))
    tell(" | ".join(found))
    return found


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure everything."""
    heads = ("test", "mesh", *(f"{count} cells" for count in CELLS))
    publish("elasticity", {"theory": table(heads, list(rows()))}, write=write)


if __name__ == "__main__":
    main()
