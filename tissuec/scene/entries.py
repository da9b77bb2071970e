"""Entries of blocks: how each is written, what holds without it, and what it means."""

from collections.abc import Mapping

import numpy as np

from tissuec.core.fields import FileIn, FromTo, Named, OneOf, Point, Real, Several, Whole
from tissuec.core.markdown import code, table
from tissuec.core.units import FREQUENCY, Dimension, describe, show, written_unit
from tissuec.scene.schema import Entry, Kind


def entry_table(entries: Mapping[str, Entry]) -> str:
    """Return a table of the entries of a block."""
    heads = ("entry", "is", "without it", "meaning")
    return table(heads, [_row(entry) for entry in entries.values()])


def _row(entry: Entry) -> tuple[str, ...]:
    about = entry.about[:1].upper() + entry.about[1:]
    return code(form_of(entry)), kind_in_words(entry.kind), default_in_words(entry), about


def form_of(entry: Entry) -> str:
    """Return how an entry is written, such as ``radius = …``."""
    match entry.kind:
        case OneOf():
            return f"{entry.name} is …"
        case Point():
            return f"{entry.name} = (x, y, z)"
        case FromTo():
            return f"{entry.name} from … to …"
        case Several():
            return f"{entry.name} = [x, y, …]"
        case FileIn():
            return f'{entry.name} "…" in mm'
        case Named():
            return f'{entry.name} "…"'
        case _:
            return f"{entry.name} = …"


def kind_in_words(kind: Kind) -> str:
    """Return what can be written for an entry."""
    match kind:
        case Real(dimension, above, at_least, at_most):
            limits = (("above", above), ("at least", at_least), ("at most", at_most))
            return describe(dimension) + "".join(
                f", {word} {_writable(limit, dimension)}"
                for word, limit in limits
                if limit is not None
            )
        case Whole(at_least, at_most):
            most = "" if at_most == Whole().at_most else f" and at most {at_most}"
            return f"a whole number, at least {at_least}{most}"
        case OneOf(words):
            return " or ".join(map(code, words)) if words else "a word"
        case Point(dimension):
            return f"a vector: {describe(dimension)}"
        case FromTo():
            return "two points"
        case Several(dimension, at_least):
            return f"a list of at least {at_least}: {describe(dimension)}"
        case FileIn(dimension):
            return f"a file and its unit: {describe(dimension)}"
        case Named():
            return "a name in quotes"


def default_in_words(entry: Entry) -> str:
    """Return what holds without an entry, as code; "needed", or nothing."""
    if entry.is_required:
        return "needed"
    if entry.default is None or entry.default == "":
        return ""
    if isinstance(entry.default, str):
        return code(entry.default)
    assert isinstance(entry.kind, Real | Whole)
    dimension = entry.kind.dimension if isinstance(entry.kind, Real) else None
    if dimension is None or not np.any(dimension):
        return code(f"{entry.default:g}")
    return code(_writable(entry.default, dimension))


def _writable(value: float, dimension: Dimension) -> str:
    """Return a value as it can stand in a scene, where no number stands before ``1/s``."""
    if dimension == FREQUENCY:
        return f"{value:g} {written_unit(dimension)}"
    return show(value, dimension)
