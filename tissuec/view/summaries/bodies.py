"""Bodies as matter: a section of a report, and plain data."""

from collections.abc import Iterator, Sequence
from math import inf, isfinite
from typing import Any

from tissuec.analysis.bodies import BodyProperties, BreakingStrength, Vibration
from tissuec.core.data import as_data
from tissuec.core.report import Fact, FactSection, FactTable
from tissuec.core.units import (
    DENSITY,
    FORCE,
    LENGTH,
    MASS,
    PRESSURE,
    STIFFNESS,
    TIME,
    VELOCITY,
    Dimension,
    show,
)
from tissuec.matter.coarseness import Coarseness
from tissuec.matter.elasticity import Elasticity

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
    if body.element_quality is not None:
        worst, mean = body.element_quality
        remark = "of tetrahedra; 1 if all edges are equally long, 0 if flat"
        yield "quality", f"{worst:.2g} at worst, {mean:.2g} on average", remark
    if body.elasticity is not None:
        yield from _elastic(body.elasticity)
    if body.coarseness is not None:
        yield from _coarse(body.coarseness)
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


def _coarse(one: Coarseness) -> Iterator[Row]:
    """Yield how many times as stiff cells make a body as matter that has none."""
    remark = "its cells against its moduli, along its longest axis"
    yield "in bending", f"{one.bending:.3g} times as stiff", remark
    value = f"{one.torsion:.3g} times as stiff" if one.torsion else "no resistance"
    yield "in torsion", value, ""


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
