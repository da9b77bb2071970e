"""Plots of the tables of studies: which kind suits a table, what is drawn, and what is told."""

from itertools import pairwise

import numpy as np
import pytest

from tests.every import every
from tests.study import tables_of_designs as tables
from tissuec.core.errors import TissueError
from tissuec.core.structs import replace
from tissuec.studies.table import FactorHead, MeasureCurve
from tissuec.view.plots import WrongOption, draw, study_measures

pytestmark = pytest.mark.usefixtures("unplaced")


@pytest.mark.parametrize(
    ("table", "kind"),
    [
        (tables.grid, "response"), (tables.plane, "heat-map"),
        (tables.sample, "scatter-matrix"), (tables.one_at_a_time, "tornado"),
        (tables.indices, "tornado"), (tables.refined, "convergence"),
    ],
)  # fmt: skip
def test_the_kind_that_suits_is_drawn_by_itself(table, kind):
    assert draw(None, table()).kind == kind


def test_a_family_of_curves_has_one_for_each_word():
    figure = draw("response", tables.grid(), measure="m0")
    soft, hard = figure.axes[0].get_lines()
    assert soft.get_label() == "hardness of liver soft"
    assert soft.get_xdata() == pytest.approx(np.arange(1.0, 7.0))
    assert soft.get_ydata() == pytest.approx(np.arange(1.0, 7.0))  # mN
    assert hard.get_ydata()[:5] == pytest.approx(3.0 * np.arange(1.0, 6.0))
    assert np.isnan(hard.get_ydata()[5])  # its run failed
    assert figure.notes == ("left out of 12 runs: 1 failed",)


def test_words_can_be_on_the_axis():
    axes = draw("response", tables.grid(), measure="m0", x="hardness of liver").axes[0]
    assert [text.get_text() for text in axes.get_xticklabels()] == ["soft", "hard"]
    assert len(axes.get_lines()) == 6


def test_a_heat_map_has_cells_of_one_size_with_few_values_and_never_below_0():
    assert study_measures._edges(np.array([5.0, 50.0, 200.0])).tolist() == [-0.5, 0.5, 1.5, 2.5]
    decades = np.geomspace(1.0, 1e4, 13)
    edges = study_measures._edges(decades)
    assert (edges > 0.0).all()
    # The borders are geometric means: each value is in the middle of its cell.
    assert np.sqrt(edges[1:] * edges[:-1]) == pytest.approx(decades, rel=1e-12)
    even = np.linspace(1.0, 13.0, 13)
    assert study_measures._edges(even) == pytest.approx(np.linspace(0.5, 13.5, 14))


def test_a_heat_map_of_few_values_has_them_as_ticks_and_numbers():
    axes = draw("heat-map", tables.plane(), x="width", y="lift").axes[0]
    levels = axes.get_xticks()
    assert levels.tolist() == list(range(len(levels)))
    assert len(axes.texts) == len(levels) * len(axes.get_yticks())
    shown = [float(text.get_text().replace("\N{MINUS SIGN}", "-")) for text in axes.texts]
    mesh = axes.collections[0].get_array()
    assert shown == pytest.approx(np.asarray(mesh).ravel(), rel=6e-3)  # of three digits


def test_a_heat_map_has_each_value_at_its_place():
    axes = draw("heat-map", tables.plane(), x="width", y="lift").axes[0]
    values = axes.collections[0].get_array()
    assert values.shape == (6, 5)
    assert values[2, 4] == pytest.approx(3.0 * 4.0)  # lift 3 mm, width 4 mm


def test_a_tornado_shows_intervals_of_indices():
    figure = draw("tornado", tables.indices(failed=(3,)))
    lines = figure.axes[0].get_lines()
    points = [line for line in lines if line.get_marker() == "o"]
    assert [line.get_label() for line in points] == ["total", "first order"]
    assert figure.notes[1] == "255 of 256 base runs are used: those with all values"


def test_convergence_names_the_orders():
    axes = draw("convergence", tables.refined()).axes[0]
    labels = {line.get_label() for line in axes.get_lines()}
    assert labels == {"one: p = 1.00", "two: p = 2.00", "four: p = 4.00"}


