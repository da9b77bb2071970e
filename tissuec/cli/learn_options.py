"""Options of ``tissuec learn``."""

from collections.abc import Sequence
from pathlib import Path

from msgspec import Struct


class LearnOptions(Struct, frozen=True):
    """Options of the command.

    Attributes:
        again: The command line that resumes an interrupted fit, by fit problem.
    """

    output: Path | None
    fresh: bool
    anyway: bool
    force: bool
    gradient: bool
    diff: bool
    again: Sequence[str]
