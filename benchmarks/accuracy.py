"""Errors of runs: of shipped scenes, of motions in closed form, of the time of a rupture.

Takes a few minutes. The shipped scenes go through "tissuec validate"; the motions that are
known in closed form are scenes too, and are compared with their formulas here.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import numpy as np
from msgspec import Struct

from benchmarks.publishing import publish, tell, write_option
from tissuec.core.markdown import code, table
from tissuec.core.resources import library
from tissuec.core.source import Source
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request

TOLERANCES = (1e-3, 1e-5, 1e-8)
SCENES = (
    "two_masses", "published_net", "hanging_net", "rupture", "sterilisation", "bladder",
    "indentation", "palpation",
)  # fmt: skip
Known = Callable[[np.ndarray], np.ndarray]


class Case(Struct, frozen=True):
    """A motion in closed form.

    Attributes:
        name: What it is, in words.
        scene: Its text without ``simulate`` and ``output``.
        duration: [s].
        node: Whose position is known, as a row of the frames.
        known: Its coordinates [m] at times [s], shape (time, 3).
    """

    name: str
    scene: str
    duration: float
    node: int
    known: Known


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure everything."""
    tables = {
        "closed forms": closed_forms(),
        "orders": orders(),
        "rupture": rupture_time(),
        "scenes": scenes(),
    }
    publish("accuracy", tables, write=write)


# --- closed forms -----------------------------------------------------------------------------


def cases() -> Iterator[Case]:
    """Yield the motions that are known."""
    for ratio in (0.0, 0.1, 1.0, 3.0):
        yield oscillator(ratio)
    yield fall()
    yield rotation()
    yield chain()


def oscillator(ratio: float) -> Case:
    """A mass of 10 g on a spring of 40 N/m from a wall, let go 1 mm away from its place."""
    omega = float(np.sqrt(40.0 / 0.01))
    text = pair(f"spring constant = 40 N/m; viscosity = {2 * ratio * 0.01 * omega!r} N*s/m")
    known = along_x(lambda t: 0.010 + 0.001 * relaxation(ratio, omega, t))
    return Case(f"oscillator, damping ratio {ratio:g}", text, 0.5, 1, known)


def relaxation(ratio: float, omega: float, time: np.ndarray) -> np.ndarray:
    """Return x(t)/x(0) of x'' + 2 ζ ω x' + ω² x = 0 from rest."""
    rate = ratio * omega
    if ratio == 1.0:
        return np.exp(-rate * time) * (1.0 + rate * time)
    root = np.sqrt(complex(rate * rate - omega * omega))
    fast, slow = -rate - root, -rate + root
    return np.real((slow * np.exp(fast * time) - fast * np.exp(slow * time)) / (slow - fast))


def fall() -> Case:
    """A free mass in a resisting medium: m v' = m g - b v."""
    text = """
    tissue grain { mass = 1 g; spring constant = 0 N/m; viscosity = 0 N*s/m }
    body one { mesh is explicit; tissue is grain }
    table nodes of one in mm with columns "x" { 0 }
    environment { gravity = (9.81, 0, 0) m/s^2; damping = 10 mN*s/m }
    """
    delay = 0.1  # m / b [s]
    known = along_x(lambda t: 9.81 * delay * (t - delay * (1.0 - np.exp(-t / delay))))
    return Case("fall with drag", text, 0.5, 0, known)


def rotation() -> Case:
    """Two masses and a dashpot whirl at the distance where tension and spin agree."""
    spin, stiffness, mass, rest = 20.0, 40.0, 0.01, 0.01
    distance = rest * stiffness / (stiffness - 0.5 * mass * spin**2)
    text = f"""
    tissue cord {{ spring constant = 40 N/m; viscosity = 1 N*s/m; mass = 10 g }}
    body two {{ mesh is explicit; tissue is cord; spin = (0, 0, {spin!r}) rad/s }}
    table nodes of two in m with columns "x" {{ {-distance / 2!r}; {distance / 2!r} }}
    table springs of two in m with columns "a b rest length" {{ 1 2 {rest!r} }}
    environment {{ gravity = (0, 0, 0) m/s^2 }}
    """

    def known(time: np.ndarray) -> np.ndarray:
        turned = [np.cos(spin * time), np.sin(spin * time), np.zeros_like(time)]
        return 0.5 * distance * np.stack(turned, axis=1)

    return Case("rotation of a damped pair", text, 1.0, 1, known)


def chain() -> Case:
    """The fastest normal mode of eight masses between two walls."""
    count, stiffness, mass, amplitude = 8, 40.0, 0.01, 1e-5
    omega = 2.0 * np.sqrt(stiffness / mass) * np.sin(0.5 * count * np.pi / (count + 1))
    shape = np.sin(count * np.pi * np.arange(count + 2) / (count + 1))
    rows = "; ".join(
        f"{i} {10 * i} {float(1e3 * amplitude * omega * shape[i])!r}" for i in range(10)
    )
    links = "; ".join(f"{i} {i + 1}" for i in range(9))
    text = f"""
    tissue cord {{ spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 10 g }}
    body row {{ mesh is explicit; tissue is cord }}
    table nodes of row in mm with columns "id x vx in mm/s" {{ {rows} }}
    table springs of row with columns "a b" {{ {links} }}
    set walls = nodes of row where id == 0 or id == 9
    environment {{ gravity = (0, 0, 0) m/s^2 }}
    script {{ at 0 s: fix walls }}
    """
    known = along_x(lambda t: 0.04 + amplitude * shape[4] * np.sin(omega * t))
    return Case("fastest mode of a chain", text, 1.0, 4, known)


