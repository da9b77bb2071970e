"""Running small nets with the engine, for tests: everything recorded comes back as arrays."""

import numpy as np
from msgspec import Struct

from tests.hand_net import make_net, span
from tissuec.compiled.record_tables import RecordTable
from tissuec.engine.engine import Engine
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import Interruption, Method
from tissuec.engine.operations import OPERATIONS, operations
from tissuec.engine.stepper import Stepper
from tissuec.forces.acting.load import Load, LoadTerm
from tissuec.mechanics.state import PrescribedMotion, PrescribedRotation, State
from tissuec.model.profiles import TimeProfile

EVERLASTING = TimeProfile("constant", 0.0, np.inf)


def set_pace(monkeypatch, backend, springs):
    """Have the loop over steps of a backend come back after some evaluations of springs."""
    usual = Stepper.call_limit

    def call_limit(stepper, foreseen):
        if stepper.backend != backend:
            return usual(stepper, foreseen)
        return stepper.asked + springs // (len(stepper.inputs.springs.ids) + 100)

    monkeypatch.setattr(Stepper, "call_limit", call_limit)


class Ran(Struct):
    """A run: its samples, its end and the engine."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    work: np.ndarray
    dissipated: np.ndarray
    error: np.ndarray
    reach: np.ndarray
    end: Interruption
    state: State
    engine: Engine

    @property
    def largest_displacement(self):
        """Return the largest displacement up to each sample [m], shape (sample,)."""
        moved = np.linalg.norm(self.position - self.position[0], axis=2).max(axis=1)
        return np.maximum.accumulate(moved)


def accelerated(state):
    """Return what the engine's forces do: accelerations, shape (node, 3), and powers [W]."""
    inputs = KernelInputs(state.network, watched=False, ledger=True)
    inputs.update(state)
    inputs.start, inputs.until = state.time, np.inf
    x, v = inputs.inwards(state.position), inputs.inwards(state.velocity)
    a, power = np.zeros_like(x), np.zeros(2)
    called = operations(frozenset(("force",)), inputs.features)
    net = inputs.net(INTEGRATORS["dop853"])._replace(operations=called)
    OPERATIONS["force"](state.time, x, v, a, power, RecordTable(net))
    return inputs.outwards(a), power


class Bench:
    """A state, an engine on it, and what it has recorded."""

    def __init__(
        self,
        network,
        duration,
        *,
        method="dop853",
        tolerance=None,
        step=None,
        times=None,
        gravity=(0.0, 0.0, 0.0),
        drag=0.0,
        fixed=(),
        ledger=False,
        ruptures=False,
        backend=None,
        choices=None,
    ):
        self.duration = duration
        self.state = State.start(network, gravity=gravity, drag=drag)
        if len(fixed):
            self.state.holders["fix"] = np.array(fixed)
        times = np.linspace(0.0, duration, 41) if times is None else np.asarray(times)
        self.batches = []
        asked = Method(method, tolerance, step, duration, ledger, ruptures, choices)
        self.engine = Engine(network, asked, times, self.batches.append, backend=backend)

    def move(self, nodes, vector, profile, *, turn=None):
        """Put nodes on a prescribed path."""
        nodes = np.array(nodes)
        self.state.holders["tool"] = nodes
        shifts = () if vector is None else (LoadTerm(np.array(vector, float), profile),)
        base = self.state.position[nodes].copy()
        self.state.motions["tool"] = PrescribedMotion(nodes, base, shifts, turn, span())

    def turn(self, nodes, angle, profile, *, centre=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0)):
        """Turn nodes about an axis."""
        self.move(
            nodes,
            None,
            profile,
            turn=PrescribedRotation(np.array(centre), np.array(axis), angle, profile),
        )

    def push(self, nodes, vector, profile=EVERLASTING):
        """Put a force on each of some nodes."""
        terms = (LoadTerm(np.array(vector, float), profile),)
        self.state.loads["push"] = Load(np.array(nodes), terms, span())

    def advance(self, until, watch=None):
        return self.engine.advance(self.state, until, watch)

    def run(self, *stops, watch=None):
        """Advance to each stop and to the duration; return everything recorded."""
        for until in (*stops, self.duration):
            end = self.advance(until, watch)
            if end.kind != "reached":
                break
        else:
            self.engine.finish(self.state)
        return self.ran(end)

    def keep_checkpoints(self, samples):
        """Return a list that fills while this runs: all that a later run can go on from.

        Each entry: batches recorded so far, time, positions, velocities, state of the engine.

        Args:
            samples: Of the buffer; a small one is emptied often.
        """
        kept, buffer = [], self.engine.stepper.buffer

        def keep(batch):
            self.batches.append(batch)
            saved = self.engine.checkpoint()
            if saved is not None:
                now = self.state
                place, speed = now.position.copy(), now.velocity.copy()
                kept.append((len(self.batches), now.time, place, speed, saved))

        buffer._record = keep
        parts = ("time", "position", "velocity", "ledger")
        few = {name: getattr(buffer.buffer, name)[:samples] for name in parts}
        buffer.buffer = buffer.buffer._replace(**few)
        return kept

    def restore(self, time, position, velocity, saved):
        """Go on from a checkpoint."""
        self.state.time = time
        self.state.position[:], self.state.velocity[:] = position, velocity
        self.engine.restore(self.state, saved)

    def ran(self, end):
        parts = [np.concatenate(part) for part in zip(*self.batches, strict=True)]
        return Ran(*parts, end, self.state, self.engine)


