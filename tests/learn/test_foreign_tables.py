"""Tables as instruments and programs write them: heads, rows of units, clocks and gaps."""

import warnings

import numpy as np
import pytest

from tests.findings import finding_of
from tests.learn.lessons import NET, column, data, fit, fit_problem
from tissuec.core.errors import CompileError
from tissuec.core.structs import replace
from tissuec.core.text_tables.columns import BadRow, read_columns
from tissuec.core.text_tables.table import find_dialect
from tissuec.core.units import FORCE, TIME
from tissuec.measurements.reading import check_times, read_experiment

ROWS = [(0.0, 10.0), (0.02, 15.5), (0.04, 21.0)]
BODY = "".join(f"{t:.2f},{f:.4f}\n" for t, f in ROWS)
TABBED = BODY.replace(",", "\t")
HEADS = {
    "preamble": f'Specimen label,liver 5\nRate,"5 mm/s"\n\nTime,Force\n{BODY}',
    "sto": f"force\nversion=1\nnRows=3\nnColumns=2\nendheader\nTime\tForce\n{TABBED}",
    "units": f"Time,Force\n(s),(mN)\n{BODY}",
    "instron": '"Test","A 7"\n\n"Time","Force"\n"(s)","(N)"\n' + BODY,
    "properties": f"Width,10.0\nLength,25.0\n\nTime,Force\n(s),(N)\n{BODY}",
    "tabs": f"Rate:\t100\nGain\t2.0\n\nTime\tForce\nSec\tN\n{TABBED}",
    "semicolons": "Probe;7\n\nTime;Force\ns;N\n" + BODY.replace(",", ";").replace(".", ","),
}
TRC = (
    "PathFileType\t4\t(X/Y/Z)\tgait.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\n100\t100\t3\t2\tmm\t100\n"
    "Frame#\tTime\tknee\t\t\ttoe\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
    + "".join(f"{k + 1}\t{0.01 * k:.2f}\t1\t2\t3\t4\t{5 + k}\t6\t\n" for k in range(3))
)


def experiment(folder, text, one, start=0.0, **axis):
    path = folder / "bench.csv"
    path.write_text(text)
    return read_experiment(replace(data(path), start=start), fit_problem(one, **axis), NET)


@pytest.mark.parametrize("name", HEADS)
def test_tables_are_found_below_their_heads(name, tmp_path):
    unit = 1e-3 if "(mN)" in HEADS[name] else 1.0
    found = experiment(tmp_path, HEADS[name], fit("force", "Force", unit=unit)).series[0]
    assert found.times.tolist() == [t for t, _ in ROWS]
    assert found.values.tolist() == [f * unit for _, f in ROWS]


def test_a_row_of_units_gives_the_unit_of_times(tmp_path):
    dialect = find_dialect(HEADS["units"].replace("(s)", "(ms)"))
    assert dialect is not None
    time, force = dialect.unit(0), dialect.unit(1)
    assert (time.factor, time.dimension) == (1e-3, TIME)
    assert (force.factor, force.dimension) == (1e-3, FORCE)
    text = HEADS["units"].replace("(s)", "(ms)")
    found = experiment(tmp_path, text, fit("force", "Force", unit=1e-3)).series[0]
    assert found.times == pytest.approx([1e-3 * t for t, _ in ROWS])


def test_markers_of_a_trc_file_have_a_column_for_each_axis(tmp_path):
    found = experiment(tmp_path, TRC, fit("distance", "toe_y", unit=1e-3)).series[0]
    assert found.times == pytest.approx([0.0, 0.01, 0.02])
    assert found.values == pytest.approx([5e-3, 6e-3, 7e-3])


def test_body_parts_of_deeplabcut_have_columns(tmp_path):
    text = "scorer,net,net,net\nbodyparts,tip,tip,tip\ncoords,x,y,likelihood\n"
    text += "".join(f"{k},{10 + k},0,0.99\n" for k in range(3))
    found = experiment(tmp_path, text, fit("force", "tip_x"), time=column("frame", 0.01))
    assert found.series[0].times == pytest.approx([0.0, 0.01, 0.02])
    assert found.series[0].values.tolist() == [10.0, 11.0, 12.0]


