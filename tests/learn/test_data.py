"""Tables as text: whatever their dialect, the numbers are those that were written."""

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.examples import examples
from tests.findings import finding_of
from tests.learn.lessons import NET, column, data, fit, fit_problem
from tissuec.core.errors import CompileError
from tissuec.core.structs import replace
from tissuec.core.text_tables import columns
from tissuec.core.text_tables.columns import MARKS, is_ambiguous
from tissuec.measurements.experiment import Experiment, Series
from tissuec.measurements.reading import check_times, read_experiment
from tissuec.measurements.rows import nearest_rows

FORCE = fit("force", "force_N")
#: The start of a video-tracked cart: times to three digits, places in pixels.
CART = "t_s,x_px\n0.033,-99\n0.067,-97\n0.100,-93\n0.133,-88\n"
#: Without what stands for a gap.
FINITE = st.floats(allow_nan=False, allow_infinity=False).filter(lambda one: one not in MARKS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("data")


def read(folder, text, *fits, **axis):
    path = folder / "bench.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_experiment(data(path), fit_problem(*(fits or (FORCE,)), **axis), NET)


def refused(folder, text, *fits, **axis):
    """Return what is said about a table, with hints: one message for each finding."""
    with pytest.raises(CompileError) as caught:
        read(folder, text, *fits, **axis)
    assert all(finding.span is not None for finding in caught.value.diagnostics)
    return [f"{one.message}; {one.hint}" for one in caught.value.diagnostics]


# --- dialects ---------------------------------------------------------------------------------


def with_comma(value):
    return repr(value).replace(".", ",")


@st.composite
def written_tables(draw):
    """Draw numbers with gaps, and a text that holds them in some dialect."""
    width = draw(st.integers(1, 4))
    rows = draw(
        st.lists(st.lists(st.none() | FINITE, min_size=width, max_size=width), max_size=8)
    )
    rows = [[1.0] * width, *rows, [2.0] * width]  # no column is constant
    delimiter = draw(st.sampled_from([",", ";", "\t", " ", "   "]))
    quote = draw(st.sampled_from(["", '"']))
    comma = draw(st.booleans()) and (delimiter != "," or quote == '"')
    if comma and delimiter == ",":  # "1,234" is refused there: it can be 1234
        rows = [
            [None if v is not None and is_ambiguous(with_comma(v)) else v for v in row]
            for row in rows
        ]
    gaps = ["NA", "nan", "-"] + ([] if delimiter.isspace() and delimiter != "\t" else [""])

    def cell(value):
        number = with_comma if comma else repr
        text = draw(st.sampled_from(gaps)) if value is None else number(value)
        return f"{quote}{text}{quote}"

    names = draw(st.permutations(["u (left)", "force, left", "strain", "comment #1"]))[:width]
    header = delimiter.join(['"t"', *(f'"{name}"' for name in names)])
    lines = [header]
    for i, row in enumerate(rows):
        if draw(st.integers(0, 4)) == 0:
            lines.append(draw(st.sampled_from(["", "# a remark; 1, 2", "  "])))
        lines.append(delimiter.join([str(i), *map(cell, row)]))
    end = draw(st.sampled_from(["\n", "\r\n"]))
    text = end.join(lines) + draw(st.sampled_from(["", end, end + end]))
    codec = draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]))
    numbers = np.array([[math.nan if v is None else v for v in row] for row in rows])
    return text.encode(codec), names, numbers


@settings(max_examples=examples(200))
@given(written_tables())
def test_a_table_in_any_dialect_gives_the_numbers_that_were_written(folder, table):
    text, names, numbers = table
    fits = [fit("distance", name) for name in names]
    # A column of gaps alone is refused, and the first row has none.
    found = read(folder, text, *fits)
    for one, expected in zip(found.series, numbers.T, strict=True):
        np.testing.assert_array_equal(one.values, expected)
        np.testing.assert_array_equal(one.times, np.arange(len(numbers)))


@settings(max_examples=examples(100))
@given(written_tables(), st.integers(1, 60))
def test_where_blocks_end_makes_no_difference(folder, table, block):
    text, names, numbers = table
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(columns, "_BLOCK", block)
        found = read(folder, text, fit("distance", names[-1]))
    np.testing.assert_array_equal(found.series[0].values, numbers[:, -1])


