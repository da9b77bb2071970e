"""Time against error of every method on a scene, beside SciPy, CVODE and MuJoCo.

Takes the options of "tissuec bench", and the names of other solvers, such as "SciPy RK45".
CVODE and MuJoCo need the extra bench. "tissuec plot" draws the JSON document.
"""

from typing import Any

import click

from benchmarks.rivals.offers import RIVALS
from benchmarks.rivals.ratios import with_ratios
from tissuec.analysis.bench import bench_report
from tissuec.cli import run_guarded
from tissuec.cli.bench import bench_options, measured
from tissuec.cli.common import Command, Settings
from tissuec.core.report import Report


@click.command(cls=Command, help=__doc__)
@bench_options
def main(settings: Settings, **options: Any) -> Report:
    """Measure a scene."""
    return measured(
        settings, RIVALS,
        lambda found, facts: with_ratios(bench_report(found, facts), found), **options,
    )  # fmt: skip


if __name__ == "__main__":
    raise SystemExit(run_guarded(main))
