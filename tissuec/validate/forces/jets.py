"""The force of a jet of fluid, element by element of the surfaces in it.

The law is that of docs/numerics.md (Irrigation): momentum flux J = ρ Q² / (π d²/4), a Gaussian
profile u = √(2 J / π ρ) / b exp(-r²/b²) with b² = b0² + (k s)², an element of area A pressed
along its normal with ρ φ A cos²θ V. Edges of triangles are divided into parts no longer than
b0, with three points in each part.
"""

from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.core.arrays import cross
from tissuec.validate.forces import ForceFormula, assembled

if TYPE_CHECKING:
    from tissuec.forces.acting.jets import Jet

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
# Constants of the law; docs/numerics.md lists them.
MOST_PARTS = 16  # of an edge; a jet is widened where it would need more
SHADE_WIDTH, SHADE_HEIGHT = 0.4, 0.35  # blur of shades over b0, and over a triangle's height
SHADE_DEPTH = 0.5  # of the blur: how far behind a triangle its shade is full
SHADE_BEGINS, SHADE_ENDS = 0.3, 0.7  # covered parts of the jet between which it goes out
GRAZING = 0.2  # cos θ below which shades fade
NO_SHADE = -1e9  # blur of faces of cuts, whose shades begin so far inside of their edges [m]
RISE = 0.5  # bores within which the jet sets in
COPLANAR = 1e-6  # of the blur: what is no further behind a plane is not shaded by it
BEYOND = 6.0  # widths beside the axis where exp(-r²/b²) is below rounding
SHARPEST = 16.0  # widths of its blur by which a shade may reach beyond a sharp corner
NUDGE = 1e-6  # of the largest coordinate difference: step of differences


class Beam(NamedTuple):
    """The axis of a jet: its opening [m], its direction, and two directions across it."""

    start: Floats
    along: Floats
    first: Floats
    second: Floats


