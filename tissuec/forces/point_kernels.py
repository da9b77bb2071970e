"""Kernels of elements around points whose energy is written once; see ``point_fields``.

Shared arguments:
    traced: Returns the traced point of a kind.
    kind: Of the elements, such as a ``SolidKind``.
    nodes, points: Of each element.
"""

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops.frame import LoopText
from tissuec.compiled.loops.points import mean_loop, record_loop
from tissuec.forces.solids.element_limits import measures_of
from tissuec.forces.solids.solid_point import SolidKind

#: Returns the traced points of elements of a kind, such as a ``SolidKind``.
Tracing = Callable[[Any], TracedPoint]


@cache
def record_kernel(
    traced: Tracing, kind: SolidKind, name: str, nodes: int, points: int
) -> tuple[GeneratedKernel, int]:
    """Return the kernel that records numbers of traced points, and how many there are."""
    return GeneratedKernel(
        f"points_{name}", partial(_recording, traced, kind, name, nodes, points)
    ), len(_numbers_of(traced(kind), name))


def _recording(
    traced: Tracing, kind: SolidKind, name: str, nodes: int, points: int, own: str
) -> LoopText:
    """Return the loop that records numbers of points."""
    point = traced(kind)
    return record_loop(own, point, _numbers_of(point, name), nodes, points)


def _numbers_of(point: TracedPoint, name: str) -> Sequence[Number]:
    """Return the numbers of a point that are recorded under a name."""
    return point.state.seen[name] if name in point.state.seen else getattr(point, name)


@cache
def limit_kernel(
    traced: Tracing, kind: SolidKind, names: tuple[str, ...], nodes: int, points: int
) -> GeneratedKernel:
    """Return the kernel that records the quantities that limits of elements concern."""
    return GeneratedKernel(
        "points_limits", partial(_measuring, traced, kind, names, nodes, points)
    )


def _measuring(
    traced: Tracing, kind: SolidKind, names: tuple[str, ...], nodes: int, points: int, own: str
) -> LoopText:
    """Return the loop that records the quantities that limits concern."""
    point = traced(kind)
    every = measures_of(point)
    return mean_loop(own, point, [every[name] for name in names], nodes, points)


@cache
def kernel_of(
    loop: Callable[..., LoopText], traced: Tracing, kind: Any, *arguments: Any
) -> GeneratedKernel:
    """Return the kernel of a loop over elements, such as ``force_loop``, with its arguments."""
    made = partial(written, loop, traced, kind, *arguments)
    return GeneratedKernel(f"points_{loop.__name__}", made)


def written(
    loop: Callable[..., LoopText], traced: Tracing, kind: Any, *arguments: Any
) -> LoopText:
    """Return a loop over elements of a kind; its name is the last of the arguments."""
    *rest, name = arguments
    return loop(name, traced(kind), *rest)
