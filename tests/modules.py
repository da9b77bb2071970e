"""The modules of the package as syntax trees, parsed once for all tests that read them."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent / "tissuec"


@cache
def trees() -> dict[str, ast.Module]:
    """Return the tree of each module by its path below the package."""
    return {
        path.relative_to(ROOT).as_posix(): ast.parse(path.read_text(encoding="utf-8"))
        for path in sorted(ROOT.rglob("*.py"))
    }


@cache
def nodes(path: str) -> list[ast.AST]:
    """Return all nodes of a module."""
    return list(ast.walk(trees()[path]))
