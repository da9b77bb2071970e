"""The examples of ``docs/extending.md`` pass the tests of all members of their families.

In a copy of the repository, each file of the page is put where the page says. Blocks
``sample FILE NAME`` hold what is added to the collection NAME of a test file.
"""

import os
import re
import shutil
import subprocess
import sys

import pytest

from tests.test_docs import DOCS, blocks

PAGE = DOCS / "extending.md"
PARTS = ("docs", "grammars", "library", "tests", "tissuec")
#: By the folder of an example: tests of its family, and what those of the example contain, or
#: nothing where each test takes all members.
FAMILIES = {
    "generators": ("tests/meshes/test_mesh_laws.py", ""),
    "formats": ("tests/imports/test_imported.py", "organ.off"),
    "tools": ("tests/contact/test_instruments.py", "spatula"),
    "measures": ("tests/script/measures", "spread"),
    "forces": ("tests/forces/test_fields.py", "magnet"),
    "spring": ("tests/laws", "saturating"),
    "surfaces": ("tests/geometry/surfaces", ""),
    "plots": ("tests/view/plots/test_kinds.py", "phases and not every_format"),
}


@pytest.fixture(scope="module")
def extended(repository, tmp_path_factory):
    """Return a copy of the repository with all examples of the page."""
    copy = tmp_path_factory.mktemp("extended")
    for part in PARTS:
        shutil.copytree(
            repository / part, copy / part, ignore=shutil.ignore_patterns("figures")
        )
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(repository / name, copy / name)
    for block in blocks(PAGE):
        file, _, name = block.name.partition(" ")
        if block.kind == "python" and file:
            (copy / file).write_text(block.text, encoding="utf-8")
        elif block.kind == "sample":
            add_sample(copy / file, name, block.text)
    return copy


def add_sample(path, name, text):
    """Put a text behind the opening bracket of a collection."""
    before = path.read_text(encoding="utf-8")
    after, count = re.subn(
        rf"^{name} = [\[{{]$", lambda found: found[0] + "\n" + text, before, flags=re.MULTILINE
    )
    assert count == 1, f"{path.name} has no {name}"
    path.write_text(after, encoding="utf-8")


def run(folder, *words, code=0, **more):
    """Run a module of Python in a folder, and fail if it ends with another code."""
    names = {**os.environ, "PYTHONPATH": str(folder), **more}
    done = subprocess.run(
        [sys.executable, "-m", *words], cwd=folder, env=names, capture_output=True, text=True
    )
    assert done.returncode == code, done.stdout[-3000:] + done.stderr[-3000:]


def run_tests(folder, chosen, *files, **more):
    """Run the tests of some files that are chosen, of which there have to be some."""
    run(folder, "pytest", "-n", "0", "-k", chosen, *files, **more)


@pytest.mark.parametrize("family", sorted(FAMILIES))
def test_an_example_passes_the_tests_of_its_family(family, extended):
    file, chosen = FAMILIES[family]
    run_tests(extended, chosen, file)


@pytest.mark.parametrize(
    "files",
    [
        ("tests/engine/test_conservation.py",),
        pytest.param(("tests/engine/integrators",), marks=pytest.mark.slow),
        pytest.param(("tests/engine",), marks=pytest.mark.slow),
    ],
    ids=["conservation", "integrators", "engine"],
)
def test_the_example_of_an_integrator_passes_the_tests_of_all_integrators(files, extended):
    run_tests(extended, "bogacki and not compiled and not both_tiers", *files)


def test_tables_list_the_examples_once_they_are_regenerated(extended):
    run(extended, "docs.reference")
    tables = ("tests/test_docs.py", "tests/lsp/test_colours.py")
    run_tests(extended, "up_to_date or generated", *tables)
    pages = (extended / "docs" / "language").glob("*.md")
    language = "".join(page.read_text(encoding="utf-8") for page in pages)
    for member in (
        "is ring`",
        "is spatula`",
        "shrink SET",
        "spread(A)",
        "is magnet`",
        "is saturating`",
    ):
        assert member in language, member


def test_expected_messages_list_the_examples_once_they_are_rewritten(extended):
    scenes = "tests/test_scenes.py"
    run_tests(extended, "a_bad_scene", scenes, code=1, TISSUEC_UPDATE="1")
    run_tests(extended, "a_bad_scene", scenes)


def test_every_family_on_the_page_is_tested():
    files = [block.name for block in blocks(PAGE) if block.kind == "python" and block.name]
    families = {path.split("/")[-2] for path in files}
    # What verbs do has no laws in common.
    assert families == {*FAMILIES, "integrators", "verbs"}
