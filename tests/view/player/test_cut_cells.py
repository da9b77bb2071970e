"""A body whose cells were cut: pages, pictures, plots and sections show both pieces."""

import numpy as np
import pytest

from tests.results.cut_block import CUT, FRAMES, SHARE, TIMES, H, cut_block
from tissuec.results.recording import EventSide
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.lifetimes import is_there
from tissuec.view.player.options import Options
from tissuec.view.player.page import render
from tissuec.view.player.reading import read_film
from tissuec.view.plots.frame_reader import largest_displacements
from tissuec.view.section.plane import SectionPlane

WHOLE = 16 * H**3


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = cut_block().saved(tmp_path_factory.mktemp("cut") / "block.vtkhdf")
    with Trajectory.open(path) as found:
        yield found


def enclosed(points, triangles):
    """Return the volume within triangles, and the sum of their outward areas."""
    a, b, c = points[triangles].swapaxes(0, 1)
    across = np.cross(b - a, c - a) / 2.0
    return np.einsum("tx,tx->", a, across) / 3.0, across.sum(axis=0)


@pytest.mark.parametrize("frame", [0, CUT - 1, CUT, FRAMES - 1])
def test_a_film_shows_closed_pieces_and_fills_them(result, frame):
    film = read_film(result, Options())
    assert film.node_count == 81 and film.cells.filled == ("block",)
    there = is_there(film.skin.life, frame)
    place = film.position[frame]
    volume, area = enclosed(place, film.skin.triangles[there])
    assert volume == pytest.approx(WHOLE, rel=1e-12, abs=0.0)
    assert np.abs(area).max() < 1e-12 * H**2
    assert not film.skin.hollow.any()
    corners = place[film.cells.there(frame)]
    sides = corners[:, 1:] - corners[:, :1]
    assert np.abs(np.linalg.det(sides)).sum() / 6.0 == pytest.approx(WHOLE, rel=1e-12, abs=0.0)
    assert len(film.cells.there(frame)) == (96 if frame < CUT else 72 + 48)
    assert not len(film.dots.of)


def test_fields_of_a_film_reach_cut_faces(result):
    film = read_film(result, Options())
    for frame in range(FRAMES):
        values, place = film.fields["von Mises stress"][frame], film.position[frame]
        np.testing.assert_allclose(values, place[:, 0] + 1.0, rtol=1e-6)
    assert not film.force[:, 63:].any() and film.force[:, :63].any()
    # Each point has the mean of the parts around it, once each: numbers are those of entities.
    stress = film.fields["stress tensor"][-1]
    block, around = cut_block(), [set[int]() for _ in range(81)]
    for cell, entity in zip(block.solid.nodes, block.solid.walls, strict=True):
        if entity not in block.crossed:
            for node in cell:
                around[node].add(int(entity))
    for corners, entity in zip(block.table.corners, block.table.owners, strict=True):
        for point in corners:
            around[point].add(int(entity))
    wanted = [3.0 * np.mean([*one]) if one else np.nan for one in around]
    np.testing.assert_allclose(stress, wanted, rtol=1e-6)


def test_places_without_matter_are_left_out_of_the_frame(result):
    film = read_film(result, Options())
    assert len(film.matter) == 63  # 45 nodes as drawn, and 18 corners on the cut
    assert set(film.matter) == {*range(45), *range(63, 81)}


def test_places_without_matter_do_not_count_as_displaced(tmp_path):
    block, rows = cut_block(), slice(0, 1)
    place = block.positions()[rows]
    place[:, 45:] += 1.0
    with block.open(tmp_path / "a.vtkhdf") as writer:
        writer.topology(block.alive(CUT), block.table)
        writer.frames(TIMES[rows], place, place, block.fields(rows))
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as result:
        assert largest_displacements(result) == [0.0]
        found = DrawnNodes(read_film(result, Options()), result).displacement
        assert not found[:, 45:63].any() and found[:, 63:].any()  # copies, points on the cut


@pytest.mark.parametrize(
    "options", [Options(), Options(nodes=40), Options(field="displacement")]
)
def test_a_page_opens(result, options):
    page = render(result, options)
    assert '"name":"block"' in page and len(page) > 50_000


