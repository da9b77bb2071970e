"""Collects diagnostics, so that one run reports many mistakes instead of the first."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import NoReturn

from tissuec.core.errors import CompileError, Diagnostic, Note
from tissuec.core.source import Span

LIMIT = 10  # further errors of one run are usually echoes of the first


class Rejected(Exception):
    """Leaves the sentence that was found wrong; its diagnostic is already recorded."""


class Findings:
    """Errors and warnings found so far; the same finding is kept once."""

    def __init__(self) -> None:
        self.diagnostics: list[Diagnostic] = []

    def add(
        self,
        code: str,
        message: str,
        span: Span | None,
        *,
        hint: str = "",
        notes: tuple[Note, ...] = (),
    ) -> None:
        """Record a finding and go on."""
        self.extend([Diagnostic(code, message, span, hint, notes)])

    def extend(self, findings: Iterable[Diagnostic]) -> None:
        """Record findings that were made elsewhere, each once."""
        for finding in findings:
            if finding not in self.diagnostics:
                self.diagnostics.append(finding)

    def reject(
        self,
        code: str,
        message: str,
        span: Span | None,
        *,
        hint: str = "",
        notes: tuple[Note, ...] = (),
    ) -> NoReturn:
        """Record an error and leave the present item."""
        self.add(code, message, span, hint=hint, notes=notes)
        raise Rejected

    def stop(self) -> NoReturn:
        """Leave the present item; what is wrong with it has been added."""
        raise Rejected

    @contextmanager
    def item(self) -> Iterator[None]:
        """Confine a rejection to one item, so that its neighbours are still looked at."""
        with suppress(Rejected):
            yield

    @contextmanager
    def together(self) -> Iterator[None]:
        """Leave the present item in the end if anything was found wrong in between."""
        before = len(self.errors)
        yield
        if len(self.errors) > before:
            raise Rejected

    @property
    def errors(self) -> list[Diagnostic]:
        return [d for d in self.diagnostics if d.severity == "error"]

    @property
    def warnings(self) -> list[Diagnostic]:
        return [d for d in self.diagnostics if d.severity == "warning"]

    def raise_errors(self) -> None:
        """Raise a CompileError with all errors so far, in the order of the text, if any."""
        if self.errors:
            ordered = sorted(
                self.errors,
                key=lambda d: (d.span.source.name, d.span.start) if d.span else ("", 0),
            )
            raise CompileError([*ordered[:LIMIT], *self.warnings])
