"""A run that is stepped, examined and acted on from Python."""

import weakref
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.api.text_reader import TextReader, recorded
from tissuec.compiler.compile import Compiled
from tissuec.compiler.measures.quantities import ObservedExpression
from tissuec.core import arguments
from tissuec.core.blas import on_one_thread
from tissuec.core.errors import SimulationError, TissueError
from tissuec.core.structs import replace
from tissuec.core.workers.workers import permitted
from tissuec.engine.execution.stepwise import SavedRun, StepwiseRun, rounded
from tissuec.model.network import Floats, Indices, Network
from tissuec.results.checkpoint import scene_digest
from tissuec.results.fields import FIELDS, Place, always_recorded
from tissuec.results.frame_columns import MOTION
from tissuec.results.layout import reserved
from tissuec.results.mesh import DrawnMesh, everything
from tissuec.results.recording import Event
from tissuec.results.shapes import ExportedShape, net_shape
from tissuec.scene.overrides.texts import Given
from tissuec.scene.request import Request
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.verbs import VERBS

if TYPE_CHECKING:
    import pyvista  # pyright: ignore[reportMissingImports]


class SavedState(Struct, frozen=True, eq=False):
    """A state that a run of the same scene can be restored to; it can be pickled.

    Attributes:
        sentences: What was ordered until then, with the times.
        scene: Digest of the compiled scene, and what it is called.
    """

    run: SavedRun
    sentences: tuple[str, ...]
    scene: tuple[str, str]


