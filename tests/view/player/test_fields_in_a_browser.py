"""Fields and values of nodes on the page in Chromium."""

import json
import re

import h5py
import numpy as np
import pytest

import tissuec
from tests.view.player.conftest import Show, grid
from tests.view.player.test_fields import BAR, Stretched
from tests.view.player.test_player_in_a_browser import (
    opened as opened,
)
from tests.view.player.test_player_in_a_browser import pixels, seek, state
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.fields import fields_of
from tissuec.view.player.options import Options
from tissuec.view.player.page import render
from tissuec.view.player.reading import read_film

pytest.importorskip("playwright", reason="a browser is driven by playwright")


def film_of(text: str) -> dict:
    found = re.search(r'<script type="application/json" id="film">(.*?)</script>', text, re.S)
    assert found
    return json.loads(found[1])


@pytest.fixture(scope="module")
def pages(sterilisation, tmp_path_factory):
    """The paths of three results and their pages."""
    folder = tmp_path_factory.mktemp("pages")
    bar = tissuec.run(BAR, out=folder / "bar.vtkhdf", companion="off")
    sheet = Show(grid(6, 7), frames=8, cut=4).write(folder / "sheet.vtkhdf")
    found = {}
    for path in (sterilisation, bar.path, sheet):
        with Trajectory.open(path) as trajectory:
            found[path.stem] = path, render(trajectory)
    return found


def settled(page, node, field):
    """Return what is read off at a node."""
    page.evaluate("field => tissuec.set('field', field)", field)
    page.evaluate("node => tissuec.pick(node)", node)
    page.evaluate("tissuec.draw()")
    return page.evaluate("tissuec.picked()")


def written(page, name):
    """Return the numbers of a row of the read-out, and by how much they are rounded."""
    text = page.locator(f"#numbers dt:text-is('{name}') + dd").inner_text()
    numbers = re.findall(r"[−\d.]+", text.replace("m²", ""))
    decimals = len(numbers[0].partition(".")[2])
    return [float(number.replace("−", "-")) for number in numbers], 0.5 * 10.0**-decimals


def test_values_are_those_of_the_file(opened, pages):
    """Positions and displacements by h5py, fields as they are computed from the result."""
    random = np.random.default_rng(11)
    for name, (path, text) in pages.items():
        page, film = opened(text), film_of(text)
        with h5py.File(path) as file, Trajectory.open(path) as trajectory:
            points = file["VTKHDF/Points"][:].reshape(len(trajectory.times), -1, 3)
            nodes = DrawnNodes(read_film(trajectory, Options()), trajectory)
            home = trajectory.network.position[trajectory.nodes]
            rows = np.flatnonzero(~nodes.film.is_side)
            for node, frame in zip(
                random.integers(len(home), size=5), random.integers(len(rows), size=5),
                strict=True,
            ):  # fmt: skip
                seek(page, float(trajectory.times[frame]))
                for spec in film["fields"]:
                    found = settled(page, int(node), spec["name"])
                    place = points[frame, node]
                    (*numbers,), half = written(page, "position")
                    unit = 1e-3
                    exact = place / unit
                    assert numbers == pytest.approx(exact, abs=half + film["step"] / unit)
                    (number,), half = written(page, "displacement")
                    divisor = film["fields"][0]["shown"][0]
                    exact = np.linalg.norm(place - home[node]) / divisor
                    bound = half + 2.0 * film["step"] / divisor
                    assert number == pytest.approx(exact, abs=bound)
                    (own,) = [one for one in fields_of(trajectory) if one.name == spec["name"]]
                    exact = own.value(nodes)[rows[frame], node]
                    (number,), half = written(page, spec["name"])
                    step = spec["step"] or film["step"]
                    if spec["name"] == "force":
                        step = film["most"]["force"] / film["steps"]["force"]
                    bound = half + 2.0 * step / spec["shown"][0]
                    if not found["field"]["isClipped"]:
                        assert number == pytest.approx(
                            exact / spec["shown"][0], abs=bound
                        ), (name, spec["name"])  # fmt: skip


