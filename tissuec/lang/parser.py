"""From text to a module of syntax nodes; errors become diagnostics.

    tree -> Lark, statement by statement, which calls the builder -> Module

A statement with a syntax error is left out, so that one run reports several mistakes. Where
nothing but units and the sizes of numbers are wrong, statements are parsed without them.
"""

import gc
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from threading import Lock
from typing import Any

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Source, Span
from tissuec.lang.builder import Builder, with_items, with_rows
from tissuec.lang.grammar import Refused, StatementParser
from tissuec.lang.known_statements import KnownStatements, key_of_tokens
from tissuec.lang.mistake import ENDS, Mistake
from tissuec.lang.syntax import Block, Item, Module, Number, Sentence
from tissuec.lang.tokens import Token
from tissuec.lang.tree import Statement, Tree
from tissuec.lang.tree_builder import MOST_PROBLEMS, in_order, tree_of
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
def statement_parser() -> StatementParser:
    """Return the one parser, built or loaded when it is first needed."""
    return StatementParser(_BUILDER)


def parse(source: Source, *, has_heading: bool = True) -> Module:
    """Return the syntax nodes of a text.

    Args:
        source: A text as :func:`tissuec.lang.characters.normalise` returns it.
        has_heading: Whether the text begins with its language; False for a part of a scene.

    Raises:
        WrongNumbers: Numbers have mistakes, and nothing else.
        CompileError: The text has mistakes; up to ten are reported, in order.
    """
    tree = tree_of(source)
    return parse_tree(tree, has_heading=has_heading)


def parse_tree(
    tree: Tree, *, has_heading: bool = True, known: KnownStatements | None = None
) -> Module:
    """Return the syntax nodes of a text.

    Args:
        has_heading: Whether the text begins with its language.
        known: Statements that were parsed before, to which those of this text are added.

    Raises:
        WrongNumbers: Numbers have mistakes, and nothing else.
        CompileError: The text has mistakes; up to ten are reported, in order.
    """
    parser = _TreeParser(tree, list(tree.problems), known)
    if not tree.is_sound or parser.is_full:
        raise CompileError(tree.problems)
    with _LOCK, _no_garbage_collection():
        module = parser.module(has_heading=has_heading)
    found = in_order(parser.problems)[:MOST_PROBLEMS]
    if parser.left_out or any(problem.code not in _OF_NUMBERS for problem in found):
        raise CompileError(found)
    if found:
        raise WrongNumbers(found, module)
    return module


def readable_part(tree: Tree, known: KnownStatements | None = None) -> Module:
    """Return the syntax nodes of a text; statements with mistakes are left out.

    Args:
        known: Statements that were parsed before, to which those of this text are added.
    """
    if not tree.is_sound:
        return _module((), tree.source)
    with _LOCK, _no_garbage_collection():
        return _TreeParser(tree, None, known).module(has_heading=True)


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


def _module(items: tuple[Item, ...], source: Source) -> Module:
    return Module(Number(1.0, Span(source, 0, 0)), items, source)


