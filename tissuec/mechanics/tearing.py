"""Tears of solids: faces that open where a limit of the tissue is passed.

An element whose stress reaches its strength is divided across its largest principal stretch,
and its faces are tied; their traction falls as they open (``forces.solids.ties``). The surface
is given by one height at each node, which never changes: an element that shares a face with the
surface keeps the heights of the nodes of that face, and its other nodes get

    n · (X - p),

p being the mean of the points in which the surface meets the edges of the face, and n the
direction of the largest principal stretch of the mean of C = FᵀF over whole elements around it,
weighted by V exp(-r²/2(``AROUND`` h)²). So tears do not follow the mesh. If a smaller principal
stretch has tension across it and lies within ``STRAIGHT`` of the normal of the surface, the
tear continues across that one: nothing shears its faces then, and tension along them, as in
arms that are peeled off, does not turn it (local symmetry: R. V. Goldstein, R. L. Salganik,
Int. J. Fract. 10:507, 1974). Elements ahead of ties that soften are divided as soon as they
bear ``AHEAD`` of their strength, up to ``REACH`` elements away: a whole element would keep the
tear closed at its face. (Cohesive segments: J. J. C. Remmers, R. de Borst, A. Needleman,
Comput. Mech. 31:69, 2003; heights and limits were measured for this program.) Where tissue has
a strength or a breaking strain alone, faces are free at once.
"""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.forces.moduli import poisson_of
from tissuec.forces.solids.element_limits import BreakableElements
from tissuec.geometry.cut_cells.cutting import near_heights
from tissuec.mechanics.cut_body import CutBody
from tissuec.mechanics.cut_effects import put_ties
from tissuec.mechanics.cutting import carry_out_tied, divided
from tissuec.mechanics.tying import TiedSections
from tissuec.model.network import Floats, Indices
from tissuec.model.torn import Peeled, Torn

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements
    from tissuec.mechanics.state import State

Bools = NDArray[np.bool_]
AHEAD, REACH, AROUND = 0.5, 2.5, 1.5
#: Factor of the strength at which an element with toughness tears if no surface enters it.
ALONE = 2.0
BESIDE = 1.2  # of the size of an element: sections this near to one that softens do so, too
#: Cosine of the largest angle between the normal of a surface and a stretch, not the largest
#: one, across which the tear continues.
STRAIGHT = float(np.cos(np.deg2rad(15.0)))
BEND = 2.0  # of the size of an element: nodes this near to a place give the normal there
TEAR = "tear"  # name of all tears of a body as a cut
LEAST_HEIGHT = 0.03  # of new nodes, over the size of the element
#: Once a tear has begun, others begin only at this factor of the loads that elements bear
#: then.
FURTHER = 1.05
TOGETHER = 1e-3  # of a limit: elements this near to it tear with the one that tears


class Tears(Struct, frozen=True, eq=False):
    """The tears of a body; cells are those of the body as drawn, shape by shape.

    Attributes:
        torn: Cells that the surface goes through, shape (cell,) each.
        factor: Of the limits at which tears begin, shape (cell,) each.
        begun: Places, as drawn, at which tears began [m], shape (n, 3).
    """

    torn: tuple[Bools, ...]
    factor: tuple[Floats, ...]
    begun: Floats

    @classmethod
    def of(cls, state: "State", name: str) -> "Tears":
        """Return the tears of a body."""
        known = state.tears.get(name)
        if known is not None:
            return known
        fields = state.network.elements_of(name)
        torn = tuple(np.zeros(one.item_count, dtype=bool) for one in fields)
        factor = tuple(np.where(one.limits.parting > 0.0, ALONE, 1.0) for one in fields)
        return cls(torn, factor, np.zeros((0, 3)))


