"""No learning of data with a known truth ends as done and is wrong."""

import pytest

from tests.learn.known_truths import NAMES, SHARES, tried


@pytest.mark.parametrize(("name", "share"), [("kicked 1", 0.03), ("thrown 1", 0.1)])
def test_the_truth_is_found_behind_outliers_and_from_afar(name, share, tmp_path):
    result = tried(name, share, tmp_path)
    assert result.ended == "right", str(result)


@pytest.mark.slow
@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("name", NAMES)
def test_no_learning_is_done_and_wrong(name, share, tmp_path):
    result = tried(name, share, tmp_path)
    assert result.ended != "wrong", str(result)