def test_simplified_pages_keep_the_gap(result):
    film = read_film(result, Options(nodes=40))
    along = film.position[-1] @ [np.cos(0.5), np.sin(0.5), 0.0]
    low, high = (along[film.skin.triangles].min(axis=1), along[film.skin.triangles].max(axis=1))
    last = is_there(film.skin.life, FRAMES - 1)
    middle = (1 + SHARE) * H + 2.5e-3
    assert last.any() and not (last & (low < middle) & (high > middle)).any()


def test_a_section_has_the_area_of_both_pieces(result):
    from tissuec.view.section.cross_section import section

    plane = SectionPlane((0.0, 0.0, 1.0), 9e-3)
    film = read_film(result, Options(section=plane))
    for frame in (0, FRAMES - 1):
        cut = section(film, frame, plane)
        assert cut.areas(len(film.tissues)).sum() == pytest.approx(8 * H**2, rel=1e-9, abs=0.0)


def test_sides_of_the_cut_are_moments_of_a_film(tmp_path):
    """Just after the cut, the parts are there at its time, between frames."""
    block = cut_block()
    with block.open(tmp_path / "a.vtkhdf") as writer:
        place, fields = block.positions(), block.fields(slice(None))
        for frame in range(FRAMES):
            rows = slice(frame, frame + 1)
            if frame == 0:
                writer.topology(block.alive(0))
            if frame == CUT:
                time = TIMES[CUT] - 0.05
                sides = [
                    EventSide(
                        time, place[at], place[at],
                        {name: each[at] for name, each in fields.items()}, block.alive(at),
                    )
                    for at in (CUT - 1, CUT)
                ]  # fmt: skip
                writer.sides(*sides)
                writer.topology(block.alive(CUT), block.table)
            found = {name: each[rows] for name, each in fields.items()}
            writer.frames(TIMES[rows], place[rows], place[rows], found)
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as result:
        film = read_film(result, Options())
        assert film.is_side.sum() == 2
        before, after = np.flatnonzero(film.is_side)
        assert len(film.cells.there(before)) == 96 and len(film.cells.there(after)) == 120
        for row in (before, after):
            volume, _ = enclosed(
                film.position[row], film.skin.triangles[is_there(film.skin.life, row)]
            )
            assert volume == pytest.approx(WHOLE, rel=1e-12, abs=0.0)
        stress = film.fields["stress tensor"][after]
        assert np.isfinite(stress[63:]).all()
        shown = result.sides.fields["stress tensor"]
        assert shown.shape == (2, 24, 6)
        assert np.array_equal(shown[1][16:, 0], block.parts) and not shown[0][16:].any()


def test_plots_of_frames_and_sections_show_the_gap(result):
    from tissuec.view.plots import draw

    path = result.path
    figure = draw("frames", path, times=(TIMES[0], TIMES[-1]), show="skin", view=(-90.0, 90.0))
    for axes, gap in zip(figure.axes, (0.0, 5.0), strict=True):
        corners = np.concatenate(
            [one.vertices[:3] for c in axes.collections for one in c.get_paths()]
        )
        turn = 0.5 if gap else 0.0
        along = np.unique((corners @ [np.cos(turn), np.sin(turn)]).round(6))
        inner = along[(along > 12.0) & (along < 24.0)]
        wanted = [20.0] if not gap else [16.0, 21.0]
        assert (
            set(wanted) <= set(inner)
            and not ((inner > 16.01) & (inner < 20.99) & (gap > 0)).any()
        )
    figure = draw("frames", path, times=(TIMES[-1],), field="von Mises stress", show="skin")
    assert figure.axes
    figure = draw("frames", path, section="z = 9 mm", times=(TIMES[0], TIMES[-1]))
    for axes in figure.axes:
        total = 0.0
        for one in axes.collections:
            if type(one).__name__ == "PolyCollection":
                for p in one.get_paths():
                    x, y = p.vertices[:3].T
                    total += abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2.0
        assert total == pytest.approx(800.0, rel=1e-9)  # [mm2]
