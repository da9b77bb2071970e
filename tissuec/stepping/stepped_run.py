"""A run that is stepped, looked at and acted on from Python."""

import warnings
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.compiler.compile import Compiled
from tissuec.compiler.conditions import Condition, Conditions
from tissuec.compiler.holds import check_holds
from tissuec.compiler.quantities import ObservedExpression, QuantityReader
from tissuec.compiler.script import ScriptReader
from tissuec.core.errors import SimulationError, TissueWarning
from tissuec.core.processors import permitted
from tissuec.core.source import Source
from tissuec.core.units import TIME, Dimension
from tissuec.engine.execution.stepwise import SavedRun, StepwiseRun, rounded
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.model.network import Floats, Indices, Network
from tissuec.results.recording import Event
from tissuec.scene.overrides import Given
from tissuec.scene.request import Request
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import ScheduledAction
from tissuec.script.verbs import VERBS, Demanding
from tissuec.stepping.recorded_script import recorded
from tissuec.stepping.sentences import UnitsOrder, joined, with_units

if TYPE_CHECKING:
    import pyvista  # pyright: ignore[reportMissingImports]

ORDERED = "ordered from Python"  # what the text of a sentence is called in messages


class SavedState(Struct, frozen=True, eq=False):
    """A state that a run of the same scene can be restored to; it can be pickled.

    Attributes:
        sentences: What was ordered until then, with the times.
    """

    run: SavedRun
    sentences: tuple[str, ...]


