"""Layout: one linear pass that prepares the text for the grammar.

Comments, rows of tables and line ends that do not end a statement become blanks, and brackets
are balanced. The result is as long as the text, so that every offset stays true.
"""

import re
from collections.abc import Iterable
from typing import NamedTuple

from msgspec import Struct, field

from tissuec.core.errors import CompileError, Diagnostic, Edit, Hint, Note, proposal
from tissuec.core.source import Source, Span
from tissuec.lang.characters import CURLY, SUSPECT, odd_character
from tissuec.lang.rows import Comment, Rows, find_rows
from tissuec.lang.words import CONTINUING

#: More problems than this are not reported at once.
MOST_PROBLEMS = 10

#: Levels of brackets. Between two brackets up to eight nodes nest (or, and, not, a comparison,
#: a sum, a product, a sign, a power), and all of them must fit on the stack of a recursion.
DEEPEST = 50

#: Characters of a text; a scene this long is a data file that was opened by mistake.
LONGEST = 200_000_000

_PART = re.compile(
    r'(?P<quote>"[^"\n]*"?)|(?P<comment>#[^\n]*)|(?P<line>\n[ \t\n]*)|(?P<open>[({[])'
    rf"|(?P<close>[)}}\]])|(?P<end>;)"
    r"|(?P<remark>//[^\n]*|/\*[\s\S]*?\*/)"
    rf"|(?P<table>(?<!\w)table(?!\w))|(?P<suspect>{SUSPECT})"
)
# Capital letters too: "Then" is reported as a capitalised "then" and not as a rule without one.
_CONTINUES = re.compile(rf"(?:{'|'.join(CONTINUING)})(?!\w)", re.IGNORECASE)
_TABLE_PLACE = re.compile(r"(?:^|[\n;{}]|\bis[ \t])[ \t]*\Z")
#: A bracket on one line, without others in it, with ";" where a vector has ",".
_PARTED = re.compile(r"\([^()\[\]{}\n=#;]*;[^()\[\]{}\n=#]*\)")
_CLOSING = {"(": ")", "[": "]", "{": "}"}
_CLOSE = 'add "}" at the end of the block'


class Layout(Struct, frozen=True, eq=False):
    """A text made ready for the grammar.

    Attributes:
        text: The text with blanks for all that the grammar need not see, as long as the source.
        comments: Every comment, in order.
        rows: The rows of each table, by the offset of its opening brace.
        problems: What is wrong with characters, quotes and brackets, in order.
    """

    source: Source
    text: str
    comments: tuple[Comment, ...]
    rows: dict[int, Rows]
    problems: tuple[Diagnostic, ...]


class _Opening(NamedTuple):
    """A bracket that waits for its partner.

    Attributes:
        indent: Of its line.
        vector: All of it, where it is a vector with ";" for ",".
    """

    sign: str
    place: int
    indent: int
    vector: re.Match[str] | None = None


