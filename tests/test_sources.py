"""Modules that compute formulas state where these are from.

A module counts if it is a law, if its docstring displays a formula, or if its code takes three
or more roots, powers, exponentials, logarithms or angles. It then has to name, in any of its
docstrings or comments, a publication with its year, or to say that a formula holds by
definition or is derived there.
"""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parent.parent / "tissuec"
#: Folders that compute. Those of kernels are left out: a comment there changes their digest.
FOLDERS = ("analysis", "fuzzy", "geometry", "laws", "matter", "mechanics")
FUNCTIONS = frozenset(
    ("sqrt", "hypot", "exp", "expm1", "log", "log1p", "erf", "cos", "sin", "cosh", "sinh",
     "tanh", "arccos", "arcsin", "arctan", "arctan2", "atan2")
)  # fmt: skip
MANY = 3
DISPLAYED = re.compile(r"^    .*[=≤≥].*$", re.MULTILINE)
YEAR = r"\b(1[6-9]\d\d|20[0-2]\d)\b"
SOURCE = re.compile(YEAR + r"|\bby\s+definition\b|\bderived\s+here\b", re.IGNORECASE)
MODULES = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))


def computes(tree: ast.Module) -> bool:
    """Return whether a module has to state a source."""
    found = sum(map(is_formula, ast.walk(tree)))
    return found >= MANY or bool(DISPLAYED.search(ast.get_docstring(tree, clean=True) or ""))


def is_formula(node: ast.AST) -> bool:
    match node:
        case ast.BinOp(left=left, op=ast.Pow()):
            return not isinstance(left, ast.Constant)
        case ast.Call(func=ast.Attribute(attr=name) | ast.Name(id=name)):
            return name in FUNCTIONS
    return False


def is_law(path: Path) -> bool:
    return path.parent.name in ("spring", "viscosity") and path.stem != "__init__"


def test_modules_that_compute_formulas_state_their_source():
    texts = {path: path.read_text(encoding="utf-8") for path in MODULES}
    silent = [
        path.relative_to(ROOT).as_posix()
        for path, text in texts.items()
        if (is_law(path) or computes(ast.parse(text))) and not SOURCE.search(text)
    ]
    assert not silent, "state the publication of the formulas in these, with the year"


def test_what_counts_is_told_apart():
    assert computes(ast.parse("x = a**2 + sqrt(b) + np.exp(c)"))
    assert computes(ast.parse('"""A law.\n\n    f = c e\n\nIt is linear.\n"""'))
    assert not computes(ast.parse("x = 2.0**20 + np.linalg.norm(a) + b**2"))
