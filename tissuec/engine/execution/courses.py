"""What two runs are compared by beside positions: logs, and what expectations compare.

The error of positions does not bound that of a logged force: viscous forces follow velocities,
and stiff springs turn small errors of positions into large ones of forces. So the rows of logs,
and the numbers that expectations compare, are compared themselves.

An event that comes a moment earlier in one of the runs is no error of what it changes. Where
only a single time of comparison lies between both, it is left out.
"""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import evenly
from tissuec.core.units import show, si_unit
from tissuec.engine.execution.event_queue import SAME, rows_at, rows_within
from tissuec.engine.execution.expectations import Failure
from tissuec.engine.execution.recorder import sample_times
from tissuec.engine.method import Samples
from tissuec.model.network import Floats, Network
from tissuec.results.promise import LogError
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import ComparedCondition, LogRequest, Plan, times_every
from tissuec.script.verbs import LoggedEvent

MOST_ROWS, MOST_BYTES = 200, 2e8  # of positions
COURSE_ROWS = 32  # of each log: all would cost more than the steps of many a companion
MOST_COLUMNS = 1024  # of a log: larger ones, such as tensions of a whole body, are left out
#: The companion has errors, too: the true error is at most so many times the difference, unless
#: both runs err alike. It is more than the 4/3 of errors that shrink with the tolerance, since
#: forces of stiff nets may not.
UNKNOWN = 2.0


def _rows_of_expectations(plan: Plan, every: Floats) -> NDArray[np.bool_]:
    """Return when expectations are compared, shape (sample,).

    Args:
        plan: Of the run.
        every: All times of samples [s], shape (sample,).
    """
    near = SAME * plan.simulation.duration
    due = np.zeros(len(every), dtype=bool)
    for one in plan.expectations:
        within = np.flatnonzero(rows_within(every, one.start, one.stop, near))
        due[within[evenly(len(within), COURSE_ROWS)]] = True
        due |= rows_at(every, np.array(one.pinned), near)
    return due


def _rows_of_log(log: LogRequest, plan: Plan, every: Floats) -> NDArray[np.bool_]:
    """Return when a log is compared, shape (sample,).

    Args:
        plan: Of the run.
        every: All times of samples [s], shape (sample,).
    """
    rows = times_every(log.every, plan.simulation.duration)
    some = rows[evenly(len(rows), COURSE_ROWS)]
    return rows_at(every, some, SAME * plan.simulation.duration)


class ComparedCourse(Struct, frozen=True, eq=False):
    """Numbers over time.

    Attributes:
        columns: Where they are in a table.
        due: At which times of comparison they are known, shape (row,).
        sample: Returns them for snapshots, in SI units, shape (…, column).
    """

    columns: slice
    due: NDArray[np.bool_]
    sample: Callable[[Snapshot], Floats]


