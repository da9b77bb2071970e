"""The numbers at points and cells of blocks, and what they are computed from.

Those of the fields that frames contain follow from their declarations; each derived field is
one function in this file. A field that the result already contains has its ``source`` there,
which blocks files link to or copy instead of computing it again.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import norm
from tissuec.mechanics.deformation import Surroundings, mean_of_springs, von_mises
from tissuec.model.network import Floats, Indices, Network
from tissuec.results import access
from tissuec.results.blocks.anatomy import Anatomy
from tissuec.results.blocks.layout import Cloud, Kind, own_elements
from tissuec.results.fields import FieldChannel
from tissuec.results.frame_columns import MOTION, POINTS, VELOCITY, column_of
from tissuec.results.schema import FRAMES, SOLIDS
from tissuec.results.trajectory import Trajectory
from tissuec.results.volume_cells import mean_at

_NO_TRIANGLES: Indices = np.zeros((0, 3), dtype=np.int64)
_NONE: NDArray[np.bool_] = np.zeros(0, dtype=bool)


class Facts:
    """What does not change with time.

    Attributes:
        region: Of each node of bodies, as a number among the names of regions, shape (node,).
        regions: Names of regions with their bodies; "" comes first, for nodes in none.
        bodies: Names of bodies and, behind them, of tools.
        tissues: Names of tissues, as far as they are known.
        labels: Which labels solid elements have.
        drawn: Positions of nodes and riding points before the run [m], shape (point, 3).
        hosts: Each node, and the main host of each riding point, shape (point,).
    """

    def __init__(
        self, trajectory: Trajectory, anatomy: Anatomy | None, clouds: Sequence[Cloud]
    ):
        self.network: Network = trajectory.network
        self.anatomy = anatomy
        groups = [group for group in trajectory.groups if group.body]
        self.regions = ("", *(f"{group.name} of {group.body}" for group in groups))
        self.region = np.zeros(self.network.node_count, dtype=np.int64)
        for number, group in enumerate(groups, start=1):
            self.region[group.indices] = number
        tools = [cloud.name for cloud in clouds if cloud.kind == "tool"]
        self.bodies = (*(body.name for body in self.network.bodies), *tools)
        self.labels = trajectory.mesh.solids.labels.keys()
        self.tissues: Sequence[str] = () if anatomy is None else anatomy.tissues
        if (kept := SOLIDS["tissue_names"].path) in trajectory.content:
            self.tissues = access.texts(trajectory.content, kept)
        self.drawn, self.hosts = self.network.position, np.arange(self.network.node_count)
        if (cut := trajectory.cut_cells) is not None:
            self.drawn = cut.points.beside(self.drawn)
            self.hosts = np.concatenate([self.hosts, cut.points.main_hosts])
        self._around: dict[int, tuple[Indices, Surroundings]] = {}

    def around(self, cloud: Cloud, lines: Indices) -> Surroundings:
        """Return the lines around the nodes of a body as drawn.

        Args:
            cloud: Of the body.
            lines: Springs that are intact and bear its stress, or edges, shape (line,).
        """
        assert cloud.matter is not None
        known = self._around.get(cloud.number)
        if known is None or not np.array_equal(known[0], lines):
            nodes = cloud.nodes[0][cloud.nodes[0] < self.network.node_count]
            ends = self.network.line_ends[lines].astype(np.int64) - nodes[0]
            drawn = self.network.position[nodes]
            known = lines, Surroundings.of(drawn, ends, cloud.matter.dimension)
            self._around[cloud.number] = known
        return known[1]


class Moment:
    """A cloud in one frame.

    Attributes:
        facts: What does not change.
        cloud: The cloud.
        nodes: Network numbers of its points, continued by riding points, shape (point,).
        lines: Network numbers of its springs and edges that exist, ascending, shape (line,).
        position: [m], shape (point, 3).
        velocity: [m/s], shape (point, 3); without rows of tools.
        recorded: Numbers of the fields of the result by name, in their units: of its points,
            its springs or these triangles, shape (point, …) or alike; of fields of cells, at
            its points. Also the labels of its solid elements.
        triangles: Its points that are corners of the skin, shape (triangle, 3).
        alive: Which entities of the network exist, shape (entity,).
        whole: Positions of all nodes that frames contain, by network number [m], shape (node,
            3).
    """

    def __init__(
        self, facts: Facts, cloud: Cloud, nodes: Indices, lines: Indices, position: Floats,
        velocity: Floats, recorded: Mapping[str, Floats], whole: Floats,
        triangles: Indices = _NO_TRIANGLES, alive: NDArray[np.bool_] = _NONE,
    ):  # fmt: skip
        self.facts, self.cloud, self.nodes, self.lines = facts, cloud, nodes, lines
        self.position, self.velocity, self.recorded = position, velocity, recorded
        self.triangles, self.whole, self.alive = triangles, whole, alive

    @property
    def network(self) -> Network:
        """Return the network before the run."""
        return self.facts.network

    @property
    def springs(self) -> Indices:
        """Network numbers of its springs that exist, ascending, shape (spring,)."""
        return self.network.springs_among(self.lines)

    @cached_property
    def ends(self) -> Indices:
        """Points of its springs, shape (spring, 2)."""
        return np.searchsorted(self.nodes, self.network.line_ends[self.springs]).reshape(-1, 2)

    @cached_property
    def _bearing(self) -> NDArray[np.bool_]:
        """Which of its lines bear stress, shape (line,)."""
        assert self.cloud.matter is not None
        return np.isin(self.lines, self.cloud.matter.lines)

    @cached_property
    def around(self) -> Surroundings:
        """The lines around the nodes of a body with matter."""
        return self.facts.around(self.cloud, self.lines[self._bearing])

    @property
    def hosts(self) -> Indices:
        """The node that stands for each of its points, shape (point,)."""
        return self.facts.hosts[self.nodes]

    def at_points(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return numbers of nodes, in their unit, then NaN at riding points, shape (point, …).

        Args:
            values: Shape (node, …).
        """
        return _padded(values, len(self.nodes))

    @cached_property
    def strain(self) -> tuple[Floats, Floats]:
        """Strain, shape (node, 6), and volume ratio, shape (node,), both without a unit."""
        return self.around.strain(self.position[self.nodes < self.network.node_count])

    @cached_property
    def of_elements(self) -> tuple[Floats, Floats]:
        """Strain, without a unit, and stress [Pa] of elements, shape (cell, 6) each.

        That of parts of cut elements, which the scene does not contain, is NaN.
        """
        assert self.cloud.matter is not None
        found = self.cloud.matter.of_elements(self.whole, self.network.position, self.alive)
        strain, stress = (_padded(one, len(self.recorded["region"])) for one in found)
        return strain, stress

    @cached_property
    def stress(self) -> Floats:
        """Stress of a body with matter [Pa], shape (node, 6)."""
        matter = self.cloud.matter
        assert matter is not None
        if matter.elements:
            nodes = self.network.bodies[self.cloud.number].nodes
            return matter.stress_of_elements(self.whole, self.alive, nodes)
        # Where a cell is turned inside out, the drawn volume is all that there is to divide by.
        ratio = np.where(self.strain[1] > 0.0, self.strain[1], 1.0)
        virial = self.around.virial(self.position, self.recorded["tension"][self._bearing])
        volume = matter.volume * ratio
        if matter.pressure is not None:
            torn = matter.pressure.enclosure.lost_items(self.alive)
            nodes = self.network.bodies[self.cloud.number].nodes
            pressure = matter.pressure.at_nodes(self.whole, torn, nodes)
            virial[:, :3] -= (pressure * volume)[:, None]
        if matter.near is not None:
            virial, volume = matter.near @ virial, matter.near @ volume
        return virial / volume[:, None]