@settings(max_examples=examples(200))
@given(written_tables())
def test_the_fast_way_and_the_exact_way_agree(folder, table):
    text, names, _ = table
    fast = read(folder, text, fit("distance", names[-1]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(columns, "_plain", lambda *_: None)
        exact = read(folder, text, fit("distance", names[-1]))
    np.testing.assert_array_equal(fast.series[0].values, exact.series[0].values)


def test_a_plain_table_takes_the_fast_way(folder, monkeypatch):
    monkeypatch.setattr(columns, "_by_cell", lambda *_: pytest.fail("cell by cell"))
    for text in (CART, CART.replace(",", "\t"), CART.replace(",", ";").replace(".", ",")):
        assert read(folder, text, fit("distance", "x_px")).series[0].values[0] == -99.0
    gaps = "t_s,a,b\n0,1,\n1,,\n2,,3\n"
    values = read(folder, gaps, fit("distance", "b")).series[0].values
    np.testing.assert_array_equal(values, [np.nan, np.nan, 3.0])


def test_tracking_of_a_cart_is_read(folder):
    cart = fit("position", "x_px", along=(1, 0, 0), unit=1e-3)
    found = read(folder, CART, cart, time=column("t_s"))
    np.testing.assert_array_equal(found.series[0].times, [0.033, 0.067, 0.1, 0.133])
    np.testing.assert_allclose(found.series[0].values, [-0.099, -0.097, -0.093, -0.088])
    assert found.name == "bench.csv" and len(found.digest) == 64
    assert found.duration == 0.133


def test_columns_without_a_header_are_numbered(folder):
    found = read(folder, "0 1,5 7\n1 2,5 8\n", fit("distance", "2"), fit("distance", "3"))
    np.testing.assert_array_equal(found.series[0].values, [1.5, 2.5])
    np.testing.assert_array_equal(found.series[1].values, [7.0, 8.0])
    told = refused(folder, "0 1\n1 2\n")
    assert told == [
        'bench.csv has no column "force_N"; there is no header; columns are numbered: 1, 2'
    ]


def test_a_remark_above_the_numbers_may_be_the_header(folder):
    text = "# measured by hand\n# t_ms force_N\n0 1\n1 2\n"
    assert read(folder, text).series[0].times[-1] == 1e-3


def test_names_with_letters_of_older_instruments_are_read(folder):
    text = "t [µs];Länge\n0;1\n5;2\n".encode("latin-1")
    assert read(folder, text, fit("distance", "Länge")).duration == pytest.approx(5e-6)


def test_text_in_a_column_that_is_not_read_is_no_mistake(folder):
    text = "t_s,who,force_N\n0,Ann,1\n1,Bob,2\n"
    np.testing.assert_array_equal(read(folder, text).series[0].values, [1.0, 2.0])


def test_rows_of_gaps_alone_are_none(folder):
    assert len(read(folder, "t_s;force_N\n0;1\n;\n;\n").series[0].times) == 1


@pytest.mark.parametrize(
    ("name", "second"),
    [
        ("t_s", 1.0), ("t", 1.0), ("time", 1.0), ("time_ms", 1e-3), ("t_us", 1e-6),
        ("t [ms]", 1e-3), ("t (ms)", 1e-3), ("t/ms", 1e-3), ("Time (sec)", 1.0),
        ("time_min", 60.0), ("t_hours", 3600.0), ("frame time", 1.0),
    ],
)  # fmt: skip
def test_the_first_column_says_the_unit_of_time(folder, name, second):
    found = read(folder, f"{name},force_N\n0,1\n2,1\n")
    assert found.duration == pytest.approx(2 * second, rel=1e-15)  # one rounding


def test_a_first_column_of_something_else_is_refused(folder):
    (told,) = refused(folder, "u_mm,force_N\n0,1\n")
    assert told.startswith('the first column of bench.csv, "u_mm", ends with the unit of a len')
    (told,) = refused(folder, "t [frames],force_N\n0,1\n")
    assert 'unknown unit: "frames" is not a unit' in told


# --- what is wrong ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "bench.csv is empty; "),
        ("# only a remark\n", "bench.csv is empty; "),
        ("t_s,force_N\n", "bench.csv contains no row of numbers; the columns are t_s, force_N"),
        (
            "t_s,forceN\n0,1\n",
            'bench.csv has no column "force_N"; did you mean "forceN"?  columns: t_s, forceN',
        ),
        (
            "t_s,force_N,force_N\n0,1,2\n",
            'bench.csv has 2 columns "force_N"; name one by its number: "2" or "3"',
        ),
        (
            "t_s,force_N\n\n0,1\n1,soft\n",
            'line 4 of bench.csv, column "force_N": "soft" is not a finite number; '
            "leave a gap empty, or write nan, NA or -; comments begin with #",
        ),
        (
            "t_s,force_N\n0,1\n1,1e999\n",
            'line 3 of bench.csv, column "force_N": "1e999" is not a finite number; '
            "such large numbers are not measurements: leave a gap empty, or write nan, NA or "
            "-; comments begin with #",
        ),
        (
            "t_s,force_N\n0,1_0\n",
            'line 2 of bench.csv, column "force_N": "1_0" is not a finite number; '
            "write digits without separators: 10; comments begin with #",
        ),
        (
            "t_s,force_N\n0,1\n1\n",
            "line 3 of bench.csv: 1 cell where there are 2 columns; comments begin with #",
        ),
        (
            "t_s,force_N\n0,1\n1 5,2 3,4\n",
            "line 3 of bench.csv: 3 cells where there are 2 columns; write digits "
            "without separators, and units after the names of columns; comments begin with #",
        ),
        ("t_s,force_N\n0,1\n,2\n", "line 3 of bench.csv has no time; "),
        (
            "t_s,force_N\n0,1\n# remark\n2,1\n1,1\n",
            "lines 4 and 5 of bench.csv do not ascend: 1 s comes after 2 s; "
            "sort the rows by time, each time once",
        ),
        (
            "t_s,force_N\n0,1\n0.5,1\n0.5,1\n",
            "lines 3 and 4 of bench.csv have the same time, 500 ms; "
            "remove one of them; for one row per node, also name the column of the nodes",
        ),
        (
            "t_s,force_N\n0,\n1,NA\n",
            'column "force_N" is empty from line 2 to line 3 of bench.csv: force(net) has no '
            "value; name another column, or remove the fit",
        ),
        (
            "t_s,force_N\n0,\n# off\n1,0.50\n2,0.5\n3,5e-1\n4,0.5\n5,\n",
            'column "force_N" is constant from line 2 to line 8 of bench.csv: force(net) does '
            "not change; a sensor that is off or out of range shows this: name another column, "
            "or remove the fit; if the quantity is at rest, keep its value in one row only",
        ),
        (
            "t_s;force_N\n0;1,5\n1;1.5\n",
            'line 3 of bench.csv, column "force_N": decimals have points in some rows and '
            "commas in others; write them all with points; comments begin with #",
        ),
        (
            "t\0_s",
            "bench.csv is neither text nor HDF5; "
            "data is a table as text (CSV), a result of tissuec or an H5MD file",
        ),
    ],
)
def test_a_table_that_cannot_be_read_is_refused_at_its_row(folder, text, message):
    assert refused(folder, text) == [message]


