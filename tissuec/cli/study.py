"""``tissuec study``: Run a scene many times with varied values, and write one table."""

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import (
    DONE,
    FAILED,
    STOPPED,
    WRONG_TEXT,
    Command,
    Settings,
    as_json,
    echo,
    keep_input,
    print_json,
    report,
    scene_options,
    tell_mistakes,
    worker_options,
)  # fmt: skip
from tissuec.core.errors import CompileError, TissueError, counted
from tissuec.engine.execution.signals import exit_code
from tissuec.results import wording

if TYPE_CHECKING:
    from tissuec.studies.study import PreparedStudy, StudyResult

MOST_REASONS = 5  # of failed runs that are told
# As in ``scene.study_entries``, which would take 50 ms of every ``--help``.
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
    help='A measure, such as "max(force of forceps A)" or "tear = time of rupture".',
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
    overrides: tuple[str, ...],
    libraries: tuple[Path, ...],
    strict: bool,
    **options: Any,
) -> int:
    """Run SCENE many times, as its study block or the options specify.

    NAME selects one of several study blocks. The table has one row for each run and can be read
    at any moment. After an interruption, the same command continues the study. Exit code: 0
    done; 1 an expectation of the study failed; 2 the text is wrong; 3 no run could be computed;
    130 interrupted.
    """
    from tissuec.results.errors import PlaceError
    from tissuec.scene.request import Request
    from tissuec.studies.progress import StudyProgress
    from tissuec.studies.study import prepare, run_study
    from tissuec.workers.selection import workers_of

    try:
        request = Request.file(scene, overrides=overrides, libraries=libraries, strict=strict)
        prepared = prepare(request, name, sentences=_sentences(options))
    except CompileError as error:
        tell_mistakes(error, settings, scene=str(scene))
        return WRONG_TEXT
    except PlaceError:
        raise
    except TissueError as error:
        raise click.UsageError(str(error)) from error
    target = options["output"] or Path(
        f"{scene.stem}.{'_'.join(prepared.study.name.split())}.csv"
    )
    keep_input(target, scene)
    if not settings.json:
        report(prepared.warnings, settings)
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
        return _interrupted(error, target, settings)
    except TissueError as error:
        if not settings.json:
            echo(f"error: {error}", err=True)
        else:
            print_json({"scene": str(scene), "ok": False, "error": str(error)})
        return WRONG_TEXT if isinstance(error, PlaceError) else STOPPED
    return _finish(scene, prepared, result, target, settings)


def _sentences(options: dict[str, Any]) -> list[str]:
    """Return the sentences of a study block that the options stand for."""
    from tissuec.studies.writing import sentences_of

    rows = None if options["rows"] is None else options["rows"].as_posix()
    named = {key: options[key] for key in ("vary", "measure", "design", "runs", "seed")}
    found = sentences_of(**named, rows=rows)
    if options["keep_results"]:
        found.append("keep is results")
    if options["no_error_estimate"]:
        found.append("error estimate is off")
    return found


def _code(result: "StudyResult") -> int:
    """Return the exit code."""
    if not result.table.finished.any():
        return STOPPED
    return DONE if all(verdict.holds for verdict in result.verdicts) else FAILED


def _interrupted(error: KeyboardInterrupt, target: Path, settings: Settings) -> int:
    if settings.json:
        print_json({"ok": False, "error": "interrupted", "table": str(target)})
    else:
        echo("interrupted", err=True)
        settings.say(f"  {target} has the runs so far; the same command continues")
    return exit_code(getattr(error, "signal", None))


def _finish(
    scene: Path,
    prepared: "PreparedStudy",
    result: "StudyResult",
    target: Path,
    settings: Settings,
) -> int:
    """Say what came out, and return the exit code."""
    code = _code(result)
    if settings.json:
        facts = {"scene": str(scene), "study": prepared.study.name, "ok": code == DONE}
        print_json(
            facts | _document(result, target) | {"diagnostics": as_json(prepared.warnings)}
        )
    else:
        _tell(scene, prepared, result, target, settings)
    return code


def _tell(
    scene: Path,
    prepared: "PreparedStudy",
    result: "StudyResult",
    target: Path,
    settings: Settings,
) -> None:
    """Say on stderr what came out."""
    from tissuec.scene.study_model import called
    from tissuec.studies.analysis.completed import completed
    from tissuec.studies.summary import doubts_in_words

    table = result.table
    taken = f", {result.taken_over} of them done before" if result.taken_over else ""
    name, count = called(table.head.name), counted(len(table), "run")
    settings.say(f"{scene}: {name}: {count}{taken}; {result.seconds:.1f} s")
    for outcome, count in Counter(table.outcome).items():
        settings.say(f"  {outcome}: {count}")
    reasons = Counter(reason for reason in table.reason if reason)
    for reason, count in reasons.most_common(MOST_REASONS):
        settings.say(f"    {counted(count, 'run')}: {reason}")
    promises = Counter(promise.split(" ")[0] for promise in table.promise)
    for promise in ("broken", "unknown"):
        if promises[promise]:
            settings.say(f"  accuracy {promise}: {counted(promises[promise], 'run')}")
    if doubts := doubts_in_words(table):
        settings.say(f"  doubtful: {doubts}")
    for verdict in result.verdicts:
        if not verdict.holds:
            echo(f"  FAILED {verdict.span.place}: {verdict.expect}", err=True)
            echo(f"         {verdict.measured}", err=True)
    if result.verdicts:
        states = ["holds" if verdict.holds else "fails" for verdict in result.verdicts]
        left_out = completed(table).left_out
        beside = f" ({left_out})" if left_out.count else ""
        settings.say(f"  expectations: {wording.expectations(states)}{beside}")
    if prepared.keeps:
        from tissuec.studies.study import RUNS

        settings.say(f"  results: {target.with_suffix(RUNS)}")
    settings.say(f"  table: {target}")


def _document(result: "StudyResult", target: Path) -> dict[str, Any]:
    """Return what came out for programs."""
    from tissuec.studies.summary import doubtful

    table = result.table
    return {
        "table": str(target),
        "runs": len(table),
        "taken_over": result.taken_over,
        "outcomes": dict(Counter(table.outcome)),
        "doubtful": doubtful(table),
        "expectations": [
            {"expect": one.expect, "holds": one.holds, "measured": one.measured}
            for one in result.verdicts
        ],
        "wall_time": result.seconds,
    }