def test_no_value_is_blended_across_a_cut(opened, pages, sterilisation):
    page = opened(pages["sterilisation"][1])
    with Trajectory.open(sterilisation) as trajectory:
        film = read_film(trajectory, Options())
    node = int(film.lines.ends[film.lines.life[:, 1] < 1e8][0, 0])
    values = []
    for time in (0.7 - 1e-6, 0.7 + 1e-6):
        seek(page, time)
        values.append(settled(page, node, "tension")["field"]["value"])
    first, last = (
        float(DrawnNodes(film, trajectory).tension[row, node])
        for row in np.flatnonzero(film.is_side & (abs(film.times - 0.7) < 1e-9))
    )
    assert values == pytest.approx([first, last], rel=0.01)
    assert abs(first - last) > 0.1 * abs(first)


def near(page, element, colour, most=6):
    """Return which part of an element's pixels has a colour, but for rounding and shade."""
    shot = pixels(page, element)
    return (np.abs(shot - np.array(colour)).max(axis=2) <= most).mean()


def test_the_skin_has_the_colour_that_the_legend_gives_its_number(opened, shown):
    """A sheet that is stretched evenly, seen from above, has one colour."""
    trajectory = shown(Stretched(grid(6, 7), frames=4))
    page = opened(render(trajectory, Options(field="strain", range=(0.0, 0.4), view=(-90, 90))))
    for frame in (1, 3):
        seek(page, 0.02 * frame)
        strain = 0.5 * ((1.0 + 0.1 * frame) ** 2 - 1.0)
        table = np.array(
            [[0, 34, 78], [67, 78, 108], [125, 124, 120], [188, 175, 111], [254, 232, 56]]
        )
        colour = [np.interp(strain / 0.4, np.linspace(0, 1, 5), column) for column in table.T]
        assert near(page, "#view", colour) > 0.1
    assert page.locator("#ticks").inner_text().split() == ["0", "20", "40"]
    assert page.locator("#clipped").inner_text() == ""
    assert page.locator("#what").inner_text().endswith("[%]")


def test_ranges_by_hand_are_marked_where_they_clip(opened, shown):
    page = opened(render(shown(Stretched(grid(6, 7), frames=4)), Options(field="strain")))
    seek(page, 0.06)
    usual = page.locator("#ticks").inner_text()
    assert page.locator("#usual").is_disabled()
    page.locator("#high").fill("10")
    page.locator("#high").press("Enter")
    assert page.locator("#ticks").inner_text().split() == ["0", "5", "10"]
    assert page.locator("#clipped").inner_text() == "largest: 34.5 %"
    assert "over" in page.locator("#ramp").get_attribute("class")
    page.evaluate("tissuec.look(-90, 90)")
    page.evaluate("tissuec.draw()")
    assert near(page, "#view", (254, 232, 56)) > 0.1
    page.locator("#low").fill("20")  # above the other end: refused, and nothing changes
    page.locator("#low").press("Enter")
    assert not page.locator("#low").evaluate("input => input.checkValidity()")
    assert page.locator("#ticks").inner_text().split() == ["0", "5", "10"]
    page.locator("#usual").click()
    assert page.locator("#ticks").inner_text() == usual
    assert page.locator("#low").evaluate("input => input.checkValidity()")


def test_the_pointer_reads_off_what_is_in_sight(opened, pages):
    """Of a block that is seen along x, the nodes of the front face and of no other."""
    page = opened(pages["bar"][1])
    page.evaluate("tissuec.look(0, 0)")
    seek(page, 0.0)
    box = page.locator("#view").bounding_box()
    for y, z in ((2, 3), (5, 10), (8, 17), (5, 5)):
        u, v = page.evaluate("place => tissuec.seen(place)", [0.01, 1e-3 * y, 1e-3 * z])
        page.mouse.move(
            box["x"] + box["width"] * (1 + u) / 2, box["y"] + box["height"] * (1 - v) / 2
        )
        page.evaluate("new Promise(requestAnimationFrame)")
        found = page.evaluate("tissuec.picked()")
        assert found["body"] == "bar"
        assert found["tissue"] == ("rubber" if found["position"][2] > 0.011 else "gel")
        assert found["position"] == pytest.approx([0.01, 1e-3 * y, 1e-3 * z], abs=2.6e-3)
        assert page.locator("#whose").inner_text() == f"node {found['id']} of bar"
    page.mouse.move(box["x"] + 4, box["y"] + box["height"] - 4)
    page.evaluate("new Promise(requestAnimationFrame)")
    assert page.evaluate("tissuec.picked()") is None and page.locator("#value").is_hidden()


