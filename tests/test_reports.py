"""One report is shown as text, as JSON and as HTML, and its levels decide where."""

import json

import click
import pytest
from click.testing import CliRunner

from tissuec.cli.common import Command, Reports, Settings
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.report import (
    FAILED,
    Fact,
    FactSection,
    FactTable,
    FailedExpectation,
    Report,
    Verbatim,
    as_text,
    failed,
    lines,
)
from tissuec.view.report.markup import shown

TABLE = FactTable(("quantity", "value"), [("mass", "3 g"), ("stiffness", "")], "What it is")
PARTS = (
    "a sentence",
    Fact("result", "tube.vtkhdf"),
    FactSection("a section", [TABLE, FactSection("", ["inside"])]),
    FailedExpectation("scene.tis:3: expect x < 1 mm", "x = 2 mm"),
)


def test_parts_become_lines():
    assert as_text(PARTS) == [
        "a sentence",
        "result: tube.vtkhdf",
        "",
        "a section",
        "  quantity   value",
        "  mass       3 g",
        "  stiffness",
        "    inside",
        "FAILED scene.tis:3: expect x < 1 mm",
        "       x = 2 mm",
    ]


def test_parts_become_html_that_escapes_what_it_shows():
    page = shown([*PARTS, Verbatim("a < b"), Fact("x", "<b>")])
    for piece in (
        "<ul><li>a sentence</li></ul>",
        "<dt>result</dt><dd>tube.vtkhdf</dd>",
        "<h3>A section</h3>",
        "<caption>What it is.</caption>",
        '<th scope="row">mass</th><td>3 g</td>',
        "<ul><li>inside</li></ul>",
        "expect x &lt; 1 mm</dt><dd>x = 2 mm",
        "<pre>a &lt; b</pre>",
        "<dd>&lt;b&gt;</dd>",
    ):
        assert piece in page, piece


def test_levels_come_from_the_part_or_from_the_report():
    parts = ["a", Fact("", "b", "failure"), FactSection("c", [Fact("d", "e")]), PARTS[3]]
    levels = [level for level, _ in lines(parts, "remark")]
    assert levels == ["remark", "failure", "remark", "remark", "failure", "failure"]


def test_a_table_that_is_too_wide_keeps_its_first_columns():
    rows = [("short", "1", "a reason of many words"), ("a longer name", "2", "why")]
    table = FactTable((), rows, kept=2)
    assert [line for _, line in lines([table], width=30)] == [
        "short          1",
        "    a reason of many words",
        "a longer name  2  why",
    ]
    assert [line for _, line in lines([table], width=80)] == [
        "short          1  a reason of many words",
        "a longer name  2  why",
    ]


@pytest.fixture
def call():
    """Return a function that calls a command that returns a report; gives code and outputs."""

    def call(found, *words):
        @click.command(cls=Command)
        @click.argument("scene")
        def command(settings: Settings, scene: str):
            if isinstance(found, Exception):
                raise found
            return found

        ran = CliRunner().invoke(command, ["file", *words], standalone_mode=False)
        if ran.exception is not None:
            raise ran.exception
        return ran.return_value, ran.stdout, ran.stderr

    return call


LEVELS = [Fact("", level, level) for level in ("result", "remark", "failure")]


@pytest.mark.parametrize(
    ("words", "err"),
    [
        ([], "remark\nfailure\n"),
        (["-q"], "failure\n"),
    ],
)
def test_results_go_to_stdout_and_the_rest_to_stderr(call, words, err):
    assert call(Report(LEVELS), *words) == (0, "result\n", err)


def test_json_is_the_document_with_ok(call):
    code, out, err = call(Report(LEVELS, {"mass": float("nan")}, FAILED), "--json")
    assert (code, json.loads(out), err) == (FAILED, {"ok": False, "mass": None}, "")
    table = Report((), {"force": [1.0]}, is_table=True)
    assert json.loads(call(table, "--json")[1]) == {"force": [1.0]}


def test_several_reports_are_a_list_and_end_with_an_interruption(call):
    each = [Report(["a"], {"n": 1}), failed("broken", 3, n=2), Report(["c"], {"n": 3}, 130)]
    codes, out, err = call(Reports([*each, Report(["d"])], is_list=True))
    assert (codes, out, err) == (130, "a\nc\n", "error: broken\n")
    assert call(Reports([failed("broken", 3), Report(["a"])], is_list=True))[0] == 3
    documents = json.loads(call(Reports(each, is_list=True), "--json")[1])
    assert [(one["n"], one["ok"]) for one in documents] == [(1, True), (2, False), (3, False)]
    assert documents[1]["error"] == "broken"


def test_text_that_is_wrong_is_a_report_of_its_findings(call):
    wrong = CompileError([Diagnostic("TIS104", "no unit", None)])
    code, out, err = call(wrong)
    assert (code, out) == (2, "") and err.startswith("error[TIS104]: no unit")
    document = json.loads(call(wrong, "--json")[1])
    assert document["ok"] is False and document["scene"] == "file"
    assert [one["code"] for one in document["diagnostics"]] == ["TIS104"]


def test_verbatim_text_is_printed_unchanged(call):
    assert call(Report([Verbatim("no line end \x1b")]))[1] == "no line end \x1b"
