"""The page in Chromium, from ``file://``; ``page`` fails a test that leaves problems behind."""

from io import BytesIO

import numpy as np
import pytest

from tests.view.player.conftest import Show, grid, without_springs
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request
from tissuec.view.player.camera import fitted, framing
from tissuec.view.player.lifetimes import Timeline
from tissuec.view.player.options import Options
from tissuec.view.player.page import fragment, render
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film

pytest.importorskip("playwright", reason="a browser is driven by playwright")
CUT = 0.7  # s
SMALL = {"width": 800, "height": 500}  # which is drawn in software


def state(page):
    return page.evaluate("tissuec.state()")


def seek(page, time):
    page.evaluate("time => tissuec.seek(time)", time)
    page.evaluate("tissuec.draw()")


def pixels(page, element="#view"):
    """Return what an element shows, shape (height, width, 3)."""
    Image = pytest.importorskip("PIL.Image")
    shot = page.locator(element).screenshot()
    return np.asarray(Image.open(BytesIO(shot)).convert("RGB")).astype(int)


@pytest.fixture
def opened(page, tmp_path):
    """Return a function that opens a page and waits until it plays."""

    def open_page(text, name="page.html"):
        (tmp_path / name).write_text(text, encoding="utf-8")
        page.set_viewport_size(SMALL)
        page.goto((tmp_path / name).as_uri())
        assert page.evaluate("tissuec.ready")
        return page

    return open_page


@pytest.fixture(scope="module")
def text(sterilisation):
    with Trajectory.open(sterilisation) as trajectory:
        return render(trajectory)


def test_the_cut_is_seen(opened, text):
    page = opened(text)
    page.keyboard.press("e")  # without resultant forces, whose names reach beyond the tube
    seek(page, 0.0)
    before, first = state(page), pixels(page)
    assert (before["springs"], before["triangles"]) == (610, 300)
    seek(page, CUT + 0.01)
    cut = state(page)
    assert (cut["springs"], cut["triangles"]) == (580, 280)
    seek(page, 1.2)
    after, last = state(page), pixels(page)
    assert after["springs"] == 580
    # The tube is elsewhere, and in two pieces: somewhere between the ends nothing is drawn.
    assert (np.abs(last - first).sum(axis=2) > 60).mean() > 0.02
    drawn = [(np.ptp(shot, axis=2) > 12).any(axis=0) for shot in (first, last)]
    inner = slice(*np.flatnonzero(drawn[0])[[0, -1]])
    assert drawn[0][inner].all() and not drawn[1][inner].all()
    seek(page, 0.0)
    assert (np.abs(pixels(page) - first) > 2).mean() < 1e-3


def test_keys(opened, text):
    page = opened(text)
    press = page.keyboard.press
    press("End")
    assert state(page)["frame"] == 50
    press("Home")
    press("ArrowRight")
    press("ArrowRight")
    press("ArrowLeft")
    assert state(page)["frame"] == 1
    press("Alt+ArrowRight")
    assert state(page)["frame"] == 11
    home = state(page)["camera"]
    press("3")
    assert state(page)["camera"]["elevation"] == 90
    press("+")
    assert state(page)["camera"]["distance"] < home["distance"] * 1.5
    press("Shift+ArrowUp")
    assert state(page)["camera"]["elevation"] < 90
    press("r")
    assert state(page)["camera"] == home
    press("f")
    assert state(page)["shown"]["forces"] and page.locator("#arrow output").inner_text()
    press("c")
    assert state(page)["shown"]["colour"] == "strain"
    press("Home")
    for _ in range(9):
        if abs(state(page)["time"] - CUT) < 1e-9:
            break
        press("n")
    assert state(page)["time"] == pytest.approx(CUT)
    assert "cut oviduct along plane" in page.locator("#caption").inner_text()
    press("?")
    page.locator("#keys button").click()
    press(" ")
    assert state(page)["playing"]
    page.evaluate(
        """async () => {
          while ((await tissuec.state()).time < 0.75) await new Promise(requestAnimationFrame);
        }"""
    )
    press(" ")
    assert not state(page)["playing"]


PAIR = """language 1
tissue spring { spring constant = 1 N/m; viscosity = 0 N*s/m; mass = 1 g }
body pair { mesh is explicit; tissue is spring }
table nodes of pair in mm with columns "id x y" {
  1 0 0
  2 40 0
  3 0 12
  4 40 12
}
table springs of pair with columns "a b rest length in mm" {
  1 2 50
  3 4 30
}
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix pair }
simulate { duration = 1 s }
output { trajectory every 1 s }
"""


def test_what_is_pressed_is_dashed_and_what_pulls_is_not(opened, tmp_path):
    request = Request(Source("pair.tis", PAIR))
    result = simulate(compile_request(request)[0], tmp_path / "pair.vtkhdf", request=request)
    with Trajectory.open(result.path) as trajectory:
        page = opened(render(trajectory))
    shot = pixels(page)
    pressed = (shot[..., 2] - shot[..., 0] > 60).any(axis=0).sum()
    pulled = (shot[..., 0] - shot[..., 2] > 60).any(axis=0).sum()
    # Columns in which each of them is seen; the gaps of dashes show what is behind.
    assert pulled > 200
    assert 0.3 * pulled < pressed < 0.85 * pulled


@pytest.mark.slow
def test_scrubbing_is_quick(opened, text):
    """At least half a dozen pictures in a second, on a computer that does nothing else."""
    page = opened(text)
    rate = page.evaluate(
        """async () => {
          const gl = document.getElementById("view").getContext("webgl2");
          const begin = performance.now(), count = 30;
          for (let i = 0; i < count; i += 1) {
            await tissuec.seek((2 * i) / count);
            await tissuec.draw();
            gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
          }
          return (1000 * count) / (performance.now() - begin);
        }"""
    )
    assert rate > 6


def test_the_timeline_and_the_curves_lead_through_time(opened, text):
    page = opened(text)
    page.locator("#time").evaluate(
        "slider => { slider.value = 500; slider.dispatchEvent(new Event('input')); }"
    )
    assert state(page)["time"] == pytest.approx(1.0)
    page.evaluate("tissuec.draw()")
    assert page.locator("#clock").inner_text() == "1.00 s of 2.00 s"
    plot = page.locator("#curves .plot").first
    box = plot.bounding_box()
    plot.click(position={"x": 44 + (box["width"] - 50) / 4, "y": 30})
    assert state(page)["time"] == pytest.approx(0.5, abs=0.02)
    marks = page.locator("#marks button")
    marks.filter(has_text="cut").click()
    assert state(page)["time"] == pytest.approx(CUT)


def test_the_force_beside_a_curve_is_the_logged_one(opened, text, sterilisation):
    page = opened(text)
    with Trajectory.open(sterilisation) as trajectory:
        log = trajectory.logs["force of forceps A"]
        for time in (0.3, 0.6, 1.0):
            seek(page, time)
            shown = page.locator("#curves figure").first.locator("figcaption span span")
            values = [float(text.replace("−", "-")) for text in shown.all_inner_texts()]
            exact = [1e3 * np.interp(time, log.time, column) for column in log.value.T]
            assert values == pytest.approx(exact, abs=0.051)  # [mN], one decimal is shown


def test_light_and_dark(opened, text):
    page = opened(text)
    page.emulate_media(color_scheme="dark")
    assert state(page)["look"] == "dark"
    page.locator("#theme").click()
    page.evaluate("tissuec.draw()")
    assert state(page)["look"] == "light" and pixels(page)[5, 5].min() > 200
    page.locator("#theme").click()
    page.evaluate("tissuec.draw()")
    assert state(page)["look"] == "dark" and pixels(page)[5, 5].max() < 60


def test_those_who_want_no_motion_get_less(opened, text):
    page = opened(text)
    page.emulate_media(reduced_motion="reduce")
    style = page.evaluate("getComputedStyle(document.querySelector('#caption')).transition")
    assert style in ("none", "none 0s ease 0s", "all 0s ease 0s") and not state(page)["playing"]


def test_a_page_that_is_ready_has_fitted_its_picture(browser, text, tmp_path):
    """Before its first frame: what is written below the picture takes height from it."""
    (tmp_path / "page.html").write_text(text, encoding="utf-8")
    context = browser.new_context(viewport={"width": 420, "height": 800})
    page = context.new_page()
    page.add_init_script("window.requestAnimationFrame = () => 0;")
    page.add_init_script("window.ResizeObserver = class { observe() {} };")
    page.goto((tmp_path / "page.html").as_uri())
    shape = page.evaluate(
        """async () => {
          await tissuec.ready;
          const view = document.getElementById("view");
          return view.clientWidth / view.clientHeight;
        }"""
    )
    assert state(page)["camera"]["aspect"] == shape
    context.close()


