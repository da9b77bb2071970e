"""``tissuec companion``: the process that a run starts beside itself; not for people."""

from pathlib import Path

import click

from tissuec.cli.common import Command, Settings


@click.command(cls=Command, hidden=True)
@click.argument("folder", type=click.Path(path_type=Path))
def command(settings: Settings, folder: Path) -> None:
    """Step the companion run that FOLDER describes."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the run, which ends this
    step_companion(folder)


def step_companion(folder: Path) -> None:
    """Step the companion run that a folder describes, and leave its positions there."""
    import os
    import shutil

    import numpy as np

    from tissuec.engine.execution.companion import (
        ROWS,
        TABLE,
        TIMES,
        allowance_in,
        order_in,
        read_job,
    )
    from tissuec.engine.execution.courses import Courses, times_of_comparison
    from tissuec.engine.execution.finer_run import stepped
    from tissuec.pipeline import compile_request

    parent = os.getppid()
    request, threads = read_job(folder)
    compiled, _ = compile_request(request)
    network, plan, times = compiled.network, compiled.plan, np.load(folder / TIMES)
    rows, table = (np.load(folder / name, mmap_mode="r+") for name in (ROWS, TABLE))
    _, every = times_of_comparison(network, plan)
    order = order_in(folder)
    stepped(
        network, plan, times, order.factor,
        method=order.method, rows=rows, courses=Courses(network, plan, times, every),
        table=table, spacing=order.spacing, every=order.every,
        allowance=allowance_in(folder), interrupt=lambda: os.getppid() != parent,
        threads=threads,
    )  # fmt: skip
    if os.getppid() != parent:  # the run was killed, and nobody else removes its folder
        shutil.rmtree(folder, ignore_errors=True)
