"""Facts about a scene before it runs: bodies as matter, origins of numbers, and the plan."""

from collections.abc import Iterable, Iterator, Sequence
from math import inf, isfinite
from typing import Any

from tissuec.analysis.bodies import BodyProperties, BreakingStrength, Vibration
from tissuec.compiler.bodies.graded_ranges import GradedRange
from tissuec.compiler.prediction import Prediction
from tissuec.compiler.provenance import SET, ProvenanceRow, tissue_rows
from tissuec.core.data import as_data
from tissuec.core.errors import counted, shown_size
from tissuec.core.report import Fact, FactSection, FactTable, Part
from tissuec.core.units import (
    AREA,
    DENSITY,
    FORCE,
    LENGTH,
    MASS,
    PRESSURE,
    STIFFNESS,
    TIME,
    VELOCITY,
    VOLUME,
    Dimension,
    show,
)
from tissuec.matter.elasticity import Elasticity
from tissuec.scene.force_numbers import numbers_of
from tissuec.scene.model import Tissue
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.script.plan import EQUILIBRIUM

Row = tuple[str, str, str]
#: By units of moduli: their dimension, and by what they are multiplied.
_UNITS: dict[str, tuple[Dimension, str]] = {
    "Pa": (PRESSURE, ""),
    "N/m": (STIFFNESS, " x thickness"),
    "N": (FORCE, " x section"),
}
_ALIKE = 0.005  # what is shown as one number


def body_section(body: BodyProperties) -> FactSection:
    """Return the material of a body, the size of its net, and all that is known of it."""
    made = f" of {', '.join(body.tissues)}" if body.tissues else ""
    table = FactTable((), [*_rows(body)], least=(17, 24))
    notes = [Fact("note", note) for note in body.notes]
    return FactSection(f"{body.name}: {body.kind}{made}; {body.net}", [table, *notes])


def _rows(body: BodyProperties) -> Iterator[Row]:
    """Yield quantity, value and remark of all that is known of a body."""
    yield "mass", show(body.mass, MASS), _size(body)
    dimension = AREA if body.kind == "wall" else VOLUME
    for region in body.regions:
        remark = f"in elements; its condition holds in {show(region.written, dimension)}"
        yield f"region {region.name}", show(region.size, dimension), remark
    if body.element_quality is not None:
        worst, mean = body.element_quality
        remark = "of tetrahedra; 1 if all edges are equally long, 0 if flat"
        yield "quality", f"{worst:.2g} at worst, {mean:.2g} on average", remark
    if body.elasticity is not None:
        yield from _elastic(body.elasticity)
    if body.elasticity is not None and body.wave_speeds:
        value, remark = _by_direction(body.wave_speeds, body.elasticity, VELOCITY)
        yield "wave speed", value, remark
    if body.shear_wave_speed:
        yield "shear wave speed", show(body.shear_wave_speed, VELOCITY), ""
    if body.retardation_time:
        yield "retardation time", show(body.retardation_time, TIME), ""
    if body.breaking is not None:
        yield _breaking(body.breaking, body.elasticity)
    if body.vibrations:
        yield "frequencies", _each(v.frequency for v in body.vibrations), ""
        yield from _decay(body.vibrations)


def _size(body: BodyProperties) -> str:
    parts: list[str] = []
    if body.density:
        parts.append(show(body.density, DENSITY, digits=4))
    if body.volume:
        parts.append(f"{1e6 * body.volume:.4g} ml")
    if body.area:
        parts.append(f"{1e4 * body.area:.4g} cm^2")
    if body.length:
        parts.append(show(body.length, LENGTH))
    return ", ".join(parts)


def _elastic(one: Elasticity) -> Iterator[Row]:
    dimension, times = _UNITS[one.unit]
    yield f"Young's modulus{times}", *_by_direction(one.young, one, dimension)
    if one.shear:
        shear = sum(one.shear) / len(one.shear)
        yield f"shear modulus{times}", show(shear, dimension), ""
    if one.poisson is not None:
        yield "Poisson's ratio", f"{one.poisson:.3g}", ""
    if one.anisotropy == inf:
        yield "anisotropy", "infinite", "no resistance in some direction"
    elif one.anisotropy is not None:
        remark = "ratio of the largest to the smallest Young's modulus over all directions"
        yield "anisotropy", f"{one.anisotropy:.3g}", remark


