"""What all answers of tables have in common: parts, and the runs that they leave out."""

from collections.abc import Iterable, Iterator
from typing import Generic, TypeVar

from msgspec import Struct

from tissuec.studies.analysis.completed import LeftOut

Part = TypeVar("Part")
MOST_NOTES = 8


class Answer(Struct, Generic[Part], frozen=True, eq=False, kw_only=True):
    """An answer about a measure; as a sequence, it holds its parts.

    Attributes:
        measure: Name of the measure.
        unit: Of the measure.
        parts: Such as quantiles, in their order.
        left_out: Runs that it leaves out.
    """

    measure: str
    unit: str
    parts: tuple[Part, ...]
    left_out: LeftOut

    def lines(self) -> Iterable[str]:
        """Return a line about each part."""
        return map(str, self.parts)

    def remarks(self) -> Iterable[str]:
        """Return remarks besides the runs that are left out."""
        return ()

    def notes(self) -> list[str]:
        """Return the runs that are left out, if there are any, and remarks."""
        found = [str(self.left_out)] if self.left_out.count else []
        remarks = list(self.remarks())
        more = len(remarks) - MOST_NOTES
        return [*found, *remarks[:MOST_NOTES], *([f"and {more} more"] if more > 0 else [])]

    def __iter__(self) -> Iterator[Part]:  # pyright: ignore[reportIncompatibleMethodOverride]  # Struct has none
        return iter(self.parts)

    def __len__(self) -> int:
        return len(self.parts)

    def __getitem__(self, place: int) -> Part:
        return self.parts[place]

    def __repr__(self) -> str:
        return "\n".join([*self.lines(), *self.notes()])
