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


#: What a run imports only if its scene needs it.
RARE = (
    "tissuec.forces.contact", "tissuec.forces.jets", "tissuec.forces.foundation",
    "tissuec.compiler.forces", "tissuec.compiler.fit_problems",
    "tissuec.learn", "tissuec.validate", "tissuec.bench", "tissuec.view.plots",
    "tissuec.view.player", "tissuec.view.report", "tissuec.lsp", "tissuec.view.compare",
    "scipy.sparse.csgraph", "numba",
)  # fmt: skip
PLAIN = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 10 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 11 }
table springs of pair with columns "a b" { 1 2 }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 10 ms }
"""


def test_a_run_of_two_masses_imports_nothing_that_its_scene_does_not_need(tmp_path):
    (tmp_path / "pair.tis").write_text(PLAIN)
    code = (
        "import sys, tissuec\n"
        "tissuec.run('pair.tis', out='pair.vtkhdf', companion='off')\n"
        f"print([name for name in {RARE!r} if name in sys.modules])\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip() == "[]"


def test_imports_point_down_only(repository):
    run = subprocess.run(
        [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()"],
        cwd=repository, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout


@pytest.mark.parametrize("rule", [("check",), ("format", "--check")])
def test_code_is_linted_and_formatted(rule, repository):
    run = subprocess.run(
        [sys.executable, "-m", "ruff", *rule, "tissuec", "tests", "docs", "benchmarks"],
        cwd=repository, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout


@pytest.mark.slow
def test_types_are_right(repository):
    pytest.importorskip("pyright")
    run = subprocess.run(
        [sys.executable, "-m", "pyright", "--pythonpath", sys.executable],
        cwd=repository, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout
