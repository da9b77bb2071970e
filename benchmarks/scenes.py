"""Time of runs to an error, beside SciPy's DOP853 on the same compiled forces.

Shown are the fastest runs whose error is within each bound, and what it is: of the worst node
at the worst output time, relative to the largest displacement so far, against a reference
that is a hundred times finer. How well it is known is the distance to the nearest run of SciPy;
where that is longer than the bound, or no such run ends within the budget, there is a dash.
Times are those of the processor, without reading the scene, loading kernels and writing files;
medians of runs by turns, in a process that is kept on one processor. S1 and L10 take a minute,
all scenes hours.
"""

import os
from pathlib import Path
from typing import Any

import click
from msgspec import Struct

from benchmarks.publishing import json_option, publish, tell
from benchmarks.rivals.offers import RIVALS
from tissuec.analysis.bench import BenchResult, MeasuredPoint, bench, bench_report, seconds
from tissuec.core.markdown import table
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.plan import AUTOMATIC

NETS = Path(__file__).with_name("nets")
BOUNDS = (1e-2, 1e-4, 1e-8)
#: That are tried; errors of a run are smaller than its tolerance, or larger.
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-9)
SOLVERS = (AUTOMATIC, "SciPy DOP853")


class Scene(Struct, frozen=True):
    """A file of ``nets`` and what is set in it."""

    net: str
    overrides: tuple[str, ...] = ()

    def request(self) -> Request:
        """Return what is to be compiled."""
        return Request.file(NETS / f"{self.net}.tis", overrides=self.overrides)


SCENES = {
    "S1": Scene("published_tube"),
    "S3": Scene("published_tube", ("harder=1e4",)),
    "L10": Scene("lattice"),
    "L22": Scene("lattice", ("edge nodes=22",)),
    "L46": Scene("lattice", ("edge nodes=46",)),
    "H16": Scene("hard_core"),
    "V60": Scene("viscous_sheet"),
    "C2000": Scene("chain"),
}


@click.command(help=__doc__)
@click.option(
    "--scene",
    "names",
    multiple=True,
    type=click.Choice(tuple(SCENES)),
    default=tuple(SCENES),
    help="Only this scene; may be repeated.",
)
@click.option(
    "--repeat", type=click.IntRange(1), default=5, show_default=True, help="Timed runs of each."
)
@click.option(
    "--budget",
    type=click.FloatRange(min=0.0, min_open=True),
    default=30.0,
    show_default=True,
    metavar="SECONDS",
    help="Time of the processor that a run may take.",
)
@json_option
def main(names: tuple[str, ...], repeat: int, budget: float, *, as_json: bool) -> None:
    """Measure the scenes that are asked for."""
    stay_on_one_processor()
    found = {name: measured(SCENES[name], repeat, budget) for name in names}
    heads = (
        "scene",
        "springs",
        "error ≤",
        *(head for s in SOLVERS for head in (s, "its error")),
    )
    rows = [row for name, one in found.items() for row in rows_of(name, one)]
    document = {name: as_dict(one) for name, one in found.items()} if as_json else None
    publish("scenes", {"scenes": table(heads, rows)}, document=document)


def stay_on_one_processor() -> None:
    """Keep the process on one processor, where the system can."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def measured(scene: Scene, repeat: int, budget: float) -> BenchResult:
    """Return the points of a scene."""
    compiled, _ = compile_request(scene.request())
    return bench(
        compiled,
        methods=SOLVERS,
        tolerances=TOLERANCES,
        repeat=repeat,
        budget=budget,
        tell=tell,
        rivals=RIVALS,
    )


def within(found: BenchResult, solver: str, bound: float) -> MeasuredPoint | None:
    """Return the fastest point of a solver whose error is known to be within a bound."""
    points = [
        p for p in found.points if p.name == solver and max(p.error, found.floor) <= bound
    ]
    return min(points, key=lambda point: point.seconds, default=None)


def rows_of(name: str, found: BenchResult) -> list[tuple[str, ...]]:
    """Return the rows of a scene."""
    springs = str(found.problem.network.spring_count)
    return [
        (
            name, springs, f"{bound:g}",
            *(cell for solver in SOLVERS for cell in cells(within(found, solver, bound))),
        )
        for bound in BOUNDS
    ]  # fmt: skip


def cells(point: MeasuredPoint | None) -> tuple[str, str]:
    """Return time and error of a point, in words."""
    return ("-", "-") if point is None else (seconds(point.seconds), f"{point.error:.1e}")


def as_dict(found: BenchResult) -> dict[str, Any]:
    """Return all points of a scene, and those that the table shows, in SI units."""
    best = [
        {"bound": bound, "method": solver, "tolerance": point.tolerance, "error": point.error,
         "seconds": point.seconds}
        for bound in BOUNDS
        for solver in SOLVERS
        if (point := within(found, solver, bound))
    ]  # fmt: skip
    return bench_report(found, {}).document | {"within": best}


if __name__ == "__main__":
    main()
