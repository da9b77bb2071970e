"""A result has one name until it is complete and another after, and each gives the other."""

from pathlib import Path

import pytest

from tissuec.results.places import final_path, partial_path


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
