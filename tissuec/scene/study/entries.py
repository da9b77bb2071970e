"""The entries of a study block: one table for checks, editors and the reference."""

from typing import Annotated

from msgspec import Struct

from tissuec.core.fields import OneOf, Whole
from tissuec.scene.reading.block_sentences import Sentences

GRID, LIST, ONE_AT_A_TIME = "grid", "list", "one at a time"
LATIN, SOBOL, INDICES = "latin hypercube", "sobol", "sobol indices"
#: Designs of values that are listed, and of values that are drawn.
LISTED, DRAWN = (GRID, LIST, ONE_AT_A_TIME), (LATIN, SOBOL, INDICES)
DESIGNS = {
    GRID: "every combination of the values of all factors",
    LIST: "the first values of all factors, then the second ones, and so on",
    ONE_AT_A_TIME: "the scene as it is, then each value of one factor with the others as in the"
    " scene",
    LATIN: "random points, of which each part of each range has one",
    SOBOL: "evenly spread random points (Sobol sequence); runs should be a power of two",
    INDICES: "points for Sobol indices of sensitivity: runs times two more than the factors",
}
AGGREGATES = {
    "max": "the largest value",
    "min": "the smallest value",
    "mean": "the mean over time",
    "first": "the value at the start",
    "last": "the value at the end",
}
DISTRIBUTIONS = {
    "uniform": "uniform(low, high)",
    "normal": "normal(mean, standard deviation)",
    "lognormal": "lognormal(median, factor)",
    "triangular": "triangular(low, mode, high)",
}
NOTHING, RESULTS = "nothing", "results"

SENTENCES: dict[str, Sentences] = {
    "vary": Sentences(
        (
            "vary lift = 2 mm to 10 mm in 9 steps",
            "vary lift = 2 mm to 10 mm by 1 mm",
            "vary lift = [2 mm, 5 mm]",
            "vary lift = normal(5 mm, 1 mm) between 2 mm and 8 mm",
            "vary lift",
            "vary hardness of TISSUE = [soft, slightly hard]",
            "vary tissue of BODY = [healthy, cirrhotic]",
            "vary tolerance = [1e-3, 1e-4]",
        ),
        "A factor: a param, or an entry of a block, and its values. ``in 9 steps`` gives 9"
        " values with both ends. A range without steps, a distribution, or a param alone"
        " (uniform within its limits) is for random designs.",
    ),
    "rows": Sentences(
        ('rows "points.csv"',),
        "A CSV file with one row for each run and a column for each factor, with its unit in"
        " the head: ``lift [mm]``. Commas, semicolons or tabs"
        " separate columns.",
        is_single=True,
    ),
    "measure": Sentences(
        (
            "measure pull = max(force of forceps A)",
            "measure height = position of tip along (0, 0, 1) at 0.3 s",
            "measure tear = time of rupture",
            "measure curve = force of forceps A every 1 ms",
            "measure early = mean(force of forceps A) from 0 s to 0.1 s",
        ),
        "A column of the table: the largest (``max``), smallest (``min``), ``mean``, ``first``"
        " or ``last`` value of a measure; its value at a time; the time of the first event of a"
        " kind; or with ``every`` the whole curve.",
        is_needed=True,
    ),
    "design": Sentences(
        tuple(f"design is {name}" for name in DESIGNS),
        f"How values are combined: {'; '.join(f'``{d}``: {t}' for d, t in DESIGNS.items())}.",
        is_single=True,
    ),
    "error estimate": Sentences(
        ("error estimate is off",),
        "Leaves out the second run with smaller steps, which by default shows whether a run"
        " keeps its tolerance.",
        is_single=True,
    ),
}  # fmt: skip


class StudySettings(Struct, frozen=True):
    """Settings of a study.

    Attributes:
        runs: number of runs of a random design
        seed: seed of random numbers
        keep: what is kept of each run besides its row
    """

    runs: Annotated[int, Whole(at_least=1, at_most=10_000_000)] = 100
    seed: Annotated[int, Whole(at_least=0)] = 0
    keep: Annotated[str, OneOf((NOTHING, RESULTS))] = NOTHING
