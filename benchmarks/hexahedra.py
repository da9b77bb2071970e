"""Time of the forces of hexahedra in blocks of several sizes.

Medians of processor times. Takes a minute.
"""

from statistics import median

import click

from benchmarks.force_costs import SOLID, Timed, compiled_scene
from benchmarks.publishing import publish, write_option
from tissuec.core.markdown import table

REPEATS = 15
EVALUATIONS = 2e5  # of one element, in one measurement
CELLS = (12, 24, 47)


def measure(cells: int) -> list[str]:
    """Return a row of the table."""
    compiled = compiled_scene(
        {"mesh": SOLID["mesh"].replace("24, 24, 24", ", ".join([str(2 * cells)] * 3))}
    )
    count, timed = cells**3, Timed(compiled, max(4, int(EVALUATIONS / cells**3)))
    found = median(timed.seconds() for _ in range(REPEATS))
    return [f"{cells}³", str(count), f"{1e9 * found / count:.0f} ns"]


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure blocks of elements."""
    rows = [measure(cells) for cells in CELLS]
    heads = ("block", "hexahedra", "time")
    publish("hexahedra", {"hexahedra": table(heads, rows)}, write=write)


if __name__ == "__main__":
    main()
