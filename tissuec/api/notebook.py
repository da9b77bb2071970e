"""Results for interactive use: as a few lines of text, in a notebook the motion itself, and as
tables, datasets and meshes of other packages."""

from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from tissuec.core.data import printable
from tissuec.core.errors import counted
from tissuec.core.report import holding
from tissuec.core.units import show_interval
from tissuec.model.blocks import NetSize
from tissuec.results import trajectory as results

if TYPE_CHECKING:
    import pandas  # pyright: ignore[reportMissingImports, reportMissingTypeStubs]
    import pyvista  # pyright: ignore[reportMissingImports]
    import xarray  # pyright: ignore[reportMissingImports]

MOST_NAMED = 8  # of a kind
MOST_NODES = 20_000  # beyond, a net is no picture for a page
MOST_POSITIONS = 1_000_000  # of nodes in all frames together; more frames are left out
LARGEST = 8_000_000  # characters of a player that a notebook still takes easily
HEIGHT = 560  # [px]


class Trajectory(results.Trajectory):
    __doc__ = results.Trajectory.__doc__
    _is_one_of_many = True  # such as in the list of a loop

    def __repr__(self) -> str:
        return as_text(self)

    def _repr_html_(self) -> str:
        """Show it in a notebook: the motion, and what else there is."""
        return as_html(self)

    def to_pandas(self, *names: str) -> "pandas.DataFrame":
        """Return logs, "energies" or "events" as a table of pandas.

        Args:
            names: One log: its columns. Several: columns of two levels, log and column, with
                NaN where one has no row at a time. None: all logs.

        Returns:
            A row per moment; the index is the time [s], the units are in ``attrs["units"]``.

        Raises:
            ImportError: pandas is not installed; says what to install.
            ResultError: There is no such log.
        """
        from tissuec.results import conversion  # where it is asked for

        return conversion.to_pandas(self, names)

    def to_xarray(self, *names: str, frames: slice = slice(None)) -> "xarray.Dataset":
        """Return frames as a dataset of xarray, with named axes, units and ids.

        Args:
            names: Of "position", "velocity", "force" and "tension"; all four if none is named.
            frames: Which frames are read.

        Raises:
            ImportError: xarray is not installed; says what to install.
            ValueError: There is no such array.
        """
        from tissuec.results import conversion  # where it is asked for

        return conversion.to_xarray(self, names, frames)

    def to_pyvista(self, frame: int = -1) -> "pyvista.UnstructuredGrid":
        """Return one frame as a mesh of PyVista: springs, triangles, and solids as volumes.

        Points are in m; the arrays at points are "velocity" [m/s], "force" [N] and "node_id",
        those at cells "spring_force" [N] and "spring_id", which only lines have: 0 and -1
        elsewhere. Further fields that frames contain have their own names.

        Args:
            frame: Its number; a negative one counts from the end.

        Raises:
            ImportError: PyVista is not installed; says what to install.
            IndexError: There is no such frame.
        """
        from tissuec.results import conversion, export  # where it is asked for

        return conversion.to_pyvista(export.frame_shape(self, frame))


def as_text(trajectory: results.Trajectory) -> str:
    """Return a summary of a result, one line per kind of content."""
    name = f'Trajectory "{trajectory.path.name}"'
    if not trajectory.is_open:
        return f"<closed {name}>"
    lines = [f"  {head}: {text}" for head, text in _rows(trajectory)]
    return printable("\n".join([f"<{name}>", *lines]))


def as_html(trajectory: results.Trajectory) -> str:
    """Return the player, or why there is none, and the summary as a table."""
    if not trajectory.is_open:
        return f"<p>{escape(as_text(trajectory))}</p>"
    cells = "".join(
        f'<tr><th style="text-align:left;vertical-align:top">{escape(head)}</th>'
        f'<td style="text-align:left">{escape(text)}</td></tr>'
        for head, text in _rows(trajectory)
    )
    return (
        f"<div>{_player(trajectory)}<table>"
        f"<caption>{escape(trajectory.path.name)}</caption>{cells}</table></div>"
    )


def _player(trajectory: results.Trajectory) -> str:
    """Return the player in a frame of its own, or a sentence about why it is left out."""
    from tissuec.view.player.options import Options
    from tissuec.view.player.page import fragment

    frames, nodes = trajectory.position.shape[:2]
    if not frames or not nodes:
        return (
            "<p>There is no motion to show, because the scene does not record a trajectory.</p>"
        )
    view = f'tissuec view "{trajectory.path}" shows it in a separate page'
    if nodes > MOST_NODES:
        return f"<p>{nodes} nodes are too many for a notebook; {escape(view)}.</p>"
    most = max(2, MOST_POSITIONS // nodes)
    page = fragment(trajectory, Options(frames=most), height=HEIGHT)
    if len(page) > LARGEST:
        return f"<p>The motion is too large for a notebook; {escape(view)}.</p>"
    left = f"<p>{most} of {frames} frames are shown; {escape(view)}.</p>"
    return page + left if frames > most else page


def _rows(trajectory: results.Trajectory) -> list[tuple[str, str]]:
    """Return headings and texts."""
    network = trajectory.network
    rows = [
        ("outcome", trajectory.outcome),
        ("accuracy in time", trajectory.promise.sentence),
        ("frames", _frames(trajectory)),
    ]
    rows += [("body", f"{body.name}, {body.size}") for body in network.bodies]
    rows += [("joint", f"{joint.name}, {joint.size}") for joint in network.joints]
    sets = [
        f"{name} ({counted(len(group.indices), group.what[:-1])})"
        for name, group in trajectory.sets.items()
    ]
    logs = [
        f"{log.name} [{log.unit}]" if log.unit else log.name for log in trajectory.logs.values()
    ]
    energies = ["energies [J]"] if trajectory.energies is not None else []
    kinds = Counter(event.kind for event in trajectory.events)
    states = [judged.state for judged in trajectory.expectations]
    rows += [
        ("sets", _some(sets)),
        ("logs", _some([*logs, *energies])),
        ("surfaces", _some(list(trajectory.surfaces))),
        ("events", _some([f"{count} {kind}" for kind, count in kinds.items()])),
        ("expectations", holding(states) if states else ""),
    ]
    return [(head, text) for head, text in rows if text]


def _frames(trajectory: results.Trajectory) -> str:
    times, frames = trajectory.times, len(trajectory.position)
    if not frames:
        return "none"
    span = show_interval(float(times[0]), float(times[-1]))
    return f"{frames}, {span}, of {_recorded(trajectory)}"


def _recorded(trajectory: results.Trajectory) -> NetSize:
    """Return how large the recorded part of a net is, with elements that are whole."""
    network, elements = trajectory.network, 0
    for body in network.bodies:
        own = np.searchsorted(trajectory.nodes, (body.nodes.start, body.nodes.stop))
        is_whole = int(own[1] - own[0]) == body.nodes.stop - body.nodes.start
        elements += body.element_count if is_whole else 0
    return NetSize(len(trajectory.nodes), len(trajectory.springs), elements)


def _some(names: Sequence[str]) -> str:
    more = f", and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + more
