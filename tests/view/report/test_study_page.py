"""The page about a study: what it says, and that it stands alone."""

from html.parser import HTMLParser

import pytest
from click.testing import CliRunner

from tests.study import tables_of_designs as tables
from tissuec.api.study_table import StudyTable
from tissuec.cli import group
from tissuec.studies.table import FactorHead, rows_of
from tissuec.view.report.study import MOST_ROWS, render_study

pytest.importorskip("matplotlib")
pytestmark = pytest.mark.usefixtures("unplaced")


class Page(HTMLParser):
    """Headings, tables and texts of a page; complains about elements that do not nest."""

    def __init__(self, text):
        super().__init__()
        self.open, self.rows, self.text = [], 0, ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)
        self.rows += tag == "tr"

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("style", "script"):
            self.text += f"{data} "


def page(table, tmp_path):
    path = tmp_path / "table.csv"
    table.to_csv(path)
    return Page(render_study(table, path))


def test_a_family_is_shown_with_its_failure(tmp_path):
    text = page(tables.grid(), tmp_path).text
    assert "1 run of 12 failed" in text
    assert "the motion diverged" in text
    assert "hardness of liver" in text and "[soft, hard]" in text
    assert "1 to 15" in text  # the range of m0
    assert "Sobol" not in text and "Quantiles" not in text


def test_sensitivities_are_shown_with_intervals(tmp_path):
    found = tables.indices().sobol_indices("m0")[0]
    text = page(tables.indices(), tmp_path).text
    assert f"{found.first:.3f}" in text
    assert f"{found.total_interval[0]:.3f} to {found.total_interval[1]:.3f}" in text
    assert "the first" in text.lower() and str(MOST_ROWS) in text  # of 1280 rows


def test_quantiles_are_shown(tmp_path):
    median = tables.sample().quantiles("m0", 0.5)[0]
    value, low = 1e3 * median.value, 1e3 * median.low  # [mN]
    assert f"{value:.4g} ({low:.4g} to" in page(tables.sample(), tmp_path).text


def few(x):
    """Return a measure that some runs lack, and others fail to have."""
    return None if x == 1.0 else (float("nan") if x == 2.0 else x,)


def test_no_number_that_is_none_is_shown(tmp_path):
    points = [(float(n),) for n in range(8)]
    sample = tables.table_of("sobol", [tables.LIFT], points, few)
    text = page(sample, tmp_path).text
    assert "no interval with 6 runs: 5 % needs 72 runs" in text
    assert "left out of 8 runs: 1 failed, 1 without a value" in text
    blocks = [(x, y) for x in (0.0, 3.0, 4.0, 5.0, 6.0) for y in (0.0, 1.0)] * 2
    factors = [tables.LIFT, FactorHead("width", "mm")]
    indices = tables.table_of(
        "sobol indices", factors, blocks, lambda x, y: few(x), base=len(blocks) // 4
    )
    own = tables.table_of("one at a time", [tables.LIFT], [(float("nan"),), (2.0,)], few)
    for table in (sample, indices, own, tables.grid(), tables.indices(4, failed=(3,))):
        text = page(table, tmp_path).text
        assert "nan" not in text.split() and "(nan" not in text


def test_a_part_of_a_study_is_told(tmp_path):
    table = tables.plane()
    part = StudyTable.of(table.head, list(rows_of(table))[:7])
    assert "not finished: 7 of 30 runs" in page(part, tmp_path).text


def test_a_page_needs_nothing_else(tmp_path):
    path = tmp_path / "table.csv"
    tables.grid().to_csv(path)
    text = render_study(tables.grid(), path)
    assert "http" not in text.replace("http-equiv", "").replace("http://www.w3.org", "")


def call(*words):
    """Return exit code and both streams of the command."""
    found = CliRunner().invoke(group, list(words), standalone_mode=False)
    return found.return_value, found.stdout, found.stderr


def test_the_command_writes_pages_of_tables(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tables.grid().to_csv(tmp_path / "grid.csv")
    code, _, err = call("report", "grid.csv")
    assert code == 0
    assert "1 run of 12 failed" in err
    assert (tmp_path / "grid.report.html").exists()
    assert '"diverged": 1' in call("--json", "info", "grid.csv")[1]


def test_a_file_that_is_no_table_is_told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other.csv").write_text("a,b\n1,2\n", "utf-8")
    for command in ("info", "report", "plot"):
        found = CliRunner().invoke(group, [command, "other.csv"], standalone_mode=False)
        assert "not a table of a study" in f"{found.exception}{found.stderr}"
