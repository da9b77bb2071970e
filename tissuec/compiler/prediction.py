"""Prediction of a run: arrays, method, stability, skipped parts, cost and size."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.errors import counted
from tissuec.engine.execution.recorder import wishes
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import Method
from tissuec.engine.method_choice import choose, measured_facts
from tissuec.engine.method_trial import evaluation_time, step_time
from tissuec.engine.run_cost import RunCost, motion_seconds, run_cost
from tissuec.engine.static_cost import StaticCost, static_cost
from tissuec.model.network import Network
from tissuec.model.topology import join_nodes_of
from tissuec.results.size import ForeseenEvents, file_size
from tissuec.script.plan import EQUILIBRIUM, Plan
from tissuec.script.procedures import stated
from tissuec.script.verbs import Dividing, follows
from tissuec.script.verbs.tie import Tie

SWEEPS = 100  # of a relaxation, each about one evaluation of the forces


class Prediction(Struct, frozen=True):
    """The plan of a run.

    Attributes:
        arrays: Name -> shape, unit-free description and bytes.
        method: The integrator.
        reason: Why it.
        choices: What is chosen of a published procedure, as it is written.
        facts: Largest angular frequency ω̂ [1/s], damping radius [1/s], damping ratio, and the
            stability limit of the step [s] of the method; empty for statics.
        skipped: What the scene does not need and the run does not do.
        steps: At the stability limit, or of the fixed step; a tolerance may need more. Of
            statics, the equilibria.
        evaluations: Force evaluations for these steps; of statics, steps of Newton's method.
        seconds: What the command takes on one core of a present-day machine, without the
            companion run, and with kernels that were compiled before; NaN where only the
            tolerance decides how many steps there are, as with implicit methods.
        cost: The parts of this time.
        step_seconds: What one step takes [s].
        static: The equilibria, also those of "settle" in a run that moves.
        bytes: About those of the result file; the most if it is compressed.
        compress: Whether it is.
    """

    arrays: dict[str, dict[str, Any]]
    method: str
    reason: str
    choices: tuple[str, ...]
    facts: dict[str, float]
    skipped: tuple[str, ...]
    steps: float
    evaluations: float
    seconds: float
    cost: RunCost
    step_seconds: float
    static: StaticCost
    bytes: int
    compress: bool


def predict(compiled: Compiled) -> Prediction:
    """Return the prediction of the run of a compiled scene."""
    plan, network = compiled.plan, compiled.network
    state = state_at_start(compiled)
    simulation = plan.simulation
    method = Method(
        simulation.integrator, simulation.tolerance, simulation.step, simulation.duration,
        ledger=plan.needs_ledger, watch_strength=plan.breakable,
    )  # fmt: skip
    layout = KernelInputs(network, watched=plan.breakable, ledger=plan.needs_ledger)
    layout.update(state)
    springs = len(layout.springs.ids)
    one = evaluation_time(state, springs)

    def implicit_step() -> float:
        return step_time("esdirk43", one, layout.solving_cost) / one

    choice = choose(state, method, layout.is_direct, implicit_step)
    integrator = None if simulation.is_static else INTEGRATORS[choice.name]
    static, foreseen = static_cost(state, plan), _foreseen(plan)
    facts: dict[str, float] = {}
    if simulation.integrator == EQUILIBRIUM:
        steps, each = float(static.equilibria), static.steps / static.equilibria
        step_seconds = static.seconds / static.equilibria
    else:
        facts = dict(choice.facts) or measured_facts(state)
        limit = np.inf
        if facts["omega"] and integrator is not None:
            limit = integrator.stability_limit(facts["omega"], facts["zeta"])
        facts["limit"] = float(limit)
        step = simulation.step or limit
        # Of an unlimited method only the tolerance decides; without motion one step does.
        unknown = np.nan if facts["omega"] else 1.0
        steps = float(np.ceil(simulation.duration / step)) if np.isfinite(step) else unknown
        each = SWEEPS if integrator is None else integrator.evaluations
        step_seconds = (
            SWEEPS * one
            if integrator is None
            else step_time(choice.name, one, layout.solving_cost)
        )
    moving = motion_seconds(plan, state, integrator, steps, step_seconds)
    cost = run_cost(state, plan, foreseen, one, moving, static.seconds)
    return Prediction(
        arrays=_arrays(network),
        method=choice.name,
        reason=choice.reason,
        choices=tuple(stated(simulation.choices)),
        facts=facts,
        skipped=tuple(skipped(compiled)),
        steps=steps,
        evaluations=steps * each,
        seconds=cost.seconds,
        cost=cost,
        step_seconds=step_seconds,
        static=static,
        bytes=file_size(
            network, wishes(network, plan), plan.output, simulation.duration, foreseen
        ),
        compress=plan.output.compress,
    )


def _foreseen(plan: Plan) -> ForeseenEvents:
    """Return how many events and cuts are expected after the start."""
    end = plan.simulation.duration
    times: set[float] = set()
    for event in plan.events:
        duration: float | None = getattr(event.action, "duration", None)
        times |= {event.time, event.time + (duration or 0.0)}
    cuts = {e.time for e in plan.events if follows(e.action, Dividing) and 0.0 < e.time <= end}
    # Each condition is expected to become true once, springs that can break to do so once, and
    # each knot to slip and to hold again once.
    knots = sum(isinstance(event.action, Tie) for event in plan.events)
    others = len(plan.triggers) + plan.breakable + 2 * knots
    count = sum(0.0 < time <= end for time in times) + others
    return ForeseenEvents(count, len(cuts) + plan.breakable)


def _arrays(network: Network) -> dict[str, dict[str, Any]]:
    names = ("position", "velocity", "mass", "ends", "stiffness", "damping", "rest")
    names += ("strength", "crush")
    return {
        name: {
            "shape": list(network.array(name).shape),
            "bytes": int(network.array(name).nbytes),
        }
        for name in names
    }


def skipped(compiled: Compiled) -> Iterator[str]:
    """Yield the parts of a run that this scene does not need."""
    network, plan = compiled.network, compiled.plan
    solid = network.elements
    or_element = " and no element" if solid else ""
    if not (network.springs.behaviour.is_viscous or any(e.viscosity.any() for e in solid)):
        yield f"viscosity: no spring{or_element} has any"
    if not network.relaxes:
        yield f"relaxation and yielding: no spring{or_element} relaxes or yields"
    if not np.any(plan.gravity):
        yield "gravity: it is zero"
    if not plan.drag and network.drag is None:
        yield "ambient damping: none"
    if not plan.breakable:
        yield "rupture: not allowed in any body"
    elif not np.isfinite(network.springs.crush).any():
        yield "crushing: compression breaks no spring"
    if not plan.needs_ledger:
        yield "energies: not in the output"
    if not plan.triggers:
        yield "conditions: no when"
    if not np.isfinite(plan.output.every):
        yield "trajectory: not in the output"
    if not plan.output.logs:
        yield "logs: none in the output"
    state = state_at_start(compiled)
    held, still = state.held, state.still
    inner = int(join_nodes_of(network.springs.ends, held).sum())
    if inner:
        yield f"{counted(inner, 'spring')} between held nodes"
    moving = (each.moving(still) for each in solid)
    left = sum(each.item_count for each in moving if each is not None)
    if idle := sum(each.item_count for each in solid) - left:
        yield f"{counted(idle, 'element')} between held nodes"
    contact = network.contact
    if contact is None:
        yield "contact: nothing can be in contact"
    elif not contact.rubs:
        yield "friction: none"
    if not any(tool.kind == "nozzle" for tool in network.tools):
        yield "jets: no nozzle"
