"""Files of figures: formats by their endings, the same bytes for the same figure."""

import os
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tissuec.core.errors import TissueError
from tissuec.core.files import replacing
from tissuec.core.printable import printable

if TYPE_CHECKING:
    from tissuec.view.plots import drawing

DPI = 150
#: Formats by the endings of files, and what to leave out of each so that it does not change.
FORMATS: dict[str, dict[str, Any] | None] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".eps": {"Creator": "tissuec"},
    ".pgf": None,
}
#: How formats call the texts of a scene about itself, by the entries of manifests.
_CREDITS = {
    ".png": {
        "title": "Title", "about": "Description", "author": "Author", "licence": "Copyright",
        "laboratory": "Source",
    },
    ".svg": {
        "title": "Title", "about": "Description", "author": "Creator", "licence": "Rights",
        "laboratory": "Publisher",
    },
    ".pdf": {"title": "Title", "about": "Subject", "author": "Author", "licence": "Keywords"},
}  # fmt: skip


def metadata(suffix: str, credits: Mapping[str, str]) -> dict[str, Any]:
    """Return the metadata of a file for ``savefig``.

    Args:
        suffix: Of the file.
        credits: Texts of a scene about itself, by the entries of manifests, and its title.
    """
    names = _CREDITS.get(suffix, {})
    given = {names[key]: printable(text) for key, text in credits.items() if key in names}
    return (FORMATS.get(suffix) or {}) | given


_EPOCH = "SOURCE_DATE_EPOCH"  # the date of EPS, which cannot be left out


def save(figure: "drawing.Figure", path: Path, *, dpi: float = DPI) -> None:
    """Write a figure to a file, in the format of its suffix.

    Args:
        figure: The figure.
        path: The file.
        dpi: Resolution [1/inch].

    Raises:
        TissueError: There is no such format, it cannot hold the figure, or the file cannot be
            written.
    """
    check_suffix(path)
    try:
        with replacing(path) as beside:
            figure.savefig(beside, dpi=dpi)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise TissueError(f'cannot write "{path}": {reason}') from error


def check_suffix(path: Path) -> None:
    """Check that the suffix of a file is a known format.

    Raises:
        TissueError: It does not.
    """
    if path.suffix.lower() not in FORMATS:
        ends = "has no ending" if not path.suffix else f"ends with {path.suffix}"
        *others, last = FORMATS
        raise TissueError(
            f'"{path}" {ends}; the name of a picture must end with {", ".join(others)} or '
            f"{last}"
        )


@contextmanager
def prepared(figure: Any, suffix: str) -> Generator[None]:
    """Fit a figure to a format within the block.

    EPS has neither transparency nor files without a date: colours are mixed with that of the
    paper instead.

    Args:
        figure: matplotlib's figure.
        suffix: Of the file.
    """
    if suffix != ".eps":
        yield
        return
    former = os.environ.get(_EPOCH)
    os.environ[_EPOCH] = former or "0"
    see_through = [one for one in figure.findobj() if _opacity(one) < 1.0]
    opacities = [one.get_alpha() for one in see_through]
    colours = [_mixed(one) for one in see_through]
    try:
        yield
    finally:
        for one, opacity, back in zip(see_through, opacities, colours, strict=True):
            back()
            one.set_alpha(opacity)
        if former is None:
            del os.environ[_EPOCH]


def _opacity(artist: Any) -> float:
    found = artist.get_alpha()
    return float(found) if isinstance(found, int | float) else 1.0


def _mixed(artist: Any) -> Any:
    """Mix the colours of an artist with white; return what undoes it."""
    import numpy as np
    from matplotlib.colors import to_rgb, to_rgba_array

    opacity = _opacity(artist)
    undo: list[tuple[Callable[[Any], object], Any]] = []
    artist.set_alpha(None)
    for name in ("color", "facecolor", "edgecolor"):
        if not hasattr(artist, f"set_{name}") or not hasattr(artist, f"get_{name}"):
            continue
        former = getattr(artist, f"get_{name}")()
        setter = getattr(artist, f"set_{name}")
        if name == "color" and hasattr(artist, "get_facecolor"):
            continue  # of collections: that of both
        try:
            shown = to_rgba_array(former)
        except ValueError:
            continue
        white = np.array(to_rgb("white"))
        mixed = shown.copy()
        mixed[:, :3] = opacity * shown[:, :3] + (1.0 - opacity) * white
        mixed[:, 3] = np.where(shown[:, 3] > 0.0, 1.0, 0.0)
        setter(mixed[0] if len(mixed) == 1 else mixed)
        undo.append((setter, former))

    def back() -> None:
        for setter, colour in undo:
            setter(colour)

    return back
