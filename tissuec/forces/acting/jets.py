"""Jets of fluid, which leave a nozzle and push surfaces.

A jet leaves an opening of bore d with the flow Q of a fluid of density ρ. Its speed at a
distance s ahead of the opening and r beside the axis is

    u = U b0/b exp(-r²/b²),    b² = b0² + (k s)²,    b0 = d/√2,    U = 4 Q / π d²,

so that its momentum flux, J = ∫ ρ u² dA = 4 ρ Q² / π d², is the same at every distance. A jet
of liquid in gas hardly spreads (k = 0); one within the same fluid is a free turbulent jet,
whose half-width r½ = b √ln 2 grows by 0.094 for each length (H. J. Hussein, S. P. Capp, W. K.
George, J. Fluid Mech. 258:31, 1994; S. B. Pope, Turbulent Flows, 2000, section 5.1).

Where it meets a surface, fluid continues along the surface and leaves to it the part of its
momentum that is normal to it. An element of area A with the unit normal n, at the angle
cos θ = n·e to the jet, is pressed along n with

    F = ρ φ(u, w) A cos² θ V,

where φ is (u - w)², w being the speed at which the element itself goes along the jet, and V is
the part of the jet that nothing takes away before. A plate that catches all of a jet is thus
pressed with J cos θ along its normal.

V follows from the triangles in front. In coordinates ξ = r/b, which go along with the
jet, each covers what lies within its edges, by a product of smooth steps over the distances
from them, so that neighbours cover together what is between them. It covers what is behind its
plane and has no corner in common with it. V falls from 1 to 0 while the sum rises from ``LIT``
to ``DARK``. Forces have continuous derivatives by all places.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up, cross
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.acting.jet_surfaces import MOST, JetSurface
from tissuec.forces.acting.jets_kernel import (
    CUT,
    DARK,
    DEEP,
    FLAT,
    GRID,
    LIT,
    NEAR,
    SLACK,
    STEEP,
    TINY,
    JetTable,
    blow,
)  # fmt: skip
from tissuec.forces.fields import Field
from tissuec.forces.matrices import assembled
from tissuec.kernels.records import BoundaryConditions
from tissuec.kernels.thread_loops import UNDIVIDED
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

SLIGHT = 1e-6  # of an edge: step of differences
AT_ONCE = 1_000_000  # pairs of triangles that are examined together
WORTHWHILE = 500  # triangles from which threads share them
TRIANGLE_SECONDS = 3e-7  # that the kernel takes for a triangle, measured [s]


class JetAxis(NamedTuple):
    """The axis of a jet.

    Attributes:
        start: The opening [m], shape (3,).
        along: Unit vector, shape (3,).
        across: Two more, all three right-handed, shape (2, 3).
    """

    start: Floats
    along: Floats
    across: Floats


class JetCoordinates(NamedTuple):
    """Coordinates of points in a jet, each of shape (…).

    Attributes:
        ahead: Distance from the opening along the axis [m].
        width: b there [m].
        beside: ξ, shape (…, 2).
    """

    ahead: Floats
    width: Floats
    beside: Floats


class Elements(NamedTuple):
    """The elements of some triangles.

    Attributes:
        owner: Number of the triangle, ascending, shape (element,).
        weights: Shares of its corners, shape (element, 3).
    """

    owner: Indices
    weights: Floats

    def at(self, corners: Floats) -> Floats:
        """Return corner values at the elements, in their unit.

        Args:
            corners: In any unit, shape (triangle, 3, 3).

        Returns:
            Shape (element, 3).
        """
        return np.einsum("ei,eik->ek", self.weights, corners[self.owner])


class Jet(Field, frozen=True):
    """The jet of one nozzle.

    Attributes:
        nozzle: Its name.
        target: Of what is pushed; "" for all there is.
        opening: Nodes in the opening and straight ahead of it, shape (2,).
        bore: d [m].
        density: ρ [kg/m³].
        growth: k.
        width: b0 [m]; wider than it should be where a mesh is very coarse.
        flow: Q [m³/s] where the profile is 1.
        profile: Of the flow; where it is negative, nothing flows.
        skin: What it may meet.
        span: The sentence.
    """

    nozzle: str
    target: str
    opening: Indices
    bore: float
    density: float
    growth: float
    width: float
    flow: float
    profile: TimeProfile
    skin: JetSurface
    span: Span

    @property
    def seconds(self) -> float:
        """Return about how long one evaluation takes [s]."""
        return TRIANGLE_SECONDS * len(self.skin.corners)

    @property
    def loss(self) -> str:
        """Why energy is not conserved: a jet supplies it."""
        return "a jet puts energy in"

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the jet of {self.nozzle}", "jet", self, self.span)

    def torn(self, alive: NDArray[np.bool_]) -> "Jet":
        """Return the same while the springs ``alive``, shape (spring,), are there."""
        skin = self.skin.torn(alive)
        return self if skin is self.skin else replace(self, skin=skin)

    def thrust(self, time: float) -> float:
        """Return the momentum flux J [N]."""
        flow = max(self.flow * self.profile.at(time)[0], 0.0)
        return self.density * flow * flow / (0.25 * np.pi * self.bore**2)

    def axis(self, position: Floats) -> JetAxis:
        """Return the present place of the opening and the direction of the jet.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        start, ahead = position[self.opening]
        along = (ahead - start) / np.linalg.norm(ahead - start)
        one = cross(along, np.eye(3)[np.argmin(np.abs(along))])
        one /= np.linalg.norm(one)
        return JetAxis(start, along, np.stack([one, cross(along, one)]))

    def way(self, points: Floats, axis: JetAxis) -> JetCoordinates:
        """Return where points, shape (…, 3) [m], are in the jet."""
        seen = points - axis.start
        ahead = seen @ axis.along
        width = np.hypot(self.width, self.growth * ahead)
        return JetCoordinates(ahead, width, seen @ axis.across.T / width[..., None])

    def met(self, position: Floats) -> Indices:
        """Return the intact triangles that lie at least partly within the jet, shape (n,).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        axis = self.axis(position)
        corners = position[self.skin.corners]
        middle = corners.mean(axis=1)
        reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1, initial=0.0)
        way = self.way(middle, axis)
        within = way.ahead + reach > 0.0
        furthest = np.hypot(self.width, self.growth * (np.abs(way.ahead) + reach))
        within &= np.linalg.norm(way.beside, axis=1) * way.width < CUT * furthest + reach
        return np.flatnonzero(within & self.skin.whole)

    def _pushed(
        self,
        thrust: float,
        axis: JetAxis,
        met: Indices,
        elements: Elements,
        corners: Floats,
    ) -> Floats:
        """Return the forces on elements at rest that nothing shades [N], shape (element, 3).

        Args:
            met: The triangles.
            corners: Theirs [m], shape (triangle, 3, 3).
        """
        area, normal, slope = _facing(corners, axis.along)
        part = area / self.skin.count[met] * self._turned(met, slope) * slope * slope
        way = self.way(elements.at(corners), axis)
        speed = np.sqrt(2.0 * thrust / (np.pi * self.density)) / way.width
        speed *= np.exp(-_squares(way.beside))
        flux = self.density * speed * speed
        flux *= _rise(way.ahead / (NEAR * self.bore)) * part[elements.owner]
        return flux[:, None] * _along(normal, slope)[elements.owner]

    def _turned(self, met: Indices, slope: Floats) -> NDArray[np.bool_]:
        """Return which triangles can be pushed from where the jet comes."""
        side = self.skin.side[met]
        return self.skin.struck[met] & ((side == 0) | (side * slope < 0.0))

    def _lit(self, axis: JetAxis, met: Indices, elements: Elements, corners: Floats) -> Floats:
        """Return the parts V of the jet that come to elements, shape (element,)."""
        _, normal, slope = _facing(corners, axis.along)
        normal, points = _along(normal, slope), elements.at(corners)
        level = np.einsum("tk,tk->t", normal, corners[:, 0])
        blur, way = self.skin.blur[met], self.way(points, axis)
        edge = self.way(corners, axis)
        below, above = self._shaded(met, edge, slope)
        # What is in a plane, but for rounding, shades nothing there.
        height = np.einsum("pk,pik->pi", normal[above], corners[below]).max(axis=1)
        may = height - level[above] > FLAT * blur[above]
        one, shade = _with_elements(elements.owner, below[may], above[may], len(met))
        deep = np.einsum("pk,pk->p", points[one], normal[shade]) - level[shade]
        before = way.ahead[one] * np.abs(slope[shade]) - deep
        inside = (deep > 0.0) & (before > 0.0)
        one, shade, deep, before = (part[inside] for part in (one, shade, deep, before))
        steep = np.abs(slope[shade])
        cover = _rise(deep / (DEEP * blur[shade])) * _rise(steep / STEEP)
        cover *= _rise(before / (steep * NEAR * self.bore))
        soft = np.asarray(blur / edge.width.mean(axis=1))
        for k in range(3):
            start, stop = edge.beside[shade, k], edge.beside[shade, (k + 1) % 3]
            distance = _left_of(stop - start, way.beside[one] - start)
            cover *= _rise(0.5 + 0.5 * np.sign(slope[shade]) * distance / soft[shade])
        total = np.bincount(one, cover, len(points)).astype(float, copy=False)
        return 1.0 - _rise((total - LIT) / (DARK - LIT))

    def _shaded(
        self, met: Indices, edge: JetCoordinates, slope: Floats
    ) -> tuple[Indices, Indices]:
        """Return pairs of a triangle that is pushed and another one that is near it in ξ.

        Args:
            edge: Where the corners are, shape (triangle, 3).
        """
        middle = edge.beside.mean(axis=1)
        reach = np.linalg.norm(edge.beside - middle[:, None], axis=2).max(axis=1, initial=0.0)
        reach = SLACK * reach
        span = reach + self.skin.blur[met] / edge.width.mean(axis=1)
        lit = np.flatnonzero(self._turned(met, slope))
        found = [np.zeros((2, 0), dtype=np.int64)]
        step = max(1, AT_ONCE // max(len(met), 1))
        for some in (lit[k : k + step] for k in range(0, len(lit), step)):
            apart = np.linalg.norm(middle[some, None] - middle[None], axis=2)
            one, other = np.nonzero(apart < reach[some, None] + span)
            found.append(np.stack([some[one], other]))
        below, above = np.concatenate(found, axis=1)
        nodes = self.skin.corners[met]
        joined = (nodes[below][:, :, None] == nodes[above][:, None]).any(axis=(1, 2))
        return below[~joined], above[~joined]

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return the symmetric part of how forces fall with places [N/m], as they are lit now.

        The other part belongs to no energy. Unless it is to be ``exact``, nothing is returned,
        because what there is may be negative.

        Args:
            number: Of each node of the scene among those that may move, -1 for others.
            size: How many may move; the matrix is of shape (3 size, 3 size).
        """
        from scipy.sparse import csc_matrix

        shape, thrust = (3 * size, 3 * size), self.thrust(time)
        if not exact or not thrust > 0.0:
            return csc_matrix(shape)
        axis, met = self.axis(position), self.met(position)
        nodes = self.skin.corners[met]
        corners, elements = position[nodes], _elements(self.skin.parts[met])
        lit = self._lit(axis, met, elements, corners)
        edge = np.ptp(corners, axis=(0, 1)).max(initial=1e-12)
        blocks = np.zeros((len(met), 9, 9))
        for column in range(9):
            step = np.zeros((3, 3))
            step.flat[column] = SLIGHT * edge
            for sign in (1.0, -1.0):
                there = corners + sign * step
                force = self._pushed(thrust, axis, met, elements, there) * lit[:, None]
                shared = elements.weights[:, :, None] * force[:, None, :]
                each = np.zeros((len(met), 3, 3))
                np.add.at(each, elements.owner, shared)
                blocks[:, :, column] -= sign * each.reshape(-1, 9) / (2.0 * SLIGHT * edge)
        values = 0.5 * (blocks + blocks.swapaxes(1, 2))
        return assembled(values.reshape(-1, 3, 3, 3, 3), number[nodes], size)

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…): none."""
        return np.zeros(position.shape[:-2])

    def wayward(self, time: float, position: Floats) -> Floats:
        """Return all forces at rest, none of which has a potential [N], shape (node, 3)."""
        found, rest = np.zeros_like(position), np.zeros_like(position)
        self.add_forces(time, position, rest, found)
        return found

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        return 0.0

    def noise(self, time: float, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        size = float(np.abs(position).max(initial=0.0))
        return self.density * self.flow**2 / self.bore**2 * (1.0 + size / self.width)

    def stiffening(self, time: float, position: Floats) -> None:
        """Return None: what it pushes away is not held."""

    # --- for the engine ---------------------------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return blow

    @property
    def changes(self) -> tuple[tuple[float, TimeProfile], ...]:
        """Return the flow."""
        return ((self.flow, self.profile),)

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> JetTable:
        """Return the jet with triangles that are not torn."""
        whole, skin = self.skin.whole, self.skin
        parts, count = skin.parts[whole], skin.count[whole]
        sizes, of = np.unique(parts, return_inverse=True)
        starts = np.concatenate([[0], np.cumsum(3 * sizes**2)])[of.reshape(-1)]
        triangles = len(parts)
        return JetTable(
            acts=acts,
            opening=place[self.opening],
            bore=self.bore,
            density=self.density,
            growth=self.growth,
            width=self.width,
            corners=np.ascontiguousarray(place[skin.corners[whole]]),
            side=skin.side[whole],
            struck=skin.struck[whole].astype(np.int64),
            blur=skin.blur[whole],
            shares=np.concatenate([np.zeros((0, 3)), *(shares(int(n)) for n in sizes)]),
            shares_start=starts.astype(np.int64),
            shares_end=(starts + count).astype(np.int64),
            frame=np.zeros(12),
            part=UNDIVIDED,
            parts=0,
            faces=np.zeros((triangles, 20)),
            points=np.zeros((count.max(initial=0), 7)),
            met=np.zeros(triangles, dtype=np.int64),
            link=np.zeros(triangles, dtype=np.int64),
            shades=np.zeros(triangles, dtype=np.int64),
            head=np.zeros(GRID * GRID, dtype=np.int64),
            found=np.zeros(1, dtype=np.int64),
            cell_size=np.zeros(1),
        )

    def in_parts(self, table: JetTable, parts: int) -> list[list[JetTable]]:
        """Return a table that finds triangles, those of parts of them, and one that adds up."""
        if parts == 1 or len(table.corners) < WORTHWHILE:
            return [[table]]

        def part(number: int) -> JetTable:
            points, shades = np.zeros_like(table.points), np.zeros_like(table.shades)
            return table._replace(part=number, parts=parts, points=points, shades=shades)

        return [[part(0)], [part(number) for number in range(1, parts + 1)], [part(parts + 1)]]


def _squares(vectors: Floats) -> Floats:
    return np.einsum("...k,...k->...", vectors, vectors)


def _facing(corners: Floats, along: Floats) -> tuple[Floats, Floats, Floats]:
    """Return areas [m²], unit normals and their components along the jet, of triangles."""
    normal = 0.5 * cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    normal = normal / np.maximum(area, TINY)[:, None]
    return area, normal, normal @ along


def _along(normal: Floats, slope: Floats) -> Floats:
    """Return normals turned to where the jet goes."""
    return np.where(slope < 0.0, -1.0, 1.0)[:, None] * normal


def _elements(parts: Indices) -> Elements:
    """Return the elements of triangles that are divided into so many parts along an edge."""
    tables = [shares(int(n)) for n in parts]
    counts = np.array([len(table) for table in tables], dtype=np.int64)
    weights = np.concatenate([*tables, np.zeros((0, 3))])
    return Elements(np.repeat(np.arange(len(parts)), counts), weights)


@lru_cache(maxsize=MOST)
def shares(parts: int) -> Floats:
    """Return the quadrature points of a triangle as dimensionless weights of its corners.

    Each of n² equal parts has three points, which integrate polynomials of second degree
    exactly; the shape is (3 n², 3).
    """
    i, j = (index.ravel() for index in np.indices((parts, parts)))
    up, down = i + j < parts, i + j < parts - 1
    ways = np.array([[1.0, 1.0], [4.0, 1.0], [1.0, 4.0]]) / 6.0
    starts = np.stack([i, j], axis=1)
    points = [starts[up] + way for way in ways] + [starts[down] + 1.0 - way for way in ways]
    one, other = np.concatenate(points).T / parts
    return np.stack([1.0 - one - other, one, other], axis=1)


def _with_elements(
    owner: Indices, below: Indices, above: Indices, triangles: int
) -> tuple[Indices, Indices]:
    """Return all elements of the triangles ``below``, each with that ``above`` it."""
    count = np.bincount(owner, minlength=triangles)
    sizes = count[below]
    first = (np.cumsum(count) - count)[below]
    return np.repeat(first, sizes) + counted_up(sizes), np.repeat(above, sizes)


def _left_of(edge: Floats, seen: Floats) -> Floats:
    """Return how far points are to the left of edges; both are of shape (…, 2)."""
    twice = edge[..., 0] * seen[..., 1] - edge[..., 1] * seen[..., 0]
    return twice / (np.hypot(edge[..., 0], edge[..., 1]) + TINY)


def _rise(part: Floats) -> Floats:
    """Return a smooth step from 0 at 0 to 1 at 1."""
    part = np.clip(part, 0.0, 1.0)
    return part * part * (3.0 - 2.0 * part)
