"""Tests under uniform strain and stress, on cubes of one element.

One element is as exact as many, because elements represent such a state exactly (the patch
test; B. M. Irons, A. Razzaque in The Mathematical Foundations of the Finite Element Method,
1972, 557). The loads are those of the closed form (``closed_form``) at the wanted strains; the
response of the element is measured and compared with the closed form.

A cube in tension or compression is an eighth of a larger one, bounded by three planes of
symmetry; a uniform stress acts on its other faces. In shear, all nodes of a cube are held or
moved. Neither has a prestress: specimens are cut out, and free of stress at rest.
"""

from collections.abc import Iterator, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.analysis.lab.bench import TICK, TestBench, TestReading, Unmeasured
from tissuec.analysis.lab.closed_form import LawCurve
from tissuec.analysis.lab.coupon import AXES, BODY, FREE
from tissuec.analysis.lab.rows import LabCurve, known_of
from tissuec.model.network import Floats
from tissuec.scene.tissues.known_curves import ACROSS, COMPRESSION, EQUIBIAXIAL, SHEAR
from tissuec.scene.tissues.quantities import SHARES

SMALL = 1e-4  # strain at which moduli are measured
POINTS = 10  # of a curve, beside those that are known
#: Largest strains of curves without evidence, of tissue that does not break.
REACH = {COMPRESSION: 0.3, SHEAR: 0.5, EQUIBIAXIAL: 0.2}
USUAL_REACH = 0.3  # of other modes
LONGEST = 3.0  # strain to which a tissue is drawn that breaks later
_NEAR = (0.99, 1.01)  # times the strain at which it breaks
_MARGIN = 0.8  # of the yield stress
_BISECTIONS = 60


class LoadLimit(NamedTuple):
    """The strain up to which a tissue can be loaded in a mode.

    Attributes:
        strain: The one at which it breaks or yields; infinite if it does neither.
        why: The event at this strain, in words.
    """

    strain: float
    why: str


class CubeResponse(Struct, frozen=True):
    """The response of a cube to the loads of a mode.

    Attributes:
        curve: Stress over strain.
        modulus: Stress over strain at a small strain [Pa], and the same by the law.
        ratio: Poisson's, at the small strain, and the same by the law; NaN in other modes.
        density: Mass over volume [kg/m³].
        rupture: Strain and stress [Pa] halfway between the last level before it and the one at
            which it breaks; NaN if it does not.
        rupture_by_law: The same by the law.
        why: The reason why the curve ends.
    """

    curve: LabCurve
    modulus: tuple[float, float]
    ratio: tuple[float, float]
    density: float
    rupture: tuple[float, float]
    rupture_by_law: tuple[float, float]
    why: str


def limits_in(bench: TestBench, law: LawCurve, mode: str) -> LoadLimit:
    """Return the strain up to which a tissue can be loaded in a mode, by its law.

    Args:
        law: Its stress by strain and mode.
        mode: Loading mode.
    """
    given = {key: one.value for key, one in bench.tissue.given.items()}
    found = [LoadLimit(np.inf, "it was not loaded further")]
    longest, most = given.get("breaking strain", np.inf), given.get("strength", np.inf)
    if mode != COMPRESSION and isfinite(longest):
        # A shear γ stretches by λ where γ = λ - 1/λ.
        stretch = 1.0 + longest
        amount = stretch - 1.0 / stretch if mode == SHEAR else longest
        found.append(LoadLimit(amount, "it tears"))
    if mode not in (COMPRESSION, SHEAR) and isfinite(most):
        found.append(LoadLimit(_strain_at(law, mode, most), "it tears"))
    if bench.yields:
        flows = _MARGIN * given["yield stress"]
        flows /= np.sqrt(3.0) if mode == SHEAR else 1.0
        found.append(LoadLimit(_strain_at(law, mode, flows), "it yields"))
    return min(found)


def _strain_at(law: LawCurve, mode: str, stress: float) -> float:
    """Return the strain at a stress [Pa], by halving; infinite where it is not reached."""
    low, high = 0.0, 0.9 if mode == COMPRESSION else LONGEST
    try:
        if law.stress(mode, np.linspace(0.0, high, 13).tolist()).max() < stress:
            return np.inf
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            is_above = law.stress(mode, np.linspace(0.0, middle, 5).tolist())[-1] >= stress
            low, high = (low, middle) if is_above else (middle, high)
            if high - low < 1e-7 * high:
                break
    except ArithmeticError:
        return np.inf
    return high


