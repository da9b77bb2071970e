"""Joints: which nodes they join, and springs between these made of a tissue.

Each node of the side with fewer nodes is joined to the nearest one of the other side, or to all
that are near.
"""

from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.bodies.arrays import check_laws, check_sizes
from tissuec.compiler.bodies.drawn import LARGEST, Drawing
from tissuec.compiler.bodies.tables import ExplicitBody
from tissuec.compiler.materials.cutting_resistance import SpringResistance
from tissuec.compiler.materials.reader import MaterialReader
from tissuec.compiler.sets import Groups
from tissuec.core.errors import counted
from tissuec.core.units import LENGTH, show
from tissuec.meshes.generators import Mesh
from tissuec.model.inelastic import NAMES as INELASTIC
from tissuec.model.network import Floats, Indices, Provenance
from tissuec.model.springs import Springs
from tissuec.scene.model import Body, Joint, Scene
from tissuec.scene.reading.findings import Findings

ALIKE = 1.0 + 1e-9
"""Distances in this ratio count as equal, lest rounding decides which node is the nearest."""


class JointArrays(Struct, frozen=True, eq=False):
    """A joint before it takes its place in the network; fields as in ``Network``."""

    joint: Joint
    drawing: Drawing
    springs: Springs
    memory: dict[str, Floats]  # of springs that relax or yield, by ``model.inelastic.NAMES``
    provenance: dict[str, Provenance]
    resistance: SpringResistance


def build_joints(scene: Scene, groups: Groups, findings: Findings) -> list[JointArrays]:
    """Return the joints of a scene, and add them to ``groups``.

    Args:
        groups: With the bodies; sets of springs of joints are not chosen yet.
    """
    built: list[JointArrays] = []
    for key, declared in scene.declarations.of("joint").items():
        one: JointArrays | None = None
        with findings.item():
            if key in scene.joints:
                one = _build(scene.joints[key], groups, findings)
                built.append(one)
        if one is None and key not in scene.glues:
            findings.doubt(declared.name)
    groups.add_joints([(one.drawing, one.springs.ends) for one in built])
    return built


@np.errstate(all="ignore")  # numbers that leave the range of numbers are found in the end
def _build(joint: Joint, groups: Groups, findings: Findings) -> JointArrays:
    ends = _pairs(joint, groups, findings)
    drawing = _drawing(joint, groups.position[ends])
    reader = MaterialReader(drawing, findings)
    quantities, (law, laws) = reader.read_springs(), reader.laws()
    arrays = {name: values for name, (values, _) in quantities.items()}
    check_sizes(drawing.body, arrays | {"length": drawing.length}, findings)
    check_laws(drawing.body, arrays["rest"], law, laws, findings)
    return JointArrays(
        joint,
        drawing,
        Springs.of(ends, arrays, law, laws, drawing.columns.spring_ids),
        {name: arrays[name] for name in INELASTIC if name in arrays},
        {name: provenance for name, (_, provenance) in quantities.items()},
        reader.resistance(),
    )


def _drawing(joint: Joint, ends: Floats) -> Drawing:
    """Return the springs of a joint as a body that has both ends of each to itself.

    Args:
        ends: Places of the ends [m], shape (spring, 2, 3).
    """
    pairs = np.arange(2 * len(ends), dtype=np.int32).reshape(-1, 2)
    mesh = Mesh(ends.reshape(-1, 3), pairs, np.zeros((0, 3), dtype=np.int32))
    body = Body(
        name=joint.name, tissue=joint.tissue, rupture=joint.rupture, section=joint.section,
        span=joint.span,
    )  # fmt: skip
    part = np.zeros(2 * len(ends), dtype=np.int32)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    columns = ExplicitBody.without_columns(mesh)
    return Drawing(body, mesh, columns, {}, part, length, len(length))


def _pairs(joint: Joint, groups: Groups, findings: Findings) -> NDArray[np.int32]:
    """Return the nodes that a joint joins, shape (spring, 2)."""
    where = joint.ends[0].span.to(joint.ends[1].span)
    first, second = groups.both(joint.ends)
    if common := int(np.isin(first.indices, second.indices).sum()):
        findings.reject(
            "TIS309",
            f"{first.name} and {second.name} share {counted(common, 'node')}, but no node can "
            "be joined to itself",
            where,
            hint="choose sets without common nodes, such as two edges",
        )
    _refuse_too_many(joint, min(len(first.indices), len(second.indices)), findings)
    pairs, distance = nearest_pairs(groups.position, first.indices, second.indices)
    near = distance <= joint.reach * ALIKE
    if not near.any():
        least = show(float(distance.min()), LENGTH)
        findings.reject(
            "TIS302",
            f"joint {joint.name} is empty: the nearest nodes of {first.name} and "
            f"{second.name} are {least} apart",
            where,
            hint="increase reach, or draw them closer together",
        )
    pairs = pairs[near]
    if joint.joins_all:
        pairs = _all_near(joint, groups.position, first.indices, second.indices, findings)
    if again := groups.joined_already(pairs):
        findings.reject(
            "TIS309",
            f"{counted(again, 'pair')} of nodes of {first.name} and {second.name} "
            f"{'has' if again == 1 else 'have'} a spring of their body between them",
            where,
            hint="choose sets that are further apart",
        )
    return pairs


def _all_near(
    joint: Joint, position: Floats, first: Indices, second: Indices, findings: Findings
) -> NDArray[np.int32]:
    """Return the pairs of nodes no further apart than the reach, ascending, shape (pair, 2)."""
    from scipy.spatial import KDTree

    tree, points, reach = KDTree(position[second]), position[first], joint.reach * ALIKE
    counts = tree.query_ball_point(points, reach, return_length=True)
    _refuse_too_many(joint, int(counts.sum()), findings)
    lists = tree.query_ball_point(points, reach, return_sorted=True)
    ends = second[np.concatenate([np.asarray(found, dtype=np.int64) for found in lists])]
    return np.stack([np.repeat(first, counts), ends], axis=1).astype(np.int32)


def _refuse_too_many(joint: Joint, count: int, findings: Findings) -> None:
    if count > LARGEST:
        findings.reject("TIS310", f"joint {joint.name} would have {count} springs", joint.span)


def nearest_pairs(
    position: Floats, first: Indices, second: Indices
) -> tuple[NDArray[np.int32], Floats]:
    """Join each node of the smaller group, or of the first, to the nearest one of the other.

    Of nodes equally near, the one that comes first counts.

    Args:
        position: Of all nodes [m], shape (node, 3).
        first, second: Numbers of nodes, ascending, none of them in both.

    Returns:
        Node pairs, of the first and the second group, shape (pair, 2), and distances [m].
    """
    from scipy.spatial import KDTree

    few, many = (first, second) if len(first) <= len(second) else (second, first)
    tree, points = KDTree(position[many]), position[few]
    distance = tree.query(points)[0]
    alike: Any = tree.query_ball_point(points, distance * ALIKE)
    nearest = many[[min(places) for places in alike]]
    columns = (few, nearest) if few is first else (nearest, few)
    reach = np.linalg.norm(position[nearest] - position[few], axis=1)
    return np.stack(columns, axis=1).astype(np.int32), reach
