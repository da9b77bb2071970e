"""What is known of the nodes of a film, in all of its rows."""

import re
from collections.abc import Iterator, Mapping
from functools import cached_property

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.matter.elasticity import wall_springs
from tissuec.mechanics.deformation import Surroundings, mean_of_springs, symmetric, von_mises
from tissuec.model.edges import without
from tissuec.model.network import BodyPart, Floats, Indices, Network, numbers_in
from tissuec.results.blocks.anatomy import Anatomy, BodyMatter
from tissuec.results.blocks.fields import Facts, Moment
from tissuec.results.blocks.layout import Cloud
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.film import DRAWN, PlayerData
from tissuec.view.player.lifetimes import is_there
from tissuec.view.player.tints import borders

#: What bodies say that have a stress though they are neither solid nor threads.
_WALLS = re.compile(r"\b(?:thickness|section)\b")

_TOGETHER = 100_000  # nodes in several rows, whose strains are computed at once


class DrawnNodes(Struct, frozen=True, eq=False, dict=True):
    """The nodes of a film, and what is known of them.

    Attributes:
        film: The film.
        trajectory: Its result.
    """

    film: PlayerData
    trajectory: Trajectory

    @cached_property
    def drawn(self) -> Floats:
        """Return positions before the run [m], shape (node, 3)."""
        drawn, cut = self.trajectory.network.position, self.trajectory.cut_cells
        return (drawn if cut is None else cut.points.beside(drawn))[self.film.numbers]

    @property
    def representatives(self) -> Indices:
        """Return network numbers of nodes, or of main hosts of riding points, shape (node,)."""
        network, cut = self.trajectory.network, self.trajectory.cut_cells
        if cut is None:
            return self.film.numbers
        every = np.concatenate([np.arange(network.node_count), cut.points.main_hosts])
        return every[self.film.numbers]

    @cached_property
    def displacement(self) -> Floats:
        """Return distances from the positions before the run [m], shape (row, node).

        Nodes that are no places of matter have none.
        """
        place = self.film.position[:, : self.film.node_count]
        found, own = np.zeros(place.shape[:2]), self.film.matter
        found[:, own] = np.linalg.norm(place[:, own] - self.drawn[own], axis=2)
        return found

    @cached_property
    def speed(self) -> Floats:
        """Return magnitudes of velocities [m/s], shape (row, node)."""
        own = self.film.velocity[:, : self.film.node_count].astype(float)
        return np.linalg.norm(own, axis=2)

    def recorded(self, name: str) -> Floats | None:
        """Return a field of frames in its unit, NaN where it is unknown, shape (row, node).

        Forces and tensions are those that are drawn.

        Args:
            name: Of the field.
        """
        if name in DRAWN:
            return getattr(self, name)
        found = self.film.fields[name].astype(float)
        return None if np.isnan(found).all() else found

    @cached_property
    def force(self) -> Floats | None:
        """Return magnitudes of spring forces on nodes [N], shape (row, node)."""
        if not len(self.film.lines.ends):
            return None
        return np.linalg.norm(self.film.force.astype(float), axis=2)

    @cached_property
    def tension(self) -> Floats | None:
        """Return the mean tension of the springs at each node [N], shape (row, node).

        Edges of elements do not count.
        """
        lines, count = self.film.lines, self.film.node_count
        if not lines.bears.any():
            return None
        found = np.empty((len(self.film.times), count))
        for row, tension in enumerate(lines.tension):
            there = self.film.alive(row) & lines.bears
            found[row] = mean_of_springs(lines.ends[there], tension[there].astype(float), count)
        return found

    @property
    def strain(self) -> Floats | None:
        """Return largest principal strains, dimensionless, shape (row, node)."""
        return self._deformation[0]

    @property
    def stress(self) -> Floats | None:
        """Return the equivalent stress at each node [Pa], shape (row, node)."""
        return self._deformation[1]

    @cached_property
    def _deformation(self) -> tuple[Floats | None, Floats | None]:
        strain, stress = (
            np.full((len(self.film.times), self.film.node_count), np.nan) for _ in range(2)
        )
        for cloud in self._clouds():
            at = np.searchsorted(self.film.numbers, cloud.nodes[0])
            if cloud.name not in self.matter:
                for rows, around in self._surroundings(cloud):
                    place = self.film.position[rows, at].reshape(-1, 3)
                    found = _largest(around, around.strain(place)[0])
                    strain[rows, at] = found.reshape(-1, len(cloud.nodes[0]))
                continue
            for row, moment in self._moments(cloud):
                strain[row, at] = _largest(moment.around, moment.strain[0])
                stress[row, at] = von_mises(moment.stress)
        known = (None if np.isnan(one).all() else one for one in (strain, stress))
        return next(known), next(known)

    @property
    def matter(self) -> Mapping[str, BodyMatter]:
        """Return the matter of bodies that have a stress, by name."""
        anatomy = self._anatomy[0]
        return {} if anatomy is None else anatomy.matter

    @property
    def unknown_stress(self) -> str:
        """Return why no stress is known of bodies that may have one; "" if it is known."""
        return self._anatomy[1]

    @cached_property
    def _anatomy(self) -> tuple[Anatomy | None, str]:
        """Return the anatomy of the scene, or why it is unknown; neither where none is needed.

        Scenes are compiled again for it, which takes longer than to write a page.
        """
        result, springs = self.trajectory, self._springs
        texts = [result.text, *map(str, result.manifest.get("sources", {}).values())]
        is_filled = any(
            body.thread is not None
            or (springs[body.name].dimension == 3 and len(result.network.skin_of(body)))
            for body in result.network.bodies
            if body.name in springs
        )
        if not springs or not (is_filled or any(map(_WALLS.search, texts))):
            return None, ""
        from tissuec.analysis.result_scene import anatomy_of_result

        try:
            return anatomy_of_result(self.trajectory)
        except (TissueError, OSError) as error:
            return None, str(error)

    @cached_property
    def _springs(self) -> dict[str, BodyMatter]:
        """Return the lines of all bodies that have some, by name."""
        network = self.trajectory.network
        return {
            body.name: _springs_of(network, body)
            for body in network.bodies
            if body.lines.stop - body.bending > body.lines.start
        }

    def _surroundings(self, cloud: Cloud) -> Iterator[tuple[slice, Surroundings]]:
        """Yield rows between which no spring of a body comes or goes, and those in each."""
        assert cloud.matter is not None
        lines, drawn = self.film.lines, self.trajectory.network.position[cloud.nodes[0]]
        own = np.isin(lines.number, cloud.matter.lines)
        ends = np.searchsorted(cloud.nodes[0], self.film.numbers[lines.ends[own]])
        life, rows, most = lines.life[own], len(self.film.times), _TOGETHER // len(drawn)
        first, last = 0, is_there(life, 0)
        around = Surroundings.of(drawn, ends[last], cloud.matter.dimension)
        for row in range(1, rows + 1):
            there = is_there(life, row) if row < rows else last
            has_changed = not np.array_equal(there, last)
            if has_changed or row == rows or row - first >= max(1, most):
                yield slice(first, row), around.repeated(row - first)
                first = row
            if has_changed:
                around, last = (
                    Surroundings.of(drawn, ends[there], cloud.matter.dimension),
                    there,
                )

    def _moments(self, cloud: Cloud) -> Iterator[tuple[int, Moment]]:
        """Yield a body with matter in each row."""
        film, network = self.film, self.trajectory.network
        facts, none = Facts(self.trajectory, None, [cloud]), np.zeros((0, 3))
        nodes, part = cloud.nodes[0], cloud.lines
        assert cloud.matter is not None
        whole_net = network.with_blocks(*(one.block for one in cloud.matter.elements))
        every = np.ones(network.entity_count, dtype=bool)
        for row in range(len(film.times)):
            there = film.alive(row)
            lines, tension = film.lines.number[there], film.lines.tension[row, there]
            own = slice(*np.searchsorted(lines, (part.start, part.stop)))
            whole, is_node = (
                np.zeros((network.body_nodes, 3)),
                film.numbers < network.node_count,
            )
            whole[film.numbers[is_node]] = film.position[row, : film.node_count][is_node]
            recorded = {"tension": tension[own].astype(float)}
            gone = np.setdiff1d(numbers_in(part), lines)
            moment = Moment(
                facts, cloud, nodes, lines[own], whole[nodes], none, recorded, whole,
                alive=without(whole_net, every, gone),
            )  # fmt: skip
            yield row, moment

    def _clouds(self) -> Iterator[Cloud]:
        network, numbers = self.trajectory.network, self.film.numbers
        for number, body in enumerate(network.bodies):
            low, high = np.searchsorted(numbers, (body.nodes.start, body.nodes.stop))
            own = self._springs.get(body.name)
            if high - low == body.nodes.stop - body.nodes.start and own is not None:
                matter = self.matter.get(body.name, own)
                yield Cloud(
                    body.name, "body", number, (numbers[low:high],), np.zeros(0, dtype=int),
                    body.lines, matter,
                )  # fmt: skip


def _springs_of(network: Network, body: BodyPart) -> BodyMatter:
    """Return the lines of a body whose matter is unknown, and its dimension."""
    lines: Indices = np.arange(int(body.lines.start), int(body.lines.stop) - body.bending)
    skin, dimension = network.skin_of(body), 3
    if body.thread is not None:
        dimension = 1
    elif len(skin):
        within = wall_springs(skin, network.line_ends[lines])
        if within.all() or borders(skin):
            lines, dimension = lines[within], 2
    volume = np.ones(body.nodes.stop - body.nodes.start)
    return BodyMatter(volume, dimension, lines)


def _largest(around: Surroundings, six: Floats) -> Floats:
    """Return the largest principal of strains (node, 6) in known directions, shape (node,)."""
    # What is not known must not be the largest.
    low = 10.0 * (1.0 + np.abs(six).max(axis=1))
    away = (around.axes * ~around.kept[:, None, :]) @ around.axes.transpose(0, 2, 1)
    largest = np.linalg.eigvalsh(symmetric(six) - low[:, None, None] * away)[:, 2]
    return np.where(around.kept.any(axis=1), largest, 0.0)
