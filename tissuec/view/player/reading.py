"""From a result file to its drawable contents, frame by frame."""

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices
from tissuec.results.frame_columns import POSITION
from tissuec.results.instruments import Course
from tissuec.results.instruments.courses import courses
from tissuec.results.moments import Moments, curved, slopes
from tissuec.results.surface_table import SurfaceSeries
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.cells import (
    MOST_NODES,
    CappedSkin,
    Change,
    SolidCells,
    capped,
    cut_solids,
    no_cells,
    read_cells,
)
from tissuec.view.player.film import (
    DRAWN,
    Instrument,
    Lines,
    PlayerData,
    Resultant,
    SkinPiece,
    SurfacePiece,
    ToolSolid,
)
from tissuec.view.player.holds import DrawnNet, read_held, read_pulls
from tissuec.view.player.lifetimes import (
    FOREVER,
    Lifetimes,
    Mask,
    Register,
    Timeline,
    lives,
    sharpened_triangles,
)
from tissuec.view.player.options import Options
from tissuec.view.player.thinning import (
    SpringLines,
    Thinning,
    strands,
    thin_triangles,
    thinned,
    whole,
)
from tissuec.view.player.tints import body_tint, is_hollow, node_tints, node_tissues
from tissuec.view.plots.frame_reader import no_frames

_STITCH = 0.06  # radius of a spring of a joint, of the mean rest length of all springs


def read_film(trajectory: Trajectory, options: Options) -> PlayerData:
    """Return the drawable contents of a result.

    Raises:
        TissueError: It has no frame.
    """
    if not len(trajectory.times):
        raise no_frames(trajectory)
    return film_of(Moments.of(trajectory, choose_frames(trajectory.times, options)), options)


def film_of(moments: Moments, options: Options) -> PlayerData:
    """Return the drawable contents of some moments of a result."""
    trajectory = moments.trajectory
    timeline = Timeline(moments.times)
    mesh, few = trajectory.mesh, options.nodes
    count = mesh.points
    thin = whole(count) if few is None or few >= count else thinned(trajectory, few)
    lives = _topologies(moments, timeline)
    cells = _cells(trajectory, lives, options)
    strand = strands(thin, trajectory.ends)
    seen = courses(moments)
    pulls = read_pulls(moments, seen)
    points = [*map(_carriers, seen), *(pull.place[:, None] for pull in pulls)]
    position, velocity = _motion(moments, thin, points)
    first = position.shape[1] - len(pulls)
    capped_skin = capped(lives.triangles, lives.life, cells)
    cells = cells.joined(cut_solids(trajectory, lives.elements))
    skin = _skin(trajectory, thin, capped_skin, cells)
    drawn = DrawnNet.of(thin, skin, strand.ends)
    tissues, tissue = node_tissues(trajectory)
    return PlayerData(
        times=timeline.times,
        clock=trajectory.clock,
        position=position,
        velocity=velocity,
        curved=curved(
            moments.times, position[:, : len(thin.kept)], velocity[:, : len(thin.kept)]
        ),
        is_side=moments.sides >= 0,
        force=moments.vectors("force", thin.kept, np.float32),
        fields=_fields(moments, thin),
        lines=_lines(trajectory, thin, strand, lives.springs, _tensions(moments, strand)),
        skin=skin,
        cells=cells if thin.is_whole else cells.on_nodes(thin.place),
        tints=node_tints(trajectory)[thin.kept],
        tissue=tissue[thin.kept],
        tissues=tissues,
        dots=thin.nodes(lives.dots),
        held=read_held(trajectory, timeline, drawn, {course.name for course in seen}),
        solids=_solids(trajectory, len(thin.kept)),
        instruments=_instruments(seen, timeline, first - 4 * len(seen)),
        resultants=tuple(
            Resultant(pull.name, first + number, _life(timeline, pull.life), pull.force)
            for number, pull in enumerate(pulls)
        ),
        surfaces={
            name: _pieces(series, moments, timeline, options)
            for name, series in trajectory.surfaces.items()
            if len(series)
        },
        laws=tuple(law.name for law in trajectory.network.springs.laws),
        recorded=(count, (own := len(trajectory.springs)), len(trajectory.lines) - own),
        numbers=mesh.numbers_of_points[thin.kept],
        matter=slice(len(thin.kept))
        if (own := mesh.are_matter[thin.kept]).all()
        else np.flatnonzero(own),
    )


def choose_frames(times: Floats, options: Options) -> Indices:
    """Return the numbers of the frames to show, shape (n,), including the first and the last.

    Args:
        times: Of all frames [s], shape (frame,).
    """
    chosen = np.arange(len(times))
    if options.every is not None:
        steps = np.floor((times - times[0]) / options.every + 1e-9)
        chosen = np.union1d(chosen[np.diff(steps, prepend=-1.0) > 0], chosen[-1:])
    if options.frames is not None and options.frames < len(chosen):
        places = np.linspace(0, len(chosen) - 1, max(2, options.frames))
        chosen = chosen[np.round(places).astype(int)]
    return chosen


