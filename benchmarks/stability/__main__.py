"""Every method on scenes at the ends of what can be written: where is a run silently wrong?

The whole grid takes half an hour. Exit code: 1 if a run is silently wrong or crashes. The
numerics page tells what is tested; "tissuec plot" draws the JSON document.
"""

import click

from benchmarks.publishing import json_option, publish, tell, write_option
from benchmarks.stability.cells import all_cells
from benchmarks.stability.grid import METHODS, as_dict, as_markdown, stress


@click.command(help=__doc__)
@click.option(
    "--method",
    "methods",
    multiple=True,
    type=click.Choice(METHODS),
    help="Only this method; may be repeated.",
)
@click.option("--small", is_flag=True, help="A few of the scenes only.")
@click.option(
    "--budget",
    type=click.FloatRange(min=0.0, min_open=True),
    default=4.0,
    show_default=True,
    metavar="SECONDS",
    help="Time of the processor that a run may take.",
)
@write_option
@json_option
@click.pass_context
def main(
    context: click.Context,
    methods: tuple[str, ...],
    budget: float,
    *,
    small: bool,
    write: bool,
    as_json: bool,
) -> None:
    """Try everything that is asked for."""
    found = stress(all_cells(small=small), methods=methods, budget=budget, tell=tell)
    document = {"ok": not found.bad} | as_dict(found) if as_json else None
    publish("stability", {"stability": as_markdown(found)}, write=write, document=document)
    context.exit(1 if found.bad else 0)


if __name__ == "__main__":
    main()
