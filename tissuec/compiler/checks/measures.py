"""Check of measures that are 0 all the time, or about something else than is meant."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.checks import check
from tissuec.compiler.checks.usage import breakable_entities, fixed_since
from tissuec.compiler.compile import Compiled
from tissuec.compiler.measures.observed import CompiledCondition, ObservedMeasure
from tissuec.compiler.measures.quantities import ObservedExpression
from tissuec.compiler.measures.subjects import kind_of
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.errors import Diagnostic
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.lang.words import written_name
from tissuec.model.blocks import OF_ELEMENTS
from tissuec.model.topology import pieces
from tissuec.script.measures import Measure, Subject
from tissuec.script.measures.needs import NEEDS
from tissuec.script.verbs import Action, Dividing, Group, follows
from tissuec.script.verbs.holding import nodes_held_by
from tissuec.script.verbs.irrigate import Irrigate
from tissuec.script.verbs.preserve import Inflate, Preserve
from tissuec.script.verbs.press import Press
from tissuec.script.verbs.push import Push

#: Kinds of blocks whose forces on all nodes of a body cancel.
_INNER = (*OF_ELEMENTS, "plates", "activation")


#: A measure, what it is taken of, and the place that names both.
Taken: TypeAlias = tuple[type[Measure], Subject, Span]


@check
def idle_measures(compiled: Compiled) -> Iterator[Diagnostic]:
    """W703: a measure says nothing, because the scene lacks what it is about."""
    yield from saying_nothing(compiled, _measured(compiled))


def saying_nothing(compiled: Compiled, measured: Iterable[Taken]) -> Iterator[Diagnostic]:
    """Yield W703 for measures that lack what they need, each once, where it is first named."""
    once = set[tuple[type[Measure], str]]()
    for measure, subject, span in measured:
        if (measure, subject.name) in once:
            continue
        once.add((measure, subject.name))
        for key in getattr(measure, "needs", ()):
            if not NEEDS[key].absent or _FOUND[key](compiled, subject):
                continue
            union = subject.name.startswith("[")
            name = subject.name if union else written_name(subject.name)
            shown = re.sub(r"\bA\b", name, measure.form)
            yield Diagnostic(
                "W703",
                f"{shown} {NEEDS[key].result}: {_about(NEEDS[key].absent, name)}",
                span,
                _about(NEEDS[key].hint, name),
            )


def _about(text: str, name: str) -> str:
    """Return a text about A with the name of the subject in its place."""
    return " ".join(name if word == "A" else word for word in text.split(" "))


def _measured(compiled: Compiled) -> Iterator[Taken]:
    """Yield what outputs, expectations, conditions and fits measure of single subjects."""
    plan = compiled.plan
    for log in plan.output.logs:
        if isinstance(log.measure, ObservedExpression):
            yield from taken_in(log.measure.readings.values(), log.span)
        else:
            yield from ((log.measure, one, log.span) for one in log.subjects)
    for item in (*plan.expectations, *plan.triggers):
        if isinstance(item.condition, CompiledCondition):
            yield from taken_in(item.condition.readings.values(), item.span)
    for fit in (fit for problem in compiled.fit_problems for fit in problem.fits):
        if fit.measure is not None:
            yield from ((fit.measure, one, fit.span) for one in fit.subjects)


def taken_in(readings: Iterable[ObservedMeasure], span: Span) -> Iterator[Taken]:
    """Yield the measures of a quantity, and what each is taken of."""
    return ((one.measure, subject, span) for one in readings for subject in one.subjects)


def _chosen(compiled: Compiled, subject: Subject) -> NDArray[np.bool_]:
    """Return which nodes a subject has, shape (node,)."""
    inside = np.zeros(compiled.network.node_count, dtype=bool)
    inside[subject.nodes] = True
    return inside


def _is_pressed(compiled: Compiled, subject: Subject) -> bool:
    """Return whether a body is a solid of elements, pressed, or keeps its volume."""
    key = key_of(subject.name)
    if subject.nodes is None or key not in compiled.groups.bodies:
        return True
    if kind_of(compiled.groups.bodies[key].drawing) == "solid" or _has_fluid(compiled):
        return True
    inside = _chosen(compiled, subject)
    groups = (_pressed_by(event.action) for event in compiled.plan.every_event)
    return any(group is not None and bool(inside[group.indices].any()) for group in groups)


def _is_loaded(compiled: Compiled, subject: Subject) -> bool:
    """Return whether an order presses a subject by its name, as the measure finds it."""
    actions = (event.action for event in compiled.plan.every_event)
    return any(isinstance(one, Press) and one.group.name == subject.name for one in actions)


def _has_cells(compiled: Compiled, subject: Subject) -> bool:
    """Return whether the volume of cells with nodes of a subject is preserved at some time."""
    if subject.nodes is None:
        return True
    inside = _chosen(compiled, subject)
    actions = (event.action for event in compiled.plan.every_event)
    return any(isinstance(one, Preserve) and inside[one.group.indices].any() for one in actions)


def _pressed_by(action: Action) -> Group | None:
    """Return the body or set that an action presses, or the body whose volume it preserves."""
    return action.group if isinstance(action, Press | Preserve | Inflate) else None


def _has_faces(compiled: Compiled, subject: Subject) -> bool:
    """Return whether contact acts on faces, which have areas."""
    contact = compiled.network.contact
    return contact is not None and contact.between is not None


def _has_fluid(compiled: Compiled) -> bool:
    return bool(compiled.network.of_kind("fluid", "volume", "pressure"))


def _is_supported(compiled: Compiled, subject: Subject) -> bool:
    """Return whether any force on nodes of a subject comes from elsewhere."""
    network, plan = compiled.network, compiled.plan
    if subject.nodes is None or network.contact is not None or network.guides is not None:
        return True
    if any(block.kind not in _INNER for block in network.blocks):
        return True
    actions = [event.action for event in plan.every_event]
    if any(isinstance(one, Press | Preserve | Inflate | Irrigate) for one in actions):
        return True
    first, second = _chosen(compiled, subject)[network.line_ends].T
    return bool((first != second).any())


def _is_held(compiled: Compiled, subject: Subject) -> bool:
    """Return whether anything but inner forces may ever act on the nodes of a set."""
    network = compiled.network
    is_whole = subject.nodes is None or key_of(subject.name) in compiled.groups.bodies
    if is_whole or network.contact is not None:
        return True
    inside = _chosen(compiled, subject)
    if state_at_start(compiled).held[inside].any() or network.guides is not None:
        return True
    if any(block.kind not in _INNER for block in network.blocks):
        return True
    if inside[network.springs.ends[network.body_springs :]].any():
        return True
    for event in compiled.plan.every_event:
        action = event.action
        if isinstance(action, Preserve | Inflate | Irrigate):
            return True
        if isinstance(action, Push | Press) and inside[action.group.indices].any():
            return True
        if inside[nodes_held_by(action)].any():
            return True
    return False


def _moves(compiled: Compiled, subject: Subject) -> bool:
    """Return whether nodes of a subject may ever move."""
    if subject.nodes is None or not len(subject.nodes):
        return True
    return bool(fixed_since(compiled)[subject.nodes].any())


def _is_divisible(compiled: Compiled, subject: Subject) -> bool:
    """Return whether cuts or tears may divide elements of a body."""
    return compiled.network.phantoms_of(subject.name) is not None


def _divides(compiled: Compiled, subject: Subject) -> bool:
    """Return whether nodes may be in several pieces at some time."""
    if subject.nodes is None or not len(subject.nodes):
        return True
    network = compiled.network
    ends, own = network.line_ends, network.of_bodies
    piece = pieces(network.node_count, ends, own)
    if (piece[subject.nodes] != piece[subject.nodes[0]]).any():
        return True
    own &= piece[ends[:, 0]] == piece[subject.nodes[0]]
    divided = breakable_entities(compiled)
    for event in compiled.plan.every_event:
        if follows(event.action, Dividing):
            divided[event.action.lines_within(network)] = True
    return bool(divided[: network.line_count][own].any())


def _stores_energy(compiled: Compiled, subject: Subject) -> bool:
    """Return whether a subject has springs that resist, or all nodes of an element."""
    network = compiled.network
    if subject.nodes is None or len(network.springs_among(subject.lines)):
        return True
    inside = _chosen(compiled, subject)
    fields = network.of_kind(*OF_ELEMENTS, "plates")
    return any(bool(inside[field.nodes].all(axis=1).any()) for field in fields)


def _yields(compiled: Compiled, subject: Subject) -> bool:
    """Return whether springs or elements of a subject can yield."""
    memory = compiled.network.springs.inelastic
    springs = compiled.network.springs_among(subject.lines)
    if memory is not None and bool(np.isfinite(memory.limit[springs]).any()):
        return True
    fields = [field for field in compiled.network.elements if field.yielding is not None]
    if subject.nodes is None:
        return bool(fields)
    inside = _chosen(compiled, subject)
    return any(bool(inside[field.nodes].any()) for field in fields)


_FOUND: Mapping[str, Callable[[Compiled, Subject], bool]] = {
    "faces": _has_faces,
    "pressure": _is_pressed,
    "load": _is_loaded,
    "cells": _has_cells,
    "support": _is_supported,
    "hold": _is_held,
    "motion": _moves,
    "division": _divides,
    "sections": _is_divisible,
    "energy": _stores_energy,
    "yielding": _yields,
}
