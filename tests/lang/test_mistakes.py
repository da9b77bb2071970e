"""Each mistake is named by its code, marked at its place, and met with a remedy."""

import re
from pathlib import Path

import pytest

from tests.every import every
from tissuec.core.errors import CompileError
from tissuec.lang import syntax as s
from tissuec.lang.characters import normalise
from tissuec.lang.grammar import StatementParser
from tissuec.lang.parser import WrongNumbers, parse

EXAMPLES = Path(__file__).parent / "examples"


def findings(text):
    with pytest.raises(CompileError) as caught:
        parse(normalise(text, "bad.tis"))
    return caught.value.diagnostics


def only(text):
    (finding,) = findings(f"language 1\n{text}")
    return finding


@every(
    ("code", "text", "marked", "hint"),
    [
        ("TIS104", "radius = 3 mmm", "mmm", 'did you mean "mm"?'),
        ("TIS104", "radius = 3 MM", "MM", 'did you mean "mm"?'),
        ("TIS104", "a = 3 millimetres", "millimetres", 'did you mean "mm"?'),
        ("TIS104", "a = 3 sec", "sec", 'did you mean "s"?'),
        ("TIS104", "a = 3 seconds", "seconds", 'did you mean "s"?'),
        ("TIS104", "a = 3 kilogram", "kilogram", 'did you mean "kg"?'),
        ("TIS104", "a = 3 msec", "msec", 'did you mean "ms"?'),
        ("TIS104", "a = 3 gg", "gg", "units are"),
        ("TIS104", "radius = 3 parsec", "parsec", "units are"),
        ("TIS104", "at 3 mss: fix a", "mss", 'did you mean "ms"?'),
        ("TIS104", "a = (1, 2, 3) mmm", "mmm", 'did you mean "mm"?'),
        ("TIS104", "a = (b + c) mm", ") mm", "after each number"),
        ("TIS104", "a = [1, 2] mm", "mm", "after each number"),
        ("TIS104", "a = 3 kg m", "m", '"kg*m"'),
        ("TIS104", "a = 3 Nm", "Nm", '"N*m"'),
        ("TIS104", "a = 3 mNs/m + b", "mNs", '"mN*s/m"'),
        ("TIS104", "a = 3 degC", "degC", "temperatures are not part of the language"),
        ("TIS104", "a = 3 K", "K", "temperatures are not part of the language"),
        ("TIS114", "a = 3 °C", "°", "temperatures are not part of the language"),
        ("TIS114", "a = 3 ℃", "℃", "temperatures are not part of the language"),
        ("TIS114", "a = 3 °", "°", "type deg"),
        ("TIS104", "a = 1 km^999", "1 km^999", "exponents"),
        ("TIS104", "a = 1 mm^999", "1 mm^999", "exponents"),
        ("TIS105", "at 0.10 s   grasp waist with forceps A", "grasp",
         'write "at 0.10 s: grasp waist with forceps A"'),
        ("TIS105", "at cut time cut waist", "", 'write "at cut time cut waist: …"'),
        ("TIS105", "from 0 s to 1 s move a by (1, 2, 3) mm", "move", "to 1 s: move a by"),
        ("TIS105", "when force(a) > 2 N release a", "release", "2 N: release a"),
        ("TIS105", "at 0 s { fix a }", "{", ": {"),
        ("TIS105", "when force(a) > 2 N at 1 s: { free a }", "at", '"when force(a) > 2 N: …"'),
        ("TIS105", "when force(a) > 2 N at 1 s free a", "at", '"when force(a) > 2 N: …"'),
        ("TIS107", "rings = 16 sides = 10", "sides", 'before "sides"'),
        ("TIS107", "mesh is tube radius = 3 mm", "=", '";"'),
        ("TIS107", "body a { } body b { }", "body", 'before "body"'),
        ("TIS107", "columns = 7, rows = 4", ",", 'write ";"'),
        ("TIS107", "radius = 3 mm let a = 2", "let", 'before "let"'),
        ("TIS107", "if a is b then c is d if e is f then g is h", "if", 'before "if"'),
        ("TIS108", "radius = 3,5 mm", ",", 'write "radius = 3.5 mm"'),
        ("TIS108", "prestress = 0,04", ",", 'write "prestress = 0.04"'),
        ("TIS108", "force = 1,000 N", ",", 'or "1000 N"'),
        ("TIS109", "grasp waist with forceps 2", "2", '"forceps 2"'),
        ("TIS109", "tool forceps 2 { }", "2", 'tool "forceps 2"'),
        ("TIS109", "rings 16", "16", 'write "rings = 16"'),
        ("TIS109", "radius 3 mm", "3 mm", 'write "radius = 3 mm"'),
        ("TIS109", "param top 3 mm", "3 mm", 'write "top = 3 mm"'),
        ("TIS109", "trajectory evry 5 ms", "evry", 'did you mean "every"?'),
        ("TIS109", "force(A) evry 5 ms", "evry", 'did you mean "every"?'),
        ("TIS109", "form 1 s to 2 s: cut a", "form", 'did you mean "from"?'),
        ("TIS100", "line = from (0, 0, 0) m to (1, 0, 0) m", "=", 'leave out "="'),
        ("TIS111", "if hardness = soft then a is b", "=", '"hardness is soft"'),
        ("TIS111", "set a = nodes of b where x = 3 mm", "=", 'write "x == 3 mm"'),
        ("TIS111", "if spring constant = low then a is b", "=", '"spring constant is low"'),
        ("TIS111", "expect count(a) = 160", "=", '"=="'),
        ("TIS111", 'set a = nodes of b where group = "top"', "=", 'write group is "top"'),
        ("TIS111", "set a = nodes of b where x is 3 mm", "is", '"=="'),
        ("TIS111", "expect force(a) is 3 N", "is", '"=="'),
        ("TIS112", "if a is b c is d", "is", '"if … then …"'),
        ("TIS112", "if a is b", "", '"if … then …"'),
        ("TIS113", 'about "no end', '"no end', '"'),
        ("TIS114", "a = 3\u00a0mm", "\u00a0", "ordinary blank"),
        ("TIS114", "a = 3 − 2", "−", "type -"),
        ("TIS114", "a = 3 m/s²", "²", "type ^2"),
        ("TIS114", "a | b", "|", "type or"),
        ("TIS114", "a \\\n  with b", "\\", "joining word"),
        ("TIS114", "about 'x", "'", "double quotes"),
        ("TIS114", "a = 1'000 N", "'", 'write "1000"'),
        ("TIS114", "a = 1\u202f000 N", "\u202f", 'write "1000"'),
        ("TIS115", "let head of pancreas = 3", "of", '"head of pancreas"'),
        ("TIS115", "tool table { }", "table", 'tool "table"'),
        ("TIS115", "output { every = 10 ms }", "every", '"trajectory every 10 ms"'),
        ("TIS115", "let where = 2 mm", "where", '"where"'),
        ("TIS115", "x and y = 3", "and", '"x and y"'),
        ("TIS115", "tissue is like", "like", '"like"'),
        ("TIS115", "set what is it = 3", "is", '"what is it"'),
        ("TIS119", "a = 1e999", "1e999", "1.8e308"),
        ("TIS119", "a = -1e400 mm", "1e400 mm", "1.8e308"),
        ("TIS312", "use tissues/skin  # soft", "/", 'use "tissues/skin"'),
        ("TIS312", "use ./skin", ".", 'use "./skin"'),
        ("TIS312", "set a is nodes of b", "is", 'write "set a = nodes of b"'),
        ("TIS312", "friction is 0.4", "is", 'write "friction = 0.4"'),
        ("TIS312", "mass is -20 mg", "is", 'write "mass = -20 mg"'),
        ("TIS312", "first edge is (9, 0, 0) mm", "is", 'write "first edge = (9, 0, 0) mm"'),
        ("TIS312", "evenly is [low, high]", "is", 'write "evenly = [low, high]"'),
        ("TIS312", "if hardness is 0.4 then a is b", "0.4", "a word of its scale"),
        ("TIS312", "mesh = sphere { }", "=", 'write "mesh is sphere {"'),
        ("TIS312", "rupture = not allowed", "=", 'write "rupture is not allowed"'),
        ("TIS312", "columns: 7", ":", 'write "columns = 7"'),
        ("TIS312", "kind: forceps", ":", 'write "kind is forceps"'),
        ("TIS312", "if force(a) > 2 N: release a", "if", 'write "when force(a) > 2 N: …"'),
        ("TIS312", "a = (60; 0; 0) mm", ";", 'write "(60, 0, 0)"'),
        ("TIS312", "a = (1,5; 0; 0) mm", ";", 'write "(1.5, 0, 0)"'),
        ("TIS312", "a = 3  // mm", "//", 'write "#"'),
        ("TIS312", "/* two\nlines */ a = 3", "/*", 'write "#"'),
        ("TIS102", "set a = nodes of b where (x < 1 mm; c = (2, 3) mm", "(", 'add ")"'),
        ("TIS100", "a = 1 000 N", "000 N", '"1000 N"'),
        ("TIS100", "a = 0, 0, -1 mm", ",", '"(0, 0, -1) mm"'),
        ("TIS100", "a = 0, 1 mm", ",", "in brackets"),
        ("TIS100", "a = 2^3^4", "^", "a^(b^c)"),
        ("TIS100", "expect 1 < x < 2", "<", 'write "x between 1 and 2"'),
        ("TIS100", "expect 2 > x > 1", ">", 'write "x between 1 and 2"'),
        ("TIS100", "expect 1 < x == 2", "==", '"and"'),
        ("TIS100", "mesh is 3 { }", "3", "a name"),
        ("TIS101", "script\n  at 0 s: fix a\n}", "script", "write script {"),
        ("TIS101", "body a {\n  mesh is tube\n    rings = 3\n  }\n}", "mesh is tube", "tube {"),
        ("TIS101", "script {\n  at 0 s:\n    fix a\n  }\n}", "at 0 s:", "write at 0 s: {"),
        ("TIS102", "a = 3\n}", "}", "remove it"),
        ("TIS307", "a = 3\nlanguage 1", "language", "remove it"),
        ("TIS100", "a = .5", ".", '"0.5"'),
        ("TIS100", "a = 5.", ".", '"5.0"'),
        ("TIS100", "expect a ! b", "!", '"!="'),
        ("TIS100", "a = % 5", "%", '"5 %"'),
        ("TIS100", "a = b · c", "·", '"*"'),
        ("TIS100", "body x\n{ }", "{", '"{" on the line'),
        ("TIS100", "if x, then y is z", ",", 'remove the ","'),
        ("TIS100", "at 0 s:\n", "\n", "on the line of its time"),
        ("TIS100", "a =", "", "a name, a number"),
        ("TIS100", "a b\nc = 2 with\nd", "\n", "a name"),
        ("TIS100", "at 0 s: = 3", "=", "a name"),
    ],
)  # fmt: skip
def test_mistakes_have_code_place_and_remedy(code, text, marked, hint):
    finding = only(text)
    assert finding.code == code, finding
    assert finding.span.text == marked
    assert hint in finding.hint


