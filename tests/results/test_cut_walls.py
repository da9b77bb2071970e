"""A wall that was cut: two pieces with straight edges, wherever it is shown."""

import numpy as np
import pytest

import tissuec
from tests.cuts.test_divided_walls import SHEET, scene
from tests.vtk_reading import frame
from tissuec.results.conversion import to_pyvista
from tissuec.results.export import frame_shape
from tissuec.results.shapes import write_vtu
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.lifetimes import is_there
from tissuec.view.player.options import Options
from tissuec.view.player.page import render
from tissuec.view.player.reading import read_film
from tissuec.view.plots.frame_reader import largest_displacements

pyvista = pytest.importorskip("pyvista")

ORDERS = "at 1.5 ms: cut block along plane through (11.2, 5, 0) mm facing (1, 0.2, 0)\n"
END = """output { trajectory with von Mises stress every 1 ms }
simulate { duration = 3 ms }
"""
BEHIND, WHOLE = 97e-6, 200e-6  # areas of a piece of the sheet, which has moved by 1.5 mm
EDGE = 10e-3 * np.sqrt(1.04)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A sheet that moves evenly, so that shapes stay as drawn."""
    text = scene(SHEET, 0, ORDERS, END)
    text = text.replace("tissue is gel;", "tissue is gel; velocity = (1, 0, 0) m/s;")
    text = text.replace("set base = nodes of block where x < 0.01 mm\n", "")
    found = tmp_path_factory.mktemp("cut") / "wall.vtkhdf"
    tissuec.run(text, out=found, companion="off")
    return found


def check_pieces(grid):
    """Check the areas of both pieces, and that there are two, with straight edges."""
    assert grid.integrate_data()["Area"][0] == pytest.approx(WHOLE, rel=1e-6)
    pieces = grid.connectivity().split_bodies()
    found = sorted(one.integrate_data()["Area"][0] for one in pieces)
    assert found == pytest.approx([BEHIND, WHOLE - BEHIND], rel=1e-6)
    outline = grid.extract_surface().extract_feature_edges(
        boundary_edges=True, feature_edges=False, manifold_edges=False
    )
    around = outline.compute_cell_sizes()["Length"].sum()
    assert around == pytest.approx(60e-3 + 2.0 * EDGE, rel=1e-6)


def test_vtk_shows_both_pieces(path):
    before, after = frame(path, 0), frame(path, 3)
    assert set(before.celltypes) == set(after.celltypes) == {5}
    assert before.n_cells == 64 and before.n_points < after.n_points
    assert before.integrate_data()["Area"][0] == pytest.approx(WHOLE, rel=1e-12)
    check_pieces(after)
    assert np.isfinite(after["von_mises_stress"]).all()


def test_an_exported_frame_is_the_same(path, tmp_path):
    with Trajectory.open(path) as result:
        shape = frame_shape(result, 3)
        write_vtu(shape, tmp_path / "frame.vtu")
        for one in (pyvista.read(tmp_path / "frame.vtu"), to_pyvista(shape)):
            check_pieces(one)


def test_blocks_show_both_pieces(path, tmp_path):
    from tissuec.results.blocks.pieces import BlockFrames

    with Trajectory.open(path) as result:
        BlockFrames(result, None).write(3, tmp_path / "frame.vtm")
    every = [each for each in pyvista.read(tmp_path / "frame.vtm") if each.n_cells]
    walls = [each for each in every if (each.celltypes == 5).any()]
    for each in walls:
        check_pieces(each.extract_cells(each.celltypes == 5))
    assert walls


@pytest.mark.parametrize("number", [0, 3])
def test_a_film_shows_clipped_triangles(path, number):
    with Trajectory.open(path) as result:
        film = read_film(result, Options())
        there = is_there(film.skin.life, number)
        a, b, c = film.position[number][film.skin.triangles[there]].swapaxes(0, 1)
        normal = np.cross(b - a, c - a) / 2.0
        assert normal[:, 2].sum() == pytest.approx(WHOLE, rel=1e-5)
        assert np.linalg.norm(normal, axis=1).sum() == pytest.approx(WHOLE, rel=1e-5)
        # Corners of the drawing, and points on the cut: no copies, where there is no matter.
        x = result.network.position[:45]
        place = film.position[0][film.matter]
        assert place[:, 0].max() < x[:, 0].max() + 1e-9
        assert len(film.matter) < result.network.node_count
        assert largest_displacements(result)[0] == pytest.approx(0.0, abs=1e-12)
        assert '"name":"block"' in render(result, Options())
