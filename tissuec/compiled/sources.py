"""What shipped kernels are made from, and a digest of it."""

import ast
import hashlib
from collections.abc import Iterator
from typing import cast

from tissuec.core.resources import PACKAGE

#: The translated files, and those that translate them.
SOURCES = (
    "compiled/binding.py",
    "compiled/bundles.py",
    "compiled/export.py",
    "compiled/fusing.py",
    "compiled/mathematics.py",
    "compiled/numba_types.py",
    "compiled/record_tables.py",
    "compiled/team.*",
    "engine/codegen/*.py",
    "engine/integrators/*.py",
    "engine/operations.py",
    "engine/rate.py",
    "engine/step_control.py",
    "engine/step_inside.py",
    "engine/step.py",
    "engine/step_refined.py",
    "forces/*/*_kernel.py",
    "forces/*_kernel.py",
    "forces/accelerations.py",
    "geometry/nearest.py",
    "kernels/*.py",
    "laws/code.py",
)
_DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def digest_of_sources() -> str:
    """Return a digest that changes with the code of the sources, and not with their comments.

    Layout, comments and docstrings of Python files do not count: no kernel depends on them.
    """
    found = hashlib.sha256()
    for pattern in SOURCES:
        for path in sorted(PACKAGE.glob(pattern)):
            text = path.read_text(encoding="utf-8")
            if path.suffix == ".py":
                text = " ".join(_words_of(ast.parse(text)))
            found.update(f"{path.name}\0{text}\0".encode())
    return found.hexdigest()


def _words_of(item: object) -> Iterator[str]:
    """Yield the syntax below a node, the same in all versions of Python.

    Empty fields are left out, since later versions add some.
    """
    match item:
        case ast.AST():
            yield f"({type(item).__name__}"
            for name, value in ast.iter_fields(item):
                if value is None or value == []:
                    continue
                if name == "body" and isinstance(item, _DOCUMENTED):
                    value = value[ast.get_docstring(item) is not None :]
                yield name
                yield from _words_of(value)
            yield ")"
        case list():
            for member in cast("list[object]", item):
                yield from _words_of(member)
        case _:
            yield repr(item)
