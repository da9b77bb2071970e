"""``tissuec explain``: Show the origin of every number of a scene, or explain a code."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from textwrap import indent
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import (
    DONE,
    Command,
    Settings,
    echo,
    line_width,
    print_json,
    report,
    scene_options,
)
from tissuec.core.columns import aligned, fitted
from tissuec.core.data import as_data
from tissuec.core.errors import TissueError
from tissuec.core.hints import did_you_mean

if TYPE_CHECKING:
    from tissuec.analysis.bodies import BodyProperties
    from tissuec.compiler.compile import Compiled
    from tissuec.compiler.prediction import Prediction
    from tissuec.compiler.provenance import ProvenanceRow
    from tissuec.scene.model import Tissue
    from tissuec.scene.resolved import ResolvedProgram

CODE = re.compile(r"(TIS|W)\d+", re.IGNORECASE)
COLUMNS = (17, 24, 10, 32)  # least widths, so that the tables of most tissues look alike


@click.command(cls=Command)
@click.argument("subject")
@click.option("--tissue", metavar="NAME", help="Explain this tissue only.")
@click.option(
    "--plan",
    "with_plan",
    is_flag=True,
    help="Also show the method, the cost and the skipped parts of the run.",
)
@click.option(
    "--bodies",
    "with_bodies",
    is_flag=True,
    help="Also show the properties of each body as matter: stiffness, mass, waves, "
    "frequencies.",
)
@scene_options
def command(
    settings: Settings, subject: str, tissue: str | None, with_plan: bool, with_bodies: bool,
    overrides: tuple[str, ...], libraries: tuple[Path, ...], strict: bool,
) -> int:  # fmt: skip
    """Show the origin of every number of the scene SUBJECT.

    SUBJECT can also be a code such as TIS104, which is then explained.

    --bodies computes these properties from the net of each body: mass, density, Young's and
    shear modulus, Poisson's ratio, anisotropy, how much too stiff its cells make a solid in
    bending and torsion, wave speeds, breaking length, and the lowest natural frequencies while
    the nodes that are held at 0 s stay held.

    \b
    tissuec explain scene.tis --tissue liver
    tissuec explain scene.tis --bodies --json
    tissuec explain TIS104
    """
    if CODE.fullmatch(subject):
        return _explain_code(subject.upper(), settings)
    from tissuec.pipeline import compile_request, read_words
    from tissuec.scene.request import Request

    request = Request.file(
        Path(subject), overrides=overrides, libraries=libraries, strict=strict
    )
    words, warnings = read_words(request)
    tissues = _chosen(words, tissue)
    plan, bodies = None, None
    if with_plan or with_bodies:
        compiled, warnings = compile_request(request)
        plan = _plan_of(compiled) if with_plan else None
        bodies = _bodies_of(compiled) if with_bodies else None
    if settings.json:
        print_json(_document(words, tissues, plan, bodies))
        return DONE
    report(warnings if settings.verbose else (), settings)
    _print_params(words)
    for one in tissues:
        _print_tissue(one)
    if tissue is None:
        _print_forces(words)
    for body in bodies or ():
        _print_body(body)
    if plan is not None:
        _print_plan(plan)
    return DONE


def _plan_of(compiled: "Compiled") -> "Prediction":
    from tissuec.compiler.prediction import predict  # late: it looks at the engine

    return predict(compiled)


def _bodies_of(compiled: "Compiled") -> "tuple[BodyProperties, ...]":
    from tissuec.analysis.bodies import properties_of  # late: it needs SciPy

    return properties_of(compiled)


def _document(
    words: "ResolvedProgram",
    tissues: "list[Tissue]",
    plan: "Prediction | None",
    bodies: "tuple[BodyProperties, ...] | None",
) -> dict[str, Any]:
    """Return all that is asked for as plain data."""
    from tissuec.compiler.provenance import as_dict

    document = as_dict(words, tissues)
    if plan is not None:
        document["plan"] = as_data(plan)
    if bodies is not None:
        from tissuec.view.summaries import bodies as wording

        document["bodies"] = [wording.as_dict(body) for body in bodies]
    return document


def _chosen(words: "ResolvedProgram", name: str | None) -> "list[Tissue]":
    """Return the tissue asked for; otherwise those that are used, or all where none is."""
    from tissuec.compiler.provenance import used_tissues
    from tissuec.core.names import key_of

    if name is None:
        return used_tissues(words)
    known, key = words.tissues, key_of(name)
    if key not in known:
        hint = did_you_mean(key, known) or f"tissues: {', '.join(known)}"
        raise TissueError(f'there is no tissue "{name}"; {hint}')
    return [known[key]]


def _print_params(words: "ResolvedProgram") -> None:
    from tissuec.compiler.provenance import SET

    for parameter in words.constants.parameters():
        mark = f" ({SET})" if parameter.overridden else ""
        place = parameter.item.span.place
        echo(f"param {parameter.name} = {parameter.value}{mark}   {place}")


def _print_tissue(tissue: "Tissue") -> None:
    from tissuec.compiler.provenance import tissue_rows

    cells = [line for row in tissue_rows(tissue) for line in _cells(row)]
    echo(f"\n{tissue.name:<40}{tissue.span.place}")
    for line in fitted(cells, COLUMNS, 3, line_width(sys.stdout) - 2):
        echo(f"  {line}")
    for name, reason in tissue.gaps.items():
        echo(f"  {name:<17}none: {reason}")


def _print_forces(words: "ResolvedProgram") -> None:
    from tissuec.scene.force_numbers import numbers_of

    for name, force in numbers_of(words.forces).items():
        head = f"force {name}: {force.kind} on {force.acts_on}"
        echo(f"\n{head:<40}{force.place}")
        cells = [
            (entry, given.shown, given.how, given.text, given.place)
            for entry, given in force.entries.items()
        ]
        for line in fitted(cells, COLUMNS, 3, line_width(sys.stdout) - 2):
            echo(f"  {line}")


def _cells(row: "ProvenanceRow") -> Iterator[tuple[str, ...]]:
    """Yield the lines of an entry; the second reason and further ones without its head."""
    if row.kind == "property":  # no rule speaks for it, which leaves a column free
        yield row.name, row.value, row.how, row.reasons[0].place
        return
    head = (row.name, row.value, row.how)
    for reason in row.reasons:
        facts = f"  ({reason.facts})" if reason.facts else ""
        yield *head, reason.said, f"{reason.place}{facts}"
        head = ("", "", "")


def _print_body(body: "BodyProperties") -> None:
    from tissuec.view.summaries import bodies as wording

    echo(f"\n{wording.head(body)}")
    for line in aligned(list(wording.rows(body)), COLUMNS[:2]):
        echo(f"  {line}")
    for note in body.notes:
        echo(f"  note: {note}")


def _print_plan(plan: "Prediction") -> None:
    from tissuec.view.summaries import plan as wording

    echo("\narrays")
    for line in aligned(wording.arrays(plan), (12, 16)):
        echo(f"  {line}")
    sections = (
        (f"method: {plan.method}", wording.method(plan)),
        ("skipped", plan.skipped),
        (wording.cost_title(plan), wording.cost(plan)),
    )
    for title, lines in sections:
        echo(f"\n{title}")
        for line in lines:
            echo(f"  {line}")


def _explain_code(code: str, settings: Settings) -> int:
    from tissuec.core.catalogue import CODES

    if code not in CODES:
        hint = did_you_mean(code, CODES)
        raise TissueError(f'unknown code "{code}"' + (f"; {hint}" if hint else ""))
    entry = CODES[code]
    if settings.json:
        print_json({"code": code, **as_data(entry)})
        return DONE
    before, after = (indent(piece, "    ") for piece in (entry.before, entry.after))
    echo(f"{code}: {entry.title}\n\n{entry.text}")
    echo(f"\ninstead of\n\n{before}\n\nwrite\n\n{after}")
    return DONE
