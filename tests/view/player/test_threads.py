"""Threads have the colours of a field and are cut by a section: in pictures, and on pages."""

import numpy as np
import pytest

import tissuec
from tests.view.player.test_player_in_a_browser import SMALL, pixels
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.node_values import read_field
from tissuec.view.player.options import Options
from tissuec.view.player.page import render_film
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film
from tissuec.view.section import read_plane

CORD = """language 1
tissue silk { spring constant = 200 N/m; viscosity = 0.5 N*s/m; mass = 1 g }
body cord {
  mesh is thread { line from (0, 0, 0) mm to (20, 0, 0) mm; pieces = 4; thickness = 4 mm }
  tissue is silk
}
body pad {
  mesh is lattice {
    box from (0, 0, -20) mm to (20, 10, -10) mm; cell = 5 mm
    kind is sodium chloride; reach is second neighbours
  }
  tissue is silk
}
set end = nodes of cord where x > 19 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
script { from 0 s to 1 ms: move end by (0, 0, 1) mm using constant speed }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""
VIEW, RANGE = (-60.0, 20.0), (0.0, 1e-3)
OVER = "#triad, #ruler, #handle, #pulls"
#: Whatever the page asks for, there is no WebGL.
BARE = """const own = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind === "webgl2" ? null : own.call(this, kind, ...more);
};"""


@pytest.fixture(scope="module")
def run():
    return tissuec.run(CORD, companion="off")


def options(**more):
    return Options(field="displacement", range=RANGE, view=VIEW, time=1e-3, **more)


def cord(shot):
    """Return the part of a picture in which the cord is: its upper half, shape (…, 3)."""
    return shot[: len(shot) // 2 - 20].astype(int)


def share(shot):
    """Return which part is inked, and which part has the highest colour of the field."""
    seen = cord(shot)
    inked = np.ptp(seen, axis=2) > 25
    yellow = (seen[..., 0] > 150) & (seen[..., 0] > seen[..., 2] + 90)
    return inked.mean(), yellow.mean()


def check(picture):
    """Check the pictures of the cord, whole and in sections."""
    inked, yellow = share(picture(None))
    assert inked > 0.02 and 0.0 < yellow < 0.4 * inked  # its end alone has moved
    half, no_yellow = share(picture("x = 10 mm"))
    assert 0.25 * inked < half < 0.75 * inked and no_yellow == 0.0
    assert share(picture("z = -5 mm"))[0] < 0.3 * inked  # only the pad behind it


def test_pictures(run):
    def picture(plane):
        given = options(section=plane and read_plane(plane))
        film = read_film(run, given)
        field = read_field(DrawnNodes(film, run), "displacement").ranged(RANGE)
        return Painter(film, given, (400, 300), "", field=field).scene(len(film.times) - 1.0)

    check(picture)


@pytest.fixture(params=["with WebGL", "without"])
def opened(request, run, browser, tmp_path):
    """Return a page without what is drawn over the picture."""
    context = browser.new_context(viewport=SMALL)
    if request.param == "without":
        context.add_init_script(BARE)
    page, path = context.new_page(), tmp_path / "page.html"
    path.write_text(render_film(read_film(run, options()), run, options()), encoding="utf-8")
    page.goto(path.as_uri())
    page.add_style_tag(content=f"{OVER} {{ display: none !important }}")
    yield page
    context.close()


def seen(page, plane):
    """Return the picture of a page, cut by a plane along an axis; whole if there is none."""
    if plane is not None:
        name, place = read_plane(plane).axis, read_plane(plane).offset
        page.evaluate("([name, place]) => tissuec.cut(name, place)", [name, place])
    page.evaluate("tissuec.draw()")
    return pixels(page)


def test_pages(opened):
    check(lambda plane: seen(opened, plane))
    # The pad, seen from the front, has a straight upper edge.
    opened.evaluate("tissuec.set('field', 'tissue')")
    opened.evaluate("tissuec.look(-90, 0)")
    inked = np.ptp(seen(opened, "z = -13 mm"), axis=2) > 40
    heights = inked[:, inked.sum(axis=0) > 20].sum(axis=0)[10:-10]
    assert np.ptp(heights) <= 6 and len(heights) > 100
