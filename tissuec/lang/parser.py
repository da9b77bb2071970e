"""Text to a module of syntax nodes; what is wrong with it becomes diagnostics.

    layout -> Lark, which calls the builder -> Module

After a syntax error the bad statement is left out and parsing goes on behind it, so that one
run reports several mistakes.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import cast

from lark import Lark, UnexpectedInput
from lark.utils import TextSlice

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Source
from tissuec.lang.builder import Builder
from tissuec.lang.classify import classify
from tissuec.lang.grammar import load_parser
from tissuec.lang.heading import check_heading
from tissuec.lang.layout import MOST_PROBLEMS, Layout, in_order, lay_out
from tissuec.lang.mistake import mistake_of
from tissuec.lang.recovery import Statement, resume_after
from tissuec.lang.syntax import Module

# The one parser has one builder, which holds the text that is being parsed.
_LOCK = Lock()
_BUILDER = Builder()


@cache
def lark_parser() -> Lark:
    """Return the one parser, built or loaded when it is first needed."""
    return load_parser(_BUILDER)


def parse(source: Source, *, has_heading: bool = True) -> Module:
    """Return the syntax nodes of a text.

    Args:
        source: A text as :func:`tissuec.lang.characters.normalise` returns it.
        has_heading: Whether the text begins with its language; False for a part of a scene.

    Raises:
        CompileError: The text has mistakes; up to ten are reported, in order.
    """
    layout = lay_out(source)
    with _LOCK, _no_garbage_collection():
        module, problems = _parse(layout, has_heading=has_heading)
    if module is None or problems:
        raise CompileError(in_order(problems)[:MOST_PROBLEMS])
    return module


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Spare the search for cycles: nodes have none, and it takes half of the time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _parse(layout: Layout, *, has_heading: bool) -> tuple[Module | None, list[Diagnostic]]:
    """Return the module, unless a statement had to be left out, and all problems."""
    heading = check_heading(layout.source, layout.text) if has_heading else None
    problems = [*layout.problems, *([heading] if heading else [])]
    text, begin = layout.text, 0
    rule = "items" if heading or not has_heading else "file"
    _BUILDER.begin(layout)
    while len(problems) < MOST_PROBLEMS:
        try:
            module = lark_parser().parse(TextSlice(text, begin, len(text)), start=rule)
        except UnexpectedInput as error:
            mistake = mistake_of(error, lark_parser(), layout.source, text, begin)
            problems += _BUILDER.problems
            _BUILDER.problems.clear()
            if not _is_known(problems, mistake.statement):
                problems.append(classify(mistake))
            text, begin = resume_after(text, mistake.statement)
            rule = "items"
        else:
            return cast(Module, module), problems + _BUILDER.problems
    return None, problems


def _is_known(problems: list[Diagnostic], statement: Statement) -> bool:
    """Return whether something about the statement has been reported already."""
    places = [problem.span for problem in problems]
    places += [note.span for problem in problems for note in problem.notes]
    return any(place and statement.start <= place.start <= statement.end for place in places)
