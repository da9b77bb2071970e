"""Checks of what a scene writes without effect: rules, shapes, friction, limits, cuts."""

from collections.abc import Iterator, Sequence
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.checks import check
from tissuec.compiler.checks.threads import turning_contact_on
from tissuec.compiler.compile import Compiled
from tissuec.compiler.materials.tissue_parts import NOT_ALLOWED
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.compiler.selections import extents
from tissuec.core.arrays import distinct
from tissuec.core.errors import Diagnostic, Note, counted
from tissuec.core.hints import Edit, Hint, leaving_out, removal
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import suggested_unit
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.mechanics.state import State
from tissuec.model.edges import edges_of, elements_at
from tissuec.model.network import Indices, Origin
from tissuec.scene.model import AssignedQuantity, Scene, Tissue
from tissuec.scene.overrides.entries import SET
from tissuec.scene.overrides.idle import idle_overrides, tissues_in_use
from tissuec.scene.tissues.quantities import (
    BREAKING_FORCE,
    CUTTING_RESISTANCE,
    FRICTION,
    LIMITS,
    QUANTITIES,
)
from tissuec.script.verbs import Action, Breaking, Shifting, follows
from tissuec.script.verbs.cut import SCISSORS, Cut
from tissuec.script.verbs.hold import Fix, Hold
from tissuec.script.verbs.holding import Driven, Freed, Holding
from tissuec.script.verbs.push import Push


@check
def fallbacks(compiled: Compiled) -> Iterator[Diagnostic]:
    """W203: quantities that no rule spoke for."""
    for tissue in tissues_in_use(compiled.scene):
        for name, given in tissue.given.items():
            if given.how == "otherwise":
                yield Diagnostic(
                    "W203",
                    f"no rule gives the {name} of {tissue.name}, so otherwise applies",
                    tissue.span,
                    f"write {name} = … in the tissue if you know it",
                    (Note("fallback", given.span),),
                )


