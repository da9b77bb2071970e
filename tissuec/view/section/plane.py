"""The plane of a section."""

import numpy as np
from msgspec import Struct

from tissuec.core.scale import scale_of, snapped
from tissuec.model.network import Floats

_AXES = ("x", "y", "z")


class SectionPlane(Struct, frozen=True):
    """The points p with normal·p = offset.

    Attributes:
        normal: Unit vector.
        offset: [m].
    """

    normal: tuple[float, float, float]
    offset: float

    @property
    def axis(self) -> str:
        """Return the axis that it is at right angles to; empty for none."""
        found = [axis for axis, one in zip(_AXES, self.normal, strict=True) if one == 1.0]
        return found[0] if found else ""

    @property
    def text(self) -> str:
        """Return the plane in words, as it can be written."""
        size = scale_of("m", [abs(self.offset) or 1e-3])
        if self.axis:
            return f"{self.axis} = {size.text(self.offset)}"
        facing = [snapped(one, 1.0) for one in self.normal]
        point = [float(size.of(self.offset * one)) for one in facing]
        through, facing = (", ".join(f"{one + 0.0:.4g}" for one in row)
                           for row in (point, facing))  # fmt: skip
        return f"through ({through}) {size.unit} facing ({facing})"

    @property
    def basis(self) -> Floats:
        """Return two unit vectors in the plane, to the right and upwards, shape (2, 3)."""
        if self.normal[:2] == (0.0, 0.0):
            return np.eye(3)[:2]
        normal = np.array(self.normal)
        right = np.cross([0.0, 0.0, 1.0], normal)
        right /= np.linalg.norm(right)
        if right[np.abs(right).argmax()] < 0.0:  # seen from the other side
            right, normal = -right, -normal
        return np.stack([right, np.cross(normal, right)])

    @property
    def labels(self) -> tuple[str, str]:
        """Return labels for the directions of the basis: names of axes, or vectors."""
        right, up = self.basis
        return _named(right), _named(up)

    def towards(self, eye: Floats) -> "SectionPlane":
        """Return the same plane with its front to the eye.

        Args:
            eye: [m], shape (3,).
        """
        x, y, z = self.normal
        if np.array(self.normal) @ eye >= self.offset:
            return self
        return SectionPlane((-x, -y, -z), -self.offset)


def _named(direction: Floats) -> str:
    largest = int(np.abs(direction).argmax())
    if direction[largest] == 1.0:
        return _AXES[largest]
    return f"along ({', '.join(f'{one + 0.0:.2g}' for one in direction)})".replace("-", "−")
