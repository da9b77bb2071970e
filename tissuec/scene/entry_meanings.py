"""Entries by other words than those of the language: a diameter for a radius, ``E = 5 kPa``."""

import re
from collections.abc import Collection, Iterable

from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean
from tissuec.core.units import (
    DENSITY,
    NUMBER,
    PRESSURE,
    STIFFNESS,
    VISCOSITY,
    Dimension,
    UnitError,
    parse_unit,
)
from tissuec.lang import syntax as s

#: What chooses the value of an entry.
_SIGN = re.compile(r"\s*(?:=|\bis\b)\s*\Z")

#: Entries of meshes and tools by words that other programs have for them.
_MEANT = {
    "centre": "center position location origin middle point",
    "point": "centre center position location origin",
    "normal": "direction facing axis",
    "direction": "normal facing axis",
    "axis": "line shaft",
    "shaft": "axis line",
    "rings": "segments slices divisions",
    "pieces": "segments divisions",
    "sides": "segments around",
    "cell": "spacing resolution size",
}

#: How another size of something round becomes one entry.
_SIZES: dict[str, dict[str, str]] = {
    "radius": dict.fromkeys(("diameter", "thickness", "width", "size", "calibre"), " / 2"),
    "diameter": {"radius": " * 2", **dict.fromkeys(("bore", "calibre", "width", "size"), "")},
    "thickness": {"radius": " * 2", **dict.fromkeys(("diameter", "height", "depth"), "")},
}

#: Quantities of a tissue by the words and letters of other texts, each with its dimension.
_QUANTITIES: dict[str, tuple[tuple[Dimension, str], ...]] = {
    **dict.fromkeys(
        ("stiffness", "k", "c", "modulus", "elastic modulus", "e", "elasticity modulus"),
        ((PRESSURE, "Young's modulus"), (STIFFNESS, "spring constant")),
    ),
    **dict.fromkeys(("damping", "d", "eta", "dashpot"), ((VISCOSITY, "viscosity"),)),
    **dict.fromkeys(("nu", "poisson", "poisson ratio"), ((NUMBER, "Poisson's ratio"),)),
    **dict.fromkeys(("rho", "mass density"), ((DENSITY, "density"),)),
}
#: What is meant where the unit does not say it.
_USUAL = {"stiffness": "spring constant", "damping": "viscosity"}


def left_side(item: s.Assign | s.Sentence | s.Block) -> str:
    """Return the text before the sign of an entry; in --set, with the name of its block."""
    value = item.value if isinstance(item, s.Assign) else item.phrase
    if value is None:
        return item.name.span.text
    written = item.span.source.text[item.span.start : value.span.start]
    return _SIGN.sub("", written)


def quantity_meant(item: s.Assign | s.Sentence) -> str:
    """Return the quantity of a tissue that an entry with another name sets, if it is known."""
    near = did_you_mean(item.name.key, _QUANTITIES).edits
    word = near[0].text if near else item.name.key
    known = _QUANTITIES.get(word, ())
    match item:
        case s.Assign(value=s.Quantity(unit=unit)):
            dimension = _dimension(unit)
        case s.Assign(value=s.Number()):
            dimension = NUMBER
        case _:
            dimension = None
    fitting = (name for one, name in known if one == dimension)
    return next(fitting, _USUAL.get(word, ""))


def _dimension(unit: str) -> Dimension | None:
    try:
        return parse_unit(unit).dimension
    except UnitError:
        return None


def unknown_entry(
    item: s.Assign | s.Sentence | s.Block,
    entries: Iterable[str],
    written: Collection[str] = (),
) -> Hint:
    """Return a hint with the entry that is meant by another word, if any, and with all.

    Args:
        item: What was written.
        entries: Names of the entries that there are.
        written: Names that the block has already.
    """
    known = tuple(entries)
    if meant := _entry_meant(item, [one for one in known if one not in written]):
        return Hint(f"{meant}  entries: {', '.join(known)}", *meant.edits)
    return alternatives(item.name.key, known, what="entries")


def _entry_meant(item: s.Assign | s.Sentence | s.Block, entries: Iterable[str]) -> Hint:
    known, word = tuple(entries), item.name.key
    for entry, others in _SIZES.items():
        if entry in known and word in others and isinstance(item, s.Assign):
            return _sized(item, entry, others[word])
    if word == "label" and "part" in known and isinstance(item, s.Assign):
        sentence = f'part "label {item.value.span.text}"'
        return Hint(f"write {sentence}", Edit(sentence, item.span))
    near = [one for one, words in _MEANT.items() if one in known and word in words.split()]
    if len(near) != 1:
        return Hint("")
    return Hint(f'did you mean "{near[0]}"?', Edit(near[0]))


def _sized(item: s.Assign, entry: str, change: str) -> Hint:
    """Return a hint to write a size of something round as another one.

    Args:
        entry: The name of the other size.
        change: What makes it of the written one; empty if they are the same.
    """
    written = item.value.span.text
    if change and isinstance(item.value, s.Sum):
        written = f"({written})"
    owner = left_side(item).removeprefix(item.name.span.text)
    sentence = f"{entry}{owner} = {written}{change}"
    what = f", {_SHARES[change]} the {item.name.text}" if change else ""
    return Hint(f'write "{sentence}"{what}', Edit(sentence, item.span))


_SHARES = {" / 2": "half", " * 2": "twice"}