def test_a_drag_turns_and_picks_nothing(opened, text_of_sheet):
    page = opened(text_of_sheet)
    box = page.locator("#view").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    before = state(page)["camera"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y, steps=4)
    page.mouse.up()
    assert state(page)["camera"]["azimuth"] != before["azimuth"]
    u, v = page.evaluate("tissuec.seen([0.03, 0.03, 0])")
    x, y = x + u * box["width"] / 2, y - v * box["height"] / 2
    page.mouse.click(x, y)
    held = page.evaluate("tissuec.picked()")["node"]
    page.mouse.move(x + 80, y)  # what is clicked at stays until it is let go
    page.evaluate("new Promise(requestAnimationFrame)")
    assert page.evaluate("tissuec.picked()")["node"] == held
    page.keyboard.press("Escape")
    assert page.evaluate("tissuec.picked()") is None


@pytest.fixture(scope="module")
def text_of_sheet(pages):
    return pages["sheet"][1]


def test_keys_walk_from_node_to_node_and_pin_them(opened, text_of_sheet):
    page = opened(text_of_sheet)
    seek(page, 0.0)
    charts = page.locator("#curves figure").count()
    page.locator("#view").focus()
    page.keyboard.press("Alt+ArrowRight")
    first = page.evaluate("tissuec.picked()")
    assert state(page)["frame"] == 0  # a node and not ten frames
    for key, way in (("ArrowRight", (0, 1)), ("ArrowUp", (1, 1)), ("ArrowLeft", (0, -1))):
        page.keyboard.press(f"Alt+{key}")
        after = page.evaluate("tissuec.picked()")
        seen = [page.evaluate("point => tissuec.seen(point)", one["position"])
                for one in (first, after)]  # fmt: skip
        change = np.subtract(seen[1], seen[0])[way[0]] * way[1]
        assert after["node"] != first["node"] and change > 0.01
        first = after
    # It is said a moment later.
    said = page.locator("#said", has_text=f"node {first['id']} of sheet, ")
    said.wait_for(state="attached")
    page.keyboard.press("Enter")
    page.keyboard.press("Enter")  # once is enough
    assert page.evaluate("tissuec.picked()")["pins"] == [first["node"]]
    assert page.locator("#curves figure").count() == charts + 1
    page.evaluate("tissuec.draw()")
    figure = page.locator("#curves figure").last
    assert figure.locator("b").inner_text().startswith("A: displacement of node")
    assert page.locator("#picks text").first.text_content() == "A"
    page.evaluate("tissuec.set('field', 'tension')")
    assert figure.locator("b").inner_text().startswith("A: tension of node")
    figure.locator("button").click()
    assert page.locator("#curves figure").count() == charts
    assert page.evaluate("tissuec.picked()")["pins"] == []


def test_a_net_without_skin_has_fields_on_its_springs(opened, shown):
    from tissuec.core.structs import replace

    net = replace(grid(6, 7), skin=np.zeros((0, 3), dtype=np.int32))
    show = Stretched(net, frames=4)
    page = opened(
        render(shown(show), Options(field="strain", range=(0.0, 0.345), view=(-90, 90)))
    )
    seek(page, 0.06)
    assert near(page, "#view", (254, 232, 56), most=12) > 0.01
    page.evaluate("tissuec.set('field', 'tissue')")
    page.evaluate("tissuec.draw()")
    assert near(page, "#view", (254, 232, 56), most=12) < 1e-4
    page.locator("#view").focus()
    page.keyboard.press("Alt+ArrowRight")
    assert page.evaluate("tissuec.picked()")["body"] == "sheet"


def test_a_page_without_webgl_has_fields_and_values_too(opened, shown, browser, tmp_path):
    text = render(shown(Stretched(grid(6, 7), frames=4)),
                  Options(field="strain", range=(0.0, 0.345), view=(-90, 90)))  # fmt: skip
    (tmp_path / "flat.html").write_text(text, encoding="utf-8")
    context = browser.new_context(viewport={"width": 800, "height": 500})
    page = context.new_page()
    page.add_init_script(
        """const own = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
          return kind === "webgl2" ? null : own.call(this, kind, ...more);
        };"""
    )
    page.goto((tmp_path / "flat.html").as_uri())
    page.evaluate("tissuec.seek(0.06)")
    page.evaluate("tissuec.draw()")
    assert near(page, "#view", (254, 232, 56), most=8) > 0.1
    page.evaluate("tissuec.pick(3)")
    page.evaluate("tissuec.draw()")
    assert page.locator("#value").is_visible()
    context.close()
