"""Rows of tables become arrays; bad ones are reported to the cell."""

from contextlib import nullcontext
from time import process_time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.every import every
from tissuec.core.errors import CompileError
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.lang.tables import NOT_GIVEN, ColumnSpec, cell_span, read_rows

NODES = (ColumnSpec("id", "whole"), ColumnSpec("x"), ColumnSpec("y"))
SPRINGS = (
    ColumnSpec("a", "whole"),
    ColumnSpec("rest", optional=True),
    ColumnSpec("law", "word", optional=True),
)


def table(rows):
    (only,) = parse(normalise(f"language 1\ntable t of net in mm {{{rows}}}", "t.tis")).items
    return only


def problems(rows, columns=NODES):
    with pytest.raises(CompileError) as caught:
        read_rows(table(rows), columns)
    return [(d.code, d.span.line, d.span.text) for d in caught.value.diagnostics]


def test_rows_end_at_line_ends_and_semicolons():
    number, x, y = read_rows(table("\n 1 2 3.5 # a\n\n4 5 -6e-1;7 8\t+9\n;\n"), NODES)
    assert number.dtype == np.int64
    assert number.tolist() == [1, 4, 7]
    assert x.tolist() == [2, 5, 8]
    assert y.tolist() == [3.5, -0.6, 9]


@pytest.mark.parametrize("rows", ["", "\n\n", " ; ;\n# nothing\n"])
def test_no_rows_give_empty_columns(rows):
    columns = read_rows(table(rows), SPRINGS)
    assert [column.shape for column in columns] == [(0,)] * 3
    assert [column.dtype.kind for column in columns] == ["i", "f", "O"]


def test_words_may_be_quoted_and_cells_may_be_left_open():
    whole = (*SPRINGS, ColumnSpec("part", "whole", optional=True))
    a, rest, law, part = read_rows(table('1 2.5 "dead  band" 7\n 2 - - -'), whole)
    assert a.tolist() == [1, 2]
    assert rest[0] == 2.5
    assert np.isnan(rest[1])
    assert law.tolist() == ["dead  band", ""]
    assert part.tolist() == [7, NOT_GIVEN]


@given(st.lists(st.tuples(st.integers(-(2**53), 2**53), st.floats(-1e300, 1e300))))
def test_numbers_come_back_to_the_last_digit(values):
    rows = "\n".join(f"{n} {x!r} 0" for n, x in values)
    number, x, _ = read_rows(table(rows), NODES)
    assert list(zip(number.tolist(), x.tolist(), strict=True)) == values


def test_plain_and_split_reading_agree():
    rows = "\n".join(f"{i} {i / 7!r} {-i / 3:e}" for i in range(500))
    plain = read_rows(table(rows), NODES)
    optional = (NODES[0], NODES[1], ColumnSpec("y", optional=True))
    split = read_rows(table(rows + "\n 500 0 -"), optional)
    assert all(np.array_equal(a, b[:-1]) for a, b in zip(plain, split, strict=True))


@every(
    ("rows", "expected"),
    [
        ("\n1 2 3\n 4 5 # 6\n", [("TIS120", 4, "4 5")]),
        ("\n1 2 3 4; 5 6 7\n", [("TIS120", 3, "1 2 3 4")]),
        # As many cells as two good rows.
        ("\n1 2\n3 4 5 6\n", [("TIS120", 3, "1 2"), ("TIS120", 4, "3 4 5 6")]),
        ("\n1 2 x\n", [("TIS121", 3, "x")]),
        ("\n1.5 2 3\n", [("TIS121", 3, "1.5")]),
        ("\n9007199254740994 2 3\n", [("TIS121", 3, "9007199254740994")]),
        ("\n1 2,5 3mm\n", [("TIS121", 3, "2,5"), ("TIS121", 3, "3mm")]),
        ("\n1 1_0 ٣\n", [("TIS121", 3, "1_0"), ("TIS121", 3, "٣")]),
        ("\n1 - 3\n", [("TIS121", 3, "-")]),
        ("\n1 nan 3\n4 -inf 5\n", [("TIS122", 3, "nan"), ("TIS122", 4, "-inf")]),
        ("\n1 1e999 3\n", [("TIS122", 3, "1e999")]),
        ('\n1 "2" 3\n', [("TIS121", 3, '"2"')]),
        ("\n1 2\u00a03 4\n", [("TIS121", 3, "2\u00a03")]),
        ("\n1 0x10 3\n", [("TIS121", 3, "0x10")]),
    ],
)  # fmt: skip
def test_bad_rows_and_cells_are_reported_at_their_place(rows, expected):
    assert problems(rows) == expected


def test_findings_come_in_order_and_ten_at_most():
    found = problems("\n" + "x 1 y\n1 2\n" * 20)
    assert len(found) == 10
    assert [line for _, line, _ in found] == [3, 3, 4, 5, 5, 6, 7, 7, 8, 9]


def test_hints_name_the_remedy():
    with pytest.raises(CompileError) as caught:
        read_rows(table("\n1 2,5 3mm\n1 2"), NODES)
    comma, unit, count = (d.hint for d in caught.value.diagnostics)
    assert "decimals with a point" in comma
    assert '"in mm"' in unit
    assert "id, x, y" in count


def test_cells_of_good_tables_can_be_found_again():
    read = table("\n1 2 3 # 9\n\n4 5 6; 7 8 9")
    assert cell_span(read, 2, 1).text == "8"
    assert cell_span(read, 1, 0).line == 5


def read_in(rows, bad=""):
    """Return how long it takes to read a table, the best of three [s]."""
    read = table("".join(f"{i} 0.{i} -{i}e-3\n" for i in range(rows)) + bad)
    taken = []
    for _ in range(3):
        start = process_time()
        with pytest.raises(CompileError) if bad else nullcontext():
            read_rows(read, NODES)
        taken.append(process_time() - start)
    return min(taken)


@pytest.mark.parametrize("bad", ["", "1 2 x"], ids=["good", "spoilt"])
def test_time_of_reading_grows_as_the_rows_do(bad):
    """Eight times as many take eight times as long; a quadratic search takes 64 times."""
    assert read_in(40_000, bad) < 20.0 * read_in(5_000, bad)
