"""The reference shares no arithmetic with what it judges."""

import ast
from pathlib import Path

import tissuec.validate
from tests.every import every

FOLDER = Path(tissuec.validate.__file__).parent
FORBIDDEN = ("engine", "kernels", "mechanics")
SOLVER = (
    "contact_search",
    "embedded",
    "equations",
    "field_matrices",
    "forces",
    "reference",
    "resting",
    "solution",
    "stepping",
    "yielding",
)
AROUND = {
    "compare",
    "engine_run",
    "refinement",
    "refinement_report",
    "report",
    "uncertainty",
    "validation",
}


def imported(name):
    """Return the full names of all that a module of the folder imports, wherever it does."""
    folder = FOLDER / name
    files = sorted(folder.glob("*.py")) if folder.is_dir() else [FOLDER / f"{name}.py"]
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in files)
    for node in (node for tree in trees for node in ast.walk(tree)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative imports would escape this test"
            yield str(node.module)
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@every("name", SOLVER)
def test_solver_imports_nothing_that_it_judges(name):
    for module in imported(name):
        is_state = module.startswith("tissuec.mechanics.state")
        package, *parts = module.split(".")
        assert package != "tissuec" or is_state or not {*parts[:1]} & {*FORBIDDEN}, module


@every("name", SOLVER)
def test_solver_imports_of_its_folder_only_itself(name):
    own = {m.split(".")[2] for m in imported(name) if m.startswith("tissuec.validate.")}
    assert own <= set(SOLVER)


def test_every_module_is_accounted_for():
    assert {path.stem for path in FOLDER.glob("*.py")} == {"__init__", *SOLVER} - {
        "forces"
    } | AROUND
