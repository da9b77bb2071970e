"""Blocks of single frames in VTK's XML formats, which programs read that know no VTKHDF.

A frame is a file ``.vtm`` that names a file ``.vtu`` for each block; ``.pvd`` names the frames
with their times. (VTK file formats, section XML.)
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from tissuec.results.blocks.anatomy import Anatomy
from tissuec.results.blocks.fields import CloudMoments, Facts, Moment, fields_of
from tissuec.results.blocks.layout import Names, ResultBlock, blocks_of
from tissuec.results.export import surface_shape
from tissuec.results.shapes import ExportedShape, cannot_write, write_vtu, write_xml
from tissuec.results.trajectory import Trajectory


class BlockFrames:
    """The blocks of a result, frame by frame.

    Args:
        trajectory: A result with frames.
        anatomy: Of its scene; None where that is not known.

    Attributes:
        left_out: Sentences about what they do not contain, and why.
    """

    def __init__(self, trajectory: Trajectory, anatomy: Anatomy | None):
        self._trajectory = trajectory
        self._blocks = blocks_of(trajectory, anatomy)
        self._clouds = list({id(block.cloud): block.cloud for block in self._blocks}.values())
        self._facts = Facts(trajectory, anatomy, self._clouds)
        self._moments = CloudMoments(trajectory, self._facts, self._clouds)
        self._fields = fields_of(trajectory)
        self._names = Names([block.name for block in self._blocks])
        self._surfaces = {
            self._names.plain(f"{name} surface"): series
            for name, series in trajectory.surfaces.items()
        }
        self.left_out = () if anatomy is None else anatomy.notes

    def write(self, frame: int, path: Path, ending: str = "") -> None:
        """Write a frame as ``.vtm``, and its blocks in a folder beside it.

        Args:
            frame: Its number.
            path: The file.
            ending: What the names of the files of blocks end with.

        Raises:
            ResultError: A file cannot be written.
        """
        folder = path.with_name(path.stem.removesuffix(ending))
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise cannot_write(folder, error) from error
        moments = dict(zip(map(id, self._clouds), self._moments.at(frame), strict=True))
        names: list[str] = []
        for block in self._blocks:
            shape, texts = self._shape(block, moments[id(block.cloud)], frame)
            write_vtu(shape, folder / f"{block.name}{ending}.vtu", texts)
            names.append(block.name)
        time = self._trajectory.times[frame]
        for name, series in self._surfaces.items():
            found = np.flatnonzero(series.times == time)
            if len(found):
                shape = surface_shape(series, int(found[0]))
                title = {"name": [f"{series.name} surface"]}
                write_vtu(shape, folder / f"{name}{ending}.vtu", title)
                names.append(name)
        files = (f"{folder.name}/{name}{ending}.vtu" for name in names)
        lines = (
            f'<DataSet index="{n}" name={quoteattr(name)} file={quoteattr(file)}/>\n'
            for n, (name, file) in enumerate(zip(names, files, strict=True))
        )
        write_xml(path, "vtkMultiBlockDataSet", "".join(lines))

    def _shape(
        self, block: ResultBlock, moment: Moment, frame: int
    ) -> tuple[ExportedShape, dict[str, Sequence[str]]]:
        """Return a block in a frame, and the texts that belong to it."""
        data: dict[str, dict[str, NDArray[Any]]] = {"points": {}, "cells": {}}
        texts: dict[str, Sequence[str]] = {"name": [block.title]}
        for field in self._fields:
            if block.has(field.at) and field.fits(block.cloud, self._facts):
                values = np.asarray(field.value(moment))
                kind = np.int64 if field.whole else self._trajectory.position.dtype
                at = "points" if field.at == "points" else "cells"
                data[at][field.name] = values.astype(kind)
                if field.names is not None:
                    texts[f"{field.name}_names"] = field.names(self._facts)
        grid = block.pieces[int(block.of_frame[frame])].grid
        points = moment.position.astype(self._trajectory.position.dtype)
        time = float(self._trajectory.times[frame])
        none = np.zeros((0, 3), dtype=np.int64)
        shape = ExportedShape(
            block.title, time, points, grid, none, data["points"], data["cells"]
        )
        return shape, texts


def write_series(files: Iterable[Path], times: Iterable[float], path: Path) -> None:
    """Write which files are the frames of what times, as ``.pvd``.

    Args:
        files: Files in the folder of ``path``.
        times: Their times [s].
        path: The file.

    Raises:
        ResultError: It cannot be written.
    """
    lines = (
        f'<DataSet timestep="{float(time)!r}" group="" part="0" file={quoteattr(file.name)}/>\n'
        for file, time in zip(files, times, strict=True)
    )
    write_xml(path, "Collection", "".join(lines))
