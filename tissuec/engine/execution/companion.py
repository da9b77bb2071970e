"""Estimate of the global error by a companion: a second run of the plan with finer steps.

Local error estimates miss how the motion amplifies errors, as in tearing, buckling or chaos,
and what a method itself does wrong. So the companion has finer steps of a method of another
kind, that of ``engine.execution.finer_run``. Where that would take too long, the same method
checks its own steps, which is no promise of the result.

Logs, and what expectations compare, are compared as well (``engine.execution.courses``).

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
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import inf
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, Literal, Self, TypeAlias, get_args

import numpy as np
from msgspec import Struct
from msgspec.json import decode, encode
from msgspec.structs import asdict
from numpy.typing import NDArray

from tissuec.core.resources import PACKAGE
from tissuec.core.structs import replace
from tissuec.core.units import LENGTH, show
from tissuec.core.workers.workers import permitted
from tissuec.engine.execution.courses import Courses, Observations
from tissuec.engine.execution.expectations import Failure
from tissuec.engine.execution.finer_run import (
    LEAST,
    MOST,
    USUAL,
    Allowance,
    Progressed,
    counterpart,
    foreseen,
    is_another,
    is_path_simple,
    largest,
    own_steps,
    stepped,
)
from tissuec.engine.method import Statistics
from tissuec.engine.run_arrays import FLOOR
from tissuec.kernels.records import GLANCES
from tissuec.model.network import BodyPart, Floats, Network
from tissuec.results.promise import LogError
from tissuec.script.plan import Plan

FINER = 4.0  # times; where errors fall as much, the difference is 3/4 of the error at least
FINEST_FINER = 100.0  # times: of the third run
FALLEN = 0.25  # of the difference: what must be left of it where steps were too large
RESOLUTION = 16.0 * np.finfo(float).eps  # of coordinates: differences that do not count
ROUNDED = 1e4 * np.finfo(float).eps  # of coordinates: differences that roundings may add up to
#: Of equilibria that do not depend on the way to them: steps four times as long confirm that.
COARSER, SEVERAL, SAME_STATE = 0.5, 4, 1e-7
ENDED = "the companion run ended before the run did"
POLLED = 0.1  # how often a process is looked after [s]
STARTING = 1.0  # what a process takes until it steps: a run that lasts longer pays for it [s]
KNOWN = 0.5  # wall time of a run after which its rest is predicted [s]
PATIENCE, LEAST_PATIENCE = 3.0, 10.0  # of the third run: times the run's own, and at least [s]
ROWS, TABLE, ORDER, ALLOWANCE = "rows.npy", "table.npy", "order.json", "allowance.txt"

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
    """Return a writer of a job into the folder of a companion, which returns its command.

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


