"""``tissuec explain``"""

import re
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import DONE, Command, Settings, print_json, report, scene_options
from tissuec.core.errors import TissueError, did_you_mean
from tissuec.core.units import TIME, show

if TYPE_CHECKING:
    from tissuec.prediction import Prediction
    from tissuec.provenance import Explained
    from tissuec.scene.model import Tissue

CODE = re.compile(r"(TIS|W)\d{3}", re.IGNORECASE)


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
    """Say where every number of the scene SUBJECT comes from, or what a code such as TIS104 means."""
    if CODE.fullmatch(subject):
        return _explain_code(subject.upper(), settings)
    from tissuec.pipeline import Request, compile_request, read_words

    request = Request.file(
        Path(subject), overrides=overrides, libraries=libraries, strict=strict
    )
    words, warnings = read_words(request)
    tissues = _chosen(words, tissue)
    document: dict[str, Any] = {
        "params": {
            p.name: {"value": p.value.amount, "overridden": p.overridden}
            for p in words.constants.parameters()
        },
        "tissues": {t.name: _tissue(t) for t in tissues},
    }
    plan = None
    if with_plan:
        from tissuec.prediction import predict

        compiled, warnings = compile_request(request)
        plan = predict(compiled)
        document["plan"] = asdict(plan)
    if settings.json:
        print_json(document)
        return DONE
    report(warnings if settings.verbose else (), settings)
    for parameter in words.constants.parameters():
        mark = " (set on the command line)" if parameter.overridden else ""
        click.echo(
            f"param {parameter.name} = {parameter.value}{mark}   {parameter.item.span.place}"
        )
    for one in tissues:
        _print_tissue(one)
    if plan is not None:
        _print_plan(plan)
    return DONE


def _chosen(words: Any, name: str | None) -> "list[Tissue]":
    """Return the tissue asked for; otherwise those that bodies use, or all without bodies."""
    known: dict[str, Tissue] = words.tissues
    if name is not None:
        key = " ".join(name.lower().split())
        if key not in known:
            hint = did_you_mean(key, known) or f"tissues: {', '.join(known)}"
            raise TissueError(f'there is no tissue "{name}"; {hint}')
        return [known[key]]
    from tissuec.lang.syntax import Block, Sentence

    used: set[str] = set()
    for declared in words.declarations.of("body").values():
        items = list(declared.item.items) if isinstance(declared.item, Block) else []
        items += [inner for item in items if isinstance(item, Block) for inner in item.items]
        for item in items:
            if (
                isinstance(item, Sentence)
                and item.name.key == "tissue"
                and item.phrase is not None
            ):
                used.add(item.phrase.words[0].key)
    return [tissue for key, tissue in known.items() if key in used or not used]


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
        "missing": dict(tissue.missing),
    }


def _print_tissue(tissue: "Tissue") -> None:
    from tissuec.provenance import explain_tissue

    click.echo(f"\n{tissue.name:<40}{tissue.span.place}")
    for fact in tissue.facts:
        click.echo(
            f"  {fact.property:<17}{fact.written:<24}{fact.number:<10.4g}{fact.span.place}"
        )
    for explained in explain_tissue(tissue):
        _print_quantity(explained)
    for name, reason in tissue.missing.items():
        click.echo(f"  {name:<17}none: {reason}")


def _print_quantity(explained: "Explained") -> None:
    head = f"  {explained.quantity:<17}{explained.shown:<24}{explained.how:<10}"
    for reason in explained.reasons:
        degree = "" if reason.degree is None else f"{reason.word} {reason.degree:.2f} "
        facts = f"  ({reason.facts})" if reason.facts else ""
        click.echo(f"{head}{degree:<32}{reason.place}{facts}")
        head = " " * len(head)


def _print_plan(plan: "Prediction") -> None:
    click.echo("\narrays")
    for name, array in plan.arrays.items():
        shape = " x ".join(map(str, array["shape"]))
        click.echo(f"  {name:<12}{shape:<16}{_bytes(array['bytes'])}")
    facts = plan.facts
    click.echo(f"\nmethod: {plan.method}\n  because {plan.reason}")
    click.echo(
        f"  fastest motion {facts['omega']:.4g} rad/s, damping ratio {facts['zeta']:.3g}"
    )
    click.echo(f"  steps are stable up to {show(facts['limit'], TIME)}")
    click.echo("\nskipped")
    for skip in plan.skipped:
        click.echo(f"  {skip}")
    click.echo("\ncost, with steps at that limit (a tolerance may need smaller ones)")
    click.echo(f"  about {plan.steps:.3g} steps, {plan.evaluations:.3g} force evaluations")
    click.echo(f"  about {show(plan.seconds, TIME, digits=2)} of stepping, once it is compiled")
    click.echo(f"  result file up to {_bytes(plan.bytes)} before compression")


def _bytes(count: int) -> str:
    for size, unit in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if count >= size:
            return f"{count / size:.3g} {unit}"
    return f"{count} bytes"


def _explain_code(code: str, settings: Settings) -> int:
    from tissuec.core.catalogue import CODES

    if code not in CODES:
        raise TissueError(
            f'there is no code "{code}"; {did_you_mean(code, CODES)}'.rstrip("; ")
        )
    entry = CODES[code]
    if settings.json:
        print_json({"code": code, **asdict(entry)})
        return DONE
    click.echo(f"{code}: {entry.title}\n\n{entry.text}")
    if entry.before:
        click.echo(
            f"\ninstead of\n\n    {_indent(entry.before)}\n\nwrite\n\n    {_indent(entry.after)}"
        )
    return DONE


def _indent(text: str) -> str:
    return text.strip().replace("\n", "\n    ")
