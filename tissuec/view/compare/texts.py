"""Differences of texts, of scenes and of files that they use, in canonical layout."""

from collections.abc import Iterator, Mapping
from difflib import unified_diff
from typing import Literal

from msgspec import Struct

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.lang.printer import format_source
from tissuec.view.compare.sides import Side


class TextDifference(Struct, frozen=True):
    """A text that is not the same, or that only one of the two uses.

    Attributes:
        name: Of a file that is used; "scene" for the scene itself.
        kind: "changed", "only in a" or "only in b".
        lines: Of a changed one, a unified diff.
    """

    name: str
    kind: Literal["changed", "only in a", "only in b"]
    lines: tuple[str, ...] = ()


def compare_texts(a: Side, b: Side) -> Iterator[TextDifference]:
    """Yield the scene if it differs, and then the files that it uses; blanks do not count."""
    yield from _changed("scene", a.text, b.text, a.scene, b.scene)
    for name in {**a.imports, **b.imports}:
        if name not in b.imports:
            yield TextDifference(name, "only in a")
        elif name not in a.imports:
            yield TextDifference(name, "only in b")
        else:
            yield from _changed(name, a.imports[name], b.imports[name], name, name)


def changed_files(a: Mapping[str, str], b: Mapping[str, str]) -> Iterator[TextDifference]:
    """Yield files that differ by digest, such as meshes."""
    for name in {**a, **b}:
        if name not in b:
            yield TextDifference(name, "only in a")
        elif name not in a:
            yield TextDifference(name, "only in b")
        elif a[name] != b[name]:
            yield TextDifference(name, "changed")


def _changed(name: str, a: str, b: str, name_a: str, name_b: str) -> Iterator[TextDifference]:
    if a == b:
        return
    before, after = (canonical(text).splitlines() for text in (a, b))
    lines = unified_diff(before, after, f"a: {name_a}", f"b: {name_b}", lineterm="")
    if found := tuple(lines):
        yield TextDifference(name, "changed", found)


def canonical(text: str) -> str:
    """Return a text in canonical layout; as it is where this version cannot read it."""
    try:
        return format_source(Source("", text))
    except CompileError:
        return text
