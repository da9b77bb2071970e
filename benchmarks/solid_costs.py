"""Time against error of solids, compared with felupe, NGSolve and the flexes of MuJoCo.

Each run is a process of its own with one thread, whose whole processor time counts, with
imports and the loading of kernels. Every program solves the same equilibria with meshes and
elements of its own, and the cheapest run within an error counts. felupe has trilinear hexahedra
with mean volumes and hexahedra of 27 nodes, and solves linear equations by SuperLU; NGSolve has
hexahedra of orders 2 and 3 and a sparse Cholesky factorisation; both take as few of 3, 6 or 12
steps of the load as Newton's method needs. The ball of felupe is a penalty of this benchmark.
MuJoCo moves a bar of linear tetrahedra until it rests. Takes a quarter of an hour, and needs
felupe, ngsolve and mujoco; programs that are not installed are left out.
"""

import json
import os
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from statistics import median
from subprocess import run as run_process
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import click
import numpy as np

import tissuec
from benchmarks.processes import seconds_of_run
from benchmarks.publishing import publish, tell, write_option
from tests.forces.solid_cases import (
    BAR,
    CASES,
    Case,
    answers,
    lattice,
    lowered,
    tetrahedra,
    text_of,
    twisted,
)
from tissuec.core.markdown import table
from tissuec.core.structs import replace

ERRORS = (np.inf, 0.03, 0.01, 0.003)  # of any error: what programs take at least
STEPS = (3, 6, 12)  # of the load, for the other programs
FLEXES = {2: 1e-3, 4: 5e-4}  # time steps [s] by cells across
KNOWN = Path(__file__).parents[1] / "tests" / "forces" / "solid_references.json"
LONGEST = 60.0  # that a run may take [s]
SOFTEST = 12.0 / 0.91 * 10.0  # pressure per share of a cell that the ball sinks in [kPa]
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
INDENTED = """language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  solid law is neo hookean {{ volume is quadratic }}
}}
body block {{
  mesh is lattice {{ cell = {cell:.15g} mm; box from (0, 0, 0) mm to (16, 16, 12) mm }}
  tissue is gel
}}
set base = nodes of block where z == 0 mm
tool ball {{ kind is probe; radius = 6 mm; centre = (0, 0, 18) mm }}
environment {{
  gravity = (0, 0, 0) m/s^2; contact is tools only; friction = 0
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}}
script {{
  at 0 s: fix base
  from 0 us to 1 us: move ball by (0, 0, -2.4) mm using constant speed
  at 1 us: settle
}}
simulate {{ duration = 2 us; integrator is dop853 }}
output {{ force of ball every 2 us }}
"""


class Problem(NamedTuple):
    """An equilibrium, and runs of each program from the cheapest one on.

    Attributes:
        known: The answer [mm, mN mm or mN]: of bars, by NGSolve with order 5 and graded cells;
            of the ball, the limit of finer hexahedra of tissuec with ever stiffer contact.
        entries: For the other programs.
        case: Of the scene; None for the ball.
        runs: Orders or shapes, and cells, by program.
    """

    known: float
    entries: dict[str, Any]
    case: Case | None
    runs: dict[str, tuple[tuple[Any, int], ...]]


OWN = (
    *(("quadratic", n) for n in (1, 2, 3)),
    *(("tetrahedra", n) for n in (1, 2, 3)),
    *(("hexahedra", n) for n in (1, 2, 4, 6, 8)),
)
RUNS = {
    "tissuec": OWN,
    "felupe": (*((2, n) for n in (1, 2, 3, 4)), *((1, n) for n in (2, 4, 6, 8))),
    "ngsolve": (*((2, n) for n in (1, 2, 3, 4)), *((3, n) for n in (1, 2, 3))),
}
BALL_RUNS = {
    "tissuec": tuple(("hexahedra", n) for n in (1, 2, 3, 4)),
    "felupe": (*((2, n) for n in (1, 2)), *((1, n) for n in (1, 2, 3, 4))),
}


