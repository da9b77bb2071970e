"""From text to a module of syntax nodes; errors become diagnostics.

    layout -> Lark, which calls the builder -> Module

After a syntax error the bad statement is left out and parsing goes on behind it, so that one
run reports several mistakes. Where nothing but units and the sizes of numbers are wrong, the
whole text is parsed once more without them, so that its other mistakes can be found.
"""

import gc
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import cast

from lark import Lark, UnexpectedInput
from lark.utils import TextSlice

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Source, Span
from tissuec.lang.builder import Builder
from tissuec.lang.classify import classify
from tissuec.lang.grammar import load_parser, parsed
from tissuec.lang.layout import MOST_PROBLEMS, Layout, in_order, lay_out
from tissuec.lang.mistake import mistake_of
from tissuec.lang.recovery import Statement, resume_after
from tissuec.lang.syntax import Module
from tissuec.lang.version import check_heading

# The one parser has one builder, which holds the text that is being parsed.
_LOCK = Lock()
_BUILDER = Builder()


#: What is said of numbers that can be read but for their unit or size.
_OF_NUMBERS = frozenset({"TIS104", "TIS119"})


class WrongNumbers(CompileError):
    """A text is right but for some numbers.

    Attributes:
        module: Its syntax nodes; a number that is wrong has the unit "".
    """

    def __init__(self, diagnostics: Iterable[Diagnostic], module: Module):
        super().__init__(diagnostics)
        self.module = module


@cache
def lark_parser() -> Lark:
    """Return the one parser, built or loaded when it is first needed."""
    return load_parser(_BUILDER)


@contextmanager
def reading(layout: Layout) -> Generator[Lark]:
    """Lend the one parser for parts of a text; no one else can parse in the meantime."""
    with _LOCK, _no_garbage_collection():
        _BUILDER.begin(layout)
        yield lark_parser()


def parse(source: Source, *, has_heading: bool = True) -> Module:
    """Return the syntax nodes of a text.

    Args:
        source: A text as :func:`tissuec.lang.characters.normalise` returns it.
        has_heading: Whether the text begins with its language; False for a part of a scene.

    Raises:
        WrongNumbers: Numbers have mistakes, and nothing else.
        CompileError: The text has mistakes; up to ten are reported, in order.
    """
    layout = lay_out(source)
    with _LOCK, _no_garbage_collection():
        module, problems, units = _parse(layout, has_heading=has_heading)
        of_numbers = all(problem.code in _OF_NUMBERS for problem in problems)
        if units and of_numbers and has_heading:
            module = _parse_without(units, layout)
    found = in_order(problems)[:MOST_PROBLEMS]
    if module is None or not of_numbers:
        raise CompileError(found)
    if found:
        raise WrongNumbers(found, module)
    return module


@contextmanager
def _no_garbage_collection() -> Generator[None]:
    """Spare the search for cycles: nodes have none, and it takes half of the time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _parse(
    layout: Layout, *, has_heading: bool
) -> tuple[Module | None, list[Diagnostic], list[Span]]:
    """Return the module, unless a statement had to be left out, all problems, and where words
    stand in place of units.
    """
    heading = check_heading(layout.source, layout.text) if has_heading else None
    problems = [*layout.problems, *([heading] if heading else [])]
    text, begin = layout.text, 0
    rule = "items" if heading or not has_heading else "file"
    units: list[Span] = []
    left_out = False
    _BUILDER.begin(layout)
    while len(problems) < MOST_PROBLEMS:
        try:
            module = parsed(lark_parser(), TextSlice(text, begin, len(text)), rule)
        except UnexpectedInput as error:
            mistake = mistake_of(error, lark_parser(), layout.source, text, begin)
            problems += _BUILDER.problems
            _BUILDER.problems.clear()
            if not _is_known(problems, mistake.statement):
                problems.append(classify(mistake))
                units += [mistake.unit] if mistake.unit else []
            left_out = True
            text, begin = resume_after(text, mistake.statement)
            rule = "items"
        else:
            whole = None if left_out else cast(Module, module)
            return whole, problems + _BUILDER.problems, units
    return None, problems, units


def _parse_without(units: list[Span], layout: Layout) -> Module | None:
    """Return the module of a text without some of its units, if all else can be read."""
    text = layout.text
    for unit in units:
        text = text[: unit.start] + " " * (unit.end - unit.start) + text[unit.end :]
    _BUILDER.begin(layout, unknown={len(text[: unit.start].rstrip()) for unit in units})
    try:
        module = parsed(lark_parser(), text, "file")
    except UnexpectedInput:
        return None
    of_numbers = all(problem.code in _OF_NUMBERS for problem in _BUILDER.problems)
    return cast(Module, module) if of_numbers and not _BUILDER.unknown else None


def _is_known(problems: list[Diagnostic], statement: Statement) -> bool:
    """Return whether something about the statement has been reported already."""
    places = [problem.span for problem in problems]
    places += [note.span for problem in problems for note in problem.notes]
    return any(place and statement.start <= place.start <= statement.end for place in places)
