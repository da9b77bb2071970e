"""The tree: statements, brackets and characters, and time that grows with length."""

import pytest

from tests.every import every
from tests.findings import finding_of
from tests.growth import calls_grow_in_proportion, grows_in_proportion
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.lang.tree_builder import DEEPEST, tree_of
from tissuec.lang.words import CONTINUING


def tree(text):
    return tree_of(Source("x.tis", text))


def seen(text):
    """Return what the grammar sees of each statement, with single blanks."""
    sentences = ([part.text for part in one.sentence] for one in tree(text).statements)
    return "\n".join(" ".join(parts) for parts in sentences if parts)


# --- normalisation ----------------------------------------------------------------------------


@pytest.mark.parametrize("raw", [b"\xef\xbb\xbfa\r\nb\rc", "\ufeffa\r\nb\rc", "a\nb\nc"])
def test_marks_and_line_ends_are_normalised(raw):
    assert normalise(raw, "x").text == "a\nb\nc"


def test_composed_and_decomposed_letters_become_equal():
    assert normalise("gro\u0308ße", "x").text == normalise("größe", "x").text == "größe"


@pytest.mark.parametrize(
    ("raw", "place"),
    [(b"ab\r\n\xff", 3), ("é\n".encode() + b"\xe9 = 1", 2), (b"a\0b", 1), ("a\ud800", 1)],
)
def test_what_is_no_text_is_reported_at_its_place(raw, place):
    finding = finding_of(normalise, raw, "x")
    assert (finding.code, finding.span.start) == ("TIS114", place)


# --- what the grammar sees --------------------------------------------------------------------


def test_tokens_stand_where_they_say():
    text = 'a = (1,\n2 mm) # c {\nb = "#x" # d\n  with c\ntable t {\n1 2 # e\n}\n²“x'
    found = tree(text).lexemes
    assert all(text[one.start : one.stop] == one.text for one in found)
    rest = list(text)
    for one in found:
        rest[one.start : one.stop] = " " * len(one.text)
    assert not "".join(rest).strip()


def test_comments_are_collected_and_quotes_are_no_comments():
    comments = list(tree('a "# no" # yes  \n# also "this\ntable t {\n 1 # row\n}').comments)
    assert [c.text.rstrip() for c in comments] == ["# yes", '# also "this', "# row"]
    assert '"# no"' in seen('a "# no" # yes')


@pytest.mark.parametrize("word", CONTINUING)
@pytest.mark.parametrize("between", ["\n", "\n\n\n  ", " # why\n  # not\n\n", "\n\t"])
def test_a_line_that_begins_with_a_joining_word_continues_the_line_above(word, between):
    assert seen(f"a{between}{word} b") == f"a {word} b"


@every("word", ["from", "at", "andes", "of_x", "basis", "if", "not", "until"])
def test_other_lines_do_not_continue(word):
    assert seen(f"a\n{word} b") == f"a\n{word} b"


def test_line_ends_in_round_and_square_brackets_are_blanks():
    assert seen("a = f(1,\n\n# c\n2) + [\n3\n]\nb") == "a = f ( 1 , 2 ) + [ 3 ]\nb"


@every(
    "head",
    ["table t of net in mm", "law is table", "x\ntable t", "a; table t", "b { }\n table t",
     'table "a b" on table "c"', "table t at (1, 2, f(3))", "table t # c\n with d"],
)  # fmt: skip
def test_rows_of_a_table_are_hidden_from_the_grammar(head):
    found = tree(head + ' {\n1 2; if "}" # }\n} rest')
    *_, table, rest = found.statements
    assert [one.text for one in rest.sentence] == ["rest"]
    assert table.rows is not None
    assert not table.items


@pytest.mark.parametrize(
    "head", ["this table", "tableau", "using table", "x = table", "(table"]
)
def test_the_word_table_elsewhere_hides_nothing(head):
    assert not any(one.rows for one in tree(f"{head} {{ a = 1 }}").statements)


# --- brackets and characters ------------------------------------------------------------------


def codes(text):
    return [problem.code for problem in tree(text).problems]


@every(
    ("text", "expected"),
    [
        ("a {\nb {\n}\n", ["TIS101"]),
        ("a }\n", ["TIS102"]),
        ("a = (1, 2\nb", ["TIS102"]),
        ("a = [1, 2)\nb", ["TIS102"]),
        ("a { b = (1 }\nc = 2)", ["TIS102", "TIS102"]),
        ('a "b\nc "d"', ["TIS113"]),
        ("a “b”", ["TIS114"]),
        ("a “b", ["TIS114"]),
        ("a\u00a0b \x0b", ["TIS114", "TIS114"]),
        ("table t {\n1 2", ["TIS101"]),
        ("table t {\n1 2\nb {\n}", ["TIS101"]),
        ('"“\u00a0\x0b" # “\u00a0', []),
        ("größe µ Ω m·s 名", []),
    ],
)
def test_bracket_and_character_problems_have_codes(text, expected):
    assert codes(text) == expected


def test_the_block_that_lacks_its_brace_is_told_by_indentation():
    problem = tree("a {\n  b {\n    c\n}\nd { }\n").problems[0]
    assert problem.notes[0].span.line == 2
    assert problem.span.line == 3
    assert [edit.text for edit in problem.edits] == ["\n  }"]


def test_brackets_as_deep_as_allowed_parse_and_one_deeper_is_reported():
    def nested(depth):
        return normalise(f"language 1\nlet a = {'(' * depth}1{')' * depth}", "x")

    assert parse(nested(DEEPEST)).items
    with pytest.raises(CompileError) as caught:
        parse(nested(DEEPEST + 1))
    assert [d.code for d in caught.value.diagnostics] == ["TIS116"]


# --- time -------------------------------------------------------------------------------------

MILLION, MANY = 1_000_000, 100_000


@pytest.mark.parametrize("share", [24, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("before", "repeated", "behind", "count"),
    [*(("", part, "", MILLION) for part in ("(", "}", ")", "[", "{", " ", '"', "“", "#", "1")),
     ("", "5±1 ", "", MANY), ("", "5±1\n", "", MANY),
     ("", "\n" * 10, "", MILLION), ("", "\n(", "", MILLION), ("", "table x { ", "", MANY),
     ("", "is table ", "", MANY), ("x = 1 ", " ", "y", MILLION), ("a = ", "-", "1", MANY),
     ("expect ", "not ", "a", MANY), ("a = 1 ", "m*", "m", MANY), ("a = 1 m^", "9", "", MANY),
     ("a = 1e", "9", "", MILLION)],
)  # fmt: skip
def test_effort_for_hostile_texts_grows_as_their_length(before, repeated, behind, count, share):
    def reading(count):
        source = normalise(f"language 1\n{before}{repeated * count}{behind}", "x")

        def read():
            try:
                parse(source)
            except CompileError as error:
                told = error.diagnostics
                assert all(len(d.message) < 300 and len(d.hint) < 400 for d in told)

        return read

    assert calls_grow_in_proportion(reading, 4000)
    assert grows_in_proportion(reading, count // share)