def tear(state: "State", name: str, broken: Indices) -> Torn:
    """Let a body tear where limits are passed; the state is changed in place.

    Args:
        name: Of the body, which has a reserve.
        broken: Elements, and names of tied sections, that are above their limits,
            shape (n,).

    Raises:
        NotDivisible: The reserve of the body is exhausted.
    """
    freed = _open(state, name, broken)
    if not has_limits(state, name):
        return freed
    front = TearFront.of(state, name)
    front.advance(np.isin(np.concatenate(front.body.entities), broken))
    torn = front.divide(state)
    set_limits(state, name)
    return Torn(np.union1d(freed.elements, torn.elements), torn.edges, *freed[2:])


def _open(state: "State", name: str, broken: Indices) -> Torn:
    """Let sections begin to soften, and free those that already did."""
    tied = state.tied.get(name)
    none = np.zeros(0, dtype=np.int64)
    if tied is None or not len(tied):
        return Torn(none, none)
    tears = np.isfinite(tied.first)
    body = state.cut_bodies[name]
    sections = tied.field(state.network, name, body).breakable
    if sections is None:
        return Torn(none, none)
    # A whole element can be above its limit, and its section not.
    able = sections.loads(state.position) >= 1.0 - TOGETHER
    own = np.isin(tied.names, np.intersect1d(sections.entities[able], broken)) & tears
    lost = tied.some(own & tied.softens)
    torn, peeled = Torn(none, none), list[Peeled]()
    for number in np.unique(lost.interface).tolist():
        one = lost.some(lost.interface == number)
        area = float(one.areas(state.network, name, body).sum())
        energy = float(one.field(state.network, name, body).energy(state.time, state.position))
        wholes = _drawn_entities(state, name, body, one.entities[:, 0])
        if number < 0:
            torn = Torn(wholes, none, area, energy)
            continue
        interface = state.network.body_named(name).interfaces[number]
        what = f"the interface {interface.name}"
        peeled.append(Peeled(what, interface.span, wholes, area, energy))
    left = replace(tied, softens=tied.softens | own).some(~(own & tied.softens))
    put_ties(state, name, _softened(left, body, state.network.position))
    return torn._replace(peeled=tuple(peeled))


def _softened(tied: TiedSections, body: CutBody, drawn: Floats) -> TiedSections:
    """Return the sections, those beside softening ones now softening, too."""
    from scipy.spatial import cKDTree

    if not tied.softens.any() or tied.softens.all():
        return tied
    middle = tied.values(body, drawn)[:, 0].mean(axis=1)
    away, _ = cKDTree(middle[tied.softens]).query(middle)
    tears, names = np.isfinite(tied.first), tied.names
    # All triangles of a section, which are free together.
    near = np.isin(names, names[tears & (away < BESIDE * tied.size)])
    return replace(tied, softens=tied.softens | (tears & near))


def _poisson(field: "SolidElements", cell: Indices) -> Floats:
    return np.asarray(poisson_of(field.shear[cell], field.bulk_modulus[cell]))


def _drawn_entities(state: "State", name: str, body: CutBody, parts: Indices) -> Indices:
    """Return the drawn elements of some parts, ascending, shape (n,)."""
    found = [np.zeros(0, dtype=np.int64)]
    for field, own, entities in zip(
        state.network.elements_of(name), body.parts, body.entities, strict=True
    ):
        found.append(field.walls[own.cell[np.isin(entities, parts)]])
    return np.unique(np.concatenate(found))


