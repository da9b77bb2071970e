"""Cells and faces that turn inside out, and elements strained beyond a stable law.

Springs resist a change of length, not of orientation: a cell that is pressed flat has a second
equilibrium, in which it is inside out and pulls where tissue would push. A cell counts as
inside out if its volume is not positive; a face of a surface, if it looks the opposite way to
the mean of its neighbours, while it did not as drawn. Cells and faces that have lost a spring
are not counted.

Elements that are strained beyond the stability of their law.

Beyond it, a further strain needs less stress, so it localises in single elements and depends on
the mesh. Only bodies with a law that is not stable everywhere are checked.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import cross, dot, norm
from tissuec.core.units import LENGTH, show
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.geometry.edge_supports import SupportedTriangles
from tissuec.geometry.edges import Edges
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.script.plan import Plan

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements
    from tissuec.forces.surfaces.membranes import Membranes

INSIDE_OUT = "inside out"
# Part of the smallest height of a cell that its nodes move before it is examined again: it
# cannot be inside out before nodes have moved by half of that height.
CLOSE = 0.25


class _Oriented:
    """Cells or faces of one body.

    Attributes:
        members: Nodes of each, shape (cell, corner).
        height: Of the smallest as drawn [m].
    """

    unit: ClassVar[str]
    remedy: ClassVar[str]

    def __init__(self, network: Network, body: BodyPart, members: Indices, height: float):
        self.network, self.body, self.members = network, body, members
        self._close = CLOSE * height
        self._seen = network.position[body.nodes]
        self._is_out = False

    def orientation(self, position: Floats) -> Floats:
        """Return a number for each, shape (cell,), that is positive if it is as drawn."""
        raise NotImplementedError

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        own = position[self.body.nodes]
        moved = own - self._seen
        moved = moved - moved.mean(axis=0)
        if not self._is_out and np.abs(moved).max(initial=0.0) < self._close:
            return
        self._seen = own.copy()
        out = np.flatnonzero((self.orientation(position) <= 0.0) & self._are_whole(state.alive))
        if not len(out) and not self._is_out:
            return
        self._is_out = bool(len(out))
        name, where = self.body.name, ""
        if len(out):
            where = f"at node {self.network.node_ids[self.members[out[0], 0]]}"
        yield Finding(
            name, len(out), f"{self.unit}s of {name} are inside out", where,
            self.unit, self.remedy, self.body.span,
        )  # fmt: skip

    def _are_whole(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which have lost none of the springs between their nodes, shape (cell,)."""
        whole = np.ones(len(self.members), dtype=bool)
        if not alive.all():
            pairs = np.array(list(combinations(range(self.members.shape[1]), 2)))
            joined = self.members[:, pairs].reshape(-1, 2)
            springs, which = self.network.pairs.between(joined)
            whole[which[~alive[springs]] // len(pairs)] = False
        return whole


class _Cells(_Oriented):
    """Cells of a lattice.

    Args:
        faces: Nodes of the faces of each, shape (cell, face, 4).
    """

    unit = "cell"
    remedy = (
        "forces and volumes are wrong there; press the body less, or use a larger Poisson's "
        "ratio or smaller cells"
    )

    def __init__(self, network: Network, body: BodyPart, faces: Indices):
        from tissuec.forces.enclosed.volume import Enclosure  # only where there are cells

        first = faces[0].ravel()
        once = np.sort(np.unique(first, return_index=True)[1])
        members = faces.reshape(len(faces), -1)[:, once]
        none, bounds = np.zeros(0, dtype=np.int64), faces.shape[1] * np.arange(len(faces) + 1)
        self._within = Enclosure(
            none, none, body.name, np.ones(len(faces)), 1.0, (), body.span,
            faces.reshape(-1, 4), bounds,
        )  # fmt: skip
        place = network.position[faces[0]]
        area = float(norm(cross(place[:, 1] - place[:, 0], place[:, 2] - place[:, 0])).max())
        volume = float(self._within.volumes(network.position)[0])
        super().__init__(network, body, members, volume / area)

    def orientation(self, position: Floats) -> Floats:
        return self._within.volumes(position)


class _Tetrahedra(_Oriented):
    """Tetrahedra of a solid."""

    unit, remedy = _Cells.unit, _Cells.remedy

    def __init__(self, network: Network, body: BodyPart, corners: Indices):
        self._drawn = _contents(network.position[corners])
        sides = network.position[corners]
        longest = norm(sides[:, [0, 0, 0, 1, 1, 2]] - sides[:, [1, 2, 3, 2, 3, 3]]).max(axis=1)
        height = float((np.abs(self._drawn) / longest**2).min(initial=np.inf))
        super().__init__(network, body, corners, height)

    def orientation(self, position: Floats) -> Floats:
        return _contents(position[self.members]) * np.sign(self._drawn)


class _Faces(_Oriented):
    """Triangles of a surface without cells behind it, each with its neighbours."""

    unit = "face"
    remedy = (
        "the surface is folded more sharply than its triangles allow; use smaller triangles, "
        "or bend or press it less"
    )

    def __init__(self, network: Network, body: BodyPart, corners: Indices):
        one, other, alike = Edges.among(corners).pairs
        self._pairs = one[alike], other[alike]
        self.members = corners
        sides = network.position[corners]
        area = norm(cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0]))
        longest = norm(sides - np.roll(sides, 1, axis=1)).max(axis=1)
        drawn = self._agreement(network.position)
        is_fit = (drawn > 0.0) & (area > 0.0)
        self._fit = np.where(is_fit, 1.0, np.nan)
        height = float((area / longest)[is_fit].min(initial=np.inf))
        super().__init__(network, body, corners, height)
        elements = network.skin_elements_of(body)
        self._skin = SupportedTriangles(network.line_ends, corners, elements)

    def _are_whole(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return self._skin.whole(alive)

    def _agreement(self, position: Floats) -> Floats:
        """Return normal times sum of the normals of neighbours, shape (face,)."""
        a, b, c = position[self.members].swapaxes(0, 1)
        normal = cross(b - a, c - a)
        one, other = self._pairs
        around = np.empty_like(normal)
        for own, to in zip(normal.T, around.T, strict=True):
            to[:] = np.bincount(one, own[other], len(own))
            to += np.bincount(other, own[one], len(own))
        return dot(normal, around)

    def orientation(self, position: Floats) -> Floats:
        return self._agreement(position) * self._fit


@WATCHES.member(INSIDE_OUT)
class InsideOut:
    """Watches cells of solids of springs, and faces of bodies without cells."""

    kind = INSIDE_OUT

    def __init__(self, parts: list[_Oriented]):
        self._parts = parts

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without solids and surfaces."""
        parts: list[_Oriented] = []
        for body in network.bodies:
            if body.is_made_of_elements and not body.is_wall:
                continue  # these are followed between outputs, too
            if body.cells is not None:
                faces, _ = body.cells()
                parts.append(_Cells(network, body, faces.astype(np.int64) + body.nodes.start))
            elif body.divided is not None:
                corners = body.divided.astype(np.int64) + body.nodes.start
                parts.append(_Tetrahedra(network, body, corners))
            elif len(skin := network.skin_of(body)):
                parts.append(_Faces(network, body, skin))
        return cls(parts) if parts else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        for part in self._parts:
            yield from part.look(state, position)


def _contents(corners: Floats) -> Floats:
    """Return six times the signed volumes of tetrahedra [m³], from shape (cell, 4, 3)."""
    a, b, c, d = corners.swapaxes(0, 1)
    return dot(cross(b - a, c - a), d - a)


UNSTABLE = "unstable law"
LARGEST = 6.0  # stretch up to which laws are examined


@WATCHES.member(UNSTABLE)
class LawStability:
    """Watches the elements of laws that are not stable at all strains.

    Args:
        parts: Bodies with their elements of such laws, and the numbers of these.
    """

    kind: ClassVar[str] = UNSTABLE

    def __init__(
        self,
        network: Network,
        parts: "Sequence[tuple[BodyPart, Sequence[tuple[SolidElements | Membranes, Indices]]]]",
    ):
        self._network, self._parts = network, parts

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None where all laws are stable."""
        parts = [
            (body, concerned)
            for body in network.bodies
            if (concerned := [*_concerned(network.elements_of(body.name))])
        ]
        return cls(network, parts) if parts else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the bodies with elements beyond the stability of their law."""
        for body, concerned in self._parts:
            count, where = 0, ""
            for field, numbers in concerned:
                lost = np.isin(numbers, field.lost_items(state.alive))
                beyond = numbers[_is_beyond(field.only(numbers), position) & ~lost]
                count += len(beyond)
                if len(beyond) and not where:
                    where = self._place(field.nodes[beyond[0]])
            yield Finding(
                body.name, count,
                f"elements of {body.name} are strained beyond the stable range of their law",
                where, "element",
                "results depend on the mesh there; strain the body less, or choose a law whose "
                "stress keeps rising", body.span,
            )  # fmt: skip

    def _place(self, nodes: Indices) -> str:
        centre = self._network.position[nodes].mean(axis=0)
        return f"around ({', '.join(show(float(x), LENGTH) for x in centre)}) as drawn"


def _concerned(
    fields: "Sequence[SolidElements | Membranes]",
) -> "Iterator[tuple[SolidElements | Membranes, Indices]]":
    """Yield the fields that have elements of laws that are not stable everywhere."""
    from tissuec.laws.solid.volume import is_whole
    from tissuec.laws.stability import stable_strains

    for field in fields:
        suspect = [
            is_whole(law) or stable_strains(law, LARGEST) is not None for law in field.laws
        ]
        # What yields bears little more than its yield stress.
        numbers = np.flatnonzero(np.array(suspect)[field.law] & ~field.yields)
        if len(numbers):
            yield field, numbers


def _is_beyond(field: "SolidElements | Membranes", position: Floats) -> NDArray[np.bool_]:
    """Return whether a law is not stable at any point of elements, shape (element,)."""
    from tissuec.laws.stability import is_stable

    first, second = field.invariants(position)
    (ratio,) = field.seen("ratio", position)
    lame = np.broadcast_to((field.bulk_modulus / field.shear - 2.0 / 3.0)[:, None], first.shape)
    beyond = np.zeros(field.item_count, dtype=bool)
    for number in np.unique(field.law):
        own = field.law == number
        given = first[own], second[own], ratio[own], lame[own]
        stable = is_stable(field.laws[int(number)], *given)
        beyond[own] = ~stable.reshape(int(own.sum()), -1).all(axis=1)
    return beyond