class SteppedRun:
    """A run of a scene that goes on when it is told to.

    Beside its methods it has one for each verb of the script: ``run.move("forceps A", by=(0,
    0, 0.005), over="50 ms")`` orders what ``from T to T + 50 ms: move forceps A by (0, 0,
    0.005) m using constant speed`` says. Words that Python reserves end with an underscore:
    ``with_``, ``from_``.

    Args:
        compiled: The scene.
        request: What it was compiled from.
        out: The result file that ``close`` writes; None for none.
        threads: Maximum number of threads for a large net; the motion does not depend on it.
        saved: Where it begins; at 0 s by default.

    Attributes:
        compiled: The scene.
        out: See above.
    """

    def __init__(
        self,
        compiled: Compiled,
        request: Request,
        *,
        out: Path | None = None,
        threads: int | None = None,
        saved: SavedState | None = None,
    ):
        self.compiled, self.out, self._request = compiled, out, request
        self._threads = threads or permitted()
        scene = compiled.scene
        self._duration, self._scope = scene.simulation.duration, scene.constants
        self._findings = scene.constants.findings
        self._conditions = Conditions(
            compiled.groups, scene.tools, scene.constants, duration=self._duration
        )
        self._dimensions: dict[tuple[str, ...], dict[str, Dimension]] = {}
        self._sentences = list(saved.sentences if saved else ())
        self._warned: set[str] = set()
        self._times: dict[str, float] = {}  # of texts [s]
        self._quantities: dict[str, ObservedExpression] = {}
        self._conditions_read: dict[str, Condition] = {}
        self._run = StepwiseRun(
            compiled.network,
            compiled.plan,
            threads=self._threads,
            saved=saved.run if saved else None,
        )
        self._snapshot: Snapshot | None = None

    def __repr__(self) -> str:
        name = self.compiled.scene.source.name
        return f'<SteppedRun "{name}": {self.time:g} s of {self.duration:g} s>'

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *VERBS]

    def __getattr__(self, name: str) -> Any:
        """Return what orders a verb of the script."""
        if name.startswith("_") or name not in VERBS:
            raise AttributeError(f'a stepped run has no "{name}", and the script no such verb')
        return partial(self._order_verb, name)

    # --- time ---------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Return the present time [s]."""
        return self._run.time

    @property
    def duration(self) -> float:
        """Return how long the scene lasts [s]."""
        return self._duration

    @property
    def ended(self) -> str:
        """Return how the run has ended, as a sentence; empty while it can go on."""
        ending = self._run.ending
        return "" if ending is None else ending[1]

    def step(self, span: str | float) -> None:
        """Go on for a time, or to the end of the run if that comes first.

        Args:
            span: Text such as "25 ms", or seconds.

        Raises:
            ValueError: The time is not above 0 s, or the run has ended.
            SimulationError: The run cannot go on.
            KeyboardInterrupt: After Ctrl-C; the run can go on from where it is.
        """
        seconds = self.seconds(span)
        until = rounded(self.time + seconds)
        if until <= self.time:
            raise ValueError(f"a step must be longer than {span}")
        self._go_to(until)

    def run_until(self, time: str | float) -> None:
        """Go on to a time, or to the end of the run if that comes first.

        Args:
            time: Text such as "1.2 s", or seconds; not before the present time.

        Raises:
            ValueError: The time is before the present one, or the run has ended.
            SimulationError: The run cannot go on.
            KeyboardInterrupt: After Ctrl-C; the run can go on from where it is.
        """
        self._go_to(rounded(self.seconds(time)))

    def _go_to(self, time: float) -> None:
        self._refuse_failure()
        if self.ended and time > self.time:
            raise ValueError(f"the run has ended; {self.ended}")
        self._snapshot = None
        self._run.step_to(time)
        self._refuse_failure()

    def _refuse_failure(self) -> None:
        ending = self._run.ending
        if ending is not None and ending[0] != "done":
            raise SimulationError(f"{self.compiled.scene.source.name}: {ending[1]}")

    def seconds(self, span: str | float) -> float:
        """Return a time such as "25 ms" in s.

        Raises:
            CompileError: The text is no time.
        """
        if not isinstance(span, str):
            return float(span)
        if span not in self._times:
            node = self._item(span).value
            with self._reporting():
                value = self._scope.number(node)
                self._scope.expect(value, TIME, node.span, what="the time")
                self._times[span] = float(value.amount)
        return self._times[span]

    # --- state --------------------------------------------------------------------------------

    @property
    def network(self) -> Network:
        """Return the net of the scene."""
        return self.compiled.network

    @property
    def snapshot(self) -> Snapshot:
        """Return everything that can be seen at the present time."""
        if self._snapshot is None:
            self._snapshot = self._run.snapshot
        return self._snapshot

    @property
    def position(self) -> Floats:
        """Return the positions of all nodes [m], shape (node, 3), not to be changed."""
        return _read_only(self.snapshot.position)

    @property
    def velocity(self) -> Floats:
        """Return the velocities of all nodes [m/s], shape (node, 3), not to be changed."""
        return _read_only(self.snapshot.velocity)

    @property
    def force(self) -> Floats:
        """Return the sum of the inner forces on each node [N], shape (node, 3)."""
        return _read_only(self.snapshot.node_force)

    @property
    def tension(self) -> Floats:
        """Return the tension of each spring [N], shape (spring,)."""
        return _read_only(self.snapshot.tension)

    @property
    def alive(self) -> NDArray[np.bool_]:
        """Return which springs are whole, shape (spring,)."""
        return self.snapshot.state.alive

    def to_pyvista(self) -> "pyvista.PolyData":
        """Return the net at the present time as a mesh; see ``Trajectory.to_pyvista``.

        Raises:
            ImportError: PyVista is not installed; says what to install.
        """
        from tissuec.results.conversion import to_pyvista
        from tissuec.stepping.present_shape import present_shape

        return to_pyvista(present_shape(self.compiled.scene.source.name, self.snapshot))

    @property
    def events(self) -> tuple[Event, ...]:
        """Return what has happened so far."""
        return self._run.events

    def log(self, name: str) -> tuple[Floats, Floats]:
        """Return what a log of the output block has recorded so far.

        Args:
            name: Such as "force of forceps A".

        Returns:
            Times [s], shape (row,), and rows in SI units, shape (row, column).

        Raises:
            KeyError: The scene has no such log.
        """
        if name not in (names := [log.name for log in self.compiled.plan.output.logs]):
            raise KeyError(f'there is no log "{name}"; the logs are: {", ".join(names)}')
        return self._run.rows(name)

    def nodes_of(self, name: str) -> Indices:
        """Return the numbers of the nodes of a set or body, shape (n,).

        Raises:
            ValueError: There is none of that name.
        """
        return self.compiled.nodes_of(name)

    def springs_of(self, name: str) -> Indices:
        """Return the numbers of the springs of a set, body or joint, shape (n,).

        Raises:
            ValueError: There is none of that name.
        """
        return self.compiled.springs_of(name)

    def measure(self, what: str) -> float:
        """Return a number at the present time, in SI units.

        Args:
            what: As in a condition or study: "force of forceps A", "position(tip along (0, 0,
                1)) - 2 mm".

        Raises:
            CompileError: This measures nothing, or not the present.
        """
        return float(self.quantity(what).sample((), self.snapshot)[0])

    def holds(self, what: str) -> bool:
        """Return whether a condition of the script holds at the present time.

        Args:
            what: Such as "force(forceps A) > 20 mN".

        Raises:
            CompileError: It is no condition.
        """
        if what not in self._conditions_read:
            items = parse(Source(ORDERED, f"expect {what}"), has_heading=False).items
            with self._reporting():
                node = cast(s.Expect, items[0]).condition
                self._conditions_read[what] = self._conditions.condition(node)
        return bool(self._conditions_read[what](self.snapshot))

    def quantity(self, what: str) -> ObservedExpression:
        """Return what is measured, read and checked once, to be evaluated on snapshots.

        Args:
            what: See ``measure``.

        Raises:
            CompileError: This measures nothing, or not the present.
        """
        if what not in self._quantities:
            item = self._item(what)
            with self._reporting():
                self._quantities[what] = self._read_quantity(item)
        return self._quantities[what]

    def _read_quantity(self, item: s.Assign) -> ObservedExpression:
        """Return a quantity of the present."""
        self._conditions.needs_ledger = False
        found = QuantityReader(self._conditions).read(item.value, item.clauses, item.value.span)
        if any(reading.time is not None for reading in found.readings.values()):
            message = "what is measured now cannot name a time"
            self._findings.reject("TIS702", message, item.value.span)
        if self._conditions.needs_ledger and not self.compiled.plan.needs_ledger:
            self._findings.reject(
                "TIS702", "this run does not keep the energies of its motion", item.value.span,
                hint='add "energy every 10 ms" to the output block of the scene',
            )  # fmt: skip
        return found

    # --- orders -------------------------------------------------------------------------------

    def order(self, sentence: str, *, over: str | float | None = None) -> None:
        """Order what a sentence of the script says, from the present time on.

        It is carried out when the run goes on or is looked at.

        Args:
            sentence: Such as "grasp tip with forceps A".
            over: How long it takes: text such as "50 ms", or seconds; None for at once.

        Raises:
            CompileError: The sentence is wrong.
            ValueError: The run has ended.
        """
        if self.ended:
            raise ValueError(f"the run has ended; {self.ended}")
        begin = self._run.order_time
        when = f"at {begin!r} s"
        if over is not None:
            when = f"from {begin!r} s to {rounded(begin + self.seconds(over))!r} s"
        text = f"{when}: {sentence}"
        items = parse(Source(ORDERED, text), has_heading=False).items
        with self._reporting():
            script = self._reader().read(items)
        self._check(script.events)
        self._run.order(script.events)
        self._sentences.append(text)
        self._snapshot = None

    def _order_verb(
        self, verb: str, *words: str, over: str | float | None = None, **clauses: Given
    ) -> None:
        """Order what a verb does.

        Args:
            words: What follows the verb, such as a set or tool.
            over: See ``order``.
            clauses: Values by joining word, numbers in SI units.
        """
        bare = tuple(
            word.rstrip("_") for word, value in clauses.items() if not isinstance(value, str)
        )
        text = joined(verb, words, clauses)
        if bare:
            sentence = parse(Source(ORDERED, text), has_heading=False).items[0]
            assert isinstance(sentence, s.Sentence)
            duration = None if over is None else self.seconds(over)
            asked = self._asked_units(verb, words, bare, sentence, duration)
            text = with_units(sentence, bare, asked)
        self.order(text, over=over)

    def _asked_units(
        self, verb: str, words: Sequence[str], bare: Sequence[str], sentence: s.Sentence,
        duration: float | None,
    ) -> dict[str, Dimension]:  # fmt: skip
        """Return what a verb asks clauses with numbers for."""
        key = (verb, *words, "", *bare)
        if key not in self._dimensions:
            member, scene = VERBS[verb], self.compiled.scene
            order = UnitsOrder(
                bare, sentence, verb, member.forms, duration, self.compiled.groups,
                scene.tools, self._scope,
            )  # fmt: skip
            with self._reporting():
                member.read(order)
            self._dimensions[key] = order.dimensions
        return self._dimensions[key]

    def _reader(self) -> ScriptReader:
        """Return a new reader: one knows sentences by where they are in memory."""
        scene = self.compiled.scene
        return ScriptReader(
            self.compiled.groups, scene.tools, self._conditions, self._scope,
            duration=self._duration,
        )  # fmt: skip

    def _check(self, events: Sequence[ScheduledAction]) -> None:
        """Report what is checked of a whole script."""
        scene, network = self.compiled.scene, self.compiled.network
        flaws = [
            (event.action.span, flaw)
            for event in events
            if isinstance(event.action, Demanding) and (flaw := event.action.flaw(network))
        ]
        plan = self.compiled.plan
        every = sorted([*plan.events, *self._run.actions, *events], key=lambda one: one.time)
        shaped = all(tool.entries is not None for tool in scene.tools.values())
        with self._reporting():
            for span, flaw in flaws:
                self._findings.add("TIS309", flaw, span)
            self._findings.extend(
                check_holds(every, plan.triggers, network.tools, shaped=shaped)
            )

    def _item(self, text: str) -> s.Assign:
        """Return what is written as the value of an entry."""
        items = parse(Source(ORDERED, f"value = {text}"), has_heading=False).items
        if len(items) != 1:
            raise ValueError(f'"{text}" is not one value but {len(items)}')
        return cast(s.Assign, items[0])

    @contextmanager
    def _reporting(self) -> Generator[None]:
        """Raise what is found wrong in the block, and warn of what is doubtful.

        Raises:
            CompileError: Something is wrong.
        """
        try:
            with self._findings.item():
                yield
            self._findings.raise_errors()
            for finding in map(str, self._findings.warnings):
                if finding not in self._warned:
                    self._warned.add(finding)
                    warnings.warn(finding, TissueWarning, stacklevel=4)
        finally:
            self._findings.clear()

    # --- what was done ------------------------------------------------------------------------

    def save(self) -> SavedState:
        """Return the present state, to the last bit."""
        return SavedState(self._run.save(), tuple(self._sentences))

    def restore(self, state: SavedState) -> None:
        """Go back, or over, to a state of this scene."""
        self._snapshot = None
        self._sentences = list(state.sentences)
        self._run.restore(state.run)

    def fork(self) -> Self:
        """Return another run that is where this one is, and writes no result."""
        other = type(self)(
            self.compiled, self._request, threads=self._threads, saved=self.save()
        )
        # Which depend on the scene alone.
        other._quantities, other._conditions_read = self._quantities, self._conditions_read
        return other

    def script(self) -> str:
        """Return the scene with everything that was ordered and given, which runs the same.

        Raises:
            TissueError: The script of the scene stands in a file that the scene uses.
        """
        return recorded(self._request, self._sentences)

    def close(self) -> None:
        """Write the result file, if one was asked for, up to the present time.

        The scene with everything that was ordered is run once more, as ``tissuec.run`` does:
        the result has all outputs of the scene and an estimate of its error.

        Raises:
            PlaceError: The file cannot be written there.
            ResultError: Writing failed later on.
        """
        if self.out is None:
            return
        from tissuec.pipeline import compile_request, simulate
        from tissuec.results.places import make_folder

        sentences = list(self._sentences)
        if self.time < self.duration and not self.ended:
            sentences.append(f"at {self.time!r} s: end the run")
        text = recorded(self._request, sentences)
        source = replace(self._request.source, text=text)
        request = replace(self._request, source=source)
        make_folder(self.out.parent)
        path, self.out = self.out, None
        simulate(compile_request(request)[0], path, request=request)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()


def _read_only(values: Floats) -> Floats:
    """Return a view that cannot be written to."""
    view = values.view()
    view.flags.writeable = False
    return view