@every(
    ("text", "code", "hint"),
    [
        ("", "TIS117", 'write "language 1"'),
        ("# remark\n\nbody a { }", "TIS117", 'write "language 1"'),
        ("language\nbody a { }", "TIS117", 'write "language 1"'),
        ("language one", "TIS117", 'write "language 1"'),
        ("language 1mm", "TIS117", 'write "language 1"'),
        ("a = 3\nlanguage 1\nb = 3", "TIS117", "as the first line instead"),
        ("a = 3\nlanguage 2", "TIS117", 'write "language 1" as the first line instead'),
        ("language 2\nfoo [bar] baz = 3", "TIS118", 'this release reads "language 1"'),
        ("language 1.5", "TIS118", 'this release reads "language 1"'),
    ],
)
def test_the_first_line_names_the_version(text, code, hint):
    (finding,) = findings(text)
    assert finding.code == code
    assert hint in finding.hint


def test_a_version_that_stands_below_is_moved_up():
    (finding,) = findings("a = 3\nlanguage 1\nb = 3\n")
    assert [note.span.line for note in finding.notes] == [2]
    (edit,) = finding.edits
    assert (edit.span.text, edit.text) == ("a = 3\nlanguage 1\n", "language 1\na = 3\n")


def test_each_block_without_its_brace_is_named():
    text = "body a\n  b = 3\n}\nscript\n  at 0 s: {\n    fix a\n  }\n}\n}\n"
    assert codes_and_lines(text) == [("TIS101", 2), ("TIS101", 5), ("TIS102", 10)]


