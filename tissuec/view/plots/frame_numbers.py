"""Numbers by which springs or skins are coloured in some frames: those of a field."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from msgspec import Struct

from tissuec.core.palette import AMOUNT, TENSION
from tissuec.core.scale import PERCENT, AxisUnit, scale_of
from tissuec.model.network import Floats
from tissuec.view.plots import net

if TYPE_CHECKING:
    from matplotlib.colors import Normalize

    from tissuec.results.trajectory import Trajectory

_UNKNOWN = 0.62  # grey, as on the page


class FrameNumbers(Struct, frozen=True, eq=False):
    """Numbers of springs or triangles in some frames.

    Attributes:
        trajectory: The result.
        name: Of the field; "tension" where none is named.
        label: What the numbers are, for the scale of colours.
        unit: Of the numbers; "" without one.
        shades: Between which their colours lie.
        norm: From numbers to colours.
        at_nodes: One number at each recorded node by frame, NaN where it is unknown; none where
            springs have numbers of their own.
    """

    trajectory: "Trajectory"
    name: str
    label: str
    unit: str
    shades: tuple[str, ...]
    norm: "Normalize"
    at_nodes: dict[int, Floats]

    @classmethod
    def of_tension(cls, trajectory: "Trajectory", frames: Sequence[int]) -> Self:
        """Return the tensions of springs."""
        norm = net.tension_norm([trajectory.spring_force(frame)[0] for frame in frames])
        label = "tension of the springs"
        return cls(trajectory, "tension", label, "N", TENSION, norm, {})

    @classmethod
    def of(cls, trajectory: "Trajectory", name: str, frames: Sequence[int]) -> Self:
        """Return a field of pages.

        Args:
            trajectory: The result.
            name: Of the field.
            frames: Numbers of the frames, ascending.

        Raises:
            TissueError: The result has no such field.
        """
        from matplotlib.colors import Normalize

        from tissuec.results.moments import Moments
        from tissuec.view.player.drawn_nodes import DrawnNodes
        from tissuec.view.player.node_values import read_field
        from tissuec.view.player.options import Options
        from tissuec.view.player.reading import film_of

        film = film_of(Moments.of(trajectory, np.array(frames)), Options(cells=False))
        values = read_field(DrawnNodes(film, trajectory), name)
        rows = np.flatnonzero(~film.is_side)
        shades = TENSION if values.is_signed else AMOUNT
        norm, found = Normalize(values.low, values.high), values.value[rows]
        at_nodes = dict(zip(frames, found, strict=True))
        text, unit = values.field.text, values.field.unit
        return cls(trajectory, name, text, unit, shades, norm, at_nodes)

    def of_springs(self, frame: int) -> Floats:
        """Return the numbers of the springs in a frame, in the unit, shape (alive,)."""
        if self._is_of("spring"):
            return np.asarray(self.trajectory.shown(self.name, frame)[0], dtype=float)
        rows = self.trajectory.spring_force(frame)[1]
        return self.at_nodes[frame][self.trajectory.ends[rows]].mean(axis=1)

    def of_triangles(self, frame: int) -> Floats:
        """Return the numbers of the triangles in a frame, in the unit, shape (triangle,)."""
        if self._is_of("triangle"):
            return np.asarray(self.trajectory.shown(self.name, frame)[0], dtype=float)
        return self.at_nodes[frame][self.trajectory.cells(frame).triangles].mean(axis=1)

    def _is_of(self, at: str) -> bool:
        return any(one.name == self.name and one.at == at for one in self.trajectory.channels)

    @property
    def scale(self) -> AxisUnit:
        """Return the unit in which numbers are shown."""
        assert self.norm.vmax is not None
        return scale_of(self.unit, [self.norm.vmax]) if self.unit else PERCENT

    def colours(self, numbers: Floats) -> Any:
        """Return the colours of numbers in the unit, grey where unknown, shape (number, 4).

        Args:
            numbers: In the unit, NaN where they are unknown, shape (number,).
        """
        known = np.isfinite(numbers)
        found = net.colours_between(self.shades)(self.norm(np.where(known, numbers, 0.0)))
        found[~known, :3] = _UNKNOWN
        return found

    def said(self, every: Floats) -> dict[str, Any]:
        """Return the scale of colours: its norm, whether it extends further, and its label.

        Args:
            every: All numbers that are drawn, in the unit, shape (number,).
        """
        from matplotlib.colors import Normalize

        known = every[np.isfinite(every)]
        low, high = float(self.norm.vmin or 0.0), float(self.norm.vmax or 0.0)
        ends = bool((known < low).any()), bool((known > high).any())
        extend = {(False, False): "neither", (True, False): "min", (False, True): "max"}
        label = self.scale.label(self.label)
        if self.name == "tension" and not self.at_nodes:
            label += "; negative: compression"
        return {
            "norm": Normalize(float(self.scale.of(low)), float(self.scale.of(high))),
            "extend": extend.get(ends, "both"),
            "label": label,
        }
