"""Loops over elements that add their forces, or write numbers of their points."""

from collections.abc import Sequence

from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.loops.cells import point_loop
from tissuec.compiled.loops.frame import LoopText, Target, at_corners
from tissuec.compiled.loops.point_frame import PointTable, parted
from tissuec.compiled.loops.tables import LANES


def force_loop(name: str, point: TracedPoint, nodes: int, points: int) -> LoopText:
    """Return the loop that adds forces, rates of what is remembered, and powers.

    Args:
        name: Of the function.
        point: Of the elements.
        nodes, points: Of each element.
    """
    loop = point_loop(point, nodes, points)
    code, is_lossy = loop.code, point.power.value != 0.0
    outputs, strained = [*point.pull, point.power, *point.rates], loop.strained
    loop.begin(outputs)
    pushed = loop.room_of(strained + 1)
    rates = loop.room_of(len(point.rates)) if point.rates else ""
    loop.clear(pushed, strained + 1)

    def press(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        values["pull"] = code.add(f"fneg {code.kind} {weight}")
        pull, (lost,), changes = parted(code.write(outputs, values), loop.components, 1)
        loop.push(pushed, pull, slopes)
        if is_lossy:
            loop.put(code.fused(weight, lost, loop.read(pushed, strained)), pushed, strained)
        for k, change in enumerate(changes):
            rate = values[f"p.rate.{k // loop.kept_numbers}"]
            loop.put(code.add(f"fmul {code.kind} {rate}, {change}"), rates, k)
        if changes:
            loop.give("give", q, rates)

    loop.each_point("press", press)

    lost: list[Target] = []
    if is_lossy:
        lost = [("power", 0 if point.state.is_supplied else 1)]
    forces = loop.forces(pushed)
    loop.each_lane(lambda: loop.scatter(forces, [*at_corners("f", nodes), *lost]))
    return loop.text(name, ("x", "v", "f", "power"), PointTable)


def record_loop(
    name: str, point: TracedPoint, outputs: Sequence[Number], nodes: int, points: int
) -> LoopText:
    """Return the loop that writes numbers of each point, for ``recorded`` to read.

    Args:
        name: Of the function.
        nodes, points: Of each element.
    """
    loop = point_loop(point, nodes, points)
    code = loop.code
    loop.begin(outputs)
    size = len(outputs) * LANES

    def write(q: str) -> None:
        _, _, values = loop.at_point(q)
        place = code.add(f"add i64 {code.add(f'mul i64 %block, {points}')}, {q}")
        base = code.address("%out", code.add(f"mul i64 {place}, {size}"))
        for k, value in enumerate(code.write(outputs, values)):
            code.store(value, code.address(base, k * LANES))

    loop.each_point("write", write)
    return loop.text(name, ("x", "v", "out"), PointTable)


def mean_loop(
    name: str, point: TracedPoint, outputs: Sequence[Number], nodes: int, points: int
) -> LoopText:
    """Return the loop that writes numbers of each element, for ``recorded`` to read.

    They may depend on ``TracedPoint.mean_of`` numbers of points; the arguments are those of
    ``record_loop``.
    """
    loop, averaged = point_loop(point, nodes, points), point.averaged(outputs)
    code, count = loop.code, len(averaged)
    loop.begin([*averaged.values(), *outputs])
    sums = loop.room_of(count + 1)
    loop.clear(sums, count + 1)

    def add(q: str) -> None:
        _, weight, values = loop.at_point(q)
        for k, value in enumerate(code.write(list(averaged.values()), values)):
            loop.put(code.fused(weight, value, loop.read(sums, k)), sums, k)
        loop.add_up(weight, sums, count)

    loop.each_point("add", add)
    volume = loop.read(sums, count)
    means = {
        each: code.add(f"fdiv {code.kind} {loop.read(sums, k)}, {volume}")
        for k, each in enumerate(averaged)
    }
    base = loop.row_of_blocks("out", len(outputs))
    for k, value in enumerate(loop.whole(outputs, means)):
        code.store(value, code.address(base, k * LANES))
    return loop.text(name, ("x", "v", "out"), PointTable)
