"""The table of a study: what is written is what is read, to the last digit."""

import random
import re
from contextlib import suppress

import h5py
import numpy as np
import pytest

from tests import damage
from tests.study.tables import HEAD, ROWS, table
from tissuec.api.study_table import StudyTable, read_table
from tissuec.core.structs import replace
from tissuec.results import ResultError
from tissuec.studies.table import Column, rows_of
from tissuec.studies.table_text import as_csv, head_lines, row_line


def assert_equal(one: StudyTable, other: StudyTable) -> None:
    assert one.head == other.head
    for name in ("outcome", "promise", "digests", "doubts"):
        assert getattr(one, name) == getattr(other, name), name
    assert np.array_equal(one.runs, other.runs)
    assert np.array_equal(one.error, other.error, equal_nan=True)
    for a, b in zip(one.columns, other.columns, strict=True):
        assert a.title == b.title
        if isinstance(a.values, tuple):
            assert a.values == b.values
        else:
            assert np.array_equal(a.values, b.numbers, equal_nan=True), a.name
    for a, b in zip(one.curves, other.curves, strict=True):
        assert np.array_equal(a.values, b.values, equal_nan=True)
        assert np.array_equal(a.times, b.times)


@pytest.mark.parametrize("name", ["table.csv", "table.h5"])
def test_what_is_written_is_what_is_read(tmp_path, name):
    path = tmp_path / name
    (table().to_csv if name.endswith("csv") else table().to_hdf5)(path)
    assert_equal(read_table(path), table())
    assert [file.name for file in tmp_path.iterdir()] == [name]


def test_a_table_has_its_rows_and_head_again():
    assert as_csv(HEAD, rows_of(table())) == as_csv(HEAD, ROWS)


@pytest.mark.parametrize("name", ["table.csv", "table.h5"])
def test_doubts_are_written_and_read(tmp_path, name):
    path = tmp_path / name
    doubtful = StudyTable.of(HEAD, (*ROWS[:2], replace(ROWS[2], doubts="inside out"), ROWS[3]))
    (doubtful.to_csv if name.endswith("csv") else doubtful.to_hdf5)(path)
    assert_equal(read_table(path), doubtful)
    assert read_table(path).doubts == ("", "", "inside out", "")


@pytest.mark.parametrize(("number", "lacks"), [(1, ",doubts,end [s]"), (2, ",end [s]")])
def test_tables_of_earlier_formats_are_read_without_what_they_lack(tmp_path, number, lacks):
    path = tmp_path / "table.csv"
    first, names, *lines = as_csv(HEAD, ROWS).splitlines()
    first = first.replace('"format": 3', f'"format": {number}')
    commas = "," * lacks.count(",")
    shorter = [names.removesuffix(lacks), *(line.removesuffix(commas) for line in lines)]
    path.write_text("\n".join([first, *shorter, ""]), "utf-8")
    assert_equal(read_table(path), table())


@pytest.mark.parametrize("name", ["table.csv", "table.h5"])
def test_ends_are_written_and_read(tmp_path, name):
    path = tmp_path / name
    known = StudyTable.of(HEAD, [replace(row, end=0.1 * n) for n, row in enumerate(ROWS)])
    (known.to_csv if name.endswith("csv") else known.to_hdf5)(path)
    assert read_table(path).end.tolist() == [0.1 * n for n in range(4)]


def test_lines_in_any_order_give_one_table(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(head_lines(HEAD) + "".join(map(row_line, reversed(ROWS))), "utf-8")
    found = read_table(path)
    assert_equal(found, table())
    assert found.is_complete and found.finished.tolist() == [True, False, True, False]


def test_a_line_that_was_cut_short_is_left_out(tmp_path):
    path, whole = tmp_path / "table.csv", as_csv(HEAD, ROWS)
    path.write_text(whole[:-3], "utf-8")
    found = read_table(path)
    assert len(found) == 3 and not found.is_complete
    assert repr(found) == '<StudyTable "lifting" of liver: 3 of 4 runs>'


def test_of_two_rows_of_a_run_the_later_one_counts():
    again = (*ROWS, ROWS[0])
    assert len(StudyTable.of(HEAD, again)) == 4
    assert StudyTable.of(HEAD, (ROWS[3], *ROWS[:3])).outcome[3] == "died"


def test_a_reason_is_one_line(tmp_path):
    table().to_csv(tmp_path / "table.csv")
    assert read_table(tmp_path / "table.csv").reason[1] == "a, and b"
    assert len((tmp_path / "table.csv").read_text("utf-8").splitlines()) == 2 + len(ROWS)


def test_a_column_is_found_by_name_and_knows_its_kind():
    assert table().column("Pull").numbers[0] == 0.1 + 0.2
    with pytest.raises(ValueError, match='no column "pul"; did you mean "pull"'):
        table().column("pul")
    with pytest.raises(ValueError, match="are words, not numbers"):
        _ = table().factors[1].numbers
    assert Column("ratio", "", np.zeros(1)).title == "ratio"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("lift,pull\n1,2\n", "not a table of a study"),
        (head_lines(HEAD).replace('"format": 3', '"format": 9'), "another version"),
        (
            head_lines(HEAD) + "0,2,soft\n",
            "damaged table: line 3: the row of run 0 has 3 cells",
        ),
        (head_lines(HEAD) + row_line(ROWS[0]).replace("0.25", "x"), "damaged table"),
    ],
)
def test_other_files_are_refused(tmp_path, text, message):
    path = tmp_path / "table.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(ResultError, match=message):
        read_table(path)
    (tmp_path / "table.h5").write_bytes(b"nothing")
    with pytest.raises(ResultError, match="cannot read"):
        read_table(tmp_path / "table.h5")


