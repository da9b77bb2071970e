"""``tissuec words``: List the words of a vocabulary and their values."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import (
    Command,
    Settings,
    check_page_name,
    keep_input,
    library_option,
    show_page,
)
from tissuec.cli.completing import shipped_names
from tissuec.core.data import as_data
from tissuec.core.errors import CompileError, TissueError
from tissuec.core.files import write_file
from tissuec.core.hints import did_you_mean
from tissuec.core.names import key_of
from tissuec.core.report import FactSection, FactTable, Part, Report
from tissuec.core.units import Dimension, show

if TYPE_CHECKING:
    from tissuec.analysis.proposal import ProposedTissue
    from tissuec.fuzzy.scale import Axis
    from tissuec.fuzzy.sets import Shape
    from tissuec.scene.model import AssignedQuantity, Tissue
    from tissuec.scene.request import Request
    from tissuec.scene.resolve import ResolvedProgram
    from tissuec.scene.words.phrases import NamedScale
    from tissuec.scene.words.vocabulary import Vocabulary

NAME = "proposed tissue"  # of a tissue that is made of numbers
DEFAULT, OF_MATTER = "fuzzy/soft_tissue", "fuzzy/soft_matter"


@click.command(cls=Command)
@click.argument("vocabulary", required=False, shell_complete=shipped_names("fuzzy"))
@click.option(
    "--explore",
    is_flag=True,
    help="Write a page with a slider for each property that shows the results of the rules.",
)
@click.option(
    "--from",
    "wanted",
    metavar="TISSUE|NUMBERS",
    help="Propose words for the written numbers of a tissue, or for numbers such as "
    '"Young\'s modulus = 5 kPa, density = 1.05 g/cm^3".',
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="File of that page; by default named after the vocabulary.",
)
@click.option("--open", "opens", is_flag=True, help="Open that page in a browser.")
@library_option()
def command(
    settings: Settings, vocabulary: str | None, explore: bool, wanted: str | None,
    output: Path | None, opens: bool, libraries: tuple[Path, ...],
) -> Report:  # fmt: skip
    """List the words of VOCABULARY and their values.

    VOCABULARY is a file, with or without .tis, or the name of a shipped vocabulary; by default
    fuzzy/soft_tissue, and with --from, fuzzy/soft_matter.

    \b
    tissuec words
    tissuec words --from liver
    tissuec words my_words.tis --explore --open
    """
    from tissuec.pipeline import read_words
    from tissuec.scene.program.library import find_words
    from tissuec.scene.request import Request

    if not explore and (output is not None or opens):
        raise click.UsageError("-o and --open need --explore")
    if explore and wanted is not None:
        raise click.UsageError("--explore and --from exclude each other")
    path = find_words(vocabulary or (DEFAULT if wanted is None else OF_MATTER), libraries)
    request = Request.file(path, libraries=libraries)
    if explore:
        return _explore(request, path, output or Path(f"{path.stem}.html"), opens)
    words, warnings = read_words(request)
    if wanted is not None:
        return propose_words(words, wanted, libraries)
    settings.warn(warnings)
    listing = _listing(words.vocabulary)
    return Report(_parts(listing), listing)


def _explore(request: "Request", path: Path, target: Path, opens: bool) -> Report:
    """Write the page that explores a vocabulary, and show it if requested."""
    from tissuec.view.explorer.page import document, render

    check_page_name(target)
    keep_input(target, path)
    page = document(request)
    text = render(page)
    write_file(target, text)
    counts = {name: len(page[name]) for name in ("properties", "quantities")}
    counts["rules"] = sum(len(rules["rules"]) for rules in page["rules"])
    counts["tissues"] = len(page["presets"])
    if opens:
        show_page(target)
    listed = ", ".join(f"{count} {name}" for name, count in counts.items())
    facts = {"file": str(target), "bytes": len(text.encode()), **counts}
    return Report([f"{target}: {listed}"], facts, level="remark")


def _listing(vocabulary: "Vocabulary") -> dict[str, Any]:
    scales = [("property", named) for named in vocabulary.properties.values()]
    scales += [("quantity", scale.named) for scale in vocabulary.quantities.values()]
    return {
        "hedges": list(vocabulary.hedges),
        "scales": [_scale(kind, named) for kind, named in scales],
        "rules": {rules.name: len(rules.spans) for rules in vocabulary.rules.values()},
    }


def _scale(kind: str, named: "NamedScale") -> dict[str, Any]:
    axis = named.scale.axis
    return {
        "kind": kind,
        "name": named.name,
        "from": axis.low,
        "to": axis.high,
        "scale": "log" if axis.log else "linear",
        "place": named.span.place,
        "words": [
            {"word": word, **_meaning(axis, shape, named.dimension)}
            for word, shape in named.scale.words.items()
        ],
    }


def _meaning(axis: "Axis", shape: "Shape", dimension: Dimension) -> dict[str, Any]:
    """Return the value of a word and the range that it can reach, in SI units."""
    means, low, high = axis.value_of(shape), *axis.reach_of(shape)
    shown = [show(value, dimension) for value in (means, low, high)]
    return {"means": means, "from": low, "to": high, "shown": shown}


def _parts(listing: dict[str, Any]) -> list[Part]:
    parts: list[Part] = []
    if listing["hedges"]:
        parts.append(f"hedges: {', '.join(listing['hedges'])}")
    for scale in listing["scales"]:
        log = ", log scale" if scale["scale"] == "log" else ""
        rows: list[tuple[str, str, str]] = []
        for word in scale["words"]:
            means, low, high = word["shown"]
            rows.append((word["word"], means, f"{low} to {high}"))
        table = FactTable(("word", "value", "range"), rows, least=(16, 16))
        title = f"{scale['kind']} {scale['name']}{log}   ({scale['place']})"
        parts.append(FactSection(title, [table]))
    parts += (f"\nrules {name}: {count}" for name, count in listing["rules"].items())
    return parts


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
    parts = _proposed_parts(found, name, _unsaid(found, numbers))
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
    from tissuec.core.resources import library
    from tissuec.pipeline import read_words
    from tissuec.scene.request import Request

    key = key_of(name)
    if key in words.tissues:
        return words.tissues[key]
    known: dict[str, Tissue] = {}
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


def _proposed_parts(found: "ProposedTissue", name: str, unsaid: list[str]) -> list[Part]:
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
