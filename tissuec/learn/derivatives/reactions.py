"""Inner forces on nodes as observables."""

import numpy as np

from tissuec.compiled.record_tables import tabulated
from tissuec.kernels.derivative_records import (
    Forces,
    Laws,
    Links,
    NodeState,
    SpringMemory,
    Values,
)
from tissuec.learn.derivatives.acting import acting_fields, present_fields
from tissuec.learn.derivatives.event_schedule import Leg
from tissuec.learn.derivatives.kernels import acceleration, pull_back
from tissuec.learn.derivatives.views import ObservableDerivative, StateView, nodes_of
from tissuec.learn.parameters.memory import NO_MEMORY, memory_of, remembering
from tissuec.model.network import Floats, Indices
from tissuec.script.measures import Subject

_NONE: Indices = np.zeros(0, dtype=np.int64)


class Support:
    """Minus the sum of the inner forces on some nodes, as ``force``."""

    def __init__(self, subject: Subject, laws: Laws):
        self.subject, self.laws = subject, laws
        # By the identity of the leg, which is kept so that no other gets its number.
        self._links: dict[int, tuple[Leg, Links, SpringMemory]] = {}

    def at(self, view: StateView) -> Floats:
        """Return x, y and z [N]."""
        return -self._pulled(view)[1].a.reshape(-1, 3).sum(axis=0)

    def slopes(self, view: StateView) -> list[ObservableDerivative]:
        """Return the derivatives, by what a force on these nodes depends on."""
        forces, at = self._pulled(view)
        nodes = np.flatnonzero(forces.links.inverse)
        found: list[ObservableDerivative] = []
        for axis in range(3):
            due = NodeState(*np.zeros((3, len(view.x))))
            due.a[3 * nodes + axis] = -1.0
            by = Values(*(np.zeros_like(part) for part in view.values))
            pull_back(forces, view.time, at, due, by)
            by.mass[:] = 0.0  # no mass is in a force
            by.drag[:] = 0.0  # nor is what acts from outside
            found.append(ObservableDerivative(due.x, due.v, by))
        return found

    def _pulled(self, view: StateView) -> tuple[Forces, NodeState]:
        """Return what acts, and the state with the forces in place of accelerations."""
        leg = view.leg
        fields = acting_fields(leg, present_fields(leg, view.values), view.x)
        links, memory = self._of(leg)
        forces = tabulated(Forces(self.laws, links, view.values, fields, memory))
        at = NodeState(view.x, view.v, np.empty_like(view.x))
        acceleration(forces, view.time, np.zeros(0), at)
        return forces, at

    def _of(self, leg: Leg) -> tuple[Links, SpringMemory]:
        """Return the springs that reach out of the nodes, each of which weighs 1 kg."""
        if id(leg) not in self._links:
            inside = np.zeros(len(leg.held), dtype=bool)
            inside[nodes_of(self.subject, leg)] = True
            ends = leg.network.springs.ends
            alive = np.flatnonzero(leg.alive_springs & (inside[ends].sum(axis=1) == 1))
            memory = memory_of(leg.network, alive) if leg.remembers else NO_MEMORY
            if leg.remembers:
                alive = alive[~remembering(leg.network)[alive]]
            low, high = (np.ascontiguousarray(e) for e in ends[alive].astype(np.int64).T)
            law = leg.network.springs.law[alive].astype(np.int64)
            steady, drag = np.zeros(3 * len(inside)), np.zeros(len(inside))
            links = Links(
                low, high, alive, law, inside.astype(float), steady, drag, _NONE, _NONE
            )
            self._links[id(leg)] = leg, tabulated(links), tabulated(memory)
        return self._links[id(leg)][1:]