@check
def silent_rules(compiled: Compiled) -> Iterator[Diagnostic]:
    """W202: a rule of the scene's own that no tissue in use wakes."""
    woken = {
        fired.span
        for tissue in tissues_in_use(compiled.scene)
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


@check
def vain_overrides(compiled: Compiled) -> Iterator[Diagnostic]:
    """W505: an entry that is set of a tissue of which nothing is made."""
    yield from idle_overrides(compiled.scene)


@check
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


@check
def friction_in_vain(compiled: Compiled) -> Iterator[Diagnostic]:
    """W407: a friction that the scene writes of a tissue, and with which nothing rubs."""
    found = _unfelt_friction(compiled)
    if found is None:
        return
    why, hint = found
    said = set[Span]()  # tissues that are like another one have its entry
    for tissue in tissues_in_use(compiled.scene):
        given = tissue.given.get(FRICTION)
        if given is None or not given.value or not _is_own(given, compiled.scene):
            continue
        if given.span not in said:
            said.add(given.span)
            is_text = given.span.source is compiled.scene.source
            without = (removal(given.span),) if is_text else ()
            yield Diagnostic(
                "W407",
                f"the friction of {tissue.name} has no effect: {why}",
                given.span,
                Hint(f"remove it, or {hint}", *without, *hint.edits),
            )


def _unfelt_friction(compiled: Compiled) -> tuple[str, Hint] | None:
    """Return why frictions of tissues have no effect, with a remedy; None if they may have."""
    scene, law = compiled.scene, compiled.scene.environment.contact
    tools_touch = any(tool.shapes and tool.may_touch for tool in scene.tools.values())
    if law is None:
        edits = turning_contact_on(compiled).edits if tools_touch else ()
        return "contact is off", Hint("write: contact is tools only", *edits)
    if law.friction is not None:
        return "that of the environment replaces it", Hint("that of the environment")
    if compiled.network.contact is None or tools_touch or law.within_bodies:
        return None
    rough = [
        body
        for body in scene.bodies.values()
        if any(one.given[FRICTION].value for one in body.tissues if FRICTION in one.given)
    ]
    if len(rough) > 1:
        return None
    why = "no other body has any, and the smaller of two counts"
    return why, Hint("give the tissue of another body a friction")


def _is_own(given: AssignedQuantity, scene: Scene) -> bool:
    """Return whether the scene itself writes a number of a tissue, or it is set."""
    source = given.span.source
    return given.how == "written" and (source is scene.source or source.name == SET)


@check
def dimensions_in_vain(compiled: Compiled) -> Iterator[Diagnostic]:
    """W503: a thickness or a section of something that has no quantity of matter."""
    for body in compiled.scene.bodies.values():
        if not _is_of_matter(*body.tissues):
            for entry in ("thickness", "section"):
                if entry in body.places:
                    yield _in_vain(entry, body.name, body.places[entry])
    for joint in compiled.scene.joints.values():
        if joint.section is not None and not _is_of_matter(joint.tissue):
            yield _in_vain("section", joint.name, joint.span)


def _is_of_matter(*tissues: Tissue) -> bool:
    """Return whether any quantity depends on sizes of the body."""
    of_surfaces = FRICTION, CUTTING_RESISTANCE
    return any(
        one.quantity.is_of_matter and key not in of_surfaces
        for tissue in tissues
        for key, one in tissue.given.items()
    )


def _in_vain(entry: str, owner: str, place: Span) -> Diagnostic:
    return Diagnostic(
        "W503",
        f"the {entry} of {owner} has no effect: no quantity of its tissue depends on it",
        place,
        "write a Young's modulus or a density in its tissue, or remove the entry",
    )


def breakable_entities(compiled: Compiled) -> NDArray[np.bool_]:
    """Return which springs and elements may rupture, and edges of these, shape (entity,)."""
    network, springs = compiled.network, compiled.network.springs
    breakable = np.zeros(network.entity_count, dtype=bool)
    finite = np.isfinite(springs.strength) | np.isfinite(springs.crush)
    breakable[: network.spring_count] = finite
    for field in network.elements:
        if (able := field.breakable) is not None:
            breakable[able.entities] = True
            breakable[edges_of(network, able.entities)] = True
    for body in network.bodies:
        for interface in body.interfaces:
            beside = int(body.elements.start) + np.flatnonzero(interface.sides)
            breakable[beside] = True
            breakable[edges_of(network, beside)] = True
    for glue in network.of_kind("glue"):
        breakable[glue.elements] = True
        breakable[edges_of(network, glue.elements)] = True
    for event in compiled.plan.every_event:
        if follows(event.action, Breaking):
            breakable[event.action.breakable(network)] = True
    # Knots of threads slip instead of breaking.
    breakable[[thread.hold for thread in network.threads.values()]] = False
    return breakable


@check
def ruptures_in_vain(compiled: Compiled) -> Iterator[Diagnostic]:
    """W404: the ruptures of something that cannot rupture are measured."""
    groups, breakable = compiled.groups, breakable_entities(compiled)
    for name in _measured("ruptured", compiled.scene):
        if groups.is_known(name):
            lines = groups.springs(name).indices
            if not breakable[lines].any():
                yield _unbreakable(compiled, name, lines)


@check
def limits_in_vain(compiled: Compiled) -> Iterator[Diagnostic]:
    """W404: a limit that the scene writes, of a tissue of which nothing may rupture."""
    scene = compiled.scene
    if any(follows(event.action, Breaking) for event in compiled.plan.every_event):
        return
    allowing = [body.tissues for body in scene.bodies.values() if "rupture" in body.places]
    allowing += [(joint.tissue,) for joint in scene.joints.values() if joint.rupture]
    able = {tissue.name for tissues in allowing for tissue in tissues}
    for tissue in tissues_in_use(scene):
        for name in (BREAKING_FORCE, "crushing force", *LIMITS):
            given = tissue.given.get(name)
            if given is None or tissue.name in able or not _is_own(given, scene):
                continue
            if np.isfinite(given.value):
                yield Diagnostic(
                    "W404",
                    f"nothing made of {tissue.name} may rupture, so its {name} has no effect",
                    given.span,
                    "write rupture is allowed in its body or joint; rupture is not allowed "
                    "states that nothing ruptures",
                )


def _unbreakable(compiled: Compiled, name: s.Name, lines: Indices) -> Diagnostic:
    """Return the finding about the ruptures of springs or elements that cannot rupture."""
    network, origins = compiled.network, list[Origin]()
    elements = elements_at(network, lines) - network.line_count
    for array, chosen in ("strength", network.springs_among(lines)), ("breaking", elements):
        if len(chosen):
            known = network.provenance[array]
            origins += [known.origins[int(index)] for index in distinct(known.index[chosen])]
    message, hint = f"nothing in {name.text} can rupture, so this is always 0", ""
    forbidding = next((one for one in origins if one.how == NOT_ALLOWED), None)
    if forbidding is not None:
        hint = _allowing(compiled, forbidding.span)
    elif origins:
        message += ": the tissue has no breaking force or strain"
        hint = _with_limit(origins[0].span)
    return Diagnostic("W404", message, name.span, hint)


def _allowing(compiled: Compiled, where: Span) -> Hint:
    """Return a hint to allow the rupture of a body or joint, whose head is given."""
    bodies = compiled.scene.bodies.values()
    places = next((body.places for body in bodies if body.span == where), None)
    if places is None or "rupture" not in places:
        return Hint(f"write rupture is allowed in the {'body' if places else 'joint'}")
    allowed = "rupture is allowed"
    return Hint(f"write {allowed} instead", Edit(allowed, places["rupture"]))


def _with_limit(entry: Span) -> Hint:
    """Return a hint to write a limit in place of an entry such as "breaking force is none"."""
    text = entry.text.lower()
    known = next((one for key, one in QUANTITIES.items() if text.startswith(key)), None)
    if known is None:
        return Hint("")
    is_strain = known.name == "breaking strain"
    limit = f"{known.name} = {'50 %' if is_strain else f'1 {suggested_unit(known.dimension)}'}"
    return Hint(f"write a limit, such as {limit}", Edit(limit, entry))


def _measured(measure: str, scene: Scene) -> Iterator[s.Name]:
    """Yield the subjects of a measure in expectations, conditions, outputs and studies."""
    declarations, single = scene.declarations, scene.declarations.single
    asked = [single[kind].items for kind in ("script", "output") if kind in single]
    studied = [one.item for study in scene.studies.values() for one in study.measures]
    for part in walk((*declarations.expects, *asked, *studied)):
        match part:
            case s.Call(function=s.Name(key=key), arguments=(first, *_)) if key == measure:
                value = first.value
            case s.Sentence(name=s.Name(key=key), clauses=(s.Clause(word="of") as of, *_)) if (
                key == measure
            ):
                value = of.value
            case _:
                continue
        if isinstance(value, s.Name):
            yield value


@check
def buried_openings(compiled: Compiled) -> Iterator[Diagnostic]:
    """W408: a nozzle is drawn inside of a body."""
    network = compiled.network
    for tool in network.tools:
        if tool.kind != "nozzle":
            continue
        from tissuec.forces.acting.jet_surfaces import buried_in  # where there is a nozzle

        opening = network.position[tool.nodes.start]
        if name := buried_in(network, network.position, opening):
            yield Diagnostic(
                "W408",
                f"the tip of {tool.name} is inside {name}, where its jet has no effect",
                tool.span,
                "place the tip outside, or move the nozzle before it irrigates",
            )


@check
def unfelt_blades(compiled: Compiled) -> Iterator[Diagnostic]:
    """W415: the force of scissors that feel nothing."""
    scissors = {key: one for key, one in compiled.scene.tools.items() if one.kind == SCISSORS}
    actions = [event.action for event in compiled.plan.every_event]
    closing = {cut.tool for cut in actions if isinstance(cut, Cut) and cut.profile is not None}
    for name in _measured("force", compiled.scene):
        tool = scissors.get(name.key)
        if tool is None:
            continue
        why = hint = ""
        if tool.name not in closing:
            why = f"{tool.name} do not cut over an interval"
            hint = f"write from … to …: cut … along line from … to … facing … with {tool.name}"
        elif compiled.network.cutting is None:
            why = "no tissue has a cutting resistance"
            hint = "write one in the tissue, such as cutting resistance = 200 J/m^2"
        if why:
            yield Diagnostic("W415", f"{why}, so this is always 0", name.span, hint)


@check
def idle_actions(compiled: Compiled) -> Iterator[Diagnostic]:
    """W417: what is done to nodes that are fixed for good, and scenes of which all is fixed."""
    fixed, plan = fixed_since(compiled), compiled.plan
    fixes = [event.action for event in plan.events if _is_whole_fix(event.action)]
    network = compiled.network
    own = fixed[network.parents[: network.body_nodes]]
    if fixes and len(own) and not own.any():
        yield Diagnostic(
            "W417",
            "every node is fixed at 0 s, so nothing can move",
            fixes[-1].span,
            "fix only a part of each body",
        )
        return
    yield from _fixed_twice(fixes, fixed)
    for event in plan.events:
        action = event.action
        if not isinstance(action, Push | Hold):
            continue
        name = action.group.name
        if not (fixed[action.group.indices] <= event.time).all():
            continue
        if isinstance(action, Push):
            message = f"{name} is fixed, so this moves nothing"
            hint = f"push nodes that are free, or write free {name} before"
        else:
            message = f"{name} is fixed, so holding it has no effect"
            hint = leaving_out(
                "remove one of both: fix lasts until free, hold until release",
                action.span,
            )
        yield Diagnostic("W417", message, action.span, hint)


def fixed_since(compiled: Compiled) -> NDArray[np.float64]:
    """Return when nodes are fixed for good [s], infinite of others, shape (node,)."""
    network, plan = compiled.network, compiled.plan
    fixed = np.full(network.node_count, np.inf)
    for event in plan.events:
        if _is_whole_fix(event.action):
            nodes = event.action.group.indices
            fixed[nodes] = np.minimum(fixed[nodes], event.time)
    for event in plan.every_event:
        match event.action.holding() if follows(event.action, Holding) else None:
            case Freed(nodes):
                fixed[nodes] = np.inf
            case Driven(mover, _):
                fixed[... if mover.nodes is None else mover.nodes] = np.inf
            case _:
                pass
    return fixed


def _is_whole_fix(action: Action) -> TypeGuard[Fix]:
    """Return whether an action fixes nodes in all directions."""
    return isinstance(action, Fix) and action.directions is None


def _fixed_twice(fixes: Sequence[Fix], fixed: NDArray[np.float64]) -> Iterator[Diagnostic]:
    """Yield W417 of sets that are fixed once more, while nothing frees them."""
    first = dict[str, Fix]()
    for action in fixes:
        before = first.setdefault(action.group.name, action)
        if before is not action and np.isfinite(fixed[action.group.indices]).all():
            yield Diagnostic(
                "W417",
                f"{action.group.name} is fixed already, so this has no effect",
                action.span,
                leaving_out("remove it", action.span),
                (Note("fixed here", before.span),),
            )


@check
def cuts_in_vain(compiled: Compiled) -> Iterator[Diagnostic]:
    """W410: a cut that goes by a body as it is drawn, or further away than it comes before."""
    # Before any cut, also those at 0 s.
    state = replace(state_at_start(compiled), alive=compiled.network.present)
    moved = 0.0  # [m]
    for event in compiled.plan.events:
        action = event.action
        if follows(action, Shifting):
            moved += action.shift
        elif isinstance(action, Cut) and _is_within_cells(action, state):
            yield Diagnostic(
                "W410",
                f"the blade crosses no edge of a cell of {action.group.name} as drawn: nothing "
                "is cut",
                action.span,
                "use smaller cells, or a longer cut",
            )
        elif isinstance(action, Cut) and _goes_by(action, state, moved, event.time):
            yield Diagnostic(
                "W410",
                f"the blade does not reach {action.group.name} as drawn: nothing is cut",
                action.span,
                "cut where it is: " + extents(state.position[_ends_of(action, state)]),
            )


def _is_within_cells(cut: Cut, state: State) -> bool:
    """Return whether the middle of a blade is in a group as drawn, but no edge crosses it."""
    if cut.blade is None or not all(cut.blade.limited) or len(cut.found(state)[0]):
        return False
    nodes = _ends_of(cut, state)
    if not len(nodes):
        return False
    middle = cut.blade.origin + 0.5 * cut.blade.spans.sum(axis=0)
    place = state.position[nodes]
    return bool((place.min(axis=0) < middle).all() and (middle < place.max(axis=0)).all())


def _goes_by(cut: Cut, state: State, moved: float, time: float) -> bool:
    """Return whether a cut meets a group neither as it is drawn, nor as large again.

    Free bodies may come to the blade, but not before the run begins.
    """
    nodes = _ends_of(cut, state)
    if cut.blade is None or not len(nodes):
        return False
    if time == 0.0:
        return not len(cut.found(state)[0])
    if not state.held[nodes].any():
        return False
    position = state.position
    if moved > 0.5 * float(np.ptp(position[nodes], axis=0).max()):
        return False
    larger = replace(state, position=2.0 * position - position[nodes].mean(axis=0))
    return not any(len(cut.found(one)[0]) for one in (state, larger))


def _ends_of(cut: Cut, state: State) -> NDArray[np.integer]:
    return distinct(state.network.line_ends[cut.group.indices])
