"""All examples of tests by Hypothesis, of which the default run tries a part."""

import os
import subprocess
import sys

import pytest


@pytest.mark.slow
def test_every_example_passes(repository):
    files = [
        path
        for path in sorted((repository / "tests").rglob("test_*.py"))
        if "from tests.examples import" in path.read_text(encoding="utf-8")
    ]
    assert files
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-n", "0", *map(str, files)],
        cwd=repository,
        env=os.environ | {"THOROUGH": "1"},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stdout
