"""Orders without effect: what a run was told to do, and what it never did.

States are examined where they are known anyway: after events, and where doubts are looked for.
Which nodes are held changes at events only, so that all of a push is known. A tool has touched
nothing if it was never closer to a body than both may have moved since the state before; where
it was, nothing is said. Nothing here changes the motion.
"""

from collections.abc import Iterable, Iterator
from typing import Any, Protocol, runtime_checkable

import numpy as np
from msgspec import Struct, field

from tissuec.core.arrays import norm
from tissuec.core.source import Span
from tissuec.core.units import TIME, VOLUME, show
from tissuec.geometry.nearest import TRIANGLE
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network, ToolPart, numbers_in
from tissuec.results.recording import WithoutEffect
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import Plan
from tissuec.script.verbs.holding import sentence

STILL = 1e-9  # of the size of the scene: displacements that rounding may cause
DIGITS = 4  # of the values that came closest to a condition
MISSED = 0.05  # of an ordered volume: a larger difference is reported


@runtime_checkable
class Comparing(Protocol):
    """A condition that may know how far it is from being true."""

    def margin(self, snapshot: Snapshot) -> Floats | None:
        """Return that in the unit of its sides, shape (…); None where it is not known."""
        ...

    def describe(self, snapshot: Snapshot, *, digits: int) -> str:
        """Return the measured values, with so many significant digits."""
        ...


class EffectMemory(Struct, eq=False):
    """What was seen so far, as a checkpoint holds it.

    Attributes:
        before: Positions at the last look [m], shape (node, 3); None before the first.
        near: Tools that may have touched something.
        pushed: Whether a push or a pressure acted on a node that was free, by its place and
            sentence, on two lines.
        free: Whether any node of a body was ever free.
        moved: Whether any of them ever moved.
        bared: When lost elements first exposed faces that touch nothing [s], by the names of
            bodies.
        closest: For conditions, by their places in the plan: how far they were from being true
            at least, in the units of their sides, and what was measured when [s].
    """

    before: Floats | None = None
    near: list[str] = field(default_factory=list[str])
    pushed: dict[str, bool] = field(default_factory=dict[str, bool])
    free: bool = False
    moved: bool = False
    bared: dict[str, float] = field(default_factory=dict[str, float])
    closest: dict[int, tuple[float, str, float]] = field(
        default_factory=dict[int, tuple[float, str, float]]
    )