SIGNS = st.text(st.sampled_from('0123456789.,;:\t \r\n"#-+eENAnaninf_µ[('), max_size=60)


@settings(max_examples=examples(300))
@given(st.sampled_from(["", "t,a\n", "t;a\n0;1\n", "t a\n0 1\n"]), SIGNS | st.binary())
@example("", '"')
def test_whatever_stands_in_a_file_is_read_or_refused(folder, head, rest):
    text = head.encode() + (rest if isinstance(rest, bytes) else rest.encode())
    try:
        (one,) = read(folder, text, fit("distance", "2")).series
    except CompileError:
        return
    assert (np.diff(one.times) > 0).all() and one.known.any()
    assert not np.isinf(one.values).any()


@settings(max_examples=examples(300))
@given(st.text(st.sampled_from("0123456789.,; \t\n-eNAnan"), max_size=40))
@example(" ,")
@example("0,1 2\n1,")
@example("0, -nan\n1 ,2")
def test_rows_the_fast_way_takes_are_those_the_exact_way_takes(folder, rest):
    text = "t,a\n" + rest
    with pytest.MonkeyPatch.context() as patch:
        outcomes = []
        for _ in range(2):
            try:
                (one,) = read(folder, text, fit("distance", "a")).series
                outcomes.append(
                    (one.times.tolist(), np.nan_to_num(one.values, nan=7e77).tolist())
                )
            except CompileError as error:
                outcomes.append(str(error))
            patch.setattr(columns, "_plain", lambda *_: None)
    assert outcomes[0] == outcomes[1]


