"""Checks of the net: pieces, lengths of springs, strength, motions that nothing resists."""

import re
from collections.abc import Callable, Iterable, Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.checks import check, thorough_check
from tissuec.compiler.checks.supports import loose_bodies
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.errors import Diagnostic, Note, counted
from tissuec.core.hints import Edit, Hint
from tissuec.core.names import key_of
from tissuec.core.units import FORCE, LENGTH, MASS, STIFFNESS, TIME, VELOCITY, show
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.stability import damping_radius, damping_ratio, spectral_radius
from tissuec.mechanics.observables import lengths
from tissuec.mechanics.rest import rests_pressed
from tissuec.mechanics.state import State
from tissuec.model import topology
from tissuec.model.network import BodyPart, Indices, Network, numbers_in
from tissuec.scene.model import AssignedQuantity, Tissue
from tissuec.script.verbs.settle import Settle

MOST_SPRINGS_NAMED = 3
MOST_AT_A_NODE = 20  # springs as stiff as the stiffest
# Strain at break. Elastin, the most extensible of what tissues are made of, bears 1.5.
IMPLAUSIBLE, PLAUSIBLE = 3.0, 0.5
#: A number without a unit.
_PLAIN = re.compile(r"[0-9.]+")
# At which dashpots are tried; rates in 1/s.
STRAINS, RATES = (0.0, 0.1, 0.3, -0.1, -0.2), (1e-2, -1e-2, 1.0, -1.0, 10.0, -10.0)


@check
def pieces(compiled: Compiled) -> Iterator[Diagnostic]:
    """W301: a body that falls apart before anything is cut."""
    for body, ends in _bodies(compiled, with_joints=True):
        # Nodes without any spring are a matter of their own.
        has_springs = np.zeros(body.size.nodes, dtype=bool)
        has_springs[ends.ravel()] = True
        found = topology.pieces(body.size.nodes, ends)[has_springs]
        count = np.count_nonzero(np.bincount(found))
        if count > 1:
            yield Diagnostic(
                "W301",
                f"{body.name} starts in {count} pieces",
                body.span,
                "join them with springs, or make them two bodies",
            )


@check
def dangling(compiled: Compiled) -> Iterator[Diagnostic]:
    """W302: nodes that no spring holds."""
    joined = compiled.network.joined_ends
    for body, ends in _bodies(compiled):
        if not len(ends):
            continue
        own = joined[(joined >= body.nodes.start) & (joined < body.nodes.stop)]
        bare = np.ones(body.size.nodes, dtype=bool)
        bare[ends] = bare[own - body.nodes.start] = False
        if loose := int(np.count_nonzero(bare)):
            yield Diagnostic(
                "W302",
                f"{body.name} has {counted(loose, 'node')} without springs",
                body.span,
                "a node without springs moves freely; remove it, or add springs",
            )


@thorough_check
def floppy(
    compiled: Compiled, count: Callable[..., topology.FloppyModes] = topology.floppy_modes
) -> Iterator[Diagnostic]:
    """W303: ways to move that no spring resists.

    Args:
        count: Counts them; whoever checks often can remember what was counted.
    """
    network = compiled.network
    held = state_at_start(compiled).held
    loose = {
        body.name for one in loose_bodies(network, compiled.plan)[0] for body in one.bodies
    }
    for body, ends in _bodies(compiled):
        # Threads are meant to fold, and elements resist what springs do not.
        if not len(ends) or body.thread is not None or body.is_made_of_elements:
            continue
        nodes, springs = numbers_in(body.nodes), numbers_in(body.springs)
        if body.name not in loose:  # else what it is joined to moves with it
            nodes, springs = _with_joined(network, body)
        ends = np.searchsorted(nodes, network.springs.ends[springs]).astype(np.int32)
        position, rest, stiffness = (
            network.position[nodes],
            network.springs.rest,
            network.springs.stiffness,
        )
        # Everything it is joined to is held, so that the rest is a mode of its own.
        still = held[nodes] | (nodes < body.nodes.start) | (nodes >= body.nodes.stop)
        modes = count(position, ends, stiffness[springs], rest[springs], still)
        if not (modes.checked and modes.count):
            continue
        reason = "it can deform without stretching any spring"
        hint = "add diagonals or interior springs, a larger reach of the lattice, or prestress"
        slack = stiffness[springs] == 0.0
        if slack.any():
            stiff = np.where(slack, stiffness[springs].max(initial=1.0), stiffness[springs])
            if count(position, ends, stiff, rest[springs], still).count < modes.count:
                zeros = int(np.count_nonzero(slack))
                reason = f"the spring constant of {zeros} of its {len(springs)} springs is 0"
                hint = "write spring constants above 0"
        text = f"{body.name} has {counted(modes.count, 'floppy mode')}: {reason}"
        yield Diagnostic("W303", text, body.span, hint)


