"""What moves is drawn more simply where drawing is slow, and in full as soon as it rests."""

from pathlib import Path

import numpy as np
import pytest

import tissuec
from tests.view.player.conftest import Show, grid
from tests.view.player.test_cells import BLOCK, LATTICE
from tests.view.player.test_player_in_a_browser import pixels, state
from tissuec.results.trajectory import Trajectory
from tissuec.view.player import page as player_page
from tissuec.view.player.page import render

pytest.importorskip("playwright", reason="a browser is driven by playwright")
WEB = Path(player_page.__file__).parent / "web"
# A browser in which pictures take long, as its clock says; it counts what they contain.
SLOW = """<script>
  const request = requestAnimationFrame;
  window.factor = 1;
  window.requestAnimationFrame = (act) => request((now) => act(window.factor * now));
  const draw = WebGL2RenderingContext.prototype.drawElements;
  WebGL2RenderingContext.prototype.drawElements = function (mode, count, ...rest) {
    window.most = Math.max(window.most ?? 0, count);
    return draw.call(this, mode, count, ...rest);
  };
</script>"""


@pytest.fixture
def slow(page, tmp_path):
    """Return a function that opens the page of a result in a slow browser."""

    def open_page(trajectory):
        text = render(trajectory).replace("<head>", f"<head>{SLOW}", 1)
        (tmp_path / "page.html").write_text(text, encoding="utf-8")
        page.set_viewport_size({"width": 500, "height": 400})
        page.goto((tmp_path / "page.html").as_uri())
        assert page.evaluate("tissuec.ready")
        return page

    return open_page


def most_drawn(page):
    """Return how many springs the next picture has: six corners each."""
    page.evaluate("window.most = 0")
    page.evaluate("tissuec.draw()")
    return page.evaluate("window.most") / 6


def test_pictures_are_simple_while_they_are_slow_and_full_at_rest(slow, shown):
    page = slow(shown(Show(grid(50, 50))))  # 7301 springs
    page.evaluate("tissuec.set('springs', true)")
    page.evaluate("tissuec.draw()")
    width = page.locator("#view").evaluate("canvas => canvas.width")
    full = most_drawn(page)
    before = state(page)["pictures"]
    # One picture for a time, whether it is awaited or asked for.
    page.evaluate("tissuec.seek(0.01)")
    page.evaluate("new Promise((act) => setTimeout(() => requestAnimationFrame(act), 100))")
    assert state(page)["pictures"] == before + 1
    page.evaluate("tissuec.seek(0.02).then(() => tissuec.draw())")
    page.evaluate("new Promise((act) => setTimeout(() => requestAnimationFrame(act), 100))")
    assert state(page)["pictures"] == before + 2
    first = pixels(page)
    page.evaluate("window.factor = 8")
    page.keyboard.press(" ")
    # All at the same moment: how slow pictures are is measured, and differs between them.
    page.wait_for_function(
        """width => tissuec.state().then(({ form }) => form === 3
          && Math.abs(document.querySelector("#view").width - width / 2) <= 1
          && document.querySelector("#fewer").innerText
            === "while moving: 82 % of the springs")""",
        arg=width,
    )
    page.keyboard.press(" ")
    page.evaluate("window.factor = 1")
    page.wait_for_function("tissuec.state().then(({ form }) => form === 0)")
    assert not page.locator("#fewer").is_visible() and most_drawn(page) == full
    page.evaluate("tissuec.seek(0.02).then(() => tissuec.draw())")
    assert np.array_equal(pixels(page), first)


def test_what_is_turned_is_simple_until_it_rests(slow, shown):
    page = slow(shown(Show(grid(6, 6))))
    page.evaluate("window.factor = 3")
    simple = page.evaluate(
        """async () => {
          for (let i = 0; i < 200; i += 1) {
            await tissuec.look(i, 30);
            await new Promise(requestAnimationFrame);
            if ((await tissuec.state()).form > 0) return true;
          }
          return false;
        }"""
    )
    assert simple
    page.wait_for_function("tissuec.state().then(({ form }) => form === 0)")


def test_pictures_are_tried_in_full_again_after_many_quick_ones_but_only_twice(page):
    script = (WEB / "haste.js").read_text(encoding="utf-8")
    levels = page.evaluate(
        script
        + """;
        const haste = new Haste(), found = [];
        for (let i = 0; i < 4; i += 1) {
          for (let k = 0; k < 3; k += 1) haste.take(50);  // of something else, or by themselves
          found.push(haste.level);
          for (let k = 0; k < 500; k += 1) haste.take(15);
          found.push(haste.level);
        }
        found"""
    )
    assert levels == [1, 0, 1, 0, 1, 1, 2, 2]


def test_springs_in_a_closed_skin_are_drawn_only_where_they_can_be_seen(slow, tmp_path):
    lines = BLOCK.replace("MESH", LATTICE).splitlines()
    still = [line for line in lines if not line.strip().startswith(("at 5", "from 5", "set"))]
    path = tmp_path / "block.tis"
    path.write_text("\n".join(still), encoding="utf-8")
    result = tissuec.run(path, companion="off")
    with Trajectory.open(result.path) as trajectory:
        page = slow(trajectory)
        place, ends = trajectory.network.position, trajectory.ends
    camera = state(page)["camera"]
    a, e = np.radians([camera["azimuth"], camera["elevation"]])
    way = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    eye = np.array(camera["target"]) + camera["distance"] * way
    low, high = place.min(axis=0), place.max(axis=0)
    front = ((place < low + 1e-9) & (eye < low)) | ((place > high - 1e-9) & (eye > high))
    seen = front.any(axis=1)[ends].all(axis=1).sum()
    page.evaluate("tissuec.set('springs', true)")
    assert 0 < seen < len(ends) / 2 and most_drawn(page) == seen
    page.evaluate("tissuec.set('surface', 'glass')")
    assert most_drawn(page) == len(ends)