class DrawnLives(NamedTuple):
    """When what is drawn is there.

    Attributes:
        springs: Recorded springs.
        triangles: Of the skin, shape (triangle, 3).
        life: Of these, in frames, shape (triangle, 2).
        dots: Nodes that nothing touches.
        changes: Which springs are there, from a frame on.
        elements: The cells of solid elements, if some are cut in parts.
    """

    springs: Lifetimes
    triangles: NDArray[np.integer]
    life: Floats
    dots: Lifetimes
    changes: list[Change]
    elements: Lifetimes


def _topologies(moments: Moments, timeline: Timeline) -> DrawnLives:
    trajectory = moments.trajectory
    nodes, count = trajectory.mesh.points, len(trajectory.lines)
    solids = len(trajectory.mesh.solids)
    register = Register(nodes, 3)
    masks: list[tuple[float, Mask, Indices, Mask]] = []
    there: list[tuple[float, Mask]] = []
    for frame, cells in moments.topologies():
        alive = _mask(np.searchsorted(trajectory.lines, cells.line_numbers), count)
        faces = register.numbers(cells.triangles)
        masks.append((frame, alive, faces, _mask(cells.vertices[:, 0], nodes)))
        if trajectory.mesh.cut is not None:
            there.append((frame, _mask(cells.elements, solids)))
    faces = len(register.rows)
    springs = timeline.sharpened(
        lives(((frame, alive) for frame, alive, _, _ in masks), count),
        trajectory.lines,
        trajectory.events,
    )
    found = lives(((frame, _mask(shown, faces)) for frame, _, shown, _ in masks), faces)
    life = sharpened_triangles(found.life, springs.life[:, 1])
    dots = lives(((frame, lonely) for frame, _, _, lonely in masks), nodes)
    changes = [(frame, alive) for frame, alive, _, _ in masks]
    elements = lives(there, solids)
    return DrawnLives(springs, register.rows[found.of], life, dots, changes, elements)


def _cells(trajectory: Trajectory, found: DrawnLives, options: Options) -> SolidCells:
    """Return filled bodies, as far as they are seen: where they are cut, torn or in section."""
    if options.section is None and not options.cells and len(found.changes) < 2:
        return no_cells()
    most = MOST_NODES if options.section is None else None
    return read_cells(trajectory, found.changes, found.springs.life[:, 1], most=most)


def _mask(numbers: Indices, count: int) -> Mask:
    there = np.zeros(count, dtype=bool)
    there[numbers] = True
    return there


def _motion(
    moments: Moments, thin: Thinning, points: Sequence[Floats]
) -> tuple[Floats, NDArray[np.float32]]:
    """Return positions and velocities of nodes, tools and further points, (row, point, 3)."""
    tools = np.concatenate([moments.tools(), *points], axis=1)
    position = np.concatenate([moments.vectors("position", thin.kept, np.float64), tools], 1)
    own = moments.vectors("velocity", thin.kept, np.float32)
    return position, np.concatenate([own, slopes(moments.times, tools).astype("f4")], axis=1)


def _fields(moments: Moments, thin: Thinning) -> dict[str, NDArray[np.float32]]:
    """Return one number at each node by fields of frames, shape (row, node) each."""
    return {
        one.name: np.stack(
            [moments.at_nodes(one, row)[thin.kept] for row in range(len(moments))]
        ).astype(np.float32)
        for one in moments.trajectory.channels
        if one.name not in DRAWN
    }


def _tensions(moments: Moments, strand: SpringLines) -> NDArray[np.float32]:
    """Return the tension of each strand, or the last one known, shape (row, strand)."""
    tensions = np.zeros((len(moments), len(strand.ends)), dtype=np.float32)
    for row in range(len(moments)):
        if row:
            tensions[row] = tensions[row - 1]
        mean, there = strand.mean(*moments.tension(row))
        tensions[row, there] = mean
    return tensions


def _lines(
    trajectory: Trajectory,
    thin: Thinning,
    strand: SpringLines,
    springs: Lifetimes,
    tension: NDArray[np.float32],
) -> Lines:
    found = strand.lives(springs)
    network, first = trajectory.network, trajectory.lines[strand.first]
    radius = np.zeros(network.line_count)
    for thread in network.threads.values():
        radius[[*range(network.spring_count)[thread.pieces], thread.hold, thread.slip]] = (
            thread.radius
        )
    stitch = np.zeros(network.line_count, dtype=bool)
    for joint in network.joints:
        stitch[joint.springs] = True
    stitch &= radius == 0.0
    rest = _rest(trajectory, thin, strand)
    radius[stitch] = _STITCH * rest[rest > 0.0].mean() if (rest > 0.0).any() else 0.0
    return Lines(
        ends=strand.ends[found.of],
        life=found.life,
        tension=tension[:, found.of] if len(found.of) != len(strand.ends) else tension,
        rest=rest[found.of],
        law=np.append(network.springs.law, 0 * network.edges[:, 0])[first][found.of].astype(
            np.int64
        ),
        radius=radius[first][found.of],
        stitch=stitch[first][found.of],
        bears=network.bears[first][found.of],
        number=first[found.of],
    )