def pair(springs: str) -> str:
    """Return a mass beside a wall, its spring stretched by 1 mm."""
    return f"""
    tissue cord {{ {springs}; mass = 10 g }}
    body pair {{ mesh is explicit; tissue is cord }}
    table nodes of pair in mm with columns "id x" {{ 1 0; 2 11 }}
    table springs of pair in mm with columns "a b rest length" {{ 1 2 10 }}
    set wall = nodes of pair where id == 1
    environment {{ gravity = (0, 0, 0) m/s^2 }}
    script {{ at 0 s: fix wall }}
    """


def along_x(profile: Known) -> Known:
    """Return coordinates of which only x changes."""
    return lambda time: np.stack([profile(time), 0.0 * time, 0.0 * time], axis=1)


def closed_forms() -> str:
    """Return the error of each case at each tolerance."""
    methods = {f"tolerance {t:g}": f"tolerance = {t:g}" for t in TOLERANCES}
    methods["1e-3 by velocity verlet"] = "tolerance = 1e-3; integrator is velocity verlet"
    rows = [
        [case.name, *(f"{error(case, entries, 200):.1e}" for entries in methods.values())]
        for case in cases()
    ]
    return table(["motion", *methods], rows)


def error(case: Case, entries: str, frames: int) -> float:
    """Return the largest error relative to the largest displacement so far."""
    text = f"""language 1
    {case.scene}
    simulate {{ duration = {case.duration!r} s; {entries} }}
    output {{ trajectory every {case.duration / frames!r} s }}
    """
    with run(text) as trajectory:
        time, position = trajectory.times, trajectory.position[:, case.node]
    known = case.known(time)
    reach = np.maximum.accumulate(np.linalg.norm(known - known[0], axis=1))
    return float((np.linalg.norm(position - known, axis=1)[1:] / reach[1:]).max())


def orders() -> str:
    """Return how errors at the ends of fixed steps fall, for both methods."""
    case, frames = oscillator(0.1), 25
    rows: list[tuple[str, str, str]] = []
    for method, steps in {
        "velocity verlet": (2e-3, 1e-3, 5e-4, 2.5e-4),
        "dop853": (2e-2, 1e-2, 5e-3),
    }.items():
        found = [error(case, f"integrator is {method}; step = {h!r} s", frames) for h in steps]
        slope = np.polyfit(np.log(steps), np.log(found), 1)[0]
        shown = ", ".join(
            f"{e:.1e} at {1e3 * h:g} ms" for h, e in zip(steps, found, strict=True)
        )
        rows.append((code(method), shown, f"{slope:.2f}"))
    return table(("method", "errors", "observed order"), rows)


def rupture_time() -> str:
    """Return how well the time of a rupture is met: c v t + d v = strength."""
    text = """language 1
    tissue cord { spring constant = 40 N/m; viscosity = 1 N*s/m; mass = 10 g
      breaking force = 0.2 N }
    body pair { mesh is explicit; tissue is cord; rupture is allowed }
    table nodes of pair in mm with columns "id x" { 1 0; 2 10 }
    table springs of pair with columns "a b" { 1 2 }
    set wall = nodes of pair where id == 1
    set hand = nodes of pair where id == 2
    environment { gravity = (0, 0, 0) m/s^2 }
    script {
      at 0 s: fix wall
      from 0 s to 1 s: move hand by (20, 0, 0) mm using constant speed
    }
    simulate { duration = 1 s }
    """
    with run(text) as trajectory:
        (found,) = [event.time for event in trajectory.events if event.kind == "rupture"]
    due = (0.2 - 1.0 * 0.02) / (40.0 * 0.02)
    return table(
        ("known [s]", "found [s]", "error [s]"),
        [(repr(due), repr(found), f"{found - due:.1e}")],
    )


def run(text: str) -> Trajectory:
    """Return the result of a scene."""
    request = Request(Source("case.tis", text))
    compiled, _ = compile_request(request)
    folder = Path(tempfile.mkdtemp())
    return Trajectory.open(simulate(compiled, folder / "case.vtkhdf", request=request).path)


# --- shipped scenes ---------------------------------------------------------------------------


def scenes() -> str:
    """Return what ``tissuec validate`` measures on the shipped scenes."""
    heads = ("scene", "tolerance", "error of positions", "energy balance", "forces felt",
             "SciPy accurate to", "steps, ours : SciPy", "verdict")  # fmt: skip
    return table(heads, [scene_row(name, validated(name)) for name in SCENES])


def scene_row(name: str, found: dict[str, Any]) -> tuple[str, ...]:
    """Return one line of the table."""
    errors: dict[str, float] = {one["name"]: one["error"] for one in found["quantities"]}
    forces = [value for key, value in errors.items() if key.startswith("force")]
    tolerance = "none (fixed step)" if found["tolerance"] is None else f"{found['tolerance']:g}"
    verdict: str = "" if found["tolerance"] is None else found["verdict"]
    if verdict == "undecided":
        verdict = f"kept until {found['judged_until']:g} s"
    known = max(float(found["reference"]["uncertainty"]), float(np.finfo(float).eps))
    steps = f"{found['run']['accepted']} : {found['reference']['steps']}"
    tell(f"{name}: {found['verdict']}")
    numbers = (errors["position"], errors["energy balance"], max(forces), known)
    return (name, tolerance, *(f"{number:.1e}" for number in numbers), steps, verdict)


def validated(name: str) -> dict[str, Any]:
    """Return the JSON document of a validation."""
    scene = library() / "scenes" / f"{name}.tis"
    command = [sys.executable, "-m", "tissuec", "--json", "validate", str(scene)]
    return json.loads(subprocess.run(command, capture_output=True, text=True).stdout)


if __name__ == "__main__":
    main()
