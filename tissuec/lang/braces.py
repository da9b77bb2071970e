"""Where a brace is missing, or one too many: where a text would be indented as it is nested.

Each place that may be meant is tried, and the one that leaves the fewest lines indented
otherwise than their block is taken.
"""

from collections.abc import Iterable, Iterator, Sequence

from msgspec import Struct

from tissuec.lang.tokens import Token

#: More places than this are not tried.
_MOST_TRIED = 12

_NOT_NESTED = 10**9  # worse than any indentation


class _Line(Struct, frozen=True):
    """A line with something on it.

    Attributes:
        stop: Offset after its last character that is no comment.
        end: Offset after its last character.
        braces: The signs and offsets of its braces.
    """

    indent: int
    start: int
    stop: int
    end: int
    braces: tuple[tuple[str, int], ...]

    @property
    def closes(self) -> bool:
        """Return whether it begins with a closing brace."""
        return self.braces[:1] == (("}", self.start),)


class Insertion(Struct, frozen=True):
    """Where a brace is missing.

    Attributes:
        at: Offset at which the block ends.
        text: What is to be inserted there.
        opening: Offset of the brace that begins the block.
    """

    at: int
    text: str
    opening: int


class Nesting:
    """The braces of a text, those that are missing or too many among them.

    Args:
        text: The text.
        tokens: All of it.
    """

    def __init__(self, text: str, tokens: Sequence[Token]):
        self.lines = [*_lines(text, tokens)]

    def missing(self, count: int) -> Iterator[Insertion]:
        """Yield the places of missing closing braces, by indentation.

        Args:
            count: How many are missing.
        """
        for _ in range(count):
            tried = (self._closed_behind(place) for place in self._ends_of_blocks())
            self.lines, place = min(tried, key=lambda pair: _disorder(pair[0]))
            yield place

    def strays(self, count: int) -> Iterator[int]:
        """Yield the offsets of superfluous closing braces, by indentation.

        Args:
            count: How many there are.
        """
        for _ in range(count):
            tried = [(self._without(place), place) for place in self._closing()]
            self.lines, place = min(tried, key=lambda pair: _disorder(pair[0]))
            yield place

    def _ends_of_blocks(self) -> list[int]:
        """Return the lines after which a block may end: the last, and those before misfits."""
        odd = [number - 1 for number in _misfits(self.lines) if number]
        return [len(self.lines) - 1, *odd[:_MOST_TRIED]]

    def _closed_behind(self, number: int) -> tuple[list[_Line], Insertion]:
        """Return the lines with a block closed after one of them, and how."""
        line = self.lines[number]
        owner, opening = _open_behind(self.lines, number)
        same = owner.start == line.start and number < len(self.lines) - 1
        at = line.stop if same else line.end
        blank = "\n" + " " * owner.indent
        place = Insertion(at, " }" if same else f"{blank}}}", opening)
        added = _Line(owner.indent, at, at, at, (("}", at),))
        if same:
            added = _Line(-1, at, at, at, (("}", at),))  # it has no line of its own
        return [*self.lines[: number + 1], added, *self.lines[number + 1 :]], place

    def _closing(self) -> list[int]:
        """Return the closing braces that may be too many, the one that closes nothing first."""
        every = [[at for sign, at in line.braces if sign == "}"] for line in self.lines]
        near = {one for number in _misfits(self.lines) for one in (number, number - 1)}
        odd = [at for number in sorted(near) if number >= 0 for at in every[number]]
        return [_unmatched(self.lines), *odd[:_MOST_TRIED]]

    def _without(self, place: int) -> list[_Line]:
        return [
            _Line(
                line.indent, line.start, line.stop, line.end,
                tuple(brace for brace in line.braces if brace[1] != place),
            )
            for line in self.lines
            if line.braces != (("}", place),) or line.stop > line.start + 1
        ]  # fmt: skip


def _lines(text: str, tokens: Iterable[Token]) -> Iterator[_Line]:
    """Yield the lines of a text; the braces of tables are left out."""
    line: list[Token] = []
    for token in (*tokens, Token("LINE", "", len(text), len(text))):
        if token.type != "LINE":
            line.append(token)
            continue
        shown = [one for one in line if one.type not in ("COMMENT", "REMARK")]
        if shown:
            start = text.rfind("\n", 0, shown[0].start) + 1
            indent = shown[0].start - start
            end = max(one.stop for one in line)
            braces = tuple((one.text, one.start) for one in _braces(shown))
            yield _Line(indent, shown[0].start, shown[-1].stop, end, braces)
        line = []


def _braces(line: Sequence[Token]) -> Iterator[Token]:
    rows = {
        place
        for number, token in enumerate(line)
        if token.type == "ROWS"
        for place in (number - 1, number + 1)
    }
    for number, token in enumerate(line):
        if token.type in ("LBRACE", "RBRACE") and number not in rows:
            yield token


def _open_behind(lines: Sequence[_Line], number: int) -> tuple[_Line, int]:
    """Return the line and the offset of the innermost brace that is open after a line."""
    stack: list[tuple[_Line, int]] = []
    for line in lines[: number + 1]:
        for sign, at in line.braces:
            if sign == "{":
                stack.append((line, at))
            elif stack:
                stack.pop()
    return stack[-1] if stack else (lines[number], lines[number].start)


def _unmatched(lines: Sequence[_Line]) -> int:
    """Return the offset of the first closing brace that closes nothing."""
    depth = 0
    for sign, at in (brace for line in lines for brace in line.braces):
        depth += 1 if sign == "{" else -1
        if depth < 0:
            return at
    raise AssertionError("each closing brace closes something")


def _misfits(lines: Sequence[_Line]) -> list[int]:
    """Return the lines whose indentation does not match their nesting."""
    found: list[int] = []
    stack: list[int] = []  # indents of the lines that open the blocks around
    for number, line in enumerate(lines):
        own = stack[-1] if stack else -1
        fits = line.indent == own if line.closes else line.indent > own
        fits &= bool(stack) or line.indent == 0
        if not fits and line.indent >= 0:
            found.append(number)
        for sign, _ in line.braces:
            if sign == "{":
                stack.append(line.indent)
            elif stack:
                stack.pop()
    return found


def _disorder(lines: Sequence[_Line]) -> int:
    """Return how badly lines are indented for their blocks; braces come first."""
    depth, lowest = 0, 0
    for sign in (sign for line in lines for sign, _ in line.braces):
        depth += 1 if sign == "{" else -1
        lowest = min(lowest, depth)
    return -lowest * _NOT_NESTED + len(_misfits(lines))
