"""Answers of tables: sensitivities, orders of convergence, quantiles and effects."""

import threading
import time as clock
import warnings

import numpy as np
import pytest
from scipy import stats

from tests.study import tables_of_designs as tables
from tests.study.scenes import CHAIN, SCENE, carried_out
from tissuec.engine.integrators import INTEGRATORS
from tissuec.studies.analysis.completed import completed
from tissuec.studies.analysis.convergence import order_of, orders
from tissuec.studies.analysis.sensitivity import sobol_indices
from tissuec.studies.table import FactorHead, StudyTable, rows_of

#: Of the Ishigami function with a = 7 and b = 0.1, first order and total, in closed form.
FIRST, TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)


def test_known_indices_are_within_their_intervals():
    found = tables.indices(base=1024).sobol_indices("m0")
    assert (found.used, found.base, found.left_out.count) == (1024, 1024, 0)
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
    assert (part.used, part.base, part.left_out.failed) == (61, 64, 3)
    assert part.notes() == [
        "left out of 320 runs: 3 failed",
        "61 of 64 base runs are used: those with all values",
    ]
    assert whole.used == 64
    for one, other in zip(whole, part, strict=True):
        assert one.first == pytest.approx(other.first, abs=0.15)


def test_indices_of_a_measure_that_never_changes_are_refused():
    factors = tables.indices(8).head.factors
    points = np.random.default_rng(1).random((40, 3)).tolist()
    table = tables.table_of("sobol indices", factors, points, lambda *_: (1.0,), base=8)
    with pytest.raises(ValueError, match="the same value in all runs"):
        table.sobol_indices("m0")


def scene_of_the_function(base):
    """Return the table of a study of a scene that measures the Ishigami function."""
    formula = "sin(x1) + 7 * sin(x2) * sin(x2) + 0.1 * x3 * x3 * x3 * x3 * sin(x1)"
    params = "".join(f"param x{n} = 0.5\n" for n in (1, 2, 3))
    text = SCENE.replace("param lift", f"{params}param lift")
    sentences = [
        *(f"vary x{n} = uniform(-3.14159265, 3.14159265)" for n in (1, 2, 3)),
        f"measure y = {formula} + 0 * count(springs of bar) at 0 s",
        "design is sobol indices", f"runs = {base}", "error estimate is off",
    ]  # fmt: skip
    return carried_out(*sentences, text=text).table


def holds(found):
    """Return which of the six intervals hold the known index."""
    return [
        low <= known <= high
        for one, first, total in zip(found, FIRST, TOTAL, strict=True)
        for known, (low, high) in ((first, one.first_interval), (total, one.total_interval))
    ]


def test_a_scene_that_measures_the_function_gives_its_values_and_indices():
    table = scene_of_the_function(base=8)
    points = np.array([factor.numbers for factor in table.factors])
    assert table.column("y").numbers == pytest.approx(tables.ishigami(*points), rel=1e-12)
    found = sobol_indices(table, "y")
    bare = tables.table_of(
        "sobol indices", table.head.factors, points.T.tolist(),
        lambda *x: (float(tables.ishigami(*x)),), base=8,
    ).sobol_indices("m0")  # fmt: skip
    assert found.used == 8
    for one, other in zip(found, bare, strict=True):
        assert (one.first, one.total) == pytest.approx((other.first, other.total), abs=1e-12)


@pytest.mark.slow
def test_all_known_indices_of_the_scene_are_within_their_intervals():
    assert all(holds(sobol_indices(scene_of_the_function(1024), "y")))


def held_by(base, seeds):
    """Return which intervals hold the known index for each seed, shape (seed, 6)."""
    return np.array(
        [holds(tables.indices(base=base, seed=seed).sobol_indices("m0")) for seed in seeds]
    )


def test_intervals_hold_as_often_as_they_say():
    # 96.7 % of them hold for 300 seeds, and 92.7 % of the worst index. The chance of less
    # than these bounds for 100 seeds is about 1 % (binomial distribution).
    held = held_by(64, range(100))
    assert held.mean() > 0.93
    assert (held.mean(axis=0) > 0.86).all()
    # Nor do they hold because they are wide: they shrink with the root of the base number.
    widths = [
        np.mean(
            [np.ptp(one.total_interval) for one in tables.indices(base).sobol_indices("m0")]
        )
        for base in (64, 1024)
    ]
    assert 3.0 < widths[0] / widths[1] < 6.0


