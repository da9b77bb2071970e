"""Common code of measures that have a part along a direction."""

from tissuec.model.network import Floats


class DirectedMeasure:
    """Base of the measures that can be followed by ``along (x, y, z)``."""

    @staticmethod
    def along(sample: Floats, direction: Floats) -> Floats:
        """Return the part along a direction in the unit of the measure, shape (…).

        Args:
            sample: Components in the unit of the measure, shape (…, column).
            direction: Unit vector, shape (3,).
        """
        raise NotImplementedError
