"""What a learn block adjusts: a tissue, a force, or nodes and springs that have a name."""

from collections.abc import Iterator, Sequence
from typing import NoReturn

import numpy as np
from msgspec import Struct

from tissuec.compiler.selections import Mask
from tissuec.compiler.sets import Groups, PlacedBody
from tissuec.core.hints import alternatives
from tissuec.lang import syntax as s
from tissuec.model.network import Indices
from tissuec.scene.model import Scene, Tissue, WrittenForce


class Target(Struct, frozen=True, eq=False):
    """Nodes and springs of a set, body, joint or region.

    Attributes:
        nodes: None where there are springs alone.
        body: Where it is a whole body.
    """

    name: str
    nodes: Indices | None
    springs: Indices
    body: PlacedBody | None = None


class Targets:
    """Finds the meaning of names after ``of``."""

    def __init__(self, scene: Scene, groups: Groups):
        self.scene, self.groups, self.findings = scene, groups, groups.findings

    def tissue(self, name: s.Name) -> Tissue | None:
        """Return the tissue of a name, if there is one; rejects one that nothing is made of."""
        if name.key not in self.scene.declarations.of("tissue"):
            return None
        if name.key not in self.scene.tissues:
            self.findings.stop()  # it was found wrong itself
        tissue = self.scene.tissues[name.key]
        used = {one.name: one for one in self._used()}
        if tissue.name not in used and self._is_whole:
            self.findings.reject(
                "TIS801",
                f"no body is made of {tissue.name}, so the data cannot determine it",
                name.span,
                hint=alternatives(tissue.name, used, what="tissues in use"),
            )
        return tissue

    def force(self, name: s.Name) -> WrittenForce | None:
        """Return the force of a name, if there is one."""
        if name.key not in self.scene.declarations.of("force"):
            return None
        if name.key not in self.scene.forces:
            self.findings.stop()  # it was found wrong itself
        return self.scene.forces[name.key]

    @property
    def _is_whole(self) -> bool:
        declared = self.scene.declarations
        if any(map(self.findings.may_be_misspelt, ("body", "joint"))):
            return False
        return len(self.scene.bodies) == len(declared.of("body")) and len(
            self.scene.joints
        ) == len(declared.of("joint"))

    def _used(self) -> Iterator[Tissue]:
        """Yield the tissues that bodies, regions and joints are made of."""
        for body in self.scene.bodies.values():
            yield from body.tissues
        yield from (joint.tissue for joint in self.scene.joints.values())

    def group(self, names: Sequence[s.Name]) -> Target | None:
        """Return the set, body, joint or region of one or two names; None if there is none."""
        name = names[0]
        if len(names) > 1:
            return self._region(name.key, names[1].key)
        if name.key in self.groups.bodies:
            body = self.groups.bodies[name.key]
            return Target(body.drawing.body.name, body.nodes, self._springs(name), body)
        if self.groups.is_known(name):
            nodes = None
            if not self.groups.is_springs(name):
                nodes = self.groups.nodes(name).indices
            return Target(self.groups.springs(name).name, nodes, self._springs(name))
        region, _, body = name.key.partition(" of ")
        return self._region(region, body)

    def _region(self, region: str, body: str) -> Target | None:
        """Return a region; of any body, if only one has it and none is named."""
        found = [
            (placed, one)
            for key, placed in self.groups.bodies.items()
            for one in placed.drawing.body.regions
            if s.key_of(one.name) == region and body in ("", key)
        ]
        if len(found) != 1:
            return None
        placed, one = found[0]
        nodes = placed.nodes[placed.drawing.regions[region]]
        name = f"{one.name} of {placed.drawing.body.name}"
        springs = self.groups.own_springs(self.groups.springs_inside(nodes))
        return Target(name, nodes, springs)

    def _springs(self, name: s.Name) -> Indices:
        """Return the springs of a set, body or joint, shape (n,)."""
        return self.groups.own_springs(self.groups.springs(name).indices)

    def unknown(self, names: Sequence[s.Name], *, with_tissues: bool) -> NoReturn:
        """Reject a name of nothing that could be adjusted."""
        text = " of ".join(name.text for name in names)
        for name in names:
            self.findings.pass_over_doubtful(name.key)
        known = self.groups.names_of_sets()
        known += [*self.groups.names_of_parts(), *self._regions()]
        kinds = "sets, bodies and regions"
        kind = "set, body or region"
        if with_tissues:
            whole = (*self.scene.tissues.values(), *self.scene.forces.values())
            known = [*(one.name for one in whole), *known]
            kinds, kind = f"tissues, forces, {kinds}", f"tissue, force, {kind}"
        self.findings.reject(
            "TIS301",
            f'there is no {kind} called "{text}"',
            names[0].span.to(names[-1].span),
            hint=alternatives(text, known, what=kinds),
        )

    def _regions(self) -> list[str]:
        return [
            f"{region.name} of {placed.drawing.body.name}"
            for placed in self.groups.bodies.values()
            for region in placed.drawing.body.regions
        ]

    def bodies_of(self, tissue: Tissue) -> Iterator[PlacedBody]:
        """Yield the bodies that have nodes of a tissue."""
        return (
            placed for placed in self.groups.bodies.values() if _inside(placed, tissue).any()
        )

    def parts_of(self, tissue: Tissue) -> tuple[Indices, Indices]:
        """Return the nodes of a tissue, and the springs with an end in it.

        Both are ascending, of shape (n,).
        """
        nodes, springs = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
        for placed in self.groups.bodies.values():
            inside = _inside(placed, tissue)
            nodes.append(placed.nodes[inside])
            lines = placed.lines(self.groups.spring_count)
            lines = lines[inside[placed.drawing.mesh.ends].any(axis=1)]
            springs.append(self.groups.own_springs(lines))
        for key, joint in self.scene.joints.items():
            if joint.tissue is tissue and key in self.groups.joints:
                springs.append(self.groups.joints[key].lines(self.groups.spring_count))
        return np.concatenate(nodes), np.concatenate(springs)


def _inside(placed: PlacedBody, tissue: Tissue) -> Mask:
    """Return which nodes of a body are of a tissue, shape (node,)."""
    drawing = placed.drawing
    made = (drawing.body.tissue, *(region.tissue for region in drawing.body.regions))
    own = [(one or drawing.body.tissue) is tissue for one in made]
    return np.array(own)[drawing.part]
