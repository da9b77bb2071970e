"""What result files contain, as Markdown, from the declarations of their datasets."""

import re
from collections.abc import Iterator

from tissuec.core.markdown import code, table
from tissuec.results.blocks.fields import DERIVED
from tissuec.results.datasets import FLOAT, TEXT, DatasetSpec
from tissuec.results.schema import GROUPS

#: What differs from file to file, as the manual writes it.
_PLACES = {"elsewhere": "", "what": "DESCRIPTION", "unit": "UNIT"}
_KINDS = {FLOAT: "f8 or f4", "": "any", TEXT: "text"}


def parts() -> dict[str, str]:
    """Return every generated part by its name."""
    return {
        "result groups": group_table(),
        "result datasets": "\n\n".join(_sections()),
        "block fields": block_table(),
    }


def block_table() -> str:
    """Return a table of the arrays of blocks that follow from frames."""
    rows = [
        (code(one.name), one.at, one.unit, one.text.replace(": xx, yy, zz, xy, yz, xz", ""))
        for one in DERIVED
    ]
    return table(("array", "at", "unit", "meaning"), rows)


def group_table() -> str:
    """Return a table of what is where in a file."""
    rows = [(code(_named(one.path)), one.about, one.when or "all files") for one in GROUPS]
    return table(("path", "contents", "in files of"), rows)


def _sections() -> Iterator[str]:
    """Yield a table of the datasets of each group below its path."""
    heads = ("dataset", "shape", "type", "unit", "contents")
    for group in GROUPS:
        rows = [
            (code(_named(name or group.path.rpartition("/")[2])), *_facts(one))
            for name, one in group.items()
        ]
        yield f"## {code(_named(group.path))}\n\n{table(heads, rows)}"


def _facts(one: DatasetSpec) -> tuple[str, ...]:
    shape = f"({', '.join(map(str, one.axes))})" if one.axes else ""
    kind = _KINDS.get(one.kind, one.kind)
    return shape, kind, _named(one.unit), _named(one.text)


def _named(text: str) -> str:
    """Return a text with names in capitals where they differ from file to file."""
    return re.sub(r"\{(\w+)\}", lambda place: _PLACES.get(place[1], place[1].upper()), text)
