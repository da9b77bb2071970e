"""What is true at one moment of a run: the state, and everything that the script has switched.

The engine and the reference both step a ``Situation`` from event to event; events change it
between steps. Arrays stand in the order of the network.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tissuec.contact import Contact
from tissuec.core.source import Span
from tissuec.courses import Course
from tissuec.enclosures import Enclosure
from tissuec.jets import Jet
from tissuec.laws.evaluation import Behaviour
from tissuec.network import Floats, Indices, Network


@dataclass(frozen=True, slots=True, eq=False)
class Term:
    """One vector times one course: a displacement [m] or a force [N]."""

    vector: Floats  # shape (3,)
    course: Course


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """A rotation about a fixed axis by ``angle`` times a course."""

    centre: Floats  # [m], shape (3,)
    axis: Floats  # unit vector, shape (3,)
    angle: float  # [rad]
    course: Course

    def apply(self, base: Floats, time: float) -> tuple[Floats, Floats]:
        """Return the turned points and their velocities, each of shape (point, 3).

        Rodrigues' formula: R r = r cos θ + (n × r) sin θ + n (n·r)(1 - cos θ).
        """
        factor, rate = self.course.at(time)
        theta = self.angle * factor
        arm = base - self.centre
        along = np.outer(arm @ self.axis, self.axis)
        turned = (
            along + (arm - along) * np.cos(theta) + np.cross(self.axis, arm) * np.sin(theta)
        )
        velocity = np.asarray(np.cross(self.axis, turned), dtype=float) * self.angle * rate
        return self.centre + turned, velocity


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A prescribed path of some nodes.

    x(t) = centre + R(t) (base - centre) + Σ vectorᵢ sᵢ(t), with R = 1 where ``turn`` is None.

    Attributes:
        nodes: The driven nodes, shape (driven,).
        base: Their positions where every course is zero [m], shape (driven, 3).
        shifts: Translations.
        turn: At most one rotation.
        span: The sentence that ordered it.
    """

    nodes: Indices
    base: Floats
    shifts: tuple[Term, ...]
    turn: Turn | None
    span: Span

    def at(self, time: float) -> tuple[Floats, Floats]:
        """Return positions [m] and velocities [m/s] of the nodes, each of shape (driven, 3)."""
        position, velocity = self.base, np.zeros_like(self.base)
        if self.turn is not None:
            position, velocity = self.turn.apply(self.base, time)
        shift, speed = _total(self.shifts, time)
        return position + shift, velocity + speed


@dataclass(frozen=True, slots=True, eq=False)
class Load:
    """An external force on each of some nodes: Σ vectorᵢ sᵢ(t) [N] per node."""

    nodes: Indices
    terms: tuple[Term, ...]
    span: Span

    def at(self, time: float) -> Floats:
        """Return the force on each of the nodes [N], shape (3,)."""
        return _total(self.terms, time)[0]


def _total(terms: tuple[Term, ...], time: float) -> tuple[Floats, Floats]:
    """Return the sum of the terms and of their rates, each of shape (3,)."""
    value, rate = np.zeros(3), np.zeros(3)
    for term in terms:
        factor, slope = term.course.at(time)
        value += factor * term.vector
        rate += slope * term.vector
    return value, rate