@pytest.mark.parametrize(
    ("name", "columns"),
    [("instron", "Time, Force  (the table begins in line 3"), ("properties", "Time, Force  (")],
)
def test_columns_are_those_of_the_table_below_its_head(name, columns, tmp_path):
    with pytest.raises(CompileError) as caught:
        experiment(tmp_path, HEADS[name], fit("force", "Load"))
    assert f"columns: {columns}" in str(caught.value.diagnostics[0].hint)


def test_columns_of_markers_are_listed_without_a_word_on_the_head(tmp_path):
    with pytest.raises(CompileError) as caught:
        experiment(tmp_path, TRC, fit("distance", "hip_y"))
    hint = str(caught.value.diagnostics[0].hint)
    assert hint.endswith("columns: frame, time, knee_x, knee_y, knee_z, toe_x, toe_y, toe_z")


def test_a_factor_before_the_unit_of_a_name_is_meant(tmp_path):
    text = f"t_s,f_mN\n{BODY}"
    doubled = fit("force", "f_mN", unit=2e-3)
    with pytest.raises(CompileError, match="has another unit"):
        experiment(tmp_path, text, doubled)
    (column,) = doubled.columns
    meant = replace(doubled, columns=(replace(column, factor=2.0),))
    assert experiment(tmp_path, text, meant).series[0].values.tolist() == pytest.approx(
        [2e-3 * f for _, f in ROWS], rel=1e-14
    )


@pytest.mark.parametrize("gap", ["#N/A", "--", "None", "1.#QNAN", "n.a."])
def test_gaps_as_programs_write_them(gap, tmp_path):
    text = f"t_s,Force\n0,1\n1,{gap}\n2,3\n"
    values = experiment(tmp_path, text, fit("force", "Force")).series[0].values
    assert np.array_equal(values, [1.0, np.nan, 3.0], equal_nan=True)


def test_a_head_without_rows_is_refused(tmp_path):
    with pytest.raises(CompileError, match="contains no row of numbers"):
        experiment(tmp_path, "t_s,Force\n", fit("force", "Force"))


def test_a_clock_that_begins_later(tmp_path):
    text = "t_s,Force\n" + "".join(f"{12.4 + t:.2f},{f}\n" for t, f in ROWS)
    late = experiment(tmp_path, text, fit("force", "Force"))
    with pytest.raises(CompileError) as caught:
        check_times(late, 0.04)
    assert 'data "bench.csv" from 12.4 s' in str(caught.value.diagnostics[0].hint)
    found = experiment(tmp_path, text, fit("force", "Force"), start=12.42)
    check_times(found, 0.04)
    assert found.series[0].times == pytest.approx([0.0, 0.02])
    assert found.series[0].values.tolist() == [15.5, 21.0]


@pytest.mark.parametrize("last", ["2x", "x", "2 3", "0x10", "1e"])
def test_what_follows_the_last_number_is_found_and_filters_stay(monkeypatch, last):
    def refused(*_, **__):
        raise AssertionError("filters of warnings belong to all threads")

    monkeypatch.setattr(warnings, "catch_warnings", refused)
    text = f"t,f\n0,1\n1,{last}\n"
    with pytest.raises(BadRow):
        read_columns(text, find_dialect(text), (0, 1))
    good = text.replace(last, "2")
    assert read_columns(good, find_dialect(good), (0, 1)).tolist() == [[0, 1], [1, 2]]


BAD_CELLS = [
    ("00:01:23.5", "83.5 for 00:01:23.5"),
    ("1:23,5", "83.5 for 1:23,5"),
    ("2024-05-01", "instead of dates"),
    ("01.05.2024", "instead of dates"),
    ("1'234.5", "without separators: 1234.5"),
    ("1 234.5", "without separators: 1234.5"),
    ("1.234.567", "without separators: 1234567"),
    ("1D+00", "write exponents with E: 1E+00"),
    ("-2.5d-3", "write exponents with E: -2.5E-3"),
    ("12.5 mN", 'the unit "mN" after 12.5'),
    ("12.5%", 'the unit "%" after 12.5'),
    ("12.5 *", 'the text "*" after 12.5'),
    ("3.0 (est.)", 'the text "(est.)" after 3.0'),
    ("<0.5", "a limit is not a measured number"),
    ("OVL", "leave a gap empty"),
    ("inf", "leave a gap empty"),
]


