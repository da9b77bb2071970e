"""Fillings of a closed surface: a crystal lattice, or tetrahedra between lattice sites.

Sites of the lattice that lie inside become nodes, but for those nearer to the surface than half
the distance of neighbours. Bonds between them are springs. Where the surface cuts bonds, the
inside is joined to it: each node of the surface to the three nearest inner ones, and each inner
node that lost a bond to the three nearest of the surface. No spring is drawn through the
outside, across a fold or a notch, as far as some places along it show.

A surface may lie on planes of the lattice, and files have few digits: lengths that differ by
rounding only count as equal.
"""

from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.errors import counted
from tissuec.geometry.divisions import regular_triangulation
from tissuec.geometry.edges import Edges, Floats, Indices, volume
from tissuec.geometry.inside import inside
from tissuec.meshes.finer import FinePart, shaken
from tissuec.meshes.finer import sites as graded_sites
from tissuec.meshes.formats import FormatError
from tissuec.meshes.generators.lattice import CRYSTALS, LARGEST, REACH, Lattice

NEAREST = 3  # nodes that each node at the border of inside and surface is joined to
_FARTHEST = 2.0  # cells: no spring joins nodes that are further apart
#: Places along a spring that must lie inside: of one from the surface to an inner node, of a
#: bond between inner nodes, and of an edge between nodes of the surface.
_JOINT, _BOND, _CHORD = (0.05, 0.3, 0.6), (0.5,), (0.05, 0.5, 0.95)
_TOO_EMPTY = 0.05  # part of the volume that tetrahedra may miss before it is reported
_FLAT = 1e-9  # of the cube of its longest edge: a tetrahedron of less volume is left out
_TIE = 1e-5  # of a length: a smaller difference may be rounding, of single precision in files


_NONE = np.zeros((0, 4), dtype=np.int64)


class Filling(NamedTuple):
    """Nodes to be added after those of the surface, and node pairs to be joined.

    Tetrahedra divide the inside; there are none where springs are the bonds of a lattice.
    """

    position: Floats
    pairs: Indices
    tetrahedra: Indices
    remarks: tuple[str, ...]


