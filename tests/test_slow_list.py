"""The list of long tests names tests that there are."""

import subprocess
import sys

from tests.conftest import long_ones


def test_every_long_test_exists(repository):
    files = sorted({name.partition("::")[0] for name in long_ones()})
    command = [sys.executable, "-m", "pytest", "--collect-only", "-n", "0", "-m", "slow"]
    found = subprocess.run([*command, *files], cwd=repository, capture_output=True, text=True)
    assert long_ones() <= set(found.stdout.splitlines())
