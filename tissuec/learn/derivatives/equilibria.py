"""The equilibria of a net along its script, and their response to forces and displacements.

The net is brought to rest at each observed time. Before an event, too, because what
is taken hold of stays where it is then, and blades cut what is there.

With a the accelerations and M the masses, K = -M ∂a/∂x is symmetric, and what changes the
forces on free nodes by F changes their places by K⁻¹ F. A net that could move somehow without
any force has no K⁻¹. Where forces do no work along such a motion, how it gives way to them is
known all the same, and nothing moves along it.

The script is gone through once without any physics: driven nodes are on their paths, all
others stay where they are drawn. The displacement of a row is the mean one of the moved nodes,
along the line to where they are in the end; what counts is the first way out, as far as it
never turns back. Along a given line it has a sign, as in a test of tension and compression;
there, what counts is when the nodes are first so far to that side.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray
from scipy import sparse

from tissuec.core.units import TIME, show
from tissuec.engine.execution.event_queue import SAME, ActionQueue
from tissuec.engine.failures import overloaded
from tissuec.kernels.derivative_records import Values
from tissuec.learn.derivatives.event_recording import note
from tissuec.learn.derivatives.event_schedule import ArrayChange, Leg, leg_of, present_fields
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.parameters.numbers import NumberOrder
from tissuec.mechanics.settling import Remark, Unsettled, settle
from tissuec.mechanics.state import PrescribedMotion, State
from tissuec.mechanics.stiffness import LowRankFactor, Stiffness
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.plan import Plan
from tissuec.script.verbs.motion import EndMotion
from tissuec.script.verbs.settle import Settle


class Unbalanced(Diverged):
    """A net has no equilibrium; the time in the script [s] is its argument.

    Attributes:
        message: What is wrong, as a sentence.
    """

    def __init__(self, time: float, message: str):
        super().__init__(time)
        self.message = message

    def __str__(self) -> str:
        return self.message


class EquilibriumStage(Struct, frozen=True, eq=False):
    """An equilibrium.

    Attributes:
        leg: What acts; of no duration.
        free: Nodes that move to it, shape (free,); springs reach each of them.
        chosen: Which nodes may move if nobody holds them, shape (node,).
        way: How far nodes that are held went since the stand before [m], shape (node, 3); 0 of
            all others.
        places: Where nodes were in it when it was frozen [m], shape (node, 3).
        remarks: What is to be known of it.
    """

    leg: Leg
    free: Indices
    chosen: NDArray[np.bool_]
    way: Floats
    places: Floats
    remarks: tuple[Remark, ...]

    @property
    def time(self) -> float:
        """Return when it is in the script [s]."""
        return self.leg.start

    def balanced(self, network: Network, values: Values, before: Floats) -> Floats:
        """Return the places in equilibrium [m], shape (node, 3).

        Args:
            network: With numbers in its laws.
            values: The numbers of this stand.
            before: Places in the stand before [m], shape (node, 3).

        Raises:
            Unbalanced: There are none.
        """
        leg = self.leg
        state = State.start(network, gravity=leg.gravity, drag=0.0)
        state.time, state.alive = leg.start, leg.alive_springs
        state.mass = values.mass
        numbers = {name: getattr(values, name) for name in ("stiffness", "damping", "rest")}
        state.springs = replace(state.springs, **numbers)
        state.holders = dict(leg.holders)
        state.loads = {str(number): load for number, load in enumerate(leg.loads)}
        fields = present_fields(leg, values).items()
        state.blocks = {name: FieldBlock(name, "", field, None) for name, field in fields}
        state.position[:] = before + self.way
        state.velocity[:] = 0.0
        _settle(state, self.chosen, self.places)
        return state.position


def stands(
    network: Network, plan: Plan, times: Floats, order: NumberOrder
) -> Iterator[tuple[EquilibriumStage, bool]]:
    """Yield the equilibria up to the last of some times, and whether each is at one of them.

    Springs that are overloaded there break, and a new equilibrium is found.

    Args:
        network: With all its numbers.
        plan: The plan of the experiment.
        times: In the script [s], ascending, each once, shape (time,).

    Raises:
        Unbalanced: There is no equilibrium.
    """
    state = plan.start(network)
    state.velocity[:] = 0.0
    queue = ActionQueue.of(plan)
    changes: dict[str, ArrayChange] = {}
    everything = np.ones(network.node_count, dtype=bool)
    before = state.position.copy()

    def stand(chosen: NDArray[np.bool_]) -> EquilibriumStage:
        nonlocal before
        state.let_leak()
        found = _stand(state, chosen, changes, before, order)
        before = state.position.copy()
        return found

    waiting = times.tolist()
    while waiting:
        state.time = min(queue.next, waiting[0])
        state.place_held()
        is_settled = state.time <= 0.0
        for action in queue.due(state.time):
            if isinstance(action, Settle):
                yield stand(action.chosen(state)), False
                continue
            if not is_settled and not isinstance(action, EndMotion):
                yield stand(everything), False
                is_settled = True
            note(action, changes, state)
            action.apply(state, queue)
            state.place_held()
        if waiting[0] <= state.time + queue.near:
            waiting.pop(0)
            yield stand(everything), True


def _stand(
    state: State,
    chosen: NDArray[np.bool_],
    changes: dict[str, ArrayChange],
    before: Floats,
    order: NumberOrder,
) -> EquilibriumStage:
    """Bring a state to rest; return its equilibrium."""
    held = state.held
    way = np.where(held[:, None], state.position - before, 0.0)
    remarks = _settle(state, chosen)
    while len(broken := overloaded(state)):
        state.break_springs(broken)
        state.let_leak()
        remarks = _settle(state, chosen)
    reached = np.zeros_like(held)
    reached[state.springs.ends[state.alive]] = True
    for field in state.fields:
        reached |= field.touched(state.position)
    leg = leg_of(state, state.time, changes, order, remembers=False)
    free = np.flatnonzero(chosen & ~held & reached)
    return EquilibriumStage(leg, free, chosen, way, state.position.copy(), remarks)


def _settle(
    state: State, chosen: NDArray[np.bool_], guess: Floats | None = None
) -> tuple[Remark, ...]:
    try:
        return settle(state, chosen, guess)
    except Unsettled as failure:
        node = state.network.node_ids[failure.node]
        when = show(state.time, TIME)
        message = f"at {when} of the script, {failure.message}, mainly at node {node}"
        raise Unbalanced(state.time, message) from failure
    except np.linalg.LinAlgError as failure:
        when = show(state.time, TIME)
        message = f"at {when} of the script, the forces of the net are not finite"
        raise Unbalanced(state.time, message) from failure


SOUND = 1e-12  # of the largest pivot: what is smaller is rounding
SHIFT = 1e-8  # of the largest entry of K, where K is singular
TURNS = 8  # of refinement then
LEFT = 1e-6  # of the largest force: what may be left of those that a singular K bears
ROUNDING = 1e-12  # of the stiffest spring over the size of the net


class UnresistedMotion(Exception):
    """Forces act along a motion that nothing resists; the number of a free node is given."""


class StaticResponse:
    """K of the free nodes of a net, factorised.

    Args:
        by_x: ∂a/∂x of all nodes but for large volumes [1/s²], shape (3 node, 3 node).
        wide: What these add to K is this times its transpose [(N/m)^½], shape (3 node, column).
        mass: Of all nodes [kg], shape (node,).
        free: Nodes that move, shape (free,).
        size: Of the net [m].

    Attributes:
        sound: Whether every motion is resisted.
    """

    def __init__(
        self,
        by_x: sparse.csr_matrix,
        wide: Floats,
        mass: Floats,
        free: Indices,
        size: float,
    ):
        self.entries = (3 * free[:, None] + np.arange(3)).ravel()
        self.weights = np.repeat(mass[free], 3)
        inner = by_x[self.entries][:, self.entries]
        matrix = sparse.csc_matrix(-sparse.diags(self.weights) @ inner)
        self.matrix = Stiffness(matrix, wide[self.entries])
        wide = self.matrix.wide
        top = float(np.abs(self.matrix.diagonal()).max(initial=0.0))
        self._noise = ROUNDING * top * size
        self.sound = False
        try:
            self._factor = LowRankFactor(matrix, wide, wide)
            self.sound = self._factor.soundness > SOUND
        except RuntimeError:  # singular
            pass
        if not self.sound:
            one = sparse.identity(len(self.entries), format="csc")
            shifted = sparse.csc_matrix(matrix + (SHIFT * top or 1.0) * one)
            self._factor = LowRankFactor(shifted, wide, wide)

    def moved(self, force: Floats) -> Floats:
        """Return the displacements of free nodes [m] by forces [N], shape (3 free, change).

        Raises:
            UnresistedMotion: Nothing resists these forces.
        """
        found = self._factor.solve(force)
        if self.sound:
            return found
        for _ in range(TURNS):
            found += self._factor.solve(force - self.matrix(found))
        left = np.abs(force - self.matrix(found)).max(axis=1, initial=0.0)
        if left.max(initial=0.0) > LEFT * np.abs(force).max(initial=0.0) + self._noise:
            raise UnresistedMotion(int(np.argmax(left)) // 3)
        return found


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
        """Forget the way from where it first turns back, and end it right there."""
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
