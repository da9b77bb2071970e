"""Cracks in bodies of elements advance at the toughness of a tissue; statics as for springs."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from tests.matter.test_toughness import HEIGHT, TISSUE, TOUGH, WIDTH
from tissuec.core.source import Source
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SCENE = """\
language 1
tissue gel {{ {tissue}; Poisson's ratio = {ratio}; toughness = {tough} J/m^2 }}
body strip {{ mesh is {mesh}; tissue is gel; rupture is allowed }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""
MESHES = {
    "solid": "lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to ({width}, {thick}, "
    "{height}) mm }}",
    "wall": "sheet {{ corner = (0, 0, 0) mm; first edge = ({width}, 0, 0) mm; second edge = "
    "(0, 0, {height}) mm; columns = {columns}; rows = {rows} }}; thickness = {thick} mm",
}


def toughness_found(kind, rows, ratio, steps):
    """Return the energy per area at which a crack between clamped edges advances [J/m²].

    The strip is that of ``test_toughness``, two elements or 2 mm thick.

    Args:
        kind: "solid" or "wall".
        rows: Of cells across the strip.
        ratio: Poisson's ratio.
        steps: How many times what comes next is removed.
    """
    cell = HEIGHT / rows
    columns = round(WIDTH / cell)
    width, thick = cell * columns, 2 * cell if kind == "solid" else 2.0
    mesh = MESHES[kind].format(
        cell=cell, width=width, thick=thick, height=HEIGHT, columns=columns + 1, rows=rows + 1
    )
    text = SCENE.format(tissue=TISSUE, ratio=ratio, tough=TOUGH, mesh=mesh)
    network = compile_request(Request(Source("strip.tis", text)))[0].network
    (field,) = network.elements
    x, number = network.position, np.arange(network.node_count)
    by = np.zeros_like(x)
    by[np.isclose(x[:, 2], HEIGHT * 1e-3), 2] = 1e-5
    is_held = np.isclose(x[:, 2], 0.0) | np.isclose(x[:, 2], HEIGHT * 1e-3)
    is_still = np.repeat(is_held, 3)
    is_still[1::3] |= kind == "wall"  # which does not resist across itself

    def drawn(there):
        matrix = there.matrix(0.0, x, number, len(x)).tocsr()
        used = np.zeros(len(x), dtype=bool)
        used[there.nodes] = True
        free = np.repeat(used, 3) & ~is_still
        u = by.ravel().copy()
        u[free] = spsolve(matrix[free][:, free].tocsc(), -(matrix @ u)[free])
        return x + u.reshape(-1, 3)

    middle = x[field.nodes].mean(axis=1)
    # Of the strip without a crack, weighted towards its middle.
    half = 0.25e-3 * width
    weight = np.clip(1.5 - np.abs(middle[:, 0] - 0.5e-3 * width) / half, 0.0, 1.0)
    energy = weight @ field.energies(drawn(field)) / (2.0 * half * 1e-3 * thick)
    is_cut = (np.abs(middle[:, 2] - 0.5e-3 * HEIGHT) < 0.3e-3 * cell) & (
        middle[:, 0] < 0.35e-3 * width
    )
    there, found = field.without(np.flatnonzero(is_cut)), []
    for _ in range(steps):
        loads = there.breakable.loads(drawn(there))
        found.append(energy / loads.max())
        there = there.without(np.flatnonzero(loads > loads.max() * (1.0 - 1e-4)))
    return max(found)


# By a breaking strain, a crack would need 1.6 times as much with the cells of the first mesh.
@pytest.mark.parametrize(
    ("kind", "ratio", "due"),
    [
        ("solid", 0.25, (0.78, 0.85)), ("solid", 0.45, (0.95, 1.05)),
        ("wall", 0.0, (0.89, 0.93)), ("wall", 0.25, (0.93, 0.98)), ("wall", 0.45, (0.98, 1.04)),
    ],
)  # fmt: skip
def test_a_crack_needs_about_the_toughness_on_every_mesh(kind, ratio, due):
    coarse, fine = (toughness_found(kind, rows, ratio, 6) / TOUGH for rows in (7, 11))
    assert (coarse, fine) == pytest.approx(due, abs=0.03)
