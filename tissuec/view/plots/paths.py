"""Paths of sets: their centres over time, and the extent of their nodes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar, NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError, counted
from tissuec.core.source import Source
from tissuec.lang import syntax as s
from tissuec.model.network import Floats, Indices, numbers_in
from tissuec.results.recording import NODES, members
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import look
from tissuec.view.plots.frame_reader import drawn, moved, no_frames
from tissuec.view.plots.options import Option, Start, Stop
from tissuec.view.plots.over_time import Panel, TimeCurve, Window, alike, picture_of
from tissuec.view.plots.page import Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled
    from tissuec.results.trajectory import Trajectory

AXES = ("x", "y", "z")
MOST_SETS = 4  # where none is named
STILL = 1e-6  # of the largest displacement: what moves less is at rest


class Path(NamedTuple):
    """The nodes of a set over time: centre and extremes [m], shapes (frame, 3)."""

    name: str
    time: Floats
    centre: Floats
    low: Floats
    high: Floats

    @property
    def reach(self) -> Floats:
        """Return by how much it moves along each axis [m], shape (3,)."""
        from_start = self.high.max(axis=0) - self.high[0], self.low[0] - self.low.min(axis=0)
        back = self.high[0] - self.high.min(axis=0), self.low.max(axis=0) - self.low[0]
        return np.max([*from_start, *back], axis=0)


@PLOTS.member("paths")
class Paths(Struct, frozen=True):
    """Displacements of sets over time: the centre, and the range of all nodes around it.

    Attributes:
        of: Names of sets or bodies, or sets as a scene has them; those that move if none.
        places: Whether positions are shown instead of displacements.
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = True

    of: Annotated[
        tuple[str, ...],
        Option(
            'Paths of this set or body, or of a set such as "nodes of BODY where x < 1 mm"; '
            "may be repeated.", "SET",
        ),
    ] = ()  # fmt: skip
    places: Annotated[bool, Option("Show positions instead of displacements.")] = False
    start: Start = None
    stop: Stop = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        notes: list[str] = []
        return picture_of(self.panels(subjects, notes), subjects, notes=notes)

    def panels(self, runs: Sequence[PlotSubject], notes: list[str]) -> list[Panel]:
        """Return the artists; add notes on what is not drawn."""
        paths = [self._paths(run.content, notes) for run in runs]
        axes = _moving(paths)
        if still := [name for name in AXES if name not in axes]:
            notes.append(f"nothing moves along {' and '.join(still)}")
        what = "position" if self.places else "displacement"
        if len(runs) == 1 and len(paths[0]) > 1:
            return alike(
                [
                    Panel(
                        f"{what} along {axis}",
                        "m",
                        [_curve(one, axis, n, one.name) for n, one in enumerate(paths[0])],
                    )
                    for axis in axes
                ]
            )
        sets = dict.fromkeys(path.name for of_run in paths for path in of_run)
        return [
            panel
            for name in sets
            for panel in alike([_of_set(paths, name, axis, what) for axis in axes])
        ]

    def _paths(self, trajectory: "Trajectory", notes: list[str]) -> list[Path]:
        if not len(trajectory.times):
            raise no_frames(trajectory)
        if self.of:
            asked = {name: nodes_of(trajectory, name) for name in self.of}
            return [self._path(trajectory, *one, notes) for one in asked.items()]
        usual = _usual(trajectory).items()
        paths = [self._path(trajectory, *one, notes) for one in usual]
        largest = max(float(path.reach.max()) for path in paths)
        moving = [path for path in paths if path.reach.max() > STILL * largest] or paths[:1]
        if len(moving) > MOST_SETS:
            notes.append(f"of {counted(len(moving), 'set')} the first {MOST_SETS} are shown")
        return moving[:MOST_SETS]

    def _path(
        self, trajectory: "Trajectory", name: str, nodes: Indices, notes: list[str]
    ) -> Path:
        rows = recorded(trajectory, nodes)
        if not len(rows):
            raise TissueError(f'no node of "{name}" is in the trajectory of this run')
        if len(rows) < len(nodes):
            missing = counted(len(nodes) - len(rows), "node")
            notes.append(f'{missing} of "{name}" are not recorded')
        frames = Window(self.start, self.stop).rows(trajectory.times, "the trajectory")
        place = moved(trajectory, rows, frames)
        if self.places:
            place = place + drawn(trajectory)[rows]
        extremes = place.min(axis=1), place.max(axis=1)
        return Path(name, trajectory.times[frames], place.mean(axis=1), *extremes)


