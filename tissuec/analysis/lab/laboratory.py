"""The laboratory: all tests of a tissue on two coupons, compared with evidence."""

from collections.abc import Callable, Iterator
from math import isfinite, nan
from typing import TypeAlias

from msgspec import Struct, field

from tissuec.analysis.lab import indentation, motion, statics
from tissuec.analysis.lab.bench import TestBench, Unmeasured
from tissuec.analysis.lab.coupon import Coupon
from tissuec.analysis.lab.statics import StressStrainCurve, TensionTest
from tissuec.compiler.provenance import used_tissues
from tissuec.core import arguments, units
from tissuec.core.errors import TissueError
from tissuec.core.hints import did_you_mean
from tissuec.core.names import key_of
from tissuec.core.source import Source
from tissuec.core.units import Dimension, show
from tissuec.model.inelastic import TIMES
from tissuec.scene.model import KnownQuantity, Tissue
from tissuec.scene.quantities import KNOWABLE, YOUNGS_MODULUS
from tissuec.scene.request import Request
from tissuec.scene.resolve import ResolvedProgram

SHARE = 0.05  # by which a measurement may be off
#: The same of indentation, as a block with free sides is no layer, and its contact is of nodes.
BY_LAYER = 0.15
SPACING = 2.5e-3  # [m], where quantities belong to springs
DEPENDS = "depends on the mesh"
#: Quantities of tests that no source states as such.
_OTHERS: dict[str, Dimension] = {"relaxed in all": units.NUMBER, "time in all": units.TIME}
#: What a coupon gives, by quantity.
Values: TypeAlias = dict[str, float]


class TestRow(Struct, frozen=True):
    """One quantity that a test measured.

    Attributes:
        test: Which test.
        quantity: What it measured.
        coarse, fine: On either coupon, in SI units; NaN where it was not measured.
        given: What the tissue says of it, in SI units; None if nothing.
        known: Evidence on it.
        verdict: What it contradicts; otherwise "good", or that it depends on the mesh.
        is_good: Whether it agrees with the evidence, and on both coupons.
    """

    test: str
    quantity: str
    coarse: float
    fine: float
    given: float | None
    known: tuple[KnownQuantity, ...]
    verdict: str
    is_good: bool

    def shown(self, value: float) -> str:
        """Return a value of this quantity with its unit."""
        if not isfinite(value):
            return "-"
        key = key_of(self.quantity)
        dimension = _OTHERS[key] if key in _OTHERS else KNOWABLE[key].dimension
        return show(value, dimension, digits=4)


class Examination(Struct):
    """Results of all tests of a tissue.

    Attributes:
        tissue: Which one.
        coupons: The coarse one and the fine one.
        rows: One for each quantity of each test.
        curves: Stress against strain, in compression and in tension, of either coupon.
        notes: What is to be known of how it was measured.
    """

    tissue: Tissue
    coupons: tuple[Coupon, Coupon]
    rows: list[TestRow] = field(default_factory=list[TestRow])
    curves: list[list[StressStrainCurve]] = field(default_factory=lambda: [[], []])
    notes: list[str] = field(default_factory=list[str])

    @property
    def is_good(self) -> bool:
        """Return whether nothing contradicts the evidence, or itself."""
        return all(row.is_good for row in self.rows)


def chosen(words: ResolvedProgram, name: str | None, source: Source) -> list[Tissue]:
    """Return the tissue of a name; otherwise those of bodies, or all tissues of a file.

    Args:
        words: The resolved program.
        name: Name of a tissue; None for all.
        source: The file.

    Raises:
        TissueError: There is none.
    """
    known = words.tissues
    if name is not None and key_of(arguments.text(name, "tissue")) not in known:
        hint = did_you_mean(key_of(name), known) or f"tissues: {', '.join(known)}"
        raise TissueError(f'there is no tissue "{name}"; {hint}')
    if name is not None:
        return [known[key_of(name)]]
    if words.declarations.of("body"):
        return used_tissues(words)
    found = [one for one in known.values() if one.span.source.name == source.name]
    if not found:
        raise TissueError(f'"{source.name}" does not declare a tissue')
    return found