@dataclass(slots=True, eq=False)
class Situation:
    """The state at ``time`` and what acts on it until the next event.

    Attributes:
        position, velocity: State [m], [m/s], shape (node, 3).
        alive: False for springs that were cut or ruptured, shape (spring,).
        holders: Who holds which nodes ("fix" for fixed ones, otherwise a tool or set name);
            a node held by anybody is no unknown.
        motions: Prescribed motions under way, by the name of the tool or set that moves.
        loads: External forces, by name.
        enclosures: Volumes that are kept by pressure, by the name of the body.
        contact: What instruments touch, None where they touch nothing.
        jets: Of fluid, by the name of the nozzle.
        hold_ends: When a hold for an interval ends [s], by the name of the holder.
        gravity: Acceleration [m/s²], shape (3,).
        drag: Ambient damping [N s/m] per node.
        mass, stiffness, damping, rest, strength, crush: Present values; the network's own
            arrays until a ``change``.
    """

    network: Network
    time: float
    position: Floats
    velocity: Floats
    alive: NDArray[np.bool_]
    mass: Floats
    stiffness: Floats
    damping: Floats
    rest: Floats
    strength: Floats
    crush: Floats
    gravity: Floats
    drag: float
    holders: dict[str, Indices] = field(default_factory=dict)
    motions: dict[str, Motion] = field(default_factory=dict)
    loads: dict[str, Load] = field(default_factory=dict)
    enclosures: dict[str, Enclosure] = field(default_factory=dict)
    contact: Contact | None = None
    jets: dict[str, Jet] = field(default_factory=dict)
    hold_ends: dict[str, float] = field(default_factory=dict)

    @classmethod
    def start(
        cls, network: Network, *, gravity: Floats, drag: float, contact: Contact | None = None
    ) -> "Situation":
        """Return the situation at 0 s, before any event: everything is free and alive."""
        tools = {
            tool.name: np.arange(tool.nodes.start, tool.nodes.stop) for tool in network.tools
        }
        return cls(
            network=network,
            time=0.0,
            position=network.position.copy(),
            velocity=network.velocity.copy(),
            alive=np.ones(network.spring_count, dtype=bool),
            mass=network.mass,
            stiffness=network.stiffness,
            damping=network.damping,
            rest=network.rest,
            strength=network.strength,
            crush=network.crush,
            gravity=np.asarray(gravity, dtype=float),
            drag=drag,
            holders=tools,
            contact=contact,
        )

    @property
    def held(self) -> NDArray[np.bool_]:
        """Return which nodes are held, grasped or driven: no unknowns, shape (node,)."""
        held = np.zeros(self.network.node_count, dtype=bool)
        for nodes in self.holders.values():
            held[nodes] = True
        held[self.network.memory] = True
        return held

    def behaviour(self, springs: Indices | None = None) -> Behaviour:
        """Return what some springs do, all of them by default, by their present numbers."""
        chosen = slice(None) if springs is None else springs
        network = self.network
        return Behaviour(
            network.laws,
            network.law[chosen],
            self.stiffness[chosen],
            self.damping[chosen],
            self.rest[chosen],
        )

    def enclosure(self, body: str) -> Enclosure | None:
        """Return the volume of a body that is kept, None without one."""
        found = (e for name, e in self.enclosures.items() if name.lower() == body.lower())
        return next(found, None)

    def let_leak(self) -> list[tuple[Enclosure, int]]:
        """Give up the cells that are torn, which keep no pressure; jets go through tears.

        Returns:
            Enclosures as they were, each with the number of cells that it loses.
        """
        found, kept = [], {}
        for name, enclosure in self.enclosures.items():
            torn = enclosure.torn(self.alive)
            if len(torn):
                found.append((enclosure, len(torn)))
                enclosure = enclosure.without(torn)
            if enclosure.cell_count:
                kept[name] = enclosure
        self.enclosures = kept
        self.jets = {name: jet.torn(self.alive) for name, jet in self.jets.items()}
        return found

    @property
    def fields(self) -> tuple[Enclosure | Contact | Jet, ...]:
        """Return what acts on nodes by their places, beside springs."""
        contact = () if self.contact is None else (self.contact,)
        return (*self.enclosures.values(), *contact, *self.jets.values())

    def place_held(self) -> None:
        """Put driven nodes on their paths and every other held node at rest, at ``time``."""
        for nodes in self.holders.values():
            self.velocity[nodes] = 0.0
        for motion in self.motions.values():
            self.position[motion.nodes], self.velocity[motion.nodes] = motion.at(self.time)
