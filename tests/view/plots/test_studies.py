"""Plots of the tables of studies: which kind suits a table, what is drawn, and what is told."""

import numpy as np
import pytest

from tests.study import tables_of_designs as tables
from tissuec.core.errors import TissueError
from tissuec.view.plots import draw


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
    assert hard.get_ydata() == pytest.approx(3.0 * np.arange(1.0, 6.0))  # one run failed
    assert figure.notes == ("1 of 12 runs failed and are left out",)


def test_words_can_be_on_the_axis():
    axes = draw("response", tables.grid(), measure="m0", x="hardness of liver").axes[0]
    assert [text.get_text() for text in axes.get_xticklabels()] == ["soft", "hard"]
    assert len(axes.get_lines()) == 6


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
    assert "1 of 256 base runs are left out" in figure.notes[0]


def test_convergence_names_the_orders():
    axes = draw("convergence", tables.refined()).axes[0]
    labels = {line.get_label() for line in axes.get_lines()}
    assert labels == {"one: p = 1.00", "two: p = 2.00", "four: p = 4.00"}


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
