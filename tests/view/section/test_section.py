"""Bodies cut open: areas, tissues, stills, pages, and planes that meet nothing."""

import numpy as np
import pytest

import tissuec
from tissuec.core.errors import TissueError
from tissuec.core.resources import library
from tissuec.geometry.blade_sections import plane_section
from tissuec.geometry.divisions import filling_tetrahedra
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.node_values import read_field
from tissuec.view.player.options import Options
from tissuec.view.player.page import render_film
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film
from tissuec.view.plots import draw
from tissuec.view.section import read_plane
from tissuec.view.section.cross_section import check_plane, clipped, section

SCENE = """language 1
use "tissues/fat"
tissue skin like fat { colour = "#d0a080" }
tissue lump like fat { colour = "#2040c0" }
body sample {
  mesh is lattice {
    box from (0, 0, 0) mm to (30, 30, 15) mm; cell = 2.5 mm
    kind is sodium chloride; reach is second neighbours
  }
  tissue is fat; interface is mean
  region cover where z > 12 mm { tissue is skin }
  region lump where within 5.2 mm of (15, 15, 6) mm { tissue is lump }
}
set top = nodes of sample where z > 14 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
script { from 0 s to 1 ms: move top by (0, 0, -1) mm using constant speed }
simulate { duration = 1 ms; integrator is velocity verlet; step = 2 us }
output { trajectory every 0.5 ms }
"""
BLUE = np.array([32, 64, 192]) / 255.0


@pytest.fixture(scope="module")
def run():
    return tissuec.run(SCENE, companion="off")


@pytest.fixture(scope="module")
def film(run):
    return read_film(run, Options())


def test_the_section_of_the_indentation_is_its_square():
    network = tissuec.compile(library() / "scenes" / "indentation.tis").network
    body = network.bodies[0]
    cells = filling_tetrahedra(network.position[body.nodes], network.skin_of(body))
    cut = plane_section(network.position, cells, np.array([0.0, 0.0, 1.0]), 7e-3)
    assert cut.areas(network.position).sum() == pytest.approx(900e-6, rel=1e-9)


def test_areas_of_tissues_add_up(film):
    cut = section(film, 0.0, read_plane("z = 7.3 mm"))
    areas = dict(zip(film.tissues, cut.areas(len(film.tissues)), strict=True))
    assert set(areas) == {"fat", "skin", "lump"}
    assert sum(areas.values()) == pytest.approx(900e-6)
    assert areas["skin"] == 0.0
    # Half a cell around its three by three nodes belongs to the lump.
    assert areas["lump"] == pytest.approx(7.5e-3**2, rel=0.05)
    skin = film.tissues.index("skin")
    aside = section(film, 0.0, read_plane("x = 4 mm"))
    assert aside.areas(3)[skin] == pytest.approx(30e-3 * 3.75e-3, rel=1e-9)
    upright = section(film, 0.0, read_plane("x = 14 mm"))
    # Where three tissues meet, at both sides of the lump, skin has a corner more.
    assert 0.0 < upright.areas(3)[skin] - 30e-3 * 3.75e-3 < 2 * 0.5 * 1.25e-3**2
    assert upright.area.sum() == pytest.approx(450e-6)