def test_a_missing_first_line_does_not_hide_other_mistakes():
    assert [f.code for f in findings("about x\na = 3,5")] == ["TIS117", "TIS108"]


# --- several mistakes -------------------------------------------------------------------------


def codes_and_lines(text):
    return [(f.code, f.span.line) for f in findings(f"language 1\n{text}")]


def test_one_run_reports_several_mistakes_in_order_and_no_cascades():
    text = """body a {
  mesh is tube { radius = 3,5 mm; rings = 16 sides = 10 }
  tissue = is soft
}
script {
  at 0 s fix a
  at 1 s: free a
  If b is c then d is e
}
let x = 1e999
expect count(a) = 3
"""
    assert codes_and_lines(text) == [
        ("TIS108", 3), ("TIS107", 3), ("TIS100", 4), ("TIS105", 7), ("TIS119", 11),
        ("TIS111", 12),
    ]  # fmt: skip


def test_the_inside_of_a_block_with_a_bad_head_is_looked_at():
    assert codes_and_lines("body is = {\n a = 3,5\n b { c = 1 }\n}\nd = 4,5\n") == [
        ("TIS312", 2), ("TIS108", 3), ("TIS108", 6),
    ]  # fmt: skip


def test_the_rows_of_a_table_with_a_bad_head_are_not_taken_for_sentences():
    assert codes_and_lines("table 3 of x {\n 1 2 3\n 4 5 6\n}\nd = 4,5\n") == [
        ("TIS100", 2), ("TIS108", 6),
    ]  # fmt: skip


