"""Angles whose derivatives are known in closed form, and their cosines and sines."""

from collections.abc import Sequence
from typing import NamedTuple

from tissuec.autodiff.functions import cos, ruled, sin
from tissuec.autodiff.graph import Number, Operand


class Angle(NamedTuple):
    """An angle θ, of which no arc is computed.

    Attributes:
        way: A number with the derivatives of θ, whose value means nothing.
        cosine, sine: Of θ.
    """

    way: Number
    cosine: Number
    sine: Number

    @classmethod
    def of(
        cls, arguments: Sequence[Number], slopes: Sequence[Number], cosine: Number, sine: Number
    ) -> "Angle":
        """Return an angle.

        Args:
            arguments: What it depends on.
            slopes: Its derivatives by these.
            cosine, sine: Their formulas, of which no derivative is taken.
        """
        way = ruled(cosine.graph.number(0.0), [*arguments, *slopes], _given)
        return cls.along(way, cosine, sine)

    @classmethod
    def along(cls, way: Number, cosine: Number, sine: Number) -> "Angle":
        """Return an angle by a number with its derivatives, its cosine and its sine."""
        values = way, cosine, sine
        return cls(way, ruled(cosine, values, _of_cosine), ruled(sine, values, _of_sine))

    @classmethod
    def written(cls, angle: Number) -> "Angle":
        """Return an angle that is a number [rad]."""
        return cls(angle, cos(angle), sin(angle))

    def less(self, other: "Angle") -> "Angle":
        """Return the difference from another angle."""
        cosine = self.cosine * other.cosine + self.sine * other.sine
        sine = self.sine * other.cosine - self.cosine * other.sine
        return Angle.along(self.way - other.way, cosine, sine)

    @property
    def versine(self) -> Number:
        """Return 1 - cos θ, to full precision also of small angles."""
        # Of a small angle, nearly all is sin² θ/2, which has all digits.
        value = 0.5 * (self.sine**2 + (1.0 - self.cosine) ** 2)
        return ruled(value, [self.way, self.sine], _of_versine)


def _given(_: Number, *values: Number) -> list[Operand]:
    count = len(values) // 2
    return [*values[count:], *[0.0] * count]


def _of_cosine(_: Number, way: Number, cosine: Number, sine: Number) -> list[Operand]:
    return [-ruled(sine, (way, cosine, sine), _of_sine), 0.0, 0.0]


def _of_sine(_: Number, way: Number, cosine: Number, sine: Number) -> list[Operand]:
    return [ruled(cosine, (way, cosine, sine), _of_cosine), 0.0, 0.0]


def _of_versine(_: Number, way: Number, sine: Number) -> list[Operand]:
    return [sine, 0.0]
