"""Times of the script at which nodes are displaced as far as the rows of data say.

The actions of the script are applied once without any physics: driven nodes are on their
paths, all others stay where they are drawn. The displacement of a row is the mean one of the
moved nodes, along the line to where they are in the end; what counts is the first way out, as
far as it never turns back. Along a given line it has a sign, as in a test of tension and
compression; there, what counts is when the nodes are first so far to that side.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.compile import Compiled
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.units import LENGTH, show
from tissuec.engine.execution.event_queue import SAME, ActionQueue
from tissuec.measurements.experiment import Series
from tissuec.mechanics.state import PrescribedMotion, State
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.fit_problem import DataAxis
from tissuec.script.plan import Plan
from tissuec.script.verbs.settle import Settle

LOOKS = 4096  # at the whole way, to find where it turns back
SAME_WAY = 1e-9  # of the whole way: displacements closer than this are one


class Interval(NamedTuple):
    """A stretch of time between two events.

    Attributes:
        start, stop: [s].
        at: Returns how far the nodes are from where they are drawn, in the mean, and how fast
            they move, [m] and [m/s], shape (3,) each.
    """

    start: float
    stop: float
    at: Callable[[float], tuple[Floats, Floats]]


class TravelledDistance:
    """The way of some nodes, as far as they are held.

    Args:
        nodes: That the script moves, shape (node,).
        along: Unit vector along which displacements have a sign, shape (3,).

    Attributes:
        least, greatest: Displacements between which there is a time [m]; 0 if nothing moves the
            nodes. Without a line the greatest is where they first turn back, or end.
        released: When they are first let go of [s]; infinite if never.
    """

    def __init__(
        self, network: Network, plan: Plan, nodes: Indices, along: Floats | None = None
    ):
        self.near = SAME * plan.simulation.duration
        self.released = np.inf
        pieces = list(self._pieces(network, plan, nodes))
        looks = max(8, LOOKS // max(len(pieces), 1))
        grids = [np.linspace(piece.start, piece.stop, looks + 1) for piece in pieces]
        self._pieces_of = np.repeat(np.arange(len(pieces)), looks + 1)
        self._list, times = pieces, np.concatenate([np.zeros(0), *grids])
        means = [pieces[p].at(t)[0] for p, t in zip(self._pieces_of, times, strict=True)]
        ways = np.array(means).reshape(-1, 3)
        self._direction = _direction(ways) if along is None else along
        self._times, self._sizes = times, ways @ self._direction
        far = float(np.abs(self._sizes).max(initial=0.0))
        if far > SAME_WAY * float(np.abs(ways).max(initial=0.0)) and along is None:
            first = int(np.argmax(np.abs(self._sizes) > SAME_WAY * far))
            if self._sizes[first] < 0.0:  # the way out counts, wherever it ends
                self._direction, self._sizes = -self._direction, -self._sizes
            self._end_where_it_turns(SAME_WAY * far)
        self.greatest = float(self._sizes.max(initial=0.0))
        self.least = 0.0 if along is None else float(self._sizes.min(initial=0.0))

    def time(self, displacement: float) -> float | None:
        """Return when the nodes are first displaced so far [s]; None if they never are.

        Of no displacement it is the time at which they set out.
        """
        close = SAME_WAY * max(self.greatest, -self.least)
        if not self.least - close <= displacement <= self.greatest + close:
            return None
        if abs(displacement) <= close:
            return self._departure(close)
        side = np.sign(displacement)
        wanted = min(abs(displacement), float((side * self._sizes).max()))
        place = int(np.argmax(side * self._sizes >= wanted))
        low, high = self._times[max(place - 1, 0)], self._times[place]
        piece = self._list[int(self._pieces_of[place])]
        while low < (middle := 0.5 * (low + high)) < high:
            if side * self._size(piece, middle) >= wanted:
                high = middle
            else:
                low = middle
        return self._held(float(high))

    # --- parts --------------------------------------------------------------------------------

    def _pieces(self, network: Network, plan: Plan, nodes: Indices) -> Iterator[Interval]:
        """Yield the intervals between events, until the nodes are released."""
        state = plan.start(network)
        queue = ActionQueue.of(plan)
        stop, were_held = plan.simulation.duration, False
        while state.time < stop:
            for action in queue.due(state.time):
                if not isinstance(action, Settle):
                    action.apply(state, queue)
            state.place_held()
            are_held = bool(state.held[nodes].all())
            if were_held and not are_held:
                self.released = state.time
                return
            were_held = are_held
            until = min(queue.next, stop)
            yield Interval(state.time, until, _mean_of(state, nodes))
            state.time = until
            state.place_held()

    def _end_where_it_turns(self, close: float) -> None:
        """End the way where it first turns back."""
        back = np.flatnonzero(np.diff(self._sizes) < -close)
        if not len(back):
            return
        last = int(back[0])
        piece = self._list[int(self._pieces_of[last])]
        low = max(self._times[max(last - 1, 0)], piece.start)
        high = min(self._times[last + 1], piece.stop)
        while low < (middle := 0.5 * (low + high)) < high:
            if piece.at(middle)[1] @ self._direction > 0.0:
                low = middle
            else:
                high = middle
        keep = self._times[: last + 1] < low
        sizes = np.append(self._sizes[: last + 1][keep], self._size(piece, low))
        self._pieces_of = np.append(self._pieces_of[: last + 1][keep], self._pieces_of[last])
        self._times, self._sizes = np.append(self._times[: last + 1][keep], low), sizes

    def _departure(self, close: float) -> float:
        """Return the start of the piece on which the nodes set out [s]."""
        away = np.flatnonzero(np.abs(self._sizes) > close)
        place = int(away[0]) if len(away) else 0
        return self._list[int(self._pieces_of[place])].start

    def _size(self, piece: Interval, time: float) -> float:
        return float(piece.at(time)[0] @ self._direction)

    def _held(self, time: float) -> float:
        """Return a time before the nodes are let go of [s]."""
        return min(time, self.released - 4.0 * self.near)


def _direction(means: Floats) -> Floats:
    """Return the unit vector to where the nodes are in the end, or farthest if that is home."""
    sizes = np.linalg.norm(means, axis=1)
    farthest = float(sizes.max(initial=0.0))
    if farthest == 0.0:
        return np.zeros(3)
    last = len(sizes) - 1
    chosen = last if sizes[last] > SAME_WAY * farthest else int(np.argmax(sizes))
    return means[chosen] / sizes[chosen]


def _mean_of(
    state: State, nodes: Indices
) -> Callable[[float], tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Return how far nodes are from where they are drawn on a piece that begins now."""
    home, place = state.network.position[nodes], state.position[nodes]
    still = (place - home).sum(axis=0)
    moved: list[tuple[PrescribedMotion, Indices, Floats]] = []
    for motion in state.motions.values():
        mine = np.flatnonzero(np.isin(motion.nodes, nodes))
        if len(mine):
            begun = motion.at(state.time)[0][mine].sum(axis=0)
            moved.append((motion, mine, begun))

    def at(time: float) -> tuple[Floats, Floats]:
        total, speed = still.copy(), np.zeros(3)
        for motion, mine, begun in moved:
            there, rate = motion.at(time)
            total += there[mine].sum(axis=0) - begun
            speed += rate[mine].sum(axis=0)
        return total / len(nodes), speed / len(nodes)

    return at


