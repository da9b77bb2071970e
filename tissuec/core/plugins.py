"""Plug-ins: modules of other packages that add members to families.

A package names them as entry points of the group ``tissuec.KIND``, where KIND is what a member
of the family is called, such as ``mesh`` or ``spring_law``.
"""

import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from tissuec.core.errors import TissueError

PREFIX = "tissuec."


class PlugIn(NamedTuple):
    """An entry point.

    Attributes:
        group: Such as "tissuec.mesh".
        module: Name of the module to import.
        package: Name of the installed package that brings it, and its version.
    """

    group: str
    module: str
    package: str
    version: str


class BrokenPlugIn(TissueError):
    """A plug-in cannot be imported; the message names it and says why."""


def load(kind: str) -> None:
    """Import the modules that add members of a kind.

    Args:
        kind: Of a family, such as "spring law".

    Raises:
        BrokenPlugIn: One of them cannot be imported.
    """
    group = PREFIX + kind.replace(" ", "_")
    for found in plugins():
        if found.group == group:
            try:
                import_module(found.module)
            except Exception as error:
                raise BrokenPlugIn(
                    f"the package {found.package} {found.version} cannot add a {kind}: "
                    f"importing {found.module} fails: {type(error).__name__}: {error}"
                ) from error


def packages() -> frozenset[str]:
    """Return the import names of all packages that may define members and their records."""
    return frozenset({"tissuec", *(found.module.partition(".")[0] for found in plugins())})


@cache
def plugins() -> tuple[PlugIn, ...]:
    """Return all plug-ins that are installed."""
    if not any(_mentions_plugins(folder) for folder in sys.path):
        return ()
    from importlib.metadata import entry_points

    known = entry_points()
    return tuple(
        PlugIn(group, point.module, point.dist.name, point.dist.version)
        for group in sorted(known.groups)
        if group.startswith(PREFIX)
        for point in known.select(group=group)
        if point.dist is not None
    )


def _mentions_plugins(folder: str) -> bool:
    """Return whether metadata of a package in a folder name the group.

    Importing ``importlib.metadata`` takes a tenth of the time of ``tissuec check``; reading
    these files takes a hundredth.
    """
    return any(b"[" + PREFIX.encode() in text for text in _entry_points(Path(folder or ".")))


def _entry_points(folder: Path) -> Iterator[bytes]:
    for pattern in ("*.dist-info", "*.egg-info"):
        for path in folder.glob(f"{pattern}/entry_points.txt"):
            try:
                yield path.read_bytes()
            except OSError:
                continue