class TearFront:
    """Whole elements of a body, and the surface that continues into them.

    Elements of all shapes are numbered one after the other, parts among them.

    Attributes:
        body: The elements.
        heights: Of all nodes above the surface [m], NaN where it is not, shape (node,).
    """

    def __init__(self, state: "State", name: str, body: CutBody):
        self.name, self.body = name, body
        self.fields = state.network.elements_of(name)
        self.tears, self.drawn = Tears.of(state, name), state.network.position
        tied = state.tied.get(name)
        none = TiedSections.none(len(self.drawn), 4)
        self.tied = none if tied is None else tied.existing(body)
        self.heights = self.tied.heights.copy()
        whole = [each.are_whole for each in body.parts]
        self.is_whole: Bools = np.concatenate(whole)
        self.fresh: Bools = self._each(lambda k, cell: ~self.tears.torn[k][cell])
        self.soft: Bools = self._each(lambda k, cell: self.fields[k].limits.parting[cell] > 0.0)
        self.size = self._each(lambda k, cell: np.cbrt(self.fields[k].volume[cell]))
        self.poisson = self._each(lambda k, cell: _poisson(self.fields[k], cell))
        self.middle = np.concatenate(
            [self.drawn[each.drawn].mean(axis=1) for each in body.parts]
        )
        self._measure(state.position)

    @classmethod
    def of(cls, state: "State", name: str) -> "TearFront":
        """Return the elements of a body that exist."""
        return cls(state, name, CutBody.of(state, name))

    def _each(self, pick):
        """Return values of all elements, of number k of the shape and cells, shape (part,)."""
        return np.concatenate([pick(k, each.cell) for k, each in enumerate(self.body.parts)])

    def _measure(self, position: Floats) -> None:
        """Find loads over limits, and largest principal stretches, of whole elements."""
        count = len(self.is_whole)
        self.load, self.gradient = np.zeros(count), np.zeros((count, 3, 3))
        self.volume = np.ones(count)
        first = 0
        for field, parts in zip(self.fields, self.body.parts, strict=True):
            own = np.flatnonzero(parts.are_whole)
            if len(own):
                cell, nodes = parts.cell[own], parts.nodes[own]
                some = replace(field.only(cell), nodes=nodes)
                limits = field.limits.some(cell)
                limited = BreakableElements(some, limits, cell)
                weight = some.weights
                self.volume[first + own] = weight.sum(axis=1)
                share = weight / weight.sum(axis=1)[:, None]
                if len(limits.finite):
                    self.load[first + own] = limited.loads(position)
                self.gradient[first + own] = np.einsum(
                    "eax,eqay,eq->exy", position[nodes], some.steepness, share
                )
            first += len(parts)

    # --- where it continues -------------------------------------------------------------------

    def _faces(self) -> tuple[Bools, Floats]:
        """Return which whole elements the surface enters through a face, and where.

        Returns:
            Shape (part,), and the mean of the points in which it meets edges of the faces, as
            drawn [m], shape (part, 3).
        """
        enters, place = np.zeros(len(self.is_whole), dtype=bool), np.zeros_like(self.middle)
        first = 0
        for parts in self.body.parts:
            own = np.flatnonzero((self.is_whole & self.fresh)[first : first + len(parts)])
            corners = parts.nodes[own]
            high = self.heights[corners]
            count, total = np.zeros(len(own)), np.zeros((len(own), 3))
            for face in parts.division.faces:
                ring = face[face >= 0]
                at = high[:, ring]
                met = (
                    ~np.isnan(at).any(axis=1) & (at >= 0.0).any(axis=1) & (at < 0.0).any(axis=1)
                )
                here, there = at[met], np.roll(at[met], -1, axis=1)
                crosses = (here >= 0.0) != (there >= 0.0)
                part = here / np.where(crosses, here - there, 1.0)
                ends = self.drawn[corners[met][:, ring]]
                points = ends + part[..., None] * (np.roll(ends, -1, axis=1) - ends)
                total[met] += (points * crosses[..., None]).sum(axis=1)
                count[met] += crosses.sum(axis=1)
            enters[first + own] = count > 0.0
            place[first + own] = total / np.maximum(count, 1.0)[:, None]
            first += len(parts)
        return enters, place

    @property
    def _softening(self) -> Floats:
        """Return places, as drawn, of what softens or is free [m], shape (n, 3)."""
        tied, found = self.tied, [self.tears.begun]
        if len(tied):
            own = tied.some(tied.softens)
            found.append(own.values(self.body, self.drawn)[:, 0].mean(axis=1))
        known = ~np.isnan(tied.heights)
        nodes = tied.nodes(self.body)
        known[nodes[nodes >= 0]] = False
        found.append(self.drawn[known])
        return np.concatenate(found)

    def ahead(self) -> tuple[Bools, Floats]:
        """Return which elements tear at ``AHEAD`` times their strength, and where.

        The shapes are (part,), and (part, 3) [m], as those of ``_faces``.
        """
        from scipy.spatial import cKDTree

        enters, place = self._faces()
        near = self._softening
        own = np.flatnonzero(enters & self.soft)
        close = np.zeros(len(own), dtype=bool)
        if len(own) and len(near):
            away, _ = cKDTree(near).query(self.middle[own])
            close = away < REACH * self.size[own]
        enters[own[~close]] = False
        return enters, place

    def advance(self, broken: Bools) -> None:
        """Let the surface continue into elements, and begin where there is none.

        Args:
            broken: Elements above their limits, shape (part,).
        """
        broken = broken & self.is_whole & self.fresh
        alone = self.factors(np.zeros(len(broken), dtype=bool))
        broken = broken & (self.load >= alone * (1.0 - TOGETHER))
        has_continued = False
        while True:
            enters, place = self.ahead()
            least = np.where(self.soft, AHEAD, 1.0) * self.factors(enters) * (1.0 - TOGETHER)
            ready = enters & (self.load >= least)
            if ready.any():
                one = int(np.argmax(np.where(ready, self.load / least, -1.0)))
                self._enter(one, place[one])
                has_continued = True
                continue
            first = np.flatnonzero(broken & self.fresh)
            if has_continued or not len(first):
                break
            has_continued = True
            one = int(first[np.argmax(self.load[first])])
            self._enter(one, self.middle[one])
            self.tears = replace(
                self.tears, begun=np.concatenate([self.tears.begun, self.middle[[one]]])
            )
        if has_continued:
            self._raise()

    def factors(self, enters: Bools) -> Floats:
        """Return dimensionless factors of limits, 1 where the surface enters, shape (part,)."""
        factor = self._each(lambda k, cell: self.tears.factor[k][cell])
        return np.where(enters, 1.0, factor)

    def _raise(self) -> None:
        """Let other tears begin only above the loads that elements bear now."""
        first, every = 0, list[Floats]()
        for parts, known in zip(self.body.parts, self.tears.factor, strict=True):
            own = self.is_whole[first : first + len(parts)]
            load = self.load[first : first + len(parts)][own]
            factor = known.copy()
            cell = parts.cell[own]
            factor[cell] = np.maximum(factor[cell], FURTHER * load)
            every.append(factor)
            first += len(parts)
        self.tears = replace(self.tears, factor=tuple(every))

    def _enter(self, one: int, place: Floats) -> None:
        """Give heights to the nodes of an element that have none."""
        kind, row = self._where(one)
        parts = self.body.parts[kind]
        nodes = parts.nodes[row]
        own = self.heights[nodes]
        new = np.isnan(own)
        away = self.drawn[nodes] - place
        normal = self._across(one, place)
        if (~new).any() and (away[~new] @ normal * own[~new]).sum() < 0.0:
            normal = -normal
        high = away @ normal
        least = LEAST_HEIGHT * self.size[one]
        high = np.where(np.abs(high) < least, np.where(high < 0.0, -least, least), high)
        self.heights[nodes[new]] = high[new]
        torn = list(self.tears.torn)
        torn[kind] = torn[kind].copy()
        torn[kind][parts.cell[row]] = True
        self.tears = replace(self.tears, torn=tuple(torn))
        self.fresh[one] = False

    def _where(self, one: int) -> tuple[int, int]:
        first = 0
        for kind, parts in enumerate(self.body.parts):
            if one < first + len(parts):
                return kind, one - first
            first += len(parts)
        raise IndexError(one)

    def _across(self, one: int, place: Floats) -> Floats:
        """Return the direction across a face in an element, as drawn, a unit vector (3,)."""
        away = ((self.middle - place) ** 2).sum(axis=1)
        weight = np.exp(-away / (2.0 * (AROUND * self.size[one]) ** 2)) * self.volume
        weight = np.where(self.is_whole & self.fresh, weight, 0.0)
        weight[one] = max(weight[one], np.finfo(float).tiny)
        squares = self.gradient.swapaxes(1, 2) @ self.gradient
        mean = np.einsum("p,pxy->xy", weight / weight.sum(), squares)
        stretch, ways = np.linalg.eigh(mean)
        strain, poisson = 0.5 * (stretch - 1.0), self.poisson[one]
        is_pulled = strain + poisson / (1.0 - 2.0 * poisson) * strain.sum() > 0.0
        along = np.abs(self._normal(one, place) @ ways)
        nearest = int(np.argmax(np.where(is_pulled, along, -1.0)))
        return np.asarray(ways[:, nearest if along[nearest] > STRAIGHT else -1])

    def _normal(self, one: int, place: Floats) -> Floats:
        """Return the normal of the surface where it enters an element; 0 where it has none."""
        away = self.drawn - place
        near = ~np.isnan(self.heights) & ((away**2).sum(axis=1) < (BEND * self.size[one]) ** 2)
        plane = np.column_stack([away[near], np.full(near.sum(), self.size[one])])
        found, _, rank, _ = np.linalg.lstsq(plane, self.heights[near], rcond=1e-6)
        steep = np.linalg.norm(found[:3])
        return found[:3] / steep if rank == 4 and steep > 0.0 else np.zeros(3)

    # --- what becomes of it -------------------------------------------------------------------

    def divide(self, state: "State") -> Torn:
        """Divide what has torn; the state is changed in place."""
        none = np.zeros(0, dtype=np.int64)
        state.tears = {**state.tears, self.name: self.tears}
        body, heights = self.body, self.heights
        active, first = list[Bools](), 0
        for parts, torn in zip(body.parts, self.tears.torn, strict=True):
            active.append(self.is_whole[first : first + len(parts)] & torn[parts.cell])
            first += len(parts)
        found = None
        if any(each.any() for each in active):
            near = near_heights(body.parts, self.drawn)
            own = np.where(np.abs(heights) < near, 0.0, heights)
            found = divided(state, self.name, own, TEAR, tuple(active))
        if found is None:
            put_ties(state, self.name, replace(self.tied, heights=heights))
            return Torn(none, none)
        old, new, edges = carry_out_tied(state, found, heights)
        tied = old.followed_by(new.some(new.is_gradual), found.body)
        put_ties(state, self.name, replace(tied, heights=new.heights))
        alone = new.some(~new.is_gradual).entities[:, 0]
        return Torn(_drawn_entities(state, self.name, found.body, alone), edges)


