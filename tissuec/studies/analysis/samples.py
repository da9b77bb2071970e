"""Values of a measure that analyses use: of runs that came to an end, and that are numbers."""

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import alternatives
from tissuec.core.names import key_of
from tissuec.studies.table import Column, StudyTable


def measure_of(table: StudyTable, name: str) -> Column:
    """Return a measure by its name.

    Raises:
        ValueError: The table has no such measure.
    """
    for column in table.measures:
        if key_of(column.name) == key_of(name):
            return column
    known = [column.name for column in table.measures]
    hint = alternatives(name, known, what="there are") or "it has none"
    raise ValueError(f'the table has no measure "{name}"; {hint}')


def usable(table: StudyTable, measure: Column) -> NDArray[np.bool_]:
    """Return which runs came to an end and have a value of a measure, shape (row,)."""
    return table.finished & np.isfinite(measure.numbers)
