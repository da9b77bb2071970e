"""One body to arrays: its mesh, its regions, and what each spring and node is made of.

Springs: c and d as the tissue says, per spring or for a spring of a stated length (n equal
springs in a row are n times softer, so c scales with 1 / length); L0 = (1 - p) drawn length for
a prestress p. A spring between two regions follows the body's ``interface``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissuec.compiling.points import PointScope, extents
from tissuec.compiling.tables import ExplicitBody, read_tables
from tissuec.core.errors import Note
from tissuec.core.source import Span
from tissuec.meshes import Mesh
from tissuec.network import Floats, Indices, Origin, Provenance
from tissuec.scene.expressions import Scope
from tissuec.scene.findings import Findings
from tissuec.scene.model import Body, Given, Tissue
from tissuec.scene.quantities import QUANTITIES
from tissuec.scene.values import LARGEST_NUMBER

LARGEST = 50_000_000  # nodes or springs of one body; more does not fit into memory


@dataclass(frozen=True, slots=True, eq=False)
class BodyArrays:
    """A body before it takes its place in the network; fields as in ``Network``."""

    body: Body
    mesh: Mesh
    arrays: dict[str, Floats]  # "mass", "stiffness", "damping", "rest", "strength"
    provenance: dict[str, Provenance]
    velocity: Floats
    node_ids: Indices
    spring_ids: Indices
    regions: dict[str, NDArray[np.bool_]]  # membership of nodes, by lower-case name


@dataclass(frozen=True, slots=True)
class Material:
    """What one region is made of; the body itself is the first."""

    name: str
    tissue: Tissue | None
    prestress: Given | None
    span: Span


def build_body(body: Body, scope: Scope) -> BodyArrays:
    """Return the arrays of one body; what is wrong is rejected with its place."""
    return _Builder(body, scope).build()


class _Builder:
    def __init__(self, body: Body, scope: Scope):
        self.body = body
        self.scope = scope
        self.findings: Findings = scope.findings

    @np.errstate(all="ignore")
    def build(self) -> BodyArrays:
        """Return the arrays; numbers that leave the range of numbers are found in the end."""
        explicit = read_tables(self.body, self.scope) if self.body.tables else None
        self.mesh = explicit.mesh if explicit else self._generate()
        self.explicit = explicit or ExplicitBody.without_columns(self.mesh)
        self.regions = self._select_regions()
        self.materials = self._materials()
        self.node_material = self._node_materials()
        self.lengths = np.linalg.norm(
            np.diff(self.mesh.position[self.mesh.ends], axis=1)[:, 0], axis=1
        )
        arrays: dict[str, Floats] = {}
        provenance: dict[str, Provenance] = {}
        arrays["mass"], provenance["mass"] = self._mass()
        self.pairs = self.node_material[self.mesh.ends]
        stiffness, provenance["stiffness"] = self._per_spring("spring constant")
        arrays["stiffness"] = stiffness
        arrays["damping"], provenance["damping"] = self._per_spring("viscosity")
        arrays["rest"], provenance["rest"] = self._rest()
        arrays["strength"], provenance["strength"] = self._strength()
        velocity = self._velocity(arrays["mass"])
        self._check_sizes(arrays, velocity)
        return BodyArrays(
            self.body, self.mesh, arrays, provenance, velocity,
            self.explicit.node_ids, self.explicit.spring_ids, self.regions,
        )  # fmt: skip

    def _check_sizes(self, arrays: Mapping[str, Floats], velocity: Floats) -> None:
        """Reject a body whose numbers are too large or too small to be reckoned with."""
        named = {
            "place": self.mesh.position,
            "length": self.lengths,
            "velocity": velocity,
            "mass": arrays["mass"],
            "spring constant": arrays["stiffness"],
            "viscosity": arrays["damping"],
            "rest length": arrays["rest"],
        }
        for name, values in named.items():
            if not np.all(np.abs(values) < LARGEST_NUMBER):
                message = f"body {self.body.name} has a {name} that is too large to reckon with"
                self.findings.reject("TIS504", message, self.body.span, hint="check the units")
        if np.any(arrays["mass"] < 1.0 / LARGEST_NUMBER):
            message = f"body {self.body.name} has a mass that is too small to reckon with"
            self.findings.reject("TIS504", message, self.body.span, hint="check the units")

    # --- mesh and regions ---------------------------------------------------------------------

    def _generate(self) -> Mesh:
        assert self.body.mesh is not None
        try:
            nodes, springs = self.body.mesh.size()
            if max(nodes, springs) > LARGEST:
                self.findings.reject(
                    "TIS310",
                    f"body {self.body.name} would have about {nodes:.3g} nodes and {springs:.3g} springs",
                    self.body.span,
                    hint=f"at most {LARGEST:,} of each can be held".replace(",", " "),
                )
            return self.body.mesh.build()
        except (ValueError, ArithmeticError) as error:
            self.findings.reject("TIS309", f"body {self.body.name}: {error}", self.body.span)

    def _select_regions(self) -> dict[str, NDArray[np.bool_]]:
        scope = PointScope(self.scope, self.mesh.position)
        members: dict[str, NDArray[np.bool_]] = {}
        for region in self.body.regions:
            inside = scope.select(region.where)
            if not inside.any():
                hint = extents(self.mesh.position)
                self.findings.reject(
                    "TIS302",
                    f'the region "{region.name}" holds no node',
                    region.span,
                    hint=hint,
                )
            for other in self.body.regions[: len(members)]:
                common = int((inside & members[other.name.lower()]).sum())
                if common:
                    self.findings.reject(
                        "TIS311",
                        f"regions {other.name} and {region.name} share {common} nodes",
                        region.span,
                        hint=f"end one of them with: and not region is {other.name}, or change its limits",
                        notes=(Note("the other region", other.span),),
                    )
            members[region.name.lower()] = inside
        return members

    def _materials(self) -> list[Material]:
        body = Material(self.body.name, self.body.tissue, None, self.body.span)
        return [body] + [
            Material(
                region.name, region.tissue or self.body.tissue, region.prestress, region.span
            )
            for region in self.body.regions
        ]

    def _node_materials(self) -> NDArray[np.int64]:
        material = np.zeros(len(self.mesh.position), dtype=np.int64)
        for number, inside in enumerate(self.regions.values(), start=1):
            material[inside] = number
        return material

    # --- quantities ---------------------------------------------------------------------------

    def _given(self, name: str, used: NDArray[np.int64]) -> list[Given | None]:
        """Return the quantity of each material; those in use must have one."""
        found: list[Given | None] = []
        for number, material in enumerate(self.materials):
            given = material.tissue.given.get(name) if material.tissue else None
            if name == "prestress" and material.prestress is not None:
                given = material.prestress
            if given is None and QUANTITIES[name].default is None and number in used:
                self._missing(name, material)
            found.append(given)
        return found

    def _missing(self, name: str, material: Material) -> None:
        if material.tissue is None:
            self.findings.reject(
                "TIS304",
                f"{material.name} needs a tissue: nothing gives its {name}",
                material.span,
                hint="write tissue is …",
            )
        reason = material.tissue.missing.get(name, "no rule and no number gives it")
        self.findings.reject(
            "TIS206",
            f"nothing gives the {name} of tissue {material.tissue.name}: {reason}",
            material.tissue.span,
            hint=f"write {name} = … in the tissue, a rule for it, or otherwise is … in the vocabulary",
            notes=(Note(f"used by {material.name}", material.span),),
        )

    def _per_spring(self, name: str) -> tuple[Floats, Provenance]:
        """Return a quantity of every spring from tables, materials and the interface."""
        column = self.explicit.springs.get(name)
        open_springs = (
            np.ones(len(self.pairs), dtype=bool) if column is None else np.isnan(column)
        )
        used = np.unique(self.pairs[open_springs])
        given = self._given(name, used)
        first, second = (self._at(given, self.pairs[:, end], name) for end in (0, 1))
        if name == "spring constant":
            # Decided once: a softer interface takes all its quantities from the softer side.
            self.first_is_softer = first <= second
        value = np.where(self.pairs[:, 0] == self.pairs[:, 1], first, self._join(first, second))
        return self._with_table(value, column, given, open_springs)

    def _at(
        self, given: Sequence[Given | None], material: NDArray[np.int64], name: str
    ) -> Floats:
        default = QUANTITIES[name].default
        values = np.array([default if g is None else g.value for g in given], dtype=float)[
            material
        ]
        lengths = np.array(
            [np.nan if g is None or g.length is None else g.length for g in given]
        )[material]
        scaled = values * (lengths / self.lengths) ** -QUANTITIES[name].scales
        if np.any(~np.isnan(lengths) & (self.lengths == 0.0)):
            self.findings.reject(
                "TIS309",
                f"{name} is given for a length, but a spring of {self.body.name} has none",
                self.body.span,
            )
        return np.where(np.isnan(lengths), values, scaled)

    def _join(self, first: Floats, second: Floats) -> Floats:
        match self.body.interface:
            case "softer":
                return np.where(self.first_is_softer, first, second)
            case "stiffer":
                return np.where(self.first_is_softer, second, first)
            case _:
                return (first + second) / 2.0

    def _with_table(
        self,
        value: Floats,
        column: Floats | None,
        given: Sequence[Given | None],
        open_springs: NDArray[np.bool_],
    ) -> tuple[Floats, Provenance]:
        origins = [self._origin(g) for g in given]
        origins.append(Origin(self.body.span, f"interface {self.body.interface}"))
        index = np.where(
            self.pairs[:, 0] == self.pairs[:, 1], self.pairs[:, 0], len(origins) - 1
        )
        if column is not None:
            assert self.body.tables is not None and self.body.tables.springs is not None
            origins.append(Origin(self.body.tables.springs.span, "table"))
            value = np.where(open_springs, value, column)
            index = np.where(open_springs, index, len(origins) - 1)
        return value, Provenance(index.astype(np.int32), tuple(origins))

    def _origin(self, given: Given | None) -> Origin:
        return Origin(given.span, given.how) if given else Origin(self.body.span, "none")

    def _rest(self) -> tuple[Floats, Provenance]:
        column = self.explicit.springs.get("rest length")
        prestress, provenance = self._per_spring("prestress")
        rest = (1.0 - prestress) * self.lengths
        if column is None:
            return rest, provenance
        assert self.body.tables is not None and self.body.tables.springs is not None
        written = ~np.isnan(column)
        origins = (*provenance.origins, Origin(self.body.tables.springs.span, "table"))
        index = np.where(written, len(origins) - 1, provenance.index)
        return np.where(written, column, rest), Provenance(index.astype(np.int32), origins)

    def _strength(self) -> tuple[Floats, Provenance]:
        if self.body.may_rupture:
            return self._per_spring("fraction force")
        unbreakable = Provenance(
            np.zeros(len(self.pairs), dtype=np.int32),
            (Origin(self.body.span, "rupture is not allowed"),),
        )
        return np.full(len(self.pairs), np.inf), unbreakable

    def _mass(self) -> tuple[Floats, Provenance]:
        nodes = len(self.node_material)
        column = self.explicit.nodes.get("mass")
        open_nodes = np.ones(nodes, dtype=bool) if column is None else np.isnan(column)
        if self.body.mass is not None:
            assert self.body.mass_span is not None
            values = np.full(nodes, self.body.mass / max(nodes, 1))
            origins, index = (
                [Origin(self.body.mass_span, "written")],
                np.zeros(nodes, dtype=np.int64),
            )
        else:
            given = self._given("mass", np.unique(self.node_material[open_nodes]))
            per_node = [
                0.0 if g is None else g.value / (nodes if g.spread == "whole body" else 1)
                for g in given
            ]
            values, index = np.array(per_node)[self.node_material], self.node_material
            origins = [self._origin(g) for g in given]
        if column is not None:
            assert self.body.tables is not None
            origins.append(Origin(self.body.tables.nodes.span, "table"))
            values = np.where(open_nodes, values, column)
            index = np.where(open_nodes, index, len(origins) - 1)
        return values, Provenance(index.astype(np.int32), tuple(origins))

    def _velocity(self, mass: Floats) -> Floats:
        position = self.mesh.position
        velocity = np.tile(self.body.velocity, (len(position), 1))
        if self.body.spin.any() and len(position):
            centre = (mass[:, None] * position).sum(axis=0) / mass.sum()
            velocity += np.cross(self.body.spin, position - centre)
        columns = [self.explicit.nodes.get(name) for name in ("vx", "vy", "vz")]
        for axis, column in enumerate(columns):
            if column is not None:
                velocity[:, axis] = np.where(np.isnan(column), velocity[:, axis], column)
        return velocity