def test_components_and_few_rows_may_be_constant(folder):
    rows = "".join(f"{t},7,{t * t},{t}\n" for t in range(9))
    plane = fit("position", "x", "y", "z", nodes=(0,))
    (one,) = read(folder, f"t,x,y,z\n{rows}", plane).series
    assert one.values[:, 0].tolist() == [7.0] * 9
    (one,) = read(folder, "t,x\n0,7\n1,7\n2,7\n3,\n", fit("distance", "x")).series
    assert one.values[:3].tolist() == [7.0] * 3
    rest = "".join(f"{t},{node},1,2,{node}\n" for t in range(4) for node in (100, 101))
    message = 'columns "node x y z" are constant from line 2 to line 9 of bench.csv: '
    (told,) = refused(folder, f"t,node,x,y,z\n{rest}", fit("positions", "node", *"xyz"))
    assert told.startswith(message)


def test_rows_that_all_come_before_the_run_are_told(folder):
    path = folder / "bench.csv"
    path.write_text("t_s,force_N\n0,1\n1,2\n")
    with pytest.raises(CompileError, match=r"no value of force\(net\) from 5 s on"):
        read_experiment(replace(data(path), start=5.0), fit_problem(FORCE), NET)


@pytest.mark.parametrize("text", ["t_s,x_mm\n0,1\n1,2\n", "t_s,force_N\n0,\n1,\n"])
def test_two_machines_are_sent_to_blocks_or_one_table(folder, text):
    path = folder / "bench.csv"
    path.write_text(text)
    one = data(path)
    with pytest.raises(CompileError) as caught:
        read_experiment(one, replace(fit_problem(FORCE), data=(one, one)), NET)
    assert "use a learn block for each machine" in str(caught.value.diagnostics[0].hint)


def test_every_missing_column_is_told(folder):
    told = refused(folder, CART, FORCE, fit("distance", "gap_mm"), time=column("time"))
    assert [one.partition(";")[0] for one in told] == [
        'bench.csv has no column "time"',
        'bench.csv has no column "force_N"',
        'bench.csv has no column "gap_mm"',
    ]


def test_a_fit_without_columns_is_refused_in_a_table(folder):
    (told,) = refused(folder, CART, fit("force"))
    assert told.startswith("bench.csv is a table; the column of force(net) is not given")


def test_a_missing_file_is_told_with_one_like_it(tmp_path):
    (tmp_path / "bench_01.csv").write_text(CART)
    finding = finding_of(
        read_experiment, data(tmp_path / "bench_1.csv"), fit_problem(FORCE), NET
    )
    assert finding.code == "TIS604" and "no such file" in finding.message
    assert "bench_01.csv" in finding.hint


def test_a_run_must_reach_what_was_measured(folder):
    check_times(read(folder, CART, fit("distance", "x_px")), 0.133)
    with pytest.raises(CompileError, match=r"ends at 133 ms, and the run at 100 ms"):
        check_times(read(folder, CART, fit("distance", "x_px")), 0.1)
    slip = read(folder, "time,force_N\n0,0\n200,1\n")
    with pytest.raises(CompileError, match=r"ends at 200 s, and the run at 200 ms") as caught:
        check_times(slip, 0.2)
    assert "if they are in ms, name the column t_ms" in caught.value.diagnostics[0].hint
    early = read(folder, "t_s,force_N\n-1,1\n1,1\n")
    with pytest.raises(CompileError, match=r"begins at -1 s, and a run begins at 0 s"):
        check_times(early, 2.0)
    pressed = read(folder, "u_m,force_N\n-1,1\n5,1\n", moved=[3])
    check_times(pressed, 1.0)  # displacements are no times


# --- what is measured -------------------------------------------------------------------------

VECTORS = "t_s,x,y,z\n0,1,2,2\n1,3,4,\n"


def test_three_columns_are_a_vector_or_are_projected(folder):
    columns_ = ("x", "y", "z")
    force, up, place = (
        fit("force", *columns_),
        fit("force", *columns_, along=(0, 1, 0)),
        fit("position", *columns_, unit=1e-3),
    )
    found = read(folder, VECTORS, force, up, place).series
    np.testing.assert_array_equal(found[0].values, [[1, 2, 2], [3, 4, np.nan]])
    np.testing.assert_array_equal(found[1].values, [2.0, np.nan])  # part of it is not known
    np.testing.assert_array_equal(found[2].values, np.array([[1, 2, 2], [3, 4, np.nan]]) * 1e-3)
    assert [one.nodes for one in found] == [None] * 3


