"""Forces of springs on nodes as something to look at."""

import numpy as np

from tissuec.compiled.tables import RecordTable
from tissuec.kernels.sensitivity import Links, Values
from tissuec.learn.course import Leg
from tissuec.learn.kernels import Kernels
from tissuec.learn.views import Slope, View, nodes_of
from tissuec.measures import Subject
from tissuec.network import Floats, Indices

_NONE: Indices = np.zeros(0, dtype=np.int64)


class Support:
    """Minus the sum of the forces of springs on some nodes, as ``force``."""

    def __init__(self, subject: Subject, kernels: Kernels):
        self.subject, self.kernels = subject, kernels
        # By the identity of the leg, which is kept so that no other gets its number.
        self._links: dict[int, tuple[Leg, RecordTable]] = {}

    def at(self, view: View) -> Floats:
        """Return x, y and z [N]."""
        return -self._forces(view, RecordTable(view.values)).reshape(-1, 3).sum(axis=0)

    def slopes(self, view: View) -> list[Slope]:
        """Return the derivatives, by what a force on these nodes depends on."""
        links, values = self._of(view.leg), RecordTable(view.values)
        forces = self._forces(view, values)
        nodes, found = np.flatnonzero(links.inverse), []
        for axis in range(3):
            weight, by_x, by_v = np.zeros((3, len(view.x)))
            weight[3 * nodes + axis] = -1.0
            by = Values(*(np.zeros_like(part) for part in view.values))
            self.kernels.pull_back(
                view.x, view.v, forces, weight, links, values, by_x, by_v, by
            )
            by.mass[:] = 0.0  # no mass is in a force
            found.append(Slope(by_x, by_v, by))
        return found

    def _forces(self, view: View, values: RecordTable) -> Floats:
        forces = np.empty_like(view.x)
        self.kernels.acceleration(
            view.x, view.v, np.zeros(0), self._of(view.leg), values, forces
        )
        return forces

    def _of(self, leg: Leg) -> RecordTable:
        """Return the springs that reach out of the nodes, each of which weighs 1 kg."""
        if id(leg) not in self._links:
            inside = np.zeros(len(leg.held), dtype=bool)
            inside[nodes_of(self.subject, leg)] = True
            ends = leg.network.ends
            alive = np.flatnonzero(leg.alive_springs & (inside[ends].sum(axis=1) == 1))
            low, high = (np.ascontiguousarray(e) for e in ends[alive].astype(np.int64).T)
            law = leg.network.law[alive].astype(np.int64)
            steady, drag = np.zeros(3 * len(inside)), np.zeros(len(inside))
            links = Links(
                low, high, alive, law, inside.astype(float), steady, drag, _NONE, _NONE
            )
            self._links[id(leg)] = leg, RecordTable(links)
        return self._links[id(leg)][1]
