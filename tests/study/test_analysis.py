"""Answers of tables: sensitivities, orders of convergence, quantiles and effects."""

import numpy as np
import pytest
from scipy import stats

from tests.study import tables_of_designs as tables
from tests.study.scenes import CHAIN, SCENE, carried_out
from tissuec.engine.integrators import INTEGRATORS
from tissuec.studies.analysis.convergence import order_of

#: Of the Ishigami function with a = 7 and b = 0.1, first order and total, in closed form.
FIRST, TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)


def test_known_indices_are_within_their_intervals():
    found = tables.indices(base=1024).sobol_indices("m0")
    assert (found.used, found.left_out) == (1024, 0)
    for one, first, total in zip(found, FIRST, TOTAL, strict=True):
        assert one.first_interval[0] <= first <= one.first_interval[1], one
        assert one.total_interval[0] <= total <= one.total_interval[1], one
        # Intervals of 1024 base runs tell something.
        assert one.total_interval[1] - one.total_interval[0] < 0.2


def test_indices_are_those_of_scipy():
    table, count = tables.indices(), 256
    values = table.measures[0].numbers.reshape(5, 1, count)
    blocks = {"f_A": values[0], "f_B": values[1], "f_AB": values[2:]}
    known = stats.sobol_indices(func=blocks, n=count)
    found = table.sobol_indices("m0")
    assert [one.first for one in found] == pytest.approx(known.first_order.ravel(), abs=1e-12)
    assert [one.total for one in found] == pytest.approx(known.total_order.ravel(), abs=1e-12)


def test_base_runs_with_a_failed_run_are_left_out_and_told():
    whole, part = (
        tables.indices(base=64, failed=f).sobol_indices("m0") for f in ((), (3, 64 + 5, 130))
    )
    assert (part.used, part.left_out) == (61, 3)
    assert whole.used == 64
    for one, other in zip(whole, part, strict=True):
        assert one.first == pytest.approx(other.first, abs=0.15)


def test_indices_of_a_measure_that_never_changes_are_refused():
    factors = tables.indices(8).head.factors
    points = np.random.default_rng(1).random((40, 3)).tolist()
    table = tables.table_of("sobol indices", factors, points, lambda *_: (1.0,), base=8)
    with pytest.raises(ValueError, match="the same value in all runs"):
        table.sobol_indices("m0")


def test_a_scene_that_measures_the_function_gives_its_values():
    formula = "sin(x1) + 7 * sin(x2) * sin(x2) + 0.1 * x3 * x3 * x3 * x3 * sin(x1)"
    params = "".join(f"param x{n} = 0.5\n" for n in (1, 2, 3))
    text = SCENE.replace("param lift", f"{params}param lift")
    sentences = [
        *(f"vary x{n} = uniform(-3.14159265, 3.14159265)" for n in (1, 2, 3)),
        f"measure y = {formula} + 0 * count(springs of bar) at 0 s",
        "design is sobol indices", "runs = 4", "error estimate is off",
    ]  # fmt: skip
    table = carried_out(*sentences, text=text).table
    points = np.array([factor.numbers for factor in table.factors])
    assert table.column("y").numbers == pytest.approx(tables.ishigami(*points), rel=1e-12)
    assert table.sobol_indices("y").used == 4


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_intervals_hold_for_most_seeds(seed):
    found = tables.indices(base=512, seed=seed).sobol_indices("m0")
    held = sum(
        low <= known <= high
        for one, first, total in zip(found, FIRST, TOTAL, strict=True)
        for known, (low, high) in ((first, one.first_interval), (total, one.total_interval))
    )
    assert held >= 5  # of six intervals of 95 %


def test_orders_of_known_methods_and_their_limit():
    found = {one.fixed: one for one in tables.refined().orders("m0")}
    for name, order in (("one", 1.0), ("two", 2.0), ("four", 4.0)):
        one = found[(name,)]
        assert one.levels.tolist() == [8.0, 4.0, 2.0, 0.5]
        assert one.orders == pytest.approx([order, order], rel=1e-6)
        assert one.limit == pytest.approx(1.0, abs=1e-9)


def test_divisions_are_refined_upwards():
    from tissuec.studies.rows import FactorHead

    points = [(4.0,), (8.0,), (16.0,)]
    table = tables.table_of(
        "grid", [FactorHead("edge nodes", "")], points, lambda n: (2.0 + 1.0 / n**3,)
    )
    (found,) = table.orders("m0")
    assert found.levels.tolist() == [4.0, 8.0, 16.0]
    assert found.order == pytest.approx(3.0)
    assert found.limit == pytest.approx(2.0)


@pytest.mark.parametrize(
    "values",
    [
        (1.0, 1.0, 1.0),
        (1.0, 2.0, 1.0),
        (1.0, 2.0, 4.0),
        (1.0, np.nan, 2.0),
        (1.0, 1.0 + 4e-14, 1.0 + 6e-14),
    ],
    ids=["alike", "turning", "diverging", "unknown", "rounded"],
)
def test_values_that_do_not_converge_have_no_order(values):
    assert np.isnan(order_of((4.0, 2.0, 1.0), values))


def test_orders_of_all_integrators_from_one_study():
    sentences = [
        "vary step = [20 ms, 10 ms, 5 ms, 2.5 ms, 1.25 ms, 0.625 ms]",
        f"vary integrator = [{', '.join(INTEGRATORS)}]",
        "measure place = position of middle along (1, 0, 0) at 0.2 s",
    ]
    table = carried_out(*sentences, text=CHAIN).table
    found = {one.fixed[0]: one for one in table.orders("place")}
    assert set(found) == set(INTEGRATORS)
    for name, one in found.items():
        # Of the three finest steps above rounding errors, 7.97 (dop853) and 1.06 (propagation)
        # being farthest from the order.
        assert one.order == pytest.approx(INTEGRATORS[name].order, abs=0.1)


def test_quantiles_and_their_intervals():
    points = [(float(n),) for n in range(1, 101)]
    table = tables.table_of("latin hypercube", [tables.LIFT], points, lambda x: (x,))
    median, low = table.quantiles("m0", 0.5, 0.05)
    assert median.value == pytest.approx(50.5)
    # Ranks 40 and 61 of 100 enclose the median with 95 % (Conover 1999, table A3).
    assert (median.low, median.high) == (40.0, 61.0)
    assert low.value == pytest.approx(5.95)


def test_quantiles_of_a_grid_are_refused():
    with pytest.raises(ValueError, match="random design"):
        tables.grid().quantiles("m0")


def test_effects_one_at_a_time():
    own, effects = tables.one_at_a_time().effects("m0")
    assert own == pytest.approx(0.02)
    first, second = effects
    assert (first.factor, first.low, first.high) == ("stiffness of liver", 0.01, 0.08)
    assert (first.at_low, first.at_high) == ("5 N/m", "40 N/m")
    assert second.range == pytest.approx(0.02)


@pytest.mark.parametrize("analysis", ["sobol_indices", "effects", "orders", "quantiles"])
def test_an_unknown_measure_is_told_with_those_there_are(analysis):
    table = {
        "sobol_indices": tables.indices(8), "effects": tables.one_at_a_time(),
        "orders": tables.refined(), "quantiles": tables.sample(),
    }[analysis]  # fmt: skip
    with pytest.raises(ValueError, match=r'no measure "pull".*m0'):
        getattr(table, analysis)("pull")


@pytest.mark.parametrize("analysis", ["sobol_indices", "effects"])
def test_analyses_say_which_design_they_need(analysis):
    with pytest.raises(ValueError, match="need the design"):
        getattr(tables.grid(), analysis)("m0")
