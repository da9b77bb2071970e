"""Pages as axe-core sees them: names, roles, contrast and order, in every state of a page."""

import pytest

from tests.view.player.conftest import sterilisation
from tests.view.report.runs import ROD, page_of, run
from tissuec.core.resources import library
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request
from tissuec.view.explorer.page import document
from tissuec.view.explorer.page import render as explorer
from tissuec.view.player.page import render

pytest.importorskip("playwright", reason="a browser is driven by playwright")
WIDE, PHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
LOOKS = pytest.mark.parametrize(
    ("size", "look"),
    [
        pytest.param(WIDE, "light", marks=pytest.mark.slow),
        pytest.param(WIDE, "dark", marks=pytest.mark.slow),
        pytest.param(PHONE, "light", marks=pytest.mark.slow),
        (PHONE, "dark"),
    ],
)
OPTIONS = {"resultTypes": ["violations"], "iframes": False}  # the player has its own test
#: Keys that show something else on the page of a run.
__all__ = ["sterilisation"]
STATES = ("", "s", "f", "e", "u", "o", "x", "Alt+ArrowRight", "Enter", "?")


@pytest.fixture
def violations(page):
    """Return a function that returns what is wrong with the page, as lines of text."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()

    def found():
        return [
            f"{one['id']}: {node['html']} {node.get('failureSummary', '')}"
            for one in axe.run(page, options=OPTIONS).response["violations"]
            for node in one["nodes"]
        ]

    return found


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    path = folder / "report.html"
    path.write_text(page_of(run(folder, ROD)), encoding="utf-8")
    return path


def opened(page, path, size, look):
    page.set_viewport_size(size)
    page.emulate_media(color_scheme=look)
    page.goto(path.as_uri())


@LOOKS
def test_the_player_in_every_state(page, violations, sterilisation, tmp_path, size, look):
    path = tmp_path / "page.html"
    with Trajectory.open(sterilisation) as trajectory:
        path.write_text(render(trajectory), encoding="utf-8")
    opened(page, path, size, look)
    assert page.evaluate("tissuec.ready")
    page.locator("#view").focus()
    for key in STATES:
        if key:
            page.keyboard.press(key)
        assert violations() == [], key
    state = page.evaluate("tissuec.state()")
    assert state["shown"]["field"] != "tissue" and state["section"]["isOn"]
    assert len(page.evaluate("tissuec.picked()")["pins"]) == 1


@LOOKS
def test_reports(page, violations, report, size, look):
    opened(page, report, size, look)
    assert violations() == []


@LOOKS
def test_the_explorer(page, violations, tmp_path, size, look):
    path = tmp_path / "explorer.html"
    words = Request.file(library() / "fuzzy" / "soft_tissue.tis")
    path.write_text(explorer(document(words)), encoding="utf-8")
    opened(page, path, size, look)
    assert violations() == []
