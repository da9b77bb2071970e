"""What the grammar lets stand behind the beginning of a statement, for those who type one."""

from copy import copy
from typing import Any

from lark import UnexpectedInput

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.lang.grammar import tokens
from tissuec.lang.layout import lay_out
from tissuec.lang.parser import lark_parser


def accepted_behind(beginning: str, *, is_heading: bool = False) -> frozenset[str] | None:
    """Return the types of tokens that can follow; None if the beginning itself is wrong.

    A type is that of the grammar, such as ``WORD`` or ``WITH``. All statements have one
    grammar, whatever block they stand in, so that nothing before this one has to be parsed.

    Args:
        beginning: A statement up to some place.
        is_heading: Whether the statement is the first of its file, which says the language.
    """
    try:
        text = lay_out(Source("statement", beginning)).text
    except CompileError:
        return None
    parser = lark_parser()
    untyped: Any = parser  # Lark leaves states of parsing without types
    state = untyped.parse_interactive("", start="file" if is_heading else "items")
    # What the builder would make of the statement is not needed.
    state.parser_state.parse_conf = copy(state.parser_state.parse_conf)
    state.parser_state.parse_conf.callbacks = {}
    try:
        for token in tokens(parser, text, 0, len(text)):
            state.feed_token(token)
    except UnexpectedInput:
        return None
    return frozenset(state.accepts())


def first_token(text: str) -> str:
    """Return the type of the token with which a text begins; empty if it begins with none."""
    try:
        found = next(tokens(lark_parser(), text, 0, len(text)), None)
    except UnexpectedInput:
        return ""
    return found.type if found else ""
