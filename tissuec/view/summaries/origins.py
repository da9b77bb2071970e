"""The origin of every number of a scene, and the prediction of a run, as parts of a report."""

from collections.abc import Iterable, Iterator
from math import isfinite

from tissuec.compiler.bodies.graded_ranges import GradedRange
from tissuec.compiler.prediction import Prediction
from tissuec.compiler.provenance import SET, ProvenanceRow, tissue_rows
from tissuec.core.errors import shown_size
from tissuec.core.report import FactSection, FactTable, Part
from tissuec.core.units import TIME, show
from tissuec.scene.force_numbers import numbers_of
from tissuec.scene.model import Tissue
from tissuec.scene.program.resolved import ResolvedProgram

#: Minimum widths, so that the tables of most tissues look alike; three columns always stay.
COLUMNS, KEPT = (17, 24, 10, 32), 3


def origins_of(
    words: ResolvedProgram, tissues: Iterable[Tissue], *, forces: bool
) -> Iterator[Part]:
    """Yield params, tissues and forces.

    Args:
        words: The scene.
        tissues: The tissues that are explained.
        forces: Whether forces are, too.
    """
    for parameter in words.constants.parameters():
        mark = f" ({SET})" if parameter.overridden else ""
        place = parameter.item.span.place
        yield f"param {parameter.name} = {parameter.value}{mark}   {place}"
    for tissue in tissues:
        cells = [line for row in tissue_rows(tissue) for line in _cells(row)]
        missing = (f"{name:<17}none: {reason}" for name, reason in tissue.gaps.items())
        parts = [FactTable((), cells, least=COLUMNS, kept=KEPT), *missing]
        yield FactSection(f"{tissue.name:<40}{tissue.span.place}", parts)
    for name, force in numbers_of(words.forces).items() if forces else ():
        head = f"force {name}: {force.kind} on {force.acts_on}"
        cells = [
            (entry, given.shown, given.how, given.text, given.place)
            for entry, given in force.entries.items()
        ]
        table = FactTable((), cells, least=COLUMNS, kept=KEPT)
        yield FactSection(f"{head:<40}{force.place}", [table])


def graded_sections(ranges: Iterable[GradedRange]) -> Iterator[Part]:
    """Yield the quantities that depend on the place, body by body, region by region."""
    owners: dict[tuple[str, str], list[tuple[str, ...]]] = {}
    for one in ranges:
        cells = one.quantity, one.shown, "formula", one.formula, one.place
        owners.setdefault((one.body, one.owner), []).append(cells)
    for (body, owner), rows in owners.items():
        what = f"body {body}" if owner == body else f"region {owner} of {body}"
        table = FactTable((), rows, least=COLUMNS, kept=KEPT)
        yield FactSection(f"{what}: depends on the place", [table])


def _cells(row: ProvenanceRow) -> Iterator[tuple[str, ...]]:
    """Yield the lines of an entry; the second reason and further ones without its head."""
    if row.kind == "property":  # no rule speaks for it, which leaves a column free
        yield row.name, row.value, row.how, row.reasons[0].place
        return
    head = (row.name, row.value, row.how)
    for reason in row.reasons:
        facts = f"  ({reason.facts})" if reason.facts else ""
        yield *head, reason.said, f"{reason.place}{facts}"
        head = ("", "", "")


def plan_sections(plan: Prediction) -> list[FactSection]:
    """Return the arrays, the method, the parts that are skipped, and the cost."""
    rows = [
        (name, " x ".join(map(str, array["shape"])), shown_size(array["bytes"]))
        for name, array in plan.arrays.items()
    ]
    table = FactTable(("array", "shape", "size"), rows, "Arrays of the net", (12, 16))
    title = "cost"
    if isfinite(plan.steps):
        title = "cost, with steps at this limit (a tolerance can need smaller steps)"
    return [
        FactSection("arrays", [table]),
        FactSection(f"method: {plan.method}", _method(plan)),
        FactSection("skipped", plan.skipped or ["nothing"]),
        FactSection(title, cost(plan)),
    ]


def _method(plan: Prediction) -> list[str]:
    """Return why the method was chosen, and what bounds its steps."""
    facts = plan.facts
    limited = isfinite(facts["limit"])
    limit = f"up to {show(facts['limit'], TIME)}" if limited else "any size"
    return [
        f"reason: {plan.reason}",
        *plan.choices,
        f"fastest motion {facts['omega']:.4g} rad/s, damping ratio {facts['zeta']:.3g}",
        f"stable steps: {limit}",
    ]


def cost(plan: Prediction) -> list[str]:
    """Return the number of steps, their time, and the size of the file."""
    file = f"result file of {'at most' if plan.compress else 'about'} {shown_size(plan.bytes)}"
    if not isfinite(plan.steps):
        each = show(plan.step_seconds, TIME, digits=2)
        return [
            f"as many steps as the tolerance needs, each of about {each}",
            "no estimate of the computing time",
            file,
        ]
    return [
        f"about {plan.steps:.3g} steps, {plan.evaluations:.3g} force evaluations",
        f"about {show(plan.seconds, TIME, digits=2)} of computing time, without compilation",
        file,
    ]