def loaded(bench: TestBench, mode: str, *, tears: bool = False) -> CubeResponse:
    """Return the response of a cube in a mode.

    Args:
        tears: Whether it is loaded until it breaks.

    Raises:
        Unmeasured: It does not resist, or the run stopped.
    """
    try:
        return _loaded(bench, mode, LawCurve.of(bench.tissue), tears=tears)
    except ArithmeticError as error:  # of the law
        raise Unmeasured(str(error)) from error


def _loaded(bench: TestBench, mode: str, law: LawCurve, *, tears: bool) -> CubeResponse:
    limits = limits_in(bench, law, mode)
    strains = _strains(bench, mode, limits, tears=tears)
    stresses = law.stress(mode, strains)
    rising = int(np.argmin(np.append(np.diff(stresses), -1.0) > 0.0)) + 1
    why = limits.why
    if rising < len(strains):
        why = f"its stress falls beyond a strain of {100.0 * strains[rising - 1]:.3g} %"
    strains, stresses = strains[:rising], stresses[:rising]
    if mode == SHEAR:
        reading, strain, measured = _sheared(bench, strains)
        across = np.full(len(strain), np.nan)
    else:
        reading, strain, across = _drawn(bench, mode, stresses, tears=tears)
        measured = stresses[: len(strain)]
    broken = np.zeros(len(strain), dtype=bool)
    if tears:
        broken = reading.logs[f"ruptured of {BODY}"][: len(strain), 0] > 0.0
    intact = int(np.argmax(broken)) if broken.any() else len(strain)
    if intact == 0 or not strain[0] > 0.0:
        raise Unmeasured(reading.stopped or "it has no resistance")
    ends = np.nan, np.nan
    if broken.any() and intact > 1:
        ends = (
            0.5 * float(strain[intact - 1] + strain[intact]),
            0.5 * float(measured[intact - 1] + measured[intact]),
        )
    by_law = np.nan, np.nan
    if tears and limits.strain <= LONGEST:
        by_law = (
            limits.strain,
            float(law.stress(mode, [0.5 * limits.strain, limits.strain])[-1]),
        )
    known = known_of(bench.tissue, mode)
    check = law.stress(mode, strain[:intact].tolist())
    curve = LabCurve(mode, strain[:intact], measured[:intact], check, known)
    network = reading.network
    return CubeResponse(
        curve,
        (float(measured[0] / strain[0]), float(check[0] / strain[0])),
        (float(-across[0] / strain[0]), law.ratio(mode) if mode != SHEAR else np.nan),
        float(network.mass[: network.body_nodes].sum()) / SIDE**3,
        ends,
        by_law,
        why,
    )


def _strains(bench: TestBench, mode: str, limits: LoadLimit, *, tears: bool) -> list[float]:
    """Return the strains at which a cube is measured, ascending."""
    known = [place for one in known_of(bench.tissue, mode) for place in one.places]
    end = max(known, default=REACH.get(mode, USUAL_REACH))
    is_torn = tears and limits.why == "it tears" and limits.strain <= LONGEST
    if is_torn:
        end = limits.strain
    end = min(end, limits.strain * (1.0 if is_torn else _NEAR[0]), LONGEST)
    if mode == COMPRESSION:
        end = min(end, 0.95)
    every = {SMALL, *np.linspace(0.0, end, POINTS + 1)[1:].tolist()}
    every |= {place for place in known if place <= end}
    found = sorted(every)
    if is_torn:
        found = [one for one in found if one < _NEAR[0] * end] + [part * end for part in _NEAR]
    return found


def _drawn(
    bench: TestBench, mode: str, stresses: Floats, *, tears: bool
) -> tuple[TestReading, Floats, Floats]:
    """Return the log of a cube, its strains along and across, shape (level,)."""
    axes = axes_of(mode)
    sign = -1.0 if mode == COMPRESSION else 1.0
    script = list(loads(axes, (sign * stresses).tolist()))
    if tears:  # broken tissue need not come to rest
        script.append(f"when ruptured({BODY}): fix {BODY}")
    faces = [f"{axis}1" for axis in AXES]
    watched = [f"position of lab {face}" for face in faces]
    watched += [f"ruptured of {BODY}"] if tears else []
    reading = bench.run(
        Cube(bench.has_fibres, bench.is_prestressed),
        script,
        faces,
        watched,
        f"duration = {len(stresses) - 0.5} {TICK}; integrator is dop853",
        interval=f"1 {TICK}",
        environment=PLANES,
        rupture=tears,
    )
    sides = [
        reading.logs[f"position of lab {face}"][:, n] / SIDE - 1.0
        for n, face in enumerate(faces)
    ]
    other = 2 if axes == (0, 1) else 1 - axes[0]
    return reading, sign * sides[axes[0]], sign * sides[other]


