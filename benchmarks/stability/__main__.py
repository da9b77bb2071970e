"""Run the stress test and write its map into ``numerics.md``.

    python benchmarks/stability/__main__.py [map.png]

does what ``tissuec bench --stability`` does, for every method, and takes half an hour.
"""

import sys
from collections import Counter
from pathlib import Path

from tissuec.bench.stress.cells import all_cells
from tissuec.bench.stress.grid import SIGNS, Stress, as_dict, stress
from tissuec.core.markdown import code, replace_places, table
from tissuec.drawing.page import save
from tissuec.plots import draw

PAGE = Path(__file__).resolve().parents[2] / "docs" / "numerics.md"
BUDGET = 4.0  # time of the processor for a run [s]


def main() -> None:
    """Try everything and rewrite the page; draw the map too if a file is named."""
    found = stress(all_cells(small=False), methods=(), budget=BUDGET, tell=print)
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(
        replace_places(page, {"stability": as_markdown(found)}, mark="mapped"),
        encoding="utf-8",
    )
    if len(sys.argv) > 1:
        save(draw("stability", as_dict(found)), Path(sys.argv[1]))


def as_markdown(found: Stress) -> str:
    """Return the map, how often each sign stands in it, and what is bad."""
    counts = Counter(verdict.kind for verdict in found.verdicts)
    meanings = [
        (sign, str(counts[kind]), meaning)
        for kind, (sign, meaning) in SIGNS.items()
        if counts[kind]
    ]
    bad = [f"- {v.axis} {v.value}, {code(v.method)}: {v.why}" for v in found.bad]
    parts = [
        table(found.heads, found.rows),
        table(("sign", "times", "means"), meanings),
        "\n".join(bad) or "Nothing is silently wrong, and nothing crashed.",
    ]
    return "\n\n".join(parts)


if __name__ == "__main__":
    main()
