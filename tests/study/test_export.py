"""``tissuec export`` of tables."""

import csv
import json

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from tests.study import tables_of_designs as tables
from tissuec.api.study_table import read_table
from tissuec.cli import group


def call(*words):
    """Return exit code and both streams of the command."""
    found = CliRunner().invoke(group, list(words))
    return found.exit_code, found.stdout, found.stderr


@pytest.fixture
def grid(tmp_path, monkeypatch):
    """Return the table of a grid, one run of which failed; it is "grid.csv" here."""
    monkeypatch.chdir(tmp_path)
    table = tables.grid()
    table.to_csv("grid.csv")
    return table


def test_formats_are_turned_into_each_other(grid, tmp_path):
    assert call("export", "grid.csv", "-o", "grid.h5")[0] == 0
    assert "study" in h5py.File("grid.h5").attrs
    assert call("export", "grid.h5", "-o", "again.csv")[0] == 0
    whole = (tmp_path / "grid.csv").read_bytes()
    assert (tmp_path / "again.csv").read_bytes() == whole
    assert call("export", "grid.csv")[1].encode() == whole
    assert np.array_equal(read_table("grid.h5").curves[0].values, grid.curves[0].values, True)


def test_measures_are_a_plain_table(grid):
    code, out, _ = call("export", "grid.csv", "m1", "M0")
    head, first, *_, last = csv.reader(out.splitlines())
    assert code == 0
    assert head == ["run", "lift [mm]", "hardness of liver", "m1 [ms]", "m0 [mN]", "outcome"]
    assert first == ["0", "1.0", "soft", "100.0", "1.0", "done"]
    assert last == ["11", "6.0", "hard", "", "", "diverged"]


def test_curves_have_a_row_for_each_sample_and_failed_runs_an_empty_one(grid):
    rows = list(csv.DictReader(call("export", "grid.csv", "curve", "m1")[1].splitlines()))
    assert len(rows) == 11 * 5 + 1
    assert rows[7] == {
        "run": "1", "lift [mm]": "1.0", "hardness of liver": "hard", "time [s]": "0.2",
        "curve [mN]": "6.0", "m1 [ms]": "100.0", "outcome": "done",
    }  # fmt: skip
    assert (rows[-1]["time [s]"], rows[-1]["outcome"]) == ("", "diverged")


def test_json_has_columns(grid):
    found = json.loads(call("--json", "export", "grid.csv", "m0")[1])
    assert found["lift [mm]"][:3] == [1.0, 1.0, 2.0] and found["m0 [N]"][-1] is None
    assert json.loads(call("--json", "export", "grid.csv", "-o", "a.h5")[1])["runs"] == 12


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("grid.csv", "m7"), 'no measure "m7"'),
        (("grid.csv", "-o", "a.vtu"), "no frames; write it as .csv or .h5"),
        (("grid.csv", "-o", "a.nc"), "does not end with"),
        (("grid.csv", "--format", "h5"), "needs a file: -o table.h5"),
        (("grid.csv", "m0", "-o", "a.h5"), "whole tables"),
        (("grid.csv", "--time", "1"), "--time is for results"),
        (("grid.csv", "--surface", "liver"), "--surface is for results"),
        (("grid.csv", "-o", "grid.csv"), "is the input file"),
        (("none.csv",), 'cannot read "none.csv"'),
        (("grid.csv", "m0", "-o", "nowhere/a.csv"), 'cannot write "nowhere'),
    ],
)
def test_what_cannot_be_exported_is_told(grid, words, said):
    found = CliRunner().invoke(group, ["export", *words])
    assert found.exit_code and said in f"{found.stderr}{found.exception}"
