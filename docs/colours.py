"""Colours of scenes on the site: what the language server tells editors, for Pygments."""

from collections.abc import Iterator
from typing import ClassVar

from pygments.lexer import Lexer
from pygments.lexers import LEXERS
from pygments.token import Comment, Keyword, Name, Number, Punctuation, String, Whitespace

from tissuec.lsp.semantic_tokens import Kind, tokens

__all__ = ["SceneLexer"]  # what Pygments loads of this module

KINDS: dict[Kind, tuple[str, ...]] = {
    "comment": Comment.Single,
    "string": String,
    "number": Number,
    "unit": Number,
    "keyword": Keyword,
    "part": Keyword.Declaration,
    "entry": Name.Attribute,
    "verb": Name.Function,
    "measure": Name.Builtin,
    "word": Name.Constant,
    "name": Name,
    "sign": Punctuation,
}


class SceneLexer(Lexer):
    """Scenes of tissuec, also incomplete ones."""

    name = "tissuec"
    aliases: ClassVar[list[str]] = ["tis"]
    filenames: ClassVar[list[str]] = ["*.tis"]

    def get_tokens_unprocessed(self, text: str) -> Iterator[tuple[int, tuple[str, ...], str]]:
        """Yield the start, the category and the text of each part, blanks included."""
        done = 0
        for start, stop, kind in tokens(text):
            if start > done:
                yield done, Whitespace, text[done:start]
            yield start, KINDS[kind], text[start:stop]
            done = stop
        yield done, Whitespace, text[done:]


def register() -> None:
    """Let Pygments find the lexer by its name, as it finds its own."""
    LEXERS[SceneLexer.__name__] = (
        __name__,
        SceneLexer.name,
        tuple(SceneLexer.aliases),
        tuple(SceneLexer.filenames),
        (),
    )
