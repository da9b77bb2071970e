"""Lists of near pairs in contact, and the distance for which they hold.

Pairs of nodes and shapes that are near are listed around a state, and hold until a node has
moved by a distance. The shorter it is, the fewer pairs without contact every step examines, and
the more often pairs are listed. Results are the same for any distance.
"""

from msgspec import Struct

from tissuec.model.network import Floats

MANY = 1000  # pairs; for fewer, listing again costs more than it saves
NARROW = 0.0625  # of the longest distance, to begin with
OFTEN, SELDOM = 60, 600  # steps between two lists; below, they are widened


class ContactListing(Struct):
    """The state around which pairs were listed, and their distance; part of checkpoints.

    Attributes:
        at: Time at which they were listed [s].
        around: Positions of all nodes then [m], shape (node, 3); None before they are listed.
        step: Number of steps that were accepted before.
        share: Distance by which nodes may move, as a part of the longest one.
        is_tried: Whether a shorter distance than the longest one was tried.
    """

    at: float = float("nan")
    around: Floats | None = None
    step: int = 0
    share: float = 1.0
    is_tried: bool = False

    def narrow(self, pairs: int) -> bool:
        """Choose a short distance if the first lists are long; return whether they were.

        Args:
            pairs: Number of pairs that were listed.
        """
        if self.is_tried or pairs <= MANY:
            return False
        self.share, self.is_tried = NARROW, True
        return True

    def end(self, time: float, step: int, pairs: int) -> bool:
        """Choose the next distance when a node is about to exceed it.

        Returns False if the next step alone exceeds the longest one.

        Args:
            time: Of the run [s].
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
