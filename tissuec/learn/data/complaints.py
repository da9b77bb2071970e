"""Diagnostics about data, with the file and row, at the place that refers to them."""

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from typing import NoReturn

from msgspec import Struct, field

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Span
from tissuec.script.fit_problem import Data

#: More names would hide the message.
_MOST_NAMED = 30


class Complaints(Struct, frozen=True):
    """All errors of one file.

    Attributes:
        is_alone: Whether it is the only file of its learn block.
    """

    data: Data
    is_alone: bool = True
    found: list[Diagnostic] = field(default_factory=list[Diagnostic])

    @property
    def file(self) -> str:
        return self.data.path.name

    def reject(
        self, code: str, message: str, span: Span | None = None, hint: str = ""
    ) -> NoReturn:
        """Report an error, at the name of the file if no other place is given.

        Args:
            code: Code of the diagnostic.
            message: What is wrong.
            span: Place in the text.
            hint: How to fix it.

        Raises:
            CompileError: Always.
        """
        raise CompileError([Diagnostic(code, message, span or self.data.span, hint)])

    @contextmanager
    def part(self) -> Generator[None]:
        """Collect the errors of one part, and continue with the next."""
        try:
            yield
        except CompileError as error:
            told = {(one.message, one.span) for one in self.found}
            self.found.extend(d for d in error.diagnostics if (d.message, d.span) not in told)

    def settle(self) -> None:
        """Report all errors so far.

        Raises:
            CompileError: There are errors.
        """
        if self.found:
            raise CompileError(self.found)


#: What to do with files of which each has something else.
TWO_MACHINES = (
    "every file needs the columns of all fits; use a learn block for each machine, or, if "
    "both measured one motion, put its rows into one table with empty cells"
)


def first_few(names: Sequence[str]) -> list[str]:
    """Return names for a hint, not more than can be read."""
    return [*names[:_MOST_NAMED], *(["…"] if len(names) > _MOST_NAMED else [])]