@pytest.mark.parametrize(("cell", "said"), BAD_CELLS)
def test_a_cell_that_is_no_number_is_answered_with_what_it_should_be(cell, said, tmp_path):
    text = f"t_s\tForce\n0\t1\n1\t{cell}\n2\t3\n"
    found = finding_of(experiment, tmp_path, text, fit("force", "Force"))
    assert (
        found.message == f'line 3 of bench.csv, column "Force": "{cell}" is not a finite number'
    )
    assert said in found.hint


@pytest.mark.parametrize("text", ['0,"1,234"\n1,"2,345"\n', "0,1,234.5\n1,2,345.5\n"])
def test_groups_of_thousands_are_never_decimals(text, tmp_path):
    with pytest.raises(CompileError) as caught:
        experiment(tmp_path, f"t_s,Force\n{text}", fit("force", "Force"))
    assert "line 2 of bench.csv" in caught.value.diagnostics[0].message
    assert "write d" in caught.value.diagnostics[0].hint


def test_no_thousands_begin_with_a_zero(tmp_path):
    found = experiment(tmp_path, 't_s,Force\n0,"0,875"\n1,"-0,125"\n', fit("force", "Force"))
    assert found.series[0].values.tolist() == [0.875, -0.125]


@pytest.mark.parametrize("mark", ["-9999", "-999.25", "-999.0", "99999", "1e30", "-32768"])
def test_numbers_that_stand_for_gaps_are_asked_about(mark, tmp_path):
    text = f"t_s,Force\n0,1\n1,2.5\n2,{mark}\n3,4\n"
    found = finding_of(experiment, tmp_path, text, fit("force", "Force"))
    assert found.message.startswith('line 4 of bench.csv, column "Force": ')
    assert "leave a gap empty" in found.hint
    mended = experiment(tmp_path, text.replace(mark, ""), fit("force", "Force"))
    assert mended.series[0].known.tolist() == [True, True, False, True]


@pytest.mark.parametrize("values", [(-9990, -9997, -9999, -9980), (0, -500, -999, -1400)])
def test_numbers_among_others_are_measured(values, tmp_path):
    text = "t_s,Force\n" + "".join(f"{t},{f}\n" for t, f in enumerate(values))
    found = experiment(tmp_path, text, fit("force", "Force")).series[0]
    assert found.values.tolist() == list(values)


def test_columns_of_one_name_are_told_by_their_numbers(tmp_path):
    text = "t_s,Force,Force\n0,1,2\n1,3,4\n2,5,7\n"
    found = finding_of(experiment, tmp_path, text, fit("force", "Force"))
    assert found.hint == 'name one by its number: "2" or "3"'
    assert experiment(tmp_path, text, fit("force", "3")).series[0].values.tolist() == [2, 4, 7]


COUNTED = {
    "deeplabcut": "scorer,net,net\nbodyparts,tip,tip\ncoords,x,y\n0,10,0\n1,11,0\n2,12,1\n",
    "pandas": ",tip_x\n0,10\n1,11\n2,12\n",
    "samples": "Sample #;tip_x\n1;10\n2;11\n3;12\n",
}


@pytest.mark.parametrize("name", COUNTED)
def test_numbers_of_rows_are_no_times(name, tmp_path):
    found = finding_of(experiment, tmp_path, COUNTED[name], fit("force", "tip_x"))
    assert "counts rows; the time between them is missing" in found.message
    assert 'time using column "' in found.hint
    column_name = found.hint.partition('column "')[2].partition('"')[0]
    given = experiment(
        tmp_path, COUNTED[name], fit("force", "tip_x"), time=column(column_name, 0.01)
    )
    assert np.diff(given.series[0].times) == pytest.approx([0.01, 0.01])
