"""Reading files as ParaView does."""

from pathlib import Path
from typing import Any

import pytest


def opened(path: Path) -> Any:
    """Return VTK's own reader of a file, which knows its steps."""
    vtk_hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    reader = vtk_hdf.vtkHDFReader()
    reader.SetFileName(str(path))
    assert reader.CanReadFile(str(path))
    reader.UpdateInformation()
    return reader
