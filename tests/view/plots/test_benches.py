"""Diagrams of benches show what their JSON holds."""

import math

import numpy as np
import pytest
from matplotlib.colors import to_hex

from benchmarks.stability.grid import SIGNS
from tests.view.plots.conftest import BENCH, STRESS
from tissuec.core.errors import TissueError
from tissuec.view.plots import draw
from tissuec.view.plots.benches import COLOURS, UNKNOWN

pytestmark = pytest.mark.usefixtures("unplaced")


def test_every_point_stands_at_its_error_and_time():
    (axes,) = draw(None, BENCH).axes
    lines = {line.get_label(): line for line in axes.get_lines()}
    assert set(lines) == {"dop853", "Other", "accuracy of the reference"}
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert axes.get_ylabel() == "time [ms]"
    assert axes.get_xlabel() == "error over largest displacement"
    floor = BENCH["reference"]["uncertainty"]
    for name in ("dop853", "Other"):
        points = [p for p in BENCH["points"] if p["method"] == name]
        expected = [(max(p["error"], floor), 1e3 * p["seconds"]) for p in points]
        assert lines[name].get_xydata() == pytest.approx(np.array(expected))
    assert lines["accuracy of the reference"].get_xdata()[0] == floor
    assert axes.get_xlim()[0] > axes.get_xlim()[1]  # precision grows to the right


def test_ours_are_filled_and_others_hollow_and_dashed():
    (axes,) = draw(None, BENCH).axes
    ours, other = axes.get_lines()[:2]
    assert to_hex(ours.get_markerfacecolor()) == to_hex(ours.get_color())
    assert to_hex(other.get_markerfacecolor()) == "#ffffff"
    assert (ours.get_linestyle(), other.get_linestyle()) == ("-", "--")
    assert ours.get_marker() != other.get_marker()


def test_points_without_numbers_are_left_out():
    points = [dict(point) for point in BENCH["points"]]
    points[0]["error"] = None  # what JSON has for NaN
    (axes,) = draw(None, BENCH | {"points": points}).axes
    assert len(axes.get_lines()[0].get_xdata()) == 2
    with pytest.raises(TissueError, match="has no results"):
        draw(None, BENCH | {"points": []})


def test_the_map_has_a_cell_for_every_verdict():
    (axes,) = draw(None, STRESS).axes
    assert [text.get_text() for text in axes.texts] == ["ok", "ok", "WRONG", "ok"]
    kinds = [verdict["kind"] for verdict in STRESS["verdicts"]]
    for cell, kind in zip(axes.patches, kinds, strict=True):
        assert to_hex(cell.get_facecolor()) == COLOURS[kind][0]
    places = [(math.floor(c.get_x()), math.floor(c.get_y())) for c in axes.patches]
    assert places == [(0, 0), (1, 0), (0, 1), (1, 1)]
    assert [t.get_text() for t in axes.get_yticklabels()] == ["stiffness 1e3", "stiffness 1e9"]
    assert [t.get_text() for t in axes.get_xticklabels()] == ["automatic", "dop853"]
    assert axes.get_ylim() == (2.0, 0.0)


def test_the_signs_are_explained_and_counted():
    figure = draw(None, STRESS)
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["ok (3): as promised", "WRONG (1): silently wrong"]


def test_all_explanations_are_on_the_page(placed):
    verdicts = [{**STRESS["verdicts"][0], "kind": kind} for kind in (*SIGNS, *SIGNS)]
    signs = {kind: list(sign) for kind, sign in SIGNS.items()}
    figure = draw(None, STRESS | {"verdicts": verdicts, "signs": signs})
    figure.draw_without_rendering()
    width, _ = figure.canvas.get_width_height()
    (legend,) = figure.legends
    assert len(legend.get_texts()) == len(SIGNS)
    box = legend.get_window_extent()
    assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width
    assert box.y1 <= figure.axes[0].get_window_extent().y0


def test_every_kind_of_verdict_has_a_colour_and_others_do_no_harm():
    assert set(COLOURS) == set(SIGNS)
    verdicts = [{**STRESS["verdicts"][0], "kind": "new"}, *STRESS["verdicts"][1:]]
    (axes,) = draw(None, STRESS | {"verdicts": verdicts}).axes
    assert to_hex(axes.patches[0].get_facecolor()) == UNKNOWN[0]
    with pytest.raises(TissueError, match="no complete map"):
        draw(None, STRESS | {"verdicts": verdicts[:3]})
