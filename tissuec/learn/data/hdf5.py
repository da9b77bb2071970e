"""HDF5 files: results of tissuec, and H5MD files of others."""

from collections.abc import Sequence
from pathlib import Path

from tissuec.learn.data.complaints import Complaints
from tissuec.learn.data.experiment import Series
from tissuec.learn.data.h5md import GROUPS, read_h5md
from tissuec.learn.data.results import read_result
from tissuec.model.network import Network
from tissuec.results.access import FAULTS, ResultGroup
from tissuec.results.errors import ResultError
from tissuec.results.hdf5 import open_file
from tissuec.results.trajectory import Trajectory
from tissuec.script.fit_problem import Fit


def read_hdf5(fits: Sequence[Fit], network: Network, complaints: Complaints) -> list[Series]:
    """Return the series of every fit in a file; errors of single fits go to ``complaints``.

    Raises:
        CompileError: It is damaged, or neither a result nor H5MD.
    """
    path, series = complaints.data.path, list[Series]()
    kind = _kind(path)
    if kind == "other":
        message = f"{complaints.file} is an HDF5 file, but neither a result of tissuec nor H5MD"
        hint = "H5MD has the groups particles or observables"
        complaints.reject("TIS604", message, hint=hint)
    try:
        with Trajectory(path) if kind == "result" else open_file(path, "r") as file:
            for fit in fits:
                with complaints.part():
                    if isinstance(file, Trajectory):
                        series.append(read_result(fit, file, network, complaints))
                    else:
                        whole = ResultGroup(file, str(path), {})
                        series.append(read_h5md(fit, whole, network, complaints))
    except (ResultError, OSError) as error:
        complaints.reject("TIS604", f"{complaints.file} cannot be read: {error}")
    return series


def _kind(path: Path) -> str:
    """Return whose a file is; one that cannot be opened is left to what mends results."""
    try:
        with open_file(path, "r") as file:
            if "tissuec" in file or "tissuec_view" in file.attrs:
                return "result"
            return "h5md" if any(name in file for name in GROUPS) else "other"
    except FAULTS:
        return "result"
