"""Collects diagnostics, so that one run reports many mistakes instead of the first.

Consequences of a mistake are not reported: a name whose declaration is wrong is doubtful, and
uses of it are skipped without a message.
"""

from collections.abc import Generator, Iterable
from contextlib import contextmanager
from typing import NoReturn

from tissuec.core.errors import CompileError, Diagnostic, Note, in_order_of_text
from tissuec.core.hints import did_you_mean, leaving_out
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.lang import syntax as s

LONGEST_NAME = 20  # words
LIMIT = 10  # errors of one run; nobody mends more of them at a time


class Rejected(Exception):
    """Leaves the sentence that was found wrong; its diagnostic is already recorded."""


class Findings:
    """Errors and warnings found so far; the same finding is kept once.

    Attributes:
        failures: Grows with every error and every item that is left out. Where it does not, all
            that was read in between is there.
    """

    def __init__(self) -> None:
        self._found: dict[Diagnostic, None] = {}
        self._notes: tuple[Note, ...] = ()  # on whatever is found now
        self._repeated: dict[tuple[object, ...], str] = {}
        self.failures = 0
        self._doubtful: set[str] = set()
        self._all_are_doubtful = False

    def add(
        self,
        code: str,
        message: str,
        span: Span | None,
        *,
        hint: str = "",
        notes: tuple[Note, ...] = (),
    ) -> None:
        """Record a finding and continue."""
        self.extend([Diagnostic(code, message, span, hint, notes)])

    def extend(self, findings: Iterable[Diagnostic]) -> None:
        """Record findings that were made elsewhere, each once."""
        for finding in findings:
            if self._is_told(finding):
                self.failures += finding.severity == "error"
                continue
            if self._notes:
                finding = replace(finding, notes=(*finding.notes, *self._notes))
            self.failures += finding.severity == "error"
            self._found[finding] = None

    def _is_told(self, finding: Diagnostic) -> bool:
        """Return whether the same was found in an earlier repetition of a statement."""
        span = finding.span
        if span is None or not span.repetition:
            return False
        key = finding.code, span.source, span.start, span.end
        is_first = self._repeated.setdefault(key, span.repetition) == span.repetition
        return not is_first

    def reject(
        self,
        code: str,
        message: str,
        span: Span | None,
        *,
        hint: str = "",
        notes: tuple[Note, ...] = (),
    ) -> NoReturn:
        """Record an error and leave the present item.

        Raises:
            Rejected: Always.
        """
        self.add(code, message, span, hint=hint, notes=notes)
        raise Rejected

    def refuse_second(self, what: str, span: Span, first: Span, *, hint: str = "") -> NoReturn:
        """Reject a statement that says once more what another one said.

        Args:
            what: What both say; an entry is in quotes.
            span: The second statement.
            first: The first statement.
            hint: The way out, if it is another than to remove one of them.

        Raises:
            Rejected: Always.
        """
        hint = hint or leaving_out("remove one of them", span, first)
        notes = (Note("first here", first),)
        self.reject("TIS307", f"{what} is given twice", span, hint=hint, notes=notes)

    def stop(self) -> NoReturn:
        """Leave the present item, whose errors were added before.

        Raises:
            Rejected: Always.
        """
        raise Rejected

    def refuse_entry(
        self, name: s.Name, owner: str, *, hint: str, code: str = "TIS303"
    ) -> NoReturn:
        """Reject the name of an entry that a block does not have.

        Args:
            name: As written.
            owner: The block in messages, such as "a body".
            hint: The way out.
            code: Of the message.

        Raises:
            Rejected: Always.
        """
        self.reject(code, f'"{name.text}" is not an entry of {owner}', name.span, hint=hint)

    @contextmanager
    def item(self) -> Generator[None]:
        """Confine a rejection to one item, so that its neighbours are still checked."""
        try:
            yield
        except Rejected:
            self.failures += 1

    @contextmanager
    def together(self) -> Generator[None]:
        """Leave the present item at the end if anything was wrong or left out in between.

        Raises:
            Rejected: There was an error in between.
        """
        before = self.failures
        yield
        if self.failures > before:
            raise Rejected

    @contextmanager
    def noting(self, message: str, span: Span) -> Generator[None]:
        """Add a note to findings within the block.

        Args:
            message: Of the note.
            span: The second place.
        """
        before = self._notes
        self._notes = (Note(message, span), *before)
        try:
            yield
        finally:
            self._notes = before

    # --- doubtful names -----------------------------------------------------------------------

    def doubt(self, name: s.Name) -> None:
        """Make a name doubtful, because what declares it was found wrong.

        The mistake may be in front of it: of ``bdy vessel { … }`` both "vessel" and the part
        that "bdy" was meant to be are doubtful.
        """
        words = name.key.split(" ")
        self._doubtful.add(words[0])
        for length in range(1, min(len(words), LONGEST_NAME) + 1):
            self._doubtful.add(" ".join(words[-length:]))

    def doubt_all(self) -> None:
        """Make every name doubtful, because what may declare it could not be read."""
        self._all_are_doubtful = True

    def is_doubtful(self, key: str) -> bool:
        """Return whether a name may refer to something that was found wrong."""
        return self._all_are_doubtful or key in self._doubtful

    def pass_over_doubtful(self, key: str) -> None:
        """Leave the present item without a diagnostic if it refers to a doubtful name.

        Raises:
            Rejected: The name is doubtful.
        """
        if self.is_doubtful(key):
            raise Rejected

    def may_be_misspelt(self, part: str) -> bool:
        """Return whether a part of a scene may be there under a name that was found wrong."""
        return self._all_are_doubtful or bool(did_you_mean(part, self._doubtful))

    # --- all of them --------------------------------------------------------------------------

    @property
    def are_many(self) -> bool:
        """Return whether there are too many findings for further hints to be useful."""
        return len(self._found) > 10 * LIMIT

    @property
    def errors(self) -> list[Diagnostic]:
        return [d for d in self._found if d.severity == "error"]

    @property
    def warnings(self) -> list[Diagnostic]:
        return [d for d in self._found if d.severity == "warning"]

    def clear(self) -> None:
        """Forget the findings so far; doubtful names remain so."""
        self._found.clear()

    def raise_errors(self) -> None:
        """Report all errors so far, in the order of the text.

        Raises:
            CompileError: There are errors.
        """
        if self.errors:
            raise CompileError([*in_order_of_text(self.errors)[:LIMIT], *self.warnings])