class CloudMoments:
    """Reads frames of a result as moments of clouds.

    Args:
        trajectory: The result.
        facts: What does not change.
        clouds: Of which there are moments.
    """

    def __init__(self, trajectory: Trajectory, facts: Facts, clouds: Sequence[Cloud]):
        self._trajectory, self._facts, self._clouds = trajectory, facts, clouds
        self._rows = np.zeros(len(facts.hosts), dtype=np.int64)
        self._rows[trajectory.mesh.numbers_of_points] = np.arange(trajectory.mesh.points)

    def at(self, frame: int) -> Iterator[Moment]:
        """Yield the moments of all clouds in a frame, in their order."""
        trajectory, network = self._trajectory, self._facts.network
        position, velocity = (
            np.asarray(trajectory.at_points(one, frame), dtype=float) for one in MOTION
        )
        drawing = trajectory.drawing(frame)
        drawn, grid, mesh = drawing.cells, drawing.grid, drawing.mesh
        numbers = {one: self._numbers(one, frame) for one in trajectory.channels}
        whole = position[: len(trajectory.nodes)]
        if len(whole) < network.body_nodes:
            whole = np.zeros((network.body_nodes, 3))
            whole[trajectory.nodes] = position[: len(trajectory.nodes)]
        for cloud in self._clouds:
            nodes = cloud.nodes[int(cloud.of_frame[frame])]
            if cloud.mesh is not None:
                still, none = np.zeros((0, 3)), np.zeros(0, dtype=int)
                places = cloud.mesh.at(frame)
                yield Moment(self._facts, cloud, nodes, none, places, still, {}, whole)
                continue
            at, row = self._rows[nodes], np.full(mesh.points, -1)
            row[at] = np.arange(len(at))
            ends = cloud.lines.start, cloud.lines.stop
            own = slice(*np.searchsorted(drawn.line_numbers, ends))
            corners = row[mesh.triangles[grid.items["triangle"]]]
            seen = (corners >= 0).all(axis=1)
            place = {"node": at, "spring": own, "triangle": seen, "cell": at}
            place["element"] = own_elements(drawing, row)
            recorded = {one.name: every[place[one.at]] for one, every in numbers.items()}
            own_solids = drawing.mesh.solids.some(drawn.elements[place["element"]])
            recorded |= own_solids.labels
            lines = drawn.line_numbers[own].astype(np.int64)
            yield Moment(
                self._facts, cloud, nodes, lines, position[at], velocity[at], recorded, whole,
                corners[seen], drawing.alive,
            )  # fmt: skip

    def _numbers(self, channel: FieldChannel, frame: int) -> Floats:
        """Return the numbers of a field at all nodes, springs or other items of a frame."""
        if channel.at in POINTS:
            found = self._trajectory.at_points(channel, frame)
        else:
            found = self._trajectory.shown(channel.name, frame)[0]
        return np.asarray(found, dtype=float)