def _sheared(bench: TestBench, amounts: list[float]) -> tuple[TestReading, Floats, Floats]:
    """Return the log of a cube, amounts of shear, and shear stresses [Pa], shape (level,)."""
    relaxing = tuple(share for share in SHARES if share in bench.tissue.given)
    reading = bench.run(
        Cube(bench.has_fibres, bench.is_prestressed, is_inviscid=True, relaxing=relaxing),
        list(shears(amounts)),
        ("y0", "y1"),
        ["force of lab y1", "position of lab y1"],
        f"duration = {2 * len(amounts) - 0.5} {TICK}; integrator is dop853",
        interval=f"1 {TICK}",
    )
    place = reading.logs["position of lab y1"][1::2, 0]
    force = reading.logs["force of lab y1"][1::2, 0]
    return reading, place / SIDE - 0.5, force / SIDE**2


SIDE = 0.01  # [m]
PLANES = " ".join(
    f"symmetric about plane through (0, 0, 0) m facing ({axis});"
    for axis in ("1, 0, 0", "0, 1, 0", "0, 0, 1")
)


class Cube(Struct, frozen=True):
    """A cube of one element.

    Attributes:
        has_fibres: Whether fibres run along x.
        is_prestressed: Whether its tissue has a prestress.
        is_inviscid: Whether its viscosity is left out.
        relaxing: Names of shares of branches to leave out, for the response after a long time.
        times: Names and values [s] of relaxation times that it has instead of its own.
    """

    has_fibres: bool
    is_prestressed: bool
    is_inviscid: bool = False
    relaxing: tuple[str, ...] = ()
    times: tuple[tuple[str, float], ...] = ()

    def body(self, tissue: str, *, tabs: str = "", rupture: bool = False) -> Iterator[str]:
        """Yield the cube; it has no tabs."""
        free = ["prestress = 0"] if self.is_prestressed else []
        free += ["retardation time = 0 s"] if self.is_inviscid else []
        free += [f"{share} = 0" for share in self.relaxing]
        free += [f"{name} = {value:.15g} s" for name, value in self.times]
        yield f"tissue {FREE} like {tissue} {{ {'; '.join(free)} }}"
        yield f"body {BODY} {{"
        yield f"  mesh is lattice {{ cell = {SIDE} m; box from (0, 0, 0) m to ({SIDE}, {SIDE}, "
        yield f"  {SIDE}) m }}; tissue is {FREE}"
        if self.has_fibres:
            yield "  fibres = (1, 0, 0)"
        if rupture:
            yield "  rupture is allowed"
        yield "}"

    def faces(self, *names: str) -> Iterator[str]:
        """Yield sets for the nodes of faces: "x1" at the largest x, "y0" at the least y."""
        for name in names:
            sign = "<" if name[1] == "0" else ">"
            yield f"set lab {name} = nodes of {BODY} where {name[0]} {sign} {0.5 * SIDE} m"


def axes_of(mode: str) -> tuple[int, ...]:
    """Return the numbers of the axes along which a stress acts in a mode."""
    return {EQUIBIAXIAL: (0, 1), ACROSS: (1,)}.get(mode, (0,))


def loads(axes: Sequence[int], stresses: Sequence[float]) -> Iterator[str]:
    """Yield orders that apply one stress [Pa] after the other to a cube, one at each tick."""
    before = 0.0
    for number, stress in enumerate(stresses):
        force = (stress - before) * SIDE**2
        before = stress
        for axis in axes:
            way = ", ".join(f"{force if one == axis else 0.0:.15g}" for one in range(3))
            yield f"at {number} {TICK}: push lab {AXES[axis]}1 with ({way}) N"
        yield f"at {number} {TICK}: settle"


def shears(amounts: Sequence[float]) -> Iterator[str]:
    """Yield orders that shear a cube along x by one amount after the other, at odd ticks."""
    yield "at 0 s: fix lab y0"
    before = 0.0
    for number, amount in enumerate(amounts):
        by, before = (amount - before) * SIDE, amount
        yield (
            f"from {2 * number} {TICK} to {2 * number + 1} {TICK}: "
            f"move lab y1 by ({by:.15g}, 0, 0) m using constant speed"
        )
