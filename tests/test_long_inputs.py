"""What is long takes as long as it is long, and not the square of that."""

from contextlib import suppress
from pathlib import Path

import pytest

from tests.growth import grows_in_proportion
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.core.text_tables.dialect import unit_of
from tissuec.core.text_tables.table import find_dialect
from tissuec.core.units import UnitError
from tissuec.meshes.formats import FormatError, read
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

LONG = 20_000
REFUSALS = (CompileError, FormatError, UnitError)
BODY = """
tissue gel { spring constant = 1 N/m; viscosity = 1 mN*s/m; mass = 1 g }
body b {
  mesh is thread { line from (0, 0, 0) mm to (9, 0, 0) mm; pieces = 4; thickness = 1 mm }
  tissue is gel
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""
STL = b"solid a\nfacet normal 0 0 1\n%s\nendfacet\nendsolid a\n"


def text(content):
    source = Source("long.tis", f"language 1\n{content}\n")
    return refused(lambda: check_request(Request(source)))


def stl(content):
    return refused(lambda: read(STL % content, Path("long.stl")))


def vtu(content):
    head = b'<VTKFile type="UnstructuredGrid"><UnstructuredGrid>'
    return refused(lambda: read(head + content, Path("long.vtu")))


def refused(work):
    """Return the work, which may find what it reads wrong."""

    def done():
        with suppress(*REFUSALS):
            work()

    return done


CASES = {
    "words of a statement": lambda n: text("word " * n),
    "words of a name": lambda n: text(f"let {'a ' * n} = 1"),
    "words of an unknown name": lambda n: text(
        f"{BODY}output {{ force({' '.join(f'w{k}' for k in range(n // 3))}) every 1 ms }}"
    ),
    "semicolons in a bracket": lambda n: text(f"let a = ({';' * n}"),
    "brackets side by side": lambda n: text("let a = " + "(1;2)" * (n // 10)),
    "missing names": lambda n: text(
        "".join(f'table springs of a{i} with columns "a b" {{ 0 1 }}\n' for i in range(n // 25))
    ),
    "terms": lambda n: text(f"let a = {'1 + ' * n}1"),
    "signs": lambda n: text(f"let a = {'-' * n}1"),
    "quotes": lambda n: text(f"let a = {chr(34) * n}"),
    "blank lines of an STL": lambda n: stl(b"\n" * n),
    "blanks of an STL": lambda n: stl(b" " * n),
    "blanks in a vertex of an STL": lambda n: stl(b"vertex" + b" " * n + b"x"),
    "solids of an STL": lambda n: stl(b"solid " * n),
    "pieces of a VTU": lambda n: vtu(b"<Piece " * n),
    "attributes of a VTU": lambda n: vtu(b"<Piece " + b"NumberOfCells " * n),
    "brackets of a header": lambda n: refused(lambda: find_dialect("a (" * n + "\n1 2\n")),
    "quotes of a header": lambda n: refused(lambda: find_dialect('a "' * n + "\n1 2\n")),
    "brackets of a name": lambda n: refused(lambda: unit_of("(" * n)),
    "blanks of a name": lambda n: refused(lambda: unit_of("(" + " " * n + "x")),
}


@pytest.mark.parametrize("length", [LONG // 2, pytest.param(LONG, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", CASES)
def test_effort_for_what_is_long_grows_as_its_length(name, length):
    assert grows_in_proportion(CASES[name], length)


def test_a_long_name_is_shortened_in_messages():
    words = " ".join(f"w{k}" for k in range(400))
    source = Source("a.tis", f"language 1\n{BODY}output {{ force({words}) every 1 ms }}")
    with pytest.raises(CompileError) as found:
        check_request(Request(source))
    (one,) = found.value.diagnostics
    assert one.message == f'there is no set, body or tool called "{words[:60]}…"'
    assert len(str(one)) < 600
