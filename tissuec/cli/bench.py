"""``tissuec bench``: Measure computing time against error, for every method."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from tissuec.cli.arguments import OptionReader
from tissuec.cli.common import Command, SceneOptions, Settings, scene_options
from tissuec.core.report import FAILED, Report, failed

if TYPE_CHECKING:
    from tissuec.analysis.bench import BenchResult, Rivals

F = TypeVar("F", bound=Callable[..., Any])
TOLERANCES = "1e-2,1e-3,1e-4,1e-5,1e-6,1e-8"
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def _tolerances(text: str) -> tuple[float, ...]:
    """Return the numbers between commas; ValueError if they are none or no tolerances."""
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(f'"{text}" is not a list of numbers such as 1e-2,1e-4') from None
    if not all(1e-13 <= tolerance <= 0.1 for tolerance in found):
        raise ValueError("a tolerance must be between 1e-13 and 0.1")
    return found


def bench_options(function: F) -> F:
    """Add the arguments and options of a bench."""
    options = (
        click.argument("scene", type=click.Path(path_type=Path)),
        click.option(
            "--method",
            "methods",
            multiple=True,
            metavar="NAME",
            help="Run only this method, such as automatic or dop853; may be repeated.",
        ),
        click.option(
            "--tolerances",
            type=OptionReader(_tolerances),
            metavar="X,X,…",
            default=TOLERANCES,
            show_default=True,
            help="Tolerances to run.",
        ),
        click.option(
            "--repeat",
            type=click.IntRange(1),
            default=3,
            show_default=True,
            help="Number of timed runs per point; the median is reported.",
        ),
        click.option(
            "--budget",
            type=click.FloatRange(min=0.0, min_open=True),
            default=10.0,
            show_default=True,
            metavar="SECONDS",
            help="Maximum processor time of a run; slower points are omitted.",
        ),
        click.option(
            "--plot",
            type=click.Path(path_type=Path, dir_okay=False),
            help="Plot the result to this file; needs matplotlib (extra plot).",
        ),
        scene_options,
    )
    for option in reversed(options):  # the last one applied is the first in the help
        function = option(function)
    return function


@click.command(cls=Command)
@bench_options
def command(settings: Settings, **options: Any) -> Report:
    """Measure computing time against error on SCENE, for every method.

    Errors are those of positions, relative to the largest displacement, and are measured
    against a run with a much smaller tolerance. Times are processor times on one thread. Only
    the plot is written to a file. Exit code: 0 done; 1 no reference could be computed; 2 the
    text or the command line is wrong.
    """
    use_one_thread()  # before NumPy is loaded
    from tissuec.analysis.bench import NONE, bench_report

    return measured(settings, NONE, bench_report, **options)


def use_one_thread() -> None:
    """Restrict linear algebra to one thread, unless NumPy is loaded already."""
    for name in THREADS:
        os.environ.setdefault(name, "1")


def measured(
    settings: Settings,
    rivals: "Rivals",
    reported: "Callable[[BenchResult, dict[str, Any]], Report]",
    *,
    scene: Path,
    plot: Path | None,
    given: SceneOptions,
    **asked: Any,
) -> Report:
    """Return the report on a bench, and write the plot.

    Args:
        settings: Global flags.
        rivals: Solvers of other libraries.
        reported: Makes the report.
        scene: The file.
        plot: File of the plot, if there is one.
        asked: Options of ``bench``.
    """
    if plot is not None:
        from tissuec.view.plots.formats import check_suffix
        from tissuec.view.plots.page import need_matplotlib

        need_matplotlib()  # before all the work
        check_suffix(plot)
    from tissuec.analysis.bench import Unknown, bench
    from tissuec.pipeline import compile_request

    compiled, warnings = compile_request(given.request(scene))
    facts = {"scene": str(scene), "diagnostics": settings.warn(warnings)}
    try:
        found = bench(compiled, **asked, tell=settings.say, rivals=rivals)
    except Unknown as failure:
        return failed(failure, FAILED, **facts)
    report = reported(found, facts)
    if plot is not None:
        from tissuec.view.plots import draw
        from tissuec.view.plots.formats import save

        save(draw(None, report.as_json()), plot)
    return report
