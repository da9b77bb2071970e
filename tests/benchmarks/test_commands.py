"""The benchmarks as commands: they are listed, say what they measure, and measure it."""

import json
import re
import shutil
import subprocess
import sys
from importlib import import_module

import pytest
from click.testing import CliRunner

from benchmarks import features, force_costs, kernels, publishing, scenes, stepping, threads
from benchmarks.__main__ import benchmarks
from tests.every import every
from tests.test_docs import PAGES

KNOWN = benchmarks()


def invoke(main, *words):
    result = CliRunner().invoke(main, words, catch_exceptions=False)
    assert result.exit_code == 0
    return result.stdout


def command_of(name):
    module = import_module(f"benchmarks.{name}")
    return getattr(module, "main", None) or import_module(f"benchmarks.{name}.__main__").main


def rows_of(table):
    return [line.strip("| ").split(" | ") for line in table.splitlines() if line]


def test_all_are_listed_with_what_they_measure(repository):
    listed = subprocess.run(
        [sys.executable, "-m", "benchmarks"],
        cwd=repository, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert {"kernels", "scenes", "stability"} <= set(KNOWN)
    for name, summary in KNOWN.items():
        assert re.search(rf"^{name} +{re.escape(summary)}$", listed, re.MULTILINE)


@every("name", KNOWN)
def test_each_says_what_it_does(name):
    said = " ".join(invoke(command_of(name), "--help").split())
    assert KNOWN[name] in said


def test_places_in_pages_are_those_of_benchmarks():
    texts = [page.read_text(encoding="utf-8") for page in PAGES]
    named = {name for text in texts for name in re.findall(r"benchmarks\.(\w+)", text)}
    assert named - {"NAME"} <= set(KNOWN)


def test_tables_are_printed_and_written_where_that_is_asked_for(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(publishing, "DOCS", tmp_path)
    page = "<!-- benchmarks.one: a b -->\nold\n<!-- end of a b -->\n"
    (tmp_path / "page.md").write_text(page)
    publishing.publish("one", {"a b": "new"}, page="page.md")
    assert capsys.readouterr().out == "new\n"
    assert (tmp_path / "page.md").read_text() == page
    publishing.publish("one", {"a b": "new"}, page="page.md", write=True, document={"a": 1})
    assert json.loads(capsys.readouterr().out) == {"a": 1}
    assert (tmp_path / "page.md").read_text().splitlines()[1:-1] == ["", "new", ""]


@pytest.fixture
def quick(monkeypatch):
    """Have the tube and the smallest lattice stepped a few times, once."""
    tube, lattice = stepping.nets()[:2]
    for module in (kernels, features, threads):
        monkeypatch.setattr(module, "REPEATS", 1)
        monkeypatch.setattr(module, "nets", lambda: [tube, lattice, lattice, lattice])
    for module in (stepping, kernels):
        monkeypatch.setattr(module, "WORK", 1e4)


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_kernels_are_measured_beside_a_loop_in_c(quick):
    _, _, tube, lattice, *_ = rows_of(invoke(kernels.main))
    assert tube[:3] == ["tube", "160", "610"]
    assert lattice[:3] == ["lattice 10³", "1000", "7560"]
    assert all(float(cell.split()[0]) > 0.0 for cell in (*tube[3:], *lattice[3:]))


def test_two_threads_are_measured_beside_one(quick):
    _, _, lattice, _ = rows_of(invoke(threads.main))
    assert lattice[:2] == ["lattice 10³", "7560"]
    assert all(float(cell) > 0.0 for cell in lattice[2:])


def test_every_feature_is_measured(quick):
    rows = rows_of(invoke(features.main))
    assert [row[0] for row in rows[3:]] == [feature.name for feature in features.FEATURES]
    assert all(float(cell) > 0.0 for row in rows[3:] for cell in row[1:] if cell)


def test_forces_are_compared_with_a_spring(monkeypatch):
    monkeypatch.setattr(force_costs, "REPEATS", 1)
    monkeypatch.setattr(force_costs, "LASTS", 1e-4)
    monkeypatch.setattr(force_costs, "FEATURES", force_costs.FEATURES[:2])
    monkeypatch.setattr(force_costs, "MATRICES", dict(list(force_costs.MATRICES.items())[:1]))
    rows = rows_of(invoke(force_costs.main))
    assert [row[0] for row in rows[2:5]] == [
        "spring", *(one.name for one in force_costs.FEATURES)]  # fmt: skip
    assert rows[3][2].endswith(" ns")
    assert float(rows[-1][2]) > 0.0


def test_scenes_are_measured_beside_scipy(monkeypatch):
    monkeypatch.setattr(scenes, "stay_on_one_processor", lambda: None)
    monkeypatch.setattr(scenes, "TOLERANCES", (1e-2, 1e-4))
    words = ("--scene", "L10", "--repeat", "1", "--json")
    best = json.loads(invoke(scenes.main, *words))["L10"]["within"]
    assert {one["method"] for one in best if one["bound"] == 1e-2} == set(scenes.SOLVERS)
    for one in best:
        assert 0.0 < one["error"] <= one["bound"]
        assert one["seconds"] > 0.0
