"""The examples of ``docs/extending.md`` pass the tests of all members of their families.

In a copy of the repository, each file of the page is put where the page says. Blocks
``sample FILE NAME`` hold what is added to the collection NAME of a test file.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.test_docs import DOCS, blocks

JSON = ["--json"]
PAGE = DOCS / "extending.md"
PARTS = ("docs", "grammars", "library", "tests", "tissuec")
#: Of an integrator, which is not compiled.
BOGACKI = "bogacki and not compiled and not both_tiers"
#: By the folder of an example: tests of its family, and what those of the example contain, or
#: nothing where each test takes all members.
FAMILIES = {
    "generators": ("tests/meshes/test_mesh_laws.py", ""),
    "formats": ("tests/imports/test_imported.py", "organ.off"),
    "tools": ("tests/contact/test_instruments.py", "spatula"),
    "measures": ("tests/script/measures", "spread"),
    "acting": ("tests/forces/test_fields.py", "magnet or area or hardening"),
    "spring": ("tests/laws/test_laws.py", "saturating"),
    "solid": ("tests/laws/test_solid_laws.py", "gent or sample"),
    "integrators": ("tests/engine/test_conservation.py", BOGACKI),
    "surfaces": ("tests/geometry/surfaces", ""),
    "fields": ("tests/results/test_fields_of_frames.py", "every_member and momentum"),
    "plots": ("tests/view/plots/test_kinds.py", "phases and not every_format"),
    "scene": ("tests/scene/test_parts.py", ""),
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


def call(folder, *words, **more):
    """Run a module of Python in a folder; return its code, and the end of what it prints."""
    names = {**os.environ, "PYTHONPATH": str(folder), **more}
    done = subprocess.run(
        [sys.executable, "-m", *words], cwd=folder, env=names, capture_output=True, text=True
    )
    return done.returncode, done.stdout[-3000:] + done.stderr[-3000:]


def run(folder, *words, code=0, **more):
    """Run a module of Python in a folder, and fail if it ends with another code."""
    ended, said = call(folder, *words, **more)
    assert ended == code, said


def run_tests(folder, chosen, *files, **more):
    """Run the tests of some files that are chosen, of which there have to be some."""
    run(folder, "pytest", "-n", "0", "-k", chosen, *files, **more)


@pytest.fixture(scope="module")
def tested(request, extended):
    """Return the results of the tests of all families that are asked for, and what is said.

    One process runs them, which takes as long to start as the tests of a family.
    """
    name = test_an_example_passes_the_tests_of_its_family.__name__
    asked = [one for one in request.session.items if getattr(one, "originalname", "") == name]
    families = [FAMILIES[one.callspec.params["family"]] for one in asked]
    parts = [
        f"({Path(file).stem} and ({chosen}))" if chosen else Path(file).stem
        for file, chosen in families
    ]
    report, files = extended / "report.xml", [file for file, _ in families]
    words = ("-n", "0", "-k", " or ".join(parts), f"--junitxml={report}", *files)
    _, said = call(extended, "pytest", *words)
    return [*ElementTree.parse(report).iter("testcase")], said


@pytest.mark.parametrize("family", sorted(FAMILIES))
def test_an_example_passes_the_tests_of_its_family(family, tested):
    results, said = tested
    module = FAMILIES[family][0].removesuffix(".py").replace("/", ".")
    own = [one for one in results if one.get("classname", "").startswith(module)]
    wrong = [one.get("name") for one in own for part in one if part.tag in ("failure", "error")]
    assert own and not wrong, f"{wrong}\n{said}"


@pytest.mark.slow
@pytest.mark.parametrize("files", ["tests/engine/integrators", "tests/engine"])
def test_the_example_of_an_integrator_passes_the_tests_of_all_integrators(files, extended):
    run_tests(extended, BOGACKI, files)


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
        "is area elasticity`",
        "is hardening foundation`",
        "`membrane tension`",
        "is saturating`",
    ):
        assert member in language, member


def test_expected_messages_list_the_examples_once_they_are_rewritten(extended):
    scenes = "tests/test_scenes.py"
    run_tests(extended, "a_bad_scene", scenes, code=1, TISSUEC_UPDATE="1")
    run_tests(extended, "a_bad_scene", scenes)


def test_a_command_is_one_file(extended):
    """The help lists it, and text, JSON and errors follow from its report."""
    scene = "library/scenes/two_masses.tis"
    (code, text), (_, data) = (call(extended, "tissuec", "mass", scene, *m) for m in ([], JSON))
    assert code == 0 and re.fullmatch(r"chain: [\d.]+ \w+\ndumb bell: [\d.]+ \w+\n", text), text
    document = json.loads(data)
    assert document.pop("ok") is True and min(document.values()) > 0.0
    code, said = call(extended, "tissuec", "mass", "nowhere.tis", *JSON)
    assert code == 2 and not json.loads(said)["ok"]
    assert "Print the mass of every body" in call(extended, "tissuec", "--help")[1]


def test_every_family_on_the_page_is_tested():
    files = [block.name for block in blocks(PAGE) if block.kind == "python" and block.name]
    families = {path.split("/")[-2] for path in files if "validate" not in path}
    # What verbs do has no laws in common.
    assert families == {*FAMILIES, "integrators", "verbs", "cli"}