def test_outlines_separate_the_colours_of_tissues(film):
    """Between two near points in different tissues there is a border."""
    cut = section(film, 0.0, read_plane("x = 14 mm"))
    near = 5e-5  # [m]
    points = np.random.default_rng(1).uniform([1e-4, 1e-4], [29.9e-3, 14.9e-3], size=(3000, 2))
    a, b, c = (cut.pieces[:, k, 1:] for k in range(3))

    def tissue(at):
        """Return the tissue of the piece around each point."""

        def side(p, q):
            return (q[:, 0] - p[:, 0]) * (at[:, None, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (
                at[:, None, 0] - p[:, 0]
            )

        turns = np.stack([side(a, b), side(b, c), side(c, a)])
        inside = (turns >= 0.0).all(axis=0) | (turns <= 0.0).all(axis=0)
        assert inside.any(axis=1).all()
        return cut.tissue[inside.argmax(axis=1)]

    differ = points[tissue(points) != tissue(points + np.array([0.0, near]))]
    assert len(differ) > 10
    first, way = cut.borders[:, 0, 1:], np.diff(cut.borders, axis=1)[:, 0, 1:]
    part = ((differ[:, None] - first) * way).sum(axis=2) / (way**2).sum(axis=1)
    foot = first + np.clip(part, 0.0, 1.0)[..., None] * way
    assert np.linalg.norm(foot - differ[:, None], axis=2).min(axis=1).max() <= near


def test_outlines_go_round_the_body_and_its_tissues(film):
    cut = section(film, 0.0, read_plane("x = 14 mm"))
    size = np.linalg.norm(np.diff(cut.borders, axis=1)[:, 0], axis=1)
    on_rim = (np.abs(cut.borders[..., 1] - 15e-3) > 15e-3 - 1e-9).all(axis=1)
    on_rim |= (np.abs(cut.borders[..., 2] - 7.5e-3) > 7.5e-3 - 1e-9).all(axis=1)
    assert size[on_rim].sum() == pytest.approx(90e-3)
    # Along the layer of skin, 30 mm, and round the lump.
    assert 30e-3 + 25e-3 < size[~on_rim].sum() < 30e-3 + 55e-3


def test_a_still_shows_the_lump_only_in_section(run):
    def blue(options):
        pixels = Painter(read_film(run, options), options, (200, 160), "").pixels(0.0) / 255.0
        hue = pixels / np.maximum(np.linalg.norm(pixels, axis=2, keepdims=True), 1e-9)
        return (hue @ (BLUE / np.linalg.norm(BLUE)) > 0.95).sum()

    view = (-90.0, 60.0)
    assert blue(Options(view=view)) == 0
    assert blue(Options(view=view, section=read_plane("z = 7.3 mm"))) > 300
    assert blue(Options(view=view, section=read_plane("z = 11.9 mm"))) == 0


def test_the_side_towards_the_camera_is_hidden(run):
    for azimuth in (-90.0, 90.0):
        options = Options(view=(azimuth, 0.0), section=read_plane("y = 14 mm"))
        painter = Painter(read_film(run, options), options, (120, 90), "")
        seen = painter.pixels(0.0)[20:-20].astype(int)
        assert (seen[..., 2] > seen[..., 0] + 40).sum() > 100  # the lump, from either side


def test_clipping_keeps_what_is_behind():
    rng = np.random.default_rng(7)
    corners = rng.normal(size=(200, 3, 3))
    height = corners[..., 2] - 0.2
    parts, of = clipped(corners, height)
    assert parts[..., 2].max() <= 0.2 + 1e-12

    def areas(triangles):
        a, b, c = triangles.swapaxes(0, 1)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0

    front, other = clipped(corners, -height)
    whole = np.bincount(of, areas(parts), 200) + np.bincount(other, areas(front), 200)
    assert whole == pytest.approx(areas(corners))


def test_a_plane_that_meets_nothing_is_answered_with_the_reach(film):
    check_plane(film, read_plane("z = 14.5 mm"), 0.0)
    with pytest.raises(
        TissueError, match=r"z = 60 mm meets nothing at 0 ms: .* 0 to 15 mm in z"
    ):
        check_plane(film, read_plane("z = 60 mm"), 0.0)
    check_plane(film, read_plane("z = 14.5 mm"), None)
    with pytest.raises(TissueError, match=r"at any time: .* in that direction.* at 42.4 mm"):
        check_plane(film, read_plane("through (0, 0, 60) mm facing (0, 1, 1)"), None)


@pytest.fixture
def opened(page, run, film, tmp_path):
    """The page in a browser, cut open at z = 7.3 mm."""
    options = Options(section=read_plane("z = 7.3 mm"), view=(-90.0, 60.0))
    path = tmp_path / "page.html"
    path.write_text(render_film(film, run, options), encoding="utf-8")
    page.set_viewport_size({"width": 800, "height": 600})
    page.goto(path.as_uri())
    assert page.evaluate("tissuec.ready")
    return page


def test_the_page_cuts_as_python_does(opened, film):
    def state():
        opened.evaluate("tissuec.draw()")
        return opened.evaluate("tissuec.state()")["section"]

    assert state()["isOn"]
    for name, offset in (("z", 7.3e-3), ("x", 14e-3), ("y", 3.1e-3)):
        opened.evaluate("([name, offset]) => tissuec.cut(name, offset)", [name, offset])
        for time in (0.0, 0.8e-3):
            opened.evaluate("time => tissuec.seek(time)", time)
            at = np.interp(time, film.times, np.arange(len(film.times)))
            cut = section(film, float(at), read_plane(f"{name} = {offset} m"))
            shown = state()
            assert shown["polygons"] == len(cut.polygons.cell)
            assert shown["area"] == pytest.approx(cut.area.sum(), rel=1e-4)


def test_the_page_shows_the_lump_and_has_labels(opened):
    from tests.view.player.test_player_in_a_browser import pixels

    def blue():
        opened.evaluate("tissuec.draw()")
        seen = pixels(opened)
        return (seen[..., 2] > seen[..., :2].max(axis=2) + 40).sum()

    slider = opened.locator("#place")
    assert blue() > 300
    assert slider.get_attribute("aria-valuetext") == "z = 7.3 mm"
    assert "cut face 900 mm²" in opened.locator("#where").inner_text()
    handle = opened.locator("#handle").bounding_box()
    opened.mouse.move(handle["x"] + 10, handle["y"] + 10)
    opened.mouse.down()
    opened.mouse.move(handle["x"] + 10, handle["y"] - 20)
    opened.mouse.up()
    assert opened.evaluate("tissuec.state()")["section"]["offset"] > 8e-3
    slider.focus()
    opened.keyboard.press("Home")
    lowest = opened.evaluate("tissuec.state()")["section"]["offset"]
    assert lowest == pytest.approx(0.0, abs=1e-5)
    opened.evaluate("document.activeElement.blur()")
    opened.keyboard.press("x")
    assert blue() == 0 and not opened.locator("#cutting").is_visible()
    opened.keyboard.press("x")
    opened.locator("#across").select_option("view")
    assert opened.locator("#place").get_attribute("aria-valuetext").startswith("distance = ")
    opened.set_viewport_size({"width": 390, "height": 844})
    assert opened.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_cut_face_has_the_colours_of_the_field(run):
    options = Options(view=(-90.0, 0.0), section=read_plane("y = 14 mm"))
    film = read_film(run, options)
    field = read_field(DrawnNodes(film, run), "displacement")
    last = float(len(film.times) - 1)
    pixels = Painter(film, options, (240, 180), "", field=field).scene(last) / 255.0
    body = np.flatnonzero(np.ptp(pixels[:, 60], axis=1) > 0.05)
    light = pixels[body, 60].mean(axis=1)
    # What is pressed moves most, which is yellow; the rest is at rest, which is dark blue.
    assert light[3] - light[-3] > 0.2
    blue = pixels[body[-3], 60]
    assert blue[2] > blue[0] + 0.1


def test_only_nodes_behind_the_plane_are_read_off(opened):
    box = opened.locator("#view").bounding_box()
    found = []
    for x in np.linspace(0.2, 0.8, 9):
        for y in np.linspace(0.2, 0.8, 7):
            opened.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])
            opened.wait_for_timeout(30)
            found.append(opened.evaluate("tissuec.picked()"))
    heights = [one["position"][2] for one in found if one]
    assert len(heights) > 10 and max(heights) <= 7.3e-3
    opened.focus("#view")
    for key in ("Alt+ArrowUp", "Alt+ArrowRight", "Alt+ArrowUp", "Alt+ArrowUp"):
        opened.keyboard.press(key)
        assert opened.evaluate("tissuec.picked()")["position"][2] <= 7.3e-3


def test_a_plane_that_meets_no_skin_is_answered(tmp_path):
    scene = """language 1
tissue silk { spring constant = 200 N/m; viscosity = 0.5 N*s/m; mass = 1 g }
body cord {
  mesh is thread { line from (0, 0, 0) mm to (20, 0, 0) mm; pieces = 4; thickness = 1 mm }
  tissue is silk
}
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""
    with pytest.raises(TissueError, match="x = 10 mm meets no skin and no filled body"):
        draw("frames", tissuec.run(scene, companion="off"), section="x = 10 mm")
