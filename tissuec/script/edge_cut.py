"""Cuts by the edge of a tool that moves through solids; see ``forces.acting.cutting_edges``.

The edge cuts along the surface that it would sweep through the tissue as it lies there, plane
within each cell and continued from cell to cell: a height at each node that is given once.
Cells are divided before the next step of the edge reaches them, and their sections are tied
(``mechanics.tying``). In the surface, places have coordinates p along the edge, from 0 to 1,
and q, how far they are ahead of it. The cut ends at the *front*, which lags behind the edge
where the tissue resists; the anchors of the pieces of the edge are just ahead of it. Each time
the edge has moved by a quarter of a cell, the front advances to where the tissue bears the
force of the edge, and the ties behind it are removed.
"""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.acting.cutting_edges import KIND, CuttingEdge
from tissuec.geometry.blade_sections import beyond
from tissuec.geometry.cut_cells.cutting import near_heights
from tissuec.geometry.moving_edges import EdgeFront, EdgePlane, Stations
from tissuec.mechanics.cut_body import CutBody
from tissuec.mechanics.cut_effects import put_ties
from tissuec.mechanics.cutting import divided
from tissuec.mechanics.tearing import set_limits
from tissuec.mechanics.tying import TiedSections
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices, Network, ToolPart, numbers_in
from tissuec.script.dividing import (
    LEAST_SHARE,
    among,
    continued,
    met_sections,
    resistances,
    tied_apart,
)
from tissuec.script.verbs import CHANGED, EventQueue, Flaw, LoggedEvent, stopping
from tissuec.script.verbs.closing import cut_event
from tissuec.script.verbs.cut_surface import stroke
from tissuec.script.verbs.holding import sentence

if TYPE_CHECKING:
    from tissuec.mechanics.state import State

Bools = NDArray[np.bool_]
#: Of the size of a cell: the way of the edge from one advance of the front to the next, how far
#: the edge is ahead of its anchors when the tissue gives way, and the length of the windows at
#: the front whose tissue carries these.
STEP, LAG, WINDOW = 0.25, 0.25, 0.25
STATIONS = 4  # for each such size of the edge: stations, each with an anchor
#: Of that size, and of its square: smaller ways and areas do not count.
LEAST, SLIVER = 1e-9, 1e-12
CREEP = 0.1  # of that size: how far strains of the windows may have displaced a front
#: Times at which a motion is examined; least number of advances in an interval.
LOOKS, MOST = 64, 16


class EdgeWay(Struct, frozen=True, eq=False):
    """How far an edge has come through a solid.

    Attributes:
        edge: Ends of it at the last advance [m], shape (2, 3).
        heights: Of nodes above the surface [m]; NaN where it has none yet, shape (node,).
        direction: In which the edge cuts, a unit vector; zero before it has moved, shape (3,).
        normal: Of the plane in which it cuts, likewise.
        area: Cut so far, as drawn [m²].
    """

    edge: Floats
    heights: Floats
    direction: Floats
    normal: Floats
    area: float = 0.0