def test_an_unclosed_bracket_spoils_its_own_line_only():
    assert codes_and_lines("a = (1, 2\nb = 3,5\nc { d = [1 }\ne = 1\n") == [
        ("TIS102", 2), ("TIS108", 3), ("TIS102", 4),
    ]  # fmt: skip


def test_a_missing_brace_is_reported_once_with_both_places():
    text = "language 1\nbody a {\n  mesh is tube {\n    radius = 3 mm\n}\nscript { }\n"
    (finding,) = findings(text)
    assert finding.code == "TIS101"
    assert finding.span.start == text.index("\n}")
    assert [note.span.line for note in finding.notes] == [3]


def test_mistakes_beside_odd_characters_and_quotes_are_not_reported_twice():
    assert codes_and_lines('a = “b of c”\nd "e of = 3\n') == [
        ("TIS114", 2), ("TIS113", 3),
    ]  # fmt: skip


def test_ten_mistakes_are_reported_at_most():
    assert codes_and_lines("a = 3,5\n" * 30) == [("TIS108", n) for n in range(2, 12)]
    assert len(findings("language 1\n" + "“\n" * 30)) == 10


def test_reporting_mistakes_in_a_long_text_parses_each_statement_once(monkeypatch):
    read, parse = [], StatementParser.parse

    def noted(self, statement, rule="statement"):
        read.append(statement[0].start)
        return parse(self, statement, rule)

    monkeypatch.setattr(StatementParser, "parse", noted)
    assert len(findings("language 1\n" + ("a = 1 mm\n" * 50 + "b = 3,5\n") * 5)) == 5
    assert read == sorted(set(read))
    assert len(read) == 1 + 5 * 51


# --- what is read in spite of mistakes --------------------------------------------------------


def read_in_spite(text: str) -> s.Module:
    with pytest.raises(WrongNumbers) as caught:
        parse(normalise(f"language 1\n{text}", "bad.tis"))
    return caught.value.module


@every(
    "number",
    ["3 mmm", "3 parsec/s^2", "3 kg m", "3 N*m s", "1 km^999", "1e999", "1e999 mm",
     "(1, 2, 3) mmm", "(1, 2, 3) mm^999"],
)  # fmt: skip
def test_a_text_with_a_wrong_number_is_read_but_for_that(number):
    items = read_in_spite(f"a = 1 mm\nat 2 s: {{ b = {number}; fix c }}\nd = 4").items
    first, timed, last = items
    wrong, order = timed.body
    assert wrong.value.unit == ""
    assert (first.value.unit, order.name.text, last.value.value) == ("mm", "fix c", 4.0)


