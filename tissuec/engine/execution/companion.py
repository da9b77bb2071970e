"""Estimate of the global error by a companion: a second run of the plan with finer steps.

Local error estimates miss how the motion amplifies errors, as in tearing, buckling or chaos.
Where the two runs agree within the tolerance, the tolerance is met. Where they differ, a third,
much finer run decides: if the second run converges to it, the steps were too large; if not, the
motion is chaotic and the error unknown.

A long run gets its companion in a process of its own beside it, if more than one processor is
permitted; otherwise the companion follows the run in the same process.
"""

import pickle
import shutil
import subprocess
import sys
import time as clock
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, Literal, Self, TypeAlias, get_args

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.core.arrays import evenly
from tissuec.core.processors import permitted
from tissuec.core.resources import PACKAGE
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder, sample_times
from tissuec.engine.method import Samples
from tissuec.engine.state import FLOOR
from tissuec.matter.elasticity import wall_springs
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.script.plan import Plan, without_outputs
from tissuec.script.verbs.end import without_end

FINER = 4.0  # times; where errors fall as much, the difference is 3/4 of the error at least
FINEST_FINER = 100.0  # times: of the third run
FALLEN = 0.25  # of the difference: what must be left of it where steps were too large
MOST_ROWS = 200
MOST_BYTES = 2e8
USUAL, FINEST = 1e-4, 1e-13  # tolerance, where none is written and at the least
POLLED = 0.1  # how often a process is looked after [s]
STARTING = 1.0  # what a process takes until it steps: a run that lasts longer pays for it [s]
KNOWN = 0.5  # wall time of a run after which its rest is predicted [s]
PATIENCE, LEAST_PATIENCE = 3.0, 10.0  # of the third run: times the run's own, and at least [s]
TIMES, ROWS = "times.npy", "rows.npy"

Mode: TypeAlias = Literal["auto", "process", "inline", "off"]
MODES: tuple[Mode, ...] = get_args(Mode)
State: TypeAlias = Literal["kept", "broken", "unknown", "not checked"]
JOB = "job.pickle"  # in the folder of a companion
#: What a companion runs: the command, with modules from where this process has them, and not
#: from the current folder, where anything may lie.
_START = (
    "import sys; folder, *sys.path[:] = sys.argv[1:]; from tissuec.cli import main; "
    "sys.argv = ['tissuec', 'companion', folder]; main()"
)
#: Returns the command that steps the companion of a run into a folder.
Launch: TypeAlias = Callable[[Path], Sequence[str]]


def launcher(job: object) -> Launch:
    """Return what writes a job into the folder of a companion, and gives the command to run it.

    The command is ``tissuec companion FOLDER``; ``read_job`` returns the job there.
    """

    def launch(folder: Path) -> list[str]:
        (folder / JOB).write_bytes(pickle.dumps(job))
        path = [*filter(None, sys.path), str(PACKAGE.parent)]
        return [sys.executable, "-P", "-c", _START, str(folder), *path]

    return launch


def read_job(folder: Path) -> Any:
    """Return the job that was written into the folder of a companion."""
    return pickle.loads((folder / JOB).read_bytes())


class ErrorEstimate(Struct, frozen=True, eq=False):
    """Distance of a run from its companion, compared with the tolerance.

    Attributes:
        state: "kept"; "broken" or "unknown" from the time ``since`` on; or "not checked".
        reason: Why it is unknown or was not checked, as a sentence; what to do if broken.
        since: [s]; None where the promise is kept or was not checked.
        times: When both were compared [s], shape (row,).
        apart: Largest distance of a node from that of the companion until then [m], (row,).
        relative: The same over the largest displacement until then, shape (row,).
        allowed: What the tolerance allows; infinite where nothing is promised.
        seconds: Wall time that the companion took after the run [s].
    """

    state: State
    reason: str
    since: float | None
    times: Floats
    apart: Floats
    relative: Floats
    allowed: float
    seconds: float

    @classmethod
    def unchecked(cls, reason: str, allowed: float) -> "ErrorEstimate":
        """Return the accuracy of a run without a companion."""
        none = np.zeros(0)
        return cls("not checked", reason, None, none, none, none, allowed, 0.0)

    @property
    def error(self) -> float | None:
        """Return the largest difference, relative to displacements; None if not known."""
        return float(self.relative.max()) if len(self.relative) else None

    @property
    def promise(self) -> str:
        """Return "kept", "broken from T", "unknown from T" or "not checked"."""
        return self.state if self.since is None else f"{self.state} from {self.since:g} s"

    def as_dict(self) -> dict[str, Any]:
        """Return it for a manifest."""
        return {
            "state": self.state,
            "since": self.since,
            "reason": self.reason,
            "error": self.error,
            "tolerance": None if np.isinf(self.allowed) else self.allowed,
            "seconds": round(self.seconds, 3),
        }


