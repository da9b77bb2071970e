"""The springs that act in a state, by places of nodes, as the stepping code takes them.

A spring that dies is first set to zero in place, which leaves every sum as if it were gone; the
springs are chosen anew when many have died.
"""

from typing import Any, cast

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.engine.chunks import chunks_of
from tissuec.engine.integrators import Integrator
from tissuec.engine.layout import Layout
from tissuec.engine.spring_runs import RunPlaces, packed, places_of
from tissuec.kernels.records import Chunks, Runs
from tissuec.laws import Law
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices
from tissuec.model.springs import Springs
from tissuec.model.topology import join_nodes_of

Bools = NDArray[np.bool_]
LEAST = 1e-300  # [m]


class ActingSprings:
    """Chooses springs and keeps what belongs to a choice.

    Args:
        layout: Of the network.
        watched: Whether springs may break.
        ledger: Whether work and dissipation are integrated.

    Attributes:
        springs: Those that act, sorted by lower and then by upper place; ids are numbers in the
            network. Dead ones have no stiffness and viscosity and no limits; limits are of
            shape (0,) where none may break.
        is_viscous: Whether some have dashpots.
        has_corners: Whether the force of some has corners.
        is_crushed: Whether some break under pressure.
        laws: The linear one and others; none where all are linear.
    """

    springs: Springs
    is_viscous: bool
    has_corners: bool
    is_crushed: bool
    laws: tuple[Law, ...]

    def __init__(self, layout: Layout, *, watched: bool, ledger: bool):
        self._layout, self._watched, self._ledger = layout, watched, ledger
        self._acting: Bools | None = None
        self._dead = 0
        # Of all springs, for the first choice of those that act.
        self._all_runs = layout.runs
        self._runs: RunPlaces | None = None  # once they are needed
        self._chunks: Chunks | None = None  # the same

    def update(self, state: State, held: Bools, moved: Bools) -> None:
        """Choose the springs that act in a state, and copy their present numbers.

        Args:
            state: The state.
            held: Nodes that are held or driven, shape (node,).
            moved: Nodes on prescribed paths, shape (node,).
        """
        acting = _acting(state, held, moved)
        self._choose(acting, state)
        self.springs = springs = self._present(state.springs, acting)
        # Kept, because the stepping code needs them at every call.
        behaviour, inelastic = springs.behaviour, springs.inelastic
        self.is_viscous = behaviour.is_viscous
        self.laws = springs.laws if springs.law.any() else ()
        yields = inelastic is not None and bool(np.isfinite(inelastic.limit).any())
        self.has_corners = yields or behaviour.has_corners
        self.is_crushed = self._watched and bool(np.isfinite(springs.crush).any())

    def _choose(self, acting: Bools, state: State) -> None:
        """Choose the springs anew if some act that did not, or many have died."""
        before = self._acting
        grown = before is None or bool(np.any(acting & ~before))
        if before is not None:
            self._dead += int(np.count_nonzero(before & ~acting))
        # Sums of energies would be grouped otherwise than in a run that is resumed.
        few = 0 if self._ledger else len(acting) // 20
        if grown or self._dead > few:
            among = self._layout.springs
            ids = np.flatnonzero(acting) if among is None else among[acting[among]]
            self._ids = ids.astype(np.int32)
            ends = self._layout.ends_of(state.springs.ends.take(self._ids, axis=0))
            # Whose columns are contiguous.
            self._ends = np.stack(ends).astype(np.int32, copy=False).T
            self._runs = self._chunks = None
            if self._all_runs is not None and len(acting) - len(ids) <= few:
                self._runs = replace(self._all_runs, place=self._all_runs.place[ids])
            self._all_runs, self._dead = None, 0
        self._acting = acting

    def _present(self, springs: Springs, acting: Bools) -> Springs:
        """Return the present numbers of the springs that were chosen."""
        ids, alive = self._ids, acting[self._ids]
        all_act = bool(alive.all())
        in_order = self._layout.springs is None and len(ids) == len(acting)

        def present(values: NDArray[Any], dead: float) -> NDArray[Any]:
            """Return numbers of the springs; no copies of what takes no room, or is there."""
            if not all_act:
                return np.where(alive, values[ids], values.dtype.type(dead))
            if values.strides == (0,):
                return np.broadcast_to(values[:1], ids.shape)
            return values if in_order else values[ids]

        stiffness, law = present(springs.stiffness, 0.0), present(springs.law, 0)
        jumps = (stiffness > 0.0) | (law > 0)
        rest = springs.rest if in_order else springs.rest[ids]
        inelastic = springs.inelastic
        if inelastic is not None:
            inelastic = inelastic.some(ids).only(alive).renumbered(self._layout.place)
            # What flows or relaxes pulls at no length, too, and jumps as it turns over.
            rest, jumps = np.maximum(rest, LEAST), jumps | (inelastic.remembers & alive)
        return Springs(
            ends=self._ends,
            stiffness=stiffness,
            damping=present(springs.damping, 0.0),
            # Without a force that could jump, it does not matter when one turns over.
            rest=np.ascontiguousarray(rest) if jumps.all() else np.where(jumps, rest, 0.0),
            strength=present(springs.strength, np.inf) if self._watched else np.zeros(0),
            crush=present(springs.crush, np.inf) if self._watched else np.zeros(0),
            law=law,
            laws=springs.laws,
            ids=cast(Indices, ids),
            inelastic=inelastic,
        )

    def move_to(self, layout: Layout) -> None:
        """Take a layout with other hidden nodes, which leaves those of springs in place."""
        self._layout, self._chunks = layout, None

    @property
    def places(self) -> RunPlaces:
        """Return the places of springs in runs."""
        if self._runs is None:
            self._runs = places_of(self._ends[:, 0], self._ends[:, 1])
        return self._runs

    def near(self, integrator: type[Integrator]) -> dict[str, Floats]:
        """Return the tension and the pressure above which springs are tested closely [N].

        Both have the shape (spring,).
        """
        part, springs = integrator.nearness, self.springs
        if not self._watched:
            # There is one form of the code for springs with laws, which examines these as well.
            straight = not self.laws and springs.inelastic is None
            count = 0 if straight else len(springs.ids)
            return dict.fromkeys(("near", "near_crush"), np.full(count, np.inf))
        return {"near": part * springs.strength, "near_crush": part * springs.crush}

    def chunks(self) -> Chunks:
        """Return chunks of nodes, for springs that are not taken in runs."""
        if self._chunks is None:
            low, high = self._ends.T
            order, place = self._layout.order, self._layout.place
            self._chunks = chunks_of(low, high, len(order), len(place))
        return self._chunks

    def runs(self, near: dict[str, Floats], parts: int) -> Runs:
        """Return springs in runs.

        Args:
            near: Limits [N] as returned by ``near``, shape (spring,).
            parts: Parts of loops, which threads share.
        """
        springs = self.springs
        return packed(
            self.places,
            len(self._layout.order),
            parts,
            stiffness=springs.stiffness,
            damping=springs.damping if self.is_viscous else None,
            rest=springs.rest,
            **(near if self._watched else dict.fromkeys(near)),
        )


def _acting(state: State, held: Bools, moved: Bools) -> Bools:
    """Return which springs act on a free node, or matter otherwise, shape (spring,)."""
    ends = state.springs.ends
    acting = state.alive & ~join_nodes_of(ends, held)
    acting[state.network.first_mark :] = False
    if moved.any():
        # Driven nodes feel them, even if no output needs it: steps must not depend on that.
        one, other = moved[ends.T]
        acting |= state.alive & (one | other)
        acting[state.network.first_mark :] = False
    if state.springs.inelastic is not None:
        acting |= state.alive & state.springs.inelastic.remembers
    # Drawing them in does work on them, even where both ends are held.
    for reeling in state.reelings.values():
        acting[reeling.springs] = state.alive[reeling.springs]
    return acting