def examine(
    request: Request,
    tissue: Tissue,
    *,
    spacing: float = SPACING,
    thickness: float | None = None,
) -> Examination:
    """Return the results of all tests of a tissue.

    Args:
        request: The text that declares it.
        tissue: The tissue.
        spacing: Length of cells, if its quantities belong to springs [m].
        thickness: Of strips of a sheet [m]; None for bars.

    Raises:
        TissueError: It has no stiffness, or none that depends on a thickness.
        CompileError: No coupon can be made of it.
    """
    bench = TestBench(request, tissue, spacing=spacing, thickness=thickness)
    if not bench.is_of_matter and bench.lacks("spring constant") and not tissue.laws:
        raise TissueError(
            f'tissue {tissue.name} cannot be tested: it has no "Young\'s modulus"'
        )
    if thickness is not None and not bench.is_of_matter:
        raise TissueError(
            f"tissue {tissue.name} cannot be tested as strips: a thickness does not affect "
            "quantities of springs"
        )
    return _Examiner(bench).all()


class _Examiner:
    """One examination, test by test."""

    def __init__(self, bench: TestBench):
        self.bench = bench
        self.found = Examination(bench.tissue, bench.coupons())
        self.tensions: list[TensionTest] = []
        self.across: list[TensionTest] = []  # as along, where there are no fibres
        self.near: float | None = None  # stress at which the coarse coupon broke [Pa]

    def all(self) -> Examination:
        """Return what all tests give, those first that others depend on."""
        self._note_the_mesh()
        self._test("tension", self._tension)
        if len(self.tensions) < 2:
            return self.found  # all others need its modulus
        if self.bench.has_fibres:
            self._test("tension across", self._tension_across)
        else:
            self.across = self.tensions
        if self.bench.thickness is None:
            self._test("compression", self._compression)
            self._test("shear", self._shear)
            self._press()
        if not self.bench.breaks_without_crack:
            self.found.notes.append(
                "no test of rupture: a coupon without a crack does not measure toughness"
            )
        elif self.bench.yields:
            self.found.notes.append(
                "no test of rupture: elements that yield bear little more than that stress"
            )
        else:
            self._test("rupture", self._rupture)
        self._motion()
        self._tell_of_what_was_left_out()
        return self.found

    # --- tests --------------------------------------------------------------------------------

    def _tension(self, number: int) -> Values:
        guess = self.tensions[0].modulus if self.tensions else self.bench.stiffness
        found = statics.tension(self.bench, self.found.coupons[number], guess)
        self.tensions.append(found)
        values = {self._along: found.modulus, "Poisson's ratio": found.ratio}
        return values if self.bench.lacks("mass") else {**values, "density": found.density}

    @property
    def _along(self) -> str:
        """Return which modulus coupons have along x."""
        return "fibre modulus" if self.bench.has_fibres else "Young's modulus"

    def _tension_across(self, number: int) -> Values:
        coupon = self.bench.coupons(along="y")[number]
        guess = self.bench.tissue.given[YOUNGS_MODULUS].value
        self.across.append(statics.tension(self.bench, coupon, guess))
        return {"Young's modulus": self.across[-1].modulus}

    def _compression(self, number: int) -> Values:
        modulus, curve = statics.compressed(self.bench, self.found.coupons[number])
        self.found.curves[number].append(curve)
        # Fibres in elements resist tension only.
        return {self._along if self.bench.of_springs else "Young's modulus": modulus}

    def _shear(self, number: int) -> Values:
        guess = self.across[number].modulus / 3.0
        return {"shear modulus": statics.shear(self.bench, self.found.coupons[number], guess)}

    def _press(self) -> None:
        if self.bench.has_fibres:
            self.found.notes.append(
                "no indentation test: its theory holds for tissue without fibres"
            )
            return
        if self.bench.is_prestressed:
            self.found.notes.append(
                "no indentation test: a block under prestress changes its shape"
            )
            return
        self._test("indentation", self._indentation, BY_LAYER)

    def _indentation(self, number: int) -> Values:
        block = indentation.blocks(self.bench)[number]
        modulus = indentation.indentation(self.bench, block, self.tensions[number])
        return {"Young's modulus": modulus}

    def _rupture(self, number: int) -> Values:
        modulus, coupon = self.tensions[number].modulus, self.found.coupons[number]
        found = statics.rupture(self.bench, coupon, modulus, self.near)
        if isfinite(found.stress) and self.bench.is_of_matter:
            self.near = found.stress
        self.found.curves[number].append(found.curve)
        return {"breaking strain": found.strain, "strength": found.stress}

    def _motion(self) -> None:
        """Test how it relaxes if it does, and otherwise how it oscillates, across fibres."""
        lacking = [what for what in ("mass", "viscosity") if self.bench.lacks(what)]
        if lacking:
            text = f"no dynamic tests: the tissue has no {' and no '.join(lacking)}"
            self.found.notes.append(text)
        elif self.bench.relaxes:
            coupons = self.bench.coupons(motion.width_to_hold(self.bench, self.across[1]), "y")
            self._test("ramp and hold", lambda number: self._held(coupons[number], number))
        else:
            coupons = self.bench.coupons(motion.width_for(self.bench, self.across[1]), "y")
            self._test("oscillation", lambda number: self._let_go(coupons[number], number))

    def _held(self, coupon: Coupon, number: int) -> Values:
        found = motion.held(self.bench, coupon, self.across[number])
        has_several = TIMES[1] in self.found.tissue.given
        names = tuple(_OTHERS) if has_several else ("relaxing share", TIMES[0])
        return dict(zip(names, (found.share, found.time), strict=True))

    def _let_go(self, coupon: Coupon, number: int) -> Values:
        tension = self.across[number]
        found = motion.oscillation(self.bench, coupon, tension)
        shear = tension.modulus / (2.0 * (1.0 + tension.ratio))
        return {"retardation time": found.time, "shear viscosity": found.time * shear}

    # --- rows ---------------------------------------------------------------------------------

    def _test(self, name: str, measure: Callable[[int], Values], share: float = SHARE) -> None:
        """Add the rows of a test on both coupons, which may be off by a share."""
        found: list[Values] = []
        why = ""
        for number in range(2):
            try:
                found.append(measure(number))
            except Unmeasured as reason:
                why = str(reason)
                found.append({})
        for quantity in found[0] | found[1] or {"": nan}:
            coarse, fine = (values.get(quantity, nan) for values in found)
            self.found.rows.append(self._row(name, quantity, coarse, fine, why, share))

    def _row(
        self, test: str, quantity: str, coarse: float, fine: float, why: str, share: float
    ) -> TestRow:
        key = key_of(quantity)
        known = tuple(
            one for one in self.found.tissue.known if key_of(one.quantity.name) == key
        )
        given = self.found.tissue.given.get(key)
        complaints = list(self._complaints(coarse, fine, known, share))
        if complaints:
            verdict = "; ".join(complaints)
        elif isfinite(fine):
            verdict = "good" if self.bench.is_of_matter else DEPENDS
        else:
            verdict = "none"
        if why and not (isfinite(coarse) and isfinite(fine)):
            verdict = f"not measured: {why}"
        value = given.value if given else None
        is_good = not complaints
        return TestRow(test, quantity, coarse, fine, value, known, verdict, is_good)

    def _complaints(
        self, coarse: float, fine: float, known: tuple[KnownQuantity, ...], share: float
    ) -> Iterator[str]:
        """Yield what a row contradicts: what is known, or one coupon the other."""
        if not (isfinite(coarse) and isfinite(fine)):
            is_needed = len(self.tensions) < 2  # by all other tests
            if known or isfinite(coarse) or isfinite(fine) or is_needed:
                yield "not measured: no spring breaks"
            return
        for one in known:
            if not agrees(fine, one, share):
                yield f'contradicts "{one.source}"'
        apart = abs(fine - coarse) / max(abs(fine), abs(coarse), 1e-300)
        if self.bench.is_of_matter and apart > share:
            yield f"the coupons differ by {100.0 * apart:.2g} %"

    def _note_the_mesh(self) -> None:
        if not self.bench.is_of_matter:
            at = show(self.bench.spacing, units.LENGTH)
            self.found.notes.append(
                "its quantities belong to springs and nodes, so all results depend on "
                f"the mesh: the spacing is {at}, on coupons of two sizes"
            )

    def _tell_of_what_was_left_out(self) -> None:
        tested = {key_of(row.quantity) for row in self.found.rows}
        for one in self.found.tissue.known:
            if key_of(one.quantity.name) not in tested:
                self.found.notes.append(f"the evidence on {one.quantity.name} was not tested")


def agrees(value: float, known: KnownQuantity, share: float = SHARE) -> bool:
    """Return whether a measurement agrees with evidence within a relative deviation.

    Args:
        value: The measurement.
        known: The evidence.
        share: Relative deviation of the measurement that is allowed.
    """
    most = share * abs(value)
    return known.low - most <= value <= known.high + most
