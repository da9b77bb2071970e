"""From a text to its tree, in one linear pass that also balances brackets."""

import re
from collections.abc import Callable, Iterable
from typing import NamedTuple

from tissuec.core.errors import Diagnostic, Note
from tissuec.core.hints import Edit, Hint, proposal
from tissuec.core.source import Source, Span
from tissuec.lang.braces import Insertion, Nesting
from tissuec.lang.characters import CURLY, SUSPECT, odd_character
from tissuec.lang.rows import find_rows
from tissuec.lang.tokens import Token, tokens, without_odd_characters
from tissuec.lang.tree import Statement, Tree
from tissuec.lang.unopened import head_of
from tissuec.lang.words import CONTINUING

#: More problems than this are not reported at once.
MOST_PROBLEMS = 10

#: Levels of brackets. Between two brackets up to eight nodes nest (or, and, not, a comparison,
#: a sum, a product, a sign, a power), and all of them must fit on the stack of a recursion.
DEEPEST = 50

#: Characters of a text; a scene this long is a data file that was opened by mistake.
LONGEST = 200_000_000

#: Where there are more of them, braces that do not match are not looked for by indentation.
MOST_TOKENS = 20_000
MOST_LOOKED_FOR = 4

_SUSPECT = re.compile(SUSPECT)
_CONTINUING = frozenset(CONTINUING)
#: A bracket on one line, without others in it, with ";" where a vector has ",".
_PARTED = re.compile(r"\([^()\[\]{}\n=#;]*;[^()\[\]{}\n=#]*\)")
_CLOSING = {"(": ")", "[": "]", "{": "}"}
_CLOSE = 'add "}" at the end of the block'


class _Opening(NamedTuple):
    """A bracket that waits for its partner.

    Attributes:
        vector: All of it, where it is a vector with ";" for ",".
    """

    sign: str
    place: int
    vector: re.Match[str] | None = None


