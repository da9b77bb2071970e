"""Properties of bodies as matter: stiffness, mass, waves, frequencies and strength.

Everything is found from the net itself, whether its tissue is given in pascals or for each
spring and node. Elastic constants are those of the body as it is drawn (``matter.elasticity``),
prestress aside; frequencies those about its state at 0 s, after the events of that time. Speeds
of waves are those of an elastic medium (L. D. Landau, E. M. Lifshitz, Theory of Elasticity,
1970, § 22).
"""

from collections.abc import Callable, Iterator
from functools import cache, partial
from math import inf, pi, sqrt
from typing import Literal, TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.analysis.element_constants import WallNodes, constants_of_elements
from tissuec.analysis.net_constants import (
    acting_springs,
    constants_of_solid,
    steepness_as_drawn,
)
from tissuec.analysis.vibration.modes import Modes, modes_of, out_of_balance
from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core import arguments
from tissuec.core.errors import SimulationError, TissueError, counted
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.units import MASS, show
from tissuec.matter.breaking import breaking_strains
from tissuec.matter.elasticity import Elasticity, Unit, of_wall, wall_springs
from tissuec.mechanics.state import State
from tissuec.meshes.stiffness_sharing import node_areas
from tissuec.model.blocks import NetSize
from tissuec.model.network import BodyPart, Indices

Kind: TypeAlias = Literal["solid", "wall", "thread", "bars", "points"]
LARGEST = 300_000  # springs of a body whose elastic constants are computed: some seconds
LARGEST_TO_VIBRATE = 5_000  # free nodes of a body whose frequencies are computed: likewise
FREQUENCIES = 3
_ALIKE = 1e-9  # of bars: rounding
_NOTICED = 0.1  # of the lowest frequency: less is not worth a note
_ABOUT = 0.1  # of breaking strains and moduli that make one stress


class BreakingStrength(Struct, frozen=True):
    """Strength of the springs that may rupture.

    Attributes:
        stretch: Length at which they break over their rest length: the least, the median and
            the largest of the body.
        stress: That of a body drawn along one direction, when they break: Young's modulus times
            strain [unit of the elasticity]. None if springs or directions differ by more than
            a tenth, or laws are not linear.
    """

    stretch: tuple[float, float, float]
    stress: float | None


class Vibration(Struct, frozen=True):
    """A natural motion of a body about its state at 0 s; joined bodies stay in place.

    Attributes:
        frequency: Without damping [Hz].
        damping_ratio: 1 is critical.
    """

    frequency: float
    damping_ratio: float

    @property
    def decay_time(self) -> float:
        """Return the time in which it decays to 1/e [s]; infinite without damping."""
        omega, ratio = 2.0 * pi * self.frequency, self.damping_ratio
        if ratio <= 1.0:
            return 1.0 / (ratio * omega) if ratio > 0.0 else inf
        return (ratio + sqrt(ratio * ratio - 1.0)) / omega


class RegionProperties(Struct, frozen=True):
    """How large a region of elements is.

    Attributes:
        size: Volume [m³], or area of a wall [m²], of the elements that belong to it.
        written: That in which its condition holds, within the body.
    """

    name: str
    size: float
    written: float