class Companion:
    """The companion of one run, until both are compared.

    Args:
        network, plan: Of the run.
        mode: "auto" chooses between a process beside the run and the same process after it.
        launch: Starts a process; without it there is none.
        threads: See ``Method``.
    """

    def __init__(
        self,
        network: Network,
        plan: Plan,
        mode: Mode = "auto",
        launch: Launch | None = None,
        threads: int = 1,
    ):
        self.threads = threads
        self.network, self.plan, self.mode, self._launch = network, plan, mode, launch
        times, nodes = sample_times(plan), max(network.node_count, 1)
        most = max(2, min(MOST_ROWS, int(MOST_BYTES / (48 * nodes))))
        self.times = times[evenly(len(times), most)]
        self.is_wanted = mode != "off" and bool((self.times > 0.0).any())
        kept = len(self.times) if self.is_wanted else 0
        self._own = np.full((kept, network.node_count, 3), np.nan)
        self._reach = np.zeros(kept)  # largest displacement before each of the times [m]
        self._began = _stepping_clock()
        self._process: subprocess.Popen[bytes] | None = None
        self._folder: Path | None = None
        simulation = plan.simulation
        self.allowed = simulation.tolerance or (USUAL if simulation.step is None else np.inf)

    def take(self, samples: Samples) -> None:
        """Keep the run's own positions at the times of comparison."""
        if self.is_wanted:
            places, due = keep(samples, self.times, self._own)
            self._reach[places] = samples.reach[due]

    def tick(self, time: float) -> None:
        """Start a process beside the run, if that is worth it.

        Args:
            time: That the run has come to [s].
        """
        if not self.is_wanted or self._process is not None or self._launch is None:
            return
        if self.mode == "process" or (
            self.mode == "auto" and self._left(time) > STARTING and permitted() > 1
        ):
            self._start(self._launch)

    def _left(self, time: float) -> float:
        """Return the wall time that the run is predicted to take from here on [s]."""
        waited, duration = _stepping_clock() - self._began, self.plan.simulation.duration
        return waited * (duration - time) / time if waited > KNOWN and time > 0.0 else 0.0

    def _start(self, launch: Launch) -> None:
        """Start the process; where that is refused, the companion follows the run instead."""
        self._folder = Path(mkdtemp(prefix="tissuec-companion-"))
        np.save(self._folder / TIMES, self.times)
        np.save(self._folder / ROWS, np.full_like(self._own, np.nan))
        try:
            self._process = subprocess.Popen(
                launch(self._folder),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        except OSError:
            self._launch = None

    def estimate(
        self, interrupt: Callable[[], bool] = lambda: False, *, patience: float = PATIENCE
    ) -> ErrorEstimate:
        """Wait for the companion, or step it, and compare.

        Args:
            interrupt: Asked now and then; True ends the companion early.
            patience: How long the third run may take, in wall times of the run. Without an end,
                the estimate depends on the run alone.
        """
        if self.mode == "off":
            return ErrorEstimate.unchecked("the companion run is switched off", self.allowed)
        if not self.is_wanted:
            return ErrorEstimate.unchecked("no positions are recorded after 0 s", self.allowed)
        ran, self._began = _stepping_clock() - self._began, clock.monotonic()
        other = self._rows(interrupt)
        until = clock.monotonic() + max(patience * ran, LEAST_PATIENCE)
        return self._compared(other, lambda: interrupt() or clock.monotonic() > until)

    def _rows(self, interrupt: Callable[[], bool]) -> Floats:
        """Return the positions of the companion, NaN where it did not come to."""
        if self._process is not None and self._folder is not None:
            rows = self._folder / ROWS
            with suppress(OSError, ValueError):
                while self._process.poll() is None and not interrupt():
                    with suppress(subprocess.TimeoutExpired):
                        self._process.wait(POLLED)
                    if self._ended and self._is_enough(np.load(rows, mmap_mode="r")):
                        break
                return np.array(np.load(rows, mmap_mode="r"))
        return self._stepped(FINER, interrupt)

    @property
    def _ended(self) -> bool:
        """Return whether the run ended before its duration."""
        return not np.isfinite(self._own[-1]).all()

    def _is_enough(self, rows: Floats) -> bool:
        """Return whether the companion has come as far as the run."""
        asked = np.flatnonzero(np.isfinite(self._own).all(axis=(1, 2)))
        return not len(asked) or bool(np.isfinite(rows[asked[-1]]).all())

    def _stepped(self, factor: float, interrupt: Callable[[], bool]) -> Floats:
        """Return positions with smaller steps, by ``stepped``, as far as the run has come."""
        rows = np.full_like(self._own, np.nan)
        return stepped(
            self.network,
            self.plan,
            self.times,
            factor,
            rows=rows,
            interrupt=lambda: interrupt() or (self._ended and self._is_enough(rows)),
            threads=self.threads,
        )

    def _compared(self, other: Floats, interrupt: Callable[[], bool]) -> ErrorEstimate:
        asked = np.isfinite(self._own).all(axis=(1, 2))
        known = np.asarray(asked & np.isfinite(other).all(axis=(1, 2)))
        relative, apart = self._apart(self._own, other, known)
        state: State = "kept"
        reason, since = "", None
        # Errors within the tolerance may make no more of a difference than this.
        beyond = np.flatnonzero(relative > (1.0 - 1.0 / FINER) * self.allowed)
        if np.isinf(self.allowed):
            state, reason = "not checked", "a fixed step has no tolerance"
        elif not asked.any():
            state, reason = "not checked", "the run was resumed after the last recorded time"
        elif len(beyond):
            since = float(self.times[known][beyond[0]])
            state, reason, since = self._tried(other, known, since, interrupt)
        elif not known[asked].all():
            last = self.times[known]
            state, since = "unknown", float(last[-1]) if len(last) else 0.0
            reason = "the companion run ended before the run did"
        seconds = clock.monotonic() - self._began
        times = self.times[known]
        return ErrorEstimate(
            state, reason, since, times, apart, relative, self.allowed, seconds
        )

    def _apart(self, one: Floats, other: Floats, known: Any) -> tuple[Floats, Floats]:
        """Return how far two motions are apart until the known times, relative and [m]."""
        drawn, floor = self.network.position, FLOOR * (self.network.extent or 1.0)
        # What has come back by the first of the times counts, too.
        moved = np.maximum(largest(self._own[known] - drawn), self._reach[known])
        scale = np.maximum.accumulate(np.maximum(moved, floor))
        apart = largest(one[known] - other[known])
        return np.maximum.accumulate(apart / scale), np.maximum.accumulate(apart)

    def _tried(
        self, other: Floats, known: Any, since: float, interrupt: Callable[[], bool]
    ) -> tuple[State, str, float | None]:
        """Return whether smaller steps are needed and would do, found out by taking them."""
        finest = self._stepped(FINEST_FINER, interrupt)
        asked = known & (self.times >= since)
        both = asked & np.isfinite(finest).all(axis=(1, 2))
        if not both.any():
            return "unknown", "the test with smaller steps did not finish in time", since
        own, _ = self._apart(self._own, finest, both)
        left, _ = self._apart(other, finest, both)
        small = np.maximum(FALLEN * own, 0.1 * self.allowed)
        if not (left <= small).all():
            chaos = "the result does not converge with smaller steps: the motion is chaotic"
            return "unknown", chaos + _limp(self.network), since
        beyond = np.flatnonzero(own > (1.0 - 1.0 / FINEST_FINER) * self.allowed)
        if len(beyond):
            since = float(self.times[both][beyond[0]])
            return "broken", f"write tolerance = {self.allowed / FINER:.2g}", since
        if not np.array_equal(both, asked):
            return "unknown", "the test with smaller steps did not finish in time", since
        return "kept", "", None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        """End the process where nobody waits for it any more."""
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)