@every(
    ("kind", "table"),
    [
        ("response", tables.grid), ("heat-map", tables.grid), ("study-curves", tables.grid),
        ("scatter-matrix", tables.grid), ("distribution", tables.lossy_sample),
        ("convergence", tables.lossy_refinement), ("tornado", tables.lossy_effects),
        ("tornado", lambda: tables.indices(16, failed=(3,))),
    ],
)  # fmt: skip
def test_every_kind_says_what_it_leaves_out(kind, table):
    notes = draw(kind, table()).notes
    assert any("left out of " in note and " 1 failed" in note for note in notes), notes


def test_a_refinement_names_the_level_that_failed():
    figure = draw("convergence", tables.lossy_refinement())
    assert "two, step 4 ms: the motion diverged" in figure.notes
    assert {line.get_label() for line in figure.axes[0].get_lines()} == {
        "one: p = 1.00", "two: no order", "four: p = 4.00",
    }  # fmt: skip


@pytest.mark.parametrize("width", [60.0, 90.0, 160.0, 300.0])
def test_numbers_of_a_refinement_do_not_touch(width, placed):
    steps = [(20.0 / 2**n,) for n in range(12)]
    step = FactorHead("step", "ms")
    table = tables.table_of("grid", [step], steps, lambda h: (1.0 + h**2,))
    axes = draw("convergence", table, size=(width, 60.0)).axes[0]
    axes.figure.canvas.draw()
    boxes = [text.get_window_extent() for text in axes.get_xticklabels()]
    assert all(a.x1 < b.x0 for a, b in pairwise(boxes)) and len(boxes) > 1
    assert {text.get_text() for text in axes.get_xticklabels()} <= {f"{h:g}" for (h,) in steps}


def test_tables_plot_themselves():
    table = tables.grid()
    assert table.plot().kind == "response"
    assert table.plot("heat-map", measure="m1", title="Heat").kind == "heat-map"
    with pytest.raises(WrongOption, match='no option "z"'):
        table.plot("response", z="lift")


def test_an_index_without_interval_is_a_point_with_a_note():
    figure = draw("tornado", tables.without_effect())
    assert any("no interval for x3" in note for note in figure.notes)
    spans = [line for line in figure.axes[0].get_lines() if line.get_linewidth() == 2]
    assert len(spans) == 4


def test_curves_of_runs_are_drawn_to_their_end():
    lines = draw("study-curves", tables.grid()).axes[0].get_lines()
    assert sum(len(line.get_xdata()) == 5 for line in lines) == 11


@pytest.mark.parametrize(
    ("kind", "table", "options", "said"),
    [
        ("response", tables.grid, {"measure": "pull"}, 'no measure "pull".*m0'),
        ("response", tables.grid, {"x": "lid"}, 'no factor "lid".*lift'),
        ("tornado", tables.grid, {}, "needs the design"),
        ("distribution", tables.grid, {}, "random design"),
        ("convergence", tables.one_at_a_time, {}, "name the factor"),
        ("study-curves", tables.plane, {}, "nothing was measured over time"),
    ],
)
def test_what_cannot_be_drawn_is_told(kind, table, options, said):
    with pytest.raises(TissueError, match=said):
        draw(kind, table(), **options)


def test_too_many_combinations_are_told_with_a_way_out():
    factors = [tables.LIFT, tables.LIFT.__class__("width", "mm")]
    points = [(float(x), float(y)) for x in range(2) for y in range(20)]
    table = tables.table_of("grid", factors, points, lambda x, y: (x + y,))
    with pytest.raises(TissueError, match="scatter-matrix"):
        draw("response", table, x="lift")


def test_curves_of_a_study_can_have_another_measure_on_the_horizontal_axis():
    """One that is sampled twice as often has the times of the other."""
    table = tables.grid()
    (curve,) = table.curves
    finer = np.arange(2 * curve.values.shape[1] - 1) * curve.every / 2.0
    places = 1e-3 * np.sqrt(1.0 + finer)[None] * np.arange(1, len(table) + 1)[:, None]
    place = MeasureCurve("place", "m", curve.every / 2.0, places)
    figure = draw("study-curves", replace(table, curves=(curve, place)), x="Place")
    (axes, _) = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("place [mm]", "curve [mN]")
    line = axes.get_lines()[2]
    known = np.isfinite(curve.values[2])
    assert np.asarray(line.get_ydata()) == pytest.approx(1e3 * curve.values[2][known])
    assert np.asarray(line.get_xdata()) == pytest.approx(1e3 * places[2, ::2][known])
    assert "curve: Place has other times and is interpolated" in figure.notes
    with pytest.raises(TissueError, match="on the horizontal axis already"):
        draw("study-curves", table, x="curve")
