"""The parser that Lark builds from the grammar files, kept on disk between runs."""

from collections.abc import Iterator
from hashlib import sha256
from typing import Any, cast

import lark
from lark import Lark, Token
from lark.lexer import Lexer, LexerThread
from lark.utils import TextSlice

from tissuec.core.resources import cache_folder, grammar
from tissuec.core.units import unit_pattern
from tissuec.lang.words import JOINING_WORDS, TIME_WORDS

_FILES = ("common.lark", "rules.lark", "tissue.lark")

#: What Lark is asked for. "items" is where parsing goes on after a mistake.
OPTIONS: dict[str, Any] = {
    "parser": "lalr",
    "lexer": "basic",
    "start": ["file", "items"],
    "maybe_placeholders": True,
}


def grammar_text() -> str:
    """Return the whole grammar, with units and reserved words put in."""
    text = "\n".join(grammar(name).read_text(encoding="utf-8") for name in _FILES)
    text = text.replace("@UNIT@", unit_pattern().replace("/", r"\/"))
    for mark, words in (("@TIME@", TIME_WORDS), ("@JOIN@", JOINING_WORDS)):
        text = text.replace(mark, " | ".join(f'"{word}"' for word in words))
    return text


def load_parser(builder: object) -> Lark:
    """Return the parser, from the cache if there is one.

    Args:
        builder: Has a method for each rule, called as soon as the rule is complete.
    """
    text = grammar_text()
    folder = cache_folder()
    if folder is None:
        return Lark(text, transformer=builder, **OPTIONS)
    digest = sha256(f"{text}{OPTIONS}{lark.__version__}".encode()).hexdigest()[:16]
    # Lark builds anew where the file is missing, half written or corrupt.
    path = folder / f"grammar-{digest}.lark-cache"
    return Lark(text, transformer=builder, cache=str(path), **OPTIONS)


def parsed(parser: Lark, text: str | TextSlice[str], start: str) -> Any:
    """Return the result of the transformer of a parser for a text.

    Args:
        parser: With a transformer.
        text: What is parsed.
        start: The rule to begin with.

    Raises:
        lark.UnexpectedInput: The text is not one of the rule.
    """
    untyped: Any = parser
    return untyped.parse(text, start=start)


def tokens(parser: Lark, text: str, start: int, end: int) -> Iterator[Token]:
    """Yield the tokens of a part of a text that was laid out for the grammar.

    Args:
        parser: The parser.
        text: The text.
        start: First character of the part.
        end: End of the part.

    Raises:
        lark.UnexpectedCharacters: A character begins no token.
    """
    built: Any = parser  # whose parts Lark leaves without types
    threads: Any = LexerThread
    lexer = cast(Lexer, built.parser.lexer)
    return threads.from_text(lexer, TextSlice(text, start, end)).lex(None)
