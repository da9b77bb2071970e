"""What acts in a state, as tables that kernels read: springs, motions and loads.

A spring that dies is first set to zero in place, which leaves every sum as if it were gone; the
springs are chosen anew when many have died.
"""

from collections.abc import Iterable, Sequence
from math import inf
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.engine.integrators import Integrator
from tissuec.engine.layout import Layout
from tissuec.engine.spring_runs import RunPlaces, packed, places_of
from tissuec.engine.threads import chunks_of
from tissuec.forces.acting.load import Load, LoadTerm
from tissuec.kernels.records import BoundaryConditions, Chunks, Runs
from tissuec.laws import Law
from tissuec.mechanics.state import PrescribedMotion, State
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile, tabulated
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
        """Take a layout with other rows of bristles, which leaves those of springs in place."""
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
    acting = state.alive_springs & ~join_nodes_of(ends, held)
    if moved.any():
        # Driven nodes feel them, even if no output needs it: steps must not depend on that.
        one, other = moved[ends.T]
        acting |= state.alive_springs & (one | other)
    if state.springs.inelastic is not None:
        acting |= state.alive_springs & state.springs.inelastic.remembers
    # Drawing them in does work on them, even where both ends are held.
    for reeling in state.reelings.values():
        acting[reeling.springs] = state.alive_springs[reeling.springs]
    return acting


LOOKS = 32  # samples at least of a period of a path or force, or of a full turn, or of a ramp


def lengths(state: State) -> list[Load]:
    """Return how lengths of threads change, as loads on no node, to be evaluated as these."""
    along, none = np.array([1.0, 0.0, 0.0]), np.zeros(0, dtype=np.int64)
    return [
        Load(none, (LoadTerm(along, reeling.profile),), reeling.span)
        for reeling in state.reelings.values()
    ]


def knots(motions: Iterable[PrescribedMotion], profiles: Iterable[TimeProfile]) -> Floats:
    """Return the times at which a profile changes its curve [s], ascending, shape (knot,).

    Args:
        profiles: All profiles except those of motions.
    """
    found = [*profiles, *(term.profile for motion in motions for term in motion.shifts)]
    found += [motion.turn.profile for motion in motions if motion.turn is not None]
    return np.array(sorted({knot for profile in found for knot in profile.knots.tolist()}))


def longest_step(
    motions: Iterable[PrescribedMotion],
    profiles: Iterable[TimeProfile],
    start: float,
    until: float,
    looks: int,
) -> float:
    """Return the largest step that follows prescribed motions in an interval of time [s].

    No error estimate sees a path that no free node feels; springs between driven and held nodes
    would break unnoticed, or in another period. Nor does one see a force that is sampled once
    in each of its periods.

    Args:
        motions: All of them.
        profiles: Of all else.
        start, until: The stretch, without knots inside [s].
        looks: How often a step is looked into.
    """
    middle = start + 0.5 * (until - start)
    longest = inf
    for profile in profiles:
        longest = min(longest, _feature(profile, middle))
    for motion in motions:
        for term in motion.shifts:
            longest = min(longest, _feature(term.profile, middle))
        turn = motion.turn
        if turn is not None:
            longest = min(longest, _feature(turn.profile, middle))
            if turn.angle and (fastest := _fastest(turn.profile, start, until)) > 0.0:
                longest = min(longest, 2.0 * np.pi / (fastest * abs(turn.angle)))
    return float(longest) * looks / LOOKS


def _feature(profile: TimeProfile, time: float) -> float:
    """Return the length of the shortest feature of a profile at a time [s]."""
    if profile.start < time < profile.stop:
        if profile.kind == "sine" and profile.frequency:
            return 1.0 / abs(profile.frequency)
        if profile.kind in ("ramp", "smooth"):
            return profile.stop - profile.start
    return inf


def _fastest(profile: TimeProfile, start: float, until: float) -> float:
    """Return about the largest rate of a profile within a stretch [1/s]."""
    if profile.kind == "sine":
        return 2.0 * np.pi * abs(profile.frequency)
    inside = start + (until - start) * np.linspace(0.0, 1.0, LOOKS + 1)[1:-1]
    return max(abs(profile.at(float(time))[1]) for time in inside)


def pack_acts(
    motions: Sequence[PrescribedMotion],
    loads: Sequence[Load],
    place: Indices,
    start: float,
    until: float,
) -> BoundaryConditions:
    """Return motions and loads as tables for a stretch of time without knots inside.

    A velocity that jumps at an end of the stretch is the one within the stretch.

    Args:
        motions, loads: In the order in which they are applied.
        place: Where the engine keeps each node, shape (node,).
        start, until: The stretch [s].
    """
    count = len(motions) + len(loads)
    profiles: list[TimeProfile] = []
    terms: list[tuple[LoadTerm, ...]] = []
    turn_curve = np.full(count, -1)
    turn_centre, turn_axis = np.zeros((count, 3)), np.zeros((count, 3))
    turn_angle = np.zeros(count)
    for act, motion in enumerate(motions):
        terms.append(motion.shifts)
        if motion.turn is not None:
            turn_curve[act] = len(profiles)
            profiles.append(motion.turn.profile)
            turn_centre[act], turn_axis[act] = motion.turn.centre, motion.turn.axis
            turn_angle[act] = motion.turn.angle
    terms += [load.terms for load in loads]
    flat = [term for group in terms for term in group]
    nodes = [act.nodes for act in (*motions, *loads)]
    base = [motion.base for motion in motions] + [
        np.zeros((len(load.nodes), 3)) for load in loads
    ]
    shares = [np.ones(len(motion.nodes)) for motion in motions]
    shares += [load.factors for load in loads]
    term_curve = len(profiles) + np.arange(len(flat))
    return BoundaryConditions(
        motions=len(motions),
        first=_offsets([len(group) for group in nodes]),
        nodes=place[np.concatenate([*nodes, np.zeros(0, dtype=np.int64)])],
        base=np.concatenate([*base, np.zeros((0, 3))]),
        share=np.concatenate([*shares, np.zeros(0)]),
        partial=np.array([a.change is not None for a in motions] + [False] * len(loads), int),
        along=_changes(motions),
        term_first=_offsets([len(group) for group in terms]),
        term_vector=np.array([term.vector for term in flat], dtype=float).reshape(-1, 3),
        term_curve=term_curve,
        turn_curve=turn_curve,
        turn_centre=turn_centre,
        turn_axis=turn_axis,
        turn_angle=turn_angle,
        **tabulated([*profiles, *(term.profile for term in flat)], start, until),
    )


def _changes(motions: Sequence[PrescribedMotion]) -> Floats:
    """Return by what missing vectors change positions, row by row, shape (entry, 9).

    It is empty if all motions are in all directions.
    """
    if all(motion.change is None for motion in motions):
        return np.zeros((0, 9))
    none = ((len(motion.nodes), 9) for motion in motions)
    return np.concatenate([
        np.zeros(shape) if motion.change is None else motion.change.reshape(shape)
        for motion, shape in zip(motions, none, strict=True)
    ])  # fmt: skip


def _offsets(sizes: Sequence[int]) -> Indices:
    """Return where each group begins and, last, where all end."""
    return np.concatenate([[0], np.cumsum(np.array(sizes, dtype=np.int64))]).astype(np.int64)