def uncounted(compiled: Compiled) -> list[str]:
    """Return the bodies that are too large to have their floppy modes counted."""
    held = state_at_start(compiled).held
    return [
        body.name
        for body in compiled.network.bodies
        if not body.is_made_of_elements
        and 3 * np.count_nonzero(~held[body.nodes]) > topology.LARGEST_CHECK
    ]


def unstable_node(state: State) -> int | None:
    """Return the node that moves most as a net buckles; see ``mechanics.stability``."""
    from tissuec.mechanics import stability  # SciPy: only where it is needed

    return stability.unstable_node(state)


@thorough_check
def unstable(
    compiled: Compiled, find: Callable[[State], int | None] = unstable_node
) -> Iterator[Diagnostic]:
    """W307: the net rests at 0 s where it would buckle.

    Args:
        find: Finds the node that moves most as it buckles; who checks often can put it off.
    """
    plan = compiled.plan
    if any(event.time == 0.0 and isinstance(event.action, Settle) for event in plan.events):
        return
    state = state_at_start(compiled)
    if not rests_pressed(state):
        return
    if (node := find(state)) is None:
        return
    network = compiled.network
    body = network.body_at(node)
    yield Diagnostic(
        "W307",
        f"{body.name} starts in an unstable equilibrium: any disturbance makes it "
        f"buckle, mainly at node {network.node_ids[node]}",
        body.span,
        'let it settle ("at 0 s: settle"), push it slightly to one side, or compress it less',
    )


@check
def zero_lengths(compiled: Compiled) -> Iterator[Diagnostic]:
    """W304: springs between nodes at one place, which have no direction."""
    network = compiled.network
    length = lengths(network.springs.ends, network.position)
    for body in network.parts:
        zero = np.flatnonzero(length[body.springs] == 0.0)
        if len(zero):
            ids = ", ".join(
                str(i) for i in network.springs.ids[body.springs][zero[:MOST_SPRINGS_NAMED]]
            )
            more = ", …" if len(zero) > MOST_SPRINGS_NAMED else ""
            yield Diagnostic(
                "W304",
                f"{body.name} has {counted(len(zero), 'spring')} between nodes at the same "
                f"position (id {ids}{more})",
                body.span,
                _of_zero_length(compiled, body.name),
            )


def _of_zero_length(compiled: Compiled, name: str) -> str:
    """Return the hint about springs of length zero of a body or joint."""
    why = "a spring of length zero has no direction and no force until its ends separate"
    joint = compiled.scene.joints.get(key_of(name))
    if joint is None:
        return why
    hosts = compiled.network.elements
    for side, other in (joint.ends, joint.ends[::-1]):
        nodes = compiled.groups.nodes(other).indices
        if any(np.isin(one.nodes, nodes).any() for one in hosts):
            glue = f"glue from {side.text} to {other.text}"
            return f"{why}; to tie the bodies, write in the joint: {glue}"
    return why


@check
def small_prestress(compiled: Compiled) -> Iterator[Diagnostic]:
    """W305: rest lengths of zero or less, which make a spring pull for ever."""
    network = compiled.network
    drawn = lengths(network.springs.ends, network.position)
    for body in network.parts:
        rest = network.springs.rest[body.springs]
        bad = rest[(rest <= 0.0) & (drawn[body.springs] > 0.0)]
        if len(bad):
            yield Diagnostic(
                "W305",
                f"{body.name} has {counted(len(bad), 'spring')} with a rest length of zero or "
                f"less (down to {show(float(bad.min()), LENGTH)})",
                body.span,
                "such a spring pulls until its ends meet; give it a rest length above zero",
            )