class Interior(Struct, frozen=True, eq=False):
    """A closed surface that is to be filled.

    Attributes:
        position: Its nodes [m], shape (node, 3).
        triangles: Facing outwards, shape (triangle, 3).
        cell: Edge of the cubic cell [m].
        part: Where tetrahedra are finer; None without such a part.
    """

    position: Floats
    triangles: Indices
    cell: float
    part: FinePart | None = None

    def box(self) -> tuple[Floats, Floats]:
        """Return the lowest and the highest corner of a box of whole cells [m].

        Both have the shape (3,). The box encloses the surface and has the same centre.

        Raises:
            FormatError: The cell is so small that there are too many nodes.
        """
        low, high = self.position.min(axis=0), self.position.max(axis=0)
        with np.errstate(over="ignore"):
            cells = np.maximum(np.ceil((high - low) / self.cell - _TIE), 1.0)
        if np.any(cells > LARGEST):
            raise FormatError("the cell of the filling is too small: it gives too many nodes")
        half = cells * (self.cell / 2.0)
        return (low + high) / 2.0 - half, (low + high) / 2.0 + half

    def lattice(self, kind: str, reach: str) -> Lattice:
        """Return the lattice of the box.

        Args:
            kind: Kind of crystal.
            reach: Which neighbours springs join.
        """
        return Lattice(kind, self.cell, self.box(), reach)

    def with_lattice(self, kind: str, reach: str) -> Filling:
        """Return the sites inside, their bonds, and the springs to the surface."""
        crystal, block = CRYSTALS[kind], self.lattice(kind, reach).build()
        sites, number = self._sites(
            block.position, crystal.shells[0] ** 0.5 / crystal.divisions
        )
        bonds = number[block.ends]
        bonds = bonds[(bonds >= 0).all(axis=1)]
        whole = sum(crystal.neighbours[: REACH.index(reach) + 1])
        degree = np.bincount(bonds.ravel(), minlength=len(sites))
        border = np.flatnonzero(degree < whole)
        bonds = self._within(
            sites, bonds, np.asarray(np.isin(bonds, border).any(axis=1)), _BOND
        )
        points, count = np.concatenate([self.position, sites]), len(self.position)
        joints = self._nearest(sites, border)
        joints = self._within(points, joints, np.ones(len(joints), dtype=bool), _JOINT)
        bare = count - len(np.unique(joints[:, 0]))
        remarks = ()
        if bare:
            remarks = (
                f"{counted(bare, 'node')} of the surface not joined to the inside: the body is "
                "thin compared with the cell there",
            )
        return Filling(sites, np.concatenate([bonds + count, joints]), _NONE, remarks)

    def with_tetrahedra(self) -> Filling:
        """Return body-centred sites and the tetrahedra of them and the surface.

        They are Delaunay's, and match face by face also where those are not unique. Where
        triangles are large beside the curvature or the thickness, tetrahedra cross the
        surface, or leave gaps.
        """
        if self.part is None:
            places = self.lattice("caesium chloride", REACH[0]).build().position
            sites, _ = self._sites(places, 3.0**0.5 / 2.0)
        else:
            low, high = self.box()
            cells = np.rint((high - low) / self.cell).astype(np.int64)
            places, size = graded_sites(low, cells, self.part)
            sites, number = self._sites(places, 3.0**0.5 / 2.0 * size / self.cell)
            sites = shaken(self.position, self.triangles, sites, size[number >= 0])
        points = np.concatenate([self.position, sites])
        cells, edges = self._divided(points, regular_triangulation(points, self.triangles))
        corners = points[cells]
        content = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
        part = float(content.sum()) / volume(self.position, self.triangles)
        remarks = ()
        if abs(part - 1.0) > _TOO_EMPTY:
            remarks = (
                f"tetrahedra take {100 * part:.0f} % of the volume inside: the triangles of "
                "the surface are too coarse for its shape, or the cell is too large",
            )
        return Filling(sites, edges, cells, remarks)

    def _divided(self, points: Floats, cells: Indices) -> tuple[Indices, Indices]:
        """Return tetrahedra of the surface and sites inside, and their edges.

        They know nothing of the surface. Flat ones and those whose centre lies outside are left
        out, and edges that pass through the outside.

        Args:
            points: Of the surface, and after them the sites [m], shape (point, 3).
            cells: All between them, shape (tetrahedron, 4).

        Returns:
            Shapes (tetrahedron, 4) and (edge, 2), of edges the lower node first.
        """
        corners = points[cells]
        content = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
        longest = np.ptp(corners, axis=1).max(axis=1)
        solid = content > _FLAT * longest**3
        solid[solid] = self._holds(corners[solid].mean(axis=1))
        cells = cells[solid]
        edges = np.concatenate([cells[:, [i, j]] for i in range(3) for j in range(i + 1, 4)])
        size, count = len(points), len(self.position)
        keys = np.unique(np.sort(edges, axis=1) @ (size, 1))
        edges = np.stack(np.divmod(keys, size), axis=1)
        drawn = Edges.among(self.triangles).ends @ (size, 1)
        doubtful = (edges < count).all(axis=1) & ~np.isin(keys, drawn)
        return cells, self._within(points, edges, doubtful, _CHORD)

    def _holds(self, points: Floats) -> NDArray[np.bool_]:
        return inside(points, self.position, self.triangles)

    def _sites(self, sites: Floats, neighbour: float | Floats) -> tuple[Floats, Indices]:
        """Return the sites that become nodes, and the number of each site among them, or -1.

        Args:
            sites: All of the box [m], shape (site, 3).
            neighbour: Distance of nearest neighbours in cells, or that of each site, shape
                (site,).
        """
        from scipy.spatial import KDTree

        clear = np.broadcast_to(0.5 * neighbour * self.cell, len(sites))
        found = np.flatnonzero(self._holds(sites))
        clear = clear[found]
        surface = KDTree(self._sampled(float(clear.min(initial=self.cell)) / 2.0))
        most = float(clear.max(initial=0.0))
        far, _ = surface.query(sites[found], distance_upper_bound=most)
        found = found[far >= (1.0 - _TIE) * clear]
        if not len(found):
            raise FormatError(
                "no node of the filling lies inside the surface", "write a smaller cell"
            )
        number = np.full(len(sites), -1)
        number[found] = np.arange(len(found))
        return sites[found], number

    def _sampled(self, spacing: float) -> Floats:
        """Return points all over the surface, no further apart than a spacing.

        Where cells are larger than those of the fine part, the spacing is larger likewise.
        """
        corners = self.position[self.triangles]
        sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
        if self.part is not None:
            sides = sides * self.part.fine / self.part.size_at(corners).min(axis=1)
        parts = np.maximum(np.ceil(sides / spacing), 1.0).astype(np.int64)
        found = [self.position]
        for many in np.unique(parts[parts > 1]):
            number = int(many)
            step = np.arange(number + 1) / number
            u, v = (grid.ravel() for grid in np.meshgrid(step, step, indexing="ij"))
            u, v = u[u + v <= 1.0 + 1e-9], v[u + v <= 1.0 + 1e-9]
            share = np.stack([1.0 - u - v, u, v], axis=1)
            found.append(
                np.einsum("pk,tki->tpi", share, corners[parts == number]).reshape(-1, 3)
            )
        return np.concatenate(found)

    def _within(
        self,
        points: Floats,
        pairs: Indices,
        doubtful: NDArray[np.bool_],
        places: tuple[float, ...],
    ) -> Indices:
        """Return pairs without those doubtful ones that pass through the outside."""
        keep = ~doubtful
        for part in places:
            rest = np.flatnonzero(doubtful)
            first, second = points[pairs[rest]].swapaxes(0, 1)
            held = self._holds((1.0 - part) * first + part * second)
            doubtful = doubtful.copy()
            doubtful[rest[~held]] = False
        return pairs[keep | doubtful]

    def _nearest(self, sites: Floats, border: Indices) -> Indices:
        """Return nodes of the surface and, numbered after them, sites that are near.

        Args:
            sites: Inside [m], shape (site, 3).
            border: Those that lost a bond.
        """
        count = len(self.position)
        reach = _FARTHEST * self.cell
        outer, there = _neighbours(self.position, sites, reach)
        inner, beside = _neighbours(sites[border], self.position, reach)
        ends = np.concatenate([outer, beside]), np.concatenate([there, border[inner]]) + count
        return np.stack(ends, axis=1)


def _neighbours(points: Floats, others: Floats, reach: float) -> tuple[Indices, Indices]:
    """Return points and their three nearest others, both by number, one row for each pair.

    They are fewer where they are far away.

    Args:
        reach: As far as any of them may be [m].
    """
    from scipy.spatial import KDTree

    near = min(NEAREST, len(others))
    far, which = (
        np.reshape(found, (len(points), near))
        for found in KDTree(others).query(points, k=near, distance_upper_bound=reach)
    )
    row, column = np.nonzero(np.isfinite(far))
    return row, which[row, column]