def _usual(trajectory: "Trajectory") -> dict[str, Indices]:
    """Return the recorded sets of nodes and bodies of a result."""
    sets = {one.name: one.indices for one in trajectory.sets.values() if one.what == NODES}
    bodies: dict[str, Indices] = {
        name: numbers_in(body.nodes) for name, body in trajectory.bodies.items()
    }
    found = {
        name: nodes
        for name, nodes in (sets | bodies).items()
        if len(recorded(trajectory, nodes))
    }
    return found or {"all nodes": trajectory.nodes}


def _of_set(paths: Sequence[Sequence[Path]], name: str, axis: str, what: str) -> Panel:
    """Return a panel of one set with a curve for each run."""
    curves = [
        _curve(path, axis, number, "")
        for number, of_run in enumerate(paths)
        for path in of_run
        if path.name == name
    ]
    return Panel(f"{what} of {name} along {axis}", "m", curves)


def _moving(paths: Sequence[Sequence[Path]]) -> list[str]:
    """Return the axes along which anything moves; all where nothing does."""
    reach = np.max([path.reach for of_run in paths for path in of_run], axis=0)
    moving = [name for name, one in zip(AXES, reach, strict=True) if one > STILL * reach.max()]
    return moving or list(AXES)


def _curve(path: Path, axis: str, number: int, name: str) -> TimeCurve:
    column = AXES.index(axis)
    band = path.low[:, column], path.high[:, column]
    return TimeCurve(name, path.time, path.centre[:, column], look(number), band)


_SETS = ("nodes of ", "springs of ", "[")


def nodes_of(trajectory: "Trajectory", asked: str) -> Indices:
    """Return the nodes of a name or set, as network numbers, shape (n,).

    Args:
        asked: A name of a set or body, a region with its body, or a set in the language, such
            as "nodes of vessel where x < 1 mm".

    Raises:
        TissueError: There is no such name, or the scene has changed.
        CompileError: The set has an error.
    """
    if s.key_of(asked).startswith(_SETS):
        from tissuec.analysis.result_scene import recompile

        recompiled = recompile(trajectory)
        if recompiled.compiled is None:
            reasons = "; ".join(doubt.text for doubt in recompiled.doubts)
            raise TissueError(f'the sets of "{trajectory.path}" are unknown: {reasons}')
        return _chosen(recompiled.compiled, asked)
    try:
        return members(trajectory.network, trajectory.groups, asked, NODES)
    except ValueError as error:
        like = f'"nodes of {next(iter(trajectory.bodies), "BODY")} where x < 1 mm"'
        raise TissueError(f"{error}; or write a set, such as {like}") from error


def _chosen(compiled: "Compiled", text: str) -> Indices:
    """Return the nodes of a set that no scene has."""
    from tissuec.lang.parser import parse
    from tissuec.scene.program.declarations import Declared

    groups, found = compiled.groups, np.zeros(0, dtype=np.int64)
    (item,) = parse(Source("--of", f"set plotted = {text}"), has_heading=False).items
    assert isinstance(item, s.Assign)
    groups.declared[item.name.key] = Declared(item.name, item)
    with groups.findings.item():
        found = groups.nodes(item.name).indices
    groups.findings.raise_errors()
    return found


def recorded(trajectory: "Trajectory", nodes: Indices) -> Indices:
    """Return the rows of the frames that show nodes, shape (m,).

    Nodes that are not recorded are left out.

    Args:
        nodes: Network numbers, shape (n,).
    """
    if not len(trajectory.nodes):
        return np.zeros(0, dtype=np.int64)
    rows = np.minimum(np.searchsorted(trajectory.nodes, nodes), len(trajectory.nodes) - 1)
    return rows[trajectory.nodes[rows] == nodes]
