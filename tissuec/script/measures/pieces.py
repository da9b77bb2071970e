"""Into how many pieces the net has come apart."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("pieces")
class Pieces(ScalarMeasure):
    """The number of connected pieces of the net that contain nodes of A.

    Two nodes are in one piece if a chain of intact springs, inside A or not, connects them.
    Springs of joints do not count: two sutured pieces are two pieces.
    """

    form = "count(pieces of A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "nodes"
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        found = snapshot.pieces[snapshot.nodes(subjects[0])]
        return one_column(len(np.unique(found)), snapshot)
