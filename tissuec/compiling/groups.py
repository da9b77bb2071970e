"""Sets: names for nodes or springs, chosen on the drawn mesh and fixed for good."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissuec.compiling.bodies import BodyArrays
from tissuec.compiling.points import PointScope, extents, plain
from tissuec.core.errors import alternatives
from tissuec.core.units import LENGTH, NUMBER
from tissuec.lang import syntax as s
from tissuec.network import Indices
from tissuec.scene.declarations import Declarations
from tissuec.scene.expressions import Scope
from tissuec.scene.order import Circle, names_in, needed_first
from tissuec.scene.values import Value
from tissuec.verbs import Group


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A body with the numbers of its first node and spring in the network."""

    built: BodyArrays
    first_node: int
    first_spring: int

    @property
    def nodes(self) -> Indices:
        return np.arange(len(self.built.mesh.position)) + self.first_node

    @property
    def springs(self) -> Indices:
        return np.arange(len(self.built.mesh.ends)) + self.first_spring


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
        self.sets: dict[str, NamedSet | None] = {}
        self.used: set[str] = set()
        # Each body and set has its arrays once, however many sentences name it.
        self.whole = {key: (placed.nodes, placed.springs) for key, placed in bodies.items()}
        self.inside: dict[str, Indices] = {}

    def choose_all(self) -> None:
        """Choose every set, so that mistakes in unused ones are reported too."""
        for declared in self.declared.values():
            with self.findings.item():
                self._set(declared.name)

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
        return self.bodies[name.key].built.body.name

    def is_springs(self, name: s.Name) -> bool:
        """Tell whether a name is a set of springs."""
        return name.key in self.declared and self._find(name).of_springs

    def springs_inside(self, nodes: Indices) -> Indices:
        """Return the springs with both ends among the nodes."""
        found = [
            placed.springs[
                np.isin(placed.built.mesh.ends + placed.first_node, nodes).all(axis=1)
            ]
            for placed in self.bodies.values()
        ]
        return np.concatenate(found) if found else np.zeros(0, dtype=np.int64)

    def _find(self, name: s.Name) -> NamedSet:
        if name.key not in self.declared:
            known = [d.name.text for d in self.declared.values()] + [
                p.built.body.name for p in self.bodies.values()
            ]
            lines = {d.name.text: d.name.span.line for d in self.declared.values()}
            hint = alternatives(name.text, known, what="sets and bodies")
            for text, line in lines.items():
                hint = hint.replace(
                    f'did you mean "{text}"?', f'did you mean "{text}" (line {line})?'
                )
            self.findings.reject(
                "TIS301", f'there is no set called "{name.text}"', name.span, hint=hint
            )
        self.used.add(name.key)
        return self._set(name)

    def _set(self, name: s.Name) -> NamedSet:
        if name.key not in self.sets:
            self._work_out(name.key)
        chosen = self.sets[name.key]
        if chosen is None:
            self.findings.stop()
        return chosen

    def _work_out(self, wanted: str) -> None:
        """Choose a set after those that it is made of; None stands for what was rejected."""
        try:
            order = needed_first(wanted, self._needs)
        except Circle as circle:
            self.sets.update(dict.fromkeys(circle.keys))
            message = f"these sets need one another: {circle}"
            self.findings.reject("TIS506", message, circle.name.span)
        for key in order:
            self.sets[key] = None
            with self.findings.item():
                self.sets[key] = self._choose(self.declared[key].item)

    def _needs(self, key: str) -> Iterator[s.Name]:
        """Yield the sets in a union that are still to be chosen."""
        item = self.declared[key].item
        assert isinstance(item, s.Assign)
        for name in names_in(item.value) if isinstance(item.value, s.Listing) else ():
            if name.key in self.declared and name.key not in self.sets:
                yield name

    def _choose(self, item: s.Item) -> NamedSet:
        assert isinstance(item, s.Assign)
        if isinstance(item.value, s.Listing):
            return self._union(item, item.value)
        clauses = {clause.word: clause for clause in item.clauses}
        kind = item.value.key if isinstance(item.value, s.Name) else ""
        known = {"of", "where", "in"}
        if (
            kind not in ("nodes", "springs")
            or "of" not in clauses
            or len(clauses) < len(item.clauses)
            or set(clauses) - known
        ):
            self.findings.reject(
                "TIS312",
                "a set is written: nodes of BODY where …, springs of BODY where …, nodes of BODY in [1, 2], or [A, B]",
                item.value.span,
            )
        body = clauses["of"].value
        if not isinstance(body, s.Name) or body.key not in self.bodies:
            names = [placed.built.body.name for placed in self.bodies.values()]
            text = clauses["of"].value.span.text
            self.findings.reject(
                "TIS301",
                f'there is no body called "{text}"',
                clauses["of"].value.span,
                hint=alternatives(text, names, what="bodies"),
            )
        placed = self.bodies[body.key]
        of_springs = kind == "springs"
        chosen = np.ones(len(placed.springs if of_springs else placed.nodes), dtype=bool)
        if "where" in clauses:
            chosen &= self._points(placed, of_springs).select(clauses["where"].value)
        if "in" in clauses:
            chosen &= self._by_ids(placed, of_springs, clauses["in"].value)
        if not chosen.any():
            condition = clauses["where"].value.span.text if "where" in clauses else "such an id"
            self.findings.reject(
                "TIS302",
                f'the set "{item.name.text}" is empty: no {kind[:-1]} of {body.text} has {" ".join(condition.split())}',
                item.name.span,
                hint=extents(placed.built.mesh.position),
            )
        first = placed.first_spring if of_springs else placed.first_node
        return NamedSet(Group(item.name.text, np.flatnonzero(chosen) + first), of_springs)

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

    def _by_ids(
        self, placed: Placed, of_springs: bool, node: s.Expression
    ) -> NDArray[np.bool_]:
        if not isinstance(node, s.Listing):
            self.findings.reject("TIS312", "ids are listed: in [1, 2, 3]", node.span)
        ids = placed.built.spring_ids if of_springs else placed.built.node_ids
        chosen = np.zeros(len(ids), dtype=bool)
        for item in node.items:
            value = self.scope.number(item)
            self.scope.expect(value, NUMBER, item.span, what="an id")
            hit = ids == float(value.amount)
            if not hit.any():
                what = "spring" if of_springs else "node"
                span = f"ids run from {ids.min()} to {ids.max()}" if len(ids) else "it has none"
                self.findings.reject(
                    "TIS302",
                    f"{placed.built.body.name} has no {what} with id {float(value.amount):g}",
                    item.span,
                    hint=span,
                )
            chosen |= hit
        return chosen

    def _points(self, placed: Placed, of_springs: bool) -> PointScope:
        built = placed.built
        mesh = built.mesh
        on_surface = np.zeros(len(mesh.position), dtype=bool)
        on_surface[mesh.skin.ravel()] = True
        has_skin = bool(len(mesh.skin))
        if not of_springs:
            return PointScope(
                self.scope,
                mesh.position,
                columns={"id": plain(built.node_ids)},
                regions=built.regions,
                surface=(lambda: on_surface) if has_skin else None,
            )
        ends = mesh.position[mesh.ends]
        length = Value(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), LENGTH)
        return PointScope(
            self.scope,
            ends.mean(axis=1),
            columns={"id": plain(built.spring_ids), "length": length},
            regions={
                name: inside[mesh.ends].all(axis=1) for name, inside in built.regions.items()
            },
            surface=(lambda: on_surface[mesh.ends].all(axis=1)) if has_skin else None,
        )