@pytest.mark.slow
@pytest.mark.parametrize(("base", "least"), [(16, 0.80), (256, 0.95), (1024, 0.98)])
def test_intervals_of_other_base_numbers_hold_as_the_manual_says(base, least):
    assert held_by(base, range(100)).mean() > least


def test_orders_of_known_methods_and_their_limit():
    found = {one.fixed: one for one in tables.refined().orders("m0")}
    for name, order in (("one", 1.0), ("two", 2.0), ("four", 4.0)):
        one = found[(name,)]
        assert one.levels.tolist() == [8.0, 4.0, 2.0, 0.5]
        assert one.orders == pytest.approx([order, order], rel=1e-6)
        assert one.limit == pytest.approx(1.0, abs=1e-9)


def test_divisions_are_refined_upwards():
    from tissuec.studies.table import FactorHead

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
    found = {one.fixed[0]: one for one in orders(table, "place")}
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
    found = tables.one_at_a_time().effects("m0")
    assert found.own == pytest.approx(0.02)
    first, second = found
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


# --- runs that are left out -------------------------------------------------------------------


def converging(h, name):
    """Return a measure of order 2; of "odd" the level 4 fails, of "lost" all."""
    if name == "lost" or (name, h) == ("odd", 4.0):
        return None
    return (1.0 + 1e-3 * h**2,)


def with_failures(levels=(8.0, 4.0, 2.0, 1.0, 0.5)):
    """Return a refinement in which runs failed."""
    points = [(h, name) for h in levels for name in ("good", "odd", "lost")]
    factors = [FactorHead("step", "ms"), FactorHead("integrator", "", is_text=True)]
    return tables.table_of("grid", factors, points, converging)


def test_orders_are_not_joined_across_a_failed_level_and_no_combination_is_missing():
    found = with_failures().orders("m0")
    good, odd, lost = found
    assert good.orders == pytest.approx([2.0, 2.0, 2.0])
    assert odd.levels.tolist() == [8.0, 4.0, 2.0, 1.0, 0.5]
    assert np.isnan(odd.values[1]) and np.isnan(odd.orders[:2]).all()
    assert odd.orders[2] == odd.order == pytest.approx(2.0)
    assert odd.limit == pytest.approx(1.0, abs=1e-12)
    assert np.isnan(lost.order) and np.isnan(lost.limit) and len(lost.gaps) == 5
    assert found.left_out.failed == 6
    told = str(found).splitlines()
    assert told[:3] == [
        "good: order 2.00; limit 1 N",
        "odd: order 2.00; limit 1 N",
        "lost: no order",
    ]
    assert told[3:5] == [
        "left out of 15 runs: 6 failed", "odd, step 4 ms: the motion diverged",
    ]  # fmt: skip


def test_a_level_of_a_grid_that_is_not_done_yet_is_told():
    table = with_failures((4.0, 2.0, 1.0))
    part = StudyTable.of(table.head, [row for row in rows_of(table) if row.run != 3])
    good = orders(part, "m0")[0]
    assert good.gaps == ("step 2 ms: not done yet",) and np.isnan(good.order)
    assert orders(part, "m0").left_out.missing == 1


def test_a_limit_is_known_where_the_finest_level_failed():
    table = tables.table_of(
        "grid", [FactorHead("step", "ms")], [(8.0,), (4.0,), (2.0,), (1.0,)],
        lambda h: None if h == 1.0 else (1.0 + 1e-3 * h,),
    )  # fmt: skip
    (found,) = table.orders("m0")
    assert found.order == pytest.approx(1.0) and found.limit == pytest.approx(1.0)


def test_effects_name_the_values_that_have_none():
    points = [(2.0, 10.0), (1.0, 10.0), (3.0, 10.0), (2.0, 5.0), (2.0, 40.0)]
    factors = (tables.LIFT, FactorHead("stiffness of liver", "N/m"))
    table = tables.table_of(
        "one at a time", factors, points,
        lambda x, c: None if x == 3.0 or c != 10.0 else (1e-3 * x * c,),
    )  # fmt: skip
    found = table.effects("m0")
    assert [one.factor for one in found] == ["lift"]
    assert found.notes() == [
        "left out of 5 runs: 3 failed",
        "lift = 3 mm: the motion diverged",
        "stiffness of liver = 5 N/m: the motion diverged",
        "stiffness of liver = 40 N/m: the motion diverged",
    ]