def test_fingers(browser, text, tmp_path):
    from tests.browser import watch

    (tmp_path / "page.html").write_text(text, encoding="utf-8")
    context = browser.new_context(viewport={"width": 420, "height": 800}, has_touch=True)
    page = context.new_page()
    watch(page)
    page.goto((tmp_path / "page.html").as_uri())
    page.evaluate("tissuec.ready")
    assert page.evaluate("document.documentElement.scrollWidth") <= 420
    devtools = context.new_cdp_session(page)

    def touch(kind, *points):
        devtools.send(
            "Input.dispatchTouchEvent",
            {"type": kind, "touchPoints": [{"x": x, "y": y, "id": k}
                                           for k, (x, y) in enumerate(points)]},
        )  # fmt: skip

    before = state(page)["camera"]
    touch("touchStart", (150, 200))
    touch("touchMove", (190, 200))
    touch("touchEnd")
    turned = state(page)["camera"]
    assert turned["azimuth"] != before["azimuth"] and turned["distance"] == before["distance"]
    touch("touchStart", (150, 200), (200, 200))
    touch("touchMove", (125, 200), (225, 200))
    touch("touchEnd")
    closer = state(page)["camera"]
    assert closer["distance"] == pytest.approx(before["distance"] / 2.0, rel=1e-6)
    assert closer["azimuth"] == turned["azimuth"]
    assert not page.problems
    context.close()