def _bending(poisson: float) -> Case:
    return Case("bending", BAR, "mm", (0.0,), {0: "end"}, lowered, "", "fix near", across=10.0,
                poisson=poisson, axis="x", gravity=-3.0)  # fmt: skip


_TWIST = Case(
    "twist", BAR, "mN mm", (90.0,), {0: "torque"}, twisted,
    "turn far by {:.12g} deg around (1, 0, 0) using constant speed", across=10.0, axis="x",
)  # fmt: skip
_BAR: dict[str, Any] = {"sides": BAR, "young": 10.0}
_BENT = {**_BAR, "kind": "bending", "load": 3e-3}
_TWISTED = {**_BAR, "kind": "twist", "load": 90.0}
PROBLEMS = {
    "bending, ν = 0.3": Problem(39.547, _BENT | {"poisson": 0.3}, _bending(0.3), RUNS),
    "bending, ν = 0.49": Problem(39.03, _BENT | {"poisson": 0.49}, _bending(0.49), RUNS),
    "twist by 90°, ν = 0.3": Problem(142.56, _TWISTED | {"poisson": 0.3}, _TWIST, RUNS),
    "ball, 20 %, ν = 0.3": Problem(
        192.0,
        {"sides": (16.0, 16.0, 12.0), "young": 10.0, "kind": "indentation", "poisson": 0.3,
         "load": 2.4, "radius": 6.0, "firm": 8.0 * SOFTEST},
        None, BALL_RUNS,
    ),
}  # fmt: skip


def own(name: str, shape: str, cells: int, times: int) -> dict[str, Any]:
    """Return the answer of ``tissuec run``, and the median of its seconds."""
    problem = PROBLEMS[name]
    with TemporaryDirectory() as folder:
        if problem.case is None:
            text = INDENTED.format(cell=4.0 / cells)
        elif shape == "tetrahedra":
            text = text_of(problem.case, tetrahedra(problem.case, cells, Path(folder)))
        else:
            text = text_of(problem.case, lattice(problem.case, cells))
        if shape == "quadratic":
            text = text.replace("made of elements", "made of quadratic elements")
        scene, result = Path(folder, "scene.tis"), Path(folder, "scene.vtkhdf")
        scene.write_text(text, encoding="utf-8")
        seconds = [seconds_of_run(scene, result, ONE_THREAD) for _ in range(times)]
        with tissuec.load(result) as run:
            if problem.case is None:
                shown = -4e3 * float(run.logs["force of ball"].value[-1, 2])
            else:
                shown = problem.case.measure(run, 1)
    return {"shown": shown, "seconds": median(seconds)}


def process(command: list[str], times: int) -> dict[str, Any] | None:
    """Return the answer of runs, and medians of seconds and memory [MB]; None if they fail."""
    found: list[dict[str, Any]] = []
    for _ in range(times):
        try:
            done = run_process(
                [sys.executable, *command], capture_output=True, check=True, text=True,
                timeout=LONGEST, env=os.environ | ONE_THREAD,
            )  # fmt: skip
        except Exception as error:  # it did not converge, or took too long
            tell(f"{command[-1]}: {type(error).__name__}")
            return None
        found.append(json.loads(done.stdout.splitlines()[-1]))
    middle = {key: median(each[key] for each in found) for key in ("seconds", "memory")}
    return {"shown": found[0]["shown"], **middle}


def solved(by: str, name: str, order: Any, cells: int, times: int) -> dict[str, Any] | None:
    """Return the result of ``process`` for a problem, with as few steps of the load as do."""
    if by == "tissuec":
        return own(name, order, cells, times)
    asked = {"by": by, **PROBLEMS[name].entries, "order": order, "cells": cells}
    # By its path, so that nothing of this package is imported.
    path = str(Path(__file__).with_name("solid_rivals.py"))
    tries = (process([path, json.dumps({**asked, "steps": k})], times) for k in STEPS)
    return next((found for found in tries if found is not None), None)