def pair(damping=0.0, *, stretch=0.2, stiffness=100.0, mass=1.0, velocity=0.0, **limits):
    """Return two masses on a spring of length 1 that is drawn longer."""
    return make_net(
        [[0.0, 0.0, 0.0], [1.0 + stretch, 0.0, 0.0]],
        [[0, 1]],
        mass=mass,
        stiffness=stiffness,
        damping=damping,
        rest=1.0,
        velocity=velocity,
        **limits,
    )


def chain(count=8, *, stiffness=100.0, mass=0.01, damping=0.0, velocity=0.0, **more):
    """Return a straight chain of ``count`` masses between two more, 1 cm apart."""
    position = np.zeros((count + 2, 3))
    position[:, 0] = 0.01 * np.arange(count + 2)
    ends = [[i, i + 1] for i in range(count + 1)]
    return make_net(
        position,
        ends,
        mass=mass,
        stiffness=stiffness,
        damping=damping,
        velocity=velocity,
        **more,
    )


def block(side=3, *, stiffness=50.0, mass=1e-3, damping=0.0, shrink=1.0, spin=(0.0, 0.0, 0.0)):
    """Return a cubic block with springs to all neighbours nearer than 1.5 cm, spinning."""
    grid = np.stack(np.meshgrid(*[0.01 * np.arange(side)] * 3, indexing="ij"), -1).reshape(
        -1, 3
    )
    apart = np.linalg.norm(grid[:, None] - grid[None], axis=2)
    ends = np.argwhere(np.triu((apart > 0.0) & (apart < 0.0145)))
    rest = shrink * apart[ends[:, 0], ends[:, 1]]
    velocity = np.cross(spin, grid - grid.mean(axis=0))
    return make_net(
        grid,
        ends,
        mass=mass,
        stiffness=stiffness,
        damping=damping,
        rest=rest,
        velocity=velocity,
    )


def tube(*, stiffness=200.0, mass=1e-4, damping=0.02, prestress=0.04, **more):
    """Return 16 rings of 10 nodes with springs crossed through the inside, 610 in all."""
    around = 2.0 * np.pi * np.arange(10) / 10
    ring = 0.003 * np.stack([np.zeros(10), np.cos(around), np.sin(around)], axis=1)
    position = np.concatenate([ring + np.array([0.064 / 15 * i, 0.0, 0.0]) for i in range(16)])
    ends = [
        (10 * i + j, 10 * (i + 1) + (j + k) % 10)
        for i in range(15)
        for j in range(10)
        for k in (0, 4, 6)
    ]
    ends += [(10 * i + j, 10 * i + (j + 1) % 10) for i in range(16) for j in range(10)]
    drawn = np.linalg.norm(np.subtract(*position[np.array(ends).T]), axis=1)
    return make_net(
        position, ends, mass=mass, stiffness=stiffness, damping=damping,
        rest=(1.0 - prestress) * drawn, **more,
    )  # fmt: skip


def lifted_tube(duration=1.0, lift=0.003, damping=0.02, **more):
    """Return a bench with the tube: end rings fixed, gravity, waist lifted within 0.3 s."""
    bench = Bench(
        tube(damping=damping),
        duration,
        gravity=(0.0, 0.0, -9.81),
        fixed=[*range(10), *range(150, 160)],
        **more,
    )
    bench.move(range(90, 110), [0.0, 0.0, lift], TimeProfile("smooth", 0.15, 0.45))
    return bench
