"""Rows of cells in aligned columns."""

import textwrap
from collections.abc import Iterator, Sequence

_DEEPER = 4 * " "  # before what has no room in its line


def aligned(
    rows: Sequence[Sequence[str]], least: Sequence[int] = (), *, indent: str = ""
) -> list[str]:
    """Return rows in columns that are as wide as their widest cell needs.

    Args:
        rows: Their cells; the last of each row has no column, so it may be as long as it is.
        least: The least width of each column, two blanks to the next one included.
        indent: Written before each row.
    """
    widths = dict(enumerate(least))
    for row in rows:
        for column, cell in enumerate(row[:-1]):
            widths[column] = max(widths.get(column, 0), len(cell) + 2)
    return [
        (indent + "".join(c.ljust(widths.get(n, 0)) for n, c in enumerate(row))).rstrip()
        for row in rows
    ]


def fitted(
    rows: Sequence[Sequence[str]], least: Sequence[int], heads: int, width: int
) -> Iterator[str]:
    """Yield rows in columns, or where these are too wide, with lines for what is behind.

    Args:
        rows: Their cells.
        least: The least width of each column, two blanks to the next one included.
        heads: How many cells of a row stay in columns.
        width: The longest line; only single words may be longer.
    """
    lines = aligned(rows, least)
    if all(len(line) <= width for line in lines):
        yield from lines
        return
    columns = aligned([(*row[:heads], "") for row in rows])
    widest = max(map(len, columns)) + 2
    for row, head in zip(rows, columns, strict=True):
        rest = "  ".join(filter(None, row[heads:]))
        if head and widest + len(rest) <= width:
            yield f"{head.ljust(widest)}{rest}".rstrip()
            continue
        if head:
            yield head
        yield from textwrap.wrap(
            rest, width, initial_indent=_DEEPER, subsequent_indent=f"{_DEEPER}  ",
            break_long_words=False, break_on_hyphens=False,
        )  # fmt: skip
