"""``tissuec explain``"""

import re
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from textwrap import indent
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import (
    DONE,
    Command,
    Settings,
    aligned,
    print_json,
    report,
    scene_options,
)
from tissuec.core.errors import TissueError, did_you_mean
from tissuec.core.units import TIME, show

if TYPE_CHECKING:
    from tissuec.prediction import Prediction
    from tissuec.scene.model import Tissue
    from tissuec.scene.resolve import Words

CODE = re.compile(r"(TIS|W)\d+", re.IGNORECASE)
COLUMNS = (17, 24, 10, 32)  # least widths, so that the tables of most tissues look alike


@click.command(cls=Command)
@click.argument("subject")
@click.option("--tissue", metavar="NAME", help="Explain this tissue only.")
@click.option(
    "--plan",
    "with_plan",
    is_flag=True,
    help="Also say what the run will do, and what it skips.",
)
@scene_options
def command(
    settings: Settings, subject: str, tissue: str | None, with_plan: bool,
    overrides: tuple[str, ...], libraries: tuple[Path, ...], strict: bool,
) -> int:  # fmt: skip
    """Say where every number of the scene SUBJECT comes from.

    SUBJECT may also be a code such as TIS104: then say what it means.
    """
    if CODE.fullmatch(subject):
        return _explain_code(subject.upper(), settings)
    from tissuec.pipeline import Request, compile_request, read_words

    request = Request.file(
        Path(subject), overrides=overrides, libraries=libraries, strict=strict
    )
    words, warnings = read_words(request)
    tissues = _chosen(words, tissue)
    plan = None
    if with_plan:
        from tissuec.prediction import predict  # late: it looks at the engine

        compiled, warnings = compile_request(request)
        plan = predict(compiled)
    if settings.json:
        print_json(_document(words, tissues, plan))
        return DONE
    report(warnings if settings.verbose else (), settings)
    for parameter in words.constants.parameters():
        mark = " (set on the command line)" if parameter.overridden else ""
        place = parameter.item.span.place
        click.echo(f"param {parameter.name} = {parameter.value}{mark}   {place}")
    for one in tissues:
        _print_tissue(one)
    if plan is not None:
        _print_plan(plan)
    return DONE


def _chosen(words: "Words", name: str | None) -> "list[Tissue]":
    """Return the tissue asked for; otherwise those that are used, or all where none is."""
    from tissuec.lang import syntax as s
    from tissuec.lang.walk import walk

    known = words.tissues
    if name is not None:
        key = s.key_of(name)
        if key not in known:
            hint = did_you_mean(key, known) or f"tissues: {', '.join(known)}"
            raise TissueError(f'there is no tissue "{name}"; {hint}')
        return [known[key]]
    used = {
        part.phrase.words[0].key
        for kind in ("body", "joint")
        for declared in words.declarations.of(kind).values()
        for part in walk(declared.item)
        if isinstance(part, s.Sentence) and part.name.key == "tissue" and part.phrase
    }
    return [tissue for key, tissue in known.items() if key in used or not used]


def _document(
    words: "Words", tissues: "list[Tissue]", plan: "Prediction | None"
) -> dict[str, Any]:
    """Return everything explained as plain data."""
    document: dict[str, Any] = {
        "params": {
            p.name: {"value": p.value.amount, "overridden": p.overridden}
            for p in words.constants.parameters()
        },
        "tissues": {tissue.name: _tissue(tissue) for tissue in tissues},
    }
    return document if plan is None else document | {"plan": asdict(plan)}


def _tissue(tissue: "Tissue") -> dict[str, Any]:
    from tissuec.provenance import explain_tissue

    return {
        "place": tissue.span.place,
        "about": tissue.about,
        "facts": {
            f.property: {"written": f.written, "number": f.number, "place": f.span.place}
            for f in tissue.facts
        },
        "quantities": {e.quantity: asdict(e) for e in explain_tissue(tissue)},
        "laws": {
            word: {"law": law.name, "force": law.force.code(), "place": law.span.place}
            for word, law in tissue.laws.items()
        },
        "missing": dict(tissue.missing),
    }


def _print_tissue(tissue: "Tissue") -> None:
    from tissuec.provenance import explain_tissue

    rows: list[tuple[str, ...]] = [
        (fact.property, fact.written, f"{fact.number:.4g}", fact.span.place)
        for fact in tissue.facts
    ]
    for explained in explain_tissue(tissue):
        head = (explained.quantity, explained.shown, explained.how)
        for reason in explained.reasons:
            degree = "" if reason.degree is None else f"{reason.word} {reason.degree:.2f}"
            facts = f"  ({reason.facts})" if reason.facts else ""
            rows.append((*head, degree, f"{reason.place}{facts}"))
            head = ("", "", "")
    rows += ((word, law.name, "", "", law.span.place) for word, law in tissue.laws.items())
    click.echo(f"\n{tissue.name:<40}{tissue.span.place}")
    for line in aligned(rows, COLUMNS):
        click.echo(f"  {line}")
    for name, reason in tissue.missing.items():
        click.echo(f"  {name:<17}none: {reason}")


def _print_plan(plan: "Prediction") -> None:
    click.echo("\narrays")
    rows = [
        (name, " x ".join(map(str, array["shape"])), _bytes(array["bytes"]))
        for name, array in plan.arrays.items()
    ]
    for line in aligned(rows, (12, 16)):
        click.echo(f"  {line}")
    facts = plan.facts
    click.echo(f"\nmethod: {plan.method}\n  because {plan.reason}")
    click.echo(
        f"  fastest motion {facts['omega']:.4g} rad/s, damping ratio {facts['zeta']:.3g}"
    )
    limited = isfinite(facts["limit"])
    limit = f"up to {show(facts['limit'], TIME)}" if limited else "at any size"
    click.echo(f"  steps are stable {limit}")
    click.echo("\nskipped")
    for skip in plan.skipped:
        click.echo(f"  {skip}")
    if isfinite(plan.steps):
        click.echo("\ncost, with steps at that limit (a tolerance may need smaller ones)")
        click.echo(f"  about {plan.steps:.3g} steps, {plan.evaluations:.3g} force evaluations")
        click.echo(
            f"  about {show(plan.seconds, TIME, digits=2)} of stepping, once it is compiled"
        )
    else:
        click.echo("\ncost")
        click.echo("  as many steps as the tolerance asks for")
    click.echo(f"  result file up to {_bytes(plan.bytes)} before compression")


def _bytes(count: int) -> str:
    for size, unit in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if count >= size:
            return f"{count / size:.3g} {unit}"
    return f"{count} bytes"


def _explain_code(code: str, settings: Settings) -> int:
    from tissuec.core.catalogue import CODES

    if code not in CODES:
        hint = did_you_mean(code, CODES)
        raise TissueError(f'there is no code "{code}"' + (f"; {hint}" if hint else ""))
    entry = CODES[code]
    if settings.json:
        print_json({"code": code, **asdict(entry)})
        return DONE
    before, after = (indent(piece, "    ") for piece in (entry.before, entry.after))
    click.echo(f"{code}: {entry.title}\n\n{entry.text}")
    click.echo(f"\ninstead of\n\n{before}\n\nwrite\n\n{after}")
    return DONE
