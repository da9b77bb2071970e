"""The parser of statements, which Lark builds from the grammar files."""

from collections.abc import Iterable
from copy import copy
from functools import lru_cache
from typing import Any

from lark import Lark, UnexpectedToken
from lark.parsers.lalr_analysis import Shift
from lark.parsers.lalr_parser_state import ParserState

from tissuec.core.keeping import recalled
from tissuec.lang import parse_table
from tissuec.lang.parse_table import OPTIONS, grammar_text
from tissuec.lang.tokens import Token

#: Ends a statement in the grammar.
END = Token("$END", "", 0, 0)


def load_parser(builder: object) -> Lark:
    """Return the parser from the shipped table, or else from the cache if there is one.

    Args:
        builder: Has a method for each rule, called as soon as the rule is complete.
    """
    text = grammar_text()
    digest = parse_table.digest(text)
    table = parse_table.read()
    if table["digest"] != digest:
        packed = recalled(f"grammar-{digest}.z", lambda: parse_table.packed(text))
        table = parse_table.unpacked(packed)
    return parse_table.StoredParser(table, builder)


class Refused(Exception):
    """A token is not allowed in its place.

    Attributes:
        place: Its number in the statement.
    """

    def __init__(self, place: int, state: Any):
        super().__init__(place)
        self.place = place
        self._state = state

    @property
    def accepted(self) -> frozenset[str]:
        """Return the types of tokens that are allowed there."""
        return _accepted(self._state)


class StatementParser:
    """Parses one statement after another.

    Args:
        builder: Has a method for each rule, called as soon as the rule is complete.
    """

    def __init__(self, builder: object):
        parser: Any = load_parser(builder)  # whose parts Lark leaves without types
        self._rules = {
            rule: parser.parse_interactive("", start=rule).parser_state.parse_conf
            for rule in OPTIONS["start"]
        }

    def parse(self, statement: Iterable[Token], rule: str = "statement") -> Any:
        """Return the result of the builder for a statement.

        Args:
            statement: Its tokens, and the brace of its block.
            rule: The rule of the grammar.

        Raises:
            Refused: A token, or the end, is not allowed in its place.
        """
        state = _state(self._rules[rule])
        place = _feed(state, statement)
        try:
            return state.feed_token(END, is_end=True)
        except UnexpectedToken:
            raise Refused(place, state) from None

    def accepted(self, beginning: Iterable[Token], rule: str = "statement") -> frozenset[str]:
        """Return the types of tokens that can follow the beginning of a statement.

        Args:
            rule: The rule of the grammar.

        Raises:
            Refused: A token is not allowed in its place.
        """
        state = _state(_without_builder(self._rules[rule]))
        _feed(state, beginning)
        return _accepted(state)


def _state(rule: Any) -> Any:
    begin: Any = ParserState
    return begin(rule, None)


def _feed(state: Any, statement: Iterable[Token]) -> int:
    """Feed tokens, and return how many there are."""
    place = 0
    try:
        for token in statement:
            state.feed_token(token)
            place += 1
    except UnexpectedToken:
        raise Refused(place, state) from None
    return place


def _without_builder(rule: Any) -> Any:
    bare = copy(rule)
    bare.callbacks = {}
    return bare


def _accepted(state: Any) -> frozenset[str]:
    """Return the types of tokens that a state of the parser takes."""
    rule = state.parse_conf
    return _taken(rule.parse_table, rule.end_state, tuple(state.state_stack))


@lru_cache(maxsize=4096)
def _taken(table: Any, end: int, stack: tuple[int, ...]) -> frozenset[str]:
    """Return the types of tokens that can follow what led to a stack of states."""
    kinds = (kind for kind in table.states[stack[-1]] if kind.isupper())
    return frozenset(kind for kind in kinds if _takes(table.states, end, list(stack), kind))


def _takes(states: Any, end: int, stack: list[int], kind: str) -> bool:
    """Return whether a token can follow: rules that it completes must lead to its place."""
    while (step := states[stack[-1]].get(kind)) is not None:
        action, rule = step
        if action is Shift:
            return True
        del stack[len(stack) - len(rule.expansion) :]
        stack.append(states[stack[-1]][rule.origin.name][1])
        if kind == END.type and stack[-1] == end:
            return True
    return False
