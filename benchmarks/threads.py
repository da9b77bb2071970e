"""How many times as fast two threads are as one.

Takes some minutes and needs two processors. Both take turns, and medians of pairs are shown.
"""

from statistics import median

import click

from benchmarks.publishing import publish, write_option
from benchmarks.stepping import METHODS, REPEATS, Net, Stepping, build, nets
from tissuec.core.markdown import table


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure the nets that are large enough for two threads."""
    rows = [gain(net) for net in nets()[2:]]
    publish("threads", {"threads": table(("net", "springs", *METHODS), rows)}, write=write)


def gain(net: Net) -> list[str]:
    """Return a row of the table."""
    compiled = build(net)
    shown: list[str] = []
    for method in METHODS:
        one, two = (Stepping(compiled, method, threads=threads) for threads in (1, 2))
        shown.append(f"{median(one.time() / two.time() for _ in range(REPEATS)):.2f}")
    return [net.name, str(compiled.network.spring_count), *shown]


if __name__ == "__main__":
    main()
