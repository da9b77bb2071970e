"""Diagnostics as people see them, and as programs read them."""

import json
import re

import pytest

from tests.every import every
from tissuec.core.errors import Diagnostic, Note, as_dict, render
from tissuec.core.source import Source, Span

SOURCE = Source(
    "sterilisation.tis", "\n" * 25 + "  at 0.10 s             grasp waist with forceps A\nx\n"
)


def finding(source, start, end, code="TIS105", hint="", notes=()):
    return Diagnostic(code, "something is wrong", Span(source, start, end), hint, notes)


def marked(text, start, end):
    """Return the excerpt and the carets of a one-line text."""
    lines = render(finding(Source("x", text), start, end)).split("\n")
    return lines[3][4:], lines[4][4:]


def test_layout_is_the_documented_one():
    start = SOURCE.text.index("grasp")
    diagnostic = Diagnostic(
        "TIS105",
        'missing ":" after the time',
        Span(SOURCE, start, start + 5),
        'write "at 0.10 s: grasp waist with forceps A"',
        (
            Note("forceps A is declared", Span(Source("tools.tis", "\n\ntool"), 2, 6)),
            Note("so it is"),
        ),
    )
    assert render(diagnostic) == (
        """error[TIS105]: missing ":" after the time
  --> sterilisation.tis:26:25
   |
26 |   at 0.10 s             grasp waist with forceps A
   |                         ^^^^^
   = hint: write "at 0.10 s: grasp waist with forceps A"
   = note: forceps A is declared at tools.tis:3
   = note: so it is"""
    )


def test_one_digit_lines_have_a_narrow_gutter():
    assert render(finding(Source("x", "abc"), 1, 2)) == (
        "error[TIS105]: something is wrong\n  --> x:1:2\n  |\n1 | abc\n  |  ^"
    )


def test_warnings_say_so():
    assert render(finding(SOURCE, 0, 0, code="W501")).startswith("warning[W501]: ")


def test_a_note_on_the_same_line_does_not_repeat_its_place():
    note = Note("begins here", Span(SOURCE, 27, 28))
    assert render(finding(SOURCE, 30, 31, notes=(note,))).endswith("= note: begins here")


def test_without_a_place_only_the_headline_and_remedies_show():
    diagnostic = Diagnostic("TIS601", "there is no file", None, "look elsewhere")
    assert render(diagnostic) == "error[TIS601]: there is no file\n  = hint: look elsewhere"
    assert as_dict(diagnostic)["line"] is None


@every(
    ("text", "start", "end", "excerpt", "carets"),
    [
        ("abc def", 4, 7, "abc def", "    ^^^"),
        ("abc", 3, 3, "abc", "   ^"),
        ("abc\ndef", 1, 6, "abc", " ^^"),
        ("abc\ndef", 3, 4, "abc", "   ^"),
        ("\ta\tb", 3, 4, "    a    b", "         ^"),
        ("a\tb", 1, 2, "a    b", " ^^^^"),
        ("漢字 x", 3, 4, "漢字 x", "     ^"),
        ("漢字 x", 0, 2, "漢字 x", "^^^^"),
        ("e\u0301q\u0323 x", 5, 6, "e\u0301q\u0323 x", "   ^"),
        ("a\x1b[31mb", 1, 2, "a\ufffd[31mb", " ^"),
        ("a\u00a0b", 1, 2, "a b", " ^"),
    ],
)
def test_carets_stand_under_what_they_mark(text, start, end, excerpt, carets):
    assert marked(text, start, end) == (excerpt, carets)


@pytest.mark.parametrize("place", [0, 30, 100, 5000, 9950, 9999])
def test_long_lines_are_shown_as_a_window_around_the_place(place):
    line = "".join(chr(ord("a") + i % 26) for i in range(10_000))
    excerpt, carets = marked(line, place, place + 1)
    assert len(excerpt) <= 162
    assert excerpt[carets.index("^")] == line[place]
    assert excerpt.startswith("…") == (place > 40)


def test_colour_changes_nothing_but_colour():
    diagnostic = finding(SOURCE, 30, 31, hint="do", notes=(Note("so"),))
    coloured = render(diagnostic, color=True)
    assert "\033[" in coloured
    assert re.sub(r"\033\[[0-9;]*m", "", coloured) == render(diagnostic)


def test_as_dict_is_plain_json_with_places_from_one():
    note = Note("there", Span(SOURCE, 0, 0))
    start = SOURCE.text.index("grasp")
    found = finding(SOURCE, start, start + 5, "TIS105", "do", (note,))
    assert json.loads(json.dumps(as_dict(found))) == {
        "code": "TIS105", "severity": "error", "message": "something is wrong",
        "file": "sterilisation.tis", "line": 26, "column": 25, "end_line": 26, "end_column": 30,
        "hint": "do",
        "edits": [],
        "notes": [{"message": "there", "file": "sterilisation.tis", "line": 1, "column": 1,
                   "end_line": 1, "end_column": 1}],
    }  # fmt: skip
