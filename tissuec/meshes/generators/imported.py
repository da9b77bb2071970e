"""A mesh from a file, such as an organ out of a segmentation or a finite element model."""

from collections.abc import Mapping
from functools import cached_property
from hashlib import sha256
from typing import TYPE_CHECKING, Annotated

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.errors import counted
from tissuec.core.fields import InFile, LengthIfAny, Named, OneOf, PointsIfAny, Real
from tissuec.core.files import read_bytes
from tissuec.core.structs import replace
from tissuec.geometry.edges import Edges, Floats, Indices
from tissuec.meshes.formats import FormatError, read, way_of_folder
from tissuec.meshes.generators import MESHES, FileOrigin, Mesh
from tissuec.meshes.generators.joining import require_fine_part, require_limits, springs
from tissuec.meshes.generators.lattice import CRYSTALS, REACH
from tissuec.meshes.images import is_image
from tissuec.meshes.stiffness_sharing import (
    area_shares,
    filled_volumes,
    node_volumes,
    volume_shares,
)

if TYPE_CHECKING:  # scenes without a file need neither repair nor fillings
    from tissuec.meshes.filling import Filling, Interior
    from tissuec.meshes.finer import FinePart
    from tissuec.meshes.images import LabelImage
    from tissuec.meshes.repair import RepairedMesh

TETRAHEDRA = "tetrahedra"
CUBES = "cubes"
ON, OFF = "on", "off"
EVEN, AREA, VOLUME = "even", "area rule", "volume rule"
LARGEST_FILE = 2 << 30  # bytes; beyond, reading takes more memory than nets can


class MeshFileError(ValueError):
    """A mesh file cannot be used.

    Attributes:
        hint: What to do about it.
        unit: Unit of length that the file itself states, where another one is given.
    """

    def __init__(self, message: str, hint: str = "", *, unit: str = ""):
        self.hint = hint
        self.unit = unit
        super().__init__(message)


