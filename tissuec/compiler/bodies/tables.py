"""Explicit meshes: tables of nodes and springs to arrays, columns with units of their own.

``with columns "id x y z mass in g"``: a column is a known name, then ``in`` and a unit where it
has one; lengths without a unit take that of the table (``table nodes of net in mm``).
"""

import re
from collections.abc import Collection, Mapping, Sequence
from typing import Literal

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.errors import CompileError
from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean, insertion
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.units import (
    ALL_UNITS,
    LENGTH,
    Dimension,
    UnitError,
    describe,
    near_unit,
    parse_unit,
    show,
)
from tissuec.lang import syntax as s
from tissuec.lang.tables import ColumnSpec, cell_span, read_rows
from tissuec.meshes.generators import Mesh
from tissuec.meshes.generators.explicit import ExplicitMesh, TableError
from tissuec.model.inelastic import NAMES as INELASTIC
from tissuec.model.network import Floats, Indices
from tissuec.scene.model import Body, Tables
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.sentences import WrittenTable
from tissuec.scene.tissues.quantities import LISTED, QUANTITIES

ID = "id"
LAW = "law"
REST = "rest length"
_WORD = re.compile(r"[^\s,]+")

#: A name and its unit in brackets or after a stroke.
_NAME_AND_UNIT = re.compile(r"(\w+)[\[(/](.+)")
NODE_COLUMNS: dict[str, Dimension | None] = {
    ID: None, "x": LENGTH, "y": LENGTH, "z": LENGTH, "mass": units.MASS,
    "vx": units.VELOCITY, "vy": units.VELOCITY, "vz": units.VELOCITY,
}  # fmt: skip
SPRING_COLUMNS: dict[str, Dimension | None] = {
    ID: None, "a": None, "b": None, "rest length": LENGTH,
    "spring constant": units.STIFFNESS, "viscosity": units.VISCOSITY,
    "breaking force": units.FORCE, "crushing force": units.FORCE, LAW: None,
    **{name: QUANTITIES[name].dimension for name in INELASTIC},
}  # fmt: skip
#: Columns that may leave a cell open with "-": the tissue gives what is missing.
_LIMITS = ("breaking force", "crushing force")
_OPEN = ("mass", "rest length", "spring constant", "viscosity", *_LIMITS, LAW, *INELASTIC)
#: Columns whose numbers must be above zero, or may be zero.
_ABOVE_ZERO = ("mass", *_LIMITS, *(n for n in INELASTIC if not QUANTITIES[n].may_be_zero))
#: Logarithm of the ratio of rest length and drawn length from which on a unit is wrong.
_FAR_OFF = np.log(20.0)
_NOT_BELOW_ZERO = (
    *("spring constant", "viscosity", "rest length"),
    *(name for name in INELASTIC if QUANTITIES[name].may_be_zero),
)


class ExplicitBody(Struct, frozen=True, eq=False):
    """Contents of the tables of a body; NaN where a cell is empty.

    The law of a spring is its number among ``laws``, the names that rows give.
    """

    mesh: Mesh
    node_ids: Indices
    spring_ids: Indices
    nodes: Mapping[str, Floats]
    springs: Mapping[str, Floats]
    laws: Sequence[str] = ()

    def with_springs(self, pairs: NDArray[np.int32]) -> "ExplicitBody":
        """Return this with more springs, given by node pairs of shape (spring, 2).

        They come last, and the tables have no values for them.
        """
        mesh, count = self.mesh, len(pairs)
        ids = int(self.spring_ids.max(initial=0)) + 1 + np.arange(count)
        return ExplicitBody(
            mesh.with_ends(np.concatenate([mesh.ends, pairs])),
            self.node_ids,
            np.concatenate([self.spring_ids, ids]),
            self.nodes,
            {
                name: np.concatenate([column, np.full(count, np.nan)])
                for name, column in self.springs.items()
            },
            self.laws,
        )

    @classmethod
    def without_columns(cls, mesh: Mesh) -> "ExplicitBody":
        """Return the same of a generated mesh, numbered from 1."""
        nodes, springs = (np.arange(1, len(part) + 1) for part in (mesh.position, mesh.ends))
        return cls(mesh, nodes, springs, {}, {})


