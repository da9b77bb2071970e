"""Sets: names for nodes or springs, chosen on the drawn mesh and fixed for good."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import NoReturn

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.bodies.drawn import Drawing, points_of
from tissuec.compiler.selections import (
    PointScope,
    extents,
    places_near,
    warn_of_idle_alternatives,
)
from tissuec.core.arrays import distinct
from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.lang.words import written_name
from tissuec.model.network import Floats, Indices
from tissuec.results.recording import NamedGroup
from tissuec.scene.program.declarations import Declarations, Declared
from tissuec.scene.program.dependency_order import Definitions
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.sentences import (
    KINDS,
    ChosenNodes,
    ChosenSprings,
    SetWords,
    UnionWords,
    read_set,
)
from tissuec.script.verbs import VERBS, Group


class PlacedBody(Struct, frozen=True, eq=False, dict=True):
    """A body with the numbers of its first node and line in the network.

    It has its arrays once, however many sentences name it. Edges of elements are counted behind
    all springs, those of joints, too.

    Attributes:
        size: How many nodes it has in the network, copies of all in reserve for cuts included.
    """

    drawing: Drawing
    first_node: int
    first_line: int
    size: int

    @cached_property
    def nodes(self) -> Indices:
        """Return the numbers of its nodes in the network, shape (node,)."""
        return np.arange(len(self.drawing.mesh.position)) + self.first_node

    def lines(self, springs: int) -> Indices:
        """Return the numbers of its springs or edges in the network, shape (line,).

        Args:
            springs: How many the network has.
        """
        first = self.first_line + (springs if self.drawing.is_elements else 0)
        return np.arange(len(self.drawing.mesh.ends)) + first

    @property
    def ends(self) -> NDArray[np.int32]:
        """Return the nodes of each line in the network, shape (line, 2)."""
        return self.drawing.mesh.ends + np.int32(self.first_node)


class PlacedJoint(Struct, frozen=True, eq=False):
    """A joint with the numbers that its springs and their nodes have in the network.

    Attributes:
        ends: Nodes of each spring, shape (spring, 2).
    """

    drawing: Drawing
    ends: NDArray[np.int32]
    first_line: int

    def lines(self, springs: int) -> Indices:
        """Return the numbers of its springs in the network, shape (spring,)."""
        return np.arange(len(self.ends)) + self.first_line


class Groups:
    """All sets, bodies and joints by name; each set is chosen once, on first use."""

    def __init__(
        self, declarations: Declarations, bodies: Mapping[str, PlacedBody], scope: Scope
    ):
        self.declared = dict(declarations.of("set"))
        self.bodies = bodies
        self.named_joints = declarations.of("joint")
        self.joints: dict[str, PlacedJoint] = {}
        self.scope = scope
        self.findings = scope.findings
        self._said: dict[str, SetWords | None] = {}  # None if it was rejected
        self.sets = Definitions("sets", self._needs, self._choose, scope.findings)
        self.used: set[str] = set()
        self.inside: dict[str, Indices] = {}
        of_springs = (one for one in bodies.values() if not one.drawing.is_elements)
        self.spring_count = sum(len(placed.drawing.mesh.ends) for placed in of_springs)

    def add_joints(self, joints: Sequence[tuple[Drawing, NDArray[np.int32]]]) -> None:
        """Add joints with the node pairs of their springs, shape (spring, 2), at the end."""
        for drawing, ends in joints:
            key = s.key_of(drawing.body.name)
            self.joints[key] = PlacedJoint(drawing, ends, self.spring_count)
            self.spring_count += len(ends)

    @cached_property
    def position(self) -> Floats:
        """Return the places of the nodes of all bodies [m], shape (node, 3).

        Nodes in reserve get the drawn places in turn.
        """
        bodies = self.bodies.values()
        found = (np.resize(one.drawing.mesh.position, (one.size, 3)) for one in bodies)
        return np.concatenate([np.zeros((0, 3)), *found])

    def has_elements(self, nodes: Indices) -> bool:
        """Return whether any of some nodes belongs to a body that consists of elements.

        Args:
            nodes: Indices in the network, shape (n,).
        """
        solids = (placed for placed in self.bodies.values() if placed.drawing.mesh.elements)
        return any(np.isin(placed.nodes, nodes).any() for placed in solids)

    def has_whole_elements(self, nodes: Indices) -> bool:
        """Return whether all nodes of any element are among some nodes, shape (n,)."""
        for placed in self.bodies.values():
            inside = np.isin(placed.nodes, nodes)
            if any(inside[one.nodes].all(axis=1).any() for one in placed.drawing.mesh.elements):
                return True
        return False

    def names_of_bodies(self) -> list[str]:
        """Return the names of all bodies."""
        return [placed.drawing.body.name for placed in self.bodies.values()]

    def names_of_sets(self) -> list[str]:
        """Return the names of all sets."""
        return [declared.name.text for declared in self._with_names()]

    def names_of_parts(self) -> list[str]:
        """Return the names of all bodies and joints."""
        joints = (declared.name.text for declared in self.named_joints.values())
        return [*self.names_of_bodies(), *joints]

    def joined_already(self, pairs: NDArray[np.int32]) -> int:
        """Return how many node pairs, shape (pair, 2), are joined by a spring of their body."""
        count = len(self.position)
        springs = [_numbered(placed.ends, count) for placed in self.bodies.values()]
        every = np.concatenate([np.zeros(0, dtype=np.int64), *springs])
        return int(np.isin(_numbered(pairs, count), every).sum())

    def own_springs(self, lines: Indices) -> Indices:
        """Return which of some lines, shape (n,), are springs and no edges of elements."""
        return lines[lines < self.spring_count]

    def choose_all(self) -> None:
        """Choose every set, so that mistakes in unused ones are reported too."""
        for key in self.declared:
            with self.findings.item():
                self.sets.find(key)

    def named(self) -> Iterator[NamedGroup]:
        """Yield all sets, and the regions of all bodies, as results keep them."""
        for key, declared in self.declared.items():
            if declared.name.listed:
                continue  # a union without a name of its own
            if (chosen := self.sets.values.get(key)) is not None:
                yield NamedGroup(chosen.name, KINDS[chosen.are_lines], chosen.indices)
        for placed in self.bodies.values():
            body, masks = placed.drawing.body, placed.drawing.regions
            for region in body.regions:
                nodes = placed.nodes[masks[s.key_of(region.name)]]
                yield NamedGroup(region.name, KINDS[0], nodes, body.name)

    def is_known(self, name: s.Name) -> bool:
        """Return whether a name is a set, a body or a joint, or all names of a union are."""
        if name.listed:
            return all(map(self.is_known, name.listed))
        return any(name.key in kind for kind in (self.declared, self.bodies, self.joints))

    def nodes(self, name: s.Name) -> Group:
        """Return the nodes of a set of nodes or of a body, or of a union of them."""
        self._enter_union(name)
        if name.key in self.bodies:
            return Group(self._body(name), self.bodies[name.key].nodes)
        if name.key in self.named_joints:
            self._refuse_joint(name, "name one of the sets or bodies that it joins")
        if self._says_springs(name) or self._find(name).are_lines:
            self.findings.reject(
                "TIS314",
                f'"{name.text}" is a set of springs, but nodes are needed here',
                name.span,
                hint=f"write set {name.text} = nodes of …, or define another set of nodes",
            )
        return self._find(name)

    def both(self, names: tuple[s.Name, s.Name]) -> tuple[Group, Group]:
        """Return the nodes of the sets or bodies on both sides; mistakes in both are found."""
        sides: list[Group] = []
        with self.findings.together():
            for name in names:
                with self.findings.item():
                    sides.append(self.nodes(name))
        first, second = sides
        return first, second

    def _says_springs(self, name: s.Name) -> bool:
        """Return whether a name is declared as springs of something, without choosing them."""
        return name.key in self.declared and isinstance(self._read(name.key), ChosenSprings)

    def springs(self, name: s.Name) -> Group:
        """Return the springs of a set of springs, a body or joint, or inside a set of nodes."""
        self._enter_union(name)
        if name.key in self.bodies:
            return Group(
                self._body(name), self.bodies[name.key].lines(self.spring_count), are_lines=True
            )
        if name.key in self.joints:
            joint = self.joints[name.key]
            return Group(
                joint.drawing.body.name, joint.lines(self.spring_count), are_lines=True
            )
        chosen = self._find(name, with_joints=True)
        if chosen.are_lines:
            return chosen
        if name.key not in self.inside:
            self.inside[name.key] = self.springs_inside(chosen.indices)
        return Group(chosen.name, self.inside[name.key], are_lines=True)

    def _enter_union(self, name: s.Name) -> None:
        """Make ``[A, B]`` a set like those that have names."""
        if name.listed and name.key not in self.declared:
            listing = s.Listing(name.listed, name.span)
            item = s.Assign("set", name, listing, None, (), name.span)
            self.declared[name.key] = Declared(name, item)

    def _body(self, name: s.Name) -> str:
        """Return the name of a body as it was declared, however it is spelt here."""
        return self.bodies[name.key].drawing.body.name

    def is_springs(self, name: s.Name) -> bool:
        """Return whether a name is a set of springs or a joint, or a union of such."""
        self._enter_union(name)
        if name.key in self.joints:
            return True
        return name.key in self.declared and self._find(name).are_lines

    def springs_inside(self, nodes: Indices) -> Indices:
        """Return the springs, shape (m,), with both ends among the nodes, shape (n,)."""
        found = [
            placed.lines(self.spring_count)[np.isin(placed.ends, nodes).all(axis=1)]
            for placed in (*self.bodies.values(), *self.joints.values())
        ]
        return np.sort(np.concatenate(found)) if found else np.zeros(0, dtype=np.int64)

    def _find(self, name: s.Name, *, with_joints: bool = False) -> Group:
        if name.key not in self.declared:
            self.findings.pass_over_doubtful(name.key)
            if name.key in KINDS:
                unnamed(name.key, name.span, self.findings)
            self.refuse_parted(name)
            lines = {d.name.text: d.name.span.line for d in self._with_names()}
            known, what = [*lines, *self.names_of_bodies()], "sets and bodies"
            if with_joints and self.named_joints:
                known, what = [*lines, *self.names_of_parts()], "sets, bodies and joints"
            known = [*map(written_name, known)]
            hint = alternatives(name.text, known, what=what)
            for text, line in lines.items():
                near = f'did you mean "{text}"'
                hint = Hint(hint.replace(f"{near}?", f"{near} (line {line})?"), *hint.edits)
            message = f'there is no set called "{name.text}"'
            self.findings.reject("TIS301", message, name.span, hint=hint)
        self.used.add(name.key)
        return self.sets.find(name.key)

    def refuse_parted(self, name: s.Name, tools: Iterable[str] = ()) -> None:
        """Reject a text that is no name because of its end or of another sentence.

        Args:
            name: The name, which is not known.
            tools: Names of tools, which are known here, too.
        """
        known = [*(d.name.text for d in self._with_names()), *self.names_of_parts(), *tools]
        text, start = name.span.source.text, name.span.start
        for one in known:
            end = start + len(one)
            if written_name(one) != one and text[start:end].lower() == one.lower():
                hint = Hint(
                    f'write the name in quotes: "{one}"',
                    Edit(f'"{one}"', Span(name.span.source, start, end)),
                )
                message = f'"{one}" contains a reserved word'
                self.findings.reject(
                    "TIS115", message, Span(name.span.source, start, end), hint=hint
                )
        words, keys = name.words.split(" "), {s.key_of(one) for one in known}
        for number in range(1, len(words)):
            head = " ".join(words[:number])
            if words[number].lower() in VERBS and s.key_of(head) in keys:
                place = Span(name.span.source, start + len(head), start + len(head))
                hint = Hint(
                    f'put ";" or a line break before "{words[number]}"', Edit(";", place)
                )
                verb = name.span.text.find(words[number], len(head))
                second = Span(name.span.source, start + verb, start + verb + len(words[number]))
                self.findings.reject("TIS107", "two statements on one line", second, hint=hint)

    def _with_names(self) -> list[Declared]:
        """Return the sets that have names of their own."""
        return [one for one in self.declared.values() if not one.name.listed]

    def _needs(self, key: str) -> Iterator[s.Name]:
        """Yield the sets in a union."""
        said = self._read(key)
        for name in said.union.listed if isinstance(said, UnionWords) else ():
            if name.key in self.declared:
                yield name

    def _read(self, key: str) -> SetWords | None:
        """Return the sentence of a set; None if it was rejected."""
        if key not in self._said:
            item = self.declared[key].item
            assert isinstance(item, s.Assign)
            self._said[key] = None
            with self.findings.item():
                self._said[key] = read_set(item, self.scope)
        return self._said[key]

    def _choose(self, key: str) -> Group:
        said = self._read(key)
        if said is None:
            self.findings.stop()
        if isinstance(said, UnionWords):
            return self._union(said)
        of_springs = isinstance(said, ChosenSprings)
        placed = [self._named_part(name, of_springs=of_springs) for name in said.of]
        points = [points_of(one.drawing, self.scope, of_springs=of_springs) for one in placed]
        found = [
            self._chosen_of(one, own, said) for one, own in zip(placed, points, strict=True)
        ]
        names = " or ".join(one.drawing.body.name for one in placed)
        missing = f"no {said.kind[:-1]} of {names} has"
        if not any(map(len, found)):
            hint = extents(np.concatenate([one.drawing.mesh.position for one in placed]))
            wanted = "such an id"
            if said.where is not None:
                wanted = said.where.span.one_line
                hint = hint if of_springs else places_near(said.where, points)
            self.findings.reject(
                "TIS302",
                f'the set "{said.name.text}" is empty: {missing} {wanted}',
                said.name.span,
                hint=hint,
            )
        if said.where is not None:
            of = f"the set {said.name.text}"
            warn_of_idle_alternatives(said.where, points, missing=missing, of=of)
        return Group(said.name.text, distinct(np.concatenate(found)), are_lines=of_springs)

    def _chosen_of(
        self,
        placed: PlacedBody | PlacedJoint,
        points: PointScope,
        said: ChosenNodes | ChosenSprings,
    ) -> Indices:
        """Return the nodes or springs of a body or joint that a set contains.

        Args:
            points: All nodes or springs of it.
        """
        of_springs = isinstance(said, ChosenSprings)
        is_joint = isinstance(placed, PlacedJoint)
        part = placed.nodes if not (is_joint or of_springs) else placed.lines(self.spring_count)
        chosen = np.ones(len(part), dtype=bool)
        if said.where is not None:
            chosen &= points.select(said.where)
        if said.ids is not None:
            chosen &= points.with_ids(said.ids, placed.drawing.body.name, said.kind[:-1])
        return part[chosen]

    def _named_part(self, name: s.Name, *, of_springs: bool) -> PlacedBody | PlacedJoint:
        """Return the body, or where springs are chosen the joint, of a name."""
        if name.key in self.bodies:
            return self.bodies[name.key]
        if of_springs and name.key in self.joints:
            return self.joints[name.key]
        self.findings.pass_over_doubtful(name.key)
        if name.key in self.named_joints:
            # Springs are known once all joints are: it is too early within a joint.
            hint = "a joint joins nodes to nodes"
            if not of_springs:
                hint = f"write springs of {name.text}, or nodes of a body"
            self._refuse_joint(name, hint)
        known = self.names_of_parts() if of_springs else self.names_of_bodies()
        what = "bodies and joints" if of_springs and self.named_joints else "bodies"
        self.findings.reject(
            "TIS301",
            f'there is no body called "{name.text}"',
            name.span,
            hint=alternatives(name.text, known, what=what),
        )

    def _refuse_joint(self, name: s.Name, hint: str) -> NoReturn:
        message = f'"{name.text}" is a joint, which has springs only; nodes are needed here'
        self.findings.reject("TIS314", message, name.span, hint=hint)

    def _union(self, said: UnionWords) -> Group:
        parts: list[Group] = []
        kinds: set[bool] = set()
        for part in said.union.listed:
            kinds.add(self.is_springs(part))
            parts.append(self.springs(part) if self.is_springs(part) else self.nodes(part))
        if len(kinds) != 1:
            message = "a union cannot mix nodes and springs"
            self.findings.reject("TIS314", message, said.union.span)
        every = distinct(np.concatenate([part.indices for part in parts]))
        return Group(said.name.text, every, are_lines=kinds.pop())


def _numbered(pairs: NDArray[np.int32], count: int) -> Indices:
    """Return a number for each pair of nodes, whatever their order, shape (pair,)."""
    low, high = np.sort(pairs.astype(np.int64), axis=1).T
    return low * count + high


def unnamed(kind: str, span: Span, findings: Findings) -> NoReturn:
    """Reject a set that is described in place of its name: ``fix nodes of vessel``.

    Args:
        kind: "nodes" or "springs".
    """
    findings.reject(
        "TIS301",
        f'the name of a set is needed, not "{kind} of …"',
        span,
        hint=f"define a set first: set NAME = {kind} of …",
    )