class EdgeCut(Struct, frozen=True, eq=False):
    """A cut of a solid by the edge of a tool; see ``verbs.cut.Cut``.

    Attributes:
        body: Name of the solid.
        tool: Name of the tool.
        duration: How long it lasts [s].
    """

    body: str
    tool: str
    duration: float
    span: Span

    def flaw(self, network: Network) -> str:
        """Return why this cannot be done, empty if it can."""
        if _edge_of(network, self.tool) is None:
            return Flaw(
                f"{self.tool} has no edge",
                f"write tool {self.tool} {{ kind is scalpel; edge from … to … }}, or "
                f"cut {self.body} along … with {self.tool}",
            )
        solid = any(body.name == self.body and not body.is_wall for body in network.bodies)
        if network.phantoms_of(self.body) is None or not solid:
            return Flaw(
                f"{self.body} does not consist of solid elements that can be divided",
                f"write cut {self.body} along plane, stroke or line",
            )
        return ""

    def lines_within(self, network: Network) -> Indices:
        """Return the edges that it may cut, shape (n,)."""
        body = network.body_named(self.body)
        return numbers_in(body.lines)

    @property
    def key(self) -> str:
        """Return the key of its ``EdgeWay`` in the state, and the name of its block."""
        return f"the edge of {self.tool} in {self.body} ({self.span.place})"

    def apply(self, state: "State", queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Begin the cut."""
        tool = _edge_of(state.network, self.tool)
        assert tool is not None
        ends = numbers_in(tool.nodes)[:2]
        heights = np.full(state.network.node_count, np.nan)
        way = EdgeWay(state.position[ends], heights, np.zeros(3), np.zeros(3))
        state.blades = {**state.blades, self.key: way}
        size = _cell_size(state.network, self.body)
        advance = AdvanceOfEdge(self, ends, size, state.time, state.time + self.duration)
        advance.follow(state, queue)
        return (LoggedEvent("stroke", (), f"start of: {sentence(self.span)}", self.span),)


class AdvanceOfEdge(Struct, frozen=True, eq=False):
    """The front of a cut follows the edge.

    Attributes:
        cut: The cut.
        ends: Nodes of the ends of the edge, shape (2,).
        size: Of the cells of the solid [m].
        start, stop: When the cut begins and ends [s].
    """

    cut: EdgeCut
    ends: Indices
    size: float
    start: float
    stop: float

    @property
    def span(self) -> Span:
        """Return the sentence."""
        return self.cut.span

    def follow(self, state: "State", queue: EventQueue) -> None:
        """Add the next advance to the queue."""
        queue.add(min(self._next(state), self.stop), self)

    def _next(self, state: "State") -> float:
        """Return when the edge has moved on by a step [s]."""
        longest = state.time + (self.stop - self.start) / MOST
        motion = state.motions.get(self.cut.tool)
        if motion is None:
            return state.time + (self.stop - self.start) / (MOST * LOOKS)
        rows = np.searchsorted(motion.nodes, self.ends)
        times = np.linspace(state.time, longest, LOOKS + 1)
        places = motion.at(times)[0][:, rows]
        moved = np.linalg.norm(places - places[0], axis=-1).max(axis=-1)
        beyond_step = np.flatnonzero(moved >= STEP * self.size)
        if not len(beyond_step):
            return longest
        k = int(beyond_step[0])
        part = (STEP * self.size - moved[k - 1]) / (moved[k] - moved[k - 1])
        return float(times[k - 1] + part * (times[k] - times[k - 1]))

    def apply(self, state: "State", queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Advance the front.

        Raises:
            ActionFailed: The reserve of the body is exhausted.
        """
        way: EdgeWay = state.blades[self.cut.key]
        stored, before = self._stored(state), way.area
        way, lost = self._advanced(state, way, state.position[self.ends])
        ends = state.time >= self.stop
        if ends:
            self._let_go(state)
        events = list[LoggedEvent]()
        if way.area > before or len(lost):
            spent = stored - self._stored(state)
            events.append(cut_event(self.span, lost, way.area - before, spent))
        else:
            events.append(LoggedEvent(CHANGED, (), "", self.span))
        if not ends:
            state.blades = {**state.blades, self.cut.key: way}
            self.follow(state, queue)
            return tuple(events)
        state.blades = {key: one for key, one in state.blades.items() if key != self.cut.key}
        if not way.area:
            note = f"{sentence(self.span)}: nothing was cut"
            events.append(LoggedEvent("note", (), note, self.span))
        events.append(LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span))
        return tuple(events)

    def _advanced(self, state: "State", way: EdgeWay, edge: Floats) -> tuple[EdgeWay, Indices]:
        """Advance the front in the state; return the way, and lost entities."""
        along = (edge[1] - edge[0]) / np.linalg.norm(edge[1] - edge[0])
        moved = (edge - way.edge).mean(axis=0)
        moved = moved - (moved @ along) * along
        gone = float(np.linalg.norm(moved))
        if not gone > LEAST * self.size:
            return way, np.zeros(0, dtype=np.int64)
        ahead = moved / gone
        if self.cut.key in state.blocks and ahead @ way.direction <= 0.0:
            # It is drawn back, and cuts nothing until tissue has let go of it.
            ahead, gone = way.direction, 0.0
        plane = EdgePlane.of(edge, ahead, way.normal)
        heights, lost = self._divided(state, way.heights, plane, gone)
        way = EdgeWay(edge, heights, plane.ahead, plane.normal, way.area)
        tied: TiedSections | None = state.tied.get(self.cut.body)
        if tied is None:
            self._let_go(state)
            return way, lost
        body = CutBody.of(state, self.cut.body)
        tied = tied.existing(body)
        is_own = tied.are_on(body, heights)
        own = tied.some(is_own)
        corners = own.values(body, state.position).mean(axis=1)
        plain = plane.plain(corners)
        each = resistances(state.network, self.cut.body, body.parts)
        resistance = own.of_parts(body, each).mean(axis=1)
        count = max(2, int(np.ceil(STATIONS * plane.length / self.size)))
        stations = Stations.of(plain, count)
        front = self._front(state, plain[resistance > 0.0], count, gone)
        middle = plain[..., 0].mean(axis=1)
        start, lag = front.started(middle), front.lags(middle)
        start = np.where(resistance > 0.0, start, np.maximum(start, gone))
        # The ties between the old and the new front are those at 0…1 in place of q.
        swept = start - lag
        some = np.flatnonzero(swept > LEAST * self.size)
        scaled = plain[some].copy()
        scaled[..., 1] = (scaled[..., 1] + start[some, None]) / swept[some, None]
        which, shares = beyond(scaled, (True, True), 1.0)
        kept = np.ones(len(own), dtype=bool)
        kept[some] = False
        left = own.some(kept).followed_by(own.some(some).parts_of(which, shares), body)
        areas = left.areas(state.network, self.cut.body, body)
        left = left.some(areas > SLIVER * self.size**2)
        gained = float(own.areas(state.network, self.cut.body, body).sum() - areas.sum())
        put_ties(state, self.cut.body, tied.some(~is_own).followed_by(left, body))
        self._put_edge(state, own, body, stations, plane, front, resistance)
        return replace(way, area=way.area + gained), lost

    def _stored(self, state: "State") -> float:
        """Return the energy that the edge stores [J], which advances of the front spend."""
        block = state.blocks.get(self.cut.key)
        return 0.0 if block is None else float(block.field.energy(state.time, state.position))

    def _divided(
        self, state: "State", known: Floats, plane: EdgePlane, gone: float
    ) -> tuple[Floats, Indices]:
        """Divide the cells that the edge touches before its next step.

        Args:
            known: Heights of nodes [m]; NaN where there is none yet, shape (node,).
            gone: Way of the edge since the last advance [m].

        Returns:
            Heights, with those of these cells, and what is lost, shape (n,).

        Raises:
            ActionFailed: The reserve of the body is exhausted.
        """
        name, back = self.cut.body, -gone * plane.ahead
        blade = stroke(*(plane.edge + back), STEP * self.size * plane.ahead - back)
        none = np.zeros(0, dtype=np.int64)
        if blade is None:
            return known, none
        body = CutBody.of(state, name)
        plain = found = plane.heights(state.position)
        nodes = np.zeros(len(plain), dtype=bool)
        if (tied := state.tied.get(name)) is not None:
            found = continued(tied.existing(body), body, plain)
            nodes = (found != plain) & ~np.isnan(tied.heights)
        heights = np.where(np.isnan(known), found, known)
        near = near_heights(body.parts, state.position)
        heights = np.where(np.abs(heights) < near, 0.0, heights)
        touched = list[Indices]()
        for parts, entities in zip(body.parts, body.entities, strict=True):
            met, _, _, covered = met_sections(parts, entities, heights, state.position, blade)
            own = met[covered > LEAST_SHARE]
            nodes[parts.nodes[np.isin(entities, own)]] = True
            touched.append(own)
        heights = np.where(nodes | ~np.isnan(known), heights, np.nan)
        with stopping(self.span):
            own = among(body, np.concatenate(touched))
            division = divided(state, name, heights, self.cut.key, own)
        if division is None:
            return heights, none
        heights, tied, lost = tied_apart(state, division, heights)
        put_ties(state, name, tied)
        set_limits(state, name)
        return heights, lost

    def _front(self, state: "State", plain: Floats, count: int, gone: float) -> EdgeFront:
        """Return how far the front lagged behind the edge, and how far it does from now on.

        Args:
            plain: p and q of the corners of what resists, shape (triangle, 3, 2).
            count: Of stations.
            gone: Way of the edge since the last advance [m].
        """
        start, held = np.full(count, gone), np.zeros(count, dtype=bool)
        block = state.blocks.get(self.cut.key)
        if block is not None:
            # An anchor is in the middle of its window.
            anchored = block.field.ahead(state.position) + 0.5 * WINDOW * self.size
            station = _stations(block.field, count)
            start[station], held[station] = np.maximum(anchored, 0.0), True
        stations = Stations.of(plain, count)
        first = stations.first_matter(-np.minimum(start, self._most))
        lag = np.maximum(-first, 0.0)
        # Where tissue does not give way, nothing is cut, whatever its strain does to windows.
        bears = np.where(held, start <= self._most, lag > 0.0)
        start = np.where(held, start + CREEP * self.size, start)
        return EdgeFront(stations.places, np.where(bears, lag, start), lag)

    @property
    def _most(self) -> float:
        """Return how far the front lags behind the edge at most [m]."""
        return (LAG + 0.5 * WINDOW) * self.size

    def _put_edge(
        self, state: "State", own: TiedSections, body: CutBody, stations: Stations,
        plane: EdgePlane, front: EdgeFront, resistance: Floats,
    ) -> None:  # fmt: skip
        """Put the pieces of the edge, with anchors at the front, into the state.

        Args:
            own: Tied sections before the front was advanced.
            stations: Of these.
            resistance: Of these [J/m²], shape (triangle,).
        """
        window = WINDOW * self.size
        triangle, station, middle, areas = stations.windows(-front.lag, window)
        resists = (resistance[triangle] > 0.0) & (areas > 0.0)
        some = resists & (front.lag[station] > 0.0)
        if not some.any():
            self._let_go(state)
            return
        triangle, station, middle, areas = (
            each[some] for each in (triangle, station, middle, areas)
        )
        at = own.some(triangle)
        widths = stations.drawn_widths(own.values(body, state.network.position)[:, 0])
        force = resistance[triangle] * widths[triangle] * areas / window
        total = np.bincount(station, areas, stations.count)
        forces = np.bincount(station, force, stations.count)
        nodes = at.nodes(body).reshape(len(at), -1)
        part = (areas / total[station])[:, None]
        weights = 0.5 * part * at.weights(body, middle[:, None]).reshape(len(at), -1)
        there = nodes >= 0
        host = np.broadcast_to(station[:, None], nodes.shape)[there]
        held = np.unique(station)
        p = stations.places[held]
        field = CuttingEdge.of(
            np.concatenate([host, held, held]),
            np.concatenate([nodes[there], *(np.full(len(held), end) for end in self.ends)]),
            np.concatenate([-weights[there], 1.0 - p, p]),
            plane.ahead, forces[held], LAG * self.size,
        )  # fmt: skip
        state.put(FieldBlock(self.cut.key, KIND, field, self.span))

    def _let_go(self, state: "State") -> None:
        """Remove the force of the edge."""
        if (block := state.blocks.get(self.cut.key)) is not None:
            state.remove(block)


def _stations(field: CuttingEdge, count: int) -> Indices:
    """Return the station, among a number of stations, of each piece, shape (piece,)."""
    p = field.weights[field.first[1:] - 1]
    return np.floor(p * count).astype(np.int64)


def _edge_of(network: Network, name: str) -> ToolPart | None:
    """Return the tool with an edge that has a name; None if there is none."""
    tools = (tool for tool in network.tools if tool.name == name)
    return next((tool for tool in tools if tool.shapes[0].kind == "edge"), None)


def _cell_size(network: Network, body: str) -> float:
    """Return the edge of a cube as large as the mean element of a body [m]."""
    fields = network.elements_of(body)
    volumes = np.concatenate([each.node_volumes.sum(axis=1) for each in fields])
    return float(np.cbrt(volumes.mean()))