class JetForce(ForceFormula):
    """The jet of one nozzle as a field of forces.

    Args:
        jet: Read for its numbers, its profile, and the triangles that it may meet, whose
            corners as drawn decide how they are divided.
    """

    def __init__(self, jet: "Jet"):
        self._jet = jet
        skin = jet.skin
        drawn, is_whole = skin.drawn, skin.like == np.arange(len(skin.like))
        edges = np.sqrt(((drawn - drawn[:, [1, 2, 0]]) ** 2).sum(axis=2)).max(axis=1)
        heights = 2.0 * facing(drawn, np.zeros(3))[0] / np.maximum(edges, 1e-300)
        longest = edges[skin.struck & is_whole].max()
        self._width = max(jet.bore / np.sqrt(2.0), longest / MOST_PARTS)
        blur = np.minimum(SHADE_WIDTH * self._width, SHADE_HEIGHT * heights)[skin.like]
        blur[skin.like < 0] = NO_SHADE
        # Less a little: rounding must not divide equal triangles differently.
        parts = np.clip(np.ceil(edges / self._width - 1e-9), 1, MOST_PARTS).astype(int)
        self._chosen = np.flatnonzero(skin.whole)
        self._corners, self._side = skin.corners[self._chosen], skin.side[self._chosen]
        self._struck, self._blur = skin.struck[self._chosen], blur[self._chosen]
        tables = [points_of(each) for each in parts[self._chosen]]
        self._owner = np.repeat(np.arange(len(tables)), [len(table) for table in tables])
        self._shares = np.concatenate([*tables, np.zeros((0, 3))])
        self._parts = np.bincount(self._owner, minlength=len(tables))
        self._state: tuple[float, Floats, Floats] | None = None
        self._found: tuple[Beam, Floats]

    def _thrust(self, time: float) -> float:
        flow = max(self._jet.flow * self._jet.profile.at(time)[0], 0.0)
        return 4.0 * self._jet.density * flow**2 / (np.pi * self._jet.bore**2)

    def _beam(self, position: Floats) -> Beam:
        start, ahead = position[self._jet.opening]
        along = (ahead - start) / np.sqrt(((ahead - start) ** 2).sum())
        helper = np.eye(3)[int(np.argmin(np.abs(along)))]
        first = cross(along, helper)
        first /= np.sqrt((first**2).sum())
        return Beam(start, along, first, cross(along, first))

    def _seen(self, points: Floats, beam: Beam) -> tuple[Floats, Floats, Floats]:
        """Return distance ahead [m], width b [m] and ξ of points, shape (…,), (…,), (…, 2)."""
        arm = points - beam.start
        ahead = arm @ beam.along
        width = np.sqrt(self._width**2 + (self._jet.growth * ahead) ** 2)
        beside = np.stack([arm @ beam.first, arm @ beam.second], axis=-1)
        return ahead, width, beside / width[..., None]

    def _forces(self, time: float, position: Floats, velocity: Floats) -> tuple[Beam, Floats]:
        """Return the beam and the forces on corners of triangles [N], (triangle, 3, 3).

        The last ones are kept, as force and power are needed in one state.
        """
        state = time, position, velocity
        if self._state is None or not all(map(np.array_equal, self._state, state)):
            beam, corners = self._beam(position), position[self._corners]
            pressed = self._pressed(self._thrust(time), beam, corners, velocity[self._corners])
            self._found = beam, self._shared(pressed * self._lit(beam, corners)[:, None])
            self._state = time, position.copy(), velocity.copy()
        return self._found

    def _shared(self, pressed: Floats) -> Floats:
        """Return forces on elements as forces on corners [N], shape (triangle, 3, 3)."""
        found = np.zeros((len(self._corners), 3, 3))
        np.add.at(found, self._owner, self._shares[:, :, None] * pressed[:, None, :])
        return found

    def _points(self, corners: Floats) -> Floats:
        return np.einsum("ei,eik->ek", self._shares, corners[self._owner])

    def _pressed(self, thrust: float, beam: Beam, corners: Floats, velocity: Floats) -> Floats:
        """Return forces on elements in full light [N], shape (element, 3)."""
        area, normal, slope = facing(corners, beam.along)
        faces = self._struck & ((self._side == 0) | (self._side * slope < 0.0))
        ahead, width, beside = self._seen(self._points(corners), beam)
        jet = self._jet
        profile = np.exp(-(beside**2).sum(axis=1)) / width
        speed = np.sqrt(2.0 * thrust / (np.pi * jet.density)) * profile
        away = self._points(velocity) @ beam.along
        # (u - w)² of what is slower than the jet; what comes towards it meets no more than u.
        slower: Floats = (speed - away) ** 2
        flux: Floats = np.where(away < 0.0, speed * (speed - 2.0 * away), slower)
        flux = np.where(away > speed, 0.0, flux) * smooth(ahead / (RISE * jet.bore))
        size = faces * area * slope**2 / self._parts
        along = np.where(slope < 0.0, -1.0, 1.0)[:, None] * normal
        return (jet.density * flux * size[self._owner])[:, None] * along[self._owner]

    def _lit(self, beam: Beam, corners: Floats) -> Floats:
        """Return the parts V of the jet that come to elements, shape (element,)."""
        _, normal, slope = facing(corners, beam.along)
        normal = np.where(slope < 0.0, -1.0, 1.0)[:, None] * normal
        level = np.einsum("tk,tk->t", normal, corners[:, 0])
        points = self._points(corners)
        ahead, _, seen = self._seen(points, beam)
        _, widths, edges = self._seen(corners, beam)
        soft = self._blur / widths.mean(axis=1)
        middle = edges.mean(axis=1)
        reach = np.sqrt(((edges - middle[:, None]) ** 2).sum(axis=2)).max(axis=1)
        reach = reach + SHARPEST * soft
        apart = np.sqrt(((seen[:, None] - middle[None]) ** 2).sum(axis=2))
        far = (seen**2).sum(axis=1) > BEYOND**2
        one, shade = np.nonzero((apart < reach) & ~far[:, None])
        below = self._owner[one]
        common = (self._corners[below][:, :, None] == self._corners[shade][:, None]).any((1, 2))
        heights = np.einsum("pk,pik->pi", normal[shade], corners[below]).max(axis=1)
        behind = heights - level[shade] > COPLANAR * self._blur[shade]
        one, shade = one[~common & behind], shade[~common & behind]
        deep = np.einsum("pk,pk->p", points[one], normal[shade]) - level[shade]
        steep = np.abs(slope[shade])
        before = ahead[one] * steep - deep
        cover = np.where((deep > 0.0) & (before > 0.0), smooth(steep / GRAZING), 0.0)
        cover *= smooth(deep / (SHADE_DEPTH * self._blur[shade]))
        cover *= smooth(before / (np.maximum(steep, 1e-300) * RISE * self._jet.bore))
        for k in range(3):
            start, edge = edges[shade, k], edges[shade, (k + 1) % 3] - edges[shade, k]
            off = seen[one] - start
            left = edge[:, 0] * off[:, 1] - edge[:, 1] * off[:, 0]
            left /= np.maximum(np.sqrt((edge**2).sum(axis=1)), 1e-200)
            cover *= smooth(0.5 * (1.0 + np.sign(slope[shade]) * left / soft[shade]))
        total: Floats = np.bincount(one, cover, len(points))  # pyright: ignore[reportAssignmentType]  # floats, unlike its stub
        return 1.0 - smooth((total - SHADE_BEGINS) / (SHADE_ENDS - SHADE_BEGINS))

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        """Add the forces on all nodes [N], shape (node, 3); the opening gets the recoil."""
        if not self._thrust(time) > 0.0:
            return
        beam, forces = self._forces(time, position, velocity)
        to[self._jet.opening[0]] -= self._thrust(time) * beam.along
        np.add.at(to, self._corners, forces)

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that the jet puts into all nodes [W]."""
        forces = np.zeros_like(position)
        self.add_forces(time, position, velocity, forces)
        return float((forces * velocity).sum())

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the symmetric part of how forces fall with places [N/m], lit as now."""
        shape, thrust = (3 * size, 3 * size), self._thrust(time)
        if not thrust > 0.0 or not len(self._corners):
            return sparse.coo_matrix(shape)
        beam, corners = self._beam(position), position[self._corners]
        lit, still = self._lit(beam, corners)[:, None], np.zeros_like(corners)
        step = NUDGE * float(np.ptp(corners, axis=(0, 1)).max())
        blocks = np.zeros((len(corners), 9, 9))
        for column in range(9):
            nudge = np.zeros(9)
            nudge[column] = step
            ahead, back = (
                self._shared(self._pressed(thrust, beam, corners + way, still) * lit)
                for way in (nudge.reshape(3, 3), -nudge.reshape(3, 3))
            )
            blocks[:, :, column] = (back - ahead).reshape(-1, 9) / (2.0 * step)
        values = 0.5 * (blocks + blocks.transpose(0, 2, 1))
        return assembled(values.reshape(-1, 3, 3, 3, 3), number[self._corners], size)


