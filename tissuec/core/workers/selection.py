"""The workers that a number or the address of a scheduler means."""

from collections.abc import Callable

from tissuec.core import arguments
from tissuec.core.workers.workers import OwnProcess, Workers, permitted


def workers_of(
    count: int | None = None,
    scheduler: str | None = None,
    tell: Callable[[str], None] | None = None,
) -> Workers:
    """Return the requested workers.

    Args:
        count: Number of processes; one is this process. By default one for each processor.
        scheduler: Address of a dask scheduler, instead.
        tell: Called if a scheduler has lost all workers; a warning by default.

    Raises:
        TypeError, ValueError: The count is no whole number of 1 or more.
        TissueError: The scheduler cannot be used.
    """
    if scheduler is not None:
        from tissuec.core.workers.cluster import Cluster, warn  # late: few use dask

        return Cluster(scheduler, tell or warn)
    count = permitted() if count is None else arguments.count(count, "workers")
    if count == 1:
        return OwnProcess()
    from tissuec.core.workers.processes import Processes

    return Processes(count)
