"""Files with the smooth surfaces of a result for ParaView, and copies of results with them.

ParaView opens the group ``/VTKHDF`` of a file, which is the net. A *view* is a file of
a kilobyte beside the result whose ``/VTKHDF`` is a link to one of its surfaces.
"""

import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import h5py

from tissuec.core.files import replacing
from tissuec.results import PlaceError, ResultError
from tissuec.results.hdf5 import external_link, open_file, set_attribute
from tissuec.results.journal import has_journal
from tissuec.results.layout import BLOCKS, VIEW, check_replaceable
from tissuec.results.places import check_place, final_path
from tissuec.results.store import LIBVER
from tissuec.results.surface_table import SurfaceSeries

BLOCKS_NAME = "blocks"
"""What the name of a blocks file has behind that of its result."""


def view_paths(result: Path, surfaces: Sequence[str]) -> dict[str, Path]:
    """Return where the views of a result stand, by the names of its surfaces."""
    result = final_path(result)
    paths: dict[str, Path] = {}
    for name in surfaces:
        plain = "".join(c if c.isalnum() or c == "-" else "_" for c in name)
        path = result.with_name(f"{result.stem}.{plain}{result.suffix}")
        if path in paths.values() or path == blocks_path(result):
            path = result.with_name(f"{result.stem}.{plain}_{len(paths) + 1}{result.suffix}")
        paths[name] = path
    return paths


def blocks_path(result: Path) -> Path:
    """Return where the blocks file of a result stands."""
    result = final_path(result)
    return result.with_name(f"{result.stem}.{BLOCKS_NAME}{result.suffix}")


def check_blocks(result: Path) -> None:
    """Check that the blocks file of a result replaces nothing but a blocks file.

    Raises:
        PlaceError: Something else has its name.
    """
    path = blocks_path(result)
    if path.exists() and not _is_marked(path, BLOCKS):
        raise PlaceError(
            f'cannot write the blocks to "{path}": it exists and is not a blocks file; give '
            "another result, or remove it"
        )


def check_views(result: Path, surfaces: Sequence[str]) -> None:
    """Check that the views of a result replace nothing but views.

    Raises:
        PlaceError: Something else has the name of one.
    """
    for name, path in view_paths(result, surfaces).items():
        if path.exists() and not _is_marked(path, VIEW):
            raise PlaceError(
                f'cannot write "{path}" for the surface of {name}: it exists '
                "and is not a surface file; give another result, or remove it"
            )


def write_views(result: Path, surfaces: Mapping[str, str]) -> dict[str, Path]:
    """Write the views of a result, and return where they stand by name.

    Args:
        surfaces: The groups in the result by name.

    Raises:
        ResultError: One cannot be written.
    """
    paths = view_paths(result, list(surfaces))
    for name, path in paths.items():
        try:
            with (
                replacing(path) as beside,
                open_file(beside, "w", libver=LIBVER) as file,
            ):
                # Of fixed length: a text of any length would fill four kilobytes.
                mark = name.encode()
                set_attribute(file, VIEW, mark, h5py.string_dtype("utf-8", len(mark)))
                file["VTKHDF"] = external_link(result.name, surfaces[name])
        except OSError as error:
            reason = error.strerror or str(error)
            raise ResultError(
                f'cannot write "{path}" for the surface of {name}: {reason}; '
                f'"{result}" is complete'
            ) from error
    return paths


def _is_marked(path: Path, mark: str) -> bool:
    try:
        with open_file(path, "r") as file:
            return mark in file.attrs
    except OSError:
        return False


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
