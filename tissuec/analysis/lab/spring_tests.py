"""Tests of nets of springs: strips of sheets, and tissues given for each spring."""

from collections.abc import Callable
from math import isfinite, nan

import numpy as np

from tissuec.analysis.lab import indentation, motion, statics
from tissuec.analysis.lab.bench import TestBench, Unmeasured
from tissuec.analysis.lab.examiner import OTHERS, Examiner, Listener, Values
from tissuec.analysis.lab.motion import width_for, width_to_hold
from tissuec.analysis.lab.rows import (
    SHARE,
    Examination,
    LabCurve,
    StressStrainCurve,
    known_of,
)
from tissuec.analysis.lab.statics import TensionTest
from tissuec.model.inelastic import TIMES
from tissuec.scene.tissues.known_curves import COMPRESSION, TENSION
from tissuec.scene.tissues.quantities import YOUNGS_MODULUS

#: Allowed relative deviation of indentation: a block with free sides is not a layer.
BY_LAYER = 0.15


class SpringExaminer(Examiner):
    """Tests of two coupons: the second is measured, and the first is the check.

    Args:
        bench: The bench of the tissue.
        listener: Callback for each row.
    """

    def __init__(self, bench: TestBench, listener: Listener):
        self.coupons = bench.coupons()
        shown = " and ".join(coupon.shown() for coupon in self.coupons)
        super().__init__(bench, f"coupons of {shown} cells", listener)
        self.tensions: list[TensionTest] = []
        self.across: list[TensionTest] = []  # as along, where there are no fibres
        self.near: float | None = None  # stress at which the coarse coupon broke [Pa]
        self.drawn: dict[str, list[StressStrainCurve]] = {}

    def all(self) -> Examination:
        """Return the results of all tests, each after those that it depends on."""
        self.note_the_mesh()
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
            self.note("no test of rupture: a coupon without a crack does not measure toughness")
        else:
            self._test("rupture", self._rupture)
        self._keep_curves()
        self._motion()
        self.note_what_was_left_out()
        return self.found

    # --- tests --------------------------------------------------------------------------------

    def _tension(self, number: int) -> Values:
        guess = self.tensions[0].modulus if self.tensions else self.bench.stiffness
        found = statics.tension(self.bench, self.coupons[number], guess)
        self.tensions.append(found)
        values = {self.along: found.modulus, "Poisson's ratio": found.ratio}
        return values if self.bench.lacks("mass") else {**values, "density": found.density}

    def _tension_across(self, number: int) -> Values:
        coupon = self.bench.coupons(along="y")[number]
        guess = self.bench.tissue.given[YOUNGS_MODULUS].value
        self.across.append(statics.tension(self.bench, coupon, guess))
        return {"Young's modulus": self.across[-1].modulus}

    def _compression(self, number: int) -> Values:
        modulus, curve = statics.compressed(self.bench, self.coupons[number])
        mirrored = StressStrainCurve(-curve.strain[::-1], -curve.stress[::-1])
        self.drawn.setdefault(COMPRESSION, []).append(mirrored)
        return {self.along: modulus}

    def _shear(self, number: int) -> Values:
        guess = self.across[number].modulus / 3.0
        return {"shear modulus": statics.shear(self.bench, self.coupons[number], guess)}

    def _press(self) -> None:
        if self.bench.has_fibres:
            self.note("no indentation test: its theory holds for tissue without fibres")
        elif self.bench.is_prestressed:
            self.note("no indentation test: a block under prestress changes its shape")
        else:
            self._test("indentation", self._indentation, BY_LAYER)

    def _indentation(self, number: int) -> Values:
        block = indentation.blocks(self.bench)[number]
        modulus = indentation.indentation(self.bench, block, self.tensions[number])
        return {"Young's modulus": modulus}

    def _rupture(self, number: int) -> Values:
        modulus, coupon = self.tensions[number].modulus, self.coupons[number]
        found = statics.rupture(self.bench, coupon, modulus, self.near)
        if isfinite(found.stress) and self.bench.is_of_matter:
            self.near = found.stress
        self.drawn.setdefault(TENSION, []).append(found.curve)
        return {"breaking strain": found.strain, "strength": found.stress}

    def _motion(self) -> None:
        """Test relaxation if the tissue relaxes, otherwise oscillation across fibres."""
        lacking = [what for what in ("mass", "viscosity") if self.bench.lacks(what)]
        if lacking:
            self.note(f"no dynamic tests: the tissue has no {' and no '.join(lacking)}")
        elif self.bench.relaxes:
            coupons = self.bench.coupons(width_to_hold(self.bench, self.across[1]), "y")

            def hold(number: int) -> Values:
                found = motion.held(self.bench, coupons[number], self.across[number])
                has_several = TIMES[1] in self.found.tissue.given
                names = tuple(OTHERS) if has_several else ("relaxing share", TIMES[0])
                return dict(zip(names, (found.share, found.time), strict=True))

            self._test("ramp and hold", hold)
        else:
            coupons = self.bench.coupons(width_for(self.bench, self.across[1]), "y")
            self._test(
                "oscillation",
                lambda n: motion.let_go(self.bench, coupons[n], self.across[n]),
            )

    # --- rows ---------------------------------------------------------------------------------

    def _test(self, name: str, measure: Callable[[int], Values], share: float = SHARE) -> None:
        """Add the rows of a test on both coupons, with an allowed relative deviation."""
        found: list[Values] = []
        why = ""
        for number in range(2):
            try:
                found.append(measure(number))
            except Unmeasured as reason:
                why = str(reason)
                found.append({})
        for quantity in found[0] | found[1] or {"": nan}:
            check, measured = (values.get(quantity, nan) for values in found)
            both = isfinite(check) and isfinite(measured)
            self.add(name, quantity, check, measured, "" if both else why, share)

    def _keep_curves(self) -> None:
        """Keep the curves of the second coupon, with those of the first as checks."""
        for mode, curves in self.drawn.items():
            place, value = curves[-1]
            begun = place > 0.0
            place, value = place[begun], value[begun]
            check = np.full_like(place, nan)
            if len(curves) > 1 and len(curves[0].strain):
                check = np.interp(place, *curves[0], right=nan)
            curve = LabCurve(mode, place, value, check, known_of(self.found.tissue, mode))
            self.keep_curve("rupture" if mode == TENSION else mode, curve, "it tears before")
