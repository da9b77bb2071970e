"""Loops over single groups, and within them over their items, whose rows are stored.

A group has λ from the sums of its items, and pushes these; see ``autodiff.pools``.
"""

from collections.abc import Callable, Sequence

from tissuec.autodiff.emission import Writer
from tissuec.autodiff.graph import Number
from tissuec.autodiff.pools import TracedPool
from tissuec.compiled.loops.frame import ItemLoop, LoopText
from tissuec.compiled.loops.tables import LANES

#: Where the powers of groups and the bends that they pass are added.
_TOTALS = ("power", 0), ("power", 1), ("passed", 0)


class _Groups(ItemLoop):
    """Writes a loop over single groups, and within it over their items, which are stored."""

    def __init__(self, pool: TracedPool):
        super().__init__(pool.graph, pool.numbers, 2, 1)
        self.pool, self._corners, code = pool, "", self.code
        self._rows = {each.place: k for k, each in enumerate(pool.rows)}
        self._begin, end = (
            code.load(code.address("%begins", at, "i64"), "i64")
            for at in (self.first, code.add(f"add i64 {self.first}, 1"))
        )
        self._count = code.add(f"sub i64 {end}, {self._begin}")
        # Where totals are, by what they are added to at last.
        self._totals = dict[tuple[str, int], str]()

    def each_item(self, name: str, write: Callable[[Callable[[Number], str]], None]) -> None:
        """Write a loop over the items that act.

        Args:
            name: Of the loop.
            write: Writes what is done, given what reads numbers of the item.
        """
        code, acts = self.code, self.pool.shares.acts

        def of_item(k: str) -> None:
            item = code.add(f"add i64 {self._begin}, {k}")
            base = self.row_of_blocks("stored", len(self._rows), item)
            self._corners = code.add(f"mul i64 {item}, {self.pool.places}")

            def read(number: Number) -> str:
                return code.load(code.address(base, self._rows[number.place] * LANES))

            if acts is not None:
                is_some = code.add(f"fcmp ogt double {read(acts)}, {code.constant(0.0)}")
                code.line(f"br i1 {is_some}, label %{name}.some, label %{name}.end")
                code.label(f"{name}.some")
            write(read)

        self.repeat(name, self._count, of_item)

    def ends(self) -> tuple[list[str], list[str]]:
        """Return the sums, and λ; add the powers, and the bends that are passed."""
        code, pool = self.code, self.pool
        shares, sums = pool.shares, self.keep([code.constant(0.0)] * pool.count)

        def add(read: Callable[[Number], str]) -> None:
            for k, part in enumerate(shares.summed):
                place, value = self.row(sums, k), read(part)
                if k in shares.greatest:
                    before = code.load(place)
                    is_more = code.add(f"fcmp ogt double {before}, {value}")
                    code.store(code.select(is_more, before, value), place)
                else:
                    self.add_to(place, value)
            if shares.bends is not None:
                self._total(_TOTALS[-1], read(shares.bends))

        self.each_item("sum", add)
        values, _ = self.inputs(pool.ends, {"x": "x", "a": "amounts"}, [])
        totals = [code.load(self.row(sums, k)) for k in range(pool.count)]
        values |= {f"s.0.{k}": total for k, total in enumerate(totals)}
        *factors, supply, lost, bends = code.write(pool.ends, values)
        powers = zip(pool.ends[-3:], (supply, lost, bends), _TOTALS, strict=True)
        for number, value, place in powers:
            if number.value != 0.0:
                self._total(place, value)
        return totals, factors

    def _total(self, place: tuple[str, int], value: str) -> None:
        """Add a number to a total of all groups, which is in a register until their end."""
        if place not in self._totals:
            self._totals[place] = self.room_of(1)
            self.room.append(f"  store double 0.0, ptr {self._totals[place]}")
        self.add_to(self._totals[place], value)

    def after(self) -> list[str]:
        """Return the code that adds the totals."""
        code, self.code = self.code, Writer(1, "t")
        for (vector, k), room in self._totals.items():
            self.add_to(self.code.address(f"%{vector}", k), self.code.load(room))
        found, self.code = self.code.lines, code
        return found

    def store(self, vector: str, values: Sequence[str]) -> None:
        """Store numbers of the group."""
        base = self.code.address(f"%{vector}", self.code.add(f"mul i64 {self.first}, 3"))
        for k, value in enumerate(values):
            self.code.store(value, self.code.address(base, k))

    def push(self, factors: Sequence[str]) -> None:
        """Add the forces of items, given λ."""
        code, slopes = self.code, list(zip(*self.pool.slopes, strict=True))
        against = [code.add(f"fneg double {each}") for each in factors]

        def of_item(read: Callable[[Number], str]) -> None:
            for corner in range(self.pool.item.corners):
                at = code.add(f"add i64 {self._corners}, {corner}")
                node = code.load(code.address("%corners", at, "i64"), "i64")
                base = code.address("%f", node)
                for axis in range(3):
                    place = code.address(base, axis)
                    total = code.load(place)
                    for factor, slope in zip(against, slopes[3 * corner + axis], strict=True):
                        total = code.fused(factor, read(slope), total)
                    code.store(total, place)

        self.each_item("push", of_item)


def group_loop(pool: TracedPool, *, pushes: bool) -> LoopText:
    """Return the loop that adds the forces of items, or that stores the sums and λ instead."""
    loop = _Groups(pool)
    sums, factors = loop.ends()
    if pushes:
        loop.push(factors)
    else:
        loop.store("sums", sums)
        loop.store("factors", factors)
    to = ("f",) if pushes else ("sums", "factors")
    names = "x", *to, "power", "amounts", "passed", "stored", "begins", "corners"
    return loop.text("groups", names, after=loop.after())
