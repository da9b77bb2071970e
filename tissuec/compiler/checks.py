"""Checks of a compiled scene: one small generator per rule, each yields diagnostics.

All of them are warnings about scenes that can be run but may not mean what their author thinks.
"""

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.compiler.compile import Compiled
from tissuec.compiler.selections import extents
from tissuec.compiler.thread_checks import passing_threads, turning_contact_on
from tissuec.core.errors import Diagnostic, Note, SimulationError, counted
from tissuec.core.hints import Hint, leaving_out
from tissuec.core.names import key_of
from tissuec.core.units import FORCE, LENGTH, MASS, STIFFNESS, TIME, VELOCITY, show
from tissuec.engine.execution.failure_messages import explain_action
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.stability import damping_radius, spectral_radius
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.matter.breaking import breaking_strains
from tissuec.mechanics.observables import lengths
from tissuec.mechanics.rest import rests_pressed
from tissuec.mechanics.state import State
from tissuec.model import topology
from tissuec.model.network import BodyPart, Floats, Indices, Network, numbers_in
from tissuec.scene.declarations import Declarations
from tissuec.scene.model import Tissue
from tissuec.script.plan import RELAXATION
from tissuec.script.verbs import Action, ActionFailed, Breaking, LoggedEvent, Shifting, follows
from tissuec.script.verbs.cut import Cut
from tissuec.script.verbs.settle import Settle

Check = Callable[[Compiled], Iterator[Diagnostic]]
MOST_SPRINGS_NAMED = 3
# Strain at break. Elastin, the most extensible of what tissues are made of, bears 1.5.
IMPLAUSIBLE, PLAUSIBLE = 3.0, 0.5
# At which dashpots are tried; rates in 1/s.
STRAINS, RATES = (0.0, 0.1, 0.3, -0.1, -0.2), (1e-2, -1e-2, 1.0, -1.0, 10.0, -10.0)


def check_all(compiled: Compiled, *, thorough: bool) -> list[Diagnostic]:
    """Return the warnings of every check.

    Args:
        thorough: Whether to make also those that take time, or are of use only to whoever asks.
    """
    checks = (*CHECKS, *(THOROUGH if thorough else ()))
    return [finding for check in checks for finding in check(compiled)]


def pieces(compiled: Compiled) -> Iterator[Diagnostic]:
    """W301: a body that falls apart before anything is cut."""
    for body, ends in _bodies(compiled, with_joints=True):
        # Nodes without any spring are a matter of their own.
        count = len(np.unique(topology.pieces(_size(body), ends)[np.unique(ends)]))
        if count > 1:
            yield Diagnostic(
                "W301",
                f"{body.name} starts in {count} pieces",
                body.span,
                "join them with springs, or make them two bodies",
            )


def dangling(compiled: Compiled) -> Iterator[Diagnostic]:
    """W302: nodes that no spring holds."""
    joined = compiled.network.ends[compiled.network.body_springs :]
    for body, ends in _bodies(compiled):
        if not len(ends):
            continue
        own = joined[(joined >= body.nodes.start) & (joined < body.nodes.stop)]
        loose = _size(body) - len(np.union1d(ends, own - body.nodes.start))
        if loose:
            yield Diagnostic(
                "W302",
                f"{body.name} has {counted(loose, 'node')} without springs",
                body.span,
                "a node without springs moves freely; remove it, or add springs",
            )


def floppy(
    compiled: Compiled, count: Callable[..., topology.FloppyModes] = topology.floppy_modes
) -> Iterator[Diagnostic]:
    """W303: ways to move that no spring resists.

    Args:
        count: Counts them; whoever checks often can remember what was counted.
    """
    network = compiled.network
    held = state_at_start(compiled).held
    for body, ends in _bodies(compiled):
        if not len(ends) or body.thread is not None:  # threads are meant to fold
            continue
        nodes, springs = _with_joined(network, body)
        ends = np.searchsorted(nodes, network.ends[springs]).astype(np.int32)
        modes = count(
            network.position[nodes],
            ends,
            network.stiffness[springs],
            network.rest[springs],
            # What it is joined to stands still, so that what is left is a mode of its own.
            held[nodes] | (nodes < body.nodes.start) | (nodes >= body.nodes.stop),
        )
        if modes.checked and modes.count:
            yield Diagnostic(
                "W303",
                f"{body.name} has {counted(modes.count, 'floppy mode')}: "
                "it can deform without stretching any spring",
                body.span,
                "add diagonals or interior springs, a larger reach of the lattice, "
                "or prestress",
            )


