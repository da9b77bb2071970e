"""The numbers at points, lines and triangles of blocks.

Those of the fields that frames contain follow from their declarations; each derived field is
one function in this file. A field that the result already contains has its ``source`` there,
which blocks files link to or copy instead of computing it again.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.vectors import norm
from tissuec.mechanics.deformation import mean_of_springs, von_mises
from tissuec.model.network import Floats
from tissuec.results.blocks.layout import Cloud, Kind
from tissuec.results.blocks.moment import Facts, Moment
from tissuec.results.fields import FieldChannel
from tissuec.results.frame_columns import VELOCITY, column_of
from tissuec.results.means import mean_at
from tissuec.results.trajectory import Trajectory

Values: TypeAlias = "NDArray[np.floating] | NDArray[np.integer]"
NODES: tuple[Kind, ...] = ("body", "joint", "grip")
ALL: tuple[Kind, ...] = (*NODES, "tool")
SPRINGS: tuple[Kind, ...] = ("body", "joint")
BODY: tuple[Kind, ...] = ("body",)


class BlockField(Struct, frozen=True):
    """Numbers at the points, lines or triangles of some blocks.

    Attributes:
        name: As VTK shows it.
        unit: Of each number; "" without one.
        width: How many numbers each of them has.
        at: "points", "lines" or "triangles".
        of: Kinds of clouds that have it.
        text: What it is.
        value: From a moment to numbers, shape (point, width) or alike, or (…,) for one of them.
        changes: Whether it has other values in each frame, while the same is drawn.
        whole: Whether its numbers are integers.
        needs: "matter" or "anatomy" where these have to be known.
        source: Dataset of the frames of a result that contains it.
        names: From facts to the meanings of integers.
    """

    name: str
    unit: str
    width: int
    at: str
    of: tuple[Kind, ...]
    text: str
    value: Callable[[Moment], Values]
    changes: bool = True
    whole: bool = False
    needs: str = ""
    source: str = ""
    names: Callable[[Facts], Sequence[str]] | None = None

    def fits(self, cloud: Cloud, facts: Facts) -> bool:
        """Return whether a cloud has this field."""
        known = {
            "": True,
            "matter": cloud.matter is not None,
            "anatomy": facts.anatomy is not None,
        }
        return cloud.kind in self.of and known[self.needs]


def _displacement(moment: Moment) -> Values:
    return moment.position - moment.network.position[moment.nodes]


def _tissue(moment: Moment) -> Values:
    assert moment.facts.anatomy is not None
    return moment.facts.anatomy.tissue[moment.nodes]


def _tissue_names(facts: Facts) -> Sequence[str]:
    assert facts.anatomy is not None
    return facts.anatomy.tissues


def _body(moment: Moment) -> Values:
    """Return the number of the body; of the points of a joint and a grip, that of the node."""
    stops = [body.nodes.stop for body in moment.network.bodies]
    if moment.cloud.kind == "tool":
        return np.full(len(moment.nodes), moment.cloud.number)
    return np.searchsorted(stops, moment.nodes, side="right")


def _elongation(moment: Moment) -> Values:
    """Return how much longer springs are than drawn, as a part of that; 0 if drawn so short."""
    ends = moment.network.springs.ends[moment.springs]
    drawn = norm(moment.network.position[ends[:, 1]] - moment.network.position[ends[:, 0]])
    here = norm(moment.position[moment.ends[:, 1]] - moment.position[moment.ends[:, 0]])
    return np.divide(here - drawn, drawn, where=drawn > 0.0, out=np.zeros_like(drawn))


DERIVED: tuple[BlockField, ...] = (
    BlockField(
        "displacement", "m", 3, "points", NODES, "from the positions before the run",
        _displacement,
    ),
    BlockField(
        "velocity", "m/s", 3, "points", NODES, "velocity of each node", lambda m: m.velocity,
        source=column_of(VELOCITY).path,
    ),
    BlockField(
        "strain", "", 6, "points", ("body",),
        "Green-Lagrange strain of the springs around each node: xx, yy, zz, xy, yz, xz",
        lambda m: m.strain[0], needs="matter",
    ),
    BlockField(
        "strain_directions", "", 1, "points", ("body",),
        "in how many directions the strain of each node is known; it is 0 in the others",
        lambda m: m.around.directions, whole=True, needs="matter",
    ),
    BlockField(
        "stress", "Pa", 6, "points", ("body",),
        "Cauchy stress by the virial of each node: xx, yy, zz, xy, yz, xz",
        lambda m: m.stress, needs="matter",
    ),
    BlockField(
        "von_mises", "Pa", 1, "points", ("body",), "equivalent stress of von Mises",
        lambda m: von_mises(m.stress), needs="matter",
    ),
    BlockField(
        "body", "", 1, "points", ALL, "number of the body or tool, from 0", _body,
        changes=False, whole=True, names=lambda facts: facts.bodies,
    ),
    BlockField(
        "region", "", 1, "points", NODES, "number of the region; 0: none",
        lambda m: m.facts.region[m.nodes],
        changes=False, whole=True, names=lambda facts: facts.regions,
    ),
    BlockField(
        "tissue", "", 1, "points", NODES, "number of the tissue, from 0", _tissue,
        changes=False, whole=True, needs="anatomy", names=_tissue_names,
    ),
    BlockField(
        "node", "", 1, "points", NODES, "number of the node in the network, unique",
        lambda m: m.nodes, changes=False, whole=True,
    ),
    BlockField(
        "node_id", "", 1, "points", NODES, "id of the node in the scene",
        lambda m: m.network.node_ids[m.nodes], changes=False, whole=True,
    ),
    BlockField(
        "strain", "", 1, "lines", SPRINGS,
        "elongation of each spring beyond its drawn length, as a part of it",
        _elongation,
    ),
    BlockField(
        "law", "", 1, "lines", SPRINGS, "number of the law, from 0",
        lambda m: m.network.springs.law[m.springs],
        changes=False, whole=True,
        names=lambda facts: [law.name for law in facts.network.springs.laws],
    ),
    BlockField(
        "spring", "", 1, "lines", SPRINGS, "number of the spring in the network, unique",
        lambda m: m.springs, changes=False, whole=True,
    ),
    BlockField(
        "spring_id", "", 1, "lines", SPRINGS, "id of the spring in the scene",
        lambda m: m.network.springs.ids[m.springs], changes=False, whole=True,
    ),
)  # fmt: skip


def fields_of(trajectory: Trajectory) -> tuple[BlockField, ...]:
    """Return all fields of the blocks of a result."""
    own = (field for channel in trajectory.channels for field in _recorded(channel))
    return (*DERIVED, *own)


def _recorded(channel: FieldChannel) -> Iterator[BlockField]:
    """Yield the fields of blocks that show a field of frames."""
    name, unit, text = channel.stored, channel.unit, channel.text
    source = column_of(channel).path

    def numbers(moment: Moment) -> Floats:
        return moment.recorded[channel.name]

    def mean_of_lines(moment: Moment) -> Values:
        return mean_of_springs(moment.ends, numbers(moment), len(moment.nodes))

    def mean_of_triangles(moment: Moment) -> Values:
        return np.nan_to_num(mean_at(moment.triangles, numbers(moment), len(moment.nodes)))

    if channel.at in ("node", "cell"):
        text = text if channel.at == "node" else f"{channel.at_nodes}; 0 without any"
        yield BlockField(
            name, unit, channel.width, "points", NODES, text, numbers, source=source
        )
        return
    mean = f"{text}, as the mean of those of the block at each node; 0 without any"
    if channel.at == "spring":
        yield BlockField(channel.key, unit, 1, "points", SPRINGS, mean, mean_of_lines)
        yield BlockField(name, unit, 1, "lines", SPRINGS, text, numbers, source=source)
    else:
        yield BlockField(channel.key, unit, 1, "points", BODY, mean, mean_of_triangles)
        yield BlockField(name, unit, 1, "triangles", BODY, text, numbers)
