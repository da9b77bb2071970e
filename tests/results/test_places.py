"""A result has one name until it is complete and another after, and each gives the other."""

from pathlib import Path

import pytest

import tissuec
from tests.every import every
from tissuec.results import PlaceError
from tissuec.results.places import final_path, partial_path

SCENE = """\
language 1
use "tissues/muscle"
body b {
  mesh is thread { line from (0, 0, 0) mm to (9, 0, 0) mm; pieces = 4; thickness = 1 mm }
  tissue is muscle
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""


@pytest.mark.parametrize(
    ("final", "partial"),
    [
        ("a.vtkhdf", "a.partial.vtkhdf"),
        ("runs/a.b.vtkhdf", "runs/a.b.partial.vtkhdf"),
        ("result", "result.partial"),
        (".partial", ".partial.partial"),
        ("/dev/null", "/dev/null.partial"),
    ],
)
def test_the_names_of_a_result_give_one_another(final, partial):
    final, partial = Path(final), Path(partial)
    assert partial_path(final) == partial_path(partial) == partial
    assert final_path(partial) == final_path(final) == final


@every("name", ("x" * 258 + ".vtkhdf", "x" * 245 + ".vtkhdf", "a\0b.vtkhdf"))
def test_names_that_the_system_refuses_are_refused_at_once(name, tmp_path):
    """The second one is short enough, but not with the mark of a partial result."""
    for call in (tissuec.run, tissuec.start):
        with pytest.raises(PlaceError, match=r'cannot write ".*": (file name too long|.*null)'):
            call(SCENE, out=str(tmp_path / name))
