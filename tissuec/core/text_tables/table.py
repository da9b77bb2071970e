"""A table in a file of text, whose lines and columns messages name."""

from collections.abc import Sequence
from typing import Self

from msgspec import Struct

from tissuec.core.text_tables.columns import Floats, read_columns
from tissuec.core.text_tables.dialect import DELIMITERS, Dialect, cells_of, lines_of
from tissuec.core.text_tables.heads import find_dialect


class TextTable(Struct, frozen=True, eq=False):
    """A table as it was read.

    Attributes:
        file: What messages call the file.
        text: Its text.
        dialect: Names and separators of its columns, and where its rows begin.
    """

    file: str
    text: str
    dialect: Dialect

    @classmethod
    def of(cls, file: str, text: str, delimiters: Sequence[str] = DELIMITERS) -> "Self | None":
        """Return the table in a text; None if there is no line in it.

        Args:
            file: What messages call the file.
            text: The text.
            delimiters: What can separate cells.
        """
        dialect = find_dialect(text, delimiters)
        return None if dialect is None else cls(file, text, dialect)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the columns, or their numbers."""
        return self.dialect.names

    def numbers(self, columns: Sequence[int]) -> Floats:
        """Return the numbers of some columns, as `read_columns` does.

        Args:
            columns: Their places, from 0.

        Returns:
            In the units of the text, NaN for gaps, shape (row, column).

        Raises:
            BadRow: A row or a cell is wrong.
        """
        return read_columns(self.text, self.dialect, columns)

    def cells(self) -> list[list[str]]:
        """Return the cells of all rows as texts."""
        lines = lines_of(self.text, self.dialect.start)
        return [cells_of(line.text, self.dialect.delimiter) for line in lines]

    def line_number(self, row: int) -> int:
        """Return the line, from 1, of a row, from 0.

        Raises:
            IndexError: There is no such row.
        """
        for number, line in enumerate(lines_of(self.text, self.dialect.start)):
            if number == row:
                return self.text.count("\n", 0, line.start) + 1
        raise IndexError(row)

    def place(self, row: int, column: int | None = None) -> str:
        """Return how messages call a row, or a cell of it: ``line 3 of a.csv, column "x"``."""
        line = f"line {self.line_number(row)} of {self.file}"
        return line if column is None else f'{line}, column "{self.names[column]}"'

    def places(self, row: int, other: int) -> str:
        """Return how messages call two rows, the upper one first."""
        first, second = sorted(map(self.line_number, (row, other)))
        return f"lines {first} and {second} of {self.file}"
