"""What completion proposes."""

from msgspec import Struct


class Proposal(Struct, frozen=True):
    """A proposed replacement of a part of the text.

    Attributes:
        kind: What a term is coloured as, or a kind of names; "unit", "file", "keyword".
        insert: What is typed.
        detail: One line.
        about: Markdown.
        rank: Small ones first.
    """

    label: str
    kind: str
    insert: str
    start: int
    stop: int
    detail: str = ""
    about: str = ""
    rank: int = 0