def test_every_control_has_a_name(opened, text):
    page = opened(text)
    nameless = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, canvas[tabindex]")]
          .filter((one) => !(one.ariaLabel || one.labels?.length || one.textContent.trim()))
          .map((one) => one.outerHTML)"""
    )
    assert not nameless


def test_camera_and_picture_are_those_of_python(opened, text, sterilisation):
    page = opened(text)
    with Trajectory.open(sterilisation) as trajectory:
        film = read_film(trajectory, Options())
    seen = state(page)["camera"]
    points = framing(film).points
    camera = fitted(points, seen["azimuth"], seen["elevation"], seen["aspect"])
    assert seen["distance"] == pytest.approx(camera.distance, rel=1e-9)
    places = page.evaluate(
        "points => Promise.all(points.map((point) => tissuec.seen(point)))", points[:9].tolist()
    )
    assert np.array(places) == pytest.approx(camera.seen(points[:9])[0], abs=1e-9)
    seek(page, 0.6)
    shot = pixels(page)
    drawn = Painter(film, Options(), (shot.shape[1], shot.shape[0]), "")
    drawn = drawn.scene(float(Timeline(film.times).frame_of(0.6))).astype(int)
    # Both draw the same silhouette, but for edges; what lies over the canvas is at the left.
    inked = [(np.ptp(one, axis=2) > 12)[:, 120:] for one in (shot, drawn)]
    differing = (inked[0] != inked[1]).sum() / inked[1].sum()
    assert inked[1].mean() > 0.05 and differing < 0.08


@pytest.mark.parametrize(
    "kind", ["points", "one frame", "one point", "two laws", "thin", "odd"]
)
def test_odd_results_are_shown(opened, shown, kind):
    options, net = Options(), grid(6, 6)
    show = Show(net, logs={"force": [1.0, np.nan, 3.0], "nothing": []}, cut=2)
    match kind:
        case "points":
            show = Show(without_springs(net))
        case "one frame":
            show = Show(net, frames=1)
        case "one point":
            show = Show(without_springs(grid(1, 1)), frames=1)
        case "two laws":
            laws = net.springs.laws * 2
            law = np.arange(net.spring_count, dtype=np.int32) % 2
            show.network = replace(net, springs=replace(net.springs, laws=laws, law=law))
        case "thin":
            options = Options(nodes=12, colour="strain")
        case "odd":
            show.scene, show.about = 'a"b<i>#?%.tis', "</script>&<i>"
    page = opened(render(shown(show), options), 'odd "name" #?%25.html')
    seek(page, 0.05)
    found = state(page)
    assert found["frames"] == show.frames
    for colour in ("strain", "law", "tension"):
        page.evaluate("colour => tissuec.set('colour', colour)", colour)
        page.evaluate("tissuec.draw()")
    page.evaluate("tissuec.set('forces', true)")
    page.evaluate("tissuec.set('surface', 'glass')")
    for key in (" ", "End", "n", "p", "u", "s", "i"):
        page.keyboard.press(key)
    page.wait_for_timeout(60)
    assert pixels(page).min() < 235  # something is drawn
    if kind == "odd":
        assert page.locator("h1").inner_text() == 'a"b<i>#?%'
        assert page.locator("#about").inner_text() == "</script>&<i>"


def test_smooth_surfaces_and_tools_are_shown(opened, tmp_path):
    from tests.results.test_instruments import SCENE
    from tissuec.core.source import Source
    from tissuec.pipeline import compile_request, simulate
    from tissuec.scene.request import Request

    text = SCENE.replace("output {", "output { surface of pad every 10 ms;")
    request = Request(Source("pad.tis", text))
    path = simulate(compile_request(request)[0], tmp_path / "pad.vtkhdf", request=request).path
    with Trajectory.open(path) as trajectory:
        page = opened(render(trajectory))
    seek(page, 0.02)
    assert not state(page)["shown"]["springs"]  # the surface shows the body
    with_tools = pixels(page)
    page.keyboard.press("i")
    page.evaluate("tissuec.draw()")
    assert (np.abs(pixels(page) - with_tools).sum(axis=2) > 30).mean() > 0.01


def test_a_fragment_plays_in_another_page(page, shown, tmp_path):
    text = fragment(shown(Show(grid(4, 4))))
    (tmp_path / "around.html").write_text(f"<!doctype html><h1>Around</h1>{text}")
    page.goto((tmp_path / "around.html").as_uri())
    inside = page.frames[1]
    assert inside.evaluate("tissuec.ready")
    assert inside.evaluate("tissuec.state()")["springs"] == grid(4, 4).spring_count


def test_a_browser_without_webgl_shows_the_net_and_all_curves(page, text, tmp_path):
    blind = """<script>
      const own = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
        return kind === "2d" ? own.call(this, kind, ...rest) : null;
      };
    </script>"""
    assert text.count("<head>") == 1
    (tmp_path / "page.html").write_text(
        text.replace("<head>", f"<head>{blind}"), encoding="utf-8"
    )
    page.goto((tmp_path / "page.html").as_uri())
    assert page.evaluate("tissuec.ready")
    assert "has no WebGL 2" in page.locator("#plain").inner_text()
    assert page.locator("#curves figure:not(#pair)").count() == 3
    for name in ("tools", "results"):
        page.evaluate(f"tissuec.set('{name}', false)")
    drawn = {}
    for time in (0.65, 1.2):
        seek(page, time)
        drawn[time] = (np.ptp(pixels(page), axis=2) > 12).any(axis=0)
        assert state(page)["springs"] == (610 if time < CUT else 580)
    # Between the stumps nothing is drawn but forceps and their force.
    gaps = {time: np.diff(np.flatnonzero(columns)).max() for time, columns in drawn.items()}
    assert gaps[1.2] > 5 * gaps[0.65]


def test_a_page_on_paper_shows_the_net(opened, text, tmp_path):
    page = opened(text)
    seek(page, 1.2)
    shown = pixels(page)
    page.emulate_media(media="print")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    page.wait_for_function("document.querySelector('#paper').complete")
    assert not page.locator("#view").is_visible() and not page.locator("#buttons").is_visible()
    printed = pixels(page, "#paper")
    inked = [(np.ptp(one, axis=2) > 12).mean() for one in (shown, printed)]
    assert inked[1] > 0.3 * inked[0] > 0.0


def test_every_scale_has_two_numbers(opened, text):
    page = opened(text)
    for low, high in ((1.0, 9.0), (-0.1, 9.9), (665.4, 666.4), (0.0, 1e-9), (-3.0, -2.9)):
        near = 1e-9 * abs(high)
        for count in (1, 2, 5):
            found = page.evaluate("([a, b, n]) => tissuec.ticks(a, b, n)", [low, high, count])
            assert len(found) >= 2
            assert low - near <= found[0] and found[-1] <= high + near


def test_a_page_shows_a_still_until_its_script_runs(page, text, tmp_path):
    """Also where scripts are disabled, and on paper."""
    (tmp_path / "page.html").write_text(text, encoding="utf-8")
    page.goto((tmp_path / "page.html").as_uri())
    assert page.evaluate("tissuec.ready") and not page.locator("#paper").is_visible()
    begun = text.replace("(() => {\n", "(() => {\nreturn;\n", 1)
    (tmp_path / "still.html").write_text(begun, encoding="utf-8")
    page.goto((tmp_path / "still.html").as_uri())
    assert page.locator("#paper").is_visible()
    assert (np.ptp(pixels(page, "#paper"), axis=2) > 12).sum() > 1000
