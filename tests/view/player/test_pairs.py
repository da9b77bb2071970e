"""The chart of one quantity against another, in the page and in the report."""

import json
import re

import numpy as np
import pytest

from tests.view.plots.conftest import carry_out
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.curves import first_pair, read_quantities
from tissuec.view.player.page import render
from tissuec.view.plots.quantities import quantity, unit_of
from tissuec.view.report.content import ReportContent
from tissuec.view.report.page import render as render_report

PULLED = """language 1
tissue gum { spring constant = 20 N/m; viscosity = 0.5 N*s/m; mass = 1 mg }
body net { mesh is explicit; tissue is gum }
table nodes of net in mm with columns "id x" { 1 0; 2 100 }
table springs of net with columns "a b" { 1 2 }
set wall = nodes of net in [1]
set hand = nodes of net in [2]
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix wall
  from 0 s to 0.3 s: move hand by (2, 1, 0) mm using sine of 10 Hz
}
simulate { duration = 0.3 s; tolerance = 1e-6 }
output {
  trajectory every 10 ms
  force of hand every 1 ms; position of hand every 1 ms; length of net every 2 ms
}
"""


@pytest.fixture(scope="module")
def pulled(tmp_path_factory):
    """Return the run of a spring whose end swings three times."""
    folder = tmp_path_factory.mktemp("pulled")
    with Trajectory.open(carry_out(PULLED, folder / "pulled.vtkhdf")) as run:
        yield run


def test_menus_offer_what_plots_draw_in_the_same_units(pulled):
    offered = read_quantities(pulled)
    names = [one.name for one in offered]
    assert names == [
        "time", "magnitude of force of hand",
        *(f"force of hand along {axis}" for axis in "xyz"),
        *(f"displacement of hand along {axis}" for axis in "xyz"),
        "magnitude of displacement of hand",
        *(f"position of hand along {axis}" for axis in "xyz"), "length of net",
    ]  # fmt: skip
    for one in offered:
        found = quantity(pulled, one.name)
        assert one.scale == unit_of([found])
        log = list(pulled.logs.values())[one.curve]
        if one.columns:
            time, value = log.with_jumps()
            part = (
                value[:, list(one.columns)] - one.is_displacement * value[0, list(one.columns)]
            )
            shown = part[:, 0] if len(one.columns) == 1 else np.linalg.norm(part, axis=1)
            assert found.value == pytest.approx(shown, abs=1e-15)
            assert found.time == pytest.approx(time)


def test_a_force_over_a_way_is_shown_first(pulled):
    offered = read_quantities(pulled)
    up, across = first_pair(offered)
    assert offered[up].name == "force of hand along x"
    assert offered[across].name == "displacement of hand along x"


@pytest.fixture
def opened(page, pulled, tmp_path):
    """Return the page of the run, in a browser."""
    (tmp_path / "pulled.html").write_text(render(pulled), encoding="utf-8")
    page.goto((tmp_path / "pulled.html").as_uri())
    assert page.evaluate("tissuec.ready")
    return page


def choose(page, up, across):
    for label, name in (("vertical", up), ("horizontal", across)):
        page.locator("#pair").get_by_label(label).select_option(label=name)
    page.evaluate("tissuec.draw()")


def test_two_menus_choose_what_is_drawn(opened):
    box = opened.locator("#pair")
    choose(opened, "force of hand along x [mN]", "displacement of hand along x [mm]")
    label = box.locator(".plot").get_attribute("aria-label")
    assert label == "force of hand along x over displacement of hand along x"
    before = box.locator("canvas").screenshot()
    # By keys, too: an arrow takes the next quantity, and does not step the motion.
    menu = box.get_by_label("vertical")
    menu.focus()
    opened.keyboard.press("ArrowDown")
    assert menu.evaluate("one => one.selectedOptions[0].text") == "force of hand along y [mN]"
    assert opened.evaluate("tissuec.state()")["time"] == 0.0
    opened.evaluate("tissuec.draw()")
    assert box.locator("canvas").screenshot() != before


def test_the_point_is_where_the_log_is(opened, pulled):
    """Places of the point over the time are the two logs but for a scale and an origin."""
    choose(opened, "force of hand along y [mN]", "length of net [mm]")
    times = np.linspace(0.005, 0.295, 12)
    places = []
    for time in times.tolist():
        opened.evaluate("time => tissuec.seek(time)", time)
        opened.evaluate("tissuec.draw()")
        style = opened.locator("#pair .point").get_attribute("style")
        places.append([float(number) for number in re.findall(r"(-?[\d.]+)px", style)])
    across, down = np.array(places).T
    for seen, name in ((across, "length of net"), (-down, "force of hand along y")):
        log = quantity(pulled, name)
        value = np.interp(times, log.time, log.value)
        slope, start = np.polyfit(value, seen, 1)
        assert slope > 0.0
        assert seen == pytest.approx(slope * value + start, abs=0.2)  # [px]


def test_every_menu_has_a_name_and_nothing_leaves_the_page(opened):
    for select in opened.locator("#pair select").all():
        assert select.evaluate("one => one.labels[0].textContent.trim()").startswith(
            ("vertical", "horizontal")
        )
    for width in (1280, 390):
        opened.set_viewport_size({"width": width, "height": 800})
        # A page without eval cannot be waited for by a text; it asks itself at each picture.
        opened.evaluate(
            "async () => { while (document.documentElement.scrollWidth > innerWidth) "
            "await new Promise(requestAnimationFrame); }"
        )
        inside = opened.evaluate(
            "() => [...document.querySelectorAll('#pair select')]"
            ".every((one) => one.getBoundingClientRect().right <= innerWidth)"
        )
        assert inside


def test_the_report_has_the_same_chart(pulled):
    text = render_report(ReportContent(pulled))
    film = json.loads(re.search(r'id="film">(.*?)</script>', render(pulled), re.DOTALL)[1])
    assert film["quantities"][0]["name"] == "time"
    assert "class PairChart" in text and "magnitude of displacement of hand" in text
