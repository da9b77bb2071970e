"""What is long takes as long as it is long, and not the square of that.

All of this takes a fraction of a second; with effort that grows as the square, minutes.
"""

import time
from contextlib import suppress
from pathlib import Path

import pytest

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.core.units import UnitError
from tissuec.formats import FormatError, read
from tissuec.formats.vtu import cells_announced
from tissuec.learn.data.dialect import find_dialect
from tissuec.learn.data.naming import unit_of
from tissuec.pipeline import Request, check_request

LONG = 50_000
MOST = 10.0  # seconds of the processor
REFUSALS = (CompileError, FormatError, UnitError)
STL = b"solid a\nfacet normal 0 0 1\n%s\nendfacet\nendsolid a\n"


def text(content):
    return lambda: check_request(Request(Source("long.tis", f"language 1\n{content}\n")))


def stl(content):
    return lambda: read(STL % content, Path("long.stl"))


CASES = {
    "words of a statement": text("word " * LONG),
    "words of a name": text(f"let {'a ' * LONG} = 1"),
    "semicolons in a bracket": text(f"let a = ({';' * LONG}"),
    "brackets side by side": text("let a = " + "(1;2)" * (LONG // 10)),
    "missing names": text(
        "".join(f'table springs of a{i} with columns "a b" {{ 0 1 }}\n' for i in range(2000))
    ),
    "terms": text(f"let a = {'1 + ' * LONG}1"),
    "signs": text(f"let a = {'-' * LONG}1"),
    "quotes": text(f"let a = {chr(34) * LONG}"),
    "blank lines of an STL": stl(b"\n" * LONG),
    "blanks of an STL": stl(b" " * LONG),
    "blanks in a vertex of an STL": stl(b"vertex" + b" " * LONG + b"x"),
    "solids of an STL": stl(b"solid " * LONG),
    "pieces of a VTU": lambda: cells_announced(b"<Piece " * LONG),
    "attributes of a VTU": lambda: cells_announced(b"<Piece " + b"NumberOfCells " * LONG),
    "brackets of a header": lambda: find_dialect("a (" * LONG + "\n1 2\n"),
    "quotes of a header": lambda: find_dialect('a "' * LONG + "\n1 2\n"),
    "brackets of a name": lambda: unit_of("(" * LONG),
    "blanks of a name": lambda: unit_of("(" + " " * LONG + "x"),
}


@pytest.mark.parametrize("name", CASES)
def test_what_is_long_is_read_or_refused_at_once(name):
    began = time.process_time()
    with suppress(*REFUSALS):
        CASES[name]()
    assert time.process_time() - began < MOST
