"""Copies of result files."""

import os
import shutil
from collections.abc import Mapping
from pathlib import Path

from tissuec.core.files import replacing
from tissuec.results import PlaceError, ResultError
from tissuec.results.journal import has_journal
from tissuec.results.layout import check_replaceable
from tissuec.results.paraview import check_views, write_views
from tissuec.results.places import check_place
from tissuec.results.surface_table import SurfaceSeries


def copy_result(path: Path, target: Path, surfaces: Mapping[str, SurfaceSeries]) -> Path:
    """Copy a result, write the views of its surfaces, and return where it is.

    Args:
        path: The result.
        target: Where the copy is written.
        surfaces: Its smooth surfaces by the names of bodies.

    Raises:
        PlaceError: It cannot stand there, or something other than a result does.
        ResultError: It is still being written, or the copy cannot be.
    """
    check_place(target)
    check_replaceable(target)
    check_views(target, list(surfaces))
    if target.exists() and os.path.samefile(path, target):
        raise PlaceError(f'"{target}" is this result itself; give another file')
    if has_journal(path):
        raise ResultError(f'"{path}" is still being written, or its run was killed')
    try:
        with replacing(target) as beside:
            shutil.copyfile(path, beside)
    except OSError as error:
        raise ResultError(f'cannot write "{target}": {error.strerror or error}') from error
    write_views(target, {name: series.path for name, series in surfaces.items()})
    return target
