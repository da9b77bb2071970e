"""``tissuec modes``: Print the natural frequencies, damping and modes of a scene."""

from pathlib import Path

import click

from tissuec.cli.arguments import OptionReader
from tissuec.cli.common import Command, SceneOptions, Settings, keep_input, scene_options
from tissuec.core.report import Report
from tissuec.core.units import FREQUENCY
from tissuec.view.plots.options import reader

LARGEST = 1000


@click.command(cls=Command)
@click.argument("scene", type=click.Path(path_type=Path))
@click.option("--body", metavar="NAME", help="Only this body moves; everything else is held.")
@click.option(
    "--count",
    type=click.IntRange(1, LARGEST),
    default=10,
    show_default=True,
    help="Number of modes, in ascending order of frequency.",
)
@click.option(
    "--above",
    type=OptionReader(reader(FREQUENCY)),
    metavar="FREQUENCY",
    help="Omit the modes at and below this frequency; 0 omits those without resistance.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Write a result file that shows each mode for one second.",
)
@scene_options
def command(
    settings: Settings, scene: Path, body: str | None, count: int, above: float | None,
    out: Path | None, given: SceneOptions,
) -> Report:  # fmt: skip
    """Print natural frequencies and damping of SCENE at 0 s.

    Modes are small motions about that state, with prestress, laws and enclosed volumes, but
    without contact. Nodes that are fixed or grasped at 0 s are held, and `settle` at 0 s is
    carried out first. A mode called "rigid" moves a part as a whole without any force; in one
    called "no spring resists", the part deforms, but no force opposes this to first order.

    In the file of --out, the largest displacement is 5 % of the size of the body.

    \b
    tissuec modes scene.tis
    tissuec modes scene.tis --body tube --count 20 --json
    tissuec modes scene.tis --above 0 --out modes.vtkhdf
    """
    from tissuec.analysis.vibration.scene import modes_report, scene_modes
    from tissuec.compiler.manifest import manifest_of
    from tissuec.pipeline import compile_request

    if above is not None and above < 0.0:
        raise click.BadParameter("a frequency must be 0 or more", param_hint="'--above'")
    if out is not None:
        keep_input(out, scene)
    request = given.request(scene)
    compiled, warnings = compile_request(request)
    settings.warn(warnings)
    found = scene_modes(compiled, body=body, count=count, above=above)
    file = None
    if out is not None and len(found):
        from tissuec.analysis.vibration.scene import write_modes

        file = write_modes(found, compiled, out, manifest_of(compiled, request))
    return modes_report(found, file)