class _TreeParser:
    """One pass over the statements of a tree.

    Attributes:
        problems: What is wrong with the text; None if not needed.
        left_out: How many statements could not be read.
    """

    def __init__(
        self, tree: Tree, problems: list[Diagnostic] | None, known: KnownStatements | None
    ):
        self.tree, self.known = tree, known
        self.is_silent = problems is None
        self.problems: list[Diagnostic] = problems or []
        self.left_out = 0

    @property
    def is_full(self) -> bool:
        return len(self.problems) >= MOST_PROBLEMS

    def module(self, *, has_heading: bool) -> Module:
        items = self.tree.items
        version = None
        if has_heading and (heading := self._heading(items)) is not None:
            items = items[items.index(heading) + 1 :]
            version = self._parsed(heading, "heading")
        module = _module(self._items(items), self.tree.source)
        return module if version is None else Module(version, module.items, module.source)

    def _heading(self, items: Sequence[Statement]) -> Statement | None:
        """Return the statement of the language, if it is right so far."""
        first = next((one for one in items if one.readable or one.is_head), None)
        later = next((one for one in items if one is not first and one.is_language), None)
        problem = check_heading(self.tree.source, first, later)
        if problem is not None:
            self.problems.append(problem)
        return first if problem is None else None

    def _items(self, statements: Iterable[Statement]) -> tuple[Item, ...]:
        items: list[Item] = []
        known = 0  # how many were left out before the last statement
        for statement in statements:
            if self.is_full or not (statement.is_head or statement.readable):
                continue
            # After a mistake, a brace may end another block than it seems.
            must_end = statement.is_behind_block and self.left_out == known
            known = self.left_out
            node = self._parsed(statement, "statement", must_end=must_end)
            inner = self._items(statement.items)
            if node is None:
                continue
            if statement.rows is not None:
                node = with_rows(node, statement.rows, statement.close)
            elif statement.is_head:
                node = with_items(node, inner, statement.close)
            items.append(node)
        return tuple(items)

    def _parsed(self, statement: Statement, rule: str, *, must_end: bool = False) -> Any:
        """Return the node of a statement, or of the head of a block; None if it is wrong.

        Args:
            rule: The rule of the grammar.
            must_end: Whether nothing is allowed there.
        """
        _BUILDER.begin(self.tree.source)
        try:
            node = self._node(statement, rule)
            if must_end and not self.is_silent:
                node = self._mistaken(statement, 0, ENDS)
            elif _lists_outside_of_script(node, statement):
                node = None if self.is_silent else self._misplaced_list(statement)
        except Refused as refused:
            place, accepted = (0, ENDS) if must_end else (refused.place, refused.accepted)
            node = None if self.is_silent else self._mistaken(statement, place, accepted)
        self.problems += _BUILDER.problems
        self.left_out += node is None
        return node

    def _misplaced_list(self, statement: Statement) -> Any:
        """Report names in a list where only an order can have them."""
        sentence = statement.sentence
        place = next(k for k, token in enumerate(sentence) if token.type == "LSQB")
        accepted = statement_parser().accepted(sentence[:place], "statement")
        return self._mistaken(statement, place, accepted - {"LSQB"})

    def _node(self, statement: Statement, rule: str) -> Any:
        """Return the syntax node of a statement, parsed unless an equal one is known."""
        sentence, source = statement.sentence, self.tree.source
        if self.known is None:
            return statement_parser().parse(sentence, rule)
        key = rule, key_of_tokens(sentence)
        node = self.known.recall(key, sentence, source)
        if node is None:
            node = statement_parser().parse(sentence, rule)
            if not _BUILDER.problems:
                self.known.keep(key, sentence, node)
        return node

    def _mistaken(self, statement: Statement, place: int, accepted: frozenset[str]) -> Any:
        """Report the mistake of a statement; return its node if only a unit is wrong.

        Args:
            place: How many of its tokens precede the wrong one.
            accepted: Types of tokens that are allowed there.
        """
        mistake = Mistake.at(statement, self.tree.source, place, accepted)
        if self._is_known(statement):
            return None
        from tissuec.lang.classify import classify  # dozens of patterns, for errors only

        self.problems.append(classify(mistake))
        if mistake.unit is None:
            return None
        unit, known = mistake.unit, _BUILDER.problems
        kept = [
            one for one in statement.sentence if one.start < unit.start or one.stop > unit.end
        ]
        _BUILDER.begin(self.tree.source, unknown=[mistake.before[-1].stop])
        with suppress(Refused):
            node = statement_parser().parse(kept)
            if not _BUILDER.unknown:
                return node
        _BUILDER.problems = known
        return None

    def _is_known(self, statement: Statement) -> bool:
        """Return whether something about the statement has been reported already."""
        problems = [*self.problems, *_BUILDER.problems]
        places = [problem.span for problem in problems]
        places += [note.span for problem in problems for note in problem.notes]
        return any(p and statement.start <= p.start <= statement.stop for p in places)


def _lists_outside_of_script(node: Any, statement: Statement) -> bool:
    """Return whether a sentence names a union, as ``fix [A, B]`` does, and is no order."""
    if not isinstance(node, Sentence | Block) or not node.name.listed:
        return False
    return all(head.words[:1] != ["script"] for head in statement.chain)


# --- for those who type -----------------------------------------------------------------------


def accepted_behind(
    beginning: Iterable[Token], *, is_heading: bool = False
) -> frozenset[str] | None:
    """Return the types of tokens that can follow; None if the beginning itself is wrong.

    A type is that of the grammar, such as ``WORD`` or ``WITH``. All statements have one
    grammar, whatever block they are in, so that nothing before this one has to be parsed.

    Args:
        beginning: A statement up to some place.
        is_heading: Whether the statement is the first of its file, which says the language.
    """
    try:
        return statement_parser().accepted(beginning, "heading" if is_heading else "statement")
    except Refused:
        return None