@MESHES.member("imported")
class Imported(Struct, frozen=True, eq=False, dict=True):
    """A surface or a solid from a file, repaired if possible.

    Springs run along the edges of triangles, quadrilaterals and volume cells. A face with four
    corners also gets its shorter diagonal, so that it resists shear; a face of a volume cell
    gets both, so that a grid of cubes is isotropic. The skin is the surface; for volume cells,
    all faces that belong to one cell only.

    A closed surface can be filled with a lattice, whose reach is that of a lattice mesh, or
    with tetrahedra. The lattice is centred on the body; its nodes follow those of the file.

    In a body of elements, tetrahedra can be finer in a part: within the fine box, they are as
    small as the fine cell. Away from it, their size grows by 0.4 of the distance until it is
    that of the cell. Edges of the surface there are divided at their middles.

    A label image becomes a closed surface, or, filled with cubes, a lattice of those whose
    centre has a label.

    Attributes:
        file: A file beside the scene or in a library, and the unit of its coordinates.
        part: Named part of the file that is the body; by default, the whole file.
        filling: What fills a closed surface: none, a crystal lattice, or tetrahedra; of label
            images also cubes, which need no surface.
        cell: Edge of the cubic cell of the filling.
        reach: Reach of the springs of a filling lattice.
        resolution: Distance of neighbouring nodes in the surface of a label image, not below
            the size of a voxel; by default, the cell of the filling, or else the size of a
            voxel.
        stiffness: Distribution of the stiffness of the tissue over springs: even (the same for
            each spring), by the area rule (for surfaces), or by the volume rule (for
            tetrahedra).
        merging: Whether coincident nodes are merged. If it is off, parts in contact stay apart.
        merging_distance: Nodes that are no further apart are merged; by default, a millionth of
            the diagonal of the mesh. 0 is the same as merging that is off.
        fine_cell: Size of the cell in the fine box, for elements in a filling with tetrahedra.
        fine_box: Two opposite corners of the part with finer cells.
    """

    file: InFile
    part: Annotated[str | None, Named("left lobe")] = None
    filling: Annotated[str, OneOf(("none", *CRYSTALS, TETRAHEDRA, CUBES))] = "none"
    cell: Annotated[float | None, Real(units.LENGTH, above=0.0)] = None
    reach: Annotated[str, OneOf(REACH)] = "nearest neighbours"
    resolution: Annotated[float | None, Real(units.LENGTH, above=0.0)] = None
    stiffness: Annotated[str, OneOf((EVEN, AREA, VOLUME))] = EVEN
    merging: Annotated[str, OneOf((ON, OFF))] = ON
    merging_distance: Annotated[float | None, Real(units.LENGTH, at_least=0.0)] = None
    fine_cell: LengthIfAny = None
    fine_box: PointsIfAny = None

    def __post_init__(self) -> None:
        require_limits(self)
        require_fine_part(self.fine_cell, self.fine_box, self.cell)
        if self.fine_cell is not None and self.filling != TETRAHEDRA:
            raise ValueError('"fine cell" is for a filling with tetrahedra')
        if self.filling != "none" and self.cell is None:
            raise ValueError(f'"filling" is {self.filling}, so it needs the size of a "cell"')
        if self.filling == "none" and self.cell is not None:
            such = ", such as cubes" if is_image(self.file.path) else ""
            raise ValueError(f'"cell" is the size of a filling, but there is no filling{such}')
        if self.reach != "nearest neighbours" and self.filling not in CRYSTALS:
            raise ValueError('"reach" belongs to a filling lattice, but there is none')
        if self.merging == OFF and self.merging_distance:
            raise ValueError('"merging distance" is given, but merging is off')
        self._require_image()

    def _require_image(self) -> None:
        """Refuse entries that belong to images where there is none, and the other way round."""
        if not is_image(self.file.path):
            if self.filling == CUBES:
                raise ValueError("cubes are made of label images (.nrrd, .nii) only")
            if self.resolution is not None:
                raise ValueError('"resolution" belongs to label images (.nrrd, .nii)')
            return
        if self.filling == CUBES and self.resolution is not None:
            raise ValueError('"resolution" is for surfaces; cubes do not need it')
        if self.merging == OFF or self.merging_distance is not None:
            raise ValueError("an image has no nodes that could be merged")

    @cached_property
    def _bytes(self) -> bytes:
        try:
            return read_bytes(self.file.path, LARGEST_FILE)
        except IsADirectoryError as error:
            raise self._error(
                FormatError("this is a folder", way_of_folder(self.file.path))
            ) from error
        except OSError as error:
            reason = (error.strerror or type(error).__name__).lower()
            raise self._error(FormatError(f"the file cannot be read: {reason}")) from error

    @cached_property
    def shape(self) -> "RepairedMesh":
        """Return the repaired contents of the file; raises MeshFileError."""
        from tissuec.meshes.repair import repair

        try:
            if is_image(self.file.path):
                return self._shape_of_image()
            raw = read(self._bytes, self.file.path)
            with np.errstate(over="ignore"):  # numbers out of range merge into one node
                close = 0.0 if self.merging == OFF else self.merging_distance
                return repair(raw, self.file.factor, close=close, part=self.part)
        except FormatError as error:
            raise self._error(error) from error

    @cached_property
    def image(self) -> "LabelImage":
        """Return the label image in the file; raises MeshFileError."""
        from tissuec.meshes.images.reading import read

        try:
            return read(self._bytes, self.file.path, self.file.factor)
        except FormatError as error:
            raise self._error(error) from error

    def _shape_of_image(self) -> "RepairedMesh":
        """Return the cubes of an image, or the surface; raises FormatError."""
        from tissuec.meshes.images.meshing import cubes, surface
        from tissuec.meshes.repair import repair

        values = self.image.values_of(self.part)
        if self.filling == CUBES:
            assert self.cell is not None
            raw = cubes(self.image, values, self.cell)
        else:
            if self.resolution is not None:
                self.image.require_resolution(self.resolution)
            resolution = self.cell if self.resolution is None else self.resolution
            raw = surface(self.image, values, resolution)
        shape = repair(raw, 1.0)
        return replace(shape, parts=tuple(self.image.names.values()))

    def _error(self, error: FormatError) -> MeshFileError:
        return MeshFileError(f'"{self.file.name}": {error}', error.hint, unit=error.unit)

    def size(self) -> tuple[int, int]:
        """Return the numbers of nodes and springs; with a filling, as if it filled the box."""
        if self.filling == CUBES:
            from tissuec.meshes.images.meshing import size

            assert self.cell is not None
            try:
                return size(self.image, self.image.values_of(self.part), self.cell)
            except FormatError as error:
                raise self._error(error) from error
        shape = self.shape
        nodes, pairs = len(shape.position), len(shape.pairs)
        if self.filling == "none":
            return nodes, pairs
        try:
            kind = self.filling if self.filling in CRYSTALS else "caesium chloride"
            inner, bonds = self._interior().lattice(kind, self.reach).size()
        except FormatError as error:
            raise self._error(error) from error
        if (part := self._part) is not None:
            from tissuec.meshes.finer import sites

            low, high = self._interior().box()
            cells = np.rint((high - low) / part.cell).astype(np.int64)
            inner = len(sites(low, cells, part)[0])
            nodes = len(self._fine_shape.position)
        # Twice as many tetrahedra as a lattice of body-centred cells has, to be safe.
        return nodes + inner, pairs + bonds + 16 * (nodes + inner)

    def build(self) -> Mesh:
        """Return nodes, springs, skin, groups, and remarks on the file.

        Raises:
            MeshFileError: The file cannot be used.
            ValueError: There are finer cells, which springs cannot have.
        """
        if self.fine_cell is not None:
            raise ValueError('"fine cell" is for bodies made of elements')
        shape = self.shape
        try:
            filling = self._filled()
            position = np.concatenate([shape.position, filling.position])
            ends = springs(len(position), shape.pairs, filling.pairs)
            shares = self._shares(position, ends, filling)
        except FormatError as error:
            raise self._error(error) from error
        return Mesh(
            position,
            ends,
            shape.skin.astype(np.int32),
            groups=self._groups(filling),
            shares=shares,
            shared_by_area=self.stiffness == AREA,
            origin=FileOrigin(self.file, self._digest),
            remarks=(*shape.remarks, *filling.remarks),
            volume=self._volume(position, filling),
            tetrahedra=self._tetrahedra(filling),
        )

    @property
    def is_solid(self) -> bool:
        """Return whether it has a filling or volume cells; False if it cannot be read."""
        try:
            return self.filling != "none" or self.shape.is_volume
        except MeshFileError:
            return False

    def element_size(self) -> tuple[int, int]:
        """Return upper bounds of the numbers of nodes and of edges of elements."""
        nodes, pairs = self.size()
        return nodes + pairs, 8 * pairs  # of tetrahedra with a node on each edge

    def build_elements(self) -> Mesh:
        """Return the mesh with elements; its node pairs are their edges."""
        from tissuec.meshes.elements import mesh_of_cells

        try:
            shape = self._fine_shape
            filling = self._filled()
            position = np.concatenate([shape.position, filling.position])
            if len(filling.tetrahedra):
                from tissuec.meshes.slivers import without_slivers

                count = len(shape.position)
                position, cells = without_slivers(position, filling.tetrahedra, count)
                filling = filling._replace(position=position[count:], tetrahedra=cells)
            bricks, tetrahedra = self._cells(filling)
            groups = self._groups(filling)
            mesh = mesh_of_cells(
                position, bricks, tetrahedra, groups, self._tetrahedra(filling), shape.between
            )
            shapes = [cells for cells in (*bricks.values(), tetrahedra) if len(cells)]
            members = [shape.part_cells.members(cells, groups) for cells in shapes]
        except FormatError as error:
            raise self._error(error) from error
        return replace(
            mesh,
            origin=FileOrigin(self.file, self._digest),
            remarks=(*shape.remarks, *filling.remarks, *mesh.remarks),
            element_groups={
                name: np.concatenate([each[name] for each in members])
                for name in shape.part_cells.parts
                if shape.is_volume
            },
        )

    def divided_cells(self) -> tuple[Mapping[str, int], int]:
        """Return how many elements of each shape its volume cells become, and how many divide.

        Raises:
            MeshFileError: The file cannot be used.
        """
        if not self.shape.is_volume:
            return {}, 0
        bricks, tetrahedra = self._cells(self._filled())
        found = {name: len(cells) for name, cells in bricks.items()}
        kept = sum(found.values()) + len(self.shape.cells.get("tetra", ()))
        divided = sum(map(len, self.shape.cells.values())) - kept
        return {**found, "tetrahedron": len(tetrahedra)}, divided

    def _cells(self, filling: "Filling") -> tuple[Mapping[str, Indices], Indices]:
        """Return cells that stay what they are, by shape, and the tetrahedra of all others.

        Faces of tetrahedra have nodes in the middle of edges, and those of other cells do not.
        So where both meet, all cells are divided into tetrahedra; FormatError of a surface.
        """
        from tissuec.meshes.elements import BRICKS, are_folded

        tetrahedra = self._tetrahedra(filling)
        if tetrahedra is None:
            raise FormatError(
                "it is a surface, which does not say what its inside consists of",
                "divide the inside into elements, for example: filling is tetrahedra; "
                "cell = 2 mm",
            )
        bricks = {name: c for name, c in self.shape.cells.items() if name in BRICKS}
        corners = np.unique(
            np.concatenate([tetrahedra[:0].ravel(), *map(np.ravel, bricks.values())])
        )
        others = [c.ravel() for name, c in self.shape.cells.items() if name not in BRICKS]
        if are_folded(bricks) or any(np.isin(nodes, corners).any() for nodes in others):
            return {}, tetrahedra
        return bricks, tetrahedra[~np.isin(tetrahedra, corners).any(axis=1)]

    @property
    def _digest(self) -> str:
        if is_image(self.file.path):
            return self.image.digest
        return sha256(self._bytes).hexdigest()

    def _groups(self, filling: "Filling") -> Mapping[str, Indices]:
        """Return the nodes of each group; of images with those of a filling."""
        if not (is_image(self.file.path) and len(filling.position)):
            return self._fine_shape.groups
        from tissuec.meshes.images.meshing import with_inner_nodes

        return with_inner_nodes(self.image, self._fine_shape, filling.position)

    @property
    def _part(self) -> "FinePart | None":
        """Return where cells are finer; None without such a part."""
        if self.fine_cell is None or self.fine_box is None or self.cell is None:
            return None
        from tissuec.meshes.finer import FinePart

        one, other = (np.asarray(corner, dtype=np.float64) for corner in self.fine_box)
        low, high = np.minimum(one, other), np.maximum(one, other)
        return FinePart(low, high, self.fine_cell, self.cell)

    @cached_property
    def _fine_shape(self) -> "RepairedMesh":
        """Return the contents of the file with a finer surface in the fine part."""
        if (part := self._part) is None:
            return self.shape
        from tissuec.meshes.finer import GroupedSurface, divided

        shape = self.shape
        found = divided(
            GroupedSurface(shape.position, shape.skin.astype(np.int64), shape.groups), part
        )
        position, skin, groups = found
        return replace(shape, position=position, skin=skin, groups=groups)

    def _interior(self) -> "Interior":
        """Return the closed surface; raises FormatError if there is none."""
        from tissuec.meshes.filling import Interior

        shape = self._fine_shape
        assert self.cell is not None
        if shape.is_volume:
            raise FormatError("it contains volume cells, which cannot be filled")
        edges = Edges.among(shape.skin)
        if not edges.is_closed:
            raise self._open(edges)
        return Interior(shape.position, shape.skin, self.cell, self._part)

    def _open(self, edges: Edges) -> FormatError:
        """Return why a surface cannot be filled, and where the first defect is."""
        from tissuec.meshes.repair import place

        position = self.shape.position
        free, many = (int(n) for n in ((edges.count == 1).sum(), (edges.count > 2).sum()))
        message = "the surface is not closed and cannot be filled: "
        if free:
            hole = edges.holes()[0]
            message += f"{counted(free, 'edge')} of one triangle, at a hole around "
            message += f"{place(position[hole].mean(axis=0))}"
            return FormatError(
                message + (f"; {many} of more than two" if many else ""),
                "close its holes in the program that made it, or write a larger merging "
                "distance",
            )
        ends = position[edges.ends[edges.count > 2][0]]
        message += f"{counted(many, 'edge')} of more than two triangles, the first of them "
        message += f"between {place(ends[0])} and {place(ends[1])}"
        parts = self.shape.parts
        alone = f'; or import each part alone: part "{parts[0]}"' if parts else ""
        hint = "where closed parts touch, keep their nodes apart: merging is off"
        return FormatError(message, hint + alone)

    def _filled(self) -> "Filling":
        from tissuec.meshes.filling import Filling

        if self.filling in ("none", CUBES):
            none = np.zeros((0, 3))
            return Filling(none, none[:, :2].astype(int), np.zeros((0, 4), int), ())
        if self.filling == TETRAHEDRA:
            return self._interior().with_tetrahedra()
        return self._interior().with_lattice(self.filling, self.reach)

    def _tetrahedra(self, filling: "Filling") -> Indices | None:
        """Return the tetrahedra that divide a solid; None of surfaces."""
        cells = self.shape.tetrahedra if self.shape.is_volume else filling.tetrahedra
        return cells if len(cells) else None

    def _volume(self, position: Floats, filling: "Filling") -> Floats | None:
        """Return the volumes of the nodes of a solid [m³]; NaN where unknown."""
        shape = self.shape
        if not (shape.is_volume or len(filling.pairs)):
            return None
        if shape.is_volume:
            return node_volumes(position, shape.tetrahedra)
        if not len(filling.tetrahedra):
            return np.full(len(position), np.nan)
        return filled_volumes(position, shape.skin, filling.tetrahedra)

    def _shares(
        self, position: Floats, ends: NDArray[np.int32], filling: "Filling"
    ) -> Floats | None:
        shape = self.shape
        if self.stiffness == EVEN:
            return None
        if self.stiffness == AREA:
            if shape.is_volume:
                raise FormatError(
                    "the area rule is for surfaces, but the file contains volume cells",
                    "for tetrahedra write: stiffness is volume rule",
                )
            return area_shares(position, shape.skin, ends)
        tetrahedra = self._tetrahedra(filling)
        if self.filling in CRYSTALS or tetrahedra is None or shape.divided:
            others = f"it contains {counted(shape.divided, 'other cell')}"
            holds = others if shape.divided else "there are none"
            raise FormatError(
                f"the volume rule is for tetrahedra, but {holds}",
                "fill a closed surface with tetrahedra, or write: stiffness is area rule",
            )
        return volume_shares(position, tetrahedra, ends)
