"""What the fields of a frame are computed from."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tissuec.mechanics.deformation import Surroundings
from tissuec.model.network import Floats, Indices, Network
from tissuec.results.blocks.anatomy import Anatomy
from tissuec.results.blocks.layout import Cloud, triangles_of
from tissuec.results.fields import FieldChannel
from tissuec.results.trajectory import Trajectory

_NO_TRIANGLES: Indices = np.zeros((0, 3), dtype=np.int64)
_NONE: Indices = np.zeros(0, dtype=np.int64)


class Facts:
    """What does not change with time.

    Attributes:
        region: Of each node of bodies, as a number among the names of regions, shape (node,).
        regions: Names of regions with their bodies; "" comes first, for nodes in none.
        bodies: Names of bodies and, behind them, of tools.
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
        self._around: dict[int, tuple[Indices, Surroundings]] = {}

    def around(self, cloud: Cloud, springs: Indices) -> Surroundings:
        """Return the springs around the nodes of a body as drawn.

        Args:
            cloud: Of the body.
            springs: Those that are intact and bear its stress, shape (spring,).
        """
        assert cloud.matter is not None
        known = self._around.get(cloud.number)
        if known is None or not np.array_equal(known[0], springs):
            nodes = cloud.nodes[0]
            ends = self.network.springs.ends[springs].astype(np.int64) - nodes[0]
            drawn = self.network.position[nodes]
            known = springs, Surroundings.of(drawn, ends, cloud.matter.dimension)
            self._around[cloud.number] = known
        return known[1]


class Moment:
    """A cloud in one frame.

    Attributes:
        facts: What does not change.
        cloud: The cloud.
        nodes: Network numbers of its points, shape (point,).
        springs: Network numbers of its springs that exist, ascending, shape (spring,).
        position: [m], shape (point, 3).
        velocity: [m/s], shape (point, 3); without rows of tools.
        recorded: Numbers of the fields of the result by name, in their units: of its points,
            these springs or these triangles, shape (point, …) or alike; of fields of cells, at
            its points.
        triangles: Its points that are corners of the skin, shape (triangle, 3).
        whole: Positions of all nodes that frames contain, by network number [m], shape (node,
            3).
        broken: Marks of elements that have broken, shape (n,).
    """

    def __init__(
        self, facts: Facts, cloud: Cloud, nodes: Indices, springs: Indices, position: Floats,
        velocity: Floats, recorded: Mapping[str, Floats], whole: Floats,
        triangles: Indices = _NO_TRIANGLES, broken: Indices = _NONE,
    ):  # fmt: skip
        self.facts, self.cloud, self.nodes, self.springs = facts, cloud, nodes, springs
        self.position, self.velocity, self.recorded = position, velocity, recorded
        self.triangles, self.whole, self.broken = triangles, whole, broken

    @property
    def network(self) -> Network:
        """Return the network before the run."""
        return self.facts.network

    @cached_property
    def ends(self) -> Indices:
        """Points of these springs, shape (spring, 2)."""
        return np.searchsorted(self.nodes, self.network.springs.ends[self.springs]).reshape(
            -1, 2
        )

    @cached_property
    def _bearing(self) -> NDArray[np.bool_]:
        """Which of these springs bear stress, shape (spring,)."""
        assert self.cloud.matter is not None
        return np.isin(self.springs, self.cloud.matter.springs)

    @cached_property
    def _alive(self) -> NDArray[np.bool_]:
        """Which springs of the network are there, as far as they are of this cloud."""
        alive = np.zeros(self.network.spring_count, dtype=bool)
        alive[self.springs] = alive[self.network.first_mark :] = True
        alive[self.broken] = False
        return alive

    @cached_property
    def around(self) -> Surroundings:
        """The springs around the nodes of a body with matter."""
        return self.facts.around(self.cloud, self.springs[self._bearing])

    @cached_property
    def strain(self) -> tuple[Floats, Floats]:
        """Strain, shape (point, 6), and volume ratio, shape (point,), both without a unit."""
        return self.around.strain(self.position)

    @cached_property
    def stress(self) -> Floats:
        """Stress of a body with matter [Pa], shape (point, 6)."""
        matter = self.cloud.matter
        assert matter is not None
        if matter.elements:
            nodes = self.network.bodies[self.cloud.number].nodes
            return matter.stress_of_elements(self.whole, self._alive, nodes)
        # Where a cell is turned inside out, the drawn volume is all that there is to divide by.
        ratio = np.where(self.strain[1] > 0.0, self.strain[1], 1.0)
        virial = self.around.virial(self.position, self.recorded["tension"][self._bearing])
        volume = matter.volume * ratio
        if matter.pressure is not None:
            torn = matter.pressure.enclosure.lost_items(self._alive)
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
        self._rows = np.zeros(facts.network.node_count, dtype=np.int64)
        self._rows[trajectory.nodes] = np.arange(len(trajectory.nodes))

    def at(self, frame: int) -> Iterator[Moment]:
        """Yield the moments of all clouds in a frame, in their order."""
        trajectory, network = self._trajectory, self._facts.network
        position, velocity = (
            np.asarray(one[frame], dtype=float)
            for one in (trajectory.position, trajectory.velocity)
        )
        drawn, broken = trajectory.cells(frame), self._broken(float(trajectory.times[frame]))
        numbers = {one: self._numbers(one, frame) for one in trajectory.channels}
        whole = position
        if len(position) < network.body_nodes:
            whole = np.zeros((network.body_nodes, 3))
            whole[trajectory.nodes] = position
        for cloud in self._clouds:
            nodes = cloud.nodes[int(cloud.of_frame[frame])]
            if cloud.mesh is not None:
                still, none = np.zeros((0, 3)), np.zeros(0, dtype=int)
                places = cloud.mesh.at(frame)
                yield Moment(self._facts, cloud, nodes, none, places, still, {}, whole)
                continue
            at = self._rows[nodes]
            ends = cloud.springs.start, cloud.springs.stop
            own = slice(*np.searchsorted(drawn.springs, ends))
            corners, seen = triangles_of(trajectory.nodes, drawn, nodes)
            place = {"node": at, "spring": own, "triangle": seen, "cell": at}
            recorded = {one.name: every[place[one.at]] for one, every in numbers.items()}
            springs = drawn.springs[own].astype(np.int64)
            yield Moment(
                self._facts, cloud, nodes, springs, position[at], velocity[at], recorded, whole,
                corners, broken,
            )  # fmt: skip

    def _broken(self, time: float) -> Indices:
        """Return the marks of elements that have broken until a time [s], shape (n,)."""
        first = self._facts.network.first_mark
        events = (event for event in self._trajectory.events if event.time <= time)
        marks = [spring for event in events for spring in event.springs if spring >= first]
        return np.array(marks, dtype=np.int64)

    def _numbers(self, channel: FieldChannel, frame: int) -> Floats:
        """Return the numbers of a field at all nodes, springs or triangles of a frame."""
        if channel.at in ("spring", "triangle"):
            found = self._trajectory.shown(channel.name, frame)[0]
        else:
            found = self._trajectory.at_points(channel, frame)
        return np.asarray(found, dtype=float)
