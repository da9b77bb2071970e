"""Filled bodies show their inside where they are cut or torn."""

import numpy as np
import pytest

import tissuec
from tissuec.geometry.divisions import filling_tetrahedra, volumes
from tissuec.geometry.edges import volume
from tissuec.meshes.generators.lattice import Lattice
from tissuec.view.player.cells import SolidCells, capped
from tissuec.view.player.lifetimes import FOREVER, is_there
from tissuec.view.player.options import Options
from tissuec.view.player.reading import read_film

BLOCK = """language 1
use "tissues/fat"
body block {
  mesh is MESH
  tissue is fat
  mass = 16 g
}
set right = nodes of block where x > 39 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 50 mN*s/m }
script {
  at 5 ms: cut block along plane through (17, 0, 0) mm facing (1, 0, 0.1)
  from 5 ms to 20 ms: move right by (8, 0, 2) mm using smooth profile
}
simulate { duration = 20 ms; integrator is velocity verlet; step = 50 us }
output { trajectory every 5 ms }
"""
LATTICE = """lattice {
    kind is sodium chloride; cell = 5 mm; reach is second neighbours
    box from (0, 0, 0) mm to (40, 20, 10) mm
  }"""
IMPORTED = """imported { file "bar.obj" in mm; filling is tetrahedra; cell = 8 mm }"""


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    """The films of a filled lattice and of a tetrahedral body that are cut in two."""
    from tests.matter.shapes import as_obj, surface

    folder = tmp_path_factory.mktemp("cut")
    (folder / "bar.obj").write_text(as_obj(*surface((40.0, 20.0, 20.0), 5.0)))
    films = {}
    for name, mesh in (("lattice", LATTICE), ("imported", IMPORTED)):
        (folder / f"{name}.tis").write_text(BLOCK.replace("MESH", mesh))
        result = tissuec.run(folder / f"{name}.tis", companion="off")
        films[name] = read_film(result, Options())
    return films


def edges_of(triangles):
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(sides, axis=0, return_counts=True)


@pytest.mark.parametrize("name", ["lattice", "imported"])
def test_skin_and_caps_close_the_surface_after_a_cut(cut, name):
    film = cut[name]
    assert film.cells.filled == ("block",) and not film.skin.hollow.any()
    shown = []
    for frame in range(len(film.times)):
        triangles = film.skin.triangles[is_there(film.skin.life, frame)]
        shown.append(len(triangles))
        assert (edges_of(triangles)[1] % 2 == 0).all()
        assert len(np.unique(np.sort(triangles, axis=1), axis=0)) == len(triangles)
    assert shown[-1] > shown[0]
    # All four sides of both pieces are there, and the wall of the cut is not where it was.
    whole, parted = film.cells.there(0), film.cells.there(len(film.times) - 1)
    assert 0.7 * len(whole) < len(parted) < len(whole)


def test_the_surface_encloses_the_tetrahedra_that_are_there(cut):
    film = cut["lattice"]
    for frame in range(len(film.times)):
        triangles = film.skin.triangles[is_there(film.skin.life, frame)]
        place = np.asarray(film.position[frame], dtype=float)
        content = volumes(place, film.cells.there(frame)).sum()
        assert volume(place, triangles) == pytest.approx(content, rel=1e-12)
    # A layer of cells is gone: 5 of 40 mm, and more where the plane is oblique.
    assert 0.7 < len(film.cells.there(8)) / len(film.cells.tetrahedra) < 0.9


def test_caps_close_whatever_is_torn():
    mesh = Lattice("diamond", 1.0, (np.zeros(3), np.full(3, 3.0)), "second neighbours").build()
    skin, rng = mesh.skin.astype(np.int64), np.random.default_rng(3)
    cells = filling_tetrahedra(mesh.position, skin)
    death = np.where(rng.random(len(cells)) < 0.3, rng.integers(1, 9, len(cells)), FOREVER)
    solid = SolidCells(cells, death, ("block",), ())
    life = np.tile([0.0, FOREVER], (len(skin), 1))
    drawn = capped(skin, life, solid)
    for frame in (0.0, 1.0, 4.5, 8.0):
        triangles = drawn.triangles[is_there(drawn.life, frame)]
        assert (edges_of(triangles)[1] % 2 == 0).all()
        content = volumes(mesh.position, solid.there(frame)).sum()
        assert volume(mesh.position, triangles) == pytest.approx(content)


@pytest.mark.parametrize("bending", ["", "bending is soft"])
def test_shells_are_not_filled(bending):
    mesh = "sphere { centre = (0, 0, 0) mm; radius = 20 mm; subdivisions = 2 }"
    scene = BLOCK.replace("MESH", mesh).split("set right")[0]
    scene = scene.replace("tissue is fat\n", f"tissue is fat\n  {bending}\n")
    result = tissuec.run(
        scene + "environment { gravity = (0, 0, 0) m/s^2 }\nsimulate { duration = 1 ms }\n"
        "output { trajectory every 1 ms }\n", companion="off",
    )  # fmt: skip
    film = read_film(result, Options())
    assert not len(film.cells.tetrahedra) and film.skin.hollow.all()


def test_bodies_without_inner_nodes_may_be_filled():
    slab = LATTICE.replace("(40, 20, 10)", "(40, 20, 5)")
    result = tissuec.run(BLOCK.replace("MESH", slab), companion="off")
    assert read_film(result, Options()).cells.filled == ("block",)


def test_large_bodies_are_divided_only_for_a_section(monkeypatch):
    from tissuec.view.player import reading
    from tissuec.view.player.page import render_film
    from tissuec.view.section import read_plane

    monkeypatch.setattr(reading, "MOST_NODES", 10)
    result = tissuec.run(BLOCK.replace("MESH", LATTICE), companion="off")
    film = read_film(result, Options())
    assert film.cells.left_out == ("block",) and not len(film.cells.tetrahedra)
    assert "block has more than" in render_film(film, result)
    asked = read_film(result, Options(section=read_plane("z = 5 mm"), cells=False))
    assert asked.cells.filled == ("block",)


def test_thinned_bodies_stay_filled():
    uncut = BLOCK.replace("MESH", LATTICE).replace("  at 5 ms: cut", "  # cut")
    result = tissuec.run(uncut, companion="off")
    whole, few = (read_film(result, Options(nodes=nodes)) for nodes in (None, 100))
    assert few.node_count < 110 < whole.node_count
    content = volumes(np.asarray(few.position[0], dtype=float), few.cells.tetrahedra)
    assert np.abs(content).sum() == pytest.approx(8e-6, rel=0.35)  # some lie over others
