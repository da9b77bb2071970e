"""The equilibria of a net along its script, and their response to forces and displacements.

The net is brought to rest at each observed time. Before an event, too, because what
is taken hold of stays where it is then, and blades cut what is there.

With a the accelerations and M the masses, K = -M ∂a/∂x is symmetric, and what changes the
forces on free nodes by F changes their places by K⁻¹ F. A net that could move somehow without
any force has no K⁻¹. Where forces do no work along such a motion, how it gives way to them is
known all the same, and nothing moves along it.
"""

from collections.abc import Iterator

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy import sparse

from tissuec.core.arrays import unknowns
from tissuec.core.structs import replace
from tissuec.core.units import TIME, show
from tissuec.engine.execution.event_queue import ActionQueue
from tissuec.engine.failures import overloaded
from tissuec.learn.derivatives.event_recording import note
from tissuec.learn.derivatives.event_schedule import ArrayChange, Leg, leg_of
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.parameters.numbers import NETWORK, NumberOrder
from tissuec.mechanics.settling import Remark, Unsettled, settle
from tissuec.mechanics.state import State
from tissuec.mechanics.stiffness import LowRankFactor, SparseFactor, Stiffness
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

    def balanced(self, network: Network, vector: Floats, before: Floats) -> Floats:
        """Return the places in equilibrium [m], shape (node, 3).

        Args:
            network: With numbers in its laws.
            vector: All numbers in SI units, shape (number,).
            before: Places in the stand before [m], shape (node, 3).

        Raises:
            Unbalanced: There are none.
        """
        leg = self.leg
        state = State.start(network, gravity=leg.gravity, drag=0.0)
        state.time, state.alive = leg.start, leg.is_alive
        numbers = leg.changed(vector)
        changed = {name: leg.order.array(numbers, name) for name in NETWORK}
        state.mass = changed.pop("mass")[: network.node_count]
        state.springs = replace(state.springs, **changed)
        state.holders = dict(leg.holders)
        state.loads = {str(number): load for number, load in enumerate(leg.loads)}
        _, fields = leg.acting.with_numbers(leg.present(vector))
        state.blocks = {
            name: FieldBlock(name, "", field, None) for name, field in fields.items()
        }
        state.guides = leg.guides
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
        state.break_entities(broken)
        state.let_leak()
        remarks = _settle(state, chosen)
    reached = np.zeros_like(held)
    reached[state.network.line_ends[state.alive_lines]] = True
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
        self.entries = unknowns(free)
        self.weights = np.repeat(mass[free], 3)
        inner = by_x[self.entries][:, self.entries]
        matrix = sparse.csc_matrix(-sparse.diags(self.weights) @ inner)
        self.matrix = Stiffness(matrix, wide[self.entries])
        wide = self.matrix.wide
        top = float(np.abs(self.matrix.diagonal()).max(initial=0.0))
        self._noise = ROUNDING * top * size
        self.sound = False
        try:
            factor = SparseFactor(matrix)
            self._factor = LowRankFactor(factor, wide, wide)
            self.sound = factor.soundness > SOUND
        except RuntimeError:  # singular
            pass
        if not self.sound:
            one = sparse.identity(len(self.entries), format="csc")
            shifted = sparse.csc_matrix(matrix + (SHIFT * top or 1.0) * one)
            self._factor = LowRankFactor(SparseFactor(shifted), wide, wide)

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
