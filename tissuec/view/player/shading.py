"""Triangles as a camera sees them, in the light of the page (``web/shared.glsl``): pixels."""

from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiled.calls import Shipped
from tissuec.core import palette
from tissuec.kernels.rasterizing import fill
from tissuec.model.network import Floats
from tissuec.view.player.bodies import TriangleMesh, lit
from tissuec.view.player.camera import Camera
from tissuec.view.player.lifetimes import Mask
from tissuec.view.player.node_values import FieldValues, field_colours, readable
from tissuec.view.player.rules import RULES, rgb
from tissuec.view.section.cross_section import clipped
from tissuec.view.section.plane import SectionPlane


class ProjectedTriangles(NamedTuple):
    """Triangles as the camera sees them.

    Attributes:
        corners: To the right, upwards, and to the eye [m], shape (triangle, 3, 3).
        colour: Of the corners, shape (triangle, 3, 3).
        opacity: Shape (triangle,).
    """

    corners: Floats
    colour: Floats
    opacity: Floats

    def behind(self, normal: Floats, offset: float) -> "ProjectedTriangles":
        """Return those parts that are not in front of a plane.

        Args:
            normal: Of the plane, a unit vector as the camera sees it, shape (3,).
            offset: Of the plane from the target of the camera, along the normal [m].
        """
        height = self.corners @ normal - offset
        values, of = clipped(np.concatenate([self.corners, self.colour], axis=2), height)
        return ProjectedTriangles(values[..., :3], values[..., 3:], self.opacity[of])


class Shading(Struct, frozen=True, eq=False):
    """Where a camera sees triangles, and in which colours.

    Attributes:
        camera: The camera.
        size: Of all that there is to see [m].
        plane: The plane of the section; None for none.
    """

    camera: Camera
    size: float
    plane: SectionPlane | None = None

    @property
    def front(self) -> SectionPlane | None:
        """The plane of the section, with its front to the eye."""
        camera = self.camera
        eye = camera.target + camera.distance * camera.axes[2]
        return self.plane and self.plane.towards(eye)

    def behind(self, shapes: ProjectedTriangles) -> ProjectedTriangles:
        """Return the parts that are not in front of the plane of the section."""
        if (plane := self.front) is None:
            return shapes
        normal = np.array(plane.normal)
        # A little more, lest rounding tears what lies in the plane.
        offset = plane.offset - float(normal @ self.camera.target) + 1e-6 * self.size
        return shapes.behind(self.camera.axes @ normal, offset)

    def body(self, mesh: TriangleMesh, base: Floats, shine: float) -> ProjectedTriangles:
        """Return triangles of one colour in the light.

        Args:
            mesh: The triangles [m].
            base: Red, green and blue, from 0 to 1, dimensionless, shape (3,).
            shine: Of the highlight.
        """
        return self.shaded(mesh, np.broadcast_to(base, mesh.corners.shape), shine)

    def skin(
        self, mesh: TriangleMesh, tint: Floats, hollow: Mask, *, paler: bool
    ) -> ProjectedTriangles:
        """Return triangles in the light, of other colour inside.

        Args:
            tint: Colour and gloss of their corners, dimensionless, shape (triangle, 3, 4).
            hollow: Which of them have an inside, shape (triangle,).
            paler: Whether springs lie on it.
        """
        colour = tint[..., :3]
        if paler:
            colour = colour + RULES.paler * (rgb(palette.PAPER) - colour)
        seen = self.into(mesh.corners)
        normal = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])
        to_eye = np.array([0.0, 0.0, self.camera.distance]) - seen[:, 0]
        is_front = (normal * to_eye).sum(axis=1) > 0.0
        base = np.where((is_front | ~hollow)[:, None, None], colour, rgb(palette.LUMEN))
        return self.shaded(mesh, base, RULES.shine * tint[..., 3:])

    def field(
        self, mesh: TriangleMesh, values: FieldValues, numbers: Floats
    ) -> ProjectedTriangles:
        """Return triangles in the colours of a field.

        Args:
            numbers: At their corners, in the unit of the field, shape (triangle, 3).
        """
        seen, outer, to_eye = self._facing(mesh)
        colour = readable(field_colours(values, numbers), outer, to_eye)
        return ProjectedTriangles(seen, colour, np.ones(len(seen)))

    def shaded(
        self, mesh: TriangleMesh, base: Floats, shine: float | Floats
    ) -> ProjectedTriangles:
        """Return triangles in the light.

        Args:
            base: Colours of their corners, from 0 to 1, dimensionless, shape (triangle, 3, 3).
            shine: Of the highlight, one number or shape (triangle, 3, 1).
        """
        seen, outer, to_eye = self._facing(mesh)
        colour = lit(base, outer, to_eye, shine)
        return ProjectedTriangles(seen, self.hazy(colour, seen, RULES.haze), np.ones(len(seen)))

    def hazy(self, colour: Floats, seen: Floats, most: float) -> Floats:
        """Return colours that are paler further away, shape (…, 3).

        Args:
            colour: From 0 to 1, shape (…, 3).
            seen: Where they are for the camera [m], shape (…, 3).
            most: Part of the paper in the paleness of what is furthest.
        """
        part = np.clip((-seen[..., 2:] / self.size + 0.25) / 1.15, 0.0, 1.0)
        fog = most * part * part * (3.0 - 2.0 * part)
        return colour + fog * (rgb(palette.PAPER) - colour)

    def into(self, points: NDArray[Any], *, direction: bool = False) -> Floats:
        """Return points [m], or directions, as the camera sees them, shape (…, 3)."""
        return (points - (0.0 if direction else self.camera.target)) @ self.camera.axes.T

    def _facing(self, mesh: TriangleMesh) -> tuple[Floats, Floats, Floats]:
        """Return corners, their normals towards the eye, and directions to it, as seen."""
        seen = self.into(mesh.corners)
        normal = self.into(mesh.normals, direction=True)
        normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-300)
        to_eye = np.array([0.0, 0.0, self.camera.distance]) - seen
        to_eye /= np.linalg.norm(to_eye, axis=-1, keepdims=True)
        away = (normal * to_eye).sum(axis=-1, keepdims=True) < 0.0
        inwards: Floats = -normal
        outer: Floats = np.where(away, inwards, normal)
        return seen, outer, to_eye


