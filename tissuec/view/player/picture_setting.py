"""What a picture of a moment shows, and how."""

from functools import cached_property

import numpy as np
from msgspec import Struct

from tissuec.model.network import Floats
from tissuec.view.player.camera import Camera, Framing, fitted, framing, half_height, outermost
from tissuec.view.player.film import PlayerData
from tissuec.view.player.node_values import FieldValues
from tissuec.view.player.options import Colour, Options
from tissuec.view.player.rules import RULES
from tissuec.view.plots.projection import viewpoint


class PictureSetting(Struct, frozen=True, eq=False, dict=True):
    """What a picture of a moment shows, and how.

    Attributes:
        film: What there is.
        options: How it is seen.
        size: Width and height [px].
        title: Above the picture.
        forces: Whether forces on nodes are drawn.
        field: What colours the skin; its tissues if None.
    """

    film: PlayerData
    options: Options
    size: tuple[int, int]
    title: str
    forces: bool = False
    field: FieldValues | None = None

    @cached_property
    def framing(self) -> Framing:
        return framing(self.film)

    @cached_property
    def home(self) -> Camera:
        """The camera; it follows what flies away from here."""
        points = self.framing.points
        angles = self.options.view or viewpoint(points)
        if self.forces:
            points = np.concatenate([points, *self._tips()])
        return fitted(points, *angles, self.size[0] / self.size[1])

    @cached_property
    def mean_rest(self) -> float:
        """The mean rest length of springs [m]."""
        rests = self.film.lines.rest[self.film.lines.rest > 0.0]
        return float(rests.mean()) if len(rests) else self.framing.size / 20.0

    @property
    def colour(self) -> Colour:
        """What colours springs, unless a field does."""
        return self.options.colour or "tension"

    @cached_property
    def most(self) -> float:
        """The number at the end of the colours of springs, in its SI unit."""
        film = self.film
        ends = {"tension": film.most_tension, "strain": film.most_strain, "law": 1.0}
        return ends[self.colour]

    @property
    def shows_springs(self) -> bool:
        return self.film.shows_springs(self.options.colour)

    @property
    def colours_skin(self) -> bool:
        """Whether the colours of the skin are those of a field."""
        return self.field is not None and bool(len(self.film.skin.triangles))

    @property
    def spring_field(self) -> FieldValues | None:
        """The field that colours springs, as there is no skin."""
        return None if self.colours_skin else self.field

    def pixels(self, length: float) -> float:
        """Return how many pixels a length [m] has at the target."""
        seen = half_height(self.home.aspect) * self.home.distance
        return length * self.size[1] / 2.0 / seen

    @cached_property
    def reach(self) -> float:
        """The length of the arrow of a force on a node over the force [m/N]."""
        return self.framing.size * RULES.arrow / (self.film.most_force or 1.0)

    def arrow(self, force: Floats) -> Floats:
        """Return the arrows of forces [N], shape (node, 3), as they are drawn [m]."""
        most = RULES.longest * (self.film.most_force or 1.0)
        size = np.linalg.norm(force.astype(float), axis=1, keepdims=True)
        return force * (self.reach * np.where(size > most, most / np.maximum(size, most), 1.0))

    def _tips(self) -> list[Floats]:
        """Return where arrows of nodes in the picture end, in each frame [m]."""
        low, high = self.framing.points.min(axis=0), self.framing.points.max(axis=0)
        near = 1e-6 * self.framing.size
        found: list[Floats] = []
        for row, force in enumerate(self.film.force):
            foot = self.film.position[row, : self.film.node_count]
            foot = foot - self.framing.middle[row] * self.framing.follows
            held = ((foot >= low - near) & (foot <= high + near)).all(axis=1)
            found.append(outermost(foot[held] + self.arrow(force[held])))
        return found
