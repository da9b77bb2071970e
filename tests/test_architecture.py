"""Imports point down and make no circles, light commands stay light, and functions short."""

import ast
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator

import pytest

from tests.modules import ROOT, nodes, trees

HEAVY = ("llvmlite", "scipy", "numba", "h5py")
LIGHT = {
    "check": ["check", "library/scenes/sterilisation.tis"],
    "pressed": ["check", "library/scenes/two_masses.tis"],
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
    "tissuec.forces.contact.contact", "tissuec.forces.acting.jets",
    "tissuec.forces.acting.foundation", "tissuec.forces.enclosed", "tissuec.autodiff",
    "tissuec.lang.classify", "tissuec.compiler.forces", "tissuec.compiler.learning.problems",
    "tissuec.scene.learning.model", "tissuec.scene.study",
    "tissuec.compiler.materials.matter",
    "tissuec.matter", "tissuec.meshes.repair", "tissuec.meshes.filling",
    "tissuec.learn", "tissuec.validate", "tissuec.analysis.bench", "tissuec.view.plots",
    "tissuec.engine.integrators.derivatives_kernel",
    "tissuec.view.player", "tissuec.view.report", "tissuec.lsp", "tissuec.view.compare",
    "scipy.sparse.csgraph", "numba", "numpy.ma",
)  # fmt: skip
PLAIN = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 10 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 11 }
table springs of pair with columns "a b" { 1 2 }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 10 ms }
"""


#: A tube that a tool lifts and lets go.
LIFTED = """language 1
tissue wall { spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 10 mg }
body duct {
  mesh is tube {
    axis from (0, 0, 0) mm to (20, 0, 0) mm
    radius = 3 mm; rings = 4; sides = 6
  }
  tissue is wall
}
set end = nodes of duct where x < 1 mm
set middle = nodes of duct where x between 5 mm and 8 mm
tool hook { kind is forceps }
environment { gravity = (0, 0, 0) m/s^2; contact is off }
script {
  at 0 s: fix end
  at 1 ms: grasp middle with hook
  from 1 ms to 4 ms: move hook by (0, 0, 1) mm using smooth profile
  when force(hook) > 50 N: release middle from hook
  at 6 ms: release middle from hook
}
simulate { duration = 10 ms }
output { trajectory of duct every 1 ms; energy every 1 ms }
"""


@pytest.mark.parametrize("scene", [PLAIN, LIFTED], ids=["two masses", "lifted tube"])
def test_a_run_imports_nothing_that_its_scene_does_not_need(scene, tmp_path):
    (tmp_path / "pair.tis").write_text(scene)
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


# --- sizes and circles ------------------------------------------------------------------------

LONGEST = 60  # lines of a function with its documentation


def test_functions_are_short():
    assert [
        f"{path}: {node.name} has {lines} lines"
        for path in trees()
        for node in nodes(path)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and (lines := node.end_lineno - node.lineno + 1) > LONGEST
    ] == []


def test_no_files_import_each_other():
    """Also where an import is late, or only for types."""
    assert _circles({path: nodes(path) for path in trees()}) == []


def _circles(modules: dict[str, list[ast.AST]]) -> list[tuple[str, ...]]:
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    paths = sorted(modules)
    number = {path: k for k, path in enumerate(paths)}
    pairs = [
        (number[path], number[other])
        for path, inside in modules.items()
        for other in _imported(inside)
        if other in number and not other.endswith("__init__.py")
    ]
    rows, columns = zip(*pairs, strict=True)
    graph = csr_array(([1] * len(pairs), (rows, columns)), shape=(len(paths), len(paths)))
    count, label = connected_components(graph, connection="strong")
    groups = [[] for _ in range(count)]
    for path, group in zip(paths, label, strict=True):
        groups[group].append(path)
    return [tuple(group) for group in groups if len(group) > 1]


def _imported(inside: list[ast.AST]) -> Iterator[str]:
    """Yield the files of the package that a module imports from anywhere in it."""
    for node in inside:
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("tissuec."):
            place = node.module.removeprefix("tissuec.").replace(".", "/")
            yield f"{place}.py"
            yield from (f"{place}/{one.name}.py" for one in node.names)


def test_a_circle_is_found():
    texts = {"a.py": "from tissuec.b import x", "b.py": "def f():\n    from tissuec.a import y"}
    modules = {path: list(ast.walk(ast.parse(text))) for path, text in texts.items()}
    assert _circles(modules) == [("a.py", "b.py")]


#: Nodes of the syntax tree that are named like what they are turned into, or like numbers and
#: vectors of formulas.
SYNTAX = "lang/syntax.py"
TURNED_INTO = {
    "fuzzy/rules.py", "laws/formula.py", "autodiff/graph.py", "autodiff/tensors.py",
}  # fmt: skip


def test_no_class_name_stands_in_two_files():
    assert _double_names({path: nodes(path) for path in trees()}) == {}


def _double_names(modules: dict[str, list[ast.AST]]) -> dict[str, list[str]]:
    """Return the files of names that several have; a subclass may keep the name of its base."""
    found: dict[str, list[str]] = {}
    for path, inside in modules.items():
        for node in inside:
            if isinstance(node, ast.ClassDef) and not _extends_namesake(node):
                found.setdefault(node.name, []).append(path)
    return {
        name: places
        for name, places in found.items()
        if len(places) > 1
        and not (len(places) == 2 and SYNTAX in places and TURNED_INTO & {*places})
    }


def _extends_namesake(node: ast.ClassDef) -> bool:
    return any(getattr(base, "attr", "") == node.name for base in node.bases)


def test_a_double_name_is_found():
    texts = {
        "a.py": "class Curve: ...", "b.py": "class Curve: ...",
        "results.py": "class Table: ...", "view.py": "class Table(results.Table): ...",
        SYNTAX: "class Rule: ...", "fuzzy/rules.py": "class Rule: ...",
    }  # fmt: skip
    modules = {path: list(ast.walk(ast.parse(text))) for path, text in texts.items()}
    assert _double_names(modules) == {"Curve": ["a.py", "b.py"]}


def test_the_manual_lists_every_folder_in_the_order_of_the_contracts(repository):
    page = (repository / "docs" / "extending.md").read_text(encoding="utf-8")
    section = page.split("## Where things live")[1].split("Where to look:")[0]
    listed = re.findall(r"^\| `(\w+)(?:\.py)?` \|", section, re.MULTILINE)
    contracts = tomllib.loads((repository / "pyproject.toml").read_text(encoding="utf-8"))
    layers = contracts["tool"]["importlinter"]["contracts"][0]["layers"]
    floor = {
        name.strip().removeprefix("tissuec."): number
        for number, layer in enumerate(reversed(layers))
        for name in layer.split("|")
    }
    assert sorted(listed) == sorted(floor)
    floors = [floor[name] for name in listed]
    assert floors == sorted(floors)
    folders = {path.parent.name for path in (repository / "tissuec").glob("*/__init__.py")}
    assert folders <= set(listed)


# --- terms ------------------------------------------------------------------------------------

#: What only makes sense while edges of elements are springs, or nodes keep internal variables.
FORMER_TERMS = re.compile(
    r"springs?\s+(?:(?:are|run)\s+)?(?:along\s+)?(?:the|its|their)?\s*edges?\s+of\s+(?:\w+\s+)?elements?"
    r"|edges?\s+of\s+(?:\w+\s+)?elements?\s+(?:are|count\s+as)\s+springs"
    r"|springs\s+are\s+(?:its|their)\s+edges"
    r"|\bspring_?s?\.is_edge|\bnetwork\.is_edge\b|\bshown_springs\b"
    r"|hidden[\s_]+nodes?\b"
)


def test_edges_are_not_called_springs_nor_variables_nodes():
    root = ROOT.parent
    texts = [*ROOT.rglob("*.py"), *(root / "docs").rglob("*.md"), root / "README.md"]
    found = {path.name: _former(path.read_text(encoding="utf-8")) for path in texts}
    assert {name: phrases for name, phrases in found.items() if phrases} == {}


def _former(text: str) -> list[str]:
    return [match[0] for match in FORMER_TERMS.finditer(text)]


def test_former_terms_are_found():
    former = [
        "Springs along the edges of elements", "its springs are edges of finite elements",
        "Edges of elements are springs without", "whose springs are their edges",
        "shown_springs", "velocities of hidden nodes", "hidden_nodes",
    ]  # fmt: skip
    assert all(_former(text.lower()) for text in former)
    assert not _former("springs and edges of elements; edges of elements are no springs")
