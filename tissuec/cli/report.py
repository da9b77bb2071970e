"""``tissuec report``: Write a page on a run: motion, curves, the origin of every number."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import (
    Command,
    Reports,
    Settings,
    check_page_name,
    keep_input,
    library_option,
    show_page,
)
from tissuec.core.errors import TissueError
from tissuec.core.files import write_file
from tissuec.core.report import DONE, Report

if TYPE_CHECKING:
    from tissuec.results.trajectory import Trajectory

SUFFIX = ".report.html"


@click.command(cls=Command)
@click.argument("results", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="File of the page, or a folder for several results.",
)
@click.option(
    "--validate", "validates", is_flag=True, help="Also run the comparison of tissuec validate."
)
@click.option(
    "--validation",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    metavar="FILE",
    help="Output of tissuec validate --json to include.",
)
@library_option("files that results do not contain, such as meshes")
@click.option("--open", "opens", is_flag=True, help="Open the page in a browser.")
def command(
    settings: Settings,
    results: tuple[Path, ...],
    output: Path | None,
    validates: bool,
    validation: Path | None,
    libraries: tuple[Path, ...],
    opens: bool,
) -> Reports:
    """Write one HTML page about each of RESULTS; tube.vtkhdf gives tube.report.html.

    RESULTS are result files, or tables of studies. A page is one file and needs no network.
    All its contents come from the result, including the text of the scene. Exit code: 0
    written; with --validate, the exit code of validate.

    \b
    tissuec report tube.vtkhdf --open
    tissuec report tube.vtkhdf --validate -o tube.html
    tissuec report lift.stretching.csv
    """
    from tissuec.studies.table_files import is_table

    if validation is not None and (validates or len(results) > 1):
        other = "--validate" if validates else "several results"
        raise click.UsageError(f"--validation is for one run and cannot be used with {other}")
    pages = _pages(results, output)

    def each() -> Iterator[Report]:
        for result, page in pages.items():
            keep_input(page, result)
            if validation is not None:
                keep_input(page, validation)
            if is_table(result):
                if validates or validation is not None:
                    raise click.UsageError(
                        f'"{result}" is the table of a study; validate a scene'
                    )
                word, reasons, code = *_write_study(result, page), DONE
            else:
                word, reasons, code = _write(
                    result, page, validation, libraries, settings, validates=validates
                )
            document = {
                "result": str(result),
                "report": str(page),
                "bytes": page.stat().st_size,
                "verdict": word,
                "reasons": reasons,
            }
            if opens:
                show_page(page)
            parts = (f"{result}: {word}", f"  report: {page}")
            yield Report(parts, document, code, level="remark")

    return Reports(each(), len(pages) > 1)


def _pages(results: Sequence[Path], output: Path | None) -> dict[Path, Path]:
    """Return where the page of each result goes.

    Raises:
        UsageError: The name is not that of a page.
        TissueError: A page would overwrite another one.
    """
    from tissuec.results.places import make_folder

    if output is not None and len(results) == 1 and not output.is_dir():
        check_page_name(output)
        return {results[0]: output}
    if output is not None:
        make_folder(output)
    pages: dict[Path, Path] = {}
    owners: dict[Path, Path] = {}
    for result in results:
        page = pages[result] = (output or Path()) / f"{result.stem}{SUFFIX}"
        owner = owners.setdefault(page.resolve(), result)
        if owner is not result:
            raise TissueError(
                f'the pages of "{owner}" and "{result}" would both be "{page}"; write one of '
                "them separately, with -o"
            )
    return pages


def _write(
    result: Path, page: Path, validation: Path | None, libraries: tuple[Path, ...],
    settings: Settings, *, validates: bool,
) -> tuple[str, list[str], int]:  # fmt: skip
    """Write the page of a run; return its verdict, the reasons, and the exit code."""
    from tissuec.analysis.result_scene import recompile
    from tissuec.results.trajectory import Trajectory
    from tissuec.view.report.content import ReportContent
    from tissuec.view.report.page import render

    with Trajectory.open(result) as trajectory:
        recompiled, document, code = recompile(trajectory, libraries), None, DONE
        if validation is not None:
            document = _read_validation(validation, trajectory)
        elif validates:
            from tissuec.cli.validate import validated
            from tissuec.validate.report import VERDICTS

            if recompiled.compiled is None:
                reasons = "; ".join(doubt.text for doubt in recompiled.doubts)
                raise TissueError(f'cannot validate "{result}": {reasons}')
            document = validated(recompiled.compiled, "DOP853", None, settings)
            code = VERDICTS[document["verdict"]][2]
        content = ReportContent(trajectory, validation=document, recompiled=recompiled)
        write_file(page, render(content))
    return content.verdict.word, [reason for reason, _ in content.verdict.reasons], code


def _write_study(path: Path, page: Path) -> tuple[str, list[str]]:
    """Write the page of a study; return its verdict, and why runs failed."""
    from tissuec.studies.table_files import read_table
    from tissuec.view.report.study import render_study, verdict

    table = read_table(path)
    write_file(page, render_study(table, path))
    return verdict(table), sorted({reason for reason in table.reason if reason})


def _read_validation(path: Path, trajectory: "Trajectory") -> Mapping[str, Any]:
    """Return the output of ``validate --json`` for the scene of a run, or raise TissueError."""
    import json

    from tissuec.view.report.outcome import misfit

    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise TissueError(f'cannot read "{path}": {error}') from error
    if flaw := misfit(document, trajectory):
        raise TissueError(f'"{path}" {flaw}')
    return document
