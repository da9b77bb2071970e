"""The arrays that are stepped, and calls of the loop over steps on them.

Lists of near pairs in contact, and the distance for which they hold.

Pairs of nodes and shapes that are near are listed around a state, and hold until a node has
moved by a distance. The shorter it is, the fewer pairs without contact every step examines, and
the more often pairs are listed. Results are the same for any distance.
"""

import time as clock
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from msgspec import Struct

from tissuec.compiled.calls import raise_failure
from tissuec.compiled.record_tables import RecordTable
from tissuec.core.arrays import norm
from tissuec.core.structs import replace
from tissuec.engine.backends import BACKENDS, bound_drive, loop_operations, with_python
from tissuec.engine.integrators import Integrator
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import Follow, Method, Samples
from tissuec.engine.run_arrays import (
    SampleBuffer,
    first_step,
    least_pressure,
    moved_work,
    new_progress,
    new_task,
    new_work,
)
from tissuec.forces.contact.bristle_kernel import SLIDES
from tissuec.kernels.records import ContactTable, Task, Work
from tissuec.mechanics import observables
from tissuec.mechanics.state import State
from tissuec.model.network import FRICTION, Floats, Indices, Network
from tissuec.script.plan import DEFAULT_TOLERANCE
from tissuec.script.procedures import PropagationChoices

PAUSE = 0.05  # time between two moments at which a run can pause [s]
FASTER = 8  # times the evaluations of a call: those of the next one, at most