class SteppedRun:
    """A run of a scene that is advanced step by step.

    Each verb of the script is also a method: ``run.move("forceps A", by=(0, 0, 0.005),
    over="50 ms")`` means ``from T to T + 50 ms: move forceps A by (0, 0, 0.005) m using
    constant speed``. Words that Python reserves end with an underscore: ``with_``, ``from_``.

    Args:
        compiled: The scene.
        request: What it was compiled from.
        out: The result file that ``close`` writes, and nobody else until then; None for none.
        threads: Maximum number of threads for a large net; the motion does not depend on it.
        saved: Where it begins; at 0 s by default.

    Attributes:
        compiled: The scene.
        out: See above.

    Raises:
        PlaceError: The file cannot be written there, or another run is writing it.
        SimulationError: What happens at 0 s ends the run.
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
        if out is not None:
            # Nobody else writes it, until it is written or this run is forgotten.
            self._release = weakref.finalize(self, reserved(out).release)
        self._threads = threads or permitted()
        self._scene: tuple[str, str] | None = None
        if saved is not None:
            self._check(saved)
        self._texts = TextReader(compiled)
        self._sentences = list(saved.sentences if saved else ())
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
        """Return a method that orders a verb of the script."""
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
        return self.compiled.scene.simulation.duration

    @property
    def ended(self) -> str:
        """Return how the run has ended, as a sentence; empty while it can continue."""
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
        seconds = self._texts.seconds(span)
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
        self._go_to(rounded(self._texts.seconds(time)))

    @on_one_thread
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
        return self._texts.seconds(span)

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
        """Return the sum of the inner forces on each node [N], shape (node, 3).

        At planes of symmetry, it is that of the part that is drawn.
        """
        return _read_only(self.snapshot.node_force)

    @property
    def tension(self) -> Floats:
        """Return the tension of each spring [N], shape (spring,)."""
        return _read_only(self.snapshot.tension)

    @property
    def alive(self) -> NDArray[np.bool_]:
        """Return which springs, edges of elements and elements are whole, shape (entity,)."""
        return self.snapshot.state.alive

    def to_pyvista(self) -> "pyvista.UnstructuredGrid":
        """Return the net at the present time as a mesh; see ``Trajectory.to_pyvista``.

        Raises:
            ImportError: PyVista is not installed; says what to install.
        """
        from tissuec.results.conversion import to_pyvista

        return to_pyvista(present_shape(self.compiled.scene.source.name, self.snapshot))

    @property
    def events(self) -> tuple[Event, ...]:
        """Return the events so far."""
        return self._run.events

    def log(self, name: str) -> tuple[Floats, Floats]:
        """Return the rows of a log of the output block so far.

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
        return bool(self._texts.condition(what)(self.snapshot))

    def quantity(self, what: str) -> ObservedExpression:
        """Return a measure, read and checked once, to be evaluated on snapshots.

        Args:
            what: See ``measure``.

        Raises:
            CompileError: This measures nothing, or not the present.
        """
        return self._texts.quantity(what)

    # --- orders -------------------------------------------------------------------------------

    def order(self, sentence: str, *, over: str | float | None = None) -> None:
        """Order what a sentence of the script says, from the present time on.

        It is carried out when the run continues or is examined.

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
            when = f"from {begin!r} s to {rounded(begin + self._texts.seconds(over))!r} s"
        text = f"{when}: {arguments.text(sentence, 'a sentence')}"
        self._run.order(self._texts.events(text, self._run.actions))
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
        duration = None if over is None else self._texts.seconds(over)
        self.order(self._texts.sentence(verb, words, clauses, duration), over=over)

    # --- what was done ------------------------------------------------------------------------

    def save(self) -> SavedState:
        """Return the present state, to the last bit."""
        return SavedState(self._run.save(), tuple(self._sentences), self._identity())

    def restore(self, state: SavedState) -> None:
        """Go back, or over, to a state of this scene.

        Raises:
            TypeError: The state is not one that was saved.
            TissueError: It is one of another scene, or of other values.
        """
        if not isinstance(state, SavedState):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"restore takes what save returned, not {type(state).__name__}")
        self._check(state)
        self._snapshot = None
        self._sentences = list(state.sentences)
        self._run.restore(state.run)

    def _identity(self) -> tuple[str, str]:
        """Return the digest of the compiled scene, and what it is called."""
        if self._scene is None:
            request, imports = self._request, self.compiled.scene.imports
            texts = [request.source.text, *(one.text for one in imports), *request.overrides]
            values = "".join(f" with {given}" for given in request.overrides)
            digest = scene_digest("\0".join(texts), self.network)
            self._scene = digest, f'"{request.source.name}"{values}'
        return self._scene

    def _check(self, state: SavedState) -> None:
        """Check that a state is of this scene; TissueError."""
        digest, called = self._identity()
        if state.scene[0] != digest:
            raise TissueError(
                f"the state was saved by a run of {state.scene[1]}, and this is a run of "
                f"{called}; restore it in a run of the same text with the same values"
            )

    def fork(self) -> Self:
        """Return another run that is where this one is, and writes no result."""
        other = type(self)(
            self.compiled, self._request, threads=self._threads, saved=self.save()
        )
        other._texts = self._texts
        return other

    def script(self) -> str:
        """Return the scene with everything that was ordered and given, which runs the same.

        Raises:
            TissueError: The script of the scene is in a file that the scene uses.
        """
        return recorded(self._request, self._sentences)

    def close(self) -> None:
        """Write the result file, if one was requested, up to the present time.

        The scene with everything that was ordered is run once more, as ``tissuec.run`` does:
        the result has all outputs of the scene and an estimate of its error.

        Raises:
            PlaceError: The file cannot be written there.
            ResultError: Writing failed later on.
        """
        if self.out is None:
            return
        from tissuec.pipeline import compile_request, simulate

        sentences = list(self._sentences)
        if self.time < self.duration and not self.ended:
            sentences.append(f"at {self.time!r} s: end the run")
        text = recorded(self._request, sentences)
        source = replace(self._request.source, text=text)
        request = replace(self._request, source=source)
        compiled, _ = compile_request(request)
        self._release()
        simulate(compiled, self.out, request=request)
        self.out = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()


def _read_only(values: Floats) -> Floats:
    """Return a view that cannot be written to."""
    view = values.view()
    view.flags.writeable = False
    return view


def present_shape(title: str, snapshot: Snapshot) -> ExportedShape:
    """Return everything that frames could show, at the time of a snapshot.

    Args:
        title: What is drawn.
        snapshot: At one time.
    """
    network, alive = snapshot.state.network, snapshot.state.alive
    mesh = everything(network).with_cut_cells(snapshot.state.cut_cells)
    nodes = mesh.nodes
    points: dict[str, NDArray[Any]] = {
        one.stored: mesh.at_points(getattr(snapshot, one.name)[nodes], one) for one in MOTION
    }
    own: dict[str, tuple[Place, NDArray[Any]]] = {}
    for channel in always_recorded():
        numbers = FIELDS[channel.name].sample(snapshot)
        if channel.at == "node":
            points[channel.stored] = mesh.at_points(numbers[nodes], channel)
        elif channel.at == "spring":
            own[channel.stored] = "spring", numbers[mesh.springs]
    drawing = DrawnMesh(mesh, mesh.cells(alive), alive)
    points["node_id"] = drawing.node_ids
    return net_shape(title, float(snapshot.time), drawing, points, own)
