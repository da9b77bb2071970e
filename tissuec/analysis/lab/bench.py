"""The test bench for coupons of one tissue: it writes, runs and reads scenes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol

import numpy as np
from msgspec import Struct

from tissuec.analysis.lab.coupon import BODY, Coupon
from tissuec.core.signals import interruption
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.lang.words import written_name
from tissuec.model.inelastic import LIMIT, TIMES
from tissuec.model.network import Floats, Network
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.model import Tissue
from tissuec.scene.program.library import belongs_to_scenes
from tissuec.scene.request import Request
from tissuec.scene.tissues.quantities import (
    FIBRE_MODULUS,
    OF_MATTER,
    TOGETHER,
    TOUGHNESS,
    YOUNGS_MODULUS,
)

TISSUE, TABS = "lab tissue", "lab tab tissue"
#: What a body needs besides springs, and defaults where the tissue does not give it.
_NEEDED = {
    "mass": ("density = 1000 kg/m^3", "mass = 1 mg"),
    "viscosity": ("retardation time = 0 s", "viscosity = 0 N*s/m"),
}
#: Between two states of rest; so short that nothing moves in it.
TICK = "ns"


class Unmeasured(Exception):
    """A test gives no number; says why."""


class TestReading(Struct, frozen=True):
    """The log of a test.

    Attributes:
        logs: By name, shape (moment, column).
        time: Of the moments of all logs [s], shape (moment,).
        network: What the coupon was.
        stopped: Why the run stopped before the end; empty if it did not.
    """

    logs: Mapping[str, Floats]
    time: Floats
    network: Network
    stopped: str


class Specimen(Protocol):
    """A specimen, as text."""

    def body(self, tissue: str, *, tabs: str = "", rupture: bool = False) -> Iterator[str]:
        """Yield the text of the body and of what belongs to it.

        Args:
            tissue: Name of its tissue.
            tabs: Name of the tissue of its tabs, empty without tabs.
        """
        ...

    def faces(self, *names: str) -> Iterator[str]:
        """Yield sets for faces."""
        ...


class TestBench:
    """Tests coupons of one tissue.

    Args:
        request: The text that declares the tissue; what else it holds of a scene is left out.
        spacing: Length of cells where quantities belong to springs [m].
        thickness: Of strips [m]; None for bars.
    """

    def __init__(
        self,
        request: Request,
        tissue: Tissue,
        *,
        spacing: float,
        thickness: float | None = None,
    ):
        self.request, self.tissue = request, tissue
        self.spacing, self.thickness = spacing, thickness
        self._text = _without_scene(request.source)

    @property
    def is_of_matter(self) -> bool:
        """Return whether the tissue means the same on every mesh."""
        return YOUNGS_MODULUS in self.tissue.given

    @property
    def of_springs(self) -> bool:
        """Return whether specimens are nets of springs."""
        return not self.is_of_matter

    @property
    def yields(self) -> bool:
        """Return whether specimens are elements that yield."""
        stress = self.tissue.given.get(OF_MATTER[LIMIT][0])
        is_solid = not self.of_springs and self.thickness is None
        return is_solid and stress is not None and isfinite(stress.value)

    @property
    def breaks_without_crack(self) -> bool:
        """Return whether it has limits other than a toughness."""
        given = self.tissue.given
        return TOUGHNESS not in given or any(key in given for key in TOGETHER)

    @property
    def stiffness(self) -> float:
        """Return about which modulus the tissue has along x, to choose loads by [Pa]."""
        given = {key: one.value for key, one in self.tissue.given.items()}
        of_springs = given.get("spring constant", 1.0) / self.spacing
        matter = given.get(FIBRE_MODULUS) or given.get(YOUNGS_MODULUS)
        return matter or of_springs or 1.0

    @property
    def is_prestressed(self) -> bool:
        """Return whether the tissue is under tension as drawn."""
        prestress = self.tissue.given.get("prestress")
        return prestress is not None and prestress.value != 0.0

    @property
    def relaxes(self) -> bool:
        """Return whether springs have branches that relax."""
        return any(key in self.tissue.given for key in TIMES)

    def lacks(self, what: str) -> bool:
        """Return whether the tissue does not say its mass, or viscosity, in any way."""
        return not any(key in self.tissue.given for key in (what, *OF_MATTER[what]))

    @property
    def has_fibres(self) -> bool:
        """Return whether the tissue is stiffer in one direction."""
        return FIBRE_MODULUS in self.tissue.given

    def coupons(self, width: float = 0.02, along: str = "x") -> tuple[Coupon, Coupon]:
        """Return a coarse coupon and a fine one.

        Where quantities belong to springs, the finer one is larger.

        Args:
            width: Of coupons of matter [m].
            along: How fibres run in them, if the tissue has any.
        """
        sizes = (width, width) if self.is_of_matter else (2 * self.spacing, 4 * self.spacing)
        coarse, fine = (
            Coupon(
                cells,
                size,
                self.thickness,
                along if self.has_fibres else "",
                self.of_springs,
                self.is_prestressed,
            )
            for cells, size in zip((2, 4), sizes, strict=True)
        )
        return coarse, fine

    # --- running ------------------------------------------------------------------------------

    def rest(
        self,
        coupon: Coupon,
        levels: Sequence[Iterable[str]],
        faces: Sequence[str],
        watched: Sequence[str],
        *,
        rupture: bool = False,
    ) -> TestReading:
        """Return the log of states of equilibrium, one after the other.

        Args:
            levels: Orders before each of them.
        """
        script = [
            f"at {number} {TICK}: {order}"
            for number, orders in enumerate(levels)
            for order in (*orders, "settle")
        ]
        if rupture:  # what is broken need not find any rest
            script.append(f"when ruptured({BODY}): fix {BODY}")
        return self.still(coupon, script, faces, watched, len(levels) - 0.5, rupture=rupture)

    def still(
        self,
        coupon: Coupon,
        script: Iterable[str],
        faces: Sequence[str],
        watched: Sequence[str],
        ticks: float,
        *,
        rupture: bool = False,
    ) -> TestReading:
        """Return the log at each of several ticks, between which nothing moves by itself.

        Args:
            ticks: Number of ticks.
        """
        simulation = f"duration = {ticks} {TICK}; integrator is dop853"
        return self.run(
            coupon, script, faces, watched, simulation, interval=f"1 {TICK}", rupture=rupture
        )

    def run(
        self,
        specimen: Specimen,
        script: Iterable[str],
        faces: Sequence[str],
        watched: Sequence[str],
        simulation: str,
        *,
        interval: str,
        more: Iterable[str] = (),
        environment: str = "",
        rupture: bool = False,
    ) -> TestReading:
        """Return the log of a test.

        Args:
            specimen: What is tested.
            watched: What is logged, each ``interval``.
            simulation: Entries of the ``simulate`` block.
            interval: Time between rows of the log, with its unit.
            more: Further sets.
            environment: Entries of the ``environment`` block; there is no gravity.
        """
        lines = [
            *self._tissues(),
            *specimen.body(TISSUE, tabs=TABS if rupture else "", rupture=rupture),
            *specimen.faces(*faces),
            *more,
            f"environment {{ gravity = (0, 0, 0) m/s^2; {environment} }}",
            "script {", *script, "}",
            f"simulate {{ {simulation} }}",
            "output {", *(f"{name} every {interval}" for name in watched), "}",
        ]  # fmt: skip
        source = self.request.source
        text = f"{self._text}\n" + "\n".join(lines) + "\n"
        request = replace(self.request, source=replace(source, text=text), strict=False)
        compiled, _ = compile_request(request)
        with TemporaryDirectory(prefix="tissuec-lab-") as folder:
            path = Path(folder) / "coupon.vtkhdf"
            finished = simulate(compiled, path, request=request, companion="off")
            with Trajectory(finished.path) as result:
                logs = {name: result.logs[name] for name in watched}
                values = {name: np.array(log.value) for name, log in logs.items()}
                time = np.array(next(iter(logs.values())).time)
        outcome = finished.outcome
        if outcome.kind == "interrupted":
            raise interruption(outcome.signal)
        stopped = "" if outcome.kind == "done" else outcome.message
        return TestReading(values, time, compiled.network, stopped)

    def _tissues(self) -> Iterator[str]:
        """Yield the materials of coupons and their tabs."""
        standing_in = [
            texts[not self.is_of_matter] for what, texts in _NEEDED.items() if self.lacks(what)
        ]
        name = written_name(self.tissue.name)
        yield f"tissue {TISSUE} like {name} {{ {'; '.join(standing_in)} }}"
        unbreakable = "breaking force is none; crushing force is none"
        yield f"tissue {TABS} like {TISSUE} {{ {unbreakable} }}"


def _without_scene(source: Source) -> str:
    """Return a text with blanks in place of what belongs to its scene, and not to its words."""
    text = source.text
    for item in parse(source).items:
        if belongs_to_scenes(item) or (
            isinstance(item, s.Block) and item.name.key.split(" ")[0] == "learn"
        ):
            start, end = item.span.start, item.span.end
            blank = "".join(sign if sign == "\n" else " " for sign in text[start:end])
            text = text[:start] + blank + text[end:]
    return text
