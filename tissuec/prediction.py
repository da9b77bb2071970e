"""What a run will do, told before it runs: arrays, method, stability, skips, cost, size."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from tissuec.checks import situation_at_start
from tissuec.compiler import Compiled
from tissuec.core.errors import counted
from tissuec.engine.choice import choose, measured_facts
from tissuec.engine.layout import Layout
from tissuec.engine.method import Method
from tissuec.integrators import INTEGRATORS
from tissuec.network import Network
from tissuec.plan import RELAXATION, SurfaceOutput
from tissuec.results.polydata import frames_of_a_chunk

SECONDS = 5.5e-9  # per spring and force evaluation, everything included, measured
FRAME_VALUES = 9  # position, velocity and force of a node
SWEEPS = 100  # of a relaxation, each about one evaluation of the forces
LOG_VALUES = 4  # the time, and at most a vector
ENERGY_VALUES = 7  # the time, and six kinds of energy
STEP_VALUES = 24  # of a frame: its time, and where its numbers begin in each array
CHUNK_VALUES = 1024  # numbers of a column that are allocated at once, at most
EMPTY_FILE = 220_000  # bytes of groups, attributes and the first chunk of each table, measured


@dataclass(frozen=True, slots=True)
class Prediction:
    """The plan of a run.

    Attributes:
        arrays: Name -> shape, unit-free description and bytes.
        method: The integrator.
        reason: Why it.
        facts: Largest angular frequency ω̂ [1/s], damping radius [1/s], damping ratio, and the
            stability limit of the step [s] of the method.
        skipped: What the scene does not need and the run does not do.
        steps: At the stability limit, or of the fixed step; a tolerance may need more.
        evaluations: Force evaluations for these steps.
        seconds: What these take on one core of a present-day machine, compiled.
        bytes: Of the result file before compression.
    """

    arrays: dict[str, dict[str, Any]]
    method: str
    reason: str
    facts: dict[str, float]
    skipped: tuple[str, ...]
    steps: float
    evaluations: float
    seconds: float
    bytes: int


def predict(compiled: Compiled) -> Prediction:
    """Return what the run of a compiled scene will do."""
    plan, network = compiled.plan, compiled.network
    situation = situation_at_start(compiled)
    simulation = plan.simulation
    method = Method(
        simulation.integrator, simulation.tolerance, simulation.step, simulation.duration,
        ledger=plan.needs_ledger, watch_strength=plan.breakable,
    )  # fmt: skip
    layout = Layout(network, watched=plan.breakable, ledger=plan.needs_ledger)
    layout.update(situation)
    choice = choose(situation, method, layout.is_banded)
    integrator = None if choice.name == RELAXATION else INTEGRATORS[choice.name]
    facts = measured_facts(situation)
    limit = np.inf
    if facts["omega"] and integrator is not None:
        limit = integrator.stability_limit(facts["omega"], facts["zeta"])
    facts["limit"] = float(limit)
    step = simulation.step or limit
    # Of an unlimited method only the tolerance decides; without motion one step does.
    unknown = np.nan if facts["omega"] else 1.0
    steps = float(np.ceil(simulation.duration / step)) if np.isfinite(step) else unknown
    evaluations = steps * (SWEEPS if integrator is None else integrator.evaluations)
    return Prediction(
        arrays=_arrays(network),
        method=choice.name,
        reason=choice.reason,
        facts=facts,
        skipped=tuple(skipped(compiled)),
        steps=steps,
        evaluations=evaluations,
        seconds=evaluations * network.spring_count * SECONDS,
        bytes=_file_size(compiled),
    )


def _arrays(network: Network) -> dict[str, dict[str, Any]]:
    names = ("position", "velocity", "mass", "ends", "stiffness", "damping", "rest")
    names += ("strength", "crush")
    return {
        name: {
            "shape": list(getattr(network, name).shape),
            "bytes": int(getattr(network, name).nbytes),
        }
        for name in names
    }


def skipped(compiled: Compiled) -> Iterator[str]:
    """Yield what the run of this scene leaves out, because the scene does not need it."""
    network, plan = compiled.network, compiled.plan
    if not compiled.network.behaviour().is_viscous:
        yield "viscosity: no spring has any, so velocities are not compared"
    if network.inelastic is None:
        yield "memory: no spring relaxes or yields, so nothing of the past is kept"
    if not np.any(plan.gravity):
        yield "gravity: it is zero"
    if not plan.drag:
        yield "ambient damping: none is written"
    if not plan.breakable:
        yield "rupture: no body may rupture, so tensions are not watched"
    elif not np.isfinite(network.crush).any():
        yield "crushing: pressure breaks no spring, so only tensions are watched"
    if not plan.needs_ledger:
        yield "energies: not asked for, so work and dissipation are not integrated"
    if not plan.triggers:
        yield "conditions: no when, so steps are not looked at one by one"
    if not np.isfinite(plan.output.every):
        yield "trajectory: none is asked for"
    if not plan.output.logs:
        yield "logs: none are asked for"
    held = situation_at_start(compiled).held
    inner = int(held[network.ends].all(axis=1).sum())
    if inner:
        yield f"{counted(inner, 'spring')} between held nodes, left out of the sums"
    if plan.contact is None:
        yield "contact: nothing can touch"
    elif not plan.contact.friction:
        yield "friction: none is written, so contact remembers nothing"
    if not any(tool.kind == "nozzle" for tool in network.tools):
        yield "jets: there is no nozzle"


def _file_size(compiled: Compiled) -> int:
    """Return how large the result file is at most [bytes], but for what events add."""
    output, duration = compiled.plan.output, compiled.plan.simulation.duration
    network = compiled.network
    total = EMPTY_FILE + sum(array["bytes"] for array in _arrays(network).values())
    word = 4 if output.single else 8
    if np.isfinite(output.every):
        nodes = len(output.frames)
        cells = network.spring_count + len(network.skin)
        batch = frames_of_a_chunk(nodes)
        frames = batch * ceil((duration / output.every + 2) / batch)
        steps = CHUNK_VALUES * ceil(frames / CHUNK_VALUES) * 8 * STEP_VALUES
        total += frames * word * (FRAME_VALUES * nodes + cells) + steps
    for log in output.logs:
        total += _table(duration / log.every, LOG_VALUES)
    for surface in output.surfaces:
        total += int(duration / surface.every + 1) * word * 3 * _points(network, surface)
    if np.isfinite(output.energy):
        total += _table(duration / output.energy, ENERGY_VALUES)
    return total


def _table(rows: float, values: int) -> int:
    """Return the bytes of a log, whose columns grow by chunks."""
    return CHUNK_VALUES * ceil((rows + 1) / CHUNK_VALUES) * 8 * values


def _points(network: Network, surface: SurfaceOutput) -> int:
    """Return about how many points a smooth surface has: half as many as triangles."""
    (body,) = (body for body in network.bodies if body.name == surface.body)
    inside = (network.skin >= body.nodes.start) & (network.skin < body.nodes.stop)
    return int(inside.all(axis=1).sum()) * 4**surface.smoothing.subdivisions // 2
