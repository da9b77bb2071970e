"""One tissue on five meshes: the same mass, stiffness, and curve at large strain."""

from pathlib import Path

import numpy as np
import pytest

import tissuec
from tests.forces.solid_cases import BAR, Case, drawn, lattice, tetrahedra, text_of
from tests.imports.organs import write_obj, write_vtk

#: 1 % and 30 % of the length, on which both ends stay as wide as they are drawn.
BAR_DRAWN = Case(
    "bar", BAR, "mN", (0.6, 8.4, 9.0), {0: "1 %", 2: "30 %"}, drawn,
    "move far by ({:.12g}, 0, 0) mm using constant speed", across=10.0, axis="x",
)  # fmt: skip


def grid(across: int, moved: float):
    """Return the nodes of cubes in the bar [mm], inner ones moved, and the corners of each."""
    counts, cell = (6 * across, across, across), 10.0 / across
    x = np.stack(np.meshgrid(*(np.arange(n + 1) for n in counts), indexing="ij"), axis=-1)
    number = np.arange(x[..., 0].size).reshape(x.shape[:-1])
    x = x.reshape(-1, 3) * cell
    inner = np.all((x > 0.01) & (x < np.array(BAR) - 0.01), axis=1)
    x[inner] += np.random.default_rng(5).uniform(-moved, moved, (inner.sum(), 3)) * cell
    around = [(0, 0), (1, 0), (1, 1), (0, 1)]
    corners = [
        number[i : i + counts[0], j : j + counts[1], k : k + counts[2]].ravel()
        for k in (0, 1)
        for i, j in around
    ]
    return x, np.stack(corners, axis=1)


def hexahedra(folder: Path) -> str:
    x, cells = grid(2, 0.15)
    write_vtk(folder / "cubes.vtk", x, cells)
    return 'imported { file "cubes.vtk" in mm }'


def wedges(folder: Path) -> str:
    x, cells = grid(2, 0.1)
    halves = [cells[:, [0, 1, 2, 4, 5, 6]], cells[:, [0, 2, 3, 4, 6, 7]]]
    write_vtk(folder / "wedges.vtk", x, np.concatenate(halves))
    return 'imported { file "wedges.vtk" in mm }'


def filled(folder: Path) -> str:
    x, cells = grid(2, 0.0)
    faces = np.array(
        [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    )
    every = cells[:, faces].reshape(-1, 4)
    _, which, count = np.unique(
        np.sort(every, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = every[which[count == 1]]
    used, numbers = np.unique(outer, return_inverse=True)
    quads = numbers.reshape(-1, 4)
    write_obj(folder / "bar.obj", x[used], np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]))
    return 'imported { file "bar.obj" in mm; filling is tetrahedra; cell = 6 mm }'


MESHES = {
    "lattice": lambda _: lattice(BAR_DRAWN, 2),
    "irregular hexahedra": hexahedra,
    "wedges": wedges,
    "tetrahedra": lambda folder: tetrahedra(BAR_DRAWN, 2, folder),
    "filled surface": filled,
}


def found_on(name: str, folder: Path) -> tuple[float, float, float]:
    """Return the mass [kg] and the forces at 1 % and at 30 % [mN]."""
    scene = folder / "bar.tis"
    scene.write_text(text_of(BAR_DRAWN, MESHES[name](folder)), encoding="utf-8")
    with tissuec.run(scene, companion="off") as run:
        assert run.finished
        mass = run.network.mass[: run.network.body_nodes].sum()
        return mass, *(BAR_DRAWN.measure(run, k + 1) for k in BAR_DRAWN.shown)


def test_one_tissue_is_the_same_on_five_meshes(tmp_path):
    mass, small, large = np.transpose([found_on(name, tmp_path) for name in MESHES])
    due = 1000.0 * np.prod(BAR) * 1e-9
    assert mass == pytest.approx(due, rel=1e-12)
    for forces in (small, large):  # 0.9 % and 1.2 % apart, and with half the cells 0.3 %
        assert np.ptp(forces) < 0.015 * forces.mean(), dict(zip(MESHES, forces, strict=True))