def test_a_factor_that_the_scene_does_not_tell_keeps_its_own_runs():
    nothing = float("nan")
    points = [(nothing, 10.0), (1.0, 10.0), (3.0, 10.0), (nothing, 5.0)]
    factors = (tables.LIFT, FactorHead("stiffness of liver", "N/m"))
    table = tables.table_of(
        "one at a time", factors, points, lambda x, c: (1e-3 * c * (2.0 if np.isnan(x) else x),)
    )
    lift = next(one for one in table.effects("m0") if one.factor == "lift")
    assert (lift.low, lift.high) == pytest.approx((0.01, 0.03))  # without the 5 N/m


def test_quantiles_count_what_they_leave_out():
    points = [(float(n),) for n in range(100)]
    table = tables.table_of(
        "sobol", [tables.LIFT], points,
        lambda x: None if x < 10 else (float("nan") if x < 13 else x,),
    )  # fmt: skip
    found = table.quantiles("m0", 0.5, 0.01)
    assert found.used == 87 and found[0].value == pytest.approx(56.0)
    assert found.notes() == [
        "left out of 100 runs: 10 failed, 3 without a value",
        "no interval with 87 runs: 1 % needs 368 runs",
    ]


@pytest.mark.parametrize("part", [0.05, 0.25, 0.5, 0.9])
def test_the_fewest_runs_of_an_interval_are_the_fewest(part):
    fewest = tables.sample().quantiles("m0", part)[0].fewest
    for count, has in ((fewest - 1, False), (fewest, True)):
        points = [(float(n),) for n in range(count)]
        table = tables.table_of("sobol", [tables.LIFT], points, lambda x: (x,))
        assert table.quantiles("m0", part)[0].has_interval is has


@pytest.mark.parametrize("design", ["grid", "list", "one at a time"])
def test_chosen_values_are_no_sample(design):
    table = tables.table_of(design, [tables.LIFT], [(1.0,), (2.0,)], lambda x: (x,))
    with pytest.raises(ValueError, match=f'"{design}" are not a sample.*nanquantile'):
        table.quantiles("m0")


def test_quantiles_of_a_study_for_indices_are_those_of_its_independent_blocks():
    table = tables.indices(base=256)
    found = table.quantiles("m0", 0.5)
    assert found.used == 512 and found.left_out.planned == 512
    assert found[0].value == np.quantile(table.measures[0].numbers[:512], 0.5)


def test_parts_that_are_none_are_refused():
    with pytest.raises(ValueError, match=r"between 0 and 1, such as 0\.5, not 50"):
        tables.sample().quantiles("m0", 50)


def test_an_index_without_any_effect_has_no_interval_and_says_so():
    found = tables.without_effect().sobol_indices("m0")
    assert found[2].first_interval is None and found[2].total_interval is None
    assert found[0].has_intervals
    assert found.notes() == [
        "no interval for x3: all resamples are equal, because nothing changes with the factor "
        "in these 32 base runs"
    ]


def test_all_kinds_of_lack_are_counted():
    table = with_failures((4.0, 2.0, 1.0))
    assert completed(table).left_out.failed == 4
    assert str(completed(StudyTable.of(table.head, [])).left_out) == (
        "left out of 9 runs: 9 not done yet"
    )
    assert str(completed(tables.sample()).left_out) == "left out of 80 runs: none"


def test_filters_of_warnings_are_changed_by_one_thread_at_a_time(monkeypatch):
    inside, together, bootstrap = [], [], stats.bootstrap

    def slowly(*args, **options):
        inside.append(warnings.filters)
        together.append(len(inside))
        clock.sleep(0.05)
        try:
            return bootstrap(*args, **options)
        finally:
            inside.pop()

    monkeypatch.setattr(stats, "bootstrap", slowly)
    before = list(warnings.filters)
    table = tables.indices(8)
    several = [threading.Thread(target=table.sobol_indices, args=("m0",)) for _ in range(3)]
    for one in several:
        one.start()
    for one in several:
        one.join()
    assert together == [1, 1, 1]
    assert list(warnings.filters) == before