def unstable_node(state: State) -> int | None:
    """Return the node that moves most as a net buckles; see ``mechanics.stability``."""
    from tissuec.mechanics import stability  # SciPy: only where it is needed

    return stability.unstable_node(state)


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
    body = next(body for body in network.bodies if node < body.nodes.stop)
    yield Diagnostic(
        "W307",
        f"{body.name} starts in an unstable equilibrium: any disturbance makes it "
        f"buckle, mainly at node {network.node_ids[node]}",
        body.span,
        'let it settle ("at 0 s: settle"), push it slightly to one side, or compress it less',
    )


def uncounted(compiled: Compiled) -> list[str]:
    """Return the bodies that are too large to have their floppy modes counted."""
    held = state_at_start(compiled).held
    return [
        body.name
        for body in compiled.network.bodies
        if 3 * np.count_nonzero(~held[body.nodes]) > topology.LARGEST_CHECK
    ]


def zero_lengths(compiled: Compiled) -> Iterator[Diagnostic]:
    """W304: springs between nodes at one place, which have no direction."""
    network = compiled.network
    length = lengths(network.ends, network.position)
    for body in network.parts:
        zero = np.flatnonzero(length[body.springs] == 0.0)
        if len(zero):
            ids = ", ".join(
                str(i) for i in network.spring_ids[body.springs][zero[:MOST_SPRINGS_NAMED]]
            )
            more = ", …" if len(zero) > MOST_SPRINGS_NAMED else ""
            yield Diagnostic(
                "W304",
                f"{body.name} has {counted(len(zero), 'spring')} between nodes at the same "
                "position "
                f"(id {ids}{more})",
                body.span,
                "a spring of length zero has no direction and no force until its ends separate",
            )


def fallbacks(compiled: Compiled) -> Iterator[Diagnostic]:
    """W203: quantities that no rule spoke for."""
    for tissue in tissues_in_use(compiled):
        for name, given in tissue.given.items():
            if given.how == "otherwise":
                yield Diagnostic(
                    "W203",
                    f"no rule gives the {name} of {tissue.name}, so otherwise applies",
                    tissue.span,
                    f"write {name} = … in the tissue if you know it",
                    (Note("fallback", given.span),),
                )


def unused_parameters(compiled: Compiled) -> Iterator[Diagnostic]:
    """W501: a parameter that nothing uses, so that ``--set`` would do nothing."""
    constants = compiled.scene.constants
    for key, declared in compiled.scene.declarations.of("param").items():
        if key not in constants.used:
            yield Diagnostic(
                "W501",
                f'the param "{declared.name.text}" is never used',
                declared.name.span,
                leaving_out(
                    "use it or remove it; setting it has no effect", declared.item.span
                ),
            )


def unused_sets(compiled: Compiled) -> Iterator[Diagnostic]:
    """W502: a set that no sentence names."""
    for key, declared in compiled.scene.declarations.of("set").items():
        if key not in compiled.groups.used and isinstance(declared.item, s.Assign):
            yield Diagnostic(
                "W502",
                f'the set "{declared.name.text}" is never used',
                declared.name.span,
                leaving_out("use it or remove it", declared.item.span),
            )


def small_prestress(compiled: Compiled) -> Iterator[Diagnostic]:
    """W305: rest lengths of zero or less, which make a spring pull for ever."""
    network = compiled.network
    drawn = lengths(network.ends, network.position)
    for body in network.parts:
        rest = network.rest[body.springs]
        bad = rest[(rest <= 0.0) & (drawn[body.springs] > 0.0)]
        if len(bad):
            yield Diagnostic(
                "W305",
                f"{body.name} has {counted(len(bad), 'spring')} with a rest length of zero or "
                f"less (down to {show(float(bad.min()), LENGTH)})",
                body.span,
                "such a spring pulls until its ends meet; give it a rest length above zero",
            )


