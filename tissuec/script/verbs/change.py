"""``change``: another gravity, another tissue, another velocity."""

from collections.abc import Callable
from functools import partial
from typing import ClassVar, NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.core import units
from tissuec.core.errors import counted
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.units import Dimension
from tissuec.mechanics.state import State
from tissuec.model.inelastic import CONSTANTS, LIMIT, NAMES, PAIRS, TIMES, VISCOSITY
from tissuec.model.network import Floats, Indices, Network
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
        springs = self.group.indices
        if self.array == "mass" or not len(springs) or not network.edges[springs].all():
            return ""
        name = next(name for name, one in PARAMETERS.items() if one.array == self.array)
        return (
            f"{self.group.name} consists of elements; their edges have no {name}, so that "
            "this changes nothing"
        )

    def breakable(self, network: Network) -> Indices:
        """Return the springs that get a breaking or a crushing force, shape (n,)."""
        sets = self.array in ("strength", "crush") and not self.is_factor
        return self.group.indices if sets else self.group.indices[:0]

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        chosen = self.group.indices
        if self.array == "rest":
            state.stop_reeling(chosen)
        if self.array == "mass":
            state.mass = state.mass.copy()  # it may be the network's own
            state.mass[chosen] = _numbers(self, state.mass[chosen])
        else:
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
        inelastic, springs = network.springs.inelastic, self.group.indices
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
        inelastic = memory.changed(self.name, self.group.indices, partial(_numbers, self))
        state.springs = replace(state.springs, inelastic=inelastic)
        return (_changed(self.span),)


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

    forms: ClassVar[tuple[str, ...]] = (
        "change gravity to VECTOR",
        "change damping to NUMBER",
        "change spring constant of SET to NUMBER",
        "change viscosity of SET by FACTOR",
        "change velocity of SET to VECTOR",
        "change spin of SET to VECTOR",
    )

    @classmethod
    def read(cls, order: Order) -> Action:
        what = key_of(order.words)
        if what in PARAMETERS:
            return _read_parameter(order, PARAMETERS[what])
        if what not in _READERS:
            known = [name for name in PARAMETERS if name not in (*CONSTANTS[1:], *TIMES[1:])]
            hint = alternatives(what, (*_READERS, *known), what="it can be")
            order.reject("TIS305", f'"{what}" cannot be changed', hint=hint)
        return _READERS[what](order)


def _read_parameter(order: Order, parameter: ChangeableArray) -> Action:
    if order.has("to") == order.has("by"):
        order.reject(
            "TIS306" if order.has("to") else "TIS304",
            f'"change {order.words}" needs either a new value or a factor',
            hint="remove one of them"
            if order.has("to")
            else "add to and a value, or by and a factor such as 50 %",
        )
    word, is_factor = ("by", True) if order.has("by") else ("to", False)
    number = order.number(word, units.NUMBER if is_factor else parameter.dimension)
    _refuse_size(order, word, number, may_be_zero=parameter.may_be_zero)
    group = order.nodes_of("of") if parameter.array == "mass" else order.springs_of("of")
    kind = ChangeMemory if parameter.array in NAMES else ChangeParameter
    return kind(parameter.array, group, number, is_factor, order.span)


def _read_gravity(order: Order) -> Action:
    return ChangeSurroundings(order.vector("to", units.ACCELERATION), None, order.span)


def _read_damping(order: Order) -> Action:
    drag = order.number("to", units.VISCOSITY)
    _refuse_size(order, "to", drag, may_be_zero=True)
    return ChangeSurroundings(None, drag, order.span)


def _read_velocity(order: Order) -> Action:
    velocity = order.vector("to", units.VELOCITY)
    return ChangeMotion(order.nodes_of("of"), velocity, False, order.span)


def _read_spin(order: Order) -> Action:
    spin = order.vector("to", units.FREQUENCY)
    return ChangeMotion(order.nodes_of("of"), spin, True, order.span)


_READERS: dict[str, Callable[[Order], Action]] = {
    "gravity": _read_gravity,
    "damping": _read_damping,
    "velocity": _read_velocity,
    "spin": _read_spin,
}


def _refuse_size(order: Order, word: str, number: float, *, may_be_zero: bool) -> None:
    if number > 0.0 or (may_be_zero and number == 0.0):
        return
    limit = "0 or more" if may_be_zero else "more than 0"
    order.reject("TIS308", f"{order.words} must be {limit}", word=word)


def _changed(span: Span) -> LoggedEvent:
    return LoggedEvent("change", (), sentence(span), span)