def _stepping_clock() -> float:
    """Return a wall time that stands still while kernels are translated, once for good [s]."""
    from tissuec.kernels.loading import time_of_translating

    return clock.monotonic() - time_of_translating()


def _limp(network: Network) -> str:
    """Return what to do about walls that fold freely, as chaos may come of it; "" for none."""
    walls = [body.name for body in network.bodies if _is_limp(network, body)]
    if not walls:
        return ""
    verbs = ("does", "crumples", "it is") if len(walls) == 1 else ("do", "crumple", "they are")
    does, crumples, are = verbs
    return (
        f"; {' and '.join(walls)} {does} not resist bending and {crumples} where {are} "
        "compressed: write bending is elastic (of matter) or bending is soft"
    )


def _is_limp(network: Network, body: BodyPart) -> bool:
    """Return whether a body is a wall without anything that resists bending."""
    skin = network.skin_of(body)
    if not len(skin) or body.bending:
        return False
    hinges = network.hinges
    if hinges is not None and np.isin(hinges.nodes, skin).any():
        return False
    return bool(wall_springs(skin, network.ends[body.springs]).all())


def threads_beside(mode: Mode) -> int:
    """Return how many threads a run may have: half of them if a companion may be beside it."""
    return max(1, permitted() // (2 if mode in ("auto", "process") else 1))


def finer(plan: Plan, factor: float) -> Plan:
    """Return a plan with finer steps and without outputs of its own."""
    simulation = plan.simulation
    if simulation.step is None:
        tolerance = max((simulation.tolerance or USUAL) / factor, FINEST)
        simulation = replace(simulation, tolerance=tolerance)
    else:
        simulation = replace(simulation, step=2.0 * simulation.step / factor)
    return replace(without_outputs(without_end(plan)), simulation=simulation)


def stepped(
    network: Network,
    plan: Plan,
    times: Floats,
    factor: float,
    *,
    rows: Floats | None = None,
    interrupt: Callable[[], bool] | None = None,
    threads: int = 1,
) -> Floats:
    """Return positions at times with smaller steps [m], shape (time, node, 3).

    They are NaN at times that the run did not reach.

    Args:
        network: The network.
        plan: The plan of the run.
        times: Times of interest [s], ascending, shape (time,).
        factor: Factor that tolerances are divided by; fixed steps are divided by half of it.
        rows: Array to be filled; a new one by default.
        interrupt: Returns whether to stop.
        threads: See ``Method``.
    """
    from tissuec.engine.execution.run import run

    rows = np.full((len(times), network.node_count, 3), np.nan) if rows is None else rows
    plan = finer(plan, factor)
    silent = _Silent(network, plan, times, rows)
    run(network, plan, silent, interrupt=interrupt, threads=threads)
    return rows


class _Silent(Recorder):
    """A recorder that keeps positions and writes nothing."""

    takes_notes = False

    def __init__(self, network: Network, plan: Plan, times: Floats, rows: Floats):
        super().__init__(network, plan, MemoryRecording())
        self._kept = rows
        self.times = times

    def record(self, samples: Samples) -> None:
        keep(samples, self.times, self._kept)


def keep(samples: Samples, times: Floats, rows: Floats) -> tuple[Indices, NDArray[np.bool_]]:
    """Copy the positions of samples at given times into rows.

    Args:
        samples: A batch of samples.
        times: Times of interest [s], ascending, shape (time,).
        rows: Positions [m], shape (time, node, 3), changed in place.

    Returns:
        Which rows were set, shape (n,), and whether each sample is one of them, shape
        (sample,).
    """
    places = np.searchsorted(times, samples.time)
    due = (places < len(times)) & (times[np.minimum(places, len(times) - 1)] == samples.time)
    rows[places[due]] = samples.position[due]
    return places[due], due


def largest(vectors: Floats) -> Floats:
    """Return the length of the longest vector of each row, in their unit, shape (row,).

    Args:
        vectors: In any unit, shape (row, node, 3).
    """
    return np.sqrt(np.einsum("rnk,rnk->rn", vectors, vectors).max(axis=1, initial=0.0))