class Stepper:
    """What is stepped, and how, without any decision about it.

    Args:
        network: The network of the run.
        method: How it is to be stepped.
        inputs: The network as compiled code takes it.
        buffer: Takes the samples.

    Attributes:
        integrator: Set by ``install``, as are ``work`` and ``task``.
        backend: Of the loop over steps.
        work: The arrays of the run.
        task: What is constant in calls of the loop.
        progress: The state of the run.
        cap: Longest step by stability [s].
        segment: Up to when profiles have no knots [s]; None before the first stretch.
        asked: Evaluations when a pause was last offered.
        listing: State of the lists of near pairs.
    """

    integrator: type[Integrator]
    backend: str
    work: Work
    task: Task

    def __init__(
        self, network: Network, method: Method, inputs: KernelInputs, buffer: SampleBuffer
    ):
        self.network, self.method, self.inputs, self.buffer = network, method, inputs, buffer
        self.progress = new_progress(0.0)
        self.cap = np.inf
        self.segment: float | None = None
        self.asked = 0
        self._allowed = 1
        self.listing = ContactListing()
        self._net: RecordTable | None = None  # what acts, once it is needed
        self._tables: dict[type[Any], RecordTable] = {}  # of further records

    @property
    def evaluations(self) -> int:
        """Return the number of force evaluations so far."""
        return int(self.work.effort[0])

    # --- the arrays ---------------------------------------------------------------------------

    def install(self, integrator: type[Integrator]) -> None:
        """Make the arrays for an integrator; the state stays where it is."""
        before = getattr(self, "work", None)
        self.integrator = integrator
        if integrator.implicit and self.inputs.left_out:
            self._place_bristles(None)
            before = self.work
        team = self.inputs.team.record
        work = new_work(integrator, self.network, team, self.inputs.layout)
        method = self.method
        if isinstance(method.choices, PropagationChoices):
            work.choices[:] = method.choices.row()
        tolerance = DEFAULT_TOLERANCE if method.tolerance is None else method.tolerance
        task = new_task(self.network, integrator, tolerance, method.duration)
        viewed = self.task.viewed if before is not None else np.inf
        self.task = task._replace(fixed=0 if method.step is None else 1, viewed=viewed)
        self.cap, self.listing = np.inf, ContactListing()
        if before is not None:
            half = self.progress.current
            work.x[:], work.v[:] = before.x[half], before.v[half]
            work.trial_x[:], work.trial_v[:] = before.x[half], before.v[half]
            work.ledger[:] = before.ledger[half]
            work.origin[:], work.effort[:] = before.origin, before.effort
            work.drift[:] = before.drift
            work.doubt[:] = before.doubt
            work = work._replace(tension=before.tension, sides=before.sides)
            self.update(fresh=1, memory=0.0, wait=0, current=0)
        self.work = work

    def begin(self, state: State) -> None:
        """Take the state with which a run begins, or is resumed."""
        self.work.origin[:] = self.inputs.inwards(state.position)
        sample = int(np.searchsorted(self.buffer.buffer.times, state.time))
        self.progress = replace(new_progress(state.time), sample=sample)

    def load(self, state: State) -> None:
        """Copy the state into the arrays; all of them hold the nodes that do not move."""
        work, inputs = self.work, self.inputs
        moving = state.velocity.copy()
        moving[np.flatnonzero(inputs.still)] = 0.0
        position, velocity = inputs.inwards(state.position), inputs.inwards(moving)
        work.x[:], work.v[:], work.a[:] = position, velocity, 0.0
        work.trial_x[:], work.trial_v[:] = position, velocity
        if state.riders is not None and state.embedding is not None:
            origin = inputs.positions(work.origin)
            state.embedding.follow(origin)
            work.origin[:] = inputs.inwards(origin)
        self.update(time=state.time, fresh=1, memory=0.0, wait=0, pending=0, leeway=0.0)
        if self.method.ledger:
            self._load_energies(state)
        self._fit()
        self._tables = {}

    def _load_energies(self, state: State) -> None:
        """Have the energies of the state among those that errors are relative to."""
        least = max(self.task.least, least_pressure(state, self.task.floor))
        self.task = self.task._replace(least=least)
        present = observables.energies(state, state.time, state.position, state.velocity)
        energy = float(present.kinetic + present.elastic)
        self.update(energy=max(self.progress.energy, energy))

    def _fit(self) -> None:
        """Give arrays with a column for each spring as many as act."""
        acting = len(self.inputs.springs.ids)
        springs = acting if self.method.watch_strength else 0
        if self.work.tension.shape[1] != springs:
            self.work = self.work._replace(tension=np.zeros((3, springs)))
        cornered = acting if self.inputs.features.cornered else 0
        if self.work.sides.shape[2] != cornered:
            self.work = self.work._replace(sides=np.zeros((2, 3, cornered)))

    def synchronise(self, state: State) -> None:
        """Copy time and state into the state."""
        now, work = self.progress, self.work
        state.time = now.time
        state.position[:] = self.inputs.positions(work.x[now.current])
        state.velocity[:] = self.inputs.outwards(work.v[now.current])
        state.keep_rest()

    def update(self, **changes: Any) -> None:
        """Change numbers of the progress, in a copy."""
        self.progress = replace(self.progress, **changes)

    # --- steps --------------------------------------------------------------------------------

    def first_step(self) -> float:
        """Return a cautious first step [s]."""
        return first_step(self.inputs, self.integrator, self.method.duration)

    def limit_step(self) -> None:
        """Find the longest step again, by stability and what moves."""
        longest = min(self.inputs.longest_step(self.integrator.looks), self.cap)
        self.task = self.task._replace(longest=longest)

    def begin_segment(self, until: float) -> None:
        """Prepare a stretch without knots inside: one curve per profile, uniform steps."""
        now, inputs = self.progress, self.inputs
        self.segment = until
        inputs.start, inputs.until = now.time, until
        self.limit_step()
        if inputs.is_changing:
            # Velocities and forces may jump here; the accelerations so far are no longer true.
            self.update(fresh=1)
            self.forget_net()
            self.work.solver.made[2] = 1.0
        if self.method.step is not None and until > now.time:
            count = np.ceil((until - now.time) / self.method.step * (1.0 - 1e-12))
            self.update(step=(until - now.time) / max(count, 1.0))

    def call_limit(self, foreseen: int) -> int:
        """Return the evaluations after which a call comes back, by default.

        Where evaluations take longer than foreseen, whatever acts on the net and however it is
        stepped, fewer take ``PAUSE``. Their number begins low and grows from call to call, so
        that the first ones are short, too.

        Args:
            foreseen: Evaluations that are predicted to take ``PAUSE``.
        """
        return self.asked + min(foreseen, self._allowed)

    def call(self, hold: int, evaluations: int, spacing: float = 0.0) -> int:
        """Run the loop over steps once; return why it returned.

        Args:
            hold: As in ``Task``.
            evaluations: Likewise.
            spacing: Likewise [s].
        """
        task = self.task._replace(
            until=self.inputs.until, evaluations=evaluations, hold=hold, spacing=spacing
        )
        net = self.acting()  # which may give other places to nodes
        self.buffer.make_room(hold)
        work, buffer = self.work, self.buffer.buffer
        if BACKENDS[self.backend].takes_tables:
            work, buffer = self.table(work), self.table(buffer)
        drive = bound_drive(self.integrator, self.backend)
        self.update()  # a copy, which the loop changes
        before, began = self.evaluations, clock.perf_counter()
        with self.inputs.team:
            reason = drive(self.progress, task, work, net, buffer)
        self._pace(self.evaluations - before, clock.perf_counter() - began)
        for table in (net, *net.fields.kept):
            raise_failure(table)
        return reason

    def _pace(self, evaluations: int, took: float) -> None:
        """Choose the evaluations of the next call from those of one and its wall time [s]."""
        if evaluations:
            foreseen = int(PAUSE * evaluations / max(took, 1e-9))
            self._allowed = max(1, min(foreseen, FASTER * max(evaluations, self._allowed)))

    def acting(self) -> RecordTable:
        """Return the acting forces, with the operations on them."""
        if self._net is None:
            inputs, needed = self.inputs, self.inputs.features
            called = loop_operations(self.integrator, needed)
            in_python = dict(BACKENDS[self.backend].operations)
            if needed.touched:
                self._list_near()
            net = inputs.net(self.integrator, plain=bool(in_python))
            if needed.touched:
                if self._narrow(net.touches):
                    net = inputs.net(self.integrator, plain=bool(in_python))
                if self._place_near_bristles(net.touches):
                    net = inputs.net(self.integrator, plain=bool(in_python))
                self._straighten(net.touches)
            called_back = in_python | inputs.in_python(self.integrator)
            net = net._replace(operations=called)
            self._net = with_python(net, called_back, self.work.solver)
        return self._net

    def _list_near(self) -> None:
        """List near pairs around the present positions, unless they are listed already."""
        listing, inputs = self.listing, self.inputs
        if listing.around is None:
            listing.at, listing.step = self.progress.time, self.progress.accepted
            listing.around = inputs.positions(self.work.x[self.progress.current])
        inputs.around, inputs.share = listing.around, listing.share

    def _narrow(self, touches: ContactTable) -> bool:
        """Choose a shorter distance for long lists; return whether to list pairs again.

        Some methods need the longest distance: steps of implicit ones may change the matrix
        before they leave their lists, and stages of stabilised ones are far away.
        """
        method, listing = self.integrator, self.listing
        if method.implicit or method.stabilised or not listing.narrow(touches.shape.size):
            return False
        self.inputs.share = listing.share
        return True

    def _place_near_bristles(self, touches: ContactTable) -> bool:
        """Give places to the bristles of listed points; return whether to list pairs again.

        Places change only if bristles lack one, or far too many others have one. Implicit
        methods keep all places, for which their matrix was made.
        """
        has_bristles = touches.memory.size > 0 and touches.bent.shape[1] > SLIDES
        if not has_bristles or self.integrator.implicit:
            return False
        contact = self.inputs.state.contact
        assert contact is not None, "otherwise there are no lists"
        near = contact.bristles_in(touches, self.inputs.layout.order)
        if not self.inputs.leaves_out(near):
            return False
        self._place_bristles(near)
        return True

    def _place_bristles(self, rows: Indices | None) -> None:
        """Give places to some bristles only; None for all."""
        self._replace(lambda: self.inputs.keep(rows))

    def park(self, state: State) -> None:
        """Give places to nodes that are not parked in a state, which ``load`` takes next."""
        if not self.inputs.parks(state):
            return
        if hasattr(self, "work"):
            self._replace(lambda: self.inputs.park(state))
        else:
            self.inputs.park(state)
            self.buffer.fit()

    def _replace(self, change: Callable[[], None]) -> None:
        """Change the places of nodes and rows between two steps."""
        inputs, now, work = self.inputs, self.progress.current, self.work
        self.progress = self.buffer.set_aside(self.progress)
        places = {
            "x": inputs.positions(work.x[now]),
            "v": inputs.outwards(work.v[now]),
            "a": inputs.outwards(work.a[now]),
            "origin": inputs.positions(work.origin),
            "drift": inputs.outwards(work.drift),
        }
        change()
        moved = {name: inputs.inwards(vectors) for name, vectors in places.items()}
        self.work = moved_work(work, self.network, inputs.layout, **moved)
        self.buffer.fit()

    def _straighten(self, touches: ContactTable) -> None:
        """Set bristles of points that are not listed to zero: nothing presses on them."""
        if touches.bent.shape[1] <= SLIDES:
            return
        places = self.inputs.layout.place[self.network.remembering(FRICTION)]
        away = np.setdiff1d(places[places >= 0], touches.memory)
        self.work.v[self.progress.current].reshape(-1, 3)[away] = 0.0

    def list_anew(self) -> bool:
        """Have near pairs listed around the present positions; nothing else changes.

        Returns:
            False if the next step alone is too long for any list.
        """
        now = self.progress
        if not self.listing.end(now.time, now.accepted, self.acting().touches.shape.size):
            return False
        slipping = self.slipping
        self.forget_net()
        self.let_slip(slipping)
        return True

    @property
    def slipping(self) -> Floats:
        """Return which bristles slip: 1 or 0 of each, dimensionless, shape (bristle,).

        Empty where no bristles are cut. The flags are an input of the forces; see
        ``cut_bristles``.
        """
        touches = None if self._net is None else self._net.touches
        if touches is None or touches.bent.shape[1] <= SLIDES:
            return np.zeros(0)
        slips = np.zeros(self.network.row_count)
        slips[self.inputs.layout.order[touches.memory]] = touches.bent[:, SLIDES]
        return slips[self.network.remembering(FRICTION)]

    def let_slip(self, slipping: Floats) -> None:
        """Set which bristles slip.

        Args:
            slipping: As the property of this name, dimensionless, shape (bristle,).
        """
        if not len(slipping):
            return
        touches, slips = self.acting().touches, np.zeros(self.network.row_count)
        slips[self.network.remembering(FRICTION)] = slipping
        touches.bent[:, SLIDES] = slips[self.inputs.layout.order[touches.memory]]

    def forget_net(self) -> None:
        """Discard the acting forces and the lists of near pairs; they are made when needed."""
        self._net, self.listing.around = None, None

    def table(self, record: Any) -> RecordTable:
        """Return a record as compiled code takes it; that of the last one if it is the same."""
        kind = cast("type[Any]", type(record))
        kept = self._tables.get(kind)
        if kept is None or kept.record is not record:
            kept = self._tables[kind] = RecordTable(record)
        return kept

    def show(self, follow: Follow) -> None:
        """Show the present state to who follows the motion, and note when to do so again."""
        now, inputs, work = self.progress, self.inputs, self.work
        leeway = follow(now.time, inputs.positions(work.x[now.current]))
        self.update(leeway=leeway)
        if leeway == np.inf:
            return
        velocity = inputs.outwards(work.v[now.current])
        drift = np.zeros_like(velocity)
        for body in self.network.bodies:
            drift[body.nodes] = velocity[body.nodes].mean(axis=0)
        work.drift[:] = inputs.inwards(drift)
        bodies = self.network.body_nodes
        speed = float(norm(velocity - drift)[:bodies].max(initial=0.0))
        self.update(speed_now=speed)

    # --- samples ------------------------------------------------------------------------------

    def flush(self) -> None:
        """Give the samples so far to the recorder."""
        before = self.progress
        self.update(filled=0)  # the recorder may request a checkpoint
        self.buffer.flush(before)

    def sample(self, state: State) -> Samples:
        """Return a state, to which the steps have come, as a batch of one sample."""
        now, ledger = self.progress, self.work.ledger[self.progress.current]
        return Samples(
            time=np.array([state.time]),
            position=state.position[None].copy(),
            velocity=state.velocity[None].copy(),
            work=ledger[:1].copy(),
            dissipated=ledger[1:].copy(),
            error=np.array([now.error]),
            reach=np.array([now.displacement]),
        )

    def record_end(self, state: State) -> None:
        """Record the sample at the time of a state, if there is one."""
        while self.buffer.is_due(self.progress, np.nextafter(state.time, np.inf)):
            self.progress = self.buffer.enter(
                self.progress,
                self.inputs.inwards(state.position),
                self.inputs.inwards(state.velocity),
                self.work.ledger[self.progress.current],
            )
        self.flush()


