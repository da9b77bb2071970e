"""Materials of the nodes and springs of a body.

Springs: c and d as the tissue says, per spring or for a spring of a stated length (n equal
springs in a row are n times softer, so c scales with 1 / length); L0 = (1 - p) drawn length for
a prestress p. What a table gives goes before all of this. A mesh may say which share of c and d
each spring gets.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.bodies.bending_springs import with_bending
from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.materials.cutting_resistance import (
    SpringResistance,
    resistance_of_parts,
    resistance_of_springs,
)
from tissuec.compiler.materials.spring_laws import SpringLaws
from tissuec.compiler.materials.spring_parts import SpringParts
from tissuec.compiler.materials.tissue_parts import NOT_ALLOWED, TissueParts
from tissuec.core.names import key_of
from tissuec.laws import Law
from tissuec.laws.evaluation import Behaviour
from tissuec.model.inelastic import PAIRS, TIMES, VISCOSITY
from tissuec.model.network import Explained, Floats, Origin, Provenance
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import (
    BREAKING_FORCE,
    BREAKING_STRAIN,
    OF_MATTER,
    QUANTITIES,
    SHARES,
    TOUGHNESS,
)

if TYPE_CHECKING:  # nets of numbers need none of it
    from tissuec.compiler.materials.matter import MatterReader


class MaterialReader:
    """Gives the nodes and springs of one drawing what tissues and tables say.

    Parts of the body are numbered: 0 is the body itself, then come its regions, then springs
    that have a tissue of their own.
    """

    def __init__(self, drawing: Drawing, findings: Findings):
        self.drawing = drawing
        self.body = drawing.body
        self.findings = findings
        self.columns = drawing.columns
        self.node_part = drawing.part
        self.length = drawing.length
        self.shares = drawing.mesh.shares
        self.parts = TissueParts(drawing, findings)
        self.springs = SpringParts(drawing, self.parts, findings)
        self._laws = SpringLaws(drawing, self.parts, self.springs, findings)

    def read(self) -> dict[str, Explained]:
        """Return every parameter array of the network, by name."""
        self.parts.refuse_idle_fibres()
        self.parts.refuse_solids(self.node_part, are_bars=self.drawing.is_bars)
        return {"mass": self._mass(), **self.read_springs()}

    def read_springs(self) -> dict[str, Explained]:
        """Return every parameter array of springs, by name."""
        arrays = {
            "stiffness": self.stiffness,
            "damping": self._shared("viscosity"),
            "rest": self.rest,
            "strength": self._limit(BREAKING_FORCE),
            "crush": self._limit("crushing force"),
        }
        return with_bending(self.drawing, self.parts, self.springs, arrays | self._inelastic())

    def resistance(self) -> SpringResistance:
        """Return the cutting resistance of the springs."""
        each, given = resistance_of_parts(self.parts), self.parts.found("spring constant")
        of_matter = [one for one in given if one is not None and one.quantity.is_of_matter]
        if not each.any() or not of_matter:
            return SpringResistance.none(len(self.length))
        pull = self.stiffness[0] * self.length
        return resistance_of_springs(self.parts, self.springs.ends, pull)

    def laws(self) -> tuple[NDArray[np.int32], tuple[Law, ...]]:
        """Return the law of each spring by number, shape (spring,), and all laws."""
        return self._laws.numbered(self._joined)

    def _inelastic(self) -> dict[str, Explained]:
        """Return the quantities of relaxation and flow, by name."""
        arrays: dict[str, Explained] = {}
        for pair in PAIRS:
            said = [self._is_said(name) for name in pair]
            if not (said[0].any() or said[1].any()):
                continue
            self._refuse_halves(pair, said)
            for name in pair:
                shared = QUANTITIES[name].scales
                arrays[name] = self._shared(name) if shared else self._per_spring(name)
        return arrays

    def _is_said(self, name: str) -> NDArray[np.bool_]:
        """Return for which springs a tissue or a table says a quantity, shape (spring,)."""
        given = np.array([g is not None for g in self.parts.found(name)])
        column = self.columns.springs.get(name)
        return given[self.springs.ends].any(axis=1) | ~_is_open(column, self.length)

    def _refuse_halves(self, pair: tuple[str, str], said: list[NDArray[np.bool_]]) -> None:
        """Reject springs of which one quantity of a pair is said, and not the other."""
        for name, other, half in (
            (*pair, said[0] & ~said[1]),
            (*reversed(pair), said[1] & ~said[0]),
        ):
            if not half.any():
                continue
            parts: list[int] = self.springs.ends[np.argmax(half)].tolist()
            given = [
                g for g in (self.parts.found(name)[part] for part in parts) if g is not None
            ]
            tables = self.body.tables
            where = (
                tables.springs.rows.name.span if tables and tables.springs else self.body.span
            )
            modulus = [self.parts.found("spring constant")[part] for part in parts]
            is_matter = any(g is not None and g.quantity.is_of_matter for g in modulus)
            lacking = QUANTITIES[
                OF_MATTER[other][0] if is_matter and OF_MATTER[other] else other
            ]
            self.parts.refuse_half(given[0] if given else None, name, lacking, where)

    def _mass(self) -> Explained:
        column = self.columns.nodes.get("mass")
        if self.body.mass is not None:
            values = np.full(len(self.node_part), self.body.mass / len(self.node_part))
            origins = [Origin(self.body.places["mass"], "written")]
            index = np.zeros_like(self.node_part)
        else:
            given = self.parts.given("mass", self.node_part[_is_open(column, self.node_part)])
            values, index = self.parts.at_nodes(given, 0.0), self.node_part
            for number, one in enumerate(given):
                if one is not None and one.quantity.is_of_matter:
                    volume = self._matter(one).volumes()
                    values = np.where(index == number, values * volume, values)
                elif one is not None and one.spread == "whole body":
                    values[index == number] /= len(index)
            origins = [self._origin(g) for g in given]
        provenance = Provenance(index.astype(np.int32), tuple(origins))
        return self._from_table(values, provenance, column, "nodes")

    @cached_property
    def stiffness(self) -> Explained:
        """The spring constant of every spring [N/m]."""
        return self._shared("spring constant")

    @cached_property
    def rest(self) -> Explained:
        """The rest length of every spring [m]."""
        prestress, provenance = self._per_spring("prestress")
        column = self.columns.springs.get("rest length")
        # Lengths as they are drawn share the memory of the drawing.
        rest = (1.0 - prestress) * self.length if prestress.any() else self.length
        return self._from_table(rest, provenance, column, "springs")

    def _limit(self, name: str) -> Explained:
        """Return the force at which each spring breaks [N]; infinite where nothing does."""
        if self.body.may_rupture:
            return self._breaking() if name == BREAKING_FORCE else self._per_spring(name)
        origin = Origin(self.body.span, NOT_ALLOWED)
        shape = self.length.shape  # of arrays that take no room
        index = np.broadcast_to(np.int32(0), shape)
        return np.broadcast_to(np.inf, shape), Provenance(index, (origin,))

    def _breaking(self) -> Explained:
        """Return the force at which each spring breaks [N]: the least of up to two limits."""
        limits = self.parts.limits()
        first: list[AssignedQuantity | None] = [one[0] if one else None for one in limits]
        last: list[AssignedQuantity | None] = [one[-1] if one else None for one in limits]
        value, known = self._per_spring(BREAKING_FORCE, first)
        if first == last:
            return value, known
        other, also = self._per_spring(BREAKING_FORCE, last)
        index = np.where(other < value, also.index + len(known.origins), known.index)
        origins = (*known.origins, *also.origins)
        return np.minimum(value, other), Provenance(index.astype(np.int32), origins)

    def _shared(self, name: str) -> Explained:
        """Return a quantity of every spring, of which it gets the share that its mesh says."""
        value, provenance = self._per_spring(name)
        if self.shares is None:
            return value, provenance
        origins = tuple(Origin(o.span, f"{o.how}, shared") for o in provenance.origins)
        share = np.where(np.isinf(value), 1.0, self.shares)  # what is infinite is none at all
        return value * share, Provenance(provenance.index, origins)

    def _per_spring(
        self, name: str, found: Sequence[AssignedQuantity | None] | None = None
    ) -> Explained:
        """Return a quantity of every spring from tables, materials and the interface.

        Args:
            found: Quantity of each part; None to look it up, or those from which it follows.
        """
        column = self.columns.springs.get(name)
        is_open, is_used = _is_open(column, self.length), self._laws.uses(name)
        self.parts.expect(name, self.springs.ends[is_open & is_used])
        open_parts = self.springs.ends[is_open & ~self._laws.is_typed]
        given = self.parts.given(name, open_parts, found)
        first, second = self._at_ends(name, given)
        if name in (*TIMES, VISCOSITY):  # of what one side has alone, there is half as much
            first, second = (
                np.where(np.isinf(one), other, one)
                for one, other in ((first, second), (second, first))
            )
        value = np.where(self.springs.is_inner, first, self._joined(first, second))
        index, origins = self.springs.origins([self._origin(g) for g in given], self.body.span)
        if (idle := self._laws.is_typed & ~is_used & np.isnan(value)).any():
            value[idle], index[idle] = 1.0, len(origins)
            origins.append(Origin(self.body.span, "no part of the law"))
        provenance = Provenance(index.astype(np.int32), tuple(origins))
        return self._from_table(value, provenance, column, "springs")

    def _from_table(
        self, value: Floats, provenance: Provenance, column: Floats | None, table: str
    ) -> Explained:
        """Return an array with the numbers of a table's column where it has some."""
        if column is None:
            return value, provenance
        assert self.body.tables is not None
        origins = (
            *provenance.origins,
            Origin(getattr(self.body.tables, table).rows.span, "table"),
        )
        is_open = np.isnan(column)
        index = np.where(is_open, provenance.index, len(origins) - 1)
        return (
            np.where(is_open, value, column),
            Provenance(index.astype(np.int32), origins),
        )

    def _origin(self, given: AssignedQuantity | None) -> Origin:
        return Origin(given.span, given.how) if given else Origin(self.body.span, "none")

    # --- parts and their interfaces -----------------------------------------------------------

    def _at_ends(
        self, name: str, given: Sequence[AssignedQuantity | None]
    ) -> tuple[Floats, Floats]:
        """Return a quantity as the part at either end of each spring has it."""
        default = QUANTITIES[name].default
        lengths = [np.nan if g is None or g.length is None else g.length for g in given]
        lengths = np.array(lengths)
        ends: list[Floats] = []
        for part in self.springs.ends.T:
            end = self.parts.at_springs(given, part, default)
            if not np.isnan(lengths).all():
                end = self._scaled(name, end, lengths[part])
            for number, one in enumerate(given):
                if one is not None and one.quantity.is_of_matter and np.isfinite(one.value):
                    own = part == number
                    end = np.where(own, self._from_matter(one, end, own), end)
            ends.append(end)
        return ends[0], ends[1]

    def _scaled(self, name: str, value: Floats, lengths: Floats) -> Floats:
        """Return a quantity of each spring that is given for a length, where it is.

        Args:
            name: Of the quantity.
            value: What is given, shape (spring,).
            lengths: For which [m], NaN where it is for any, shape (spring,).
        """
        is_scaled = ~np.isnan(lengths)
        if np.any(is_scaled & (self.length == 0.0)):
            self.findings.reject(
                "TIS309",
                f"{name} is given for a length, but a spring of {self.body.name} has none",
                self.body.span,
            )
        scale = (lengths / self.length) ** -QUANTITIES[name].scales
        return np.where(is_scaled, value * scale, value)

    # --- matter -------------------------------------------------------------------------------

    def _from_matter(
        self, given: AssignedQuantity, amount: Floats, own: NDArray[np.bool_]
    ) -> Floats:
        """Return the values for springs that follow from a quantity of matter, shape (spring,).

        Args:
            amount: Its number for each spring in its SI unit, shape (spring,).
            own: Which springs have it, shape (spring,).
        """
        match key_of(given.quantity.name):
            case "young's modulus":
                added = self.parts.added_by_fibres(given)
                each = (1.0 + added) * self._matter(given).section() / self.length
            case "shear viscosity":
                each = self._matter(given).shears * (
                    self._matter(given).section() / self.length
                )
            case "flow viscosity":
                each = self._matter(given).section() / self.length
            case "retardation time":
                each = self.stiffness[0]
            case share if share in SHARES:
                each = self.stiffness[0] / (1.0 - self.parts.relaxing_beside(given))
            case _:
                return self._at_limit(given, amount, own)
        each = amount * each
        return each if self.shares is None else each / self.shares

    def _at_limit(
        self, given: AssignedQuantity, amount: Floats, own: NDArray[np.bool_]
    ) -> Floats:
        """Return the force of springs at a stress, strain or energy [N], shape (spring,).

        The arguments are those of ``_from_matter``.
        """
        constant, rest = self.stiffness[0], self.rest[0]
        if key_of(given.quantity.name) == BREAKING_STRAIN:
            return self._behaviour.pull(amount * rest)
        beside = self.parts.modulus_beside(given)
        modulus = self.parts.at_springs([None, beside], own.astype(np.int64), 1.0)
        if key_of(given.quantity.name) == TOUGHNESS:
            from tissuec.matter.breaking import force_at_energy

            section = constant * self.length / modulus
            return force_at_energy(self._behaviour, amount * section)
        return constant * rest * amount / modulus

    @property
    def _behaviour(self) -> Behaviour:
        """The behaviour of the springs without their dashpots."""
        (constant, _), (rest, _), (law, laws) = self.stiffness, self.rest, self.laws()
        return Behaviour(laws, law, constant, np.zeros_like(constant), rest)

    def _matter(self, given: AssignedQuantity) -> "MatterReader":
        """Return the reader of what follows from a quantity of matter."""
        from tissuec.compiler.materials.matter import MatterReader

        return MatterReader(self.drawing, given, self.findings)

    @cached_property
    def _first_is_softer(self) -> NDArray[np.bool_]:
        """Whether the first end is in the softer part, shape (spring,).

        Spring constants decide for all quantities, so that an interface is made of one side.
        """
        first, second = self._at_ends("spring constant", self.parts.found("spring constant"))
        return np.asarray(first <= second)

    def _joined(self, first: Floats, second: Floats) -> Floats:
        """Return the values of springs between two parts by their rules, shape (spring,)."""
        return self.springs.joined(first, second, lambda: self._first_is_softer)


def _is_open(column: Floats | None, like: NDArray[np.generic]) -> NDArray[np.bool_]:
    """Return where a table leaves a quantity to the tissue: everywhere without a column."""
    return np.ones(len(like), dtype=bool) if column is None else np.isnan(column)
