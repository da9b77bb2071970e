"""The verdict on a run, in one word, a sign and a sentence."""

from collections.abc import Mapping
from typing import Any, Literal

from msgspec import Struct

from tissuec.results.manifest import RUNNING

Kind = Literal["done", "stopped", "unfinished"]
Tone = Literal["good", "bad", "warned", "open"]
SIGNS: Mapping[Tone, str] = {"good": "✓", "bad": "✗", "warned": "!", "open": "…"}


class Headline(Struct, frozen=True):
    """The headline of a report.

    Attributes:
        tone: Also shown by a colour.
        word: A few words.
        reasons: Why, each with the section of the page that tells more.
    """

    tone: Tone
    word: str
    reasons: tuple[tuple[str, str], ...]

    @property
    def sign(self) -> str:
        """Return the sign that says the same as the colour."""
        return SIGNS[self.tone]


def kind_of(manifest: Mapping[str, Any]) -> Kind:
    """Return whether a run reached its end, failed, or can be resumed."""
    if manifest["finished"]:
        return "done"
    outcome = str(manifest["outcome"])
    is_open = manifest.get("kind") == "interrupted" or outcome.startswith("interrupted")
    return "unfinished" if is_open or outcome == RUNNING else "stopped"
