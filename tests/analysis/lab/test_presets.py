"""Every shipped preset of matter passes the laboratory: no contradiction with what is known."""

import pytest

import tissuec
from tissuec.core.resources import library

FILES = sorted((library() / "matter").glob("*.tis"))


@pytest.mark.slow  # 10 s each; that a contradiction is told is tested by default
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_preset_of_matter_passes_the_laboratory(path):
    for examined in tissuec.examine(path):
        assert examined.is_good, [row for row in examined.rows if not row.is_good]