class BodyProperties(Struct, frozen=True):
    """Properties of a body, found from its net; None where one does not apply.

    Attributes:
        kind: "solid" with a volume; "wall": a surface; "thread"; "bars": a net typed in as
            tables; "points" without springs.
        tissues: What it is made of.
        nodes, springs, elements: Their numbers.
        mass: [kg].
        volume: Of a solid [m³]; of a wall with a thickness, area times that; likewise with the
            section of a thread or of bars.
        area: Of a wall [m²].
        length: Of a thread, or of all bars together [m].
        elasticity: None where it could not be found.
        retardation_time: Median of viscosity over spring constant [s].
        breaking: None where rupture is not allowed.
        vibrations: The lowest ones that something resists.
        notes: What is left out, and why, as sentences.
        element_quality: The worst and the mean quality of tetrahedra that it is made of, of 1
            if they are regular.
        regions: Those of a body that consists of elements.
    """

    name: str
    kind: Kind
    tissues: tuple[str, ...]
    nodes: int
    springs: int
    mass: float
    volume: float | None = None
    area: float | None = None
    length: float | None = None
    elasticity: Elasticity | None = None
    retardation_time: float | None = None
    breaking: BreakingStrength | None = None
    vibrations: tuple[Vibration, ...] = ()
    notes: tuple[str, ...] = ()
    elements: int = 0
    element_quality: tuple[float, float] | None = None
    regions: tuple[RegionProperties, ...] = ()

    def __repr__(self) -> str:
        made = f" of {', '.join(self.tissues)}" if self.tissues else ""
        return f'<{self.kind} "{self.name}"{made}: {self.net}, {show(self.mass, MASS)}>'

    @property
    def net(self) -> str:
        """Return the numbers of nodes, and of elements or springs."""
        return str(NetSize(self.nodes, self.springs, self.elements))

    @property
    def density(self) -> float | None:
        """Return mass over volume [kg/m³]."""
        return self.mass / self.volume if self.volume else None

    @property
    def wave_speeds(self) -> tuple[float, ...]:
        """Return √(E/ρ) for each direction of the elasticity [m/s]; none of bars.

        This is the speed of waves that stretch a bar and are longer than it is thick.
        """
        if self.elasticity is None:
            return ()
        return tuple(v for v in map(self._speed, self.elasticity.young) if v is not None)

    @property
    def shear_wave_speed(self) -> float | None:
        """Return √(G/ρ) [m/s]."""
        if self.elasticity is None or not self.elasticity.shear:
            return None
        return self._speed(sum(self.elasticity.shear) / len(self.elasticity.shear))

    def _speed(self, modulus: float) -> float | None:
        """Return √(modulus / density), the density being one in the unit of the modulus."""
        assert self.elasticity is not None
        if self.kind == "bars":  # masses of nodes need not be those of bars
            return None
        sizes = {"Pa": self.volume, "N/m": self.area, "N": self.length}
        size = sizes[self.elasticity.unit]
        return sqrt(modulus * size / self.mass) if size else None


def properties_of(
    compiled: Compiled, *, body: str | None = None, frequencies: int = FREQUENCIES
) -> tuple[BodyProperties, ...]:
    """Return the properties of the bodies of a scene.

    Args:
        compiled: The scene.
        body: The only body of interest; all if None.
        frequencies: Number of frequencies of each.

    Raises:
        TissueError: There is no such body.
    """
    parts = {key_of(part.name): part for part in compiled.network.bodies}
    if body is not None:
        if key_of(arguments.text(body, "body")) not in parts:
            names = [part.name for part in compiled.network.bodies]
            hint = alternatives(body, names, what="bodies")
            raise TissueError(f'there is no body "{body}"; {hint}')
        parts = {key_of(body): parts[key_of(body)]}
    drawn, equilibrium = state_at_start(compiled), cache(partial(_equilibrium, compiled))
    rest: State | str
    try:
        rest = state_at_start(compiled, settles=True)
        rest.place_held()
    except SimulationError as error:
        rest = str(error)
    bodies = compiled.groups.bodies
    return tuple(
        _Examined(part, bodies[key].drawing, drawn, equilibrium).properties(rest, frequencies)
        for key, part in parts.items()
    )


def _equilibrium(compiled: Compiled) -> State | None:
    """Return the state at 0 s after everything has settled; None if that is not found."""
    state = state_at_start(compiled)
    if len(state.position) > LARGEST_TO_VIBRATE:
        return None
    from tissuec.mechanics.settling import Unsettled, settle  # SciPy: only where it is needed

    state.place_held()
    try:
        settle(state, np.ones(len(state.position), dtype=bool))
    except Unsettled:
        return None
    return state


