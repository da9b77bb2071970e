"""Loops over elements that carry derivatives of their forces backwards and forwards."""

from collections.abc import Mapping, Sequence

from tissuec.autodiff.derivatives import gradient
from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.loops.cells import point_loop
from tissuec.compiled.loops.frame import LoopText, at_corners, places_of_numbers
from tissuec.compiled.loops.point_frame import PointLoop, PointTable, parted
from tissuec.compiled.loops.tables import LANES


def pull_loop(
    name: str, point: TracedPoint, learnt: Sequence[str], nodes: int, points: int
) -> LoopText:
    """Return the loop ``pull_back`` of ``forces.matrices``.

    With W = Σ w_a ⊗ ∂N_a/∂X and A = Σ w ∂r/∂F : W, the derivatives of Σ weight · f are those of
    -P : W + h · dT/dt - A U''/V r at all points, and -A ∂U'/∂p.

    Args:
        name: Of the function.
        point: Of the elements.
        learnt: Names of numbers.
        nodes, points: Of each element.
    """
    loop, outputs = point_loop(point, nodes, points), point.pulled(learnt)
    code, numbers, kept = loop.code, point.of(learnt), loop.kept_numbers * point.tensors
    by_mean = gradient(point.slope_of_mean, numbers)
    loop.begin([*outputs, *by_mean, point.bend_of_mean], moves=True)
    load, turned, strained = loop.gathered("load"), loop.room_of(1), loop.strained
    weights = loop.carried(load)
    by_x, by_v, by = map(loop.room_of, (strained, strained, max(1, len(numbers))))
    by_kept = loop.room_of(max(1, kept))
    for room, rows in ((turned, 1), (by_x, strained), (by_v, strained), (by, len(numbers))):
        loop.clear(room, rows)

    share = _share_of_mean(loop, weights, turned) if point.is_pooled else code.constant(0.0)

    def pull(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        given = {f"w.{k}": one for k, one in enumerate(loop.gradient_of(weights, slopes))}
        given |= _loads_of_rates(loop, q, loop.rates_of(values), weight)
        written = loop.times(weight, code.write(outputs, values | given | {"share": share}))
        of_f, of_rate, of_kept, of_numbers = parted(written, *[loop.components] * 2, kept)
        loop.push(by_x, of_f, slopes)
        loop.push(by_v, of_rate, slopes)
        for k, each in enumerate(of_numbers):
            loop.add_up(each, by, k)
        for k, each in enumerate(of_kept):
            inverse = values[f"p.inverse_rate.{k // loop.kept_numbers}"]
            loop.put(loop.times(inverse, [each])[0], by_kept, k)
        if kept:
            loop.give("give", q, by_kept, "by_v")

    loop.each_point("pull", pull)
    for k, each in enumerate(code.write(by_mean, loop.values) if point.is_pooled else ()):
        loop.add_up(
            code.add(f"fneg {code.kind} {loop.times(loop.read(turned, 0), [each])[0]}"), by, k
        )

    by_x, by_v = loop.derivatives(load, by_x, by_v, by, numbers)

    def write() -> None:
        loop.scatter(by_x, at_corners("by_x", nodes))
        loop.scatter(by_v, at_corners("by_v", nodes))
        every = dict.fromkeys(learnt, False)
        loop.scatter(by, [("by", at) for at in places_of_numbers(loop, point.widths, every)])

    loop.each_lane(write)
    return loop.text(name, ("x", "v", "load", "by_x", "by_v", "by"), PointTable)


def _share_of_mean(loop: PointLoop, weights: str, turned: str) -> str:
    """Return -A U''/V of ``pull_loop``, and store A.

    Args:
        weights: Where the weights of the nodes are.
        turned: Where A is stored.
    """
    code, point = loop.code, loop.point

    def turn(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        rise = loop.inner(code.write(point.pooling, values), loop.gradient_of(weights, slopes))
        loop.add_up(loop.times(weight, [rise])[0], turned, 0)

    loop.each_point("turn", turn)
    (bend,) = code.write([point.bend_of_mean], loop.values)
    (share,) = loop.times(bend, [code.add(f"fneg {code.kind} {loop.read(turned, 0)}")])
    return code.add(f"fdiv {code.kind} {share}, {loop.read(loop.sums, 0)}")


def push_loop(
    name: str, point: TracedPoint, learnt: Sequence[str], nodes: int, points: int
) -> LoopText:
    """Return the loop ``push_forward`` of ``forces.matrices``; see ``pull_loop``."""
    loop, outputs = point_loop(point, nodes, points), point.pushed(learnt)
    code, kept = loop.code, loop.kept_numbers * point.tensors
    learnt_numbers = point.of(learnt)
    numbers = [str(each.operation.detail) for each in learnt_numbers]
    of_mean, of_pooled = point.pushed_mean(learnt)
    loop.begin([*outputs, of_mean, of_pooled], moves=True)
    dx, dv, df = (loop.room_of(each) for each in (3 * nodes, 3 * nodes, loop.strained))
    pulls = loop.pulls(point.stress)
    rates = loop.room_of(max(1, kept))

    def change(m: str) -> None:
        for corner, places in enumerate(loop.places()):
            for axis in range(3):
                for vector, room in (("dx", dx), ("dv", dv)):
                    loop.put(loop.strided(vector, places, axis, m), room, 3 * corner + axis)
        given = _changes_of_numbers(loop, learnt, numbers, m)
        moved, faster = loop.vectors_of(dx), loop.vectors_of(dv)
        with_numbers = learnt_numbers, given
        strain, rate = (loop.carried(moved, each, *with_numbers) for each in ("", faster))
        loop.clear(df, loop.strained)

        if point.is_pooled:
            mean = _mean_change(loop, strain, given, of_pooled)
            (given["dswell"],) = code.write([of_mean], loop.values | given | {"dmean": mean})

        def push(q: str) -> None:
            slopes, weight, values = loop.at_point(q)
            for letter, room in (("df", strain), ("dg", rate)):
                form = loop.gradient_of(room, slopes)
                values |= {f"{letter}.{k}": one for k, one in enumerate(form)}
            for tensor, moved in enumerate(loop.kept_at(q, "dv", m)):
                scaled = loop.times(values[f"p.inverse_rate.{tensor}"], moved)
                values |= {f"dt.{tensor}.{k}": one for k, one in enumerate(scaled)}
            stress, rising = parted(code.write(outputs, values | given), loop.components)
            minus = code.add(f"fneg {code.kind} {weight}")
            loop.push(df, loop.times(minus, stress), slopes)
            every = loop.rates_of(values)
            for k, each in enumerate(rising):
                loop.put(loop.times(every[k // loop.kept_numbers], [each])[0], rates, k)
            if kept:
                loop.give("give", q, rates, "df", m)

        loop.each_point("push", push)
        rooms = {"pull": pulls, "dx": moved, "dv": faster, "dpull": df}
        forces = loop.changed_forces(*with_numbers, **rooms)
        loop.each_lane(lambda: loop.scatter_change(forces, "df", m))

    loop.repeat("changes", "%room.shape", change)
    return loop.text(name, ("x", "v", "dx", "dv", "dn", "df", "room"), PointTable)


def _loads_of_rates(
    loop: PointLoop, q: str, rates: Sequence[str], weight: str
) -> dict[str, str]:
    """Return weights of what a point remembers, by the names of inputs, of its volume."""
    code, found = loop.code, dict[str, str]()
    for tensor, heavy in enumerate(loop.kept_at(q, "load")):
        for k, one in enumerate(loop.times(rates[tensor], heavy)):
            found[f"h.{tensor}.{k}"] = code.add(f"fdiv {code.kind} {one}, {weight}")
    return found


def _mean_change(
    loop: PointLoop, strain: str, given: Mapping[str, str], pooled: Number
) -> str:  # fmt: skip
    """Return the change of the mean of what points pool.

    Args:
        strain: Where changes of strains are.
        given: Changes of numbers.
        pooled: That of what is pooled.
    """
    code, grown = loop.code, loop.room_of(1)
    loop.clear(grown, 1)

    def grow(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        form = loop.gradient_of(strain, slopes)
        values |= {f"df.{k}": one for k, one in enumerate(form)}
        (rise,) = code.write([pooled], values | dict(given))
        loop.add_up(loop.times(weight, [rise])[0], grown, 0)

    loop.each_point("grow", grow)
    return code.add(f"fdiv {code.kind} {loop.read(grown, 0)}, {loop.read(loop.sums, 0)}")


def _changes_of_numbers(
    loop: PointLoop, learnt: Sequence[str], numbers: Sequence[str], change: str
) -> dict[str, str]:
    """Return one of the changes of the numbers of the elements, by the names of inputs."""
    code, found, lanes = loop.code, [""] * len(numbers), list[list[str]]()
    for lane in range(LANES):
        item = code.add(f"add i64 %first, {lane}")
        test, last = code.add(f"icmp ult i64 {item}, %size"), code.add("sub i64 %size, 1")
        item = code.add(f"select i1 {test}, i64 {item}, i64 {last}")
        lanes.append(
            places_of_numbers(loop, loop.point.widths, dict.fromkeys(learnt, False), item)
        )
    for k, places in enumerate(zip(*lanes, strict=True)):
        found[k] = loop.strided("dn", places, 0, change)
    return {f"d{name}": value for name, value in zip(numbers, found, strict=True)}
