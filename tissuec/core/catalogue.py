"""What each code of a message means: ``codes.toml`` as values and as a page of the manual."""

import textwrap
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from msgspec import Struct

_FILE = Path(__file__).with_name("codes.toml")
_HERE = "<here>"
_MOST_IN_A_LINE = 96


class CodeEntry(Struct, frozen=True):
    """One code.

    Attributes:
        title: The kind of mistake in a few words.
        text: What it means, why it is refused, and what to do.
        before: A piece of text that earns the code.
        after: The same without the mistake.
        frame: The rest of the scene around the piece, which replaces ``<here>``. Without
            that mark the piece belongs on the command line; empty if the piece is a whole text.
        frame_name: What the frame is called; empty without one.
    """

    title: str
    text: str
    before: str
    after: str
    frame: str = ""
    frame_name: str = ""

    def whole(self, piece: str) -> str:
        """Return the whole text around a piece, such as ``before``."""
        if not self.frame:
            return f"{piece}\n"
        lines = (
            "\n".join(line.replace(_HERE, part) for part in piece.splitlines())
            if _HERE in line
            else line
            for line in self.frame.splitlines()
        )
        return "\n".join(lines) + "\n"

    def override(self, piece: str) -> str | None:
        """Return the argument of ``--set`` for ``piece``; None if it belongs in the text."""
        if not self.frame or _HERE in self.frame:
            return None
        return piece.removeprefix("--set").strip().strip('"')


@cache
def _document() -> Mapping[str, Any]:
    return tomllib.loads(_FILE.read_text(encoding="utf-8"))


@cache
def _entry(code: str) -> CodeEntry:
    written = _document()[code]
    name = written.get("frame", "")
    frame = _document()["frames"][name].strip() if name else ""
    parts = {name: written[name].strip() for name in ("title", "text", "before", "after")}
    return CodeEntry(**parts, frame=frame, frame_name=name)


class _Codes(Mapping[str, CodeEntry]):
    """The entries by code, read when first needed."""

    def __getitem__(self, code: str) -> CodeEntry:
        if code not in set(self):
            raise KeyError(code)
        return _entry(code)

    def __iter__(self) -> Iterator[str]:
        return (name for name in _document() if name not in ("frames", "files"))

    def __len__(self) -> int:
        return sum(1 for _ in self)


CODES: Mapping[str, CodeEntry] = _Codes()


def example_files() -> Mapping[str, str]:
    """Return the files beside the scene of every example, by relative path."""
    return _document()["files"]


def reference() -> str:
    """Return the page of the manual that lists every code."""
    parts = [_INTRODUCTION]
    for code, entry in CODES.items():
        parts.append(f"## {code}: {entry.title}\n\n{_wrapped(entry.text)}")
        parts.append(f"{_place(entry)}, instead of\n\n```tis\n{entry.before}\n```")
        parts.append(f"write\n\n```tis\n{entry.after}\n```")
    parts.append(_SURROUNDINGS)
    for name, frame in _document()["frames"].items():
        text = frame.strip().replace(_HERE, HERE_IN_PAGE)
        parts.append(f"### Scene {name}\n\n```tis\n{text}\n```")
    for name, text in example_files().items():
        parts.append(f"### File {name}\n\n```text\n{text.strip()}\n```")
    return "\n\n".join(parts) + "\n"


def _place(entry: CodeEntry) -> str:
    """Return where the pieces of an entry belong, for the page."""
    if not entry.frame:
        return "As a file of its own"
    scene = f"[scene `{entry.frame_name}`](#scene-{entry.frame_name})"
    return f"In the {scene}" if _HERE in entry.frame else f"On the command line of the {scene}"


#: What replaces ``<here>`` on the page.
HERE_IN_PAGE = "# here"
_SURROUNDINGS = f"""## Scenes of the examples

To try an example, copy the scene that it belongs to into a file, with the example in place of
`{HERE_IN_PAGE}`. The files that examples name follow the scenes."""
_INTRODUCTION = """# Messages

Every message has a code that stays the same between releases. Codes that begin with TIS are
errors: the scene cannot run. Codes that begin with W are warnings: the scene can run, but may
not do what you intend; `--strict` treats them as errors. `tissuec explain TIS104` prints the
explanation below. Each example is a part of one of the
[scenes at the end](#scenes-of-the-examples).

One run shows up to ten mistakes of a scene, and omits those that only follow from another
mistake. If the text cannot be parsed, only mistakes of syntax are reported."""


def _wrapped(text: str) -> str:
    return textwrap.fill(text, _MOST_IN_A_LINE)
