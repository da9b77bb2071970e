"""The list of long tests names tests that there are."""

import subprocess
import sys

import pytest

from tests.conftest import long_ones


def test_every_long_test_has_a_function(repository):
    for name in long_ones():
        path, *_, function = name.partition("[")[0].split("::")
        text = (repository / path).read_text(encoding="utf-8")
        assert f"def {function}(" in text, name


@pytest.mark.slow
def test_every_long_test_exists(repository):
    files = sorted({name.partition("::")[0] for name in long_ones()})
    command = [sys.executable, "-m", "pytest", "--collect-only", "-n", "0", "-m", "slow"]
    found = subprocess.run([*command, *files], cwd=repository, capture_output=True, text=True)
    assert long_ones() <= set(found.stdout.splitlines())
