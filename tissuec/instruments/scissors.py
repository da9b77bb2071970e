"""Scissors: what cuts is said with each cut."""

from dataclasses import dataclass

from tissuec.instruments import INSTRUMENTS, Shape


@INSTRUMENTS.member("scissors")
@dataclass(frozen=True, slots=True, eq=False)
class Scissors:
    """Blades that cut where a ``cut`` says; they have no shape of their own."""

    def shapes(self) -> tuple[Shape, ...]:
        return ()