def rows_of(
    compiled: Compiled, series: Sequence[Series], axis: DataAxis
) -> tuple[Floats, list[Indices]]:
    """Return all times that rows belong to [s], shape (time,), and which one each row has.

    Times ascend; of each series there are numbers of times, shape (row,).

    Args:
        compiled: The scene.
        series: Measurements by displacement.
        axis: The moved nodes whose displacement rows have.

    Raises:
        CompileError: The script does not move the nodes, or not as far as a row says, or
            elements yield.
    """
    _refuse_yielding(compiled.network, axis)
    nodes = axis.nodes
    assert nodes is not None  # without, there is a time
    travel = TravelledDistance(compiled.network, compiled.plan, nodes, axis.along)
    if travel.least == travel.greatest:
        message = "the script does not move the nodes whose displacement is measured"
        hint = "for example: from 0 s to 1 s: move SET by (5, 0, 0) mm using smooth profile"
        raise CompileError([Diagnostic("TIS703", message, axis.span, hint)])
    times: dict[float, float] = {}
    for one in series:
        for displacement in one.times.tolist():
            time = travel.time(displacement)
            if time is None:
                raise CompileError([_unreached(travel, displacement, axis)])
            times[displacement] = time
    known = np.unique(list(times.values()))
    rows = [
        np.searchsorted(known, [times[u] for u in one.times.tolist()]).astype(np.int64)
        for one in series
    ]
    return known, rows


def _refuse_yielding(network: Network, axis: DataAxis) -> None:
    """Reject elements that yield where there is no time in which they could flow."""
    if all(field.yielding is None for field in network.elements):
        return
    message = "elements that yield need time: they cannot be fitted over a displacement"
    hint = "fit them over time: remove the displacement, and write a column of times"
    raise CompileError([Diagnostic("TIS802", message, axis.span, hint)])


def _unreached(travel: TravelledDistance, displacement: float, axis: DataAxis) -> Diagnostic:
    """Return the finding about a row with a displacement that the script does not reach."""
    there, least, greatest = (
        show(u, LENGTH, digits=6) for u in (displacement, travel.least, travel.greatest)
    )
    message = f"a row has a displacement of {there}, and the script moves the nodes from "
    hint = "check the unit of the column, extend the motion in the script, or remove such rows"
    if displacement < 0.0 and axis.along is None:
        hint = (
            "for displacements with a sign, write the direction after the set, for example: "
            f"displacement of SET along (1, 0, 0) using …; otherwise {hint}"
        )
    place = axis.span if axis.column is None else axis.column.span
    return Diagnostic("TIS703", f"{message}{least} to {greatest}", place, hint)
