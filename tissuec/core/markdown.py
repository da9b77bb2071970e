"""Small pieces of Markdown: tables, docstrings, and generated places in a page."""

import inspect
import re
from collections.abc import Iterable, Mapping, Sequence

_PLACE = r"(<!-- {mark}: (?P<name>[\w -]+) -->\n).*?(<!-- end of (?P=name) -->)"
_SECTION = re.compile(r"^(Attributes|Args|Returns|Raises):$", re.MULTILINE)


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; cells are one line each, and a bar in them is no border."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(map(_cell, line))} |" for line in lines)


def code(text: str) -> str:
    """Return text as code."""
    return f"`{text}`"


def fenced(text: str, kind: str = "text") -> str:
    """Return text as a block of code."""
    return f"```{kind}\n{text}\n```"


def summary(documented: object) -> str:
    """Return the first sentence of a docstring, as Markdown."""
    return described(documented).partition("\n\n")[0].replace("\n", " ")


def described(documented: object) -> str:
    """Return a docstring as Markdown, without its sections such as "Attributes:"."""
    text = inspect.cleandoc(getattr(documented, "__doc__", None) or "")
    found = _SECTION.search(text)
    return paragraphs(text[: found.start()] if found else text)


def paragraphs(text: str) -> str:
    """Return paragraphs with ``code`` as `code`, and tables and \\b parts as blocks."""
    parts: list[str] = []
    for part in re.split(r"\n\s*\n", text.strip()):
        if part.startswith("\b\n"):
            parts.append(fenced(part.removeprefix("\b\n"), "sh"))
        elif part.startswith("==="):
            parts.append(_grid(part))
        else:
            parts.append(re.sub(r"``(.+?)``", _on_one_line, part, flags=re.DOTALL))
    return "\n\n".join(parts)


def replace_places(page: str, contents: Mapping[str, str], mark: str = "generated") -> str:
    """Return a page with new contents at its marked places.

    Args:
        contents: Contents by the name of the place.
        mark: First word of the marks.

    Raises:
        ValueError: A place has a name without contents.
    """

    def fill(found: re.Match[str]) -> str:
        if found["name"] not in contents:
            raise ValueError(f'there is nothing to put at "{mark}: {found["name"]}"')
        return f"{found[1]}\n{contents[found['name']]}\n\n{found[3]}"

    return _places(mark).sub(fill, page)


def places(page: str, mark: str = "generated") -> list[str]:
    """Return the names of the marked places of a page, in order."""
    return [found["name"] for found in _places(mark).finditer(page)]


def _places(mark: str) -> re.Pattern[str]:
    return re.compile(_PLACE.format(mark=mark), re.DOTALL)


def _on_one_line(quoted: re.Match[str]) -> str:
    return code(" ".join(quoted[1].split()))


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _grid(text: str) -> str:
    """Return a table whose columns are underlined with equal signs, as Markdown.

    A line that is blank under the first column continues the row above.
    """
    border, *lines = text.split("\n")
    starts = [found.start() for found in re.finditer(r"=+", border)]
    rows: list[list[str]] = []
    for line in lines:
        if line.startswith("==="):
            continue
        cells = [line[a:b].strip() for a, b in zip(starts, [*starts[1:], None], strict=True)]
        if cells[0] or not rows:
            rows.append(cells)
        else:
            rows[-1] = [
                f"{old} {new}".strip() for old, new in zip(rows[-1], cells, strict=True)
            ]
    return table(rows[0], rows[1:])