Values: TypeAlias = "NDArray[np.floating] | NDArray[np.integer]"
NODES: tuple[Kind, ...] = ("body", "joint", "grip")
ALL: tuple[Kind, ...] = (*NODES, "tool")
SPRINGS: tuple[Kind, ...] = ("body", "joint")
BODY: tuple[Kind, ...] = ("body",)


class BlockField(Struct, frozen=True):
    """Numbers at the points or cells of some blocks.

    Attributes:
        name: As VTK shows it.
        unit: Of each number; "" without one.
        width: How many numbers each of them has.
        at: "points", "lines", "triangles" or "elements".
        of: Kinds of clouds that have it.
        text: What it is.
        value: From a moment to numbers, shape (point, width) or alike, or (…,) for one of them.
        changes: Whether it has other values in each frame, while the same is drawn.
        whole: Whether its numbers are integers.
        needs: "matter" or "anatomy" where these have to be known, or a label of elements.
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
            **dict.fromkeys(facts.labels, True),
        }
        return cloud.kind in self.of and known.get(self.needs, False)


def _displacement(moment: Moment) -> Values:
    return moment.position - moment.facts.drawn[moment.nodes]


def _tissue(moment: Moment) -> Values:
    assert moment.facts.anatomy is not None
    return moment.facts.anatomy.tissue[moment.hosts]


def _label(
    name: str, text: str, width: int = 1, names: Callable[[Facts], Sequence[str]] | None = None
) -> BlockField:
    """Return the field of a label of solid elements."""
    return BlockField(
        name, "", width, "elements", BODY, text, lambda m: m.recorded[name],
        changes=False, whole=width == 1, needs=name, source=FRAMES[f"CellData/{name}"].path,
        names=names,
    )  # fmt: skip


def _padded(values: NDArray[Any], count: int) -> NDArray[Any]:
    """Return numbers with so many rows, NaN where there are none."""
    if len(values) == count:
        return values
    return np.concatenate([values, np.full((count - len(values), *values.shape[1:]), np.nan)])


def _body(moment: Moment) -> Values:
    """Return the number of the body; of the points of a joint and a grip, that of the node."""
    stops = [body.nodes.stop for body in moment.network.bodies]
    if moment.cloud.kind == "tool":
        return np.full(len(moment.nodes), moment.cloud.number)
    return np.searchsorted(stops, moment.hosts, side="right")


def _elongation(moment: Moment) -> Values:
    """Return how much longer springs are than drawn, as a part of that; 0 if drawn so short."""
    ends = moment.network.line_ends[moment.springs]
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
        lambda m: m.at_points(m.strain[0]), needs="matter",
    ),
    BlockField(
        "strain_directions", "", 1, "points", ("body",),
        "in how many directions the strain of each node is known; it is 0 in the others",
        lambda m: np.nan_to_num(m.at_points(m.around.directions)), whole=True, needs="matter",
    ),
    BlockField(
        "stress", "Pa", 6, "points", ("body",),
        "Cauchy stress by the virial of each node: xx, yy, zz, xy, yz, xz",
        lambda m: m.at_points(m.stress), needs="matter",
    ),
    BlockField(
        "von_mises", "Pa", 1, "points", ("body",), "equivalent stress of von Mises",
        lambda m: m.at_points(von_mises(m.stress)), needs="matter",
    ),
    BlockField(
        "strain", "", 6, "elements", BODY,
        "mean Green-Lagrange strain of each element: xx, yy, zz, xy, yz, xz",
        lambda m: m.of_elements[0], needs="matter",
    ),
    BlockField(
        "stress", "Pa", 6, "elements", BODY,
        "mean Cauchy stress of each element: xx, yy, zz, xy, yz, xz",
        lambda m: m.of_elements[1], needs="matter",
    ),
    BlockField(
        "body", "", 1, "points", ALL, "number of the body or tool, from 0", _body,
        changes=False, whole=True, names=lambda facts: facts.bodies,
    ),
    BlockField(
        "region", "", 1, "points", NODES, "number of the region; 0: none",
        lambda m: m.facts.region[m.hosts],
        changes=False, whole=True, names=lambda facts: facts.regions,
    ),
    BlockField(
        "tissue", "", 1, "points", NODES, "number of the tissue, from 0", _tissue,
        changes=False, whole=True, needs="anatomy", names=lambda facts: facts.tissues,
    ),
    _label("region", "number of the region; 0: none", names=lambda facts: facts.regions),
    _label("tissue", "number of the tissue, from 0", names=lambda facts: facts.tissues),
    _label("fibres", "direction of the fibres as drawn; 0 without fibres", 3),
    _label("second_fibres", "direction of the second fibres as drawn", 3),
    BlockField(
        "node", "", 1, "points", NODES, "number of the node in the network, unique",
        lambda m: m.nodes, changes=False, whole=True,
    ),
    BlockField(
        "node_id", "", 1, "points", NODES, "id of the node in the scene",
        lambda m: np.where(
            m.nodes < m.network.node_count, m.network.node_ids[m.hosts], -1
        ),
        changes=False, whole=True,
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
    own = [field for channel in trajectory.channels for field in _recorded(channel)]
    known = {(field.name, field.at) for field in own}
    return (*(field for field in DERIVED if (field.name, field.at) not in known), *own)


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
    if channel.at == "element":
        yield BlockField(
            name, unit, channel.width, "elements", BODY, text, numbers, source=source
        )
    elif channel.at == "spring":
        yield BlockField(channel.key, unit, 1, "points", SPRINGS, mean, mean_of_lines)
        yield BlockField(name, unit, 1, "lines", SPRINGS, text, numbers, source=source)
    else:
        yield BlockField(channel.key, unit, 1, "points", BODY, mean, mean_of_triangles)
        yield BlockField(name, unit, 1, "triangles", BODY, text, numbers)
