"""Everything that differs between two sides."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.model.network import Indices
from tissuec.results.trajectory import Trajectory
from tissuec.view.compare.matching import MatchedIndices, SideParts, match_nodes, match_springs
from tissuec.view.compare.motion import MotionDifference, compare_motions
from tissuec.view.compare.over_time import (
    Curves,
    EventComparison,
    compare_curves,
    compare_events,
)
from tissuec.view.compare.parameters import (
    FORCE,
    QuantityDifference,
    compare_forces,
    compare_parameters,
    forces_alone,
)
from tissuec.view.compare.sides import Side, TextDifference, changed_files, compare_texts

MOST_NAMED = 6  # nodes or springs that are named of one part


class StatedDifference(Struct, frozen=True):
    """A fact that differs between both sides."""

    name: str
    a: Any
    b: Any


class Leftover(Struct, frozen=True):
    """Nodes or springs of a part, or a force, that the other side does not have.

    Attributes:
        side: "a" or "b".
        part: The body, joint, tool or ``force`` block.
        what: "node", "spring" or "force".
        count: How many.
        total: Of so many of that part.
        ids: The first ones, as the scene numbers them.
    """

    side: str
    part: str
    what: str
    count: int
    total: int
    ids: tuple[int, ...]


class Comparison(Struct, frozen=True, eq=False):
    """All differences; an empty part is equal on both sides.

    Attributes:
        texts: Of the scene and of what it uses.
        files: Such as meshes, by digest.
        settings: Of the simulation: tolerance, duration, overrides, …
        nodes, springs: Which are the same.
        leftovers: Nodes and springs that one side alone has.
        changes: Numbers of the others.
        logged_events: Of two scenes what is scripted, of two results what happened.
        provenance: How the runs were made and ended; only of two results, as all below.
        curves: Logs and energies.
        motion: Or why it cannot be compared.
    """

    a: Side
    b: Side
    texts: tuple[TextDifference, ...]
    files: tuple[TextDifference, ...]
    settings: tuple[StatedDifference, ...]
    nodes: MatchedIndices
    springs: MatchedIndices
    leftovers: tuple[Leftover, ...]
    changes: tuple[QuantityDifference, ...]
    logged_events: EventComparison | None = None
    provenance: tuple[StatedDifference, ...] = ()
    curves: Curves | None = None
    motion: MotionDifference | str | None = None

    @property
    def is_same(self) -> bool:
        """Return whether nothing differs."""
        lists = (self.texts, self.files, self.settings, self.leftovers, self.changes)
        wholes = (self.logged_events, self.curves)
        return (
            not any(lists)
            and not self.provenance
            and all(whole is None or whole.is_same for whole in wholes)
            and (not isinstance(self.motion, MotionDifference) or self.motion.is_same)
        )


def compare(a: Side, b: Side) -> Comparison:
    """Return the differences of two scenes, two results, or a scene and a result."""
    nodes = match_nodes(a, b)
    springs = match_springs(a, b, nodes)
    alike = (a.trajectory is None) == (b.trajectory is None)
    found = Comparison(
        a, b, tuple(compare_texts(a, b)), tuple(changed_files(a.files, b.files)),
        _facts(a.settings, b.settings), nodes, springs, _leftovers(a, b, nodes, springs),
        (*compare_parameters(a, b, nodes, springs), *compare_forces(a, b)),
        compare_events(a, b, springs) if alike else None,
    )  # fmt: skip
    if a.trajectory is None or b.trajectory is None:
        return found
    return replace(
        found,
        provenance=_facts(_made(a.trajectory), _made(b.trajectory)),
        curves=compare_curves(a.trajectory, b.trajectory),
        motion=compare_motions(a.trajectory, b.trajectory, nodes),
    )


def _made(trajectory: Trajectory) -> dict[str, Any]:
    """Return how a run was made and how it ended, without what the clock decides."""
    manifest = trajectory.manifest
    statistics = manifest.get("statistics", {})
    return {
        "outcome": trajectory.outcome,
        "method": [change["method"] for change in statistics.get("changes", ())],
        "steps": statistics.get("accepted"),
        "frames": len(trajectory.times),
        "precision": trajectory.position.dtype.name,
        "failed expectations": [
            judged.expect for judged in trajectory.expectations if judged.state != "holds"
        ],
        **{f"version of {name}": v for name, v in manifest.get("versions", {}).items()},
    }


def _facts(a: Mapping[str, Any], b: Mapping[str, Any]) -> tuple[StatedDifference, ...]:
    names = {**a, **b}
    return tuple(
        StatedDifference(name, a.get(name), b.get(name))
        for name in names
        if a.get(name) != b.get(name)
    )


def _leftovers(
    a: Side, b: Side, nodes: MatchedIndices, springs: MatchedIndices
) -> tuple[Leftover, ...]:
    """Return the items of one side only, part by part."""
    found: list[Leftover] = []
    for side, which, alone, own in (
        (a, "a", nodes.only_a, springs.only_a),
        (b, "b", nodes.only_b, springs.only_b),
    ):
        network, places = side.network, SideParts(side)
        body, part = places.body_of_nodes, places.part_of_springs
        found += _by_part(which, "node", alone, body, places.bodies, network.node_ids)
        names = [part.name for part in network.parts]
        found += _by_part(which, "spring", own, part, names, network.springs.ids)
    found += [Leftover(side, name, FORCE, 1, 1, ()) for side, name in forces_alone(a, b)]
    return tuple(found)


def _by_part(
    side: str, what: str, alone: Indices, owner: Indices, names: list[str], ids: Indices
) -> list[Leftover]:
    found: list[Leftover] = []
    for part in np.unique(owner[alone]).tolist():
        members = alone[owner[alone] == part]
        name = names[int(part)] if part >= 0 else "a tool"
        total = int((owner == part).sum())
        some = tuple(ids[members[:MOST_NAMED]].tolist())
        found.append(Leftover(side, name, what, len(members), total, some))
    return found
