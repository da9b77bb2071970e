"""All blocks of a result with all frames in one VTKHDF file.

The type is MultiBlockDataSet, which PyVista opens, too, and of which VTK 9.4 shows the names of
blocks: for each block a grid with steps of its own, and links to them in
``Assembly``. Points that follow one another in the frames of the
result are not written again: a dataset of the result is shown by a link into it, or a copy that
all blocks share, and ``PointOffsets`` says where those of the block begin.
(VTK file formats, section VTKHDF, version 2.2.)

VTK 9.4 and 9.5 read nothing from lists of points whose numbers have another type than their
offsets, nor from groups with blanks in their names, and show texts only if they are ASCII of
variable length.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray

from tissuec.core.files import replacing
from tissuec.core.signals import give_way
from tissuec.model.network import Indices
from tissuec.results import ResultError, access
from tissuec.results.blocks.anatomy import Anatomy
from tissuec.results.blocks.fields import BlockField, CloudMoments, Facts, Moment, fields_of
from tissuec.results.blocks.layout import Cloud, Names, Piece, ResultBlock, blocks_of
from tissuec.results.blocks.poses import write_poses
from tissuec.results.grid_frames import GRID, write_type
from tissuec.results.hdf5 import (
    copy_to,
    external_link,
    open_file,
    ordered_group,
    set_attribute,
    soft_link,
)
from tissuec.results.layout import BLOCKS
from tissuec.results.mesh import CellGrid
from tissuec.results.schema import CELL_TABLE, FRAMES, ROOT
from tissuec.results.shapes import cannot_write
from tissuec.results.store import LIBVER, describe
from tissuec.results.surface_table import SurfaceSeries
from tissuec.results.trajectory import Trajectory

_COPIES = "/tissuec"
_TEXT = h5py.string_dtype("ascii")
_MOST_WAITING = 1 << 20  # [byte] of a column
_POSITION = BlockField(
    "Points",
    "m",
    3,
    "points",
    (),
    "position",
    lambda m: m.position,
    source=FRAMES["Points"].path,
)


def write_blocks(
    trajectory: Trajectory, anatomy: Anatomy | None, path: Path, *, links: bool
) -> "WrittenBlocks":
    """Write the blocks of a result.

    Args:
        trajectory: The result.
        anatomy: Of its scene; None where that is not known: then there are no tissues, strains,
            stresses, and no tools without a shape.
        path: The file.
        links: Whether what the result contains already is linked instead of copied; the file
            then has to stay in the folder of the result.

    Raises:
        ResultError: The result has no frames, or the file cannot be written.
    """
    if not len(trajectory.times) or not len(trajectory.nodes):
        raise ResultError(
            f'"{trajectory.path}" has no frames to make blocks of; write in the scene: output '
            "{ trajectory every 10 ms }"
        )
    notes = list(anatomy.notes if anatomy is not None else ())
    try:
        with replacing(path) as beside, open_file(beside, "w", libver=LIBVER) as file:
            text = trajectory.path.name.encode()
            set_attribute(file, BLOCKS, text, h5py.string_dtype("utf-8", len(text)))
            names = _BlocksWriter(file, trajectory, anatomy, links=links).write(notes)
    except OSError as error:
        raise cannot_write(path, error) from error
    return WrittenBlocks(names, tuple(notes))


class WrittenBlocks(NamedTuple):
    """What a blocks file contains.

    Attributes:
        names: Of the blocks.
        left_out: Sentences about what it does not contain, and why.
    """

    names: tuple[str, ...]
    left_out: tuple[str, ...]


class _Planned(NamedTuple):
    """A field of an owner that is computed.

    Attributes:
        name: Of its dataset.
        first: Where its rows begin there.
        field: What they are.
        variants: Which variant each frame shows; it has rows of its own, shape (frame,).
        cloud: Number of the cloud whose moments they are computed from.
    """

    name: str
    first: int
    field: BlockField
    variants: Indices
    cloud: int


class _FieldRows:
    """Rows of a dataset, which several blocks have, that come one frame after the other."""

    def __init__(self, dataset: Any, planned: _Planned):
        self.planned, self._dataset = planned, dataset
        self._rows, self._size = planned.first, 0
        self._waiting: list[NDArray[Any]] = []

    def add(self, moment: Moment) -> None:
        """Add the rows of a frame."""
        values = np.asarray(self.planned.field.value(moment)).astype(self._dataset.dtype)
        self._waiting.append(values)
        self._size += values.nbytes
        if self._size > _MOST_WAITING:
            self.flush()

    def flush(self) -> None:
        """Hand all rows to HDF5."""
        if self._waiting:
            rows = np.concatenate(self._waiting)
            self._dataset[self._rows : self._rows + len(rows)] = rows
            self._rows += len(rows)
            self._size = 0
            self._waiting.clear()


class _BlocksWriter:
    """Writes the blocks of one result into an empty file."""

    def __init__(
        self, file: h5py.File, trajectory: Trajectory, anatomy: Anatomy | None, *, links: bool
    ):
        self.file, self.trajectory, self.links = file, trajectory, links
        self.blocks = blocks_of(trajectory, anatomy)
        self.clouds = list({id(block.cloud): block.cloud for block in self.blocks}.values())
        self.facts = Facts(trajectory, anatomy, self.clouds)
        self.fields = fields_of(trajectory)
        self.frames = len(trajectory.times)
        self._starts: dict[tuple[int, str], Indices] = {}  # of each frame, by owner and field
        self._planned: list[_Planned] = []
        self._copied: set[str] = set()
        self._times: Any = None

    def write(self, notes: list[str]) -> tuple[str, ...]:
        """Write everything, and return the names of the blocks."""
        root = ordered_group(self.file, "VTKHDF")
        write_type(root, "MultiBlockDataSet")
        assembly = ordered_group(root, "Assembly")
        self._steps(root.create_group("Steps"))
        self._plan()
        written = [block.name for block in self.blocks]
        for index, block in enumerate(self.blocks):
            self._block(ordered_group(root, block.name), block, index)
        names, times = Names(written), self.trajectory.times
        for name, series in self.trajectory.surfaces.items():
            frames = np.minimum(np.searchsorted(series.times, times), max(0, len(series) - 1))
            if not len(series) or not np.array_equal(series.times[frames], times):
                notes.append(
                    f"the surface of {name} is left out: it is not recorded at the times of "
                    "the trajectory"
                )
                continue
            title = f"{name} surface"
            plain = names.plain(title)
            self._surface(ordered_group(root, plain), series, title, frames, len(written))
            written.append(plain)
        meshes = [cloud.mesh for cloud in self.clouds if cloud.mesh is not None]
        write_poses(self.file, meshes, self.trajectory.times)
        for name in written:
            assembly[name] = soft_link(f"{ROOT}/{name}")
        self._fill()
        return tuple(written)

    def _steps(self, group: h5py.Group) -> None:
        """Write the steps of the whole file, which is a grid without points at once.

        Without steps at the root, VTK 9.7 takes the first frame for data without time, and
        reads it from the first row on; VTK 9.4 takes every group at the root for a data set.
        """
        set_attribute(group, "NSteps", self.frames, "i8")
        none = np.zeros((0, 3))
        values = _whole(group, "Values", self.trajectory.times, "time of each frame", "s")
        self._times = values
        nothing = Piece(0, CellGrid.of_triangles(none.astype(int)), none[:, 0].astype(int), 0)
        always = np.zeros(self.frames, dtype=np.int64)
        nowhere = Cloud("", "grip", -1, (), always)
        empty = ResultBlock("", "", nowhere, "Vertices", (nothing,), always)
        write_type(group, GRID)
        _whole(group, "Points", none, "no points", "m")
        steps = group.create_group("Steps")
        set_attribute(steps, "NSteps", self.frames, "i8")
        steps["Values"] = values
        for name in ("PartOffsets", "PointOffsets"):
            _whole(steps, name, always, f"{name} of each frame")
        _whole(steps, "NumberOfParts", always + 1, "parts of each frame")
        self._cells(group, steps, empty)
        for name in ("PointData", "CellData", "FieldData"):
            group.create_group(name)

    # --- one block ----------------------------------------------------------------------------

    def _block(self, group: h5py.Group, block: ResultBlock, index: int) -> None:
        steps = self._head(group, index)
        cloud = block.cloud
        self._cells(group, steps, block)
        _whole(steps, "PartOffsets", block.of_frame, "part of each frame")
        points = group.create_group("PointData"), steps.create_group("PointDataOffsets")
        cells = group.create_group("CellData"), steps.create_group("CellDataOffsets")
        starts = self._field(group, cloud, _POSITION)
        _whole(steps, "PointOffsets", starts, "first point of each frame")
        names: dict[str, Sequence[str]] = {"name": [block.title]}
        for field in self.fields:
            if not field.fits(cloud, self.facts) or not block.has(field.at):
                continue
            at_points = field.at == "points"
            data, offsets = points if at_points else cells
            starts = self._field(data, cloud if at_points else block, field)
            _whole(offsets, field.name, starts, f"first row of {field.name}")
            if field.names is not None:
                names[f"{field.name}_names"] = field.names(self.facts)
        self._names(group, steps, names)

    def _head(self, group: h5py.Group, index: int) -> h5py.Group:
        write_type(group, GRID)
        set_attribute(group, "Index", index, "i8")
        steps = group.create_group("Steps")
        set_attribute(steps, "NSteps", self.frames, "i8")
        if self._times is None:
            self._times = _whole(
                steps, "Values", self.trajectory.times, "time of each frame", "s"
            )
        else:
            steps["Values"] = self._times
        ones = np.ones(self.frames, dtype=np.int64)
        _whole(steps, "NumberOfParts", ones, "parts of each frame")
        return steps

    def _cells(self, group: h5py.Group, steps: h5py.Group, block: ResultBlock) -> None:
        """Write what is drawn, and where that of each frame begins."""
        grids = [piece.grid for piece in block.pieces]
        lengths, sizes = ([len(one.types) for one in grids], [len(one.points) for one in grids])
        for name, numbers in (("CellOffsets", lengths), ("ConnectivityIdOffsets", sizes)):
            starts = _starts(np.array(numbers))[block.of_frame]
            _whole(steps, name, starts, f"{name} of each frame")
        tables = [piece.grid.table(piece.points) for piece in block.pieces]
        for name in CELL_TABLE:
            # VTK 9.4 and 9.5 need one type of integers.
            kind = np.uint8 if name == "Types" else np.int64
            data = np.concatenate([table[name] for table in tables]).astype(kind)
            _whole(group, name, data, f"{name} of each part")

    def _names(
        self, group: h5py.Group, steps: h5py.Group, names: Mapping[str, Sequence[str]]
    ) -> None:
        """Write texts, with what readers need to find them in each frame."""
        data, first, size = (
            group.create_group("FieldData"),
            steps.create_group("FieldDataOffsets"),
            steps.create_group("FieldDataSizes"),
        )
        for name, texts in names.items():
            found = np.array([text.encode() for text in texts], dtype=object)
            describe(data.create_dataset(name, data=found, dtype=_TEXT), "", "names")
            _whole(first, name, np.zeros(self.frames, dtype=np.int64), "first text")
            sizes = np.tile(np.array([1, len(texts)]), (self.frames, 1))
            _whole(size, name, sizes, "components and number of texts")

    # --- numbers ------------------------------------------------------------------------------

    def _plan(self) -> None:
        """Make room for all fields that are computed: one dataset each, whatever has it.

        VTK 9.5 and 9.6 may take rows of a name that begin at the same place for the same rows,
        although they are of another block. In one dataset, they begin at different places.
        """
        owners: list[tuple[Cloud | ResultBlock, Cloud, str]] = [
            *((cloud, cloud, "points") for cloud in self.clouds),
            *(
                (block, block.cloud, at)
                for at in ("lines", "triangles", "elements")
                for block in self.blocks
                if block.has(at)
            ),
        ]
        wanted: dict[str, list[tuple[BlockField, Cloud | ResultBlock, Cloud]]] = {}
        for owner, cloud, at in owners:
            for field in (_POSITION, *self.fields):
                fits = field is _POSITION or field.fits(cloud, self.facts)
                if field.at == at and fits and self._shown(owner, field) is None:
                    wanted.setdefault(f"{at}/{field.name}", []).append((field, owner, cloud))
        for name, of_field in wanted.items():
            first = 0
            for field, owner, cloud in of_field:
                rows = _rows(owner)
                each = rows[owner.of_frame] if field.changes else rows
                variants = np.arange(self.frames) if field.changes else owner.of_frame
                self._starts[id(owner), name] = (_starts(each) + first * (each > 0))[variants]
                self._planned.append(
                    _Planned(name, first, field, variants, self.clouds.index(cloud))
                )
                first += int(each.sum())
            field = of_field[0][0]
            folder = self.file.require_group(f"{_COPIES}/{field.at}")
            kind = "i8" if field.whole else self.trajectory.position.dtype
            shape = (first, field.width) if field.width > 1 else (first,)
            dataset = folder.create_dataset(field.name, shape=shape, dtype=kind)
            describe(dataset, field.unit, field.text)

    def _field(
        self, group: h5py.Group, owner: Cloud | ResultBlock, field: BlockField
    ) -> Indices:
        """Add a field to a block, and return where its rows begin in each frame."""
        shown = self._shown(owner, field)
        if shown is not None:
            path, starts = shown
            self._share(group, field.name, path)
            return starts
        name = f"{field.at}/{field.name}"
        group[field.name] = self.file[f"{_COPIES}/{name}"]
        return self._starts[id(owner), name]

    def _shown(
        self, owner: Cloud | ResultBlock, field: BlockField
    ) -> tuple[str, Indices] | None:
        """Return the dataset of the result that has a field, and where its frames begin there.

        None if there is none, or the rows do not follow one another. Of a single frame, VTK
        reads all rows from the first one on.
        """
        if not field.source or self.frames < 2:
            return None
        path = field.source
        if isinstance(owner, ResultBlock):
            steps = f"{ROOT}/Steps/CellDataOffsets/{field.name}"
            starts = access.array(self.trajectory.content, steps)[: self.frames]
            first = np.array([piece.first for piece in owner.pieces])
            return path, starts + first[owner.of_frame]
        if owner.kind == "tool" or len(owner.nodes) != 1 or not len(owner.nodes[0]):
            return None
        nodes, begin = owner.nodes[0], int(owner.nodes[0][0])
        shown = self.trajectory.nodes
        row = int(np.searchsorted(shown, begin))
        if not np.array_equal(shown[row : row + len(nodes)], nodes):
            return None
        starts = access.array(self.trajectory.content, f"{ROOT}/Steps/PointOffsets")
        return path, starts[: self.frames] + row

    def _share(self, group: h5py.Group, name: str, path: str) -> None:
        """Add a dataset or group of the result under another name."""
        if self.links:
            group[name] = external_link(self.trajectory.path.name, path)
            return
        copy = f"{_COPIES}{path}"
        if path not in self._copied:
            self._copied.add(path)
            folder, _, last = copy.rpartition("/")
            content = self.trajectory.content
            with access.reading(content.file, path):
                copy_to(content.raw, path, self.file.require_group(folder), last)
        group[name] = self.file[copy]

    def _fill(self) -> None:
        """Compute the fields of all frames."""
        columns = [_FieldRows(self.file[f"{_COPIES}/{one.name}"], one) for one in self._planned]
        moments = CloudMoments(self.trajectory, self.facts, self.clouds)
        for frame in range(self.frames):
            give_way()
            found = list(moments.at(frame))
            for column in columns:
                shown = column.planned.variants
                if not frame or shown[frame] != shown[frame - 1]:
                    column.add(found[column.planned.cloud])
        for column in columns:
            column.flush()

    # --- surfaces -----------------------------------------------------------------------------

    def _surface(
        self, group: h5py.Group, series: SurfaceSeries, title: str, frames: Indices, index: int
    ) -> None:
        """Add a smooth surface, whose datasets are those of the result."""
        steps = self._head(group, index)
        for name in ("Points", *CELL_TABLE):
            self._share(group, name, f"{series.path}/{name}")
        for name in ("PartOffsets", "PointOffsets", "CellOffsets", "ConnectivityIdOffsets"):
            rows = access.array(self.trajectory.content, f"{series.path}/Steps/{name}")
            _whole(steps, name, rows[frames], f"{name} of each frame")
        for name in ("PointData", "CellData"):
            group.create_group(name)
            steps.create_group(f"{name}Offsets")
        self._names(group, steps, {"name": [title]})


def _starts(counts: Indices) -> Indices:
    """Return where rows begin that follow one another.

    Of no rows this is 0, as VTK 9.4 reads none from behind the last row.
    """
    return (np.cumsum(counts) - counts) * (counts > 0)


def _rows(owner: Cloud | ResultBlock) -> Indices:
    """Return how many points, or lines, each variant of a cloud, or piece of a block, has."""
    if isinstance(owner, ResultBlock):
        return np.array([len(piece.grid) for piece in owner.pieces])
    return np.array([len(nodes) for nodes in owner.nodes])


def _whole(group: h5py.Group, name: str, data: NDArray[Any], text: str, unit: str = "") -> Any:
    """Add a dataset that is known as a whole, and return it."""
    dataset = group.create_dataset(name, data=data)
    describe(dataset, unit, text)
    return dataset
