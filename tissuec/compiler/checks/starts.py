"""Checks of how a scene starts: prestress out of balance, and the cost."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.checks import check
from tissuec.compiler.checks.nets import MOST_AT_A_NODE
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.arrays import norm
from tissuec.core.errors import Diagnostic, Note, counted
from tissuec.core.units import FORCE, STIFFNESS, TIME, show
from tissuec.mechanics.observables import lengths
from tissuec.mechanics.rest import AT_REST, pulls
from tissuec.model.network import BodyPart, JointPart, Network
from tissuec.script.plan import RELAXATION, ScheduledAction
from tissuec.script.verbs import Shifting, follows
from tissuec.script.verbs.push import Push
from tissuec.script.verbs.settle import Settle

if TYPE_CHECKING:
    from tissuec.compiler.prediction import Prediction

UNSTRETCHED = ("none", "table")  # how rest lengths are given without prestress
LONG = 60.0  # [s]: a run that takes longer is announced
# [s] for a spring in a step at the limit of stability: less than docs/numerics.md measures.
SPRING = 2e-9
MANY_SPRINGS = 50_000  # of a net whose implicit steps may be expensive
FEW_SPRINGS = 500  # of one whose equilibria are not
FEW_STEPS = 100  # of an implicit method, which takes at least about 30 in any motion


def settles_at_start(compiled: Compiled) -> bool:
    """Return whether the script settles the net at 0 s."""
    events = compiled.plan.events
    return any(event.time == 0.0 and isinstance(event.action, Settle) for event in events)


@check
def out_of_balance(compiled: Compiled) -> Iterator[Diagnostic]:
    """W309: prestress that moves a net at 0 s.

    Weight is left out: a body that is let go sags, as everybody expects. So are rest lengths of
    tables, which are typed in to make a net swing, and scenes in which nothing moves until some
    time later: they wait for the net to come to rest.
    """
    network = compiled.network
    is_stressed = _stressed_springs(network)
    solid = [one for one in network.elements if one.is_prestressed]
    if not (is_stressed.any() or solid):
        return
    if settles_at_start(compiled) or compiled.plan.simulation.is_static:
        return
    if _waits(compiled.plan.events):
        return
    state = state_at_start(compiled)
    if not state.held.any():  # what is free contracts, and nobody feels its prestress
        return
    tension, force = pulls(state)
    largest = np.abs(tension).max(initial=0.0)
    if solid:
        for one in solid:
            one.add_forces(0.0, state.position, np.zeros_like(force), force)
        largest = max(largest, norm(force).max())
    force[state.held] = 0.0
    each = norm(force)
    node = int(each.argmax())
    if each[node] <= AT_REST * largest:
        return
    is_solid = any((one.nodes == node).any() for one in solid)
    springs = (network.springs.ends == node).any(axis=1)
    if not (is_solid or is_stressed[springs].any()):  # typed in to swing
        return
    body = network.body_at(node)
    yield Diagnostic(
        "W309",
        f"{body.name} is not in equilibrium at 0 s: prestress pulls with up to "
        f"{show(float(each[node]), FORCE)} at node {network.node_ids[node]}",
        body.span,
        'let it settle (write "at 0 s: settle" after what is fixed there); otherwise forces at '
        "the start are those of its first motion",
    )


def _stressed_springs(network: Network) -> NDArray[np.bool_]:
    """Return which springs a prestress makes longer or shorter than at rest, (spring,)."""
    known = network.provenance["rest"]
    given = np.array([origin.how not in UNSTRETCHED for origin in known.origins])
    if not given.any():
        return np.broadcast_to(False, known.index.shape)
    drawn = lengths(network.springs.ends, network.position)
    return given[known.index] & (network.springs.rest != drawn)


def _waits(events: Sequence[ScheduledAction]) -> bool:
    """Return whether nothing but holding happens at 0 s, and something happens later."""
    acts = (
        isinstance(e.action, Push) or follows(e.action, Shifting) for e in events if not e.time
    )
    return any(event.time > 0.0 for event in events) and not any(acts)


@check
def costly(compiled: Compiled) -> Iterator[Diagnostic]:
    """W413: a run of more than a minute, with the tissue that causes it."""
    network, simulation = compiled.network, compiled.plan.simulation
    if simulation.integrator == RELAXATION or not network.line_count:
        return
    # No frequency is above this bound, and most are not far below it.
    share = network.springs.sudden / network.mass[network.springs.ends].T
    stiffest = share.max(axis=0)
    omega = np.sqrt(2.0 * MOST_AT_A_NODE * float(stiffest.max(initial=0.0)))
    is_long = simulation.duration * omega * network.spring_count * SPRING >= LONG
    solid = [part for part in network.bodies if part.is_made_of_elements]
    is_large = network.line_count > (FEW_SPRINGS if simulation.is_static else MANY_SPRINGS)
    if not (is_large or (not simulation.is_static and (is_long or solid))):
        return
    from tissuec.compiler.prediction import predict  # where it may be long

    expected = predict(compiled)
    balancing, moving = expected.cost.equilibria, expected.cost.motion
    solving = expected.cost.solving  # NaN where only the tolerance decides
    if balancing + np.nan_to_num(moving) > LONG and not moving > balancing:
        yield _expensive_equilibria(network, expected, is_static=simulation.is_static)
    elif solving > LONG:
        if solid and expected.facts["omega"] > omega:
            yield _too_many_steps_of(solid, solving)
            return
        # Springs between held nodes do not count. Of those that differ by rounding alone, the
        # first, on every processor.
        held = state_at_start(compiled).held
        stiffest = np.where(held[network.springs.ends].all(axis=1), 0.0, stiffest)
        first = int((stiffest >= (1.0 - 1e-9) * stiffest.max()).argmax())
        yield _too_many_steps(network, first, solving)
    elif np.isnan(solving) and FEW_STEPS * expected.step_seconds > LONG:
        yield _expensive_steps(network, expected)


def _too_many_steps(network: Network, spring: int, seconds: float) -> Diagnostic:
    """Return a warning of a run of explicit steps that a spring makes short."""
    owner, origin = network.owner(spring), network.provenance["stiffness"][spring]
    return Diagnostic(
        "W413",
        f"the run takes about {_minutes(seconds)} at the steps that it needs, "
        f"mainly for spring {network.springs.ids[spring]} of {owner.name} with "
        f"{show(float(network.springs.sudden[spring]), STIFFNESS)}",
        owner.span,
        "use softer tissue or larger cells there, a wall with a thickness for a thin stiff "
        "layer, a shorter duration, or settle for equilibria",
        (Note("the stiffness", origin.span),),
    )


def _too_many_steps_of(solid: Sequence[BodyPart], seconds: float) -> Diagnostic:
    """Return a warning of a run of explicit steps that elements make short."""
    return Diagnostic(
        "W413",
        f"the run takes about {_minutes(seconds)} at the steps that it needs, mainly for the "
        f"elements of {' and '.join(part.name for part in solid)}",
        solid[0].span,
        "use softer tissue, a smaller Poisson's ratio or larger cells there, an implicit "
        "integrator, a shorter duration, or settle for equilibria",
    )


def _expensive_steps(network: Network, expected: "Prediction") -> Diagnostic:
    """Return a warning of a run whose steps solve the equations of a large body."""
    largest = max(network.parts, key=_size)
    is_solid = isinstance(largest, BodyPart) and largest.is_made_of_elements
    known = network.provenance["stiffness"]
    notes = () if is_solid else (Note("the stiffness", known[largest.springs.start].span),)
    steps = f"{FEW_STEPS} steps take {_minutes(FEW_STEPS * expected.step_seconds)}"
    count = _size(largest)
    size = f"{counted(count, 'edge')} of elements" if is_solid else counted(count, "spring")
    return Diagnostic(
        "W413",
        f"the run takes long: a step of {expected.method} takes about "
        f"{show(expected.step_seconds, TIME, digits=2)}, mainly for the {size} of "
        f"{largest.name}; {steps}, and the tolerance decides how many there are",
        largest.span,
        "use larger cells there, or settle for equilibria",
        notes,
    )


def _size(part: BodyPart | JointPart) -> int:
    """Return how many springs or edges a body or joint has."""
    return int(part.lines.stop - part.lines.start)


def _expensive_equilibria(
    network: Network, expected: "Prediction", *, is_static: bool
) -> Diagnostic:
    """Return a warning of many or large equilibria."""
    largest = max(network.parts, key=_size)
    equilibria, steps, seconds, _ = expected.static
    number = counted(equilibria, "equilibrium")
    return Diagnostic(
        "W413",
        f"the run takes about {_minutes(seconds)} for {number}, mainly for {largest.name}: a "
        f"step of Newton's method takes about {show(seconds / steps, TIME, digits=2)}",
        largest.span,
        "use larger cells where little happens"
        + ("; fewer outputs and a longer step need fewer equilibria" if is_static else ""),
    )


def _minutes(seconds: float) -> str:
    """Return a duration in words, with the unit that suits it."""
    for size, unit in ((86400.0, "day"), (3600.0, "hour")):
        if seconds >= size:
            return counted(round(seconds / size), unit)
    return counted(round(seconds / 60.0), "minute")
