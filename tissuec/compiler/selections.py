"""Conditions over the nodes or springs of a body: ``x < 1 mm and region is cover``."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.arrays import SAME_PLACE, largest_side
from tissuec.core.errors import Note, counted
from tissuec.core.hints import alternatives
from tissuec.core.units import LENGTH, NUMBER
from tissuec.lang import syntax as s
from tissuec.meshes.generators import Mesh
from tissuec.model.network import Floats, Indices
from tissuec.scene.model import Region
from tissuec.scene.reading.expressions import InnerScope, Scope, Truth
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.values import Value

Mask: TypeAlias = NDArray[np.bool_]


class Criterion(Struct, frozen=True):
    """What nodes or springs are chosen by, after ``where``.

    Attributes:
        about: What it is, in one sentence.
        of: What has it; nothing for both.
        is_test: Whether it is a test, and no number.
        form: How a test is written, if not by its name alone.
    """

    about: str
    of: Literal["nodes", "springs", ""] = ""
    is_test: bool = False
    form: str = ""


CRITERIA = {
    "x": Criterion("First coordinate of a node, or of the middle of a spring, as drawn."),
    "y": Criterion("Second coordinate of a node, or of the middle of a spring, as drawn."),
    "z": Criterion("Third coordinate of a node, or of the middle of a spring, as drawn."),
    "id": Criterion("Id of a node or spring."),
    "length": Criterion("Drawn length of a spring.", "springs"),
    "region": Criterion("Region of the body.", is_test=True, form="region is NAME"),
    "group": Criterion("Group of the mesh file.", "nodes", True, 'group is "NAME"'),
    "surface": Criterion("True on the surface of the mesh.", "nodes", True),
    "bending": Criterion("True for springs that resist bending only.", "springs", True),
}


class PointScope(InnerScope):
    """A scope in which x, y and z are the coordinates of many points.

    Args:
        constants: Scope of the scene's own numbers.
        position: The points [m], shape (point, 3).
        size: Largest side of what is drawn [m]; by default, of the box around the points.
        ids: Ids of the author, shape (point,); None where nothing has ids yet.
        length: Lengths of springs [m], shape (point,); None for nodes.
        regions: Membership of each point in each region, by key of its name.
        surface: Which points lie on the surface, shape (point,); None where there is none.
        bends: Which springs resist bending only, shape (point,); None for nodes.
        groups: Membership of each point in each group of the mesh file, by its name there.
    """

    def __init__(
        self,
        constants: Scope,
        position: Floats,
        *,
        size: float | None = None,
        ids: Indices | None = None,
        length: Floats | None = None,
        regions: Mapping[str, Mask] | None = None,
        surface: Mask | None = None,
        bends: Mask | None = None,
        groups: Mapping[str, Mask] | None = None,
    ):
        super().__init__(constants)
        self.position = position
        self.size = largest_side(position) if size is None else size
        self.columns = {
            name: Value(position[:, axis], LENGTH) for axis, name in enumerate("xyz")
        }
        if ids is not None:
            self.columns["id"] = Value(ids.astype(float), NUMBER)
        if length is not None:
            self.columns["length"] = Value(length, LENGTH)
        self.regions = regions or {}
        self.surface, self.bends = surface, bends
        self.groups = groups or {}

    def name(self, name: s.Name) -> Value:
        if name.key in self.columns:
            return self.columns[name.key]
        if self.constants.has(name):
            return self.constants.name(name)
        return self.unknown(name)

    def has(self, name: s.Name) -> bool:
        return name.key in self.columns or self.constants.has(name)

    def names(self) -> Sequence[str]:
        return (*self.columns, *self.constants.names())

    def rounding(self, left: Value, right: Value) -> float:
        if not (left.is_many or right.is_many):
            return 0.0
        power = left.dimension.length
        if power <= 0.0 or left.dimension != LENGTH**power:
            sizes = (np.abs(one.amount).max(initial=0.0) for one in (left, right))
            return SAME_PLACE * float(max(sizes))
        return self.near * max(self.size, self.far) ** (power - 1.0)

    @cached_property
    def far(self) -> float:
        """Return the largest coordinate [m]."""
        return float(np.abs(self.position).max(initial=0.0))

    @property
    def near(self) -> float:
        """Return the distance below which places are the same [m]."""
        # Coordinates far from the origin are rounded by more.
        return SAME_PLACE * self.size + 8.0 * np.finfo(float).eps * self.far

    def test(self, node: s.Expression) -> Truth:
        match node:
            case s.Within(subject=None):
                return self._within(node)
            case s.Is(subject=s.Name(words="region")):
                return self._in_region(node)
            case s.Is(subject=s.Name(words="group", quoted=None)):
                return self._in_group(node)
            case s.Name() if node.key == "surface":
                if self.surface is None:
                    self.findings.reject(
                        "TIS302",
                        "this mesh has no surface",
                        node.span,
                        hint="select nodes by position or id",
                    )
                return self.surface
            case s.Name() if node.key == "bending" and self.bends is not None:
                return self.bends
            case _:
                return super().test(node)

    def select(self, condition: s.Expression) -> Mask:
        """Return which points meet a condition, shape (point,)."""
        return np.broadcast_to(self.decide(condition), len(self.position)).astype(bool)

    def with_ids(self, node: s.Expression, body: str, what: str) -> Mask:
        """Return which points have one of the listed ids, shape (point,).

        Args:
            node: The expression after ``in``.
            body: Name of the body, for messages.
            what: "node" or "spring".
        """
        if not isinstance(node, s.Listing):
            self.findings.reject("TIS312", "write ids as a list: in [1, 2, 3]", node.span)
        if "id" not in self.columns:
            self.findings.reject(
                "TIS302",
                f"ids of {what}s are those of the written mesh of {body}, not of a finer one",
                node.span,
                hint=f"select {what}s by position, such as where x < 1 mm",
            )
        ids = self.columns["id"].amount
        chosen = np.zeros(len(ids), dtype=bool)
        for item in node.items:
            value = self.constants.number(item)
            self.expect(value, NUMBER, item.span, what="an id")
            hit = ids == float(value.amount)
            if not hit.any():
                self.findings.reject(
                    "TIS302",
                    f"{body} has no {what} with id {float(value.amount):g}",
                    item.span,
                    hint=f"ids run from {ids.min():.0f} to {ids.max():.0f}"
                    if len(ids)
                    else "it has none",
                )
            chosen |= hit
        return chosen

    def _within(self, node: s.Within) -> Truth:
        radius, centre = self.number(node.radius), self.evaluate(node.centre)
        self.expect(radius, LENGTH, node.radius.span, what="the radius")
        if not centre.is_vector:
            self.findings.reject(
                "TIS312", "the centre must be a point: (x, y, z) mm", node.centre.span
            )
        if np.any(centre.amount):
            self.expect(centre, LENGTH, node.centre.span, what="the centre")
        distance = np.linalg.norm(self.position - centre.amount, axis=1)
        return distance <= radius.amount + self.near

    def _in_region(self, node: s.Is) -> Truth:
        result = np.zeros(len(self.position), dtype=bool)
        if node.phrase.kind == "between":
            self.findings.reject("TIS312", "write one name of a region", node.phrase.span)
        for name in node.phrase.words:
            if name.key not in self.regions:
                self.findings.pass_over_doubtful(name.key)
                self.findings.reject(
                    "TIS301",
                    f'there is no region called "{name.text}"',
                    name.span,
                    hint=alternatives(name.key, self.regions, what="regions")
                    or "the body has no regions",
                )
            result |= self.regions[name.key]
        return ~result if node.phrase.kind == "not" else result

    def _in_group(self, node: s.Is) -> Truth:
        if node.phrase.kind == "between":
            self.findings.reject("TIS312", "write one name of a group", node.phrase.span)
        name = node.phrase.words[0]
        alike = [group for group in self.groups if s.key_of(group) == name.key]
        if name.text in self.groups:
            alike = [name.text]
        if len(alike) != 1:
            self.findings.reject(
                "TIS301",
                f'there is no group called "{name.text}"',
                name.span,
                hint=alternatives(name.text, self.groups, what="groups of the mesh")
                or "groups come from a mesh file; this mesh has none",
            )
        inside = self.groups[alike[0]]
        return ~inside if node.phrase.kind == "not" else inside


def idle_alternatives(
    condition: s.Expression, points: Sequence[PointScope]
) -> Iterator[s.Expression]:
    """Yield the operands of ``or`` in a condition that no point meets.

    Args:
        condition: What is written after ``where``.
        points: All that it selects from.
    """
    match condition:
        case s.Or(operands=operands):
            for one in operands:
                if any(some.select(one).any() for some in points):
                    yield from idle_alternatives(one, points)
                else:
                    yield one
        case s.And(operands=operands):
            for one in operands:
                yield from idle_alternatives(one, points)
        case s.Not(operand=operand):
            yield from idle_alternatives(operand, points)
        case _:
            pass


def warn_of_idle_alternatives(
    condition: s.Expression, points: Sequence[PointScope], *, missing: str, of: str
) -> None:
    """W311: parts of a condition that select nothing, while others do.

    Args:
        condition: What is written after ``where``.
        points: All that it selects from.
        missing: What has no such place, for the message: "no node of block has".
        of: What the condition belongs to, such as "the set marks".
    """
    for one in idle_alternatives(condition, points):
        points[0].findings.add(
            "W311",
            f"{missing} {one.span.one_line}: this part of {of} selects nothing",
            one.span,
            hint=places_near(one, points),
        )


def refuse_overlap(
    regions: Sequence[Region], inside: Sequence[Mask], what: str, findings: Findings
) -> None:
    """Reject a region that has something in common with one before it.

    Args:
        regions: Of a body.
        inside: What belongs to each of the first ones, up to the region; shape (item,) each.
        what: "node" or "element".
    """
    region = regions[len(inside) - 1]
    for other, others in zip(regions, inside[:-1], strict=False):
        if common := int((inside[-1] & others).sum()):
            findings.reject(
                "TIS311",
                f"regions {other.name} and {region.name} share {counted(common, what)}",
                region.span,
                hint=f"append to one of them: and not ({other.where.span.one_line}), or change "
                "the limits",
                notes=(Note("the other region", other.span),),
            )


def places_near(condition: s.Expression, points: Sequence[PointScope]) -> str:
    """Return the coordinates next to one that no point has, or the extents; for messages.

    Args:
        condition: What no point meets.
        points: Those it was to select from.
    """
    position = np.concatenate([one.position for one in points])
    match condition:
        case s.Compare(left=s.Name(key="x" | "y" | "z") as axis, sign="==", right=right):
            wanted = points[0].number(right).amount
            column = position[:, "xyz".index(axis.key)]
            below, above = column[column < wanted], column[column > wanted]
            if len(below) and len(above):
                first, last = (units.show(one, LENGTH) for one in (below.max(), above.min()))
                return f"the nearest have {axis.key} == {first} and {axis.key} == {last}"
        case _:
            pass
    return extents(position)


def surface_mask(mesh: Mesh) -> Mask | None:
    """Return which nodes lie on the skin, shape (node,); None where there is none."""
    if not len(mesh.skin):
        return None
    mask = np.zeros(len(mesh.position), dtype=bool)
    mask[mesh.skin.ravel()] = True
    return mask


def group_masks(mesh: Mesh) -> dict[str, Mask]:
    """Return which nodes belong to each group of a file, shape (node,), by its name."""
    masks: dict[str, Mask] = {}
    for name, nodes in mesh.groups.items():
        masks[name] = np.zeros(len(mesh.position), dtype=bool)
        masks[name][nodes] = True
    return masks


def extents(position: Floats) -> str:
    """Return the extents of points, for messages: ``x runs from 2 mm to 66 mm, …``.

    Args:
        position: The points [m], shape (node, 3).
    """
    if not len(position):
        return "the body has no nodes"
    low, high = position.min(axis=0), position.max(axis=0)
    return ", ".join(
        f"{axis} runs from {units.show(a, LENGTH)} to {units.show(b, LENGTH)}"
        for axis, a, b in zip("xyz", low, high, strict=True)
    )
