"""``tissuec bench``: Measure computing time against error, including other solvers."""

import os
from pathlib import Path
from typing import Any, cast

import click

from tissuec.cli.common import (
    DONE,
    FAILED,
    WRONG_TEXT,
    Command,
    Settings,
    as_json,
    echo,
    print_json,
    report,
    scene_options,
    tell_mistakes,
)
from tissuec.core.errors import CompileError

TOLERANCES = "1e-2,1e-3,1e-4,1e-5,1e-6,1e-8"
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class Tolerances(click.ParamType):  # pyright: ignore[reportMissingTypeArgument]  # generic in newer click only
    """Numbers between commas."""

    name = "X,X,…"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[float, ...]:
        """Return the tolerances.

        Args:
            value: The text, or the tolerances.
            param: The parameter.
            ctx: Context of click.
        """
        if isinstance(value, tuple):
            given = cast("tuple[float, ...]", value)
            return given
        try:
            found = tuple(float(part) for part in value.split(","))
        except ValueError:
            self.fail(f'"{value}" is not a list of numbers such as 1e-2,1e-4')
        if not all(1e-13 <= tolerance <= 0.1 for tolerance in found):
            self.fail("a tolerance must be between 1e-13 and 0.1")
        return found


@click.command(cls=Command)
@click.argument("scene", type=click.Path(path_type=Path))
@click.option(
    "--method",
    "methods",
    multiple=True,
    metavar="NAME",
    help='Run only this solver, such as automatic or "SciPy RK45"; may be repeated.',
)
@click.option(
    "--tolerances",
    type=Tolerances(),
    default=TOLERANCES,
    show_default=True,
    help="Tolerances to run.",
)
@click.option(
    "--repeat",
    type=click.IntRange(1),
    default=3,
    show_default=True,
    help="Number of timed runs per point; the median is reported.",
)
@click.option(
    "--budget",
    type=click.FloatRange(min=0.0, min_open=True),
    default=10.0,
    show_default=True,
    metavar="SECONDS",
    help="Maximum processor time of a run; slower points are omitted.",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Plot the result to this file; needs matplotlib (extra plot).",
)
@scene_options
def command(
    settings: Settings,
    scene: Path,
    methods: tuple[str, ...],
    tolerances: tuple[float, ...],
    repeat: int,
    budget: float,
    plot: Path | None,
    overrides: tuple[str, ...],
    libraries: tuple[Path, ...],
    strict: bool,
) -> int:
    """Measure computing time against error on SCENE, for every method and for other solvers.

    The other solvers are those of SciPy and, if installed (extra bench), CVODE and MuJoCo;
    SciPy and CVODE use the compiled forces of tissuec. Times are processor times on one thread.
    Only the plot is written to a file. Exit code: 0 done; 1 no reference could be computed; 2
    the text or the command line is wrong.
    """
    use_one_thread()
    if plot is not None:
        from tissuec.view.plots.formats import check_suffix
        from tissuec.view.plots.page import need_matplotlib

        need_matplotlib()  # before all the work
        check_suffix(plot)
    return _bench(
        settings, scene, plot,
        {"methods": methods, "tolerances": tolerances, "repeat": repeat, "budget": budget},
        {"overrides": overrides, "libraries": libraries, "strict": strict},
    )  # fmt: skip


def use_one_thread() -> None:
    """Keep linear algebra to one thread, where it is not loaded yet."""
    for name in THREADS:
        os.environ.setdefault(name, "1")


def _bench(
    settings: Settings,
    scene: Path,
    plot: Path | None,
    asked: dict[str, Any],
    options: dict[str, Any],
) -> int:
    from tissuec.pipeline import compile_request
    from tissuec.scene.request import Request

    try:
        compiled, warnings = compile_request(Request.file(scene, **options))
    except CompileError as error:
        tell_mistakes(error, settings, scene=str(scene))
        return WRONG_TEXT
    if not settings.json:
        report(warnings, settings)
    from tissuec.bench.bench import bench
    from tissuec.bench.report import as_dict, as_text
    from tissuec.bench.truth import Unknown

    facts = {"scene": str(scene), "diagnostics": as_json(warnings)}
    try:
        found = bench(compiled, **asked, tell=settings.say)
    except Unknown as failure:
        if settings.json:
            print_json(facts | {"ok": False, "error": str(failure)})
        else:
            echo(f"error: {failure}", err=True)
        return FAILED
    document = facts | {"ok": True} | as_dict(found)
    if settings.json:
        print_json(document)
    else:
        echo("\n".join(as_text(found)))
    if plot is not None:
        from tissuec.view.plots import draw
        from tissuec.view.plots.formats import save

        save(draw(None, document), plot)
    return DONE
