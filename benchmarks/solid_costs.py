"""Time and memory of solid elements compared with felupe and the flexes of MuJoCo.

Each run is a process of its own with one thread, whose whole processor time counts, with
imports and the loading of kernels. felupe solves the same load steps on the same nodes, with
trilinear hexahedra of mean volumes, by its default solver. MuJoCo moves a bar of these nodes,
made of linear tetrahedra, until it rests. Takes a quarter of an hour, and needs felupe and
mujoco.
"""

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from statistics import median
from subprocess import run as run_process
from tempfile import TemporaryDirectory
from typing import Any

import click

from benchmarks.publishing import publish, tell, write_option
from tests.forces.solid_cases import CASES, Case, answers
from tissuec.core.markdown import table
from tissuec.core.structs import replace

#: Cases, and cells across.
RUNS = (("cube, ν = 0.3", 4), ("cube, ν = 0.3", 8), ("cube, ν = 0.3", 12), ("cantilever", 4),
        ("torsion", 4))  # fmt: skip
FLEXES = {2: 1e-3, 4: 5e-4}  # time steps [s] by cells across
KNOWN = Path(__file__).parents[1] / "tests" / "forces" / "solid_references.json"


def case_of(name: str) -> Case:
    """Return a case without the loads for which no answers are known."""
    case, known = CASES[name], json.loads(KNOWN.read_text(encoding="utf-8"))[name]
    shown = {k: shown for k, shown in case.shown.items() if shown in known}
    return replace(case, shown=shown, steps=case.steps[: max(shown) + 1])


def measured(by: str, name: str, cells: int, times: int) -> dict[str, Any]:
    """Return the answers of a run, and medians of its seconds and of its memory [MB]."""
    case = case_of(name)
    if by == "tissuec":
        command = ["-m", "benchmarks.solid_costs", "--one", name, str(cells)]
    else:
        asked = {
            "by": by, "kind": name.split(",")[0], "sides": case.sides, "axis": case.axis,
            "cell": case.across / cells, "young": case.young, "poisson": case.poisson,
            "steps": case.steps, "shown": case.shown, "step": FLEXES.get(cells),
        }  # fmt: skip
        # By its path, so that nothing of this package is imported.
        command = [str(Path(__file__).with_name("solid_rivals.py")), json.dumps(asked)]
    found = [
        json.loads(
            run_process(
                [sys.executable, *command],
                capture_output=True,
                check=True,
                text=True,
                env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            ).stdout.splitlines()[-1]
        )
        for _ in range(times)
    ]
    tell(f"{by}, {name}, {cells}: {found}")
    return {
        "shown": found[0]["shown"],
        **{key: median(each[key] for each in found) for key in ("seconds", "memory")},
    }


def worst(shown: dict[str, float], name: str) -> float:
    """Return the largest error of the answers of a case [%]."""
    known = json.loads(KNOWN.read_text(encoding="utf-8"))[name]
    return max((100.0 * (shown[k] / due - 1.0) for k, due in known.items()), key=abs)


def rows(times: int) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the comparison with felupe."""
    for name, cells in RUNS:
        own, other = (measured(by, name, cells, times) for by in ("tissuec", "felupe"))
        yield (
            f"{name}, {cells} across",
            *(
                f"{worst(each['shown'], name):+.1f} %, {each['seconds']:.1f} s, "
                f"{each['memory']:.0f} MB"
                for each in (own, other)
            ),
            f"{own['seconds'] / other['seconds']:.2f}",
        )  # fmt: skip


def flex_rows(times: int) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the comparison with MuJoCo: the cantilever."""
    known = json.loads(KNOWN.read_text(encoding="utf-8"))["cantilever"]
    for cells in FLEXES:
        for by in ("tissuec", "mujoco"):
            found = measured(by, "cantilever", cells, 1 if by == "mujoco" else times)
            errors = [
                f"{100.0 * (found['shown'][k] / v - 1.0):+.1f} %" for k, v in known.items()
            ]
            yield f"{by}, {cells} across", *errors, f"{found['seconds']:.1f} s"


@click.command(help=__doc__)
@click.option("--one", nargs=2, type=str, hidden=True)
@click.option("--times", default=3, show_default=True, help="Runs of each kind.")
@write_option
def main(*, one: tuple[str, str] | None, times: int, write: bool) -> None:
    """Measure everything."""
    if one is not None:
        with TemporaryDirectory() as folder:
            shown = answers(case_of(one[0]), "hexahedra", int(one[1]), Path(folder))
        used = getrusage(RUSAGE_SELF)
        seconds = used.ru_utime + used.ru_stime
        click.echo(
            json.dumps({"shown": shown, "seconds": seconds, "memory": used.ru_maxrss / 1024})
        )
        return
    beside = ("case", "tissuec", "felupe", "time of tissuec / felupe")
    flexes = ("bar", "0.5 mN", "2.3 mN", "7 mN", "time")
    publish(
        "solid_costs",
        {
            "felupe": table(beside, list(rows(times))),
            "flexes": table(flexes, list(flex_rows(times))),
        },
        write=write,
    )


if __name__ == "__main__":
    main()