@check
def driving_dashpots(compiled: Compiled) -> Iterator[Diagnostic]:
    """W308: dashpots by a law of their own that drive what they should brake."""
    network = compiled.network
    behaviour = network.springs.behaviour
    if behaviour.is_linear:
        return
    for strain, rate in product(STRAINS, RATES):
        stretch, speed = strain * network.springs.rest, rate * network.springs.rest
        brakes = behaviour.brake(stretch, speed)
        worst = np.flatnonzero(brakes * speed < -1e-9 * np.abs(brakes * speed).max(initial=0.0))
        for spring in worst[:1].tolist():
            owner = network.owner(spring)
            yield Diagnostic(
                "W308",
                f"dashpots of {owner.name} add energy: spring "
                f"{network.springs.ids[spring]} with {show(float(brakes[spring]), FORCE)} at a "
                f"strain of {strain:g} and {show(float(speed[spring]), VELOCITY)}",
                owner.span,
                "write max(…, 0) around the factor of the speed, which must not be negative",
            )
            return


@check
def unstable_step(compiled: Compiled) -> Iterator[Diagnostic]:
    """W403: a fixed step above what the method can bear."""
    simulation = compiled.plan.simulation
    if simulation.step is None or simulation.is_static:
        return
    state = state_at_start(compiled)
    omega = spectral_radius(state)
    zeta = damping_ratio(omega, damping_radius(state))
    limit = INTEGRATORS[simulation.integrator].stability_limit(omega, zeta)
    if simulation.step > limit:
        yield Diagnostic(
            "W403",
            f"step {show(simulation.step, TIME)} exceeds the stability estimate "
            f"{show(limit, TIME)}: {_stiffest(compiled.network, omega)}",
            simulation.span,
            "write a smaller step, or a tolerance instead",
        )


def _stiffest(network: Network, omega: float) -> str:
    """Name the spring, or the elements, that require the smallest step.

    Args:
        omega: The largest angular frequency [1/s].
    """
    springs = network.springs
    share = springs.sudden * (1.0 / network.mass[springs.ends]).sum(axis=1)
    solid = [part.name for part in network.bodies if part.is_made_of_elements]
    if solid and omega**2 > MOST_AT_A_NODE * float(share.max(initial=0.0)):
        return f"the stiffest are the elements of {' and '.join(solid)}"
    spring = int(share.argmax())
    part = network.owner(spring)
    mass = float(network.mass[springs.ends[spring]].min())
    return (
        f"spring {springs.ids[spring]} of {part.name} has "
        f"{show(float(springs.sudden[spring]), STIFFNESS)} at a node of {show(mass, MASS)}"
    )


