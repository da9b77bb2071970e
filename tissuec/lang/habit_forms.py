"""Forms of statements that are not part of the language: what describes one, and its pieces."""

from typing import NamedTuple

from tissuec.lang.tokens import NUMBER_PATTERN

NUMBER = rf"-?{NUMBER_PATTERN}"
UNIT = r"(?:[^\W\d]|%)[\w*/·^-]*"
AMOUNT = rf"{NUMBER}(?: ?{UNIT})?"
WORDS = r"[^\W\d]\w*(?: [^\W\d]\w*)*"
UNUSED = r"(?!(?:let|expect|when|if|at|after|from)\b)"  # begins statements of other kinds
VALUE = rf"(?:{AMOUNT}|{WORDS})"
TEXT = r'"[^"]*"'
TIMED = r"^(?:(?:at|after|from|when)\b[^:]*: ?)?"


class Habit(NamedTuple):
    """A form that is not part of the language.

    Attributes:
        form: Regular expression of a statement; its group "wrong" is to be replaced.
        message: What is wrong.
        instead: What replaces it, with the other groups; None where that is not clear.
        hint: What to do; empty for ``write "…"``.
    """

    form: str
    message: str
    instead: str | None = None
    hint: str = ""
