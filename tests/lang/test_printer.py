"""Canonical layout, piece by piece."""

import pytest

from tests.every import every
from tissuec.core.errors import CompileError
from tissuec.lang.characters import normalise
from tissuec.lang.printer import format_source


def formatted(text):
    printed = format_source(normalise(f"language 1\n{text}", "x"))
    return printed.removeprefix("language 1\n").removesuffix("\n")


@every(
    ("text", "expected"),
    [
        ("a   b=3mm", "a b = 3 mm"),
        ("a = 3\tN·s/m+2µm-1 μs", "a = 3 N*s/m + 2 um - 1 us"),
        ("a=(1,2 ,3)mm", "a = (1, 2, 3) mm"),
        ("a=[x,y ,]", "a = [x, y,]"),
        ("a = - x^ - 2*( - y ) - - z", "a = -x^-2 * (-y) - -z"),
        ("a = 3 m ^2", "a = 3 m ^ 2"),
        ("a = 3 ^2", "a = 3^2"),
        ("a = f ( x , y to z )", "a = f(x, y to z)"),
        ('a = "f" (x)', 'a = "f"(x)'),
        ("expect not(a<=b)", "expect not (a <= b)"),
        ("at(1,2,3) :fix   a", "at (1, 2, 3): fix a"),
        ("a{b}", "a { b }"),
        ("a{}", "a { }"),
        ("a ; ; b;\n;c;", "a; b\nc"),
        ("a { ; b ; }", "a { b }"),
        ('a   "b   c"', 'a "b   c"'),
        ("Half WAY = 007.50e+3", "Half WAY = 007.50e+3"),
    ],
)
def test_blanks_between_neighbours(text, expected):
    assert formatted(text) == expected


def test_indentation_follows_braces_and_continued_lines():
    text = """body a {
mesh is tube
on b {
      x = [
1,
2
]
}
       }
if a is b
then c is d
"""
    expected = """body a {
  mesh is tube
    on b {
    x = [
      1,
      2
    ]
  }
}
if a is b
  then c is d"""
    assert formatted(text) == expected


def test_comments_stay_where_they_are():
    text = """# first
a = 1# behind
   # own line
if a is b     # why

      # how
   then c is d
b {
# inside
   # last
}
# end   """
    expected = """# first
a = 1  # behind
# own line
if a is b  # why

  # how
  then c is d
b {
  # inside
  # last
}
# end"""
    # A comment before a closing brace belongs to the block.
    assert formatted(text) == expected


def test_a_sign_behind_a_comment_joins_two_operands():
    assert formatted("a = [b # why\n- -c]") == "a = [b  # why\n  - -c]"


def test_empty_lines_come_one_at_a_time():
    assert formatted("\n\n\na\n\n\n\nb\n\n\n") == "\na\n\nb"


def test_rows_keep_their_numbers_and_lose_needless_blanks():
    text = """t {
table  nodes of b in mm{
1   0\t0.50 # first
      2 1e-3 "a  b" ;3 - - ;

   # own
}
}"""
    expected = """t {
  table nodes of b in mm {
    1 0 0.50  # first
    2 1e-3 "a  b"; 3 - -

    # own
  }
}"""
    assert formatted(text) == expected


def test_rows_on_the_line_of_their_brace_stay_there():
    assert formatted("table t {1 2;3 4}") == "table t { 1 2; 3 4 }"


def test_a_text_with_mistakes_is_refused():
    with pytest.raises(CompileError):
        formatted("a = 3,5")
