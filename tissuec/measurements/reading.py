"""From a file of data to an experiment."""

from collections.abc import Sequence
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any

import numpy as np

from tissuec.core.errors import CompileError, Diagnostic, counted
from tissuec.core.files import open_regular, read_rest
from tissuec.core.hints import nearby_file
from tissuec.core.structs import replace
from tissuec.core.units import TIME, show
from tissuec.measurements.experiment import Experiment, Series
from tissuec.measurements.rows import Complaints
from tissuec.measurements.tables import read_table
from tissuec.model.network import Network
from tissuec.script.fit_problem import (
    START_POSITION,
    START_VELOCITY,
    Adjust,
    Data,
    DataAxis,
    Fit,
    FitProblem,
)

_HDF5 = b"\x89HDF\r\n\x1a\n"
#: Places of its mark: at the start, or after a block of the user.
_PLACES = (0, 512, 1024, 2048)
_LARGEST_TABLE = 1 << 30  # bytes
#: By which part of a run a time may be outside of it: by rounding only.
_ROUNDING = 1e-9


def read_experiment(data: Data, fit_problem: FitProblem, network: Network) -> Experiment:
    """Return the measurements of one experiment for every fit.

    A file is a table as text, a result of tissuec or an H5MD file, whatever it is called.

    Args:
        data: One of those of ``fit_problem``, the learn block.
        network: Of the scene as it is set for this experiment.

    Raises:
        CompileError: The file cannot be read, or does not hold what is fitted; every finding
            is at the name of the file or at the column.
    """
    complaints = Complaints(data, len(fit_problem.data) < 2)
    try:
        digest, content = _opened(data.path)
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        hint = "" if data.path.exists() else nearby_file(data.path, data.path.suffix)
        complaints.reject("TIS604", f'cannot read "{data.path}": {reason}', hint=hint)
    axis, fits = fit_problem.axis, fit_problem.fits
    if content is None:
        series = _read_hdf5(axis, fits, network, complaints)
    else:
        series = read_table(content, axis, fits, network, complaints)
    if data.start:
        if fit_problem.axis.nodes is not None:
            complaints.reject("TIS306", "rows over a displacement have no time")
        series = [_started(one, data.start) for one in series]
    for one in series:
        if not one.known.any():
            complaints.found.append(_empty(one, complaints))
    complaints.settle()
    timed = fit_problem.axis.nodes is None
    return Experiment(complaints.file, digest, tuple(series), data, timed)


def check_times(experiment: Experiment, duration: float) -> None:
    """Check that a run reaches everything that was measured.

    Args:
        duration: Of the run [s].

    Raises:
        CompileError: Something was measured before the start of the run or after its end.
    """
    if not experiment.timed:
        return
    complaints = Complaints(experiment.data)
    first = min((float(s.times[0]) for s in experiment.series if len(s.times)), default=0.0)
    name, last = experiment.name, experiment.duration
    if first < -_ROUNDING * duration:
        complaints.reject(
            "TIS703",
            f"{name} begins at {show(first, TIME)}, and a run begins at 0 s",
            hint=f"count times from the start of the run: {_from(experiment, first)}; or "
            "remove earlier measurements",
        )
    if last > duration * (1 + _ROUNDING):
        # As long as the run, but later: another clock.
        is_late = first > 0.0 and last - first <= duration * (1 + _ROUNDING)
        longer = f"write in simulate: duration = {show(last, TIME, digits=6)}"
        if last / 1000.0 <= duration * (1 + _ROUNDING):
            longer = (
                "times are in s where nothing else is written: if they are in ms, name the "
                f'column t_ms, or write time using column "…" in ms; otherwise {longer}'
            )
        hint = (
            f"count times from the start of the run: {_from(experiment, first)}"
            if is_late
            else f"{longer}, or remove later measurements"
        )
        complaints.reject(
            "TIS703",
            f"{name} ends at {show(last, TIME)}, and the run at {show(duration, TIME)}",
            hint=hint,
        )


def check_count(experiments: Sequence[Experiment], fit_problem: FitProblem) -> None:
    """Check that there are as many numbers as a fit has parameters at least.

    Words and regions may have more parameters than are counted here.

    Args:
        experiments: Those of the data of the problem.

    Raises:
        CompileError: There are fewer.
    """
    learnt = [one for one in experiments if not one.data.held_out]
    parts = [one.split(fit_problem.last_part)[0] for one in learnt]
    many = sum(int(np.isfinite(s.values).sum()) for one in parts for s in one.series)
    least = sum(_least(adjust) for adjust in fit_problem.adjusts)
    expected = sum(_least(one) for one in fit_problem.adjusts if one.prior is not None)
    if many + expected < least:
        names = [one.name for one in learnt]
        raise CompileError([too_few(names, many, least, fit_problem)])


def _least(adjust: Adjust) -> int:
    """Return how many parameters an entry has at least."""
    if adjust.per not in ("node", "spring"):
        return 1
    is_vector = adjust.what in (START_POSITION, START_VELOCITY) and adjust.along is None
    return len(adjust.members) * (3 if is_vector else 1)


def too_few(
    files: Sequence[str], many: int, parameters: int, fit_problem: FitProblem
) -> Diagnostic:
    """Return an error about fewer numbers in files than parameters."""
    return Diagnostic(
        "TIS802",
        f"{' and '.join(files)}: {counted(many, 'number')}, fewer than the {parameters} "
        "parameters of the fit",
        fit_problem.span,
        "measure more, adjust less, or write expected values: around … by …",
    )


def _from(experiment: Experiment, first: float) -> str:
    """Return how data is written that begins at another time."""
    start = experiment.data.start + first
    return f'data "{experiment.name}" from {show(start, TIME, digits=6)}'


def _started(one: Series, start: float) -> Series:
    """Return a series whose times count from another one [s]."""
    kept = one.at(one.times >= start - _ROUNDING * abs(start))
    return replace(kept, times=np.maximum(kept.times - start, 0.0))


def _opened(path: Path) -> tuple[str, bytes | None]:
    """Return the SHA-256 of a file in hexadecimal digits, and its content unless it is HDF5.

    Raises:
        OSError: It cannot be read, is no regular file, or is a table that is too large.
    """
    with open_regular(path) as file:
        head = file.read(_PLACES[-1] + len(_HDF5))
        file.seek(0)
        if any(head.startswith(_HDF5, place) for place in _PLACES):
            readable: Any = file  # in blocks, for such a file may be larger than memory
            return file_digest(readable, "sha256").hexdigest(), None
        content = read_rest(file, _LARGEST_TABLE)
    return sha256(content).hexdigest(), content


def _read_hdf5(
    axis: DataAxis, fits: Sequence[Fit], network: Network, complaints: Complaints
) -> list[Series]:
    if axis.nodes is not None:
        complaints.reject(
            "TIS313",
            f"{complaints.file} has times, but this block uses a displacement",
            hint="measure over time, or give a table of displacements",
        )
    from tissuec.measurements.hdf5 import read_hdf5  # late: tables need no h5py

    return read_hdf5(fits, network, complaints)


def _empty(one: Series, complaints: Complaints) -> Diagnostic:
    """Return the finding about a fit of which nothing was measured during the run."""
    message, start = f"{complaints.file} contains no value of {one.fit.text}", ""
    if complaints.data.start:
        start = f" from {show(complaints.data.start, TIME, digits=6)} on"
    return Diagnostic("TIS313", message + start, one.fit.span)
