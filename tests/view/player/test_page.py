"""The page as a text: what it weighs, holds, and never lets through."""

import html
import json
import re

import numpy as np
import pytest

from tests.view.player.conftest import Show, grid, without_springs
from tissuec.core import palette
from tissuec.core.data import printable
from tissuec.core.errors import TissueError
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.curves import read_curves
from tissuec.view.player.options import Options
from tissuec.view.player.page import SCRIPTS, WEB, as_script, fragment, render

EVIL = 'a </script><script>alert("x")</script> & <b>é</b> \u2028 ${none} $none'


def film_of(page: str) -> dict:
    found = re.search(r'<script type="application/json" id="film">(.*?)</script>', page, re.S)
    assert found
    return json.loads(found[1])


class Alive(Show):
    """Every node moves in its own way, so that little can be foretold."""

    def place(self, frame):
        phase = 0.7 * np.arange(self.network.node_count)[:, None] + [0.0, 1.0, 2.0]
        wave = np.sin(0.21 * frame + phase) + 0.2 * np.sin(1.3 * frame + 3.0 * phase)
        return self.network.position + 0.003 * wave


def test_160_nodes_and_100_frames_weigh_less_than_430_kb(shown):
    moments = np.random.default_rng(7).normal(size=2001)
    show = Alive(grid(16, 10), frames=100, logs={"force": moments, "other": moments[::-1]})
    page = render(shown(show))
    film = film_of(page)
    assert len(film["times"]) == 100 and film["nodes"] == 160
    assert len(page.encode()) <= 430_000  # 160 of them are the page without a result


def test_a_page_needs_nothing_else(shown):
    page = render(shown(Show(grid(3, 3))))
    assert not re.findall(r"https?://(?!www\.w3\.org)", page)
    assert not re.findall(r'<(?:script|link|img|iframe)[^>]+(?:src|href)="(?!data:)', page)
    assert "default-src 'none'" in page


def test_colours_are_those_of_all_pictures(shown):
    page = render(shown(Show(grid(3, 3))))
    assert film_of(page)["looks"]["tension"] == list(palette.TENSION)
    for name in ("player.css", "shell.html", *SCRIPTS):
        text = (WEB / name).read_text(encoding="utf-8")
        assert not re.findall(r"#[0-9a-f]{6}\b", text), f"{name} has colours of its own"


def test_texts_cannot_end_a_script(shown):
    show = Show(grid(3, 3), scene=f"{EVIL}.tis", about=EVIL, text=f"language 1\n# {EVIL}\n",
                logs={EVIL: [1.0, 2.0]})  # fmt: skip
    page = render(shown(show))
    plain = render(shown(Show(grid(3, 3), logs={"force": [1.0, 2.0]}), "plain.vtkhdf"))
    assert page.count("</script>") == plain.count("</script>")
    assert film_of(page)["curves"][0]["name"] == EVIL
    assert html.escape(printable(EVIL)) in page


def test_json_in_a_script_is_the_same_data():
    value = {"<!--": ["\u2028", "</script>", "&amp;", 1.5, None]}
    text = as_script(value)
    assert json.loads(text) == value and not set("<>&\u2028") & set(text)


def test_a_fragment_holds_the_whole_page(shown):
    trajectory = shown(Show(grid(3, 3), about=EVIL))
    element = fragment(trajectory, height=300)
    inner = re.search(r'srcdoc="([^"]*)"', element)
    assert inner and html.unescape(inner[1]) == render(trajectory)
    assert "height:300px" in element


def test_it_is_the_same_page_each_time(shown):
    trajectory = shown(Show(grid(4, 4), cut=2))
    assert render(trajectory) == render(trajectory)


@pytest.mark.parametrize("nodes", [None, 20])
def test_numbers_that_are_none_stay_none(shown, nodes):
    show = Show(grid(6, 6), logs={"empty": [], "holes": [1.0, np.nan, -np.inf, 2.0, 3.0],
                                  "none": [np.nan, np.nan]})  # fmt: skip
    film = film_of(render(shown(show), Options(nodes=nodes)))
    empty, holes, none = film["curves"]
    assert empty["empty"] and none["empty"] and not holes["empty"]
    assert (holes["low"], holes["high"]) == (1.0, 3.0)


def test_a_log_is_a_vertical_step_where_an_event_changes_it(shown):
    trajectory = shown(Show(grid(4, 4), cut=3, logs={"pull": [2.0, 2.0, 2.0, 0.0, 0.0]}))
    (curve,) = read_curves(trajectory)
    assert curve.value[:, 0].tolist() == [2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0]
    (drawn,) = film_of(render(trajectory))["curves"]
    clock = drawn["clock"]
    assert (clock["first"], clock["step"] * 2**30) == pytest.approx((0.0, 0.08))


def test_it_says_how_it_was_made(sterilisation):
    with Trajectory.open(sterilisation) as trajectory:
        made = film_of(render(trajectory))["made"]
        assert made.startswith("160 nodes, 610 springs; dop853, ")
        assert f"tissuec {trajectory.manifest['versions']['tissuec']}" in made
        assert "tolerance 0.0001" in made


def test_an_unfinished_run_says_so(shown, tmp_path):
    show = Show(grid(3, 3), finished=False)
    show.write(tmp_path / "cut.vtkhdf")
    with Trajectory.open(tmp_path / "cut.partial.vtkhdf") as trajectory:
        assert "interrupted" in film_of(render(trajectory))["made"]


def test_a_result_without_frames_says_what_to_do(shown):
    with pytest.raises(TissueError, match="has no frames yet; run the scene to its end"):
        render(shown(Show(grid(3, 3), frames=0)))
    with pytest.raises(TissueError, match="trajectory every 20 ms"):
        render(shown(Show(without_springs(grid(0, 0)), frames=0), "none.vtkhdf"))


def test_what_is_left_out_is_said(shown):
    film = film_of(render(shown(Show(grid(12, 12))), Options(nodes=40, frames=3)))
    assert len(film["times"]) == 3
    assert re.fullmatch(
        r"drawn: \d\d of 144 nodes; \d+ lines represent 385 springs", film["thinned"]
    )