class EffectWatcher:
    """Examines what the orders of a run do.

    Args:
        network, plan: Of the run.
    """

    def __init__(self, network: Network, plan: Plan):
        self._network, self._plan = network, plan
        has_contact = network.contact is not None
        self._tools = [one for one in network.tools if has_contact and one.touches]
        self._still = STILL * network.extent
        self._solid = _solids_that_touch_themselves(network)
        self._comparing = {
            number: trigger.condition
            for number, trigger in enumerate(plan.triggers)
            if isinstance(trigger.condition, Comparing)
        }

    def enter(self, state: State, memory: EffectMemory) -> None:
        """Examine on what pushes act, after the events of a time."""
        held = state.held
        memory.free = memory.free or not held[: self._network.body_nodes].all()
        for span, nodes in _pushes(state):
            key = f"{span.place}\n{sentence(span)}"
            memory.pushed[key] = memory.pushed.get(key, False) or not held[nodes].all()
        for body in self._solid:
            if body.name not in memory.bared and _is_torn(body, state):
                memory.bared[body.name] = state.time

    def look(self, state: State, position: Floats, memory: EffectMemory) -> None:
        """Examine what is near to tools, and whether anything moves.

        Args:
            state: What is alive then.
            position: Of all nodes [m], shape (node, 3).
            memory: Of the run.
        """
        before = position if memory.before is None else memory.before
        if not memory.moved:
            way = self._network.moved(position)[: self._network.body_nodes]
            memory.moved = float(np.abs(way).max(initial=0.0)) > self._still
        tools = [one for one in self._tools if one.name not in memory.near]
        contact = state.touching if tools else None
        if contact is None:
            return
        from tissuec.forces.contact.readings import comes_near  # where something touches

        ways = norm(position - before)
        bodies = float(ways[: self._network.body_nodes].max(initial=0.0))
        for tool in tools:
            nodes = numbers_in(tool.nodes)
            way = bodies + float(ways[nodes].max(initial=0.0))
            if comes_near(contact, nodes, position, way):
                memory.near.append(tool.name)
        memory.before = position.copy()

    def measure(self, snapshot: Snapshot, memory: EffectMemory) -> None:
        """Note how close the conditions of the script are to being true.

        Args:
            snapshot: One state, or a batch along a single axis.
            memory: Of the run.
        """
        is_batch = np.ndim(snapshot.time) > 0
        for number, condition in self._comparing.items():
            margin = condition.margin(snapshot)
            if margin is None:
                continue
            missing = np.where(np.isfinite(margin), margin, np.inf)
            row = int(missing.argmin())
            least = float(missing.flat[row])
            known = memory.closest.get(number)
            if np.isfinite(least) and (known is None or least < known[0]):
                one = snapshot.pick(row) if is_batch else snapshot
                memory.closest[number] = (
                    least,
                    condition.describe(one, digits=DIGITS),
                    float(one.time),
                )

    def found(
        self, state: State, waiting: Iterable[int], memory: EffectMemory
    ) -> tuple[WithoutEffect, ...]:
        """Return what had no effect by the end of a run.

        Args:
            state: At the end.
            waiting: Conditions that were never true, by their places in the plan.
            memory: Of the run.
        """
        return (
            *self._nothing_moved(memory),
            *(self._untouched(one) for one in self._tools if one.name not in memory.near),
            *self._unmoved(memory),
            *self._bared(memory),
            *self._never_true(waiting, memory),
            *_missed_volumes(state),
        )

    def _nothing_moved(self, memory: EffectMemory) -> Iterator[WithoutEffect]:
        if memory.moved or not self._network.body_nodes:
            return
        span = self._plan.simulation.span
        what, remedy = "no body moved: nothing acts on them", "write what does"
        if not memory.free:
            what, remedy = "no body moved: every node is held", "fix only a part of each body"
        yield WithoutEffect("motion", what, remedy, span.place)

    def _untouched(self, tool: ToolPart) -> WithoutEffect:
        what = f"{tool.name} touched nothing"
        remedy = "check where it is drawn, and its way"
        return WithoutEffect("contact", what, remedy, tool.span.place)

    def _unmoved(self, memory: EffectMemory) -> Iterator[WithoutEffect]:
        for key, acted in memory.pushed.items():
            if not acted:
                place, _, order = key.partition("\n")
                what = f"{order} acts on held nodes only"
                remedy = "choose nodes that are free, or move those that are held"
                yield WithoutEffect("push", what, remedy, place)

    def _bared(self, memory: EffectMemory) -> Iterator[WithoutEffect]:
        for body in self._network.bodies:
            if body.name in memory.bared:
                since = show(memory.bared[body.name], TIME)
                what = (
                    f"contact does not act on the faces of {body.name} that lost elements "
                    f"leave from {since} on: its parts pass through each other there"
                )
                remedy = "draw the parts as bodies with a joint between them, and cut the joint"
                yield WithoutEffect("cut faces", what, remedy, body.span.place)

    def _never_true(
        self, waiting: Iterable[int], memory: EffectMemory
    ) -> Iterator[WithoutEffect]:
        for number in waiting:
            span = self._plan.triggers[number].span
            what = f"{' '.join(span.text.split()).rstrip(':')} was never true"
            if number in memory.closest:
                _, said, time = memory.closest[number]
                what = f"{what}; closest at {show(time, TIME)}: {said}"
            yield WithoutEffect("condition", what, "", span.place)


def _solids_that_touch_themselves(network: Network) -> list[BodyPart]:
    """Return bodies with elements that have an inside, if contact acts within bodies."""
    contact = network.contact
    if contact is None:
        return []
    is_face = contact.kind[: len(contact.spared)] == TRIANGLE
    if not (is_face & (contact.spared < 0)).any():
        return []
    return [body for body in network.bodies if _solids_of(network, body)]


def _solids_of(network: Network, body: BodyPart) -> list[Any]:
    """Return the elements of a body that have an inside, shape by shape."""
    return [one for one in network.elements_of(body.name) if one.nodes.shape[1] > 3]


def _is_torn(body: BodyPart, state: State) -> bool:
    """Return whether elements of a body are lost that were there as drawn, and others left.

    Faces of elements that were divided touch what is in front of them.
    """
    lost = left = 0
    for one in _solids_of(state.network, body):
        number = len(one.lost_items(state.alive))
        lost += number - len(one.lost_items(state.network.present))
        if (drawn := state.cut_cells) is not None:
            lost -= np.count_nonzero(np.isin(one.walls, drawn.wholes))
        left += len(one.nodes) - number
    return lost > 0 and left > 0


def _pushes(state: State) -> Iterator[tuple[Span, Indices]]:
    """Yield the sentences of pushes and pressures that act now, and their nodes."""
    yield from ((load.span, load.nodes) for load in state.loads.values())
    for pressure in state.pressures:
        yield pressure.span, pressure.faces.corners.ravel()


def _missed_volumes(state: State) -> Iterator[WithoutEffect]:
    """Yield the volumes that are not what was ordered, as pressure is not all that acts."""
    for kept in state.kept_volumes:
        intact = kept.intact(state.alive)
        ordered = float(intact.due(state.time).sum())
        volume = float(intact.volumes(state.position).sum())
        if ordered > 0.0 and abs(volume - ordered) > MISSED * ordered:
            what = (
                f"the volume of {kept.name} is {show(volume, VOLUME)} at the end, instead of "
                f"{show(ordered, VOLUME)}"
            )
            remedy = "preserve it with a larger pressure, which is a bulk modulus"
            yield WithoutEffect("volume", what, remedy, kept.span.place)
