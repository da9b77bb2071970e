"""Rows of cells in aligned columns."""

from collections.abc import Sequence


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