@thorough_check
def late_breaking(compiled: Compiled) -> Iterator[Diagnostic]:
    """W209: springs and elements that break at a strain which no tissue bears.

    Left out are threads, many of which are made softer so that steps are longer, and nets typed
    in as tables, which need not be tissue.
    """
    network = compiled.network
    yield from _late_elements(compiled)
    if not np.isfinite(network.springs.strength).any():
        return
    from tissuec.matter.breaking import breaking_strains

    strain = breaking_strains(network.springs.behaviour, network.springs.strength)
    for body in network.bodies:
        springs = numbers_in(body.springs)
        springs = springs[np.isfinite(strain[springs])]
        is_typed = compiled.scene.bodies[key_of(body.name)].tables is not None
        if body.thread is not None or is_typed or not len(springs):
            continue
        median = int(springs[np.argsort(strain[springs])[len(springs) // 2]])
        if strain[median] > IMPLAUSIBLE:
            tissues = compiled.scene.tissues.values()
            yield _breaks_late(network, tissues, body, median, float(strain[median]))


def _late_elements(compiled: Compiled) -> Iterator[Diagnostic]:
    """Yield bodies whose elements have a breaking strain that no tissue bears."""
    network = compiled.network
    tissues = list(compiled.scene.tissues.values())
    for body in network.bodies:
        for field in network.elements:
            limits = field.limits if field.name == body.name else None
            strain = np.zeros(0) if limits is None else limits.strain
            late = np.flatnonzero(np.isfinite(strain) & (strain > IMPLAUSIBLE))
            if limits is None or not len(late):
                continue
            place = network.provenance["breaking"][
                int(field.walls[late[0]]) - network.line_count
            ].span
            known = (one for tissue in tissues for one in tissue.given.values())
            given = next((one for one in known if one.span == place), None)
            stretch = 1.0 + float(strain[late[0]])
            yield Diagnostic(
                "W209",
                f"elements of {body.name} break only at {stretch:.3g} times their length",
                body.span,
                Hint("") if given is None else _smaller_strain(given),
                (Note("the breaking strain", place),),
            )
            break


def _breaks_late(
    network: Network, tissues: Iterable[Tissue], body: BodyPart, spring: int, strain: float
) -> Diagnostic:
    rest, force = float(network.springs.rest[spring]), float(network.springs.strength[spring])
    constant = float(network.springs.stiffness[spring])
    arrays = {"breaking force": "strength", "spring constant": "stiffness"}
    return Diagnostic(
        "W209",
        f"springs of {body.name} break only at {1.0 + strain:.3g} times their length: one of "
        f"{show(rest, LENGTH)} has a spring constant of {show(constant, STIFFNESS)} and a "
        f"breaking force of {show(force, FORCE)}",
        body.span,
        _breaking_early(network, tissues, spring),
        tuple(
            Note(f"the {name}", network.provenance[array][spring].span)
            for name, array in arrays.items()
        ),
    )


def _breaking_early(network: Network, tissues: Iterable[Tissue], spring: int) -> Hint:
    """Return a hint to write a limit at which a spring breaks at a strain that tissue bears."""
    place = network.provenance["strength"][spring].span
    limits = ((tissue, one) for tissue in tissues for one in tissue.given.values())
    tissue, given = next((pair for pair in limits if pair[1].span == place), (None, None))
    if given is None or given.how != "written" or not given.quantity.is_of_matter:
        better = show(
            float(network.springs.behaviour.pull(PLAUSIBLE * network.springs.rest)[spring]),
            FORCE,
        )
        how = "" if tissue is None else f' (--set "breaking force of {tissue.name} = {better}")'
        return Hint(
            f"{better} would break it at {1.0 + PLAUSIBLE:g} times its length{how}, where most "
            "tissue has torn; tissues of matter/ have a breaking strain instead. If nothing is "
            "to tear in this run, leave it as it is"
        )
    return _smaller_strain(given)


def _smaller_strain(given: AssignedQuantity) -> Hint:
    """Return a hint to write a strain that tissue bears in place of a limit."""
    place, strain = given.span, f"{PLAUSIBLE:.0%}".replace("%", " %")
    name, entry = given.quantity.name, f"breaking strain = {strain}"
    if name != "breaking strain":
        return Hint(f"write {entry} instead of the {name}", Edit(entry, place))
    number = place.text.partition("=")[2].strip()
    if _PLAIN.fullmatch(number) and given.value / 100.0 <= IMPLAUSIBLE:
        entry = f"breaking strain = {number} %"
        question = f"is a strain of {given.value:.0%} meant?".replace("%", " %")
        return Hint(f"{question} otherwise write {entry}", Edit(entry, place))
    return Hint(f"write a smaller strain, such as {entry}", Edit(entry, place))


def _bodies(
    compiled: Compiled, *, with_joints: bool = False
) -> Iterator[tuple[BodyPart, NDArray[np.int32]]]:
    """Yield each body with the node pairs of its springs or edges, numbered within the body.

    Args:
        with_joints: Whether springs of joints between its nodes count as well.
    """
    network = compiled.network
    joined = network.joined_ends
    for body in network.bodies:
        ends = network.line_ends[body.lines]
        if with_joints:
            inside = (joined >= body.nodes.start) & (joined < body.nodes.stop)
            ends = np.concatenate([ends, joined[inside.all(axis=1)]])
        yield body, ends - np.int32(body.nodes.start)


def _with_joined(network: Network, body: BodyPart) -> tuple[Indices, Indices]:
    """Return a body's nodes and springs, with springs that join it and nodes at their ends."""
    joined = network.joined_ends
    beside = ((joined >= body.nodes.start) & (joined < body.nodes.stop)).any(axis=1)
    own = numbers_in(body.nodes)
    nodes = np.union1d(own, joined[beside])
    springs = numbers_in(body.springs)
    further = network.body_springs + np.flatnonzero(beside)
    return nodes.astype(np.int64), np.append(springs, further)