MANY = 1000  # pairs; for fewer, listing again costs more than it saves
NARROW = 0.0625  # of the longest distance, to begin with
OFTEN, SELDOM = 60, 600  # steps between two lists; below, they are widened


class ContactListing(Struct):
    """The state around which pairs were listed, and their distance; part of checkpoints.

    Attributes:
        at: Time at which they were listed [s].
        around: Positions of all nodes then [m], shape (node, 3); None before they are listed.
        step: Number of steps that were accepted before.
        share: Distance by which nodes may move, as a part of the longest one.
        is_tried: Whether a shorter distance than the longest one was tried.
    """

    at: float = float("nan")
    around: Floats | None = None
    step: int = 0
    share: float = 1.0
    is_tried: bool = False

    def narrow(self, pairs: int) -> bool:
        """Choose a short distance if the first lists are long; return whether they were.

        Args:
            pairs: Number of pairs that were listed.
        """
        if self.is_tried or pairs <= MANY:
            return False
        self.share, self.is_tried = NARROW, True
        return True

    def end(self, time: float, step: int, pairs: int) -> bool:
        """Choose the next distance when a node is about to exceed it.

        Returns False if the next step alone exceeds the longest one.

        Args:
            time: Of the run [s].
            step: Number of steps that were accepted.
            pairs: Number of pairs that were listed.
        """
        steps = step - self.step
        if time == self.at:
            if self.share == 1.0:
                return False
            self.share = min(8.0 * self.share, 1.0)
        elif self.share < 1.0 and steps < OFTEN:
            self.share *= 2.0
        elif steps > SELDOM and pairs > MANY:
            self.share *= 0.5
        return True
