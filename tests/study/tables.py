"""Tables of studies that tests share."""

import math

from tissuec.api.study_table import StudyTable
from tissuec.studies.table import DIED, DONE, REFUSED, FactorHead, MeasureHead, Row, StudyHead

HEAD = StudyHead(
    "lifting", "liver", "grid", 1, 0, 4,
    (
        FactorHead("lift", "mm", values="[2 mm, 4 mm]"),
        FactorHead('hardness of "my, liver"', "", is_text=True, values="[soft, very hard]"),
    ),
    (MeasureHead("pull", "N"), MeasureHead("tear", "s"), MeasureHead("curve", "N", 0.1)),
)  # fmt: skip
ROWS = (
    Row(
        0, (2.0, "soft"), (0.1 + 0.2, 0.25, (1.0, math.nan, 1 / 3)), DONE, "", "kept", 1e-5, "a"
    ),
    Row(
        1, (2.0, "very hard"), (math.nan, math.nan, ()), REFUSED, "a, and\nb", "", math.nan, "b"
    ),
    Row(2, (4.0, "soft"), (2e-300, math.nan, (1.0,)), DONE, "", "broken from 0.1 s", 0.5, "c"),
    Row(3, (4.0, "very hard"), (math.nan, math.nan, ()), DIED, "killed", "", math.nan, "d"),
)


def table() -> StudyTable:
    """Return a table of four runs, two of which failed."""
    return StudyTable.of(HEAD, ROWS)
