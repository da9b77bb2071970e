"""Signs of doubtful numbers, for which states are examined during a run.

A watch is a class registered by its kind, in a separate file. It examines at most ``LOOKS``
states of the run and the last one, or follows the motion between them, and yields findings. The
event log, the result and all reports treat findings of every kind alike. Watches do not change
the state.
"""

from collections.abc import Iterator
from functools import cached_property
from typing import ClassVar, Protocol, Self, runtime_checkable

import numpy as np
from msgspec import Struct, field

from tissuec.core.registry import Family
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.results.promise import Doubt
from tissuec.script.plan import Plan

LOOKS = 64


class Finding(Struct, frozen=True):
    """What a watch sees in one state.

    Attributes:
        subject, what, where, unit, remedy: As of ``Doubt``.
        count: How many there are now; 0 where there are none (any more).
        span: The sentence that is concerned.
        weight: Where not every state counts, how much this one does: only the state of the
            largest weight is reported, such as that of the largest force.
    """

    subject: str
    count: int
    what: str
    where: str
    unit: str
    remedy: str
    span: Span
    weight: float | None = None


class Watch(Protocol):
    """Interface of members of ``WATCHES``."""

    kind: ClassVar[str]

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None where it has nothing to examine."""
        ...

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield doubts, and former ones that no longer hold, with a count of 0.

        Args:
            state: What is alive and held; its positions are ignored.
            position: Of all nodes [m], shape (node, 3).
        """
        ...


@runtime_checkable
class Follower(Watch, Protocol):
    """A watch that checks the states of a motion in order, as often as nodes move.

    Samples arrive later than the states between them, and are not checked.

    Attributes:
        memory: Its findings so far, as a checkpoint holds them.
    """

    memory: Struct

    def leeway(self, position: Floats) -> float:
        """Return how far nodes can move before a check is needed [m]; 0 or less if it is due.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        ...


WATCHES: Family[type[Watch]] = Family("tissuec.engine.execution.doubts", "watch")


class DoubtMemory(Struct, eq=False):
    """Doubts of a run so far, as a checkpoint holds them.

    Attributes:
        next: Time of the next look [s].
        found: Doubts by kind and subject.
        weights: Largest weight so far of findings that have one, by kind and subject.
        kept: Findings of watches that follow a motion, by kind.
        fresh: Those of ``found`` that the event log does not contain yet, with their spans.
    """

    next: float = 0.0
    found: dict[str, Doubt] = field(default_factory=dict[str, Doubt])
    weights: dict[str, float] = field(default_factory=dict[str, float])
    kept: dict[str, Struct] = field(default_factory=dict[str, Struct])
    fresh: list[tuple[Doubt, Span]] = field(default_factory=list[tuple[Doubt, Span]])

    def enter(self, kind: str, finding: Finding, time: float) -> None:
        """Take what a watch found.

        Args:
            kind: Of the watch.
            finding: What it found.
            time: When [s].
        """
        key = f"{kind}: {finding.subject}"
        known = self.found.get(key)
        if finding.weight is not None:
            if finding.weight <= self.weights.get(key, 0.0):
                return
            self.weights[key] = finding.weight
            if known is not None:
                del self.found[key]
                known = None
        if known is not None:
            most = max(known.most, finding.count)
            self.found[key] = replace(known, most=most, last=finding.count)
        elif finding.count:
            self.found[key] = doubt = Doubt(
                kind, finding.subject, finding.what, time, finding.where,
                finding.count, finding.count, finding.unit, finding.remedy, finding.span.place,
            )  # fmt: skip
            if finding.weight is None:
                self.fresh.append((doubt, finding.span))


class Watcher:
    """Examines a run for all kinds of doubts.

    Args:
        network, plan: Of the run.
    """

    def __init__(self, network: Network, plan: Plan):
        self._network, self._plan = network, plan
        self._apart = plan.simulation.duration / LOOKS

    def look(self, state: State, time: float, position: Floats, memory: DoubtMemory) -> None:
        """Check a state, with all watches but those that follow the motion.

        Args:
            state: As of ``Watch.look``.
            time: [s].
            position: Of all nodes [m], shape (node, 3).
            memory: Receives the findings.
        """
        for watch in self._at_work[0]:
            self._ask(watch, state, time, position, memory)
        memory.next = (time // self._apart + 1.0) * self._apart

    def follow(
        self,
        state: State,
        time: float,
        position: Floats,
        memory: DoubtMemory,
        *,
        always: bool = False,
    ) -> float:
        """Check the next state of a motion, with the watches that follow it.

        Args:
            state: As of ``Watch.look``.
            time: Later than that of the last call [s].
            position: Of all nodes [m], shape (node, 3).
            memory: Receives the findings.
            always: Whether to look even if nothing has moved far.

        Returns:
            How far nodes can move before the next state has to be checked [m].
        """
        leeway = np.inf
        for watch in self._at_work[1]:
            watch.memory = memory.kept.setdefault(watch.kind, watch.memory)
            own = watch.leeway(position)
            if always or own <= 0.0:
                self._ask(watch, state, time, position, memory)
                own = watch.leeway(position)
            leeway = min(leeway, max(own, 0.0))
        return leeway

    @cached_property
    def _at_work(self) -> tuple[list[Watch], list[Follower]]:
        """Return the watches of the run: those of single states, and those of the motion."""
        made = (kind.of(self._network, self._plan) for kind in WATCHES.values())
        lookers: list[Watch] = []
        followers: list[Follower] = []
        for watch in made:
            if isinstance(watch, Follower):  # slow, as it is of a protocol: only once
                followers.append(watch)
            elif watch is not None:
                lookers.append(watch)
        return lookers, followers

    @staticmethod
    def _ask(
        watch: Watch, state: State, time: float, position: Floats, memory: DoubtMemory
    ) -> None:
        for finding in watch.look(state, position):
            memory.enter(watch.kind, finding, time)
