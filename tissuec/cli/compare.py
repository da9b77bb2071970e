"""``tissuec compare``: Show the differences between two runs or scenes."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tissuec.cli.common import Command, Settings, library_option
from tissuec.core.report import DONE, FAILED, Fact, Report

if TYPE_CHECKING:
    from tissuec.view.compare.comparison import Comparison


@click.command(cls=Command)
@click.argument("first", metavar="A", type=click.Path(path_type=Path))
@click.argument("second", metavar="B", type=click.Path(path_type=Path))
@click.option(
    "--within",
    type=click.FloatRange(min=0.0),
    metavar="TOLERANCE",
    help="Exit with 1 if the motions differ by more than this, relative to the "
    "largest displacement until then.",
)
@library_option()
def command(
    settings: Settings,
    first: Path,
    second: Path,
    within: float | None,
    libraries: tuple[Path, ...],
) -> Report:
    """Show the differences between A and B: results, scenes, or a scene and a result.

    This compares the texts, the compiled nets and, for two results, the events, all logs and
    the motion. Nodes and springs are matched by their ids in the scene. Exit code: 0 done, even
    if there are differences; 1 with --within, the motions differ by more or cannot be compared
    completely; 2 a file cannot be read.
    """
    from tissuec.view.compare.comparison import compare
    from tissuec.view.compare.report import as_dict, parts_of
    from tissuec.view.compare.sides import Side, open_side

    with ExitStack() as open_files:
        sides: list[Side] = []
        for path in (first, second):
            side = open_side(path, libraries)
            sides.append(side)
            if side.trajectory is not None:
                open_files.enter_context(side.trajectory)
        if within is not None and any(side.trajectory is None for side in sides):
            raise click.UsageError("--within compares motions; give two results")
        found = compare(*sides)
        reason = "" if within is None else _objection(found, within)
        document, parts = as_dict(found), parts_of(found)
    if within is not None:
        document |= {"within": within, "reason": reason}
    if reason:
        said = f"not within {within:g}: {reason}"
        parts.append(Fact("", said, "remark"))
        if settings.json:  # beside a document that is often written to a file
            settings.say(said)
    return Report(parts, document, FAILED if reason else DONE)


def _objection(found: "Comparison", within: float) -> str:
    """Return why two motions are not within a tolerance of one another; "" if they are."""
    motion = found.motion
    if motion is None or isinstance(motion, str):
        return motion or "there is no motion"
    worst = float(motion.relative.max())
    if worst > within:
        return f"the motions are {worst:.2g} of the largest displacement apart"
    return "" if motion.is_whole else "not all nodes and times are in both"
