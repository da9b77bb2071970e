"""``tissuec study``: Run a scene many times with varied values, and write one table."""

from pathlib import Path
from typing import Any

import click

from tissuec.cli.common import (
    Command,
    SceneOptions,
    Settings,
    echo,
    keep_input,
    scene_options,
    worker_options,
)
from tissuec.core.errors import CompileError, TissueError
from tissuec.core.report import STOPPED, WRONG_TEXT, Fact, Report, failed
from tissuec.core.signals import exit_code

# As in ``scene.study.entries``, which would take 50 ms of every ``--help``.
_DESIGNS = ("grid", "list", "one at a time", "latin hypercube", "sobol", "sobol indices")


@click.command(cls=Command)
@click.argument("scene", type=click.Path(path_type=Path))
@click.argument("name", required=False)
@click.option(
    "--vary",
    multiple=True,
    metavar="TEXT",
    help='A factor and its values, such as "lift = 2 mm to 10 mm in 9 steps", "lift = '
    '[2 mm, 5 mm]", "lift = normal(5 mm, 1 mm)" or "hardness of fallopian tube = '
    '[soft, hard]".',
)
@click.option(
    "--rows",
    type=click.Path(path_type=Path, dir_okay=False),
    help="CSV file with a row for each run and a column for each factor.",
)
@click.option(
    "--measure",
    multiple=True,
    metavar="TEXT",
    help='A measure, such as "max(force(forceps A))" or "tear = time of rupture".',
)
@click.option(
    "--design",
    type=click.Choice(_DESIGNS),
    help="How values are combined; by default a grid if all values are listed, otherwise a "
    "Latin hypercube.",
)
@click.option("--runs", type=click.IntRange(min=1), help="Number of runs of a random design.")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of a random design.")
@click.option(
    "--keep-results", is_flag=True, help="Write the result file of each run beside the table."
)
@click.option(
    "--no-error-estimate",
    is_flag=True,
    help="Do not check whether runs keep their tolerance; this halves the time.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Table to write, .csv or .h5; by default SCENE.NAME.csv in the current directory.",
)
@click.option("--fresh", is_flag=True, help="Discard the rows that the table has already.")
@worker_options
@scene_options
def command(
    settings: Settings,
    scene: Path,
    name: str | None,
    given: SceneOptions,
    **options: Any,
) -> Report:
    """Run SCENE many times, as its study block or the options specify.

    NAME selects one of several study blocks. The table has one row for each run and can be read
    at any moment. After an interruption, the same command continues the study. Exit code: 0
    done; 1 an expectation of the study failed; 2 the text is wrong; 3 no run could be computed;
    130 interrupted.
    """
    from tissuec.core.workers.selection import workers_of
    from tissuec.results import PlaceError
    from tissuec.studies.report import StudyProgress, study_report
    from tissuec.studies.study import prepare, run_study

    try:
        prepared = prepare(given.request(scene), name, sentences=_sentences(options))
    except (CompileError, PlaceError):
        raise
    except TissueError as error:
        raise click.UsageError(str(error)) from error
    target = options["output"] or Path(
        f"{scene.stem}.{'_'.join(prepared.study.name.split())}.csv"
    )
    keep_input(target, scene)
    diagnostics = settings.warn(prepared.warnings)
    try:
        workers = workers_of(
            options["workers"],
            options["scheduler"],
            lambda text: echo(f"\nwarning: {text}", err=True),
        )
        with StudyProgress(prepared.study.name, shown=settings.shows_progress) as line:
            result = run_study(
                prepared, workers, out=target, fresh=options["fresh"], progress=line.at
            )
    except KeyboardInterrupt as error:
        again = f"  {target} has the runs so far; the same command continues"
        parts = (Fact("", "interrupted", "failure"), Fact("", again, "remark"))
        code = exit_code(getattr(error, "signal", None))
        return Report(parts, {"error": "interrupted", "table": str(target)}, code)
    except TissueError as error:
        code = WRONG_TEXT if isinstance(error, PlaceError) else STOPPED
        return failed(error, code, scene=str(scene))
    return study_report(str(scene), prepared, result, target, diagnostics)


def _sentences(options: dict[str, Any]) -> list[str]:
    """Return the sentences of a study block that correspond to the options."""
    from tissuec.studies.writing import sentences_of

    rows = None if options["rows"] is None else options["rows"].as_posix()
    named = {key: options[key] for key in ("vary", "measure", "design", "runs", "seed")}
    found = sentences_of(**named, rows=rows)
    if options["keep_results"]:
        found.append("keep is results")
    if options["no_error_estimate"]:
        found.append("error estimate is off")
    return found