def against_errors(times: int) -> Iterator[tuple[str, ...]]:
    """Yield the cheapest runs within errors, of each program, and a ratio."""
    for name, problem in PROBLEMS.items():
        costs: dict[str, list[tuple[float, float, str]]] = {}
        exact: set[tuple[str, Any]] = set()  # whose finer runs cost more and win nothing
        for by, runs in problem.runs.items():
            for order, cells in runs if find_spec(by) else ():
                if (by, order) in exact:
                    continue
                found = solved(by, name, order, cells, times)
                if found is None:
                    continue
                error = found["shown"] / problem.known - 1.0
                if abs(error) <= min(ERRORS):
                    exact.add((by, order))
                label = f"{order}, {cells}" if by == "tissuec" else f"order {order}, {cells}"
                costs.setdefault(by, []).append((found["seconds"], abs(error), label))
                tell(f"{name}, {by}, {label}: {100 * error:+.2f} %, {found['seconds']:.2f} s")
        for allowed in ERRORS:
            best = {
                by: min(one for one in each if one[1] <= allowed)
                for by, each in costs.items()
                if any(one[1] <= allowed for one in each)
            }
            cells = [
                f"{best[by][0]:.2f} s ({best[by][2]})" if by in best else "-"
                for by in ("tissuec", "felupe", "ngsolve")
            ]
            others = [best[by][0] for by in best if by != "tissuec"]
            ratio = (
                f"{best['tissuec'][0] / min(others):.2f}"
                if others and "tissuec" in best
                else "-"
            )
            within = f"{100 * allowed:g} %" if np.isfinite(allowed) else "any"
            yield name, within, *cells, ratio


def _cantilever() -> Case:
    """Return the cantilever without the loads for which no answers are known."""
    case, known = (
        CASES["cantilever"],
        json.loads(KNOWN.read_text(encoding="utf-8"))["cantilever"],
    )
    shown = {k: shown for k, shown in case.shown.items() if shown in known}
    return replace(case, shown=shown, steps=case.steps[: max(shown) + 1])


def flex_rows(times: int) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the comparison with MuJoCo: the cantilever."""
    known = json.loads(KNOWN.read_text(encoding="utf-8"))["cantilever"]
    for cells in FLEXES:
        for by in ("tissuec", "mujoco"):
            if by == "tissuec":
                command = ["-m", "benchmarks.solid_costs", "--bar", str(cells)]
            else:
                case = _cantilever()
                asked = {
                    "by": by, "sides": case.sides, "cell": case.across / cells,
                    "young": case.young, "poisson": case.poisson, "steps": case.steps,
                    "shown": case.shown, "step": FLEXES[cells],
                }  # fmt: skip
                command = [str(Path(__file__).with_name("solid_rivals.py")), json.dumps(asked)]
            found = process(command, 1 if by == "mujoco" else times)
            if found is None:
                continue
            errors = [
                f"{100.0 * (found['shown'][k] / v - 1.0):+.1f} %" for k, v in known.items()
            ]
            yield f"{by}, {cells} across", *errors, f"{found['seconds']:.1f} s"


@click.command(help=__doc__)
@click.option("--bar", type=int, hidden=True)
@click.option("--times", default=3, show_default=True, help="Runs of each kind.")
@click.option("--flexes", is_flag=True, help="Also compare with MuJoCo: ten minutes.")
@write_option
def main(
    *,
    bar: int | None,
    times: int,
    flexes: bool,
    write: bool,
) -> None:
    """Measure everything."""
    if bar is not None:
        with TemporaryDirectory() as folder:
            shown = answers(_cantilever(), "hexahedra", bar, Path(folder))
        used = getrusage(RUSAGE_SELF)
        seconds = used.ru_utime + used.ru_stime
        click.echo(
            json.dumps({"shown": shown, "seconds": seconds, "memory": used.ru_maxrss / 1024})
        )
        return
    heads = ("problem", "error", "tissuec", "felupe", "NGSolve", "tissuec / best other")
    publish("solid_costs", {"errors": table(heads, list(against_errors(times)))}, write=write)
    if flexes:
        bars = ("bar", "0.5 mN", "2.3 mN", "7 mN", "time")
        publish(
            "solid_costs.flexes", {"times": table(bars, list(flex_rows(times)))}, write=write
        )


if __name__ == "__main__":
    main()