class Courses:
    """All that the runs of a plan are compared by.

    Positions are compared at some of all samples, evenly spread, and logs at some of their
    rows; whatever expectations name is among these.

    Args:
        network, plan: Of the run.

    Attributes:
        times: When runs are compared [s], shape (row,).
        logs: By the place of the log in the plan.
        expectations: By the place of the expectation in the plan.
        pinned: Times that expectations look back to [s], by the times of comparison.
        width: Number of columns of a table.
    """

    def __init__(self, network: Network, plan: Plan):
        self.plan = plan
        every, near = sample_times(plan), SAME * plan.simulation.duration
        expected = _rows_of_expectations(plan, every)
        logged = [_rows_of_log(log, plan, every) for log in plan.output.logs]
        chosen = np.logical_or.reduce([expected, *logged])
        most = int(MOST_BYTES / (48 * max(network.node_count, 1)))
        chosen[evenly(len(every), max(2, min(MOST_ROWS, most)))] = True
        self.times = times = every[chosen]
        self._is_expected = expected[chosen]
        is_of_logs = self._is_expected.copy()
        self.logs: dict[int, ComparedCourse] = {}
        self.expectations: dict[int, ComparedCourse] = {}
        self.width = 1  # the number of events until then
        start = Snapshot.of(plan.start(network)) if plan.output.logs else None
        for place, (log, rows) in enumerate(zip(plan.output.logs, logged, strict=True)):
            if start is None or not _is_compared(log):
                continue
            due = rows[chosen]
            is_of_logs |= due
            columns = self._next(len(log.measure.columns(log.subjects, start)))
            self.logs[place] = ComparedCourse(
                columns, due, partial(log.measure.sample, log.subjects)
            )
        pinned = list[float]()
        for place, one in enumerate(plan.expectations):
            compared = one.compared
            if compared is None or compared.needs_ledger:
                continue
            due = is_of_logs & rows_within(times, one.start, one.stop, near)
            columns = self._next(len(compared.comparisons))
            self.expectations[place] = ComparedCourse(columns, due, partial(_gaps, compared))
            pinned += one.pinned
        self.pinned = {
            float(row): time
            for time in pinned
            for row in times[rows_at(times, np.array([time]), near)]
        }

    def _next(self, columns: int) -> slice:
        first, self.width = self.width, self.width + columns
        return slice(first, self.width)

    def stops(self, every: int) -> Floats:
        """Return some times [s], shape (n,): from the last one back, and of expectations."""
        stops = self._is_expected.copy()
        stops[::-1][::every] = True
        return self.times[stops]

    def table(self) -> Floats:
        """Return a table of numbers in SI units, all unknown: NaN of shape (row, width)."""
        return np.full((len(self.times), self.width), np.nan)

    def sample(self, snapshot: Snapshot, rows: NDArray[np.int64], table: Floats) -> None:
        """Enter what is known at a batch of snapshots into some rows of a table.

        Args:
            snapshot: The batch.
            rows: Where its times are in ``times``, shape (sample,).
            table: Numbers in SI units, shape (row, width), changed in place.
        """
        for course in (*self.logs.values(), *self.expectations.values()):
            due = np.flatnonzero(course.due[rows])
            if len(due):
                part = snapshot if len(due) == len(rows) else snapshot.pick(due)
                table[rows[due], course.columns] = course.sample(part)


def _is_compared(log: LogRequest) -> bool:
    """Return whether a log is small enough, and what a companion can tell."""
    columns = (len(one.lines) for one in log.subjects if log.measure.takes == "springs")
    return max(columns, default=0) <= MOST_COLUMNS and not log.needs_ledger


def _gaps(compared: ComparedCondition, snapshot: Snapshot) -> Floats:
    return compared.weighed(snapshot)[1]