class CompanionOrder(Struct, frozen=True):
    """What a companion in a process is to do; see ``stepped``."""

    method: str
    spacing: float
    factor: float
    every: int


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
        method: Of the companion; "" without one.
        differs: Whether that is of another kind than all that stepped the run.
        steps: How many times shorter the steps of the companion are, where those of the run are
            fixed; below 1, they are longer.
        least: What ``relative`` is relative to [m], where displacements stay below it; None
            where they do not, or where nothing moves.
        logs: Errors of logs, by name, where they could be compared.
        undecided: Of expectations that these errors may decide otherwise, what to say, by their
            places in the plan.
    """

    state: State
    reason: str
    since: float | None
    times: Floats
    apart: Floats
    relative: Floats
    allowed: float
    seconds: float
    method: str = ""
    differs: bool = False
    steps: float = 2.0
    least: float | None = None
    logs: Mapping[str, LogError] = {}
    undecided: Mapping[int, str] = {}

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
            "method": self.method,
            "differs": self.differs,
            "steps": self.steps,
            "least": self.least,
            "logs": {name: asdict(one) for name, one in self.logs.items()},
        }


class Companion:
    """The companion of one run, until both are compared.

    Args:
        network, plan: Of the run.
        mode: "auto" chooses between a process beside the run and the same process after it.
        launch: Starts a process; without it there is none.
        threads: See ``Method``.

    Attributes:
        tap: What the recorder of the run shows its samples to; None where nothing is compared.
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
        courses = None if mode == "off" else Courses(network, plan)
        self.tap: Observations | None = None
        if courses is not None and (courses.times > 0.0).any():
            self.tap = Observations(courses, network)
            self.times = courses.times
            self._own, self._reach = self.tap.position, self.tap.reach
            self._theirs = courses.table()  # what the companion observed
        self._began = _stepping_clock()
        self._process: subprocess.Popen[bytes] | None = None
        self._folder: Path | None = None
        self._most = inf  # predicted cost that all companions may have [s]
        self._progress, self._spent = Progressed(), 0.0
        self._method = ""  # of the companion; "" for that of the plan
        self._differs = False  # from all that stepped the run
        # The ``factor`` of the companion, and of how many times one is compared.
        self._steps = (COARSER, SEVERAL) if is_path_simple(network, plan) else (FINER, 1)
        self._spacing = 0.0  # at which the companion tests conditions [s]
        simulation = plan.simulation
        self.allowed = simulation.tolerance or (USUAL if simulation.step is None else np.inf)

    def tick(self, time: float, ran: Statistics) -> None:
        """Start a process beside the run, if that is worth it.

        Args:
            time: That the run has come to [s].
            ran: What it did until then.
        """
        self._progress.note(time, ran.cost)
        if self.tap is None or self._process is not None or self._launch is None:
            return
        if self.mode == "process" or (
            self.mode == "auto" and self._left(time) > STARTING and permitted() > 1
        ):
            self._method = counterpart(ran, self.network, self.plan)
            self._space(time, ran)
            if not self._is_dear(ran):
                self._start(self._launch)

    def _space(self, time: float, ran: Statistics) -> None:
        """Have conditions tested as densely in time as in the run, however short steps are.

        Args:
            time: That the run has come to [s].
            ran: What it did until then.
        """
        # Integrators of other packages run as Python, with times that are numbers of NumPy.
        self._spacing = float(time) / max(GLANCES * ran.accepted, 1)

    def _left(self, time: float) -> float:
        """Return the wall time that the run is predicted to take from here on [s]."""
        waited, duration = _stepping_clock() - self._began, self.plan.simulation.duration
        return waited * (duration - time) / time if waited > KNOWN and time > 0.0 else 0.0

    def _start(self, launch: Launch) -> None:
        """Start the process; where that is refused, the companion follows the run instead."""
        self._folder = Path(mkdtemp(prefix="tissuec-companion-"))
        np.save(self._folder / ROWS, np.full_like(self._own, np.nan))
        np.save(self._folder / TABLE, self._theirs)
        (self._folder / ORDER).write_bytes(
            encode(CompanionOrder(self._method, self._spacing, *self._steps))
        )
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
        self,
        ran: Statistics,
        interrupt: Callable[[], bool] = lambda: False,
        *,
        failures: Sequence[Failure] = (),
        patience: float = PATIENCE,
    ) -> ErrorEstimate:
        """Wait for the companion, or step it, and compare.

        Args:
            ran: What the run did.
            failures: Expectations that did not hold in it.
            interrupt: Called now and then; True ends the companion early.
            patience: How long the third run may take, in wall times of the run. Without an end,
                the estimate depends on the run alone.
        """
        if self.mode == "off":
            return ErrorEstimate.unchecked("the companion run is switched off", self.allowed)
        if self.tap is None:
            return ErrorEstimate.unchecked("no positions are recorded after 0 s", self.allowed)
        self._most = max(MOST * ran.cost, LEAST)
        ended = self.times[_known(self._own)]
        self._space(float(ended.max(initial=0.0)), ran)
        took, self._began = _stepping_clock() - self._began, clock.monotonic()
        until = clock.monotonic() + max(patience * took, LEAST_PATIENCE)
        found, limit = self._by_another(ran, interrupt)
        if limit and not interrupt():
            self._method, self._differs = "", False
            left = max(self._most - self._spent, 0.0) + own_steps(ran, FINER)
            found = self._stepped(FINER, interrupt, most=left)
        estimate = self._compared(found, lambda: interrupt() or clock.monotonic() > until)
        failed = {one.expectation: one for one in failures}
        estimate = replace(
            estimate,
            method=self._method or ran.method,
            differs=self._differs,
            steps=0.5 * self._steps[0],
            logs=self.tap.log_errors(self._theirs),
            undecided=self.tap.undecided(self._theirs, failed),
        )
        is_late = estimate.reason == ENDED and not interrupt()
        if limit and (estimate.state == "kept" or is_late):
            return replace(estimate, state="not checked", reason=limit, since=None)
        return estimate

    def _by_another(self, ran: Statistics, interrupt: Callable[[], bool]) -> tuple[Floats, str]:
        """Return the positions of a companion of another kind, NaN where it did not come to.

        The second result says why it is no check of the whole run, if so.
        """
        used = {change.method for change in ran.changes}
        is_fixed = self.plan.simulation.step is not None
        self._differs = is_another(self._method, used)
        if is_fixed:
            return self._by_other_steps(interrupt), ""
        if self._process is not None and self._differs:
            rows, is_late = self._from_process(interrupt)
            return rows, self._too_dear(ran, rows) if is_late else ""
        self._method = counterpart(ran, self.network, self.plan)
        if not self._method:
            own = ", ".join(sorted(used))
            return self._own, (
                f"no method of another kind can step this net in {MOST:g} times the time of "
                f"the run, and finer steps of {own} alone confirm the result"
            )
        rows = np.full_like(self._own, np.nan)
        if not self._is_dear(ran):
            rows = self._stepped(FINER, interrupt, most=self._most)
        self._differs = True
        known, asked = _known(rows), _known(self._own)
        relative, _ = self._apart(self._own, rows, known & asked)
        is_enough = known[asked].all() or (relative > self._agreed).any()
        return rows, "" if is_enough else self._too_dear(ran, rows)

    def _by_other_steps(self, interrupt: Callable[[], bool]) -> Floats:
        """Return the positions of a companion of a run with fixed steps."""
        if self._process is not None:
            rows, _ = self._from_process(interrupt)
        else:
            rows = self._stepped(self._steps[0], interrupt, every=self._steps[1])
        if self._steps[0] == FINER:
            return rows
        both = _known(self._own) & _known(rows)
        relative, _ = self._apart(self._own, rows, both)
        if both.any() and relative.max(initial=0.0) <= SAME_STATE:
            return rows
        self._steps = FINER, 1
        return self._stepped(FINER, interrupt)

    @property
    def _agreed(self) -> float:
        """Return how much of a difference errors within the tolerance may make at most."""
        return (1.0 - 1.0 / FINER) * self.allowed

    def _is_dear(self, ran: Statistics) -> bool:
        """Return whether the companion is sure to take too long."""
        if not self._method:
            return False
        times = foreseen(self._method, ran, min(self.allowed, 1.0), FINER)
        return times > MOST and times * ran.cost > LEAST

    def _too_dear(self, ran: Statistics, rows: Floats) -> str:
        """Return which part is unchecked, where the companion reached only some of the rows."""
        own = ", ".join(dict.fromkeys(change.method for change in ran.changes))
        known = self.times[_known(rows)]
        until = float(known.max(initial=0.0))
        ended = f" (it ended at {until:g} s)" if until else ""
        return (
            f"{self._method}, a method of another kind, takes more than {MOST:g} times the "
            f"time of the run{ended}, and finer steps of {own} alone confirm the result"
        )

    def _from_process(self, interrupt: Callable[[], bool]) -> tuple[Floats, bool]:
        """Return the positions of the companion in the process, and whether it was too slow."""
        assert self._process is not None and self._folder is not None
        rows = self._folder / ROWS
        (self._folder / ALLOWANCE).write_text(repr(self._most), encoding="utf-8")
        try:
            while self._process.poll() is None and not interrupt():
                with suppress(subprocess.TimeoutExpired):
                    self._process.wait(POLLED)
                if self._ended and self._is_enough(np.load(rows, mmap_mode="r")):
                    break
            found = np.array(np.load(rows, mmap_mode="r"))
            self._theirs = np.load(self._folder / TABLE)
        except (OSError, ValueError):
            return np.full_like(self._own, np.nan), False
        return found, self._process.poll() == 0 and not self._is_enough(found)

    @property
    def _ended(self) -> bool:
        """Return whether the run ended before its duration."""
        return not np.isfinite(self._own[-1]).all()

    def _is_enough(self, rows: Floats) -> bool:
        """Return whether the companion has come as far as the run."""
        each = slice((len(self.times) - 1) % self._steps[1], None, self._steps[1])
        asked = np.arange(len(self.times))[each]
        asked = asked[_known(self._own[each])]
        return not len(asked) or bool(np.isfinite(rows[asked[-1]]).all())

    def _stepped(
        self, factor: float, interrupt: Callable[[], bool], *, most: float = inf, every: int = 1
    ) -> Floats:
        """Return positions with smaller steps, by ``stepped``, as far as the run has come."""
        assert self.tap is not None, "otherwise nothing is compared"
        rows, courses = np.full_like(self._own, np.nan), self.tap.courses
        self._theirs = courses.table()
        allowance = Allowance(lambda: most, self._progress)
        found = stepped(
            self.network,
            self.plan,
            self.times,
            factor,
            method=self._method,
            rows=rows,
            courses=courses,
            table=self._theirs,
            spacing=self._spacing,
            every=every,
            allowance=allowance,
            interrupt=lambda: interrupt() or (self._ended and self._is_enough(rows)),
            threads=self.threads,
        )
        self._spent += allowance.spent
        return found

    def _compared(self, other: Floats, interrupt: Callable[[], bool]) -> ErrorEstimate:
        asked = _known(self._own)
        known = asked & _known(other)
        relative, apart = self._apart(self._own, other, known)
        state: State = "kept"
        reason, since = "", None
        beyond = np.flatnonzero(relative > self._agreed)
        if np.isinf(self.allowed):
            state, reason = "not checked", "a fixed step has no tolerance"
        elif not asked.any():
            state, reason = "not checked", "the run was resumed after the last recorded time"
        elif len(beyond):
            since = float(self.times[known][beyond[0]])
            theirs = self._theirs
            state, reason, since, closer = self._tried(other, known, since, interrupt)
            self._theirs = np.where(np.isnan(self._theirs), theirs, self._theirs)
            if closer is not None:  # the companion erred, and not the run
                relative, apart = (
                    np.maximum.accumulate(np.concatenate([before[: beyond[0]], after]))
                    for before, after in zip((relative, apart), closer, strict=True)
                )
        elif not known[asked].all():
            last = self.times[known]
            state, since = "unknown", float(last[-1]) if len(last) else 0.0
            reason = ENDED
        seconds = clock.monotonic() - self._began
        times = self.times[known]
        is_small = 0.0 < self._moved(known).max(initial=0.0) < self._floor
        return ErrorEstimate(
            state, reason, since, times, apart, relative, self.allowed, seconds,
            least=self._floor if is_small else None,
        )  # fmt: skip

    @property
    def _floor(self) -> float:
        """Return the displacement below which errors are relative to it [m]."""
        return FLOOR * (self.network.extent or 1.0)

    def _moved(self, known: NDArray[np.bool_]) -> Floats:
        """Return the largest displacement until each of some times [m], shape (row,)."""
        # What has come back by the first of the times counts, too.
        moved = largest(self.network.moved(self._own[known]))
        return np.maximum.accumulate(np.maximum(moved, self._reach[known]))

    def _apart(
        self, one: Floats, other: Floats, known: NDArray[np.bool_]
    ) -> tuple[Floats, Floats]:
        """Return how far two motions are apart until the known times, relative and [m]."""
        scale = np.maximum(self._moved(known), self._floor)
        apart = largest(one[known] - other[known])
        apart = np.maximum(apart - RESOLUTION * self._coordinates, 0.0)
        return np.maximum.accumulate(apart / scale), np.maximum.accumulate(apart)

    def _tried(
        self, other: Floats, known: Any, since: float, interrupt: Callable[[], bool]
    ) -> tuple[State, str, float | None, tuple[Floats, Floats] | None]:
        """Find out by smaller steps whether they are needed and would do.

        Returns:
            State, reason and time, and where the run keeps its promise, how far it is from the
            motion with smaller steps from ``since`` on, relative and [m].
        """
        finest = self._stepped(FINEST_FINER, interrupt, most=MOST * self._most)
        asked = known & (self.times >= since)
        both = asked & _known(finest)
        if not both.any():
            return "unknown", "the test with smaller steps did not finish in time", since, None
        own, apart = self._apart(self._own, finest, both)
        left, _ = self._apart(other, finest, both)
        beyond = np.flatnonzero(own > (1.0 - 1.0 / FINEST_FINER) * self.allowed)
        small = np.maximum(FALLEN * own, 0.1 * self.allowed)
        if len(beyond) and not (left <= small).all():
            return "unknown", self._why_unknown(own[-1], apart[-1]), since, None
        if len(beyond):
            since = float(self.times[both][beyond[0]])
            way_out = f"write tolerance = {self.allowed / FINER:.2g}"
            if self._differs:
                way_out += f" or integrator is {self._method}"
            return "broken", way_out, since, None
        if not np.array_equal(both, asked):
            return "unknown", "the test with smaller steps did not finish in time", since, None
        return "kept", "", None, (own, apart)

    def _why_unknown(self, relative: float, apart: float) -> str:
        """Return why smaller steps do not help, from the largest difference of them [m]."""
        if apart < ROUNDED * self._coordinates:
            return (
                f"rounding errors of the coordinates, of {show(apart, LENGTH)}, are larger "
                f"than the tolerance allows: write tolerance = {2.0 * relative:.1g}"
            )
        chaos = "the result does not converge with smaller steps: the motion is chaotic"
        return chaos + _limp(self.network)

    @property
    def _coordinates(self) -> float:
        """Return the largest coordinate as drawn [m]."""
        return float(np.abs(self.network.position).max(initial=0.0))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        """End the process where nobody waits for it any more."""
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)