def in_order(problems: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return problems by their place in the text."""
    return sorted(problems, key=lambda problem: problem.span.start if problem.span else 0)


def tree_of(source: Source) -> Tree:
    """Return the tree of a text, right or wrong."""
    return _TreeBuilder(source).build()


class _TreeBuilder:
    def __init__(self, source: Source):
        self.source = source
        self.scanned = without_odd_characters(source.text)
        self.tokens: list[Token] = []
        self.statements: list[Statement] = []
        self.problems: list[Diagnostic] = []
        self.is_sound = True
        self.heads: list[Statement] = []
        self.statement = Statement(None, 0)
        self.brackets: list[_Opening] = []
        #: The line end that ends the statement, unless a joining word follows.
        self.line: Token | None = None
        #: Line ends inside round and square brackets, and how many parts precede each.
        self.bracketed: list[tuple[int, Token]] = []
        self.unopened: set[int] = set()  # starts of the heads of blocks without "{"
        self.strays: list[int] = []  # closing braces that close nothing

    def build(self) -> Tree:
        text = self.source.text
        if len(text) > LONGEST:
            message = f"the text is longer than {LONGEST // 1_000_000} million characters"
            self._report("TIS116", message, 0, 1, "put bulk data into separate files")
            self.is_sound = False
        place = 0 if self.is_sound else None
        while place is not None:
            place = self._read(place)
        self._finish(len(text))
        problems = in_order(self.problems)
        return Tree(self.source, self.tokens, self.statements, problems, self.is_sound)

    def _read(self, place: int) -> int | None:
        """Read from a place on; return where to continue if tokens have been skipped."""
        for token in tokens(self.source.text, place, scanned=self.scanned):
            self.tokens.append(token)
            if token.type == "LINE":
                self._line(token)
            elif token.type != "COMMENT":
                if self.line is not None:
                    self._end_line(self.line, token)
                handle = _HANDLERS.get(token.type)
                if handle is None:
                    self.statement.parts.append(token)
                elif (behind := handle(self, token)) is not None:
                    return behind
        return None

    # --- statements ---------------------------------------------------------------------------

    def _end(self, stop: int, following: int) -> Statement:
        """Enter the statement that ends at ``stop``; the next one begins at ``following``."""
        statement = self.statement
        statement.stop = statement.close = stop
        self.statements.append(statement)
        if statement.outer is not None:
            statement.outer.items.append(statement)
        self.statement = Statement(self.heads[-1] if self.heads else None, following)
        return statement

    def _line(self, line: Token) -> None:
        if self._in_bracket():
            self.bracketed.append((len(self.statement.parts), line))
        elif self.line is None:
            self.line = line

    def _end_line(self, line: Token, following: Token) -> None:
        # Capital letters too: "Then" is reported as a capitalised "then".
        if following.text.lower() not in _CONTINUING:
            self._end(line.start, line.start + 1)
        self.line = None

    # --- one method for each type of token; a result is the next place ------------------------

    def open_quote(self, token: Token) -> None:
        hint = 'add " at the end of the quoted text'
        if "{" not in (line := token.text.rstrip()):
            place = Span(self.source, token.start + len(line), token.stop)
            hint = Hint(hint, Edit('"', place))
        self._report("TIS113", "unterminated quote", token.start, token.stop, hint)
        self.statement.parts.append(token)

    def remark(self, token: Token) -> None:
        lines = token.text.removesuffix("*/")[2:].split("\n")
        remark = "\n".join(f"#{line}" for line in lines)
        behind = self.source.text[token.stop : token.stop + 1]
        line_end = "" if behind in ("", "\n") else "\n"
        place = Span(self.source, token.start, token.stop)
        hint = Hint('write "#"', Edit(remark + line_end, place))
        message = 'a comment begins with "#"'
        self._report("TIS312", message, token.start, token.start + 2, hint)

    def character(self, token: Token) -> int | None:
        text, kind, behind = self.source.text, "CHARACTER", None
        if _SUSPECT.match(text, token.start):
            kind = "ODD"
            if text[token.start : token.start + 2] in ("&&", "||"):
                token = Token(token.type, token.text * 2, token.start, token.stop + 1)
                behind = token.stop
            problem = odd_character(Span(self.source, token.start, token.stop))
            if problem is not None:  # nothing of the second of two bars
                self._add(problem)
            if (quoted := CURLY.match(text, token.start)) is not None:
                token = Token("STRING", f'"{quoted[1]}"', *quoted.span())
                self.statement.parts.append(token)
                self.tokens[-1] = token
                return quoted.end()
        self.statement.parts.append(Token(kind, token.text, token.start, token.stop))
        return behind

    def semicolon(self, token: Token) -> None:
        vector = self.brackets[-1].vector if self._in_bracket() else None
        if vector is None:
            self._split_lines()
            self._end(token.start, token.stop)
            return
        if ";" not in self.source.text[vector.start() : token.start]:
            points = re.sub(r"(?<=[0-9]),(?=[0-9])", ".", vector[0])
            hint = proposal(points.replace(";", ","), Span(self.source, *vector.span()))
            message = 'use "," between the components of a vector'
            self._report("TIS312", message, token.start, token.stop, hint)
        self.statement.parts.append(Token("COMMA", ";", token.start, token.stop))

    def open_bracket(self, token: Token) -> None:
        """Enter a round or square bracket."""
        self._push(token)
        self.statement.parts.append(token)

    def close_bracket(self, token: Token) -> None:
        """Leave a round or square bracket."""
        if not self._in_bracket():
            self._unmatched(token)
            self.statement.parts.append(Token("STRAY", token.text, token.start, token.stop))
            return
        self._pop(token)
        self.statement.parts.append(token)
        if not self._in_bracket():
            self.bracketed.clear()

    def open_block(self, token: Token) -> int | None:
        self._drop_unclosed()
        head = self.statement
        if head.is_table:
            return self._table(head, token)
        self._push(token)
        self.heads.append(head)
        self._end(token.start, token.stop).is_head = True
        return None

    def close_block(self, token: Token) -> None:
        self._drop_unclosed()
        head = self.heads.pop() if self.heads else None
        self._end(token.start, token.stop)
        if head is None:
            self._unmatched(token)
            return
        head.close = token.stop
        self.statement.is_behind_block = True
        self._pop(token)

    def _table(self, head: Statement, token: Token) -> int:
        """Enter the rows of a table and return where they end."""
        rows = find_rows(self.source, token.stop)
        place, text = rows.end, self.source.text
        if is_closed := text.startswith("}", place):
            head.is_head = True
        else:
            place = self._unclosed_table(token.start, token.stop, place)
        if rows.open_quote is not None and rows.open_quote < place:
            end = text.find("\n", rows.open_quote)
            quote = rows.open_quote, end if end >= 0 else len(text)
            self.open_quote(Token("OPEN_QUOTE", text[slice(*quote)], *quote))
            head.parts.pop()
        self._end(token.start, place + is_closed).close = place + is_closed
        self.statement.is_behind_block = is_closed
        head.rows = rows._replace(end=place)
        self.tokens.append(Token("ROWS", text[rows.start : place], rows.start, place))
        if is_closed:
            self.tokens.append(Token("RBRACE", "}", place, place + 1))
        return place + is_closed

    def _unclosed_table(self, start: int, end: int, place: int) -> int:
        """Report a table without a closing brace and return where its rows are taken to end."""
        text = self.source.text
        at_end = place == len(text)
        what = "the file ends" if at_end else "another block begins"
        message = f'a "}}" is missing: {what} within the rows of a table'
        note = self._note("the table begins", _Opening("{", start))
        mark = len(text.rstrip()) if at_end else place
        # The line of the other brace is taken for the head of a block.
        last = place if at_end else max(text.rfind("\n", end, place), end)
        close = Edit("\n}", Span(self.source, last, last))
        self._report("TIS101", message, mark, mark + (not at_end), Hint(_CLOSE, close), note)
        return last

    # --- brackets -----------------------------------------------------------------------------

    def _in_bracket(self) -> bool:
        return bool(self.brackets) and self.brackets[-1].sign != "{"

    def _push(self, token: Token) -> None:
        if len(self.brackets) >= DEEPEST and self.is_sound:
            message = f"brackets are nested more than {DEEPEST} levels deep"
            hint = 'name a part of it with "let", or close a bracket earlier'
            self._report("TIS116", message, token.start, token.stop, hint)
            self.is_sound = False
        vector = _PARTED.match(self.source.text, token.start)
        self.brackets.append(_Opening(token.text, token.start, vector))

    def _pop(self, token: Token) -> None:
        opening, sign = self.brackets.pop(), token.text[0]
        if sign != _CLOSING[opening.sign]:
            message = f'this "{sign}" does not close "{opening.sign}"'
            line = Span(self.source, opening.place, token.start).line
            right = proposal(_CLOSING[opening.sign])
            hint = Hint(f"{right}, which closes the bracket in line {line}", *right.edits)
            self._report("TIS102", message, token.start, token.start + 1, hint)

    def _unmatched(self, token: Token) -> None:
        # More would not be reported, so that the search would be in vain.
        is_told = len(self.problems) + len(self.strays) < MOST_PROBLEMS
        if token.text == "}" and is_told and (place := self._unopened_here(token)) is not None:
            self._never_opened(*place, token)
            return
        if token.text == "}" and is_told and (head := self._unopened()) is not None:
            self.unopened.add(head.start)
            self._never_opened(head.parts[0].start, head.parts[-1].stop, token)
            return
        if token.text == "}":
            if len(self.strays) < MOST_PROBLEMS:
                self.strays.append(token.start)  # reported at the end, by all lines
            return
        self._stray(token.text[0], token.start)

    def _never_opened(self, start: int, end: int, token: Token) -> None:
        """Report a block without its opening brace, by the offsets of its head."""
        message = 'a "{" is missing: this block is never opened'
        text = self.source.text[start:end]
        hint = Hint(f"write {text} {{", Edit(" {", Span(self.source, end, end)))
        note = Note("the block ends", Span(self.source, token.start, token.stop))
        self._report("TIS101", message, start, end, hint, note)

    def _unopened_here(self, token: Token) -> tuple[int, int] | None:
        """Return the offsets of a head without a brace at the beginning of the present line."""
        line = self.source.text.rfind("\n", 0, token.start) + 1
        here = [one for one in self.statements if one.parts and one.parts[0].start >= line]
        if not here or here[0].is_head:
            return None
        end = head_of(here[0].parts, self.source.text)
        return None if end is None else (here[0].parts[0].start, end)

    def _stray(self, sign: str, place: int) -> None:
        self._report(
            "TIS102", f'unmatched "{sign}"', place, place + 1, Hint("remove it", Edit(""))
        )

    def _unopened(self) -> Statement | None:
        """Return the last statement that lines below are indented to, without a "{"."""
        written = [one for one in self.statements if one.parts]
        for head, inner in zip(written[-2::-1], written[:0:-1], strict=True):
            is_assignment = any(part.type == "EQUAL" for part in head.parts)
            if head.is_head or is_assignment or head.start in self.unopened:
                continue
            (line, column), (below, further) = self._place(head), self._place(inner)
            if head.outer is inner.outer and line < below and column < further:
                return head
        return None

    def _place(self, statement: Statement) -> tuple[int, int]:
        """Return the line of a statement, as the offset at which it begins, and its indent."""
        start = statement.parts[0].start
        line = self.source.text.rfind("\n", 0, start) + 1
        return line, start - line

    def _drop_unclosed(self) -> None:
        """Report round and square brackets that are still open where they no longer can be."""
        unclosed = None
        while self._in_bracket():
            unclosed = self.brackets.pop()
        if unclosed is None:
            return
        message = f'this "{unclosed.sign}" is not closed'
        hint = f'add "{_CLOSING[unclosed.sign]}" where the bracket ends'
        self._report("TIS102", message, unclosed.place, unclosed.place + 1, hint)
        self._split_lines()

    def _split_lines(self) -> None:
        """Let line ends in brackets end statements, so that each line is read by itself."""
        parts, done = self.statement.parts, 0
        for index, line in self.bracketed:
            following = parts[index].text.lower() if index < len(parts) else ""
            if index > done and following not in _CONTINUING:
                self.statement.parts = parts[done:index]
                self._end(line.start, line.start + 1)
                done = index
        self.statement.parts = parts[done:]
        self.bracketed.clear()

    def _finish(self, end: int) -> None:
        self._drop_unclosed()
        if self.line is not None:
            self._end(self.line.start, self.line.start + 1)
        self._end(end, end)
        for head in self.heads:
            head.close = end
        if not (self.brackets or self.strays) or not self.is_sound:
            return
        number = len(self.strays) + len(self.brackets)
        if number > MOST_LOOKED_FOR or len(self.tokens) > MOST_TOKENS or self.unopened:
            strays, end = self.strays, len(self.source.text.rstrip())
            missing = [
                Insertion(end, "\n}", one.place) for one in self.brackets[:MOST_PROBLEMS]
            ]
        else:
            nesting = Nesting(self.source.text, self.tokens)
            strays = nesting.strays(len(self.strays))
            missing = nesting.missing(len(self.brackets))
        for stray in strays:
            self._stray("}", stray)
        for place in missing:
            self._missing(place)

    def _missing(self, place: Insertion) -> None:
        """Report the end of a block whose closing brace is missing."""
        at_end = place.at == len(self.source.text.rstrip())
        where = "still open at the end of the file" if at_end else "indented up to here"
        message = f'a "}}" is missing: this block is {where}'
        hint = Hint(_CLOSE, Edit(place.text, Span(self.source, place.at, place.at)))
        note = self._note("the block begins", _Opening("{", place.opening))
        self._report("TIS101", message, place.at, place.at, hint, note)

    # --- findings -----------------------------------------------------------------------------

    def _note(self, what: str, opening: _Opening) -> Note:
        return Note(what, Span(self.source, opening.place, opening.place + 1))

    def _report(
        self, code: str, message: str, start: int, end: int, hint: str, *notes: Note
    ) -> None:
        self._add(Diagnostic(code, message, Span(self.source, start, end), hint, notes))

    def _add(self, problem: Diagnostic) -> None:
        if len(self.problems) < MOST_PROBLEMS and self.is_sound:
            self.problems.append(problem)


#: What is done with tokens that are more than a part of their statement.
_HANDLERS: dict[str, Callable[[_TreeBuilder, Token], int | None]] = {
    "OPEN_QUOTE": _TreeBuilder.open_quote,
    "REMARK": _TreeBuilder.remark,
    "CHARACTER": _TreeBuilder.character,
    "SEMICOLON": _TreeBuilder.semicolon,
    "LPAR": _TreeBuilder.open_bracket,
    "LSQB": _TreeBuilder.open_bracket,
    "RPAR": _TreeBuilder.close_bracket,
    "RPAR_UNIT": _TreeBuilder.close_bracket,
    "RSQB": _TreeBuilder.close_bracket,
    "LBRACE": _TreeBuilder.open_block,
    "RBRACE": _TreeBuilder.close_block,
}
