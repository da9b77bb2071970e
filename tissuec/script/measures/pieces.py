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
    """The number of connected pieces of the net that the nodes of A belong to.

    Two nodes are in one piece where intact springs lead from one to the other, inside A or not,
    but for those of joints, which hold pieces together and leave them pieces.
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