def read_tables(body: Body, tables: Tables, scope: Scope) -> ExplicitBody:
    """Return the mesh and the columns of an explicit body; errors point at their cell."""
    nodes = _NumberTable(tables.nodes, NODE_COLUMNS, ("x",), scope).read()
    node_ids = nodes.ids()
    if not len(node_ids):
        message = f"the table contains no node of {body.name}"
        scope.findings.reject(
            "TIS302", message, tables.nodes.rows.name.span, hint="write at least one row"
        )
    position = np.stack([nodes.get(axis, default=0.0) for axis in "xyz"], axis=1)
    if tables.springs is None:
        springs, ends, spring_ids = None, np.zeros((0, 2), np.int32), np.zeros(0, np.int64)
    else:
        springs = _NumberTable(tables.springs, SPRING_COLUMNS, ("a", "b"), scope).read()
        spring_ids = springs.ids()
        ends = np.stack(
            [springs.node_numbers(end, node_ids, body.name) for end in ("a", "b")], axis=1
        )
    try:
        mesh = ExplicitMesh(position, ends).build()
    except TableError as error:
        table = springs if error.table == "springs" and springs is not None else nodes
        scope.findings.reject("TIS313", str(error), cell_span(table.table, error.row, 0))
    if springs is None:
        return ExplicitBody(mesh, node_ids, spring_ids, nodes.columns, {})
    springs.warn_of_lengths(mesh)
    laws = springs.number_laws(tables.laws)
    return ExplicitBody(mesh, node_ids, spring_ids, nodes.columns, springs.columns, laws)


def _kind(name: str, dimension: Dimension | None) -> Literal["number", "whole", "word"]:
    """Return the kind of the cells of a column."""
    if name == LAW:
        return "word"
    return "whole" if dimension is None else "number"