def _by_direction(
    values: Sequence[float], one: Elasticity, dimension: Dimension
) -> tuple[str, str]:
    """Return the mean of values, and each with its direction if they differ."""
    mean, remark = sum(values) / len(values), ""
    if max(values) - min(values) > _ALIKE * max(values):
        pairs = zip(one.directions, values, strict=True)
        remark = ", ".join(
            f"{direction} {show(value, dimension)}" for direction, value in pairs
        )
    return show(mean, dimension), remark


def _breaking(breaking: BreakingStrength, elasticity: Elasticity | None) -> Row:
    least, median, largest = breaking.stretch
    value = f"{median:.3g} times its length"
    if breaking.stress is not None and elasticity is not None:
        value += f", at {show(breaking.stress, _UNITS[elasticity.unit][0])}"
    differs = largest - least > _ALIKE * median
    remark = f"its springs at {least:.3g} to {largest:.3g} times" if differs else ""
    return "breaks at", value, remark


def _decay(vibrations: tuple[Vibration, ...]) -> Iterator[Row]:
    times = [vibration.decay_time for vibration in vibrations]
    if any(map(isfinite, times)):
        shown = (show(time, TIME) if isfinite(time) else "never" for time in times)
        yield "decay to 1/e in", ", ".join(shown), ""


def _each(frequencies: Iterator[float]) -> str:
    return ", ".join(f"{frequency:.4g} Hz" for frequency in frequencies)


def as_dict(body: BodyProperties) -> dict[str, Any]:
    """Return a body as plain data in SI units."""
    found = as_data(body)
    for vibration, one in zip(found["vibrations"], body.vibrations, strict=True):
        vibration["decay_time"] = one.decay_time
    derived = ("density", "wave_speeds", "shear_wave_speed")
    return found | {name: getattr(body, name) for name in derived}


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
    if plan.method == EQUILIBRIUM:
        title = "cost (where the state changes fast, there are more equilibria)"
    elif isfinite(plan.steps):
        title = "cost, with steps at this limit (a tolerance can need smaller steps)"
    return [
        FactSection("arrays", [table]),
        FactSection(f"method: {plan.method}", _method(plan)),
        FactSection("skipped", plan.skipped or ["nothing"]),
        FactSection(title, cost(plan)),
    ]


def _method(plan: Prediction) -> list[str]:
    """Return why the method was chosen, and what bounds its steps."""
    if plan.method == EQUILIBRIUM:
        return [
            f"reason: {plan.reason}",
            "Newton's method, with a matrix for each of its steps",
        ]
    facts = plan.facts
    limited = isfinite(facts["limit"])
    limit = f"up to {show(facts['limit'], TIME)}" if limited else "any size"
    return [
        f"reason: {plan.reason}",
        *plan.choices,
        f"fastest motion {facts['omega']:.4g} rad/s, damping ratio {facts['zeta']:.3g}",
        f"stable steps: {limit}",
    ]


LARGE = 2e8  # bytes of memory that are worth a line


def cost(plan: Prediction) -> list[str]:
    """Return the number of steps, their time, and the size of the file."""
    file = f"result file of {'at most' if plan.compress else 'about'} {shown_size(plan.bytes)}"
    still = plan.static
    number = counted(still.equilibria, "equilibrium")
    time = show(still.seconds, TIME, digits=2)
    whole = f"the run takes about {show(plan.seconds, TIME, digits=2)} of processor time"
    equilibria = f"about {number}, {still.steps:.0f} steps of Newton's method, {time}"
    memory = [f"about {shown_size(round(still.bytes))} of memory for matrices"]
    also = memory if still.bytes >= LARGE else []
    if plan.method == EQUILIBRIUM:
        return [equilibria, *also, whole, file]
    also = [equilibria, *also] if still.equilibria else []
    if not isfinite(plan.steps):
        each = show(plan.step_seconds, TIME, digits=2)
        return [
            f"as many steps as the tolerance needs, each of about {each}",
            *also,
            "no estimate of the computing time",
            file,
        ]
    return [
        f"about {plan.steps:.3g} steps, {plan.evaluations:.3g} force evaluations",
        *also,
        whole,
        file,
    ]
