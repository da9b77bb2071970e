"""``tissuec words``"""

from pathlib import Path

import click

from tissuec.cli.common import DONE, Command, Settings, print_json, report
from tissuec.core.units import Dimension, show

DEFAULT = "fuzzy/soft_tissue"


@click.command(cls=Command)
@click.argument("vocabulary", default=DEFAULT)
def command(settings: Settings, vocabulary: str) -> int:
    """List the words of VOCABULARY, and the numbers they stand for.

    VOCABULARY is a file, or the name of a shipped one such as fuzzy/soft_tissue.
    """
    from tissuec.core import resources
    from tissuec.pipeline import Request, read_words

    path = Path(vocabulary)
    if not path.is_file():
        shipped = resources.library() / f"{vocabulary.removesuffix('.tis')}.tis"
        path = shipped if shipped.is_file() else path
    words, warnings = read_words(Request.file(path))
    report(warnings, settings)
    listing = _listing(words.vocabulary)
    if settings.json:
        print_json(listing)
    else:
        _print(listing)
    return DONE


def _listing(vocabulary) -> dict:
    scales = [("property", named) for named in vocabulary.properties.values()]
    scales += [("quantity", scale.named) for scale in vocabulary.quantities.values()]
    return {
        "hedges": list(vocabulary.hedges),
        "scales": [_scale(kind, named) for kind, named in scales],
        "rules": {rules.name: len(rules.spans) for rules in vocabulary.rules.values()},
    }


def _scale(kind: str, named) -> dict:
    axis = named.scale.axis
    return {
        "kind": kind,
        "name": named.name,
        "from": axis.low,
        "to": axis.high,
        "scale": "log" if axis.log else "linear",
        "place": named.span.place,
        "words": [
            {
                "word": word,
                "means": axis.value_of(shape),
                "from": axis.from_scale(max(shape.support[0], axis.bounds[0])),
                "to": axis.from_scale(min(shape.support[1], axis.bounds[1])),
                "shown": _shown(axis, shape, named.dimension),
            }
            for word, shape in named.scale.words.items()
        ],
    }


def _shown(axis, shape, dimension: Dimension) -> list[str]:
    low, high = (
        axis.from_scale(min(max(end, axis.bounds[0]), axis.bounds[1])) for end in shape.support
    )
    return [show(value, dimension) for value in (axis.value_of(shape), low, high)]


def _print(listing: dict) -> None:
    if listing["hedges"]:
        click.echo(f"hedges: {', '.join(listing['hedges'])}")
    for scale in listing["scales"]:
        log = ", log scale" if scale["scale"] == "log" else ""
        click.echo(f"\n{scale['kind']} {scale['name']}{log}   ({scale['place']})")
        click.echo(f"  {'word':<16}{'stands for':<16}can mean")
        for word in scale["words"]:
            means, low, high = word["shown"]
            click.echo(f"  {word['word']:<16}{means:<16}{low} to {high}")
    for name, count in listing["rules"].items():
        click.echo(f"\nrules {name}: {count}")
