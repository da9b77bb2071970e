"""A scalpel: an edge that cuts where it moves."""

import numpy as np

from tissuec.core.fields import Points
from tissuec.script.tools import TOOLS, HandTool, Shape

SEEN = 0.01  # of its length: how thick an edge is drawn


@TOOLS.member("scalpel")
class Scalpel(HandTool, frozen=True, eq=False):
    """An edge that parts tissue where it moves, in the sentence ``cut … with``.

    It has no thickness and touches nothing else.

    Attributes:
        edge: line from one end of the edge to the other
    """

    edge: Points

    def shapes(self) -> tuple[Shape, ...]:
        """Return the edge.

        Raises:
            ValueError: The edge or the shaft has no length.
        """
        self.check_shaft()
        length = float(np.linalg.norm(np.subtract(*self.edge)))
        if not length > 0.0:
            raise ValueError('"edge" has no length')
        return (Shape("edge", np.array(self.edge), SEEN * length),)
