"""The report on runs with finer and finer meshes."""

from collections.abc import Mapping, Sequence
from typing import Any

from tissuec.core.report import STOPPED, FactTable, Report, failed
from tissuec.core.units import TIME, show, show_si
from tissuec.validate.refinement import ORDER, Dependence, MeshRun


def refinement_report(
    runs: Sequence[MeshRun], dependences: Sequence[Dependence], facts: Mapping[str, Any]
) -> Report:
    """Return the report; that of a failure if a run could not continue.

    Args:
        runs: With finer and finer meshes; only the last one may have failed.
        dependences: Of quantities on the mesh.
        facts: Further facts for programs.
    """
    last = runs[-1].outcome
    if last.kind != "done":
        return failed(f"the run with {runs[-1].network.size}: {last.message}", STOPPED, **facts)
    sizes = [f"{one.cells} cells" for one in runs]
    heads = ("quantity", *sizes, "change", "order", "error", "worst at")
    table = FactTable(heads, [*map(_row, dependences)], "Dependence on the mesh", kept=1)
    document = {
        **facts,
        "meshes": [{**one.network.size.facts, "wall_time": one.wall_time} for one in runs],
        "quantities": [
            {name: getattr(one, name) for name in Dependence.__struct_fields__}
            for one in dependences
        ],
    }
    return Report((table, *_conclusion(dependences, sizes[0])), document)


def _row(one: Dependence) -> tuple[str, ...]:
    order = "-" if one.order is None else f"{one.order:.1f}"
    values = (show_si(value, one.unit, digits=4) for value in one.values)
    changes = (f"{number:.1e}" for number in (one.change, one.error))
    return (one.name, *values, next(changes), order, next(changes), show(one.time, TIME))


def _conclusion(dependences: Sequence[Dependence], size: str) -> list[str]:
    """Return the estimated error of the first mesh, and what the estimate assumes."""
    if not dependences:
        return ["nothing is compared: the meshes have no common nodes, and there are no logs"]
    worst = max(dependences, key=lambda one: one.error)
    assumed = [one for one in dependences if one.order is None]
    found = [
        f"estimated error of the mesh with {size}: up to {worst.error:.1e} of {worst.name}"
    ]
    if assumed and len(assumed[0].values) == 2:
        found.append(
            f"errors are assumed to be of order {ORDER:g}; --mesh 2 measures the order"
        )
    elif assumed:
        found.append(
            "-: no order is observed, and the error is estimated as if it were of order 1"
        )
    return found