def test_every_wrong_number_is_told_and_left_out():
    text = "a = 1 mmm; b = 2 mm\nc from 3 ss to 4 s\nd = (1 mm, 2 mn, 3 mm)"
    assert [d.code for d in findings(f"language 1\n{text}")] == ["TIS104"] * 3
    first, _, third, fourth = read_in_spite(text).items
    assert first.value.unit == third.clauses[0].value.unit == fourth.value.items[1].unit == ""


@pytest.mark.parametrize(
    "text",
    ["a = 3 mmm; b = 3,5 mm", "a = 3 mmm; b =", "a = [1, 2] mmm",
     "a from 3 mmm to 4 nnn"],
)  # fmt: skip
def test_beside_other_mistakes_of_syntax_nothing_is_read(text):
    with pytest.raises(CompileError) as caught:
        parse(normalise(f"language 1\n{text}", "bad.tis"))
    assert not isinstance(caught.value, WrongNumbers)


# --- words of messages ------------------------------------------------------------------------


@every(
    "text",
    ["a = ", "a b is", "at", "expect", "if", "a { b = }", "a = [1, ]]", "a = f(,)", "= 3",
     "a = 1 <", "from 1 s: 3", "a is not", "a is between b", "a = x is y", "]", "a ^", "let",
     "let a", ", a"],
)  # fmt: skip
def test_no_message_holds_names_of_the_grammar(text):
    internal = re.compile(r"\b[A-Z_]{3,}\b|\$END|_NL|Token|__")
    for finding in findings(f"language 1\n{text}"):
        assert not internal.search(f"{finding.message} {finding.hint}")
        assert finding.hint


def test_examples_with_one_character_missing_never_give_more_than_three_findings():
    # One slip of the finger is one mistake; a missing brace or quote may show twice.
    text = (EXAMPLES / "indentation.tis").read_text(encoding="utf-8")
    for place in range(0, len(text), 7):
        found = ()
        try:
            parse(normalise(text[:place] + text[place + 1 :], "x"))
        except CompileError as error:
            found = error.diagnostics
        assert len(found) <= 3, (place, text[place], found)


@pytest.mark.parametrize(
    "text",
    ["If a is b Then c is d", "At 0 s: fix a", "Param a = 1", "Expect force(a) < 2 N",
     "Set a = nodes of b Where x < 1 mm And y > 2 mm", "a Is NOT b"],
)  # fmt: skip
def test_reserved_words_may_begin_with_a_capital_letter(text):
    def read(text):
        return parse(normalise(f"language 1\n{text}", "a.tis")).items

    small = (
        "".join(f"{word.lower()} " for word in text.split(" ")).replace(" mm", " mm").strip()
    )
    assert read(text) == read(small.replace("2 n", "2 N"))


BODY = "body a {\n  mesh is tube {\n    radius = 3 mm\n  }\n  tissue is b\n}\n"
SCRIPT = "script {\n  at 0 s: fix a\n  at 1 s: {\n    free a\n  }\n}\n"


@pytest.mark.parametrize("brace", range((BODY + SCRIPT).count("}")))
def test_each_brace_that_is_left_out_is_put_back_where_its_block_ends(brace):
    text = f"language 1\n{BODY}{SCRIPT}"
    at = [place for place, sign in enumerate(text) if sign == "}"][brace]
    line = text.rfind("\n", 0, at)
    wrong = text[:line] + text[at + 1 :]
    (finding,) = findings(wrong)
    assert finding.code == "TIS101"
    (edit,) = finding.edits
    assert wrong[: edit.span.start] + edit.text + wrong[edit.span.end :] == text


@pytest.mark.parametrize("line", range(1, 12))
@pytest.mark.parametrize("indent", [0, 2, 4])
def test_a_brace_too_many_is_marked_where_it_stands_or_its_like(line, indent):
    lines = f"language 1\n{BODY}{SCRIPT}".split("\n")
    lines.insert(line, " " * indent + "}")
    wrong = "\n".join(lines)
    found = findings(wrong)
    assert [one.code for one in found] == ["TIS102"]
    (edit,) = found[0].edits
    mended = wrong[: edit.span.start] + edit.text + wrong[edit.span.end :]
    assert parse(normalise(mended, "a.tis")).items