def test_pandas_has_units_in_its_heads():
    frame = table().to_pandas()
    assert frame["lift [mm]"].tolist() == [2.0, 2.0, 4.0, 4.0]
    assert frame.loc[3, "outcome"] == "died"
    assert frame.attrs["study"] == "lifting"


def test_xarray_has_the_axes_of_a_complete_grid():
    dataset = table().to_xarray()
    name = HEAD.factors[1].name
    assert dataset["pull"].dims == ("lift", name)
    assert float(dataset["pull"].sel({"lift": 4.0, name: "soft"})) == 2e-300
    assert dataset["curve"].shape == (2, 2, 3)
    part = StudyTable.of(HEAD, ROWS[:3]).to_xarray()
    assert part["pull"].dims == ("run",) and part["lift"].dims == ("run",)


def test_a_table_is_read_whatever_its_curves(tmp_path):
    """A curve is one cell, and modules that read CSV refuse those above 131 072 characters."""
    whole, path = as_csv(HEAD, ROWS), tmp_path / "table.csv"
    curve = " ".join(str(n / 7) for n in range(30_000))
    old = next(cell for cell in whole.splitlines()[2].split(",") if " " in cell)
    path.write_text(whole.replace(old, curve, 1), "utf-8")
    assert len(curve) > 131_072
    found = read_table(path)
    assert found.curves[0].values.shape[1] == 30_000
    assert found.curves[0].values[0, -1] == 29_999 / 7


@pytest.mark.parametrize("run", [-1, 4, 2**63, 10**400])
def test_a_run_that_the_study_does_not_have_is_damage(tmp_path, run):
    path = tmp_path / "table.csv"
    path.write_text(head_lines(HEAD) + f"{run}," + row_line(ROWS[0]).partition(",")[2], "utf-8")
    with pytest.raises(ResultError, match=r"line 3: .*; without that line, the study does its"):
        read_table(path)


def read_damaged(path, change, seeds):
    """Change a table in many ways; nothing but a ResultError comes of it."""
    whole = path.read_bytes()
    for seed in seeds:
        path.write_bytes(whole)
        dice = random.Random(seed)
        for _ in range(dice.choice([1, 1, 3])):
            change(dice, path)
        with suppress(ResultError):
            found = read_table(path)
            as_csv(found.head, rows_of(found))


def flip(dice, path):
    data = bytearray(path.read_bytes())
    data[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
    path.write_bytes(data)


def reword(dice, path):
    cells = re.split(r"([,\n])", path.read_text("utf-8"))
    cells[dice.randrange(len(cells))] = dice.choice(
        ["", "1e999", "-1", "9" * 30, "nan", "x", '"', "0x1", "1 2 nan", "\0", "٣", "{}"]
    )
    path.write_text("".join(cells), "utf-8")


def restructure(dice, path):
    with h5py.File(path, "r+") as file:
        dice.choice([damage.remove, damage.retype, damage.reshape, damage.renumber])(dice, file)


@pytest.mark.parametrize(
    ("name", "change"),
    [("table.csv", flip), ("table.csv", reword), ("table.h5", flip), ("table.h5", restructure)],
)
def test_a_damaged_table_is_a_result_error(tmp_path, name, change):
    path = tmp_path / name
    (table().to_csv if name.endswith("csv") else table().to_hdf5)(path)
    read_damaged(path, change, range(60))