def in_order(problems: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return problems by their place in the text."""
    return sorted(problems, key=lambda problem: problem.span.start if problem.span else 0)


def lay_out(source: Source) -> Layout:
    """Return the text made ready for the grammar.

    Raises:
        CompileError: Brackets are too deep, the text is too long, or there are so many
            problems that nothing else can be reported.
    """
    if len(source.text) > LONGEST:
        message = f"the text is longer than {LONGEST // 1_000_000} million characters"
        span = Span(source, 0, 1)
        raise CompileError(
            [Diagnostic("TIS116", message, span, "put bulk data into separate files")]
        )
    return _Scanner(source).scan()


class _Scanner(Struct):
    source: Source
    stack: list[_Opening] = field(default_factory=list[_Opening])
    edits: list[tuple[int, int, str]] = field(default_factory=list[tuple[int, int, str]])
    comments: list[Comment] = field(default_factory=list[Comment])
    rows: dict[int, Rows] = field(default_factory=dict[int, Rows])
    problems: list[Diagnostic] = field(default_factory=list[Diagnostic])
    #: Line ends that become blanks if a joining word follows.
    waiting: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])
    #: Line ends inside round and square brackets, as indices of edits.
    bracketed: list[int] = field(default_factory=list[int])
    table: bool = False  # a table was announced and its brace is still to come
    first: int = 0  # offset of the first character of the line that is no blank
    indent: int = 0
    suspect: _Opening | None = None  # the block that seems to lack its closing brace

    def scan(self) -> Layout:
        text = self.source.text
        place = 0
        while part := _PART.search(text, place):
            handle = getattr(self, f"_{part.lastgroup}")
            place = handle(text, part.start(), part.end()) or part.end()
        self._finish(len(text))
        return Layout(
            self.source,
            self._edited(),
            tuple(self.comments),
            self.rows,
            tuple(in_order(self.problems)),
        )

    # --- one method for each kind of part; a result is where to go on -------------------------

    def _quote(self, text: str, start: int, end: int) -> None:
        if end - start == 1 or text[end - 1] != '"':
            self._open_quote(start, end)
            self._blank(start, end)

    def _comment(self, text: str, start: int, end: int) -> None:
        self.comments.append(Comment(Span(self.source, start, end), text[start:end].rstrip()))
        self._blank(start, end)

    def _line(self, text: str, start: int, end: int) -> None:
        self.first = end
        self.indent = end - text.rfind("\n", start, end) - 1
        if self._in_bracket():
            self.bracketed.append(len(self.edits))
            self._blank(start, end)
            return
        self.waiting.append((start, end))
        if text.startswith("#", end):
            return  # what follows the comments decides
        if _CONTINUES.match(text, end):
            self.edits += (
                (*stretch, " " * (stretch[1] - stretch[0])) for stretch in self.waiting
            )
        else:
            self.table = False
        self.waiting.clear()

    def _open(self, text: str, start: int, end: int) -> int | None:
        sign = text[start]
        if sign == "{":
            self._drop_unclosed()
            if self.table:
                return self._table_rows(text, start, end)
        if len(self.stack) >= DEEPEST:
            message = f"brackets are nested more than {DEEPEST} levels deep"
            hint = 'name a part of it with "let", or close a bracket earlier'
            problem = Diagnostic("TIS116", message, Span(self.source, start, end), hint)
            raise CompileError(in_order([*self.problems, problem]))
        self.stack.append(_Opening(sign, start, self.indent, _PARTED.match(text, start)))
        return None

    def _close(self, text: str, start: int, end: int) -> None:
        sign = text[start]
        if sign == "}":
            self.table = False
            self._drop_unclosed()
        if not self.stack or (sign != "}" and not self._in_bracket()):
            message, hint = f'unmatched "{sign}"', Hint("remove it", Edit(""))
            self._report("TIS102", message, start, end, hint)
            self._blank(start, end, ";" if sign == "}" else " ")
            return
        opening = self.stack.pop()
        if sign != _CLOSING[opening.sign]:
            message = f'this "{sign}" does not close "{opening.sign}"'
            line = Span(self.source, opening.place, start).line
            right = proposal(_CLOSING[opening.sign])
            hint = Hint(f"{right}, which closes the bracket in line {line}", *right.edits)
            self._report("TIS102", message, start, end, hint)
        if sign == "}":
            self._look_at_indentation(start, opening)
        elif not self._in_bracket():
            self.bracketed.clear()

    def _end(self, text: str, start: int, end: int) -> None:
        vector = self.stack[-1].vector if self._in_bracket() else None
        if vector is None:
            self.table = False
            return
        if ";" not in text[vector.start() : start]:
            points = re.sub(r"(?<=[0-9]),(?=[0-9])", ".", vector[0])
            hint = proposal(points.replace(";", ","), Span(self.source, *vector.span()))
            self._report(
                "TIS312", 'use "," between the components of a vector', start, end, hint
            )
        self._blank(start, end, ",")

    def _remark(self, text: str, start: int, end: int) -> None:
        lines = text[start:end].removesuffix("*/")[2:].split("\n")
        remark = "\n".join(f"#{line}" for line in lines)
        line_end = "" if text[end : end + 1] in ("", "\n") else "\n"
        hint = Hint('write "#"', Edit(remark + line_end, Span(self.source, start, end)))
        self._report("TIS312", 'a comment begins with "#"', start, start + 2, hint)
        self._blank(start, end)

    def _table(self, text: str, start: int, _end: int) -> None:
        before = start
        while before and text[before - 1] in " \t":
            before -= 1
        lead = text[max(before - 3, 0) : start]
        if not self._in_bracket() and _TABLE_PLACE.search(lead):
            self.table = True

    def _suspect(self, text: str, start: int, end: int) -> int | None:
        problem = odd_character(Span(self.source, start, end))
        if problem is None:
            return None
        self._add(problem)
        quoted = CURLY.match(text, start)
        if quoted is None:
            self._blank(start, end)
            return None
        self._blank(start, end, '"')
        self._blank(quoted.end() - 1, quoted.end(), '"')
        return quoted.end()

    def _table_rows(self, text: str, start: int, end: int) -> int:
        rows = find_rows(self.source, end)
        place = rows.end
        closed = text.startswith("}", place)
        if not closed:
            place = self._unclosed_table(text, start, end, place)
            rows = rows._replace(
                end=place, comments=tuple(c for c in rows.comments if c.span.start < place)
            )
        if rows.open_quote is not None and rows.open_quote < place:
            self._open_quote(rows.open_quote, text.find("\n", rows.open_quote))
        self.comments += rows.comments
        self.rows[start] = rows
        self._blank(end, place)
        self.table = False
        return place + closed

    def _unclosed_table(self, text: str, start: int, end: int, place: int) -> int:
        """Report a table without a closing brace and return where its rows are taken to end."""
        at_end = place == len(text)
        what = "the file ends" if at_end else "another block begins"
        message = f'a "}}" is missing: {what} within the rows of a table'
        note = self._note("the table begins", _Opening("{", start, 0))
        mark = len(text.rstrip()) if at_end else place
        # The line of the other brace is taken for the head of a block.
        last = place if at_end else max(text.rfind("\n", end, place), end)
        close = Edit("\n}", Span(self.source, last, last))
        self._report("TIS101", message, mark, mark + (not at_end), Hint(_CLOSE, close), note)
        self._blank(start, end, ";")
        return last

    # --- findings -----------------------------------------------------------------------------

    def _open_quote(self, start: int, end: int) -> None:
        message = "unterminated quote"
        end = len(self.source.text) if end < 0 else end
        hint = 'add " at the end of the quoted text'
        if "{" not in (line := self.source.text[start:end].rstrip()):
            hint = Hint(hint, Edit('"', Span(self.source, start + len(line), end)))
        self._report("TIS113", message, start, end, hint)

    def _drop_unclosed(self) -> None:
        """Report round and square brackets that are still open where they no longer can be."""
        unclosed = None
        while self._in_bracket():
            unclosed = self.stack.pop()
        if unclosed is None:
            return
        message = f'this "{unclosed.sign}" is not closed'
        hint = f'add "{_CLOSING[unclosed.sign]}" where the bracket ends'
        self._report("TIS102", message, unclosed.place, unclosed.place + 1, hint)
        # Lines count again, so that the statements below are looked at one by one.
        for index in self.bracketed:
            start, end, _ = self.edits[index]
            self.edits[index] = (start, end, self.source.text[start:end])
        self.bracketed.clear()

    def _look_at_indentation(self, start: int, opening: _Opening) -> None:
        """Suspect a block whose "}" stands under the head of a block around it."""
        if self.suspect or start != self.first or self.indent >= opening.indent:
            return
        if any(outer.indent == self.indent for outer in self.stack):
            self.suspect = opening

    def _finish(self, end: int) -> None:
        self._drop_unclosed()
        if not self.stack:
            return
        missing = [self.suspect] if self.suspect else self.stack[-1:]
        notes = [self._note("the block begins", opening) for opening in missing]
        place = len(self.source.text.rstrip())
        message = 'a "}" is missing: this block is still open at the end of the file'
        hint = _CLOSE if self.suspect else Hint(_CLOSE, Edit("\n}" * len(self.stack)))
        self._report("TIS101", message, place, place, hint, *notes)
        # Beyond the end of the text, so that offsets stay true and nothing else is reported.
        self.edits.append((end, end, "}" * len(self.stack)))

    # --- helpers ------------------------------------------------------------------------------

    def _in_bracket(self) -> bool:
        return bool(self.stack) and self.stack[-1].sign != "{"

    def _blank(self, start: int, end: int, sign: str = " ") -> None:
        self.edits.append((start, end, sign * (end - start)))

    def _note(self, what: str, opening: _Opening) -> Note:
        return Note(what, Span(self.source, opening.place, opening.place + 1))

    def _report(
        self, code: str, message: str, start: int, end: int, hint: str, *notes: Note
    ) -> None:
        self._add(Diagnostic(code, message, Span(self.source, start, end), hint, notes))

    def _add(self, problem: Diagnostic) -> None:
        self.problems.append(problem)
        if len(self.problems) == MOST_PROBLEMS:
            raise CompileError(in_order(self.problems))

    def _edited(self) -> str:
        """Return the text with all edits made."""
        text = self.source.text
        pieces: list[str] = []
        place = 0
        for start, end, replacement in sorted(self.edits):
            pieces += text[place:start], replacement
            place = end
        return "".join((*pieces, text[place:]))