def has_limits(state: "State", name: str) -> bool:
    """Return whether elements of a body tear; ties of its interfaces part without.

    Args:
        name: Of the body.
    """
    return any(each.limits is not None for each in state.network.elements_of(name))


def set_limits(state: "State", name: str) -> None:
    """Set the limits of elements, lower where a tear is about to enter (``TearFront.ahead``).

    Args:
        name: Of the body; without limits, nothing changes.
    """
    if not has_limits(state, name):
        return
    front = TearFront.of(state, name)
    enters, _ = front.ahead()
    factor = np.where(enters & front.soft, AHEAD, front.factors(enters))
    count = state.network.entity_count
    of_entity, cell = np.full(count, np.inf), np.zeros(count, dtype=np.int64)
    for field in front.fields:
        cell[field.walls] = np.arange(field.item_count)
    entities = np.concatenate(front.body.entities)
    of_entity[entities] = np.where(front.fresh & front.is_whole, factor, np.inf)
    cell[entities] = np.concatenate([each.cell for each in front.body.parts])
    for block in list(state.blocks.values()):
        field = block.field
        if block.kind != "elements" or field.name != name or field.limits is None:
            continue
        (drawn,) = (each for each in front.fields if each.shape.name == field.shape.name)
        limits = drawn.limits.some(cell[field.walls]).times(of_entity[field.walls])
        state.put(replace(block, field=replace(field, limits=limits)))
