"""``tissuec explain``: Show the origin of every number of a scene, or explain a code."""

import re
from pathlib import Path
from textwrap import indent
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import Command, SceneOptions, Settings, scene_options
from tissuec.core.data import as_data
from tissuec.core.errors import TissueError
from tissuec.core.hints import did_you_mean
from tissuec.core.report import Part, Report

if TYPE_CHECKING:
    from tissuec.scene.model import Tissue
    from tissuec.scene.program.resolved import ResolvedProgram

CODE = re.compile(r"(TIS|W)\d+", re.IGNORECASE)


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
    given: SceneOptions,
) -> Report:  # fmt: skip
    """Show the origin of every number of the scene SUBJECT.

    SUBJECT can also be a code such as TIS104, which is then explained.

    --bodies computes these properties from the net of each body: mass, density, Young's and
    shear modulus, Poisson's ratio, anisotropy, wave speeds, breaking length, and the lowest
    natural frequencies while the nodes that are held at 0 s stay held.

    \b
    tissuec explain scene.tis --tissue liver
    tissuec explain scene.tis --bodies --json
    tissuec explain TIS104
    """
    if CODE.fullmatch(subject):
        return _code_report(subject.upper())
    from tissuec.compiler.bodies.graded_ranges import graded_ranges
    from tissuec.compiler.provenance import as_dict
    from tissuec.pipeline import compile_request, read_words
    from tissuec.scene.reading.graded import mentions_graded
    from tissuec.view.scene_summary import graded_sections, origins_of

    request = given.request(Path(subject))
    words, warnings = read_words(request)
    tissues = _chosen(words, tissue)
    parts: list[Part] = [*origins_of(words, tissues, forces=tissue is None)]
    document: dict[str, Any] = as_dict(words, tissues)
    compiled = None
    is_graded = tissue is None and mentions_graded(words.declarations)
    if with_plan or with_bodies or is_graded:
        compiled, warnings = compile_request(request)
    if compiled is not None and is_graded:
        ranges = [*graded_ranges(compiled)]
        parts += graded_sections(ranges)
        document["graded"] = [*map(as_data, ranges)]
    if compiled is not None and with_bodies:
        from tissuec.analysis.bodies import properties_of  # late: it needs SciPy
        from tissuec.view import scene_summary

        properties = properties_of(compiled)
        parts += map(scene_summary.body_section, properties)
        document["bodies"] = [*map(scene_summary.as_dict, properties)]
    if compiled is not None and with_plan:
        from tissuec.compiler.prediction import predict  # late: it imports the engine
        from tissuec.view.scene_summary import plan_sections

        plan = predict(compiled)
        parts += plan_sections(plan)
        document["plan"] = as_data(plan) | {"cost": plan.cost._asdict()}
    if settings.verbose:
        settings.warn(warnings)
    return Report(parts, document)


def _chosen(words: "ResolvedProgram", name: str | None) -> "list[Tissue]":
    """Return the requested tissue; otherwise those that are used, or all where none is."""
    from tissuec.compiler.provenance import used_tissues
    from tissuec.core.names import key_of

    if name is None:
        return used_tissues(words)
    known, key = words.tissues, key_of(name)
    if key not in known:
        hint = did_you_mean(key, known) or f"tissues: {', '.join(known)}"
        raise TissueError(f'there is no tissue "{name}"; {hint}')
    return [known[key]]


def _code_report(code: str) -> Report:
    from tissuec.core.catalogue import CODES

    if code not in CODES:
        hint = did_you_mean(code, CODES)
        raise TissueError(f'unknown code "{code}"' + (f"; {hint}" if hint else ""))
    entry = CODES[code]
    before, after = (indent(piece, "    ") for piece in (entry.before, entry.after))
    parts = (
        f"{code}: {entry.title}\n\n{entry.text}",
        f"\ninstead of\n\n{before}\n\nwrite\n\n{after}",
    )
    return Report(parts, {"code": code, **as_data(entry)})
