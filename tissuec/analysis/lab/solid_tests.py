"""Tests of solids that consist of elements."""

from math import isfinite, nan

import numpy as np
from msgspec.structs import replace

from tissuec.analysis.lab import homogeneous, indentation, motion
from tissuec.analysis.lab.bench import TestBench, Unmeasured
from tissuec.analysis.lab.examiner import OTHERS, Examiner, Listener, Values
from tissuec.analysis.lab.homogeneous import CubeResponse
from tissuec.analysis.lab.relaxation import branches_of, relaxed
from tissuec.analysis.lab.rows import SHARE, Examination, LabCurve, known_of
from tissuec.analysis.lab.spring_tests import BY_LAYER
from tissuec.analysis.lab.statics import TensionTest
from tissuec.core.names import key_of
from tissuec.model.inelastic import TIMES
from tissuec.scene.tissues.known_curves import ACROSS, COMPRESSION, EQUIBIAXIAL, SHEAR, TENSION
from tissuec.scene.tissues.quantities import TOGETHER

_CELLS = 3  # across a bar that oscillates; its decay hardly depends on the mesh
_COUPONS = "one element where strain is the same everywhere; otherwise two meshes"


class SolidExaminer(Examiner):
    """Tests of cubes of one element, and of blocks and bars on two meshes.

    Measurements on cubes are checked by the closed form of the law.

    Args:
        bench: The bench of the tissue.
        listener: Callback for each row.
    """

    beside = "the law differs"

    def __init__(self, bench: TestBench, listener: Listener):
        super().__init__(bench, _COUPONS, listener)
        self.tension: TensionTest | None = None  # across fibres, if it has any

    def all(self) -> Examination:
        """Return the results of all tests, each after those that it depends on."""
        if not self._draw():
            return self.found  # all others need its modulus
        self._load(COMPRESSION, COMPRESSION, "Young's modulus")
        self._load(SHEAR, SHEAR, "shear modulus")
        if self.bench.has_fibres:
            self._load("tension across", ACROSS, "Young's modulus")
            self.note("no test of equibiaxial tension: fibres make it uneven")
        else:
            self._load(EQUIBIAXIAL, EQUIBIAXIAL, "")
        self.beside = "the meshes differ"
        self._press()
        self._motion()
        self.note_what_was_left_out()
        return self.found

    # --- cubes --------------------------------------------------------------------------------

    def _draw(self) -> bool:
        """Stretch a cube until it breaks, if it does; return whether it could be measured."""
        tears = self._tears()
        found: list[CubeResponse] = []

        def draw() -> tuple[Values, Values]:
            found.append(homogeneous.loaded(self.bench, TENSION, tears=tears))
            one = found[0]
            measured = {self.along: one.modulus[0], "Poisson's ratio": one.ratio[0]}
            check = {self.along: one.modulus[1], "Poisson's ratio": one.ratio[1]}
            if not self.bench.lacks("mass"):
                measured["density"] = one.density
            return measured, check

        if not self.attempt("tension", draw):
            return False
        one = found[0]
        self.tension = TensionTest(one.modulus[0], one.ratio[0], one.density)
        self.keep_curve("tension", one.curve, one.why)
        if tears or self._knows_of_rupture():
            why = one.why if tears and not isfinite(one.rupture[0]) else ""
            both = zip(TOGETHER, one.rupture_by_law, one.rupture, strict=True)
            for quantity, check, measured in both:
                self.add("tearing", quantity, check, measured, why, SHARE)
        return True

    def _tears(self) -> bool:
        """Return whether a cube is stretched until it breaks; if not, note why."""
        if not self.bench.breaks_without_crack:
            self.note("no test of tearing: a cube without a crack does not measure toughness")
            return False
        if self.bench.yields:
            self.note(
                "no test of tearing: elements that yield bear little more than that stress"
            )
            return False
        return self._has_limit()

    def _has_limit(self) -> bool:
        given = self.bench.tissue.given
        return any(key in given and isfinite(given[key].value) for key in TOGETHER)

    def _knows_of_rupture(self) -> bool:
        known = {key_of(one.quantity.name) for one in self.bench.tissue.known}
        return bool(known.intersection(TOGETHER)) and not self.bench.yields

    def _load(self, name: str, mode: str, quantity: str) -> None:
        """Load a cube in a mode, and add its modulus and its curve."""
        found: list[CubeResponse] = []

        def load() -> tuple[Values, Values]:
            found.append(homogeneous.loaded(self.bench, mode))
            if not quantity:
                return {}, {}
            return {quantity: found[0].modulus[0]}, {quantity: found[0].modulus[1]}

        if self.attempt(name, load):
            self.keep_curve(name, found[0].curve, found[0].why)
            if mode == ACROSS:
                one = found[0]
                self.tension = TensionTest(one.modulus[0], one.ratio[0], one.density)

    # --- two meshes ---------------------------------------------------------------------------

    def _press(self) -> None:
        if self.bench.has_fibres:
            self.note("no indentation test: its theory holds for tissue without fibres")
            return
        coarse, fine = indentation.blocks(self.bench)

        def press() -> tuple[Values, Values]:
            assert self.tension is not None
            check, measured = (
                {"Young's modulus": indentation.indentation(self.bench, one, self.tension)}
                for one in (coarse, fine)
            )
            return measured, check

        self.attempt("indentation", press, BY_LAYER)

    def _motion(self) -> None:
        """Test relaxation if the tissue relaxes, otherwise oscillation across fibres."""
        if branches_of(self.bench):
            self._relax()
            return
        self._stay()
        lacking = [what for what in ("mass", "viscosity") if self.bench.lacks(what)]
        if lacking:
            self.note(f"no dynamic tests: the tissue has no {' and no '.join(lacking)}")
            return
        assert self.tension is not None
        tension = self.tension
        coarse, fine = self.bench.coupons(motion.width_for(self.bench, tension), "y")
        coupons = coarse, replace(fine, cells=_CELLS)

        def let_go() -> tuple[Values, Values]:
            check, measured = (motion.let_go(self.bench, one, tension) for one in coupons)
            return measured, check

        self.attempt("oscillation", let_go)

    def _stay(self) -> None:
        """Compare a tissue that does not relax with evidence on its relaxation."""
        known = known_of(self.found.tissue, "")
        if known:
            place = np.unique([place for one in known for place in one.places])
            all_left = np.ones_like(place)
            self.keep_curve("ramp and hold", LabCurve("", place, all_left, all_left, known), "")

    def _relax(self) -> None:
        names = (
            tuple(OTHERS)
            if TIMES[1] in self.bench.tissue.given
            else ("relaxing share", TIMES[0])
        )
        self.beside = "the law differs"
        try:
            found = relaxed(self.bench)
        except Unmeasured as reason:
            self.add("ramp and hold", "", nan, nan, str(reason), SHARE)
            return
        measured, check = zip(found.share, found.time, strict=True)
        self.attempt(
            "ramp and hold",
            lambda: (
                dict(zip(names, measured, strict=True)),
                dict(zip(names, check, strict=True)),
            ),
        )
        self.keep_curve("ramp and hold", found.curve, "it was not held longer")
