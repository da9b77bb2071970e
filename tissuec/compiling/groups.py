"""Sets: names for nodes or springs, chosen on the drawn mesh and fixed for good."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from tissuec.compiling.drawing import Drawing, group_masks, surface_mask
from tissuec.compiling.points import Mask, PointScope, extents
from tissuec.core.errors import alternatives
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in
from tissuec.network import Indices
from tissuec.scene.declarations import Declarations
from tissuec.scene.expressions import Scope
from tissuec.scene.findings import Findings
from tissuec.scene.order import Definitions
from tissuec.verbs import Group

#: What a set can be chosen from.
KINDS = ("nodes", "springs")


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A body with the numbers of its first node and spring in the network."""

    drawing: Drawing
    first_node: int
    first_spring: int

    @property
    def nodes(self) -> Indices:
        return np.arange(len(self.drawing.mesh.position)) + self.first_node

    @property
    def springs(self) -> Indices:
        return np.arange(len(self.drawing.mesh.ends)) + self.first_spring


@dataclass(frozen=True, slots=True, eq=False)
class NamedSet:
    """A set of nodes or of springs."""

    group: Group
    of_springs: bool


class Groups:
    """All sets and bodies by name; each set is chosen once, when first asked for."""

    def __init__(self, declarations: Declarations, bodies: Mapping[str, Placed], scope: Scope):
        self.declared = declarations.of("set")
        self.bodies = bodies
        self.scope = scope
        self.findings = scope.findings
        self.sets = Definitions("sets", self._needs, self._choose, scope.findings)
        self.used: set[str] = set()
        # Each body and set has its arrays once, however many sentences name it.
        self.whole = {key: (placed.nodes, placed.springs) for key, placed in bodies.items()}
        self.inside: dict[str, Indices] = {}

    def choose_all(self) -> None:
        """Choose every set, so that mistakes in unused ones are reported too."""
        for key in self.declared:
            with self.findings.item():
                self.sets.find(key)

    def is_known(self, name: s.Name) -> bool:
        """Tell whether a name is a set or a body."""
        return name.key in self.declared or name.key in self.bodies

    def nodes(self, name: s.Name) -> Group:
        """Return the nodes of a set of nodes or of a body."""
        if name.key in self.bodies:
            return Group(self._body(name), self.whole[name.key][0])
        chosen = self._find(name)
        if chosen.of_springs:
            self.findings.reject(
                "TIS314",
                f'"{name.text}" is a set of springs; nodes are needed here',
                name.span,
                hint=f"write set {name.text} = nodes of …, or make a set of nodes beside it",
            )
        return chosen.group

    def springs(self, name: s.Name) -> Group:
        """Return the springs of a set of springs, of a body, or inside a set of nodes."""
        if name.key in self.bodies:
            return Group(self._body(name), self.whole[name.key][1])
        chosen = self._find(name)
        if chosen.of_springs:
            return chosen.group
        if name.key not in self.inside:
            self.inside[name.key] = self.springs_inside(chosen.group.indices)
        return Group(chosen.group.name, self.inside[name.key])

    def _body(self, name: s.Name) -> str:
        """Return the name of a body as it was declared, however it is spelt here."""
        return self.bodies[name.key].drawing.body.name

    def is_springs(self, name: s.Name) -> bool:
        """Tell whether a name is a set of springs."""
        return name.key in self.declared and self._find(name).of_springs

    def springs_inside(self, nodes: Indices) -> Indices:
        """Return the springs with both ends among the nodes."""
        found = [
            placed.springs[
                np.isin(placed.drawing.mesh.ends + placed.first_node, nodes).all(axis=1)
            ]
            for placed in self.bodies.values()
        ]
        return np.concatenate(found) if found else np.zeros(0, dtype=np.int64)

    def _find(self, name: s.Name) -> NamedSet:
        if name.key not in self.declared:
            self.findings.pass_over_doubtful(name.key)
            if name.key in KINDS:
                unnamed(name.key, name.span, self.findings)
            lines = {d.name.text: d.name.span.line for d in self.declared.values()}
            known = [*lines, *(placed.drawing.body.name for placed in self.bodies.values())]
            hint = alternatives(name.text, known, what="sets and bodies")
            for text, line in lines.items():
                near = f'did you mean "{text}"'
                hint = hint.replace(f"{near}?", f"{near} (line {line})?")
            message = f'there is no set called "{name.text}"'
            self.findings.reject("TIS301", message, name.span, hint=hint)
        self.used.add(name.key)
        return self.sets.find(name.key)

    def _needs(self, key: str) -> Iterator[s.Name]:
        """Yield the sets in a union."""
        item = self.declared[key].item
        assert isinstance(item, s.Assign)
        for name in names_in(item.value) if isinstance(item.value, s.Listing) else ():
            if name.key in self.declared:
                yield name

    def _choose(self, key: str) -> NamedSet:
        item = self.declared[key].item
        assert isinstance(item, s.Assign)
        if isinstance(item.value, s.Listing):
            return self._union(item, item.value)
        clauses = {clause.word: clause for clause in item.clauses}
        kind = item.value.key if isinstance(item.value, s.Name) else ""
        if (
            kind not in KINDS
            or "of" not in clauses
            or len(clauses) < len(item.clauses)
            or set(clauses) - {"of", "where", "in"}
        ):
            self.findings.reject(
                "TIS312",
                "a set is written: nodes of BODY where …, springs of BODY where …, "
                "nodes of BODY in [1, 2], or [A, B]",
                item.value.span,
            )
        placed = self._named_body(clauses["of"].value)
        part = placed.springs if kind == "springs" else placed.nodes
        points = points_of(placed.drawing, self.scope, of_springs=kind == "springs")
        chosen = np.ones(len(part), dtype=bool)
        if "where" in clauses:
            chosen &= points.select(clauses["where"].value)
        if "in" in clauses:
            chosen &= points.with_ids(clauses["in"].value, placed.drawing.body.name, kind[:-1])
        if not chosen.any():
            wanted = (
                clauses["where"].value.span.one_line if "where" in clauses else "such an id"
            )
            self.findings.reject(
                "TIS302",
                f'the set "{item.name.text}" is empty: '
                f"no {kind[:-1]} of {placed.drawing.body.name} has {wanted}",
                item.name.span,
                hint=extents(placed.drawing.mesh.position),
            )
        return NamedSet(Group(item.name.text, part[chosen]), kind == "springs")

    def _named_body(self, node: s.Expression) -> Placed:
        if isinstance(node, s.Name) and node.key in self.bodies:
            return self.bodies[node.key]
        self.findings.pass_over_doubtful(s.key_of(node.span.text))
        names = [placed.drawing.body.name for placed in self.bodies.values()]
        self.findings.reject(
            "TIS301",
            f'there is no body called "{node.span.text}"',
            node.span,
            hint=alternatives(node.span.text, names, what="bodies"),
        )

    def _union(self, item: s.Assign, listing: s.Listing) -> NamedSet:
        if item.clauses:
            self.findings.reject(
                "TIS303", "a union of sets takes no further words", item.clauses[0].span
            )
        parts: list[Group] = []
        kinds: set[bool] = set()
        for part in listing.items:
            if not isinstance(part, s.Name):
                self.findings.reject(
                    "TIS312", "a union lists names of sets or bodies", part.span
                )
            kinds.add(self.is_springs(part))
            parts.append(self.springs(part) if self.is_springs(part) else self.nodes(part))
        if len(kinds) != 1:
            self.findings.reject(
                "TIS314", "a union is of nodes or of springs, not of both", listing.span
            )
        return NamedSet(
            Group(item.name.text, np.unique(np.concatenate([part.indices for part in parts]))),
            kinds.pop(),
        )