class Observations:
    """What a run shows of its motion and its courses, as a ``Tap`` takes it.

    Args:
        courses: What runs are compared by.
        network: Of the run.

    Attributes:
        position: At the times of comparison [m], shape (row, node, 3); NaN where not known.
        reach: Largest displacement before each of these times [m], shape (row,).
        table: Of the courses, at the same times, shape (row, width); NaN where not known.
    """

    def __init__(self, courses: Courses, network: Network):
        self.courses, self.table = courses, courses.table()
        self.position = np.full((len(courses.times), network.node_count, 3), np.nan)
        self.reach = np.zeros(len(courses.times))
        self._events = 0
        self._largest: dict[int, float] = {}
        self._gaps: dict[int, list[Floats]] = {}
        self._places = {log.name: n for n, log in enumerate(courses.plan.output.logs)}

    def take(self, samples: Samples) -> None:
        """Take positions, and how many events came before them."""
        rows, due = rows_of(self.courses.times, samples.time)
        self.position[rows] = samples.position[due]
        self.reach[rows] = samples.reach[due]
        self.table[rows, 0] = self._events

    def happened(self, logged_event: LoggedEvent) -> None:
        """Count an event."""
        self._events += counts(logged_event)

    def log(self, name: str, time: Floats, rows: Floats) -> None:
        """Take rows of a log, shape (row, column), at times [s], shape (row,)."""
        place = self._places[name]
        if (course := self.courses.logs.get(place)) is None or not rows.size:
            return
        known, due = rows_of(self.courses.times, time)
        self.table[known, course.columns] = rows[due]
        largest = float(np.abs(rows[np.isfinite(rows)]).max(initial=0.0))
        self._largest[place] = max(largest, self._largest.get(place, 0.0))

    def judged(self, place: int, time: Floats | None, gaps: Floats) -> None:
        """Take gaps of an expectation.

        Args:
            place: Of the expectation in the plan.
            time: Times of samples [s], shape (row,); None for times between samples.
            gaps: In SI units, shape (row, comparison).
        """
        course = self.courses.expectations.get(place)
        if course is None:
            return
        self._gaps.setdefault(place, []).append(gaps)
        if time is not None:
            known, due = rows_of(self.courses.times, time)
            self.table[known, course.columns] = gaps[due]

    def log_errors(self, other: Floats) -> dict[str, LogError]:
        """Return the errors of all logs that could be compared, by name.

        Args:
            other: The table of the companion, in SI units, shape (row, width).
        """
        found: dict[str, LogError] = {}
        for place, course in self.courses.logs.items():
            apart = self._apart(course, other)
            if not len(apart):
                continue
            log, largest = self.courses.plan.output.logs[place], self._largest[place]
            worst = float(apart.max())
            error = worst / largest if largest else float(worst > 0.0)
            found[log.name] = LogError(error, worst, largest, si_unit(log.measure.dimension))
        return found

    def undecided(self, other: Floats, failures: Mapping[int, Failure]) -> dict[int, str]:
        """Return what is said of expectations that errors may decide otherwise, by place.

        Args:
            other: The table of the companion, in SI units, shape (row, width).
            failures: Of the run, by place.
        """
        found: dict[int, str] = {}
        for place, course in self.courses.expectations.items():
            compared = self.courses.plan.expectations[place].compared
            apart = self._apart(course, other)
            if compared is None or not len(apart) or place not in self._gaps:
                continue
            errors, gaps = apart.max(axis=0), np.concatenate(self._gaps[place])
            may_hold, may_fail = compared.possible(gaps, errors)
            is_open = may_hold & may_fail
            if place in failures:
                found_so, _ = compared.possible(gaps, np.zeros_like(errors))
                is_open &= ~found_so & may_hold.all()
            if not is_open.any():
                continue
            near = np.where(errors > 0.0, np.abs(gaps[is_open]), np.inf)
            near /= np.where(errors > 0.0, errors, 1.0)
            row, column = divmod(int(near.argmin()), near.shape[1])
            dimension = compared.comparisons[column].dimension
            by = show(float(abs(gaps[is_open][row, column])), dimension)
            error = show(float(errors[column]), dimension)
            verb = "fails" if place in failures else "holds"
            found[place] = f"{verb} by {by}, but the error is {error}"
        return found

    def _apart(self, course: ComparedCourse, other: Floats) -> Floats:
        """Return bounds of errors where both runs are known, shape (row, column)."""
        one, two = self.table[:, course.columns], other[:, course.columns]
        known = np.isfinite(one).all(axis=1) & np.isfinite(two).all(axis=1)
        differ = self.table[:, 0] != other[:, 0]
        agrees_beside = ~np.append(differ[1:], True) & ~np.append(True, differ[:-1])
        known &= ~(differ & agrees_beside)
        return UNKNOWN * np.abs(one[known] - two[known])


def counts(logged_event: LoggedEvent) -> bool:
    """Return whether an event may change what is compared; companions take no notes."""
    return logged_event.kind != "note"


def rows_of(times: Floats, asked: Floats) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return which of some times are asked for, and which of those asked for they are.

    Args:
        times: Ascending [s], shape (row,).
        asked: Times [s], shape (sample,).

    Returns:
        Rows, shape (n,), and whether each sample is one of them, shape (sample,).
    """
    places = np.searchsorted(times, asked)
    due = (places < len(times)) & (times[np.minimum(places, len(times) - 1)] == asked)
    return places[due], due
