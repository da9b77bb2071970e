"""Tests of many cases fail with every case that fails, and with no other."""

import pytest

from tests.every import every


def test_all_cases_that_fail_are_told():
    seen = []

    @every(("a", "b"), [(1, 1), (1, 2), (2, 2), (3, 4), (5, 5)])
    def of_each(a, b, tmp_path):
        seen.append((a, tmp_path))
        if a == 5:
            pytest.skip("five")
        assert a == b

    with pytest.raises(BaseExceptionGroup) as caught:
        of_each(part=0, tmp_path="here")
    assert [error.__notes__ for error in caught.value.exceptions] == [
        ["case: 1-2"],
        ["case: 3-4"],
    ]
    assert seen == [(a, "here") for a in (1, 1, 2, 3, 5)]


def test_parts_share_the_cases():
    seen = []

    @every("a", range(7), parts=3)
    def of_each(a):
        seen.append(a)

    for part in range(3):
        of_each(part=part)
    assert sorted(seen) == list(range(7))