def _rest(trajectory: Trajectory, thin: Thinning, strand: SpringLines) -> Floats:
    """Return rest lengths [m] that give lines the mean stretch of their springs as drawn."""
    network = trajectory.network
    of_edges = _lengths(network.position, network.edges.astype(np.int64))
    rest = np.append(network.springs.rest, of_edges)[trajectory.lines]
    if thin.is_whole:
        return rest
    drawn = trajectory.mesh.at_points(network.position[trajectory.nodes], POSITION)
    stretch = _lengths(drawn, trajectory.ends) / np.where(rest > 0.0, rest, np.inf)
    mean, there = strand.mean(stretch, np.arange(len(rest)))
    own = np.zeros(len(strand.ends))
    own[there] = _lengths(drawn[thin.kept], strand.ends[there]) / np.where(
        mean > 0.0, mean, np.inf
    )
    return own


def _lengths(position: Floats, ends: Indices) -> Floats:
    return np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)


def _skin(
    trajectory: Trajectory, thin: Thinning, drawn: CappedSkin, cells: SolidCells
) -> SkinPiece:
    corners, first, life = thin_triangles(thin, drawn.triangles, drawn.life)
    nodes = trajectory.mesh.representatives
    smooth = np.zeros(len(nodes), dtype=bool)
    for body in trajectory.network.bodies:
        if body.name in trajectory.surfaces and len(trajectory.surfaces[body.name]):
            smooth |= (nodes >= body.nodes.start) & (nodes < body.nodes.stop)
    smooth = smooth[drawn.triangles[first, 0]] & ~drawn.is_cap[first]
    hollow = is_hollow(trajectory, drawn.triangles[first], set(cells.filled))
    return SkinPiece(corners, life, smooth, hollow)


def _carriers(course: Course) -> Floats:
    """Return the points that carry an instrument [m], shape (row, 4, 3); see ``Instrument``."""
    x, _, z = np.moveaxis(course.axes, 1, 0)
    ways = [np.zeros_like(z), z, x, course.setting[:, None] * z]
    return course.origin[:, None] + course.size * np.stack(ways, axis=1)


def _life(timeline: Timeline, life: tuple[float, float]) -> tuple[float, float]:
    """Return a life in frames, given in seconds."""
    begin, end = (float(timeline.frame_of(time)) for time in life)
    return begin, FOREVER if life[1] > timeline.times[-1] else end


def _instruments(
    seen: Sequence[Course], timeline: Timeline, first: int
) -> tuple[Instrument, ...]:
    """Return instruments, whose points begin with a number."""
    found: list[Instrument] = []
    for number, course in enumerate(seen):
        life = _life(timeline, course.life)
        origin = first + 4 * number
        points = origin, origin + 1, origin + 2, origin + 3
        found.append(Instrument(course.kind, course.name, course.size, life, points))
    return tuple(found)


def _solids(trajectory: Trajectory, nodes: int) -> tuple[ToolSolid, ...]:
    """Return the shapes of tools, whose points follow the nodes."""
    if trajectory.tools is None:
        return ()
    shapes = [(tool, shape) for tool in trajectory.network.tools for shape in tool.shapes]
    return tuple(
        ToolSolid(
            shape.seen_as, shape.radius, (nodes + 2 * number, nodes + 2 * number + 1), tool.name
        )
        for number, (tool, shape) in enumerate(shapes)
    )


def _pieces(
    series: SurfaceSeries, moments: Moments, timeline: Timeline, options: Options
) -> list[SurfacePiece]:
    """Return a smooth surface as pieces whose triangles stay the same."""
    shown: list[tuple[float, Floats, Indices]] = []
    for frame in map(int, choose_frames(series.times, options)):
        place = float(timeline.frame_of(series.times[frame]))
        shown.append((place, series.position(frame), series.triangles(frame)))
    rows = {int(moments.sides[row]): row for row in np.flatnonzero(moments.sides >= 0)}
    for side, points, triangles in moments.surface(series):
        shown.append((float(rows[side]), points, triangles))
    shown.sort(key=lambda one: one[0])
    tint = body_tint(moments.trajectory, series.name)
    found: list[SurfacePiece] = []
    for _, same in groupby(shown, key=lambda one: one[2].tobytes()):
        places, positions, faces = zip(*same, strict=True)
        found.append(SurfacePiece(np.array(places), faces[0], np.stack(positions), tint))
    return found