def unnamed(kind: str, span: Span, findings: Findings) -> NoReturn:
    """Reject a set that is described where its name belongs: ``fix nodes of vessel``."""
    findings.reject(
        "TIS301",
        f'"{kind} of …" stands where the name of a set belongs',
        span,
        hint=f"declare a set first: set NAME = {kind} of …",
    )


def points_of(body: Drawing, scope: Scope, *, of_springs: bool) -> PointScope:
    """Return the nodes of a body as points, or the middles of its springs."""
    mesh = body.mesh
    surface = surface_mask(mesh)
    if not of_springs:
        return PointScope(
            scope,
            mesh.position,
            ids=body.columns.node_ids,
            regions=body.regions,
            surface=surface,
            groups=group_masks(mesh),
        )
    ends = mesh.position[mesh.ends]

    def inside(nodes: Mask) -> Mask:
        return np.asarray(nodes[mesh.ends].all(axis=1))

    return PointScope(
        scope,
        ends.mean(axis=1),
        ids=body.columns.spring_ids,
        length=np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1),
        regions={name: inside(nodes) for name, nodes in body.regions.items()},
        surface=None if surface is None else inside(surface),
        bends=body.bends,
        groups={name: inside(nodes) for name, nodes in group_masks(mesh).items()},
    )
