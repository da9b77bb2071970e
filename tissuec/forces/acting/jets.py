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

from collections.abc import Callable, Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec import autodiff
from tissuec.autodiff import Number, Numbers, Potential, Vector
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.potentials import TracedItem
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.acting.jet_surfaces import MOST, JetSurface
from tissuec.forces.acting.jets_kernel import GRID, NEAR, JetTable, blow
from tissuec.forces.fields import Field, acts_of
from tissuec.forces.grouped_items import inputs
from tissuec.forces.matrices import assembled
from tissuec.kernels.records import BoundaryConditions
from tissuec.kernels.thread_loops import UNDIVIDED
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

WORTHWHILE = 500  # triangles from which threads share them
# That the kernel takes for an element of a triangle, where a quarter of them is in the jet [s].
ELEMENT_SECONDS = 8e-8
_ALWAYS = TimeProfile("constant", 0.0, np.inf)


def _pressed(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
    """Return the power that a jet supplies to an element at rest."""
    normal = autodiff.cross(x[1] - x[0], x[2] - x[0])
    slope = autodiff.dot(normal, p.along)  # twice the area times cos θ
    facing = slope * abs(slope) / (2.0 * autodiff.square(normal))
    seen = x[0] * p.shares[0] + x[1] * p.shares[1] + x[2] * p.shares[2] - p.start
    ahead = autodiff.dot(seen, p.along)
    width: Number = p.width**2 + (p.growth * ahead) ** 2
    beside = autodiff.square(seen) - ahead**2
    near = autodiff.minimum(autodiff.maximum(ahead / p.near, 0.0), 1.0)
    flux = 2.0 / np.pi * p.thrust * autodiff.exp(-2.0 * beside / width) / width
    force = flux * p.lit * near * near * (3.0 - 2.0 * near) * facing
    speed = v[0] * p.shares[0] + v[1] * p.shares[1] + v[2] * p.shares[2]
    return Potential(0.0, supply=force * autodiff.dot(normal, speed))


@cache
def _traced_element() -> TracedItem:
    """Return an element, which the corners of its triangle carry."""
    vectors, numbers = (
        ("along", "start", "shares"),
        ("thrust", "growth", "width", "near", "lit"),
    )
    return TracedItem(_pressed, 3, dict.fromkeys(vectors, 3) | dict.fromkeys(numbers, 1))


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
        return ELEMENT_SECONDS * float(self.skin.count.sum())

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

    def met(self, position: Floats) -> Indices:
        """Return the intact triangles that lie at least partly within the jet, shape (n,)."""
        table = self._blown(position)
        return np.flatnonzero(self.skin.whole)[table.met[: table.found[0]]]

    def _blown(self, position: Floats) -> JetTable:
        """Return the table after an evaluation, whatever the flow."""
        from tissuec.compiled.calls import kernel_on

        acts = acts_of([(1.0, _ALWAYS)], 0.0, 0.0)
        table = self.table(np.arange(len(position)), acts, position)
        x, none = position.reshape(-1).astype(float), np.zeros((2, position.size))
        kernel_on(self.kernel, table)(0.0, x, *none, np.zeros(2))
        return table

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return the symmetric part of how forces fall with places [N/m], as they are lit now.

        The other part belongs to no energy. Unless it is to be ``exact``, nothing is returned,
        because what there is may be negative.
        """
        from scipy.sparse import csc_matrix

        flow = max(self.flow * self.profile.at(time)[0], 0.0)
        if not exact or not flow > 0.0:
            return csc_matrix((3 * size, 3 * size))
        table = self._blown(position)
        element = np.flatnonzero(table.lit)
        owner = np.searchsorted(table.elements, element, side="right") - 1
        count = table.shares_end - table.shares_start
        share = table.shares_start[owner] + element - table.elements[owner]
        nodes = table.corners[owner]
        values = inputs(
            {
                "start": table.frame[:3, None],
                "along": table.frame[3:6, None],
                "shares": table.shares[share].T,
                "thrust": self.density * flow * flow / (0.25 * np.pi * self.bore**2),
                "growth": self.growth,
                "width": self.width,
                "near": NEAR * self.bore,
                "lit": table.lit[element] / count[owner],
            }
        )
        for corner, axis in np.ndindex(3, 3):
            values[f"x.{corner}.{axis}"] = position[nodes[:, corner], axis]
        turning = np.zeros((81, len(table.corners)))
        for row, each in zip(turning, evaluate(_traced_element().turning, values), strict=True):
            np.add.at(row, owner, each)
        blocks = turning.T.reshape(-1, 9, 9)
        even = 0.5 * (blocks + blocks.swapaxes(1, 2))
        return assembled(even.reshape(-1, 3, 3, 3, 3), number[table.corners], size)

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
            elements=(np.cumsum(count) - count).astype(np.int64),
            lit=np.zeros(count.sum()),
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
