"""Places of labels in a picture, clear of each other; see ``web/placing.js``."""

from collections.abc import Iterator

Box = tuple[float, float, float, float]
"""Left, bottom, right and top [px]."""

EDGE = 4.0  # [px]: between labels and the rim of the picture
_STEPS = 6  # up to how many lines a label gives way, either way


class Placing:
    """The room for labels in a picture.

    Args:
        size: Width and height of the picture [px].
    """

    def __init__(self, size: tuple[float, float]):
        self.size = size
        self.taken: list[Box] = []

    def take(self, box: Box) -> None:
        """Keep labels out of a box."""
        self.taken.append(box)

    def beside(
        self, point: tuple[float, float], room: tuple[float, float], *, right: bool, gap: float
    ) -> tuple[float, float]:
        """Take the best place for a label beside a point, and return its left and bottom [px].

        Args:
            point: From the left and the bottom of the picture [px].
            room: Width and height of the label [px].
            right: The side on which it is placed if there is room.
            gap: Between point and label [px].
        """
        best = min(self._places(point, room, right=right, gap=gap), key=self._covered)
        self.take(best)
        return best[0], best[1]

    def _places(
        self, point: tuple[float, float], room: tuple[float, float], *, right: bool, gap: float
    ) -> Iterator[Box]:
        """Yield places, the best ones first."""
        (x, y), (wide, high) = point, room
        sides = (x + gap, x - gap - wide)
        for step in sorted(range(-_STEPS, _STEPS + 1), key=abs):
            for left in sides if right else sides[::-1]:
                inside = min(max(left, EDGE), self.size[0] - EDGE - wide)
                # A label that the rim moves over the point is placed above or below it.
                lines = step if inside == left else step + (1 if step >= 0 else -1)
                low = y - high / 2.0 + lines * high
                low = min(max(low, EDGE), self.size[1] - EDGE - high)
                yield inside, low, inside + wide, low + high

    def _covered(self, box: Box) -> float:
        """Return the area of a box that others have [px²]."""
        left, low, right, top = box
        return sum(
            max(0.0, min(right, b[2]) - max(left, b[0]))
            * max(0.0, min(top, b[3]) - max(low, b[1]))
            for b in self.taken
        )
