"""``change``: another gravity, another tissue, another velocity."""

from functools import partial
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.errors import counted
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import Dimension
from tissuec.mechanics.state import State
from tissuec.model.inelastic import CONSTANTS, LIMIT, NAMES, PAIRS, TIMES, VISCOSITY
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    SET,
    SPRINGS,
    Amount,
    Cases,
    Chosen,
    EitherClause,
    NumberClause,
    SubjectPart,
    VectorClause,
    factor,
)
from tissuec.script.verbs import VERBS, Action, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.holding import sentence


class ChangeableArray(NamedTuple):
    """A parameter array of a state that can be changed."""

    array: str  # of a state, or one of what its springs remember
    dimension: Dimension
    may_be_zero: bool


PARAMETERS = {
    "spring constant": ChangeableArray("stiffness", units.STIFFNESS, True),
    "viscosity": ChangeableArray("damping", units.VISCOSITY, True),
    "breaking force": ChangeableArray("strength", units.FORCE, False),
    "crushing force": ChangeableArray("crush", units.FORCE, False),
    "rest length": ChangeableArray("rest", units.LENGTH, True),
    "mass": ChangeableArray("mass", units.MASS, False),
    **{
        name: parameter
        for constant, time in zip(CONSTANTS, TIMES, strict=True)
        for name, parameter in (
            (constant, ChangeableArray(constant, units.STIFFNESS, True)),
            (time, ChangeableArray(time, units.TIME, False)),
        )
    },
    LIMIT: ChangeableArray(LIMIT, units.FORCE, True),
    VISCOSITY: ChangeableArray(VISCOSITY, units.VISCOSITY, False),
}


class ChangeParameter(Struct, frozen=True):
    """A number for every spring or node of a group, or a factor on present numbers."""

    array: str
    group: Group
    number: float  # in SI units
    is_factor: bool
    span: Span

    def flaw(self, network: Network) -> str:
        if self.array == "mass":
            return ""
        name = next(name for name, one in PARAMETERS.items() if one.array == self.array)
        return _without_springs(self.group, network, name)

    def chosen(self, network: Network) -> Indices:
        """Return the nodes or springs that change, shape (n,)."""
        every = self.group.indices
        return every if self.array == "mass" else network.springs_among(every)

    def breakable(self, network: Network) -> Indices:
        """Return the springs that get a breaking or a crushing force, shape (n,)."""
        sets = self.array in ("strength", "crush") and not self.is_factor
        return self.chosen(network) if sets else self.group.indices[:0]

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        chosen = self.chosen(state.network)
        if self.array == "mass":
            state.mass = state.mass.copy()  # it may be the network's own
            state.mass[chosen] = _numbers(self, state.mass[chosen])
        else:
            if self.array == "rest":
                state.stop_reeling(chosen)
            values = _numbers(self, getattr(state.springs, self.array)[chosen])
            state.springs = state.springs.changed(self.array, chosen, values)
        return (_changed(self.span),)


class ChangeMemory(Struct, frozen=True):
    """The same of what springs relax or flow by."""

    name: str
    group: Group
    number: float  # in SI units
    is_factor: bool
    span: Span

    def flaw(self, network: Network) -> str:
        inelastic = network.springs.inelastic
        if text := _without_springs(self.group, network, self.name):
            return text
        springs = network.springs_among(self.group.indices)
        having = 0 if inelastic is None else int(inelastic.has(self.name)[springs].sum())
        if having == len(springs):
            return ""
        first, second = next(pair for pair in PAIRS if self.name in pair)
        without = len(springs) - having
        return (
            f"{counted(without, 'spring')} of {self.group.name} "
            f"{'has' if without == 1 else 'have'} no {first} and {second} at the start; "
            f'to change them later, write "{first} is none" and a {second} in the tissue'
        )

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        memory = state.springs.inelastic
        assert memory is not None  # see ``flaw``
        springs = state.network.springs_among(self.group.indices)
        inelastic = memory.changed(self.name, springs, partial(_numbers, self))
        state.springs = replace(state.springs, inelastic=inelastic)
        return (_changed(self.span),)


def _without_springs(group: Group, network: Network, name: str) -> str:
    """Return that a group consists of edges of elements; "" if it does not.

    Args:
        name: Of what is to change.
    """
    lines = group.indices
    if not len(lines) or len(network.springs_among(lines)):
        return ""
    return (
        f"{group.name} consists of elements; their edges have no {name}, so that this changes "
        "nothing"
    )


def _numbers(change: ChangeParameter | ChangeMemory, values: Floats) -> Floats | float:
    """The numbers that replace present ones, shape (n,), or one for all."""
    return values * change.number if change.is_factor else change.number


class ChangeSurroundings(Struct, frozen=True):
    """Another gravity [m/s²], shape (3,), or another ambient damping [N s/m]."""

    gravity: Floats | None
    drag: float | None
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if self.gravity is not None:
            state.gravity = self.gravity
            for fluid in state.of_kind("fluid"):
                state.put(replace(fluid, gravity=self.gravity).block)
        if self.drag is not None:
            state.drag = self.drag
        return (_changed(self.span),)


