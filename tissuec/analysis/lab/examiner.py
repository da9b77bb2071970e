"""The base of all examinations: rows of tests, and their comparison with the evidence."""

from collections.abc import Callable, Iterator
from math import isfinite, nan
from typing import TypeAlias

from tissuec.analysis.lab.bench import TestBench, Unmeasured
from tissuec.analysis.lab.rows import SHARE, Examination, LabCurve, TestRow, agrees, curve_rows
from tissuec.core import units
from tissuec.core.names import key_of
from tissuec.core.units import Dimension, show
from tissuec.scene.model import KnownQuantity
from tissuec.scene.tissues.quantities import KNOWABLE

DEPENDS = "depends on the mesh"
#: Quantities of tests that no source states as such.
OTHERS: dict[str, Dimension] = {"relaxed in all": units.NUMBER, "time in all": units.TIME}
#: Results of a test, by quantity.
Values: TypeAlias = dict[str, float]
#: Called with each row once it is measured.
Listener: TypeAlias = Callable[[TestRow], None]


class Examiner:
    """One examination, test by test.

    Args:
        bench: The bench of the tissue.
        coupons: Description of the specimens.
        listener: Callback for each row.
    """

    #: The verdict if a measurement differs from its check.
    beside = "the coupons differ"

    def __init__(self, bench: TestBench, coupons: str, listener: Listener):
        self.bench, self._listener = bench, listener
        self.found = Examination(bench.tissue, coupons)

    @property
    def along(self) -> str:
        """Return the name of the modulus of coupons along x."""
        return "fibre modulus" if self.bench.has_fibres else "Young's modulus"

    def attempt(
        self, name: str, measure: Callable[[], tuple[Values, Values]], share: float = SHARE
    ) -> bool:
        """Add the rows of a test, and return whether it measured anything.

        Args:
            name: Name of the test.
            measure: Returns the measured values, and their checks.
            share: Allowed relative deviation of a measurement.
        """
        try:
            measured, check = measure()
        except Unmeasured as reason:
            self.add(name, "", nan, nan, str(reason), share)
            return False
        for quantity in measured | check:
            expected, found = check.get(quantity, nan), measured.get(quantity, nan)
            self.add(name, quantity, expected, found, "", share)
        return True

    def add(
        self, test: str, quantity: str, check: float, measured: float, why: str, share: float
    ) -> None:
        """Add a row.

        Args:
            test: Name of the test.
            quantity: Measured quantity.
            check: The value by an independent method.
            measured: The measured value.
            why: The reason if there is none.
            share: Its allowed relative deviation.
        """
        tissue, key = self.found.tissue, key_of(quantity)
        known = tuple(one for one in tissue.known if key_of(one.quantity.name) == key)
        given = tissue.given.get(key)
        complaints = list(self._complaints(test, check, measured, known, share))
        if complaints:
            verdict = "; ".join(complaints)
        elif isfinite(measured):
            verdict = "good" if self.bench.is_of_matter else DEPENDS
        else:
            verdict = "none"
        if why:
            verdict = f"not measured: {why}"
        dimension = units.NUMBER
        if quantity:
            dimension = OTHERS[key] if key in OTHERS else KNOWABLE[key].dimension
        value = given.value if given else None
        self.keep(
            TestRow(
                test,
                quantity,
                check,
                measured,
                value,
                known,
                verdict,
                not complaints,
                dimension,
            )
        )

    def keep(self, row: TestRow) -> None:
        """Append a row to the results."""
        self.found.rows.append(row)
        self._listener(row)

    def keep_curve(self, test: str, curve: LabCurve, why: str) -> None:
        """Add a curve, and a row for each source on it.

        Args:
            test: Name of the test.
            why: The reason why it ends.
        """
        self.found.curves.append(curve)
        for row in curve_rows(test, curve, why):
            self.keep(row)

    def is_needed(self, test: str) -> bool:
        """Return whether all other tests need the results of a test."""
        return test == "tension"

    def _complaints(
        self,
        test: str,
        check: float,
        measured: float,
        known: tuple[KnownQuantity, ...],
        share: float,
    ) -> Iterator[str]:
        """Yield the contradictions of a row: to evidence, or to its check."""
        if not isfinite(measured):
            if known or isfinite(check) or self.is_needed(test):
                yield "not measured: it does not break"
            return
        for one in known:
            if not agrees(measured, one, share):
                yield f'contradicts "{one.source}"'
        if not isfinite(check):
            return
        apart = abs(measured - check) / max(abs(measured), abs(check), 1e-300)
        if self.bench.is_of_matter and apart > share:
            yield f"{self.beside} by {100.0 * apart:.2g} %"

    def note(self, text: str) -> None:
        """Add a note."""
        self.found.notes.append(text)

    def note_what_was_left_out(self) -> None:
        """Add a note for evidence that no test covers."""
        tested = {key_of(row.quantity) for row in self.found.rows}
        for one in self.found.tissue.known:
            if key_of(one.quantity.name) not in tested:
                self.note(f"the evidence on {one.quantity.name} was not tested")
        sources = {row.known[0].span for row in self.found.rows if row.known}
        for curve in self.found.tissue.curves:
            if curve.span not in sources:
                self.note(f"the evidence on {curve.name} was not tested")

    def note_the_mesh(self) -> None:
        """Add a note where results depend on the mesh."""
        if not self.bench.is_of_matter:
            at = show(self.bench.spacing, units.LENGTH)
            self.note(
                "its quantities belong to springs and nodes, so all results depend on "
                f"the mesh: the spacing is {at}, on coupons of two sizes"
            )
