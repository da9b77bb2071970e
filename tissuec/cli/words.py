"""``tissuec words``: List the words of a vocabulary and their values."""

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
from tissuec.core.files import write_file
from tissuec.core.report import FactSection, FactTable, Part, Report
from tissuec.core.units import Dimension, show

if TYPE_CHECKING:
    from tissuec.fuzzy.axis import Axis
    from tissuec.fuzzy.sets import Shape
    from tissuec.scene.request import Request
    from tissuec.scene.vocabulary import Vocabulary
    from tissuec.scene.words import NamedScale

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
    from tissuec.scene.library import find_words
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
        from tissuec.cli.proposed_words import propose_words

        return propose_words(words, wanted, libraries)
    settings.warn(warnings)
    listing = _listing(words.vocabulary)
    return Report(_parts(listing), listing)


def _explore(request: "Request", path: Path, target: Path, opens: bool) -> Report:
    """Write the page that explores a vocabulary, and show it if so wished."""
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
    """Return what a word stands for and from where to where it can reach, in SI units."""
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
