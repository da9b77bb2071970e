"""A package of its own adds members, without a line in tissuec: those of docs/extending.md."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.test_docs import DOCS, blocks

#: Groups of entry points by the folder in which the page puts an example.
GROUPS = {
    "tissuec/meshes/generators": "tissuec.mesh",
    "tissuec/meshes/formats": "tissuec.mesh_format",
    "tissuec/script/tools": "tissuec.tool",
    "tissuec/script/verbs": "tissuec.verb",
    "tissuec/script/measures": "tissuec.measure",
    "tissuec/forces": "tissuec.force",
    "tissuec/validate/forces": "tissuec.force_formula",
    "tissuec/laws/spring": "tissuec.spring_law",
    "tissuec/engine/integrators": "tissuec.integrator",
    "tissuec/geometry/surfaces": "tissuec.surface",
    "tissuec/view/plots": "tissuec.plot",
}

TETRAHEDRON = "OFF\n4 4 0\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"


def install(folder, name, version, groups):
    """Write the metadata of a package whose modules are in a folder already.

    Args:
        groups: Pairs of a name and a module, by groups of entry points.
    """
    metadata = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
    )
    (metadata / "entry_points.txt").write_text(
        "\n".join(
            f"[{group}]\n" + "".join(f"{name} = {module}\n" for name, module in members)
            for group, members in groups.items()
        )
    )


def break_in(folder):
    """Install a package that says to have a mesh, and that cannot be imported."""
    (folder / "broken.py").write_text("import nowhere\n")
    install(folder, "broken", "0.3", {"tissuec.mesh": [("a", "broken")]})


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Return a folder in which a package is installed that has the examples of the page."""
    folder = tmp_path_factory.mktemp("site")
    package, groups = folder / "tissue_extras", {}
    for block in blocks(DOCS / "extending.md"):
        if block.kind == "python" and block.name:
            home = Path(block.name)
            name = "_".join(home.parts[1:-1])
            (package / name).mkdir(parents=True, exist_ok=True)
            (package / name / home.name).write_text(block.text, encoding="utf-8")
            module = f"tissue_extras.{name}.{home.stem}"
            groups.setdefault(GROUPS[home.parent.as_posix()], []).append((home.stem, module))
    install(folder, "tissue-extras", "2.5", groups)
    return folder


def call(folder, site, *words, code=0):
    """Run tissuec in a folder, with the packages of a site; return what it prints."""
    return call_python(folder, site, None, *words, code=code)


def call_python(folder, site, program, *words, code=0):
    """Run a program, or tissuec, in a folder with the packages of a site."""
    environment = {
        **os.environ,
        "PYTHONPATH": f"{site}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
    }
    done = subprocess.run(
        [sys.executable, *(["-c", program] if program else ["-m", "tissuec"]), *words],
        cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8",
    )  # fmt: skip
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def scenes():
    """Return the scenes of the page that use an example, by their names."""
    named = {b.name: b.text for b in blocks(DOCS / "extending.md") if b.kind == "tis"}
    return {
        name: text for name, text in named.items() if name != "cyst.tis" and "/" not in name
    }


@pytest.mark.parametrize("name", sorted(scenes()))
def test_a_scene_uses_members_of_an_installed_package(name, site, tmp_path):
    (tmp_path / "tetrahedron.off").write_text(TETRAHEDRON)
    (tmp_path / name).write_text(scenes()[name], encoding="utf-8")
    verb = "validate" if name in ("magnet.tis", "limit.tis") else "run"
    printed = call(tmp_path, site, verb, name)
    assert "fail" not in printed


def test_a_result_names_the_packages_that_its_scene_may_have_used(site, tmp_path):
    (tmp_path / "ring.tis").write_text(scenes()["ring.tis"], encoding="utf-8")
    call(tmp_path, site, "run", "ring.tis", "-q")
    assert "tissue-extras" in call(tmp_path, site, "info", "ring.vtkhdf", "--json")


def test_actions_of_a_package_are_kept_for_a_run_that_goes_on(site, tmp_path):
    code = (
        "import numpy as np\n"
        "from tissuec.engine.execution.checkpoint import read_state, write_state\n"
        "from tissuec.script.verbs import VERBS\n"
        "from tissue_extras.script_verbs.shrink import Shrink\n"
        "blank = Shrink(*(None for _ in Shrink.__struct_fields__))\n"
        "assert type(read_state(write_state(blank, []), [])) is Shrink and 'shrink' in VERBS\n"
    )
    call_python(tmp_path, site, code)


def test_nothing_is_known_of_a_package_that_is_not_installed(tmp_path):
    (tmp_path / "ring.tis").write_text(scenes()["ring.tis"], encoding="utf-8")
    assert 'there is no mesh called "ring"' in call(
        tmp_path, tmp_path, "check", "ring.tis", code=2
    )


def test_a_package_that_cannot_be_imported_is_named(tmp_path):
    break_in(tmp_path)
    (tmp_path / "ring.tis").write_text(scenes()["ring.tis"], encoding="utf-8")
    said = call(tmp_path, tmp_path, "check", "ring.tis", code=2)
    assert "the package broken 0.3 cannot add a mesh: importing broken fails" in said


def test_a_package_that_cannot_be_imported_is_named_each_time(tmp_path):
    break_in(tmp_path)
    code = (
        "from tissuec.core.plugins import BrokenPlugIn\n"
        "from tissuec.meshes.generators import MESHES\n"
        "for _ in range(2):\n"
        "    try:\n"
        "        len(MESHES)\n"
        "    except BrokenPlugIn as error:\n"
        "        print(error)\n"
    )
    said = call_python(tmp_path, tmp_path, code)
    assert said.count("the package broken 0.3 cannot add a mesh") == 2
