"""The plane of a section, and how it is written."""

import re
from math import isfinite

import numpy as np
from msgspec import Struct

from tissuec.core.scale import scale_of, snapped
from tissuec.core.units import LENGTH, UnitError, parse_unit
from tissuec.model.network import Floats

FORMS = 'write "z = 6 mm" or "through (0, 0, 6) mm facing (0, 1, 1)"'
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_TRIPLE = rf"\(\s*({_NUMBER})\s*,\s*({_NUMBER})\s*,\s*({_NUMBER})\s*\)"
_ALONG_AXIS = re.compile(rf"\s*([xyz])\s*=\s*({_NUMBER})\s*(\S*)\s*")
_FACING = re.compile(
    rf"\s*(?:(?:along\s+)?plane\s+)?through\s+{_TRIPLE}\s*(\S*)\s+facing\s+({_TRIPLE})\s*"
)
_LENGTH = rf"({_NUMBER})\s*([^\s,()]*)"
_LENGTHS = re.compile(rf"\(\s*{_LENGTH}\s*,\s*{_LENGTH}\s*,\s*{_LENGTH}\s*\)(?=\s+facing)")
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


def read_plane(text: str) -> SectionPlane:
    """Return the plane that a text describes, in the words of cuts.

    Raises:
        ValueError: It describes none; says where and what to write.
    """
    if found := _ALONG_AXIS.fullmatch(text):
        axis = _AXES.index(found[1])
        normal = (float(axis == 0), float(axis == 1), float(axis == 2))
        place = float(found[2]) * _metres(text, found, 3, found[2])
        return _finite(text, SectionPlane(normal, place))
    text = _LENGTHS.sub(_in_metres, text)
    if found := _FACING.fullmatch(text):
        point = np.array([float(found[k]) for k in (1, 2, 3)])
        point = point * _metres(text, found, 4, "" if point.any() else "0")
        facing = np.array([float(found[k]) for k in (6, 7, 8)])
        if not facing.any():
            raise _wrong(text, found.span(5), "a plane faces some direction; write (0, 0, 1)")
        normal = facing / np.linalg.norm(facing)
        x, y, z = map(float, normal)
        return _finite(text, SectionPlane((x, y, z), float(normal @ point)))
    raise _wrong(text, _unread(text), f"this is no plane; {FORMS}")


def _finite(text: str, plane: SectionPlane) -> SectionPlane:
    if not isfinite(plane.offset) or not all(map(isfinite, plane.normal)):
        raise _wrong(text, (0, len(text)), f"a number is too large; {FORMS}")
    return plane


def _in_metres(found: re.Match[str]) -> str:
    """Return three lengths with units of their own in one unit; as they are if one is none."""
    metres: list[float] = []
    for k in (1, 3, 5):
        number, unit = float(found[k]), found[k + 1]
        try:
            read = parse_unit(unit) if unit else None
        except UnitError:
            return found[0]
        if (read is None and number) or (read is not None and read.dimension != LENGTH):
            return found[0]
        metres.append(number * (1.0 if read is None else read.factor))
    return f"({', '.join(map(repr, metres))}) m"


def _metres(text: str, found: re.Match[str], group: int, amount: str) -> float:
    """Return the size of the unit in a group of a match [m]; 0 needs none."""
    unit = found[group]
    if not unit:
        if amount and float(amount) == 0.0:
            return 1.0
        end = found.start(group)
        instead = f"{text[:end].rstrip()} mm{text[end:]}"
        raise _wrong(text, (max(end - 1, 0), end), f'a length has a unit; write "{instead}"')
    try:
        read = parse_unit(unit)
    except UnitError as error:
        raise _wrong(text, found.span(group), f"{error}; {FORMS}") from None
    if read.dimension != LENGTH:
        raise _wrong(text, found.span(group), f'"{unit}" is no unit of length; {FORMS}')
    return read.factor


def _unread(text: str) -> tuple[int, int]:
    """Return from where on a text differs from the form that it begins like."""
    begin = len(text) - len(text.lstrip())
    starts = (
        rf"\s*[xyz]\s*=\s*(?:{_NUMBER})?\s*\S*\s*", r"\s*[xyz]\s*",
        rf"\s*(?:(?:along\s+)?plane\s+)?through\s+{_TRIPLE}\s*\S*\s+facing\s*",
        rf"\s*(?:(?:along\s+)?plane\s+)?through\s+{_TRIPLE}\s*",
        r"\s*(?:(?:along\s+)?plane\s+)?through\s*",
    )  # fmt: skip
    reached = [found.end() for form in starts if (found := re.match(form, text))]
    begin = max([begin, *reached])
    return begin, max(len(text.rstrip()), begin + 1)


def _wrong(text: str, place: tuple[int, int], message: str) -> ValueError:
    begin, end = place
    carets = " " * begin + "^" * max(1, end - begin)
    return ValueError(f"{message}\n    {text}\n    {carets}")
