"""Unknowns at which an energy is least, such as the thickness of a wall without stress across.

With z > 0 at the least energy W(u, z), the derivatives of that energy are ∂W/∂u at a fixed z,
as ∂W/∂z is zero there (the envelope theorem). Those of z follow from its equation (the implicit
function theorem): in the logarithm y of z, dy/du = -W_yu / W_yy.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from tissuec.autodiff.derivatives import gradient
from tissuec.autodiff.functions import maximum, minimum, ruled, where
from tissuec.autodiff.graph import Iteration, Number, Operation

LONGEST = 1.0 / 3.0  # step of an iteration, in the logarithm
CLOSE = 1e-6  # step after which an iteration of third order is at rounding
ROUNDS = 60  # more than bisection needs
_FAR = 1e300


class Least(NamedTuple):
    """The least value of an energy, and where it is.

    Attributes:
        energy: The value.
        at: z.
        slope, bend: Its first and second derivative by the logarithm of z. Where the second is
            not positive, no least value was found, and z counts as constant.
    """

    energy: Number
    at: Number
    slope: Number
    bend: Number


def least(energy: Callable[[Number], Number], start: Number) -> Least:
    """Return the least energy over all z > 0.

    This is Halley's iteration in the logarithm of z, within limits between which z lies: it
    spares a round of Newton's, which would cost more than the third derivative. It ends when a
    step is below ``CLOSE``, or after ``ROUNDS`` steps.

    Args:
        energy: Takes z. What else it depends on is found by itself.
        start: From where z is sought, positive.
    """
    graph = start.graph
    name = f"unknown.{len(graph.operations)}"
    z, low, high = variables = tuple(
        graph.input(f"{name}.{each}") for each in ("z", "low", "high")
    )
    slope, bend = _logarithmic(energy, z)
    step, *following = _round(slope, bend, z * gradient(bend, [z], [z])[0], z, low, high)
    iteration = Iteration(
        variables, (start, graph.number(0.0), graph.number(_FAR)), step, tuple(following),
        CLOSE, ROUNDS,
    )  # fmt: skip
    outer = graph.apart_from([step, *following], variables)
    given = tuple(each.place for each in (*iteration.start, *outer))
    found = graph.record(Operation("unknown", given, iteration))
    # Factors of what is constant may be gathered in slopes, which then are of other numbers.
    several = [energy(z), *_logarithmic(energy, z)]
    others = graph.apart_from(several, [z], by_rules=True)

    def follow(at: Number, *others: Number) -> Sequence[Number]:
        fixed = [at, *others]
        slope = at * gradient(energy(at), [at], fixed)[0]
        by_at, *mixed = gradient(slope, fixed, fixed)
        bend = at * by_at
        factor = where(bend > 0.0, -at / where(bend > 0.0, bend, 1.0), 0.0)
        return [factor * each for each in mixed]

    at = ruled(found, others, follow)

    def envelope(_: Number, *others: Number) -> Sequence[Number]:
        return gradient(energy(at), others, [at, *others])

    return Least(ruled(energy(at), others, envelope), at, *_logarithmic(energy, at))


def _logarithmic(energy: Callable[[Number], Number], z: Number) -> tuple[Number, Number]:
    """Return the first and second derivative of an energy by the logarithm of z."""
    slope = z * gradient(energy(z), [z], [z])[0]
    return slope, z * gradient(slope, [z], [z])[0]


def _round(
    slope: Number, bend: Number, third: Number, z: Number, low: Number, high: Number
) -> tuple[Number, Number, Number, Number]:
    """Return a step of the logarithm, and z and its limits after it.

    Args:
        slope, bend, third: Derivatives of the energy by the logarithm.
        z, low, high: Before the step.
    """
    low, high = where(slope > 0.0, low, z), where(slope > 0.0, z, high)
    steep = where(bend > 0.0, bend, 1.0)
    wanted = -slope / steep
    curved = 1.0 + 0.5 * wanted * third / steep
    wanted = where(curved > 0.5, wanted / curved, wanted)
    downhill = where(slope > 0.0, -LONGEST, LONGEST)
    step = where(bend > 0.0, where(abs(wanted) < _FAR, wanted, downhill), downhill)
    step = minimum(maximum(step, -LONGEST), LONGEST)
    found = z * (1.0 + step * (1.0 + 0.5 * step))
    # A limit is crossed only after both were reached, which are one step apart then.
    middle = 0.5 * (low + high)
    found = where(low > found, middle, where(found > high, middle, found))
    return step, found, low, high