class ChangeMotion(Struct, frozen=True):
    """Another velocity [m/s] or angular velocity [rad/s], shape (3,), of free nodes."""

    group: Group
    vector: Floats
    is_spin: bool
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        nodes = self.group.indices
        velocity = self._spinning(state) if self.is_spin else self.vector
        state.velocity[nodes] = velocity
        state.place_held()
        return (_changed(self.span),)

    def _spinning(self, state: State) -> Floats:
        """Return v = v_c + ω × (x - x_c) about the centre of mass c, shape (node, 3)."""
        nodes = self.group.indices
        share = state.mass[nodes] / state.mass[nodes].sum()
        arm = state.position[nodes] - share @ state.position[nodes]
        return share @ state.velocity[nodes] + np.cross(self.vector, arm)


# --- sentences ----------------------------------------------------------------------------

_DIMENSIONS = {name: one.dimension for name, one in PARAMETERS.items()}
OfNodes = Annotated[Group, SubjectPart("nodes", (SET,), "of")]
OfSprings = Annotated[Group, SubjectPart("springs", (SPRINGS,), "of")]


def _to_or_by(sign: Literal["positive", "not negative"]) -> EitherClause:
    to = NumberClause("to", _DIMENSIONS, sign, what="new value", place="NUMBER")
    return EitherClause((to, factor("by", sign)))


def _to_vector(dimension: Dimension, example: str) -> VectorClause:
    return VectorClause("to", dimension, what="new value", place="VECTOR", example=example)


class ChangeOfSprings(VerbSentence, frozen=True):
    """Another parameter of each spring of a set or body, which may be zero."""

    what: Chosen
    group: OfSprings
    value: Annotated[Amount, _to_or_by("not negative")]

    def action(self, order: Order) -> Action:
        parameter, is_factor = PARAMETERS[self.what], self.value.word == "by"
        kind = ChangeMemory if parameter.array in NAMES else ChangeParameter
        return kind(parameter.array, self.group, self.value.number, is_factor, self.span)


class ChangeOfSpringsAboveZero(ChangeOfSprings, frozen=True):
    """Another parameter of each spring, which cannot be zero."""

    value: Annotated[Amount, _to_or_by("positive")]


class ChangeOfNodes(ChangeOfSpringsAboveZero, frozen=True):
    """Another mass of each node of a set or body."""

    group: OfNodes


class ChangeGravity(VerbSentence, frozen=True):
    """Another gravity [m/s²]."""

    to: Annotated[Floats, _to_vector(units.ACCELERATION, "to (0, 0, -9.81) m/s^2")]

    def action(self, order: Order) -> Action:
        return ChangeSurroundings(self.to, None, self.span)


class ChangeDamping(VerbSentence, frozen=True):
    """Another ambient damping [N s/m]."""

    to: Annotated[
        float,
        NumberClause(
            "to",
            units.VISCOSITY,
            "not negative",
            what="new value",
            place="NUMBER",
            example="to 1 mN*s/m",
        ),
    ]

    def action(self, order: Order) -> Action:
        return ChangeSurroundings(None, self.to, self.span)


class ChangeVelocity(VerbSentence, frozen=True):
    """Another velocity [m/s] of nodes."""

    group: OfNodes
    to: Annotated[Floats, _to_vector(units.VELOCITY, "to (0, 0, 1) mm/s")]

    def action(self, order: Order) -> Action:
        return ChangeMotion(self.group, self.to, False, self.span)


class ChangeSpin(VerbSentence, frozen=True):
    """Another angular velocity [rad/s] of nodes."""

    group: OfNodes
    to: Annotated[Floats, _to_vector(units.FREQUENCY, "to (0, 0, 90) deg/s")]

    def action(self, order: Order) -> Action:
        return ChangeMotion(self.group, self.to, True, self.span)


def _form_of(name: str) -> type[VerbSentence]:
    """Return the class of sentences for a parameter."""
    if name == "mass":
        return ChangeOfNodes
    return ChangeOfSprings if PARAMETERS[name].may_be_zero else ChangeOfSpringsAboveZero


_OWN: dict[str, type[VerbSentence]] = {
    "gravity": ChangeGravity,
    "damping": ChangeDamping,
    "velocity": ChangeVelocity,
    "spin": ChangeSpin,
}


@VERBS.member("change")
class Change:
    """Gives something a new value from this time on.

    ``gravity`` and ``damping`` are those of the environment. ``spring constant``,
    ``viscosity``, ``breaking force``, ``crushing force`` and ``rest length`` apply to each
    spring of a set or body, as do the quantities by which springs relax or yield if the springs
    started with them. ``mass`` applies to each node. ``by FACTOR`` multiplies the present
    values. ``velocity`` and ``spin`` apply to free nodes: a velocity is the same for all of
    them; a spin turns them about their centre of mass, whose velocity does not change.
    """

    meant: ClassVar[str] = "set modify soften stiffen"
    cases: ClassVar = Cases(
        "",
        {**_OWN, **{name: _form_of(name) for name in PARAMETERS}},
        '"{}" cannot be changed',
        shown=(*_OWN, *(n for n in PARAMETERS if n not in (*CONSTANTS[1:], *TIMES[1:]))),
        what="quantity to change",
    )


def _changed(span: Span) -> LoggedEvent:
    return LoggedEvent("change", (), sentence(span), span)
