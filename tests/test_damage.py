"""Whatever is wrong with a result, every command that reads it says so in a sentence."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits memory as Linux does")


def read_damaged(*options):
    command = [sys.executable, "-m", "tests.damage", *map(str, options)]
    run = subprocess.run(command, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr


def test_a_damaged_result_is_a_result_error():
    read_damaged("--count", 3, "--seed", 4, "--quick")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_thousand_damaged_results_are_result_errors_for_every_command(seed):
    read_damaged("--count", 250, "--seed", seed)
