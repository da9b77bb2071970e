"""The report of a command: one record that becomes text, JSON, or a part of a page.

A report consists of parts: sentences, facts, tables, failed expectations, and sections of
these. The module that computes a result also returns its parts. Three renderers show them:
``lines`` as text, ``as_json`` as plain data, and ``view.report.markup.shown`` as HTML. Commands
only return reports.
"""

from collections.abc import Iterable, Iterator, Sequence
from sys import maxsize
from typing import Any, Literal, TypeAlias, cast

from msgspec import Struct

from tissuec.core.errors import Diagnostic, as_dict

#: Exit codes of commands.
DONE, FAILED, WRONG_TEXT, STOPPED, INTERRUPTED = 0, 1, 2, 3, 130

#: A "result" is what a command is for, and is printed on stdout. The others are printed on
#: stderr: a "remark" unless the command is quiet, a "failure" always.
Level = Literal["result", "remark", "failure"]
Part: TypeAlias = "str | Fact | FailedExpectation | FactTable | FactSection | Verbatim"

_DEEPER = "    "  # before text that has no room in its line


class Fact(Struct, frozen=True):
    """A sentence with a name before it, such as ``result: tube.vtkhdf``; or with a level.

    Attributes:
        name: Empty for a sentence alone.
        level: None for that of the report.
    """

    name: str
    text: str
    level: Level | None = None


class FailedExpectation(Struct, frozen=True):
    """An expectation that does not hold; a failure.

    Attributes:
        expectation: Its place and text.
        measured: The measured value, and when.
    """

    expectation: str
    measured: str


class FactTable(Struct, frozen=True):
    """Rows in columns.

    Attributes:
        heads: Heads of the columns; empty if they have none.
        rows: Cells of each row.
        title: Title of the table; on pages only.
        least: Minimum widths of the columns, with two blanks before the next one.
        kept: Number of cells of a row that stay in columns if the table is too wide for a
            terminal; the others follow in lines of their own. 0 keeps all.
    """

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""
    least: Sequence[int] = ()
    kept: int = 0


class FactSection(Struct, frozen=True):
    """Parts under a title.

    Attributes:
        title: If it is empty, the parts belong to the sentence before.
        apart: Whether an empty line precedes the section.
    """

    title: str
    parts: Sequence[Part]
    apart: bool = True


class Verbatim(Struct, frozen=True):
    """Text that is printed unchanged, such as a file or a diff."""

    text: str


class Report(Struct, frozen=True):
    """The result of a command.

    Attributes:
        parts: The parts, in the order in which they are shown.
        document: The same as plain data for programs; ``ok`` is added.
        code: Exit code.
        findings: Diagnostics about the text; part of the document.
        level: Level of all parts that have none.
        is_table: Whether the names in the document are those of columns, without ``ok``.
    """

    parts: Sequence[Part] = ()
    document: Any = None
    code: int = DONE
    findings: Sequence[Diagnostic] = ()
    level: Level = "result"
    is_table: bool = False

    def as_json(self) -> Any:
        """Return the document with ``ok``, unless it is a table or a list."""
        document = self.document
        if self.is_table or not isinstance(document, dict):
            return document
        document = cast("dict[str, Any]", document)
        found = {"diagnostics": [*map(as_dict, self.findings)]} if self.findings else {}
        return {"ok": self.code == DONE, **document, **found}


def judged(states: Sequence[str], failures: Iterable[FailedExpectation]) -> Iterator[Part]:
    """Yield the expectations that fail, and how many hold; nothing if there are none.

    Args:
        states: Of all: "holds", "fails" or "not reached".
        failures: Those that fail, or that a run ended too early for.
    """
    yield from failures
    if states:
        yield Fact("expectations", holding(states))


def holding(states: Sequence[str]) -> str:
    """Return how many expectations hold, by their states."""
    unreached = states.count("not reached")
    rest = f", {unreached} not reached" if unreached else ""
    return f"{states.count('holds')} of {len(states)} hold{rest}"


def failed(error: Exception | str, code: int, **facts: Any) -> Report:
    """Return the report of a command that failed.

    Args:
        error: The reason.
        code: Exit code.
        facts: Further facts for programs.
    """
    parts = (Fact("error", str(error), "failure"),)
    return Report(parts, {**facts, "error": str(error)}, code)


def lines(
    parts: Iterable[Part], level: Level = "result", width: int = maxsize, indent: str = ""
) -> Iterator[tuple[Level, str]]:
    """Yield the lines of parts as text, each with its level.

    Args:
        parts: What to show.
        level: Level of parts that have none.
        width: Maximum length of the rows of tables.
        indent: Written before each line.
    """
    for part in parts:
        match part:
            case str():
                yield level, f"{indent}{part}"
            case Fact():
                name = f"{part.name}: " if part.name else ""
                yield part.level or level, f"{indent}{name}{part.text}"
            case FailedExpectation():
                yield "failure", f"{indent}FAILED {part.expectation}"
                yield "failure", f"{indent}       {part.measured}"
            case FactTable():
                rows = [part.heads, *part.rows] if part.heads else part.rows
                for line in fitted(rows, part.least, part.kept, width - len(indent)):
                    yield level, f"{indent}{line}"
            case FactSection():
                if part.title:
                    gap = "\n" if part.apart else ""
                    yield level, f"{gap}{indent}{part.title}"
                yield from lines(part.parts, level, width, f"{indent}  ")
            case Verbatim():
                yield level, part.text.removesuffix("\n")


def as_text(parts: Iterable[Part]) -> list[str]:
    """Return the lines of parts as text."""
    return [line for _, text in lines(parts) for line in text.split("\n")]


def aligned(rows: Sequence[Sequence[str]], least: Sequence[int] = ()) -> list[str]:
    """Return rows in columns that are as wide as their widest cell needs.

    Args:
        rows: Their cells; the last of each row has no column, so it may be as long as it is.
        least: Minimum widths of the columns, with two blanks before the next one.
    """
    widths = dict(enumerate(least))
    for row in rows:
        for column, cell in enumerate(row[:-1]):
            widths[column] = max(widths.get(column, 0), len(cell) + 2)
    return ["".join(c.ljust(widths.get(n, 0)) for n, c in enumerate(r)).rstrip() for r in rows]


def fitted(
    rows: Sequence[Sequence[str]], least: Sequence[int], kept: int, width: int
) -> Iterator[str]:
    """Yield rows in columns; of rows that are too wide, some cells in lines of their own.

    Args:
        rows: Their cells.
        least: As for ``aligned``.
        kept: How many cells of a row stay in columns; 0 for all.
        width: Maximum length of lines; only single words may be longer.
    """
    found = aligned(rows, least)
    if not kept or all(len(line) <= width for line in found):
        yield from found
        return
    from textwrap import wrap  # which few commands need

    columns = aligned([(*row[:kept], "") for row in rows])
    widest = max(map(len, columns)) + 2
    for row, head in zip(rows, columns, strict=True):
        rest = "  ".join(filter(None, row[kept:]))
        if head and widest + len(rest) <= width:
            yield f"{head.ljust(widest)}{rest}".rstrip()
            continue
        if head:
            yield head
        yield from wrap(
            rest, width, initial_indent=_DEEPER, subsequent_indent=f"{_DEEPER}  ",
            break_long_words=False, break_on_hyphens=False,
        )  # fmt: skip
