"""Loops over items that carry many changes forward, which are in the lanes."""

from collections.abc import Iterable, Mapping, Sequence

from tissuec.autodiff.emission import Writer
from tissuec.autodiff.graph import Number
from tissuec.compiled.loops.frame import (
    SUFFIX,
    ItemLoop,
    LoopText,
    Place,
    Target,
    places_of_numbers,
)
from tissuec.compiled.loops.tables import LANES


class Changes(Writer):
    """Writes a loop over changes, which are in the lanes, within a loop over single items."""

    def __init__(self, loop: ItemLoop):
        super().__init__(LANES, "m")
        self._loop, self._outer, self.lines = loop, loop.code, loop.code.lines

    # --- before the loop, or between its rounds -----------------------------------------------

    def apart(
        self, outputs: Sequence[Number], changing: Iterable[Number], state: Mapping[str, str],
        constants: Sequence[int] = (), more: Mapping[str, str] | None = None,
    ) -> dict[int, str]:  # fmt: skip
        """Write what outputs need and what does not depend on changes; return it by places.

        Args:
            state, constants: As ``vectors`` and ``known`` of ``ItemLoop.inputs``.
            more: Names of the values of further inputs.
        """
        still = self._loop.graph.apart_from(outputs, changing)
        values, known = self._loop.inputs(still, state, constants)
        written = self._outer.write(still, {**values, **(more or {})}, known)
        return {
            each.place: self.in_all_lanes(value, "i1" if each.is_condition else "double")
            for each, value in zip(still, written, strict=True)
        }

    def rows(self, targets: Sequence[Target]) -> list[tuple[str, str]]:
        """Return vectors and where the changes of numbers begin in them; of the item."""
        code, nodes = self._outer, [place for (place,) in self._loop.places()]

        def row(at: Place) -> str:
            own = code.add(f"add i64 {nodes[at[0]]}, {at[1]}") if isinstance(at, tuple) else at
            return code.add(f"mul i64 {own}, %room.shape")

        return [(vector, row(at)) for vector, at in targets]

    # --- in the loop ------------------------------------------------------------------------

    def begin(self) -> None:
        """Begin the loop."""
        before, lanes = self._outer.block, ", ".join(f"i64 {k}" for k in range(LANES))
        self.line("br label %changes")
        self.label("changes")
        self.line(f"%change = phi i64 [ 0, %{before} ], [ %change.next, %changes.end ]")
        self.line("%change.left = sub i64 %room.shape, %change")
        whole = f"<{LANES} x i64>"
        left = self.in_all_lanes("%change.left", "i64")
        self.line(f"%mask = icmp ugt {whole} {left}, <{lanes}>")
        self._outer.block = self.block

    def given(
        self, outputs: Sequence[Number], rates: Iterable[str], rows: Sequence[tuple[str, str]]
    ) -> dict[str, str]:
        """Return the changes that outputs need, by the names of their inputs in order."""
        needed = self._loop.graph.inputs_of(outputs)
        pairs = zip(rates, rows, strict=True)
        return {rate: self._masked(self._at(*row)) for rate, row in pairs if rate in needed}

    def add_to_rows(self, rows: Sequence[tuple[str, str]], values: Sequence[str]) -> None:
        """Add values to changes."""
        for row, value in zip(rows, values, strict=True):
            place = self._at(*row)
            total = self.add(f"fadd {self.kind} {self._masked(place)}, {value}")
            given = f"{self.kind} {total}, ptr {place}, i32 8, {self.condition} %mask"
            self.line(f"call void @llvm.masked.store.{SUFFIX[LANES]}.p0({given})")

    def _at(self, vector: str, row: str) -> str:
        return self.address(f"%{vector}", self.add(f"add i64 {row}, %change"))

    def _masked(self, place: str) -> str:
        given = f"ptr {place}, i32 8, {self.condition} %mask, {self.kind} zeroinitializer"
        name = f"llvm.masked.load.{SUFFIX[LANES]}.p0"
        return self.add(f"call {self.kind} @{name}({given})")

    def end(self) -> None:
        """End the loop."""
        self.line("br label %changes.end")
        self.label("changes.end")
        self.line(f"%change.next = add i64 %change, {LANES}")
        self.line("%change.more = icmp ult i64 %change.next, %room.shape")
        self.line("br i1 %change.more, label %changes, label %changes.out")
        self.label("changes.out")
        self._outer.block = self.block
        self._outer.called |= self.called


def change_loop(
    name: str, loop: ItemLoop, outputs: Sequence[Number], rates: Iterable[str],
    vectors: Mapping[str, str], sources: Sequence[Target], targets: Sequence[Target],
    constants: Sequence[Number] = (), *,
    learnt: tuple[Mapping[str, int], Mapping[str, bool]] = ({}, {}),
) -> LoopText:  # fmt: skip
    """Return a loop that adds changes, which are in its lanes.

    Args:
        loop: Over single items.
        rates: Inputs that are changes, in the order of their sources.
        sources: Where changes are; the last ones, those of numbers, are in "dn".
        vectors, targets, constants, learnt: As those of ``add_loop``.
    """
    rates, many = tuple(rates), Changes(loop)
    known = [each.place for each in constants]
    spread = many.apart(outputs, map(loop.graph.input, rates), vectors, known)
    numbers = places_of_numbers(loop, *learnt, "%first")
    sources = [*sources, *(("dn", at) for at in numbers)]
    given, to = many.rows(sources), many.rows(targets)
    many.begin()
    many.add_to_rows(to, many.write(outputs, many.given(outputs, rates, given), spread))
    many.end()
    named = (*vectors.values(), *(each for each, _ in (*sources, *targets)), "room")
    return loop.text(name, tuple(dict.fromkeys(named)))