def driving_dashpots(compiled: Compiled) -> Iterator[Diagnostic]:
    """W308: dashpots by a law of their own that drive what they should brake."""
    network = compiled.network
    behaviour = network.behaviour()
    if behaviour.is_linear:
        return
    for strain, rate in product(STRAINS, RATES):
        stretch, speed = strain * network.rest, rate * network.rest
        brakes = behaviour.brake(stretch, speed)
        worst = np.flatnonzero(brakes * speed < -1e-9 * np.abs(brakes * speed).max(initial=0.0))
        for spring in worst[:1].tolist():
            owner = network.owner(spring)
            yield Diagnostic(
                "W308",
                f"dashpots of {owner.name} add energy: spring "
                f"{network.spring_ids[spring]} with {show(float(brakes[spring]), FORCE)} at a "
                f"strain of {strain:g} and {show(float(speed[spring]), VELOCITY)}",
                owner.span,
                "write max(…, 0) around the factor of the speed, which must not be negative",
            )
            return


def unstable_step(compiled: Compiled) -> Iterator[Diagnostic]:
    """W403: a fixed step above what the method can bear."""
    simulation = compiled.plan.simulation
    if simulation.step is None or simulation.integrator == RELAXATION:
        return
    state = state_at_start(compiled)
    omega = spectral_radius(state)
    zeta = damping_radius(state) / (2.0 * omega) if omega else 0.0
    limit = INTEGRATORS[simulation.integrator].stability_limit(omega, zeta)
    if simulation.step > limit:
        yield Diagnostic(
            "W403",
            f"step {show(simulation.step, TIME)} exceeds the stability estimate "
            f"{show(limit, TIME)}: {_stiffest(compiled)}",
            simulation.span,
            "write a smaller step, or a tolerance instead",
        )