class _NumberTable:
    """One table: its header, and its cells in SI units."""

    def __init__(
        self,
        written: WrittenTable,
        known: Mapping[str, Dimension | None],
        needed: Sequence[str],
        scope: Scope,
    ):
        self.written, self.table = written, written.rows
        self.known = known
        self.needed = needed
        self.scope = scope
        self.findings = scope.findings
        self.names: list[str] = []
        self.columns: dict[str, Floats] = {}

    def read(self) -> "_NumberTable":
        """Read header and rows."""
        factors = self._header()
        wanted = [
            ColumnSpec(name, _kind(name, self.known[name]), optional=name in _OPEN)
            for name in factors
        ]
        try:
            cells = read_rows(self.table, wanted)
        except CompileError as error:
            self.findings.extend(error.diagnostics)
            self.findings.stop()
        self.names = list(factors)
        for name, column in zip(self.names, cells, strict=True):
            self.columns[name] = self._scaled(name, column, factors[name])
            self._check_sign(name, self.columns[name])
        return self

    def get(self, name: str, *, default: float) -> Floats:
        """Return a column, or the default in every row if it was left out."""
        rows = len(next(iter(self.columns.values())))
        return self.columns.get(name, np.full(rows, default))

    def ids(self) -> Indices:
        """Return the ids of the rows; without such a column their numbers from 1."""
        if ID not in self.columns:
            return np.arange(1, len(next(iter(self.columns.values()))) + 1)
        ids = self.columns[ID].astype(np.int64)
        order = np.argsort(ids, kind="stable")
        again = np.flatnonzero(np.diff(ids[order]) == 0)
        if len(again):
            row = int(order[again + 1].min())
            self.findings.reject(
                "TIS313", f"duplicate id {ids[row]} in the table", self._cell(row, ID)
            )
        return ids

    def node_numbers(self, name: str, node_ids: Indices, body: str) -> Indices:
        """Return the numbers of the nodes whose ids a column holds."""
        wanted = self.columns[name].astype(np.int64)
        order = np.argsort(node_ids)
        if not len(order):
            self.findings.reject(
                "TIS313", f"{body} has springs but no nodes", self.table.name.span
            )
        place = np.clip(np.searchsorted(node_ids, wanted, sorter=order), 0, len(order) - 1)
        found = order[place]
        unknown = np.flatnonzero(node_ids[found] != wanted)
        if len(unknown):
            row = int(unknown[0])
            self.findings.reject(
                "TIS313",
                f"{body} has no node with id {wanted[row]}",
                self._cell(row, name),
                hint=f"ids run from {node_ids.min()} to {node_ids.max()}",
            )
        return found

    def number_laws(self, known: Collection[str]) -> Sequence[str]:
        """Replace the names of laws by numbers; return the names."""
        if LAW not in self.columns:
            return ()
        keys = [s.key_of(word) for word in self.columns[LAW].tolist()]
        named = list(dict.fromkeys(key for key in keys if key))
        for key in named:
            if key not in known:
                place = self._cell(keys.index(key), LAW)
                self.findings.pass_over_doubtful(key)
                self.findings.reject(
                    "TIS301",
                    f'there is no law called "{place.text.strip(chr(34))}"',
                    place,
                    hint=alternatives(key, known, what="laws")
                    if known
                    else "declare it: law NAME { spring law is … }",
                )
        numbers = {"": np.nan} | {key: float(number) for number, key in enumerate(named)}
        self.columns[LAW] = np.array([numbers[key] for key in keys], dtype=float)
        return named

    def warn_of_lengths(self, mesh: Mesh) -> None:
        """W306: rest lengths that no prestress explains; mostly a slip of units."""
        first, second = mesh.position[mesh.ends].swapaxes(0, 1)
        drawn = np.linalg.norm(second - first, axis=1)
        rest = self.get(REST, default=np.nan)
        with np.errstate(all="ignore"):
            far = np.flatnonzero(
                (rest > 0.0) & (drawn > 0.0) & (np.abs(np.log(rest / drawn)) >= _FAR_OFF)
            )
        if not len(far):
            return
        row = int(far[0])
        more = f" (in {len(far)} rows)" if len(far) > 1 else ""
        self.findings.add(
            "W306",
            f"the rest length in row {row + 1} is {show(float(rest[row]), LENGTH)}, "
            f"but the drawn length is {show(float(drawn[row]), LENGTH)}{more}",
            self._cell(row, REST),
            hint="check the units of rest lengths and positions",
        )

    def _header(self) -> dict[str, float | None]:
        """Return the factor to SI of each column, None for ids."""
        unit, columns = self.written.said.unit, self.written.said.columns
        length = None if unit is None else self._unit(unit.text, LENGTH, unit)
        factors = self._columns(columns.quoted or "", columns.span.end - 1, length)
        for name in self.needed:
            if name not in factors:
                message = f'the table needs a column "{name}"'
                self.findings.reject("TIS304", message, self.written.header)
        return factors

    def _columns(self, text: str, end: int, length: float | None) -> dict[str, float | None]:
        """Return the columns that a header names; its ``text`` ends at offset ``end``."""
        factors: dict[str, float | None] = {}
        begin = end - len(text)
        words = [
            Span(self.table.span.source, begin + word.start(), begin + word.end())
            for word in _WORD.finditer(text)
        ]
        while words:
            keys = {n: key_of(" ".join(w.text for w in words[:n])) for n in (1, 2, 3)}
            count = max((n for n, key in keys.items() if key in self.known), default=1)
            count = min(count, len(words))
            name = keys[count] if keys[count] in self.known else words[0].text.lower()
            where = words[0].to(words[count - 1])
            words = words[count:]
            if name not in self.known:
                self._refuse_unit_in_name(where)
                listed = [n for n in self.known if n in LISTED or n not in QUANTITIES]
                for rest in () if did_you_mean(name, listed) else words[:2]:
                    if did_you_mean(key_of(where.to(rest).text), listed):
                        where = where.to(rest)
                        name = where.text
                        break
                self.findings.reject(
                    "TIS303",
                    f'"{name}" is not a column of {self.table.name.text}',
                    where,
                    hint=alternatives(name, listed, what="columns"),
                )
            if name in factors:
                self.findings.reject("TIS307", f'duplicate column "{name}"', where)
            dimension = self.known[name]
            factors[name] = None
            if len(words) > 1 and words[0].text == "in":
                if dimension is None:
                    self.findings.reject("TIS502", f"{name} has no unit", words[1])
                factors[name] = self._unit(words[1].text, dimension, words[1])
                words = words[2:]
            elif dimension is not None:
                if words and key_of(words[0].text) not in self.known:
                    self._refuse_unit_without_in(name, words[0].text, where.to(words[0]))
                factors[name] = self._default_factor(name, dimension, length, where)
        return factors

    def _refuse_unit_in_name(self, where: Span) -> None:
        """Reject ``mass[mg]``."""
        if parts := _NAME_AND_UNIT.fullmatch(where.text):
            self._refuse_unit_without_in(parts[1].lower(), parts[2], where)

    def _refuse_unit_without_in(self, name: str, unit: str, where: Span) -> None:
        """Reject ``mass mg`` and ``mass [mg]``, if the unit is one of the column.

        Args:
            name: Of the column.
            unit: The text after it, perhaps in brackets.
            where: Of both.
        """
        unit = unit.strip("[]()")
        try:
            fits = parse_unit(unit).dimension == self.known.get(name)
        except UnitError:
            return
        if fits:
            hint = Hint(f'write "… {name} in {unit}"', Edit(f"{name} in {unit}", where))
            message = 'the unit of a column follows "in"'
            self.findings.reject("TIS501", message, where, hint=hint)

    def _default_factor(
        self, name: str, dimension: Dimension, length: float | None, where: Span
    ) -> float:
        if dimension == LENGTH and length is not None:
            return length
        example = f'"… {name} in {units.suggested_unit(dimension)}"'
        self.findings.reject(
            "TIS501",
            f"the column {name} is {describe(dimension)}, but its unit is missing",
            where,
            hint=Hint(
                f"write {example}",
                insertion(f" in {units.suggested_unit(dimension)}", where),
            ),
        )

    def _unit(self, text: str, dimension: Dimension, where: Span) -> float:
        try:
            unit = parse_unit(text)
        except UnitError as error:
            hint = near_unit(error.symbol) or ALL_UNITS
            self.findings.reject("TIS104", str(error), where, hint=hint)
        if unit.dimension != dimension:
            self.findings.reject(
                "TIS502",
                f"{text} is {describe(unit.dimension)}; {describe(dimension)} is needed",
                where,
            )
        return unit.factor

    def _scaled(self, name: str, column: Floats, factor: float | None) -> Floats:
        """Return a column in SI units; rejects a number that leaves the range of numbers."""
        if factor is None:
            return column
        with np.errstate(over="ignore"):
            scaled = column * factor
        if np.isinf(scaled).any():
            place = self._cell(int(np.flatnonzero(np.isinf(scaled))[0]), name)
            self.findings.reject("TIS122", f'"{place.text}" is too large in this unit', place)
        return scaled

    def _check_sign(self, name: str, column: Floats) -> None:
        if name in _ABOVE_ZERO:
            bad, wanted = np.flatnonzero(column <= 0.0), "above zero"
        elif name in _NOT_BELOW_ZERO:
            bad, wanted = np.flatnonzero(column < 0.0), "zero or more"
        else:
            return
        if len(bad):
            row = int(bad[0])
            self.findings.reject(
                "TIS308", f"the {name} in row {row + 1} must be {wanted}", self._cell(row, name)
            )

    def _cell(self, row: int, name: str) -> Span:
        return cell_span(self.table, row, self.names.index(name))