class _Examined:
    """One body.

    Args:
        state: As it is drawn, after the events at 0 s.
        equilibrium: Finds the state after everything has settled.
    """

    def __init__(
        self,
        part: BodyPart,
        drawing: Drawing,
        state: State,
        equilibrium: Callable[[], State | None],
    ):
        self.part, self.drawing, self.state = part, drawing, state
        self.equilibrium = equilibrium
        self.mesh, self.notes = drawing.mesh, list[str]()
        self.own, self.behaviour = acting_springs(part, drawing, state)
        self.ends, self.length = self.mesh.ends[self.own], drawing.length[self.own]
        self.springs = part.springs.start + self.own
        self.constant = steepness_as_drawn(self.behaviour, self.length)
        self.kind: Kind = self._kind()

    def _kind(self) -> Kind:
        volume = self.mesh.volume
        if not len(self.own) and not self.part.is_made_of_elements:
            return "points"
        if self.drawing.thread is not None:
            return "thread"
        if volume is not None and np.all(volume > 0.0):
            return "solid"
        return "wall" if len(self.mesh.skin) else "bars"

    def properties(self, rest: State | str, frequencies: int) -> BodyProperties:
        """Return all there is to say.

        Args:
            rest: After what settles at 0 s, or why that could not be found.
        """
        part = self.part
        volume, area, length = self._sizes()
        elasticity = self._elasticity()
        return BodyProperties(
            name=part.name,
            kind=self.kind,
            tissues=tuple(self._tissues()),
            nodes=part.size.nodes,
            springs=part.springs.stop - part.springs.start,
            mass=float(self.state.mass[part.nodes].sum()),
            volume=volume,
            area=area,
            length=length,
            elasticity=elasticity,
            retardation_time=self._retardation_time(),
            breaking=self._breaking(elasticity),
            vibrations=tuple(self._vibrations(rest, frequencies)),
            notes=tuple(self.notes),
            elements=part.element_count,
            element_quality=self._quality(),
            regions=tuple(self._regions()),
        )

    def _regions(self) -> Iterator[RegionProperties]:
        from tissuec.compiler.elements.region_sizes import region_sizes  # where there are any

        for one in region_sizes(self.drawing) if self.drawing.body.regions else ():
            yield RegionProperties(one.name, one.size, one.written)

    def _quality(self) -> tuple[float, float] | None:
        """Return the worst and the mean quality of tetrahedra that are elements."""
        from tissuec.meshes.slivers import worst_and_mean

        for one in self.mesh.elements:
            if one.shape == "tetrahedron":
                return worst_and_mean(self.mesh.position, one.nodes[:, :4])
        return None

    def _tissues(self) -> Iterator[str]:
        body = self.drawing.body
        tissues = [body.tissue, *(region.tissue or body.tissue for region in body.regions)]
        used = (tissues[int(number)] for number in np.unique(self.drawing.part).tolist())
        own = (part.tissue for part in body.spring_parts)
        yield from dict.fromkeys(one.name for one in (*used, *own) if one is not None)

    def _sizes(self) -> tuple[float | None, float | None, float | None]:
        """Return volume [m³], area [m²] and length [m], as far as there are any."""
        across = self._across()
        match self.kind:
            case "solid":
                assert self.mesh.volume is not None
                return float(self.mesh.volume.sum()), None, None
            case "wall":
                area = float(
                    node_areas(self.mesh.position, self.mesh.skin.astype(np.int64)).sum()
                )
                return across and across * area, area, None
            case "thread" | "bars":
                length = float(self.drawing.length[self._bars()].sum())
                return across and across * length, None, length
            case "points":
                return None, None, None

    def _across(self) -> float | None:
        """Return the thickness of a wall [m], or the section of bars [m²]."""
        body, thread = self.drawing.body, self.drawing.thread
        return body.thickness or body.section or (thread and pi * thread.radius**2)

    def _bars(self) -> Indices:
        """Return the springs that are no knots, numbered within the body."""
        thread = self.drawing.thread
        count = len(self.drawing.length)
        return np.arange(count)[slice(None) if thread is None else thread.pieces]

    # --- springs ------------------------------------------------------------------------------

    def _elasticity(self) -> Elasticity | None:
        if self.kind == "points":
            return None
        if self.part.is_made_of_elements:
            return self._of_elements()
        if len(self.own) > LARGEST:
            self.notes.append(f"elastic constants are not computed above {LARGEST} springs")
            return None
        match self.kind:
            case "solid":
                return constants_of_solid(
                    self.part, self.drawing, self.state, self.own, self.constant
                )
            case "wall":
                return self._of_wall()
            case "thread" | "bars":
                return self._of_bars()

    def _of_elements(self) -> Elasticity | None:
        """Return the elastic constants of the elements of a body, if all have the same."""
        own, wall = self.state.network.elements_of(self.part.name), None
        if self.kind == "wall":
            wall = WallNodes(self.state.network.position, self.part.nodes, self.mesh.even_grid)
        if (found := constants_of_elements(own, wall)) is None:
            self.notes.append("elastic constants are not computed for elements that differ")
        return found

    def _of_wall(self) -> Elasticity:
        grid = self.mesh.even_grid
        within = wall_springs(self.mesh.skin, self.ends) | self.drawing.bends[self.own]
        if grid is not None and grid.closed:  # springs through the inside of a tube take part
            within[:] = True
        if others := int((~within).sum()):
            springs = counted(others, "spring")
            self.notes.append(f"elastic constants ignore {springs} outside the wall")
        return of_wall(
            self.mesh.position, self.ends[within], self.constant[within], self.mesh.skin,
            grid, self._across(),
        )  # fmt: skip

    def _of_bars(self) -> Elasticity:
        chosen = np.isin(self.own, self._bars())
        pull = self.constant[chosen] * self.length[chosen]
        across = self._across()
        low, high = (float(one) / (across or 1.0) for one in (pull.min(), pull.max()))
        unit: Unit = "N" if across is None else "Pa"
        if high - low <= _ALIKE * high:
            return Elasticity(unit, ("along",), (high,))
        return Elasticity(unit, ("least", "largest"), (low, high))

    def _retardation_time(self) -> float | None:
        if self.part.is_made_of_elements:
            own = self.state.network.elements_of(self.part.name)
            shear, viscosity = (
                np.concatenate([getattr(one, key) for one in own])
                for key in ("shear", "viscosity")
            )
            return float(np.median(viscosity / shear)) or None
        elongation = self.length - self.behaviour.rest
        viscosity = self.behaviour.sluggishness(elongation, 0.0 * elongation)
        resists = (self.constant > 0.0) & (viscosity > 0.0)
        if not resists.any():
            return None
        return float(np.median(viscosity[resists] / self.constant[resists]))

    def _breaking_elements(self) -> BreakingStrength | None:
        """Return the stretch at which elements with a breaking strain break."""
        own = self.state.network.elements_of(self.part.name)
        limits = [one.limits.strain for one in own if one.limits is not None]
        strain = np.concatenate([np.zeros(0), *limits])
        strain = strain[np.isfinite(strain)]
        if not len(strain):
            return None
        least, middle, most = np.quantile(1.0 + strain, [0.0, 0.5, 1.0]).tolist()
        return BreakingStrength((least, middle, most), None)

    def _breaking(self, elasticity: Elasticity | None) -> BreakingStrength | None:
        if self.part.is_made_of_elements:
            return self._breaking_elements()
        chosen = np.isin(self.own, self._bars()) & ~self.drawing.bends[self.own]
        strain = breaking_strains(self.behaviour, self.state.springs.strength[self.springs])[
            chosen
        ]
        strain = strain[np.isfinite(strain)]
        if not len(strain):
            return None
        median = float(np.median(strain))
        stretch = 1.0 + float(strain.min()), 1.0 + median, 1.0 + float(strain.max())
        stress = None
        if elasticity is not None and self.behaviour.is_linear:
            spreads = (strain, np.array(elasticity.young))
            if all(np.ptp(one) <= _ABOUT * one.max() for one in spreads):
                stress = elasticity.mean * median
        return BreakingStrength(stretch, stress)

    # --- motion -------------------------------------------------------------------------------

    def _about_equilibrium(
        self, found: Modes, chosen: NDArray[np.bool_], unbalanced: str
    ) -> Iterator[str]:
        """Yield the frequencies about the equilibrium, if they are others.

        Args:
            found: The modes about the state at 0 s, which is none.
            chosen: Nodes of the body, shape (node,).
            unbalanced: By how much forces fail to balance.
        """
        settled = self.equilibrium()
        if settled is None:
            yield f"{unbalanced}; frequencies are about the state at 0 s"
            return
        others = modes_of(settled, chosen, count=len(found), above=0.0)
        drawn, at_rest = (
            [mode.frequency for mode in modes if mode.frequency] for modes in (found, others)
        )
        if not at_rest or abs(at_rest[0] - drawn[0]) <= _NOTICED * drawn[0]:
            return
        shown = ", ".join(f"{frequency:.3g}" for frequency in at_rest)
        yield (
            "frequencies are about the state at 0 s, which is not in equilibrium; about the "
            f'equilibrium, they are {shown} Hz (write "at 0 s: settle" to begin there)'
        )

    def _vibrations(self, rest: State | str, count: int) -> Iterator[Vibration]:
        if not isinstance(rest, State):
            self.notes.append(f"frequencies are not computed: {rest}")
            return
        chosen = np.zeros(len(rest.position), dtype=bool)
        chosen[self.part.nodes] = True
        free = int((chosen & rest.free).sum())
        if not free or not count:
            return
        if free > LARGEST_TO_VIBRATE:
            self.notes.append(
                f"frequencies are not computed above {LARGEST_TO_VIBRATE} free nodes; "
                "tissuec modes computes them"
            )
            return
        try:
            found = modes_of(rest, chosen, count=count, above=0.0)
        except SimulationError as error:
            self.notes.append(f"frequencies are not computed: {error}")
            return
        unbalanced = out_of_balance(rest, chosen)
        self.notes += [
            note for note in found.notes if not (unbalanced and note.startswith(unbalanced))
        ]
        if unbalanced:
            self.notes += self._about_equilibrium(found, chosen, unbalanced)
        for mode in found:
            if mode.frequency and mode.damping_ratio is not None:
                yield Vibration(mode.frequency, mode.damping_ratio)