def facing(corners: Floats, along: Floats) -> tuple[Floats, Floats, Floats]:
    """Return areas [m²], unit normals and cos θ of triangles, shapes (n,), (n, 3) and (n,)."""
    a, b, c = corners.swapaxes(0, 1)
    twice = cross(a, b) + cross(b, c) + cross(c, a)
    length = np.sqrt((twice**2).sum(axis=1))
    normal = twice / np.maximum(length, 1e-300)[:, None]
    return 0.5 * length, normal, normal @ along


def smooth(part: Floats) -> Floats:
    """Return a cubic step from 0 at 0 to 1 at 1 with zero slopes, dimensionless.

    The shape is that of ``part``.
    """
    part = np.clip(part, 0.0, 1.0)
    return 3.0 * part**2 - 2.0 * part**3


@cache
def points_of(parts: int) -> Floats:
    """Return the quadrature points of a triangle as dimensionless weights of its corners.

    Edges are divided into ``parts``. Each of the n² equal triangles has three points, a sixth
    of the way in from two of its edges; the shape is (3 n², 3).
    """
    found: list[Floats] = []
    for i in range(parts):
        for j in range(parts - i):
            corners = [np.array([[i, j], [i + 1, j], [i, j + 1]], float)]
            if i + j + 1 < parts:
                corners.append(np.array([[i + 1, j + 1], [i, j + 1], [i + 1, j]], float))
            for triangle in corners:
                found += [(triangle.sum(axis=0) + 3.0 * triangle[k]) / 6.0 for k in range(3)]
    first, second = np.array(found).T / parts
    return np.column_stack([1.0 - first - second, first, second])