def _known(position: Floats) -> NDArray[np.bool_]:
    """Return at which times positions are known, shape (row,), of shape (row, node, 3)."""
    return np.asarray(np.isfinite(position).all(axis=(1, 2)))


def _stepping_clock() -> float:
    """Return a wall time that stands still while kernels are translated, once for good [s]."""
    from tissuec.compiled.loading import time_of_translating

    return clock.monotonic() - time_of_translating()


def _limp(network: Network) -> str:
    """Return the remedy for walls that fold freely, which may cause chaos; "" for none."""
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
    from tissuec.matter.elasticity import wall_springs

    if any(np.isin(one.nodes, skin).any() for one in network.of_kind("plates")):
        return False
    return bool(wall_springs(skin, network.line_ends[body.lines]).all())


def threads_beside(mode: Mode) -> int:
    """Return how many threads a run may have: half of them if a companion may be beside it."""
    return max(1, permitted() // (2 if mode in ("auto", "process") else 1))


def order_in(folder: Path) -> CompanionOrder:
    """Return the task of a companion in a process."""
    return decode((folder / ORDER).read_bytes(), type=CompanionOrder)


def allowance_in(folder: Path) -> Allowance:
    """Return the allowance of a companion in a process; there is none before the run ends."""

    def most() -> float:
        with suppress(OSError, ValueError):
            return float((folder / ALLOWANCE).read_text(encoding="utf-8"))
        return inf

    return Allowance(most)