def late_breaking(compiled: Compiled) -> Iterator[Diagnostic]:
    """W209: springs that break at a strain which no tissue bears.

    Left out are threads, many of which are made softer so that steps are longer, and nets typed
    in as tables, which need not be tissue.
    """
    network = compiled.network
    if not np.isfinite(network.strength).any():
        return
    strain = breaking_strains(network.behaviour(), network.strength)
    for body in network.bodies:
        springs = numbers_in(body.springs)
        springs = springs[np.isfinite(strain[springs])]
        is_typed = compiled.scene.bodies[key_of(body.name)].tables is not None
        if body.thread is not None or is_typed or not len(springs):
            continue
        median = int(springs[np.argsort(strain[springs])[len(springs) // 2]])
        if strain[median] > IMPLAUSIBLE:
            yield _breaks_late(network, body, median, float(strain[median]))


def _breaks_late(network: Network, body: BodyPart, spring: int, strain: float) -> Diagnostic:
    rest, force = float(network.rest[spring]), float(network.strength[spring])
    constant = float(network.stiffness[spring])
    better = float(network.behaviour().pull(PLAUSIBLE * network.rest)[spring])
    arrays = {"breaking force": "strength", "spring constant": "stiffness"}
    return Diagnostic(
        "W209",
        f"springs of {body.name} break at {1.0 + strain:.3g} times their length: one of "
        f"{show(rest, LENGTH)} has a spring constant of {show(constant, STIFFNESS)} and a "
        f"breaking force of {show(force, FORCE)}",
        body.span,
        f"{show(better, FORCE)} would break it at {1.0 + PLAUSIBLE:g} times its length; "
        "a tissue with a Young's modulus can have a breaking strain instead",
        tuple(
            Note(f"the {name}", network.provenance[array][spring].span)
            for name, array in arrays.items()
        ),
    )


def idle_shapes(compiled: Compiled) -> Iterator[Diagnostic]:
    """W407: a tool with a shape that touches nothing, because contact is off."""
    if compiled.scene.environment.contact is not None:
        return
    for tool in compiled.scene.tools.values():
        if tool.may_touch and tool.shapes:
            yield Diagnostic(
                "W407",
                f"{tool.name} has a shape, but contact is off, so it touches nothing",
                tool.span,
                Hint(
                    "write: environment { contact is tools only; … }",
                    *turning_contact_on(compiled).edits,
                ),
            )


def ruptures_in_vain(compiled: Compiled) -> Iterator[Diagnostic]:
    """W404: the ruptures of something that cannot rupture are measured."""
    plan, groups = compiled.plan, compiled.groups
    network = compiled.network
    breakable = np.isfinite(network.strength) | np.isfinite(network.crush)
    followed = (event for trigger in plan.triggers for event in trigger.events)
    for event in (*plan.events, *followed):
        if follows(event.action, Breaking):
            breakable[event.action.breakable(network)] = True
    # Knots of threads slip instead of breaking.
    breakable[[thread.hold for thread in network.threads.values()]] = False
    for name in _ruptured(compiled.scene.declarations):
        if groups.is_known(name) and not breakable[groups.springs(name).indices].any():
            yield Diagnostic(
                "W404",
                f"nothing in {name.text} can rupture, so this is always 0",
                name.span,
                "write rupture is allowed in the body",
            )


def _ruptured(declarations: Declarations) -> Iterator[s.Name]:
    """Yield what ``ruptured`` is asked about in expectations, conditions and outputs."""
    single = declarations.single
    asked = [single[kind].items for kind in ("script", "output") if kind in single]
    for part in walk((*declarations.expects, *asked)):
        match part:
            case s.Call(function=s.Name(key="ruptured"), arguments=(first, *_)):
                value = first.value
            case s.Sentence(
                name=s.Name(key="ruptured"), clauses=(s.Clause(word="of") as of, *_)
            ):
                value = of.value
            case _:
                continue
        if isinstance(value, s.Name):
            yield value


def silent_rules(compiled: Compiled) -> Iterator[Diagnostic]:
    """W202: a rule of the scene's own that no tissue in use wakes."""
    woken = {
        fired.span
        for tissue in tissues_in_use(compiled)
        for given in tissue.given.values()
        for fired in given.fired
    }
    for rules in compiled.scene.vocabulary.rules.values():
        silent = [
            span
            for span in rules.spans
            if span.source is compiled.scene.source and span not in woken
        ]
        if silent:
            more = counted(len(silent) - 1, "other rule") if silent[1:] else ""
            yield Diagnostic(
                "W202",
                "no tissue in use can make this rule fire" + (f", nor {more}" if more else ""),
                silent[0],
                leaving_out(
                    "describe a tissue so that it fires, or remove the rule",
                    *(silent if len(silent) == 1 else ()),
                ),
                tuple(Note("another rule", span) for span in silent[1:]),
            )


def buried_openings(compiled: Compiled) -> Iterator[Diagnostic]:
    """W408: a nozzle is drawn inside of a body."""
    network = compiled.network
    for tool in network.tools:
        if tool.kind != "nozzle":
            continue
        from tissuec.forces.jet_surfaces import buried_in  # where there is a nozzle

        opening = network.position[tool.nodes.start]
        if name := buried_in(network, network.position, opening):
            yield Diagnostic(
                "W408",
                f"the tip of {tool.name} is inside {name}, where its jet has no effect",
                tool.span,
                "place the tip outside, or move the nozzle before it irrigates",
            )


def cuts_in_vain(compiled: Compiled) -> Iterator[Diagnostic]:
    """W410: a cut that goes by a held body, further away than it comes before."""
    state = state_at_start(compiled)
    moved = 0.0  # [m]
    for event in compiled.plan.events:
        action = event.action
        if follows(action, Shifting):
            moved += action.shift
        elif isinstance(action, Cut) and _goes_by(action, state, moved):
            yield Diagnostic(
                "W410",
                f"the blade does not reach {action.group.name} as drawn: nothing is cut",
                action.span,
                "cut where it is: " + extents(state.position[_ends_of(action, state)]),
            )


def _goes_by(cut: Cut, state: State, moved: float) -> bool:
    """Return whether a cut meets a held group neither as it is drawn, nor as large again."""
    nodes = _ends_of(cut, state)
    if cut.blade is None or not len(nodes) or not state.held[nodes].any():
        return False
    position = state.position
    if moved > 0.5 * float(np.ptp(position[nodes], axis=0).max()):
        return False
    larger = replace(state, position=2.0 * position - position[nodes].mean(axis=0))
    return not any(len(cut.found(one)[0]) for one in (state, larger))


def _ends_of(cut: Cut, state: State) -> NDArray[np.integer]:
    return np.unique(state.network.ends[cut.group.indices])


CHECKS: tuple[Check, ...] = (
    pieces,
    dangling,
    zero_lengths,
    small_prestress,
    driving_dashpots,
    unstable_step,
    fallbacks,
    silent_rules,
    unused_parameters,
    unused_sets,
    idle_shapes,
    ruptures_in_vain,
    buried_openings,
    cuts_in_vain,
    passing_threads,
)
THOROUGH: tuple[Check, ...] = (late_breaking, floppy, unstable)


def _stiffest(compiled: Compiled) -> str:
    """Return the spring that asks for the smallest step, in words."""
    network = compiled.network
    ratio = network.sudden * (1.0 / network.mass[network.ends]).sum(axis=1)
    spring = int(ratio.argmax())
    part = network.owner(spring)
    mass = float(network.mass[network.ends[spring]].min())
    return (
        f"spring {network.spring_ids[spring]} of {part.name} has "
        f"{show(float(network.sudden[spring]), STIFFNESS)} at a node of {show(mass, MASS)}"
    )


def tissues_in_use(compiled: Compiled) -> tuple[Tissue, ...]:
    """Return the tissues that some body or joint is made of, each once."""
    tissues = {joint.tissue.name: joint.tissue for joint in compiled.scene.joints.values()}
    for body in compiled.scene.bodies.values():
        tissues |= {tissue.name: tissue for tissue in body.tissues}
    return tuple(tissues.values())


def state_at_start(compiled: Compiled, *, settles: bool = False) -> State:
    """Return the state after the events of the script at 0 s.

    Args:
        settles: Whether what is told to settle does; otherwise it stays as it is drawn.

    Raises:
        SimulationError: It ``settles``, and a run would end here.
    """
    plan = compiled.plan
    state = plan.start(compiled.network)
    for event in plan.events:
        if event.time > 0.0 or (isinstance(event.action, Settle) and not settles):
            continue
        try:
            event.action.apply(state, _InitialQueue())
        except ActionFailed as failure:  # a run tells it in its own words
            if settles:
                raise SimulationError(explain_action(failure, state)) from failure
    return state


class _InitialQueue:
    """A queue for looking at 0 s only."""

    def add(self, time: float, action: Action) -> None:
        pass

    def land(self, times: Floats) -> None:
        pass

    def end(self, ended: LoggedEvent) -> None:
        pass


def _bodies(
    compiled: Compiled, *, with_joints: bool = False
) -> Iterator[tuple[BodyPart, NDArray[np.int32]]]:
    """Yield each body with the node pairs of its springs, numbered within the body.

    Args:
        with_joints: Whether springs of joints between its nodes count as well.
    """
    network = compiled.network
    joined = network.ends[network.body_springs :]
    for body in network.bodies:
        ends = network.ends[body.springs]
        if with_joints:
            inside = (joined >= body.nodes.start) & (joined < body.nodes.stop)
            ends = np.concatenate([ends, joined[inside.all(axis=1)]])
        yield body, ends - np.int32(body.nodes.start)


def _with_joined(network: Network, body: BodyPart) -> tuple[Indices, Indices]:
    """Return a body's nodes and springs, with springs that join it and nodes at their ends."""
    joined = network.ends[network.body_springs :]
    beside = ((joined >= body.nodes.start) & (joined < body.nodes.stop)).any(axis=1)
    own = numbers_in(body.nodes)
    nodes = np.union1d(own, joined[beside])
    springs = numbers_in(body.springs)
    further = network.body_springs + np.flatnonzero(beside)
    return nodes.astype(np.int64), np.append(springs, further)


def _size(body: BodyPart) -> int:
    return body.nodes.stop - body.nodes.start
