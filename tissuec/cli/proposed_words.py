"""``tissuec words --from``: Words for the numbers of a tissue, found and shown."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from tissuec.core.data import as_data
from tissuec.core.errors import TissueError
from tissuec.core.hints import did_you_mean
from tissuec.core.names import key_of
from tissuec.core.report import FactTable, Part, Report

if TYPE_CHECKING:
    from tissuec.analysis.proposal import ProposedTissue
    from tissuec.scene.model import AssignedQuantity, Tissue
    from tissuec.scene.resolve import ResolvedProgram

NAME = "proposed tissue"  # of a tissue that is made of numbers


def propose_words(words: "ResolvedProgram", wanted: str, libraries: tuple[Path, ...]) -> Report:
    """Return the words of a vocabulary that come nearest to numbers.

    Args:
        words: The vocabulary.
        wanted: The name of a tissue, or numbers with their names.
        libraries: Further folders of tissues.

    Raises:
        TissueError: There is no such tissue, it has no number, or no rule concludes one.
        CompileError: The numbers cannot be read.
    """
    from tissuec.analysis.proposal import propose

    if "=" in wanted:
        name, rules, numbers, facts = NAME, "", _read(wanted), {}
    else:
        tissue = _find(words, wanted, libraries)
        name, rules = tissue.name, key_of(tissue.vocabulary)
        facts = {fact.property: fact.number for fact in tissue.facts}
        numbers = {key: one for key, one in tissue.given.items() if one.how == "written"}
        if not numbers:
            raise TissueError(
                f"tissue {name} has no written number; its words are: "
                + ", ".join(f"{fact.property} {fact.written}" for fact in tissue.facts)
                + '; give numbers instead, such as --from "Young\'s modulus = 5 kPa"'
            )
    found = propose(words.vocabulary, numbers, rules, facts)
    parts = _parts(found, name, _unsaid(found, numbers))
    return Report(parts, {**as_data(found), "text": found.text(name)})


def _read(text: str) -> "Mapping[str, AssignedQuantity]":
    """Return the numbers of a text such as "Young's modulus = 5 kPa, density = 1 g/cm^3"."""
    from tissuec.core.source import Source
    from tissuec.pipeline import read_words
    from tissuec.scene.request import Request

    entries = "\n".join(part.strip() for part in text.replace(";", ",").split(","))
    source = Source("--from", f"language 1\ntissue {NAME} {{\n{entries}\n}}\n")
    words, _ = read_words(Request(source))
    return words.tissues[NAME].given


def _find(words: "ResolvedProgram", name: str, libraries: tuple[Path, ...]) -> "Tissue":
    """Return a tissue of the file of the vocabulary, of another file, or of the library."""
    from tissuec.core.errors import CompileError
    from tissuec.core.resources import library
    from tissuec.pipeline import read_words
    from tissuec.scene.request import Request

    key = key_of(name)
    known = {} if key not in words.tissues else {key: words.tissues[key]}
    if known:
        return known[key]
    files = [path for path in (Path(name), Path(f"{name}.tis")) if path.is_file()]
    for folder in (*libraries, library()):
        files += sorted((folder / "matter").glob("*.tis")) or sorted(folder.glob("*.tis"))
    for path in files:
        try:
            read, _ = read_words(Request.file(path, libraries=libraries))
        except CompileError:
            continue  # reported where the file is used
        own = {k: one for k, one in read.tissues.items() if one.span.source.name == str(path)}
        if path.stem == Path(name).stem and key not in own and own:
            return next(iter(own.values()))
        known |= {k: one for k, one in own.items() if k not in known}
        if key in known:
            return known[key]
    hint = did_you_mean(key, known) or 'name one that "tissuec library matter" lists'
    raise TissueError(f'there is no tissue "{name}"; {hint}')


def _unsaid(found: "ProposedTissue", numbers: "Mapping[str, AssignedQuantity]") -> list[str]:
    """Return the names of numbers that no rule concludes."""
    said = {key_of(one.quantity) for one in found.numbers}
    return [one.quantity.name for key, one in numbers.items() if key not in said]


def _parts(found: "ProposedTissue", name: str, unsaid: list[str]) -> list[Part]:
    numbers = [
        (
            one.quantity,
            one.shown(one.wanted),
            one.shown(one.found),
            "" if one.ratio is None else f"{one.ratio:.2f}",
        )
        for one in found.numbers
    ]
    words = [
        (
            word.property,
            word.phrase,
            ", ".join(f"{text} {degree:.2f}" for text, degree in word.degrees),
            word.decides,
        )
        for word in found.words
    ]
    parts: list[Part] = [
        FactTable(("number", "wanted", "by the words", "ratio"), numbers, least=(24, 14, 14)),
        "",
        FactTable(("property", "word", "degrees", "decides"), words, least=(18, 20, 28)),
    ]
    if found.left:
        parts.append(f"\nwithout effect on these numbers: {', '.join(found.left)}")
    if unsaid:
        parts.append(f"\nno rule concludes: {', '.join(unsaid)}")
    return [*parts, f"\n{found.text(name)}"]
