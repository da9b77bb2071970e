"""Reading files as ParaView does."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

VERTEX, LINE, TRIANGLE, HEXAHEDRON, WEDGE, TETRAHEDRON, BRICK = 1, 3, 5, 12, 13, 24, 29
WIDTHS = {1: 1, 3: 2, 5: 3, 12: 8, 13: 6, 24: 10, 29: 27}


def opened(path: Path) -> Any:
    """Return VTK's own reader of a file, which knows its steps."""
    vtk_hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    reader = vtk_hdf.vtkHDFReader()
    reader.SetFileName(str(path))
    assert reader.CanReadFile(str(path))
    reader.UpdateInformation()
    return reader


def frame(path: Path, number: int) -> Any:
    """Return a frame of a file as a grid of PyVista."""
    pyvista = pytest.importorskip("pyvista")
    reader = opened(path)
    reader.SetStep(number)
    reader.Update()
    return pyvista.wrap(reader.GetOutput())


def cells_of(data: Any, kind: int) -> Any:
    """Return the points of the cells of a type, shape (cell, point)."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if not data.GetNumberOfCells():
        return np.zeros((0, WIDTHS[kind]), dtype=int)
    cells = data.GetCells()
    types = np.array([data.GetCellType(n) for n in range(data.GetNumberOfCells())])
    points = vtk_to_numpy(cells.GetConnectivityArray())
    first = vtk_to_numpy(cells.GetOffsetsArray())[:-1][types == kind]
    return points[first[:, None] + np.arange(WIDTHS[kind])]


def points_of(data: Any) -> Any:
    """Return the positions of the points of a data set [m], shape (point, 3)."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(data.GetPoints().GetData())