def test_positions_of_one_node_need_no_column_of_nodes(folder):
    (one,) = read(folder, VECTORS, fit("positions", "x", "y", "z", nodes=[2])).series
    assert one.values.shape == (2, 1, 3)
    np.testing.assert_array_equal(one.nodes, [2])
    (told,) = refused(folder, VECTORS, fit("positions", "x", "y", "z"))
    assert told.startswith("positions(net) has 4 nodes, but x, y and z describe one node")


@settings(max_examples=examples(60))
@given(st.data())
def test_a_long_table_is_read_in_whatever_order_its_rows_are(folder, data_):
    times = sorted(data_.draw(st.sets(st.floats(0, 10), min_size=1, max_size=4)))
    nodes = sorted(data_.draw(st.sets(st.integers(0, 3), min_size=1)))
    every = [(t, n) for t in range(len(times)) for n in range(len(nodes))]
    chosen = data_.draw(st.lists(st.sampled_from(every), unique=True, min_size=1))
    expected = np.full((len(times), len(nodes), 3), np.nan)
    text = "t_s node x y z\n"
    for t, n in chosen:
        expected[t, n] = data_.draw(st.tuples(FINITE, FINITE, FINITE))
        x, y, z = expected[t, n].tolist()
        text += f"{times[t]!r} {nodes[n] + 100} {x!r} {y!r} {z!r}\n"
    (one,) = read(folder, text, fit("positions", "node", "x", "y", "z")).series
    rows = sorted({t for t, _ in chosen})
    columns_ = sorted({n for _, n in chosen})
    np.testing.assert_array_equal(one.times, np.array(times)[rows])
    np.testing.assert_array_equal(one.nodes, np.array(nodes)[columns_])
    np.testing.assert_array_equal(one.values, expected[np.ix_(rows, columns_)])


LONG = "t_s,node,x,y,z,force_N\n0,100,0,0,0,5\n0,101,1,0,0,5\n1,101,2,0,0,\n1,100,3,0,0,6\n"
NODES = fit("positions", "node", "x", "y", "z")


def test_what_stands_beside_nodes_is_read_once_for_each_time(folder):
    nodes, force = read(folder, LONG, NODES, FORCE).series
    np.testing.assert_array_equal(nodes.values[:, :, 0], [[0, 1], [3, 2]])
    np.testing.assert_array_equal(force.values, [5.0, 6.0])
    (told,) = refused(folder, LONG.replace("0,0,5\n1", "0,0,7\n1"), NODES, FORCE)
    assert told.startswith("lines 2 and 3 of bench.csv both give force(net) at 0 s")


def test_ids_have_no_unit(folder):
    places = replace(NODES, columns=tuple(column(one.name, 1e-3) for one in NODES.columns))
    (one,) = read(folder, LONG, places).series
    np.testing.assert_array_equal(one.nodes, [0, 1])
    np.testing.assert_array_equal(one.values[:, :, 0], [[0, 1e-3], [3e-3, 2e-3]])


def test_nodes_of_a_body_that_are_not_in_the_set_are_left_aside(folder):
    few = fit("positions", "node", "x", "y", "z", nodes=[1, 3])
    (one,) = read(folder, LONG, few).series
    np.testing.assert_array_equal(one.nodes, [1])
    np.testing.assert_array_equal(one.values[:, 0, 0], [1.0, 2.0])


def test_ids_that_are_none_are_refused(folder):
    (told,) = refused(folder, LONG.replace(",101,", ",7,"), NODES)
    assert told == (
        "bench.csv contains 1 node that net does not have: 7; ids of net run from 100 to 103"
    )
    (told,) = refused(folder, LONG.replace(",101,", ",1.5,"), NODES)
    assert told.startswith("line 3 of bench.csv has the node 1.5, which is not an id")
    (told,) = refused(folder, LONG.replace("1,101", "0,101"), NODES)
    assert told.startswith("lines 3 and 4 of bench.csv both give node 101 at 0 s")


def test_rows_without_a_time_are_sorted_by_displacement(folder):
    text = "u_mm;force_N\n2;4\n-1;1\n2;3\n0;2\n"
    found = read(folder, text, moved=[3])
    np.testing.assert_allclose(found.series[0].times, [-1e-3, 0.0, 2e-3, 2e-3])
    np.testing.assert_array_equal(found.series[0].values, [1.0, 2.0, 4.0, 3.0])
    named = read(folder, text, moved=[3], time=column("u_mm", 1e-3))
    np.testing.assert_array_equal(found.series[0].times, named.series[0].times)


