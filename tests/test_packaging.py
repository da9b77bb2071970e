"""Grammars and library are found in a wheel, a wheel built from the sdist, and a checkout."""

import re
import subprocess
import sys
import zipfile

import pytest

from tissuec import __version__
from tissuec.view.explorer.page import PARTS, SCRIPTS
from tissuec.view.report.origins import PAPER, SOFTWARE

pytest.importorskip("hatchling")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory, repository):
    """Return a wheel that was built through the sdist, as releases are."""
    folder = tmp_path_factory.mktemp("dist")
    build = (
        "import sys, os, tarfile, pathlib\n"
        "from hatchling import build\n"
        "dist = sys.argv[1]\n"
        "name = build.build_sdist(dist)\n"
        "tarfile.open(os.path.join(dist, name)).extractall(dist, filter='data')\n"
        "os.chdir(os.path.join(dist, name.removesuffix('.tar.gz')))\n"
        "print(build.build_wheel(dist))\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", build, str(folder)],
        cwd=repository,
        capture_output=True,
        text=True,
        check=True,
    )
    return folder / run.stdout.strip().splitlines()[-1]


def test_the_wheel_ships_grammars_library_and_nothing_else(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert "tissuec/_data/grammars/tissue.lark" in names
    assert "tissuec/_data/grammars/vscode/syntaxes/tissuec.tmLanguage.json" in names
    assert "tissuec/_data/library/scenes/sterilisation.tis" in names
    assert "tissuec/core/codes.toml" in names
    assert "tissuec/py.typed" in names
    assert {f"tissuec/view/explorer/{name}" for name in (*SCRIPTS, *PARTS)} <= set(names)
    others = ("benchmarks/", "docs/", "tests/")
    assert not [name for name in names if name.startswith(others) or "__pycache__" in name]


def test_the_sdist_ships_what_is_beside_the_package(wheel):
    (unpacked,) = (path for path in wheel.parent.iterdir() if path.is_dir())
    for name in ("benchmarks/nets/lattice.tis", "benchmarks/loops.c", "docs/numerics.md"):
        assert (unpacked / name).is_file()


def test_an_unpacked_wheel_checks_a_shipped_scene(wheel, tmp_path):
    zipfile.ZipFile(wheel).extractall(tmp_path)
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); "
        "sys.argv = ['tissuec', 'check', 'scene.tis']; from tissuec.cli import main; main()"
    )
    shipped = tmp_path / "tissuec" / "_data" / "library" / "scenes" / "sterilisation.tis"
    (tmp_path / "scene.tis").write_bytes(shipped.read_bytes())
    run = subprocess.run(
        [sys.executable, "-I", "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr


def test_a_bare_checkout_finds_its_own_files(repository):
    from tissuec.core import resources

    assert resources.root() == repository


def test_files_of_a_release_name_its_version(repository):
    cited = (repository / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {__version__}\n" in cited
    paper = cited[cited.index("references:") :]
    facts = re.findall(r"(?:title|year|family-names): ([^,\n]+)", paper)
    assert len(facts) == 6 and all(fact in PAPER for fact in facts)
    assert re.search(r"abstract: A (.+)\n", cited)[1] in SOFTWARE
    changes = (repository / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.findall(r"^## \[(\d.*?)\]", changes, re.MULTILINE)[0] == __version__