FINER = 2  # pixels of the raster to a pixel of the picture, either way
_FILL = Shipped(fill, "raster")


class Raster:
    """A picture that is being drawn.

    Args:
        size: Width and height [px].
        paper: Colour behind everything, shape (3,).
    """

    def __init__(self, size: tuple[int, int], paper: Floats):
        width, height = size
        self._picture = np.empty((height * FINER, width * FINER, 3), dtype=np.float32)
        self._picture[:] = paper
        self._nearness = np.zeros(self._picture.shape[:2])

    def draw(self, corners: Floats, colour: Floats, opacity: Floats, *, hides: bool) -> None:
        """Draw triangles.

        Args:
            corners: Place from the left and from the bottom [px], and the inverse of the
                distance from the eye, which is linear on the picture, shape (triangle, corner,
                3).
            colour: Of the corners, 0 to 1, shape (triangle, corner, 3).
            opacity: 0 to 1, shape (triangle,).
            hides: Whether they hide what lies behind and is drawn later.
        """
        given = corners * [FINER, FINER, 1.0], colour, opacity
        arrays = (np.ascontiguousarray(each, dtype=float) for each in given)
        _FILL(*arrays, self._picture, self._nearness, int(hides))

    def pixels(self) -> NDArray[np.uint8]:
        """Return the picture, from the top, dimensionless, shape (height, width, 3)."""
        height, width = (side // FINER for side in self._nearness.shape)
        parts = self._picture.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3))
        return np.rint(255.0 * np.clip(parts[::-1], 0.0, 1.0)).astype(np.uint8)
