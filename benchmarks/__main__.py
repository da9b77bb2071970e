"""List the benchmarks."""

import ast
from pathlib import Path

HERE = Path(__file__).resolve().parent


def benchmarks() -> dict[str, str]:
    """Return the name of every benchmark and the first line of its docstring."""
    found: dict[str, str] = {}
    for path in sorted([*HERE.glob("*.py"), *HERE.glob("*/__main__.py")]):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        if path != Path(__file__).resolve() and _has_main(tree):
            name = path.parent.name if path.stem == "__main__" else path.stem
            found[name] = (ast.get_docstring(tree) or "").partition("\n")[0]
    return found


def _has_main(tree: ast.Module) -> bool:
    return any(isinstance(one, ast.FunctionDef) and one.name == "main" for one in tree.body)


if __name__ == "__main__":
    known = benchmarks()
    width = max(map(len, known))
    print("python -m benchmarks.NAME [--help]\n")
    for name, summary in known.items():
        print(f"{name:{width}}  {summary}")
