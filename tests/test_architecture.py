"""The floors of the house: imports point down, and light commands stay light."""

import os
import subprocess
import sys

import pytest

HEAVY = ("scipy", "numba", "h5py")
LIGHT = {
    "check": ["check", "library/scenes/sterilisation.tis"],
    "fmt": ["fmt", "--check", "library/scenes/sterilisation.tis"],
    "words": ["words", "fuzzy/soft_tissue"],
    "explore": ["words", "fuzzy/soft_tissue", "--explore", "-o", os.devnull],
    "library": ["library"],
    "help": ["--help"],
}


def _heavy_modules(arguments, root):
    code = (
        "import sys\n"
        f"sys.argv = ['tissuec', *{arguments!r}]\n"
        "from tissuec.cli import main\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code, end.code\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules], file=sys.stderr)\n"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return run.stderr.strip().splitlines()[-1]


@pytest.mark.parametrize("name", sorted(LIGHT))
def test_light_commands_import_no_heavy_library(name, repository):
    assert _heavy_modules(LIGHT[name], repository) == "[]"


def test_imports_point_down_only(repository):
    run = subprocess.run(
        [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()"],
        cwd=repository, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout


@pytest.mark.parametrize("rule", [("check",), ("format", "--check")])
def test_code_is_linted_and_formatted(rule, repository):
    run = subprocess.run(
        [sys.executable, "-m", "ruff", *rule, "tissuec", "tests", "docs"],
        cwd=repository, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout
