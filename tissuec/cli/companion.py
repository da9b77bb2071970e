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
        allowance_in,
        order_in,
        read_job,
    )
    from tissuec.engine.execution.courses import Courses
    from tissuec.engine.execution.finer_run import stepped
    from tissuec.pipeline import compile_request

    parent = os.getppid()
    request, threads = read_job(folder)
    compiled, _ = compile_request(request)
    network, plan = compiled.network, compiled.plan
    rows, table = (np.load(folder / name, mmap_mode="r+") for name in (ROWS, TABLE))
    courses, order = Courses(network, plan), order_in(folder)
    stepped(
        network, plan, courses.times, order.factor,
        method=order.method, rows=rows, courses=courses,
        table=table, spacing=order.spacing, every=order.every,
        allowance=allowance_in(folder), interrupt=lambda: os.getppid() != parent,
        threads=threads,
    )  # fmt: skip
    if os.getppid() != parent:  # the run was killed, and nobody else removes its folder
        shutil.rmtree(folder, ignore_errors=True)
