"""Gradients of learning by effects: their error, and their time and memory against a run.

Takes some minutes. Each effect acts on a sphere of 642 nodes, and velocity Verlet steps it 1000
times. The derivatives of a sum of positions with random weights, by all masses, spring
constants, viscosities, rest lengths, start positions and numbers of the effect, are compared
with sixth-order differences in random directions. Times are those of the processor; memory is
the largest of a process that makes a run or a gradient alone.
"""

import resource
import subprocess
import sys
import time
from statistics import median

import click
import numpy as np

from benchmarks.publishing import publish, write_option
from tests.learn.test_motion import motion_of
from tests.learn.trials import difference
from tissuec.core.markdown import table
from tissuec.core.source import Source
from tissuec.learn.derivatives.motion import Motion
from tissuec.model.network import Floats
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SCENE = """language 1
tissue wall {{ spring constant = 20 N/m; viscosity = 2 mN*s/m; mass = 20 mg; {tissue} }}
body ball {{ mesh is sphere {{ centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 3 }}
  tissue is wall; {body} }}
set bottom = nodes of ball where z < -5 mm
set top = nodes of ball where z > 9 mm
{parts}
environment {{ gravity = (0, 0, -9.81) m/s^2; {environment} }}
script {{ from 0 s to 20 ms: move top by (2, 0, 3) mm using smooth profile; {script} }}
simulate {{ duration = 20 ms; tolerance = 1e-8 }}
"""
PLACES = ("tissue", "body", "parts", "environment", "script")
#: What is added to springs, by the places of the scene.
EFFECTS: dict[str, dict[str, str]] = {
    "springs alone": {},
    "preserved volume": {"script": "at 0 s: preserve volume of ball with 8 kPa"},
    "bending": {"body": "bending is elastic; thickness = 1 mm"},
    "foundation": {
        "parts": "force bed { kind is foundation; acts on bottom; stiffness = 200 kPa/m"
        "; damping = 30 Pa*s/m }"
    },
    "contact": {
        "parts": "tool plate { kind is plane; point = (0, 0, -11) mm; normal = (0.1, 0, 1) }",
        "environment": "contact is tools only; contact damping = 0.5 s/m",
        "script": "from 0 s to 15 ms: move plate by (0, 0, 4) mm using smooth profile",
    },
    "relaxing springs": {"tissue": "relaxing constant = 30 N/m; relaxation time = 5 ms"},
    "yielding springs": {"tissue": "yield force = 2 mN; yield viscosity = 0.2 N*s/m"},
}
TISSUE_OF_WALLS = "Young's modulus = 40 kPa; density = 1000 kg/m^3; retardation time = 0.3 ms"
STEP, TIMES = 20e-6, np.array([7e-3, 13e-3, 20e-3])
DIRECTIONS, REPEATS = 5, 5
#: Relative, of the changes between which differences are taken; the best counts, for small ones
#: are spoilt by rounding and large ones by where a law bends.
SIZES = (1e-5, 1e-6, 1e-7, 3e-8)
RUN, GRADIENT = "run", "gradient"


@click.command(help=__doc__)
@click.option("--alone", type=(str, click.Choice([RUN, GRADIENT])), hidden=True)
@write_option
def main(*, alone: tuple[str, str] | None, write: bool) -> None:
    """Measure everything, or make one run or gradient and print the memory of the process."""
    if alone is not None:
        made(*alone)
        click.echo(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        return
    rows = [row(effect) for effect in EFFECTS]
    head = (
        "effect", "numbers", "largest relative error", "time in runs",
        "memory of a run and of a gradient [MB]",
    )  # fmt: skip
    publish("gradients", {"effects": table(head, rows)}, write=write)


def row(effect: str) -> tuple[str, ...]:
    """Return the row of an effect."""
    motion, vector = motion_with(effect)
    ones = np.ones((len(TIMES), 3 * motion.order.sizes["mass"]))
    run, gradient = (memory(effect, what) for what in (RUN, GRADIENT))
    return (
        effect,
        str(np.count_nonzero(vector)),
        f"{error(motion, vector):.0e}",
        f"{cost(motion, vector, ones):.1f}",
        f"{run:.0f}, {gradient:.0f}",
    )


def motion_with(effect: str) -> tuple[Motion, Floats]:
    """Return the motion of the sphere with an effect, and its numbers."""
    text = SCENE.format(**(dict.fromkeys(PLACES, "") | EFFECTS[effect]))
    if effect == "bending":  # which follows from matter
        first, last = text.index("spring constant"), text.index(" }\nbody")
        text = text[:first] + TISSUE_OF_WALLS + text[last:]
    compiled, _ = compile_request(Request(Source("ball.tis", text)))
    return motion_of(compiled, "velocity verlet", STEP, TIMES, float(TIMES[-1]))


def error(motion: Motion, vector: Floats) -> float:
    """Return how far derivatives along some directions are from differences, at most.

    It is relative to the root mean square of these derivatives.

    Args:
        motion: The motion.
        vector: Its numbers in SI units, shape (number,).
    """
    random = np.random.default_rng(3)
    weights = random.standard_normal((len(TIMES), 3 * motion.order.sizes["mass"]))
    motion.forward(vector)
    gradient = motion.backward(weights, np.zeros_like(weights))
    found: list[float] = []
    exact: list[float] = []
    for _ in range(DIRECTIONS):
        way = random.standard_normal(len(vector)) * np.abs(vector)
        slopes = [difference(motion, vector, way, weights, step=size) for size in SIZES]
        exact.append(float(gradient @ way))
        found.append(min(abs(exact[-1] - slope) for slope in slopes))
    return max(found) / float(np.sqrt(np.mean(np.square(exact))))


def cost(motion: Motion, vector: Floats, weights: Floats, repeats: int = REPEATS) -> float:
    """Return the time of a gradient, with its run, over that of the run: the median.

    Args:
        motion: The motion, which has been computed before.
        vector: Its numbers in SI units, shape (number,).
        weights: Of positions and velocities, shape (time, 3 node).
        repeats: How often both are timed.
    """
    ratios: list[float] = []
    for _ in range(repeats):
        began = time.process_time()
        motion.forward(vector)
        forward = time.process_time() - began
        motion.backward(weights, weights)
        ratios.append((time.process_time() - began) / forward)
    return median(ratios)


def memory(effect: str, what: str) -> float:
    """Return the largest memory of a process that makes a run or gradient [MB]."""
    command = [sys.executable, "-m", "benchmarks.gradients", "--alone", effect, what]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return float(told.split()[-1]) / 1024.0


def made(effect: str, what: str) -> None:
    """Make one run, and a gradient."""
    motion, vector = motion_with(effect)
    samples = motion.forward(vector)
    if what == GRADIENT:
        motion.backward(np.ones_like(samples.x), np.ones_like(samples.x))


if __name__ == "__main__":
    main()
