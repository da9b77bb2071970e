"""What is near in contact, listed for as many steps as pay.

Pairs of nodes and shapes that are near are listed around a state, and hold until a node has
moved by a distance. The shorter it is, the fewer pairs every step looks at that do not touch,
and the more often they are listed. Results are the same for any distance.
"""

from msgspec import Struct

from tissuec.model.network import Floats

MANY = 1000  # pairs; for fewer, listing again costs more than it saves
NARROW = 0.0625  # of the longest distance, to begin with
OFTEN, SELDOM = 60, 600  # steps between two lists; below, they are widened


class ContactListing(Struct):
    """When and how far around pairs were listed; all of it goes into checkpoints.

    Attributes:
        at: When they were listed [s].
        around: And around which positions of all nodes [m], shape (node, 3); None if they are
            to be listed.
        step: Number of steps that were accepted before.
        share: Distance by which nodes may move, as a part of the longest one.
        is_tried: Whether a shorter distance than that was tried.
    """

    at: float = float("nan")
    around: Floats | None = None
    step: int = 0
    share: float = 1.0
    is_tried: bool = False

    def is_wide(self, pairs: int) -> bool:
        """Return whether pairs that were just listed are to be listed again, nearer by.

        Args:
            pairs: Number of them.
        """
        if self.is_tried or pairs <= MANY:
            return False
        self.share, self.is_tried = NARROW, True
        return True

    def end(self, time: float, step: int, pairs: int) -> bool:
        """Choose the next distance, as a node is about to leave it; return whether one helps.

        Args:
            time: Where the run stands [s].
            step: Number of steps that were accepted.
            pairs: Number of pairs that were listed.
        """
        steps = step - self.step
        if time == self.at:
            if self.share == 1.0:
                return False
            self.share = min(8.0 * self.share, 1.0)
        elif self.share < 1.0 and steps < OFTEN:
            self.share *= 2.0
        elif steps > SELDOM and pairs > MANY:
            self.share *= 0.5
        return True