# --- which rows -------------------------------------------------------------------------------


@given(
    st.lists(st.floats(-100, 100), unique=True, min_size=1).map(sorted),
    st.floats(1e-2, 1e2),
)
def test_values_every_so_often_are_the_nearest_and_none_is_taken_twice(times, every):
    times = np.array(times)
    rows = nearest_rows(times, every)
    assert (np.diff(rows) > 0).all()
    multiple = np.ceil(times / every - 0.5 - 1e-9)  # in the middle, rounding may go both ways
    assert len(set(multiple[rows])) == len(rows) == len(set(multiple))
    off = np.abs(times - multiple * every)
    for row in rows:
        assert off[row] == off[multiple == multiple[row]].min()


def test_every_so_often_chooses_among_values_and_not_among_gaps(folder):
    text = "t_ms,force_N\n" + "".join(f"{t},{'' if t == 10 else t}\n" for t in range(31))
    (one,) = read(folder, text, replace(FORCE, every=0.01)).series
    np.testing.assert_allclose(one.values, [0, 9, 20, 30])  # 9 ms and 11 ms are equally near


def series(times, values):
    return Series(FORCE, np.array(times, float), None, np.array(values, float))


def experiment(*parts, timed=True):
    return Experiment("x", "", parts, data(type("P", (), {"name": "x"})()), timed)


@given(
    st.lists(st.integers(0, 1000), unique=True, min_size=2).map(sorted), st.floats(0.01, 0.99)
)
def test_the_last_part_is_that_of_the_time(times, part):
    whole = experiment(series(times, np.ones(len(times))))
    first, last = whole.split(part)
    a, b = first.series[0].times, last.series[0].times
    np.testing.assert_array_equal(np.concatenate([a, b]), times)
    cut = times[-1] - part * (times[-1] - times[0])
    # One value at least on either side; the cut is that of rounded numbers.
    assert len(a) and len(b)
    assert (b[1:] > cut - 1e-9).all() and (a[1:] <= cut + 1e-9).all()
    assert last.data.held_out and not first.data.held_out


def test_parts_are_those_of_rows_where_there_is_no_time_and_gaps_do_not_count():
    pressed = experiment(series([0, 0, 0, 9, 100], np.ones(5)), timed=False)
    assert [len(part.series[0].times) for part in pressed.split(0.4)] == [3, 2]
    gaps = experiment(series([0, 1, 2, 3], [1, 1, np.nan, np.nan]))
    first, last = gaps.split(0.5)
    assert first.series[0].known.sum() == last.series[0].known.sum() == 1
    whole, nothing = gaps.split(0.0)
    assert len(whole.series[0].times) == 4 and nothing.duration == 0.0


def test_tables_are_read_without_hdf5():
    code = "import sys; import tissuec.measurements.reading; assert 'h5py' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


# --- units ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("head", "unit"),
    [
        ("t_s,force_N", 1e-3),
        ("t_s,force [mN]", 1.0),
        ("Time,force\n(s),(mN)", 1.0),
        ("t_s,force_kg", 1.0),
    ],
)
def test_a_column_in_another_unit_than_the_sentence_is_refused(folder, head, unit):
    """Newtons that are read as millinewtons are wrong a thousand times."""
    name = head.partition("\n")[0].partition(",")[2]
    (told,) = refused(folder, f"{head}\n0,1\n1,2\n", fit("force", name, unit=unit))
    assert "has another unit than the one after in" in told and told.endswith('number, "2"')


@pytest.mark.parametrize(
    "head", ["t_s,force_mN", "t_s,F", "t_s,force (filtered)", "t_s,specimen A", "t_s,m"]
)
def test_a_column_in_the_same_unit_or_in_none_is_read(folder, head):
    name = head.partition(",")[2]
    experiment = read(folder, f"{head}\n0,1\n1,2\n", fit("force", name, unit=1e-3))
    assert experiment.series[0].values == pytest.approx([1e-3, 2e-3])


def test_a_unit_that_is_wrong_in_a_file_is_avoided_by_the_number_of_its_column(folder):
    experiment = read(folder, "t_s,force_N\n0,1\n1,2\n", fit("force", "2", unit=1e-3))
    assert experiment.series[0].values == pytest.approx([1e-3, 2e-3])
