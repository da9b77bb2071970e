"""A block of 4 x 2 x 2 hexahedra whose second column a plane cuts: parts built by hand."""

from functools import cache

import numpy as np

from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.geometry.elements import CUBE
from tissuec.model.cut_cells import CutCells, WeightedSums
from tissuec.model.phantoms import Phantoms, Reserve
from tissuec.pipeline import compile_request
from tissuec.results.fields import channels
from tissuec.results.recording import Recording
from tissuec.results.writer import ResultWriter
from tissuec.scene.request import Request

H = 10e-3  # edge of a cell [m]
SHARE = 0.6  # of the cells in front of the plane
SCENE = """language 1
tissue gel {
  Young's modulus = 20 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  fibre modulus = 40 kPa
}
body block {
  mesh is lattice { cell = 10 mm; box from (0, 0, 0) mm to (40, 20, 20) mm }
  tissue is gel; fibres = (0, 1, 0); region left where x < 20 mm { tissue is gel }
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""
#: Six tetrahedra around a diagonal of a box with the corners of ``CUBE``.
BOX = np.array(
    [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
)
FACES = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [3, 7, 6, 2], [0, 4, 7, 3], [1, 2, 6, 5]]
)
LEFT, RIGHT = 4, 5  # faces across x
CUT, FRAMES = 3, 6  # the first frame after the cut, and how many there are
TIMES = 0.1 * np.arange(FRAMES)


class CutBlock:
    """The block, with phantom nodes and reserved entities, and what a cut makes of it.

    Attributes:
        network: Compiled, with 18 more nodes and 8 more entities.
        table: Eight parts: of each crossed cell the one behind the plane, then the one in
            front.
        crossed, severed: Entities of the cells and of the edges that are cut.
        front: Which nodes move with what is in front of the plane.
    """

    def __init__(self):
        compiled = compile_request(Request(Source("scene.tis", SCENE)))[0]
        drawn = compiled.network
        (block,) = drawn.blocks
        solid, place = block.field, drawn.position
        column = np.round(place[:, 0] / H).astype(int)
        parents = np.flatnonzero((column == 1) | (column == 2))
        phantom = np.full(len(place), -1)
        phantom[parents] = len(place) + np.arange(len(parents))
        middle = place[solid.nodes].mean(axis=1)[:, 0]
        cells = np.flatnonzero((middle > H) & (middle < 2 * H))
        self.crossed = solid.walls[cells]
        body, count = drawn.bodies[0], 2 * len(cells)
        whole = drawn.skin[:, :1] * 0 - 1
        faces = np.sort(solid.nodes[:, FACES].reshape(-1, 4), axis=1)
        owner = np.repeat(solid.walls, 6)
        for number, triangle in enumerate(drawn.skin):
            fits = np.isin(faces, triangle).sum(axis=1) == 3
            (whole[number],) = owner[fits]
        mass = drawn.provenance["mass"]
        self.network = replace(
            drawn,
            position=np.concatenate([place, place[parents]]),
            velocity=np.zeros((len(place) + len(parents), 3)),
            mass=np.concatenate([drawn.mass, drawn.mass[parents]]),
            node_ids=np.arange(len(place) + len(parents)),
            bodies=(
                replace(
                    body,
                    nodes=slice(0, len(place) + len(parents)),
                    elements=slice(body.elements.start, body.elements.stop + count),
                    reserve=Reserve(len(parents), count, 1),
                ),
            ),
            phantoms=(
                Phantoms(
                    "block",
                    slice(len(place), len(place) + len(parents)),
                    parents,
                    slice(body.elements.stop, body.elements.stop + count),
                    1,
                ),
            ),
            skin_elements=whole.ravel().astype(np.int64),
            provenance={"mass": replace(mass, index=mass.index[[*range(45), *parents]])},
        )  # fmt: skip
        self.solid, self.cells = solid, cells
        across = np.sort(column[drawn.edges], axis=1) == [1, 2]
        self.severed = drawn.spring_count + np.flatnonzero(across.all(axis=1))
        reserved = np.arange(body.elements.stop, body.elements.stop + count)
        self.parts = reserved
        self.front = np.concatenate([column >= 2, column[parents] == 1])
        self.table = self.parts_of(place, phantom)

    def parts_of(self, place, phantom):
        """Return both parts of each crossed cell."""
        hosts, weights, corners, owners = [], [], [], []
        triangles, borders, cuts = [], [], []
        bounds = {tuple(sorted(one)) for one in self.network.skin.tolist()}
        count, known = self.network.node_count, {}

        def rider(low, high):
            """Return the point where the plane meets an edge, from nodes of a part."""
            if (low, high) not in known:
                known[low, high] = count + len(known)
                hosts.extend((low, high))
                weights.extend((1 - SHARE, SHARE))
            return known[low, high]

        part = iter(self.parts.tolist())
        for cell in self.cells:
            nodes = self.solid.nodes[cell]
            is_low = place[nodes, 0] < 1.5 * H
            for in_front in (False, True):
                own = np.where(is_low == in_front, phantom[nodes], nodes)
                place_of = {tuple(CUBE[k]): own[k] for k in range(8)}
                box = []
                for k in range(8):
                    _, y, z = CUBE[k]
                    ends = place_of[-1.0, y, z], place_of[1.0, y, z]
                    box.append(own[k] if is_low[k] != in_front else rider(*ends))
                box, entity = np.array(box), next(part)
                corners.append(box[BOX])
                owners += [entity] * 6
                for number, face in enumerate(FACES):
                    is_cut = number == (LEFT if in_front else RIGHT)
                    drawn = {*nodes[face].tolist()}
                    is_outer = sum({*one} <= drawn for one in bounds) == 2
                    if (number not in (LEFT, RIGHT) and is_outer) or is_cut:
                        triangles += [box[face[[0, 1, 2]]], box[face[[0, 2, 3]]]]
                        borders += [entity] * 2
                        cuts += [(1 if in_front else -1) * is_cut] * 2
        sums = WeightedSums.of(
            np.full(len(known), 2), np.array(hosts, dtype=np.int64), np.array(weights)
        )
        return CutCells(
            count, sums, self.parts, np.repeat(self.crossed, 2), np.concatenate(corners),
            np.array(owners), np.array(triangles), np.array(borders), np.array(cuts),
        )  # fmt: skip

    def alive(self, frame):
        alive = np.ones(self.network.entity_count, dtype=bool)
        alive[self.crossed if frame >= CUT else self.parts] = False
        if frame >= CUT:
            alive[self.severed] = False
        return alive

    def position(self, frame, gap=5e-3):
        """The front moves away after the cut, and all of it is turned a little."""
        place = self.network.position.copy()
        place[self.front, 0] += gap * max(0, frame - CUT + 1) / (FRAMES - CUT)
        turn = 0.1 * frame
        about = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0]])
        return place @ np.vstack([about, [0, 0, 1]]).T

    def positions(self):
        return np.stack([self.position(frame) for frame in range(FRAMES)])

    def recording(self, fields=("von Mises stress", "stress tensor"), **changes):
        nodes, lines = np.arange(self.network.node_count), np.arange(self.network.line_count)
        found = Recording(nodes, lines, False, (), False, fields=channels(fields))
        return replace(found, **changes)

    def fields(self, rows):
        """Numbers that tell where they are: of entities, their number; of nodes, places."""
        place = self.positions()
        items = np.concatenate([self.solid.walls, self.parts]).astype(float)
        count = self.network.spring_count
        found = {
            "force": place + 1.0,
            "tension": np.zeros((FRAMES, count)),
            "von Mises stress": place[..., 0] + 1.0,
            "stress tensor": np.tile(items[:, None], (FRAMES, 1, 6)),
        }
        return {name: each[rows] for name, each in found.items()}

    def open(self, path, recording=None, text=SCENE):
        return ResultWriter(path, self.network, recording or self.recording(), {}, text)

    def write(self, writer, first=0, checkpoints=()):
        """Write frames one after another, and checkpoints before some of them."""
        place = self.positions()
        for frame in range(first, FRAMES):
            if frame in (0, CUT):
                writer.topology(self.alive(frame), self.table if frame == CUT else None)
            rows = slice(frame, frame + 1)
            writer.frames(TIMES[rows], place[rows], 2.0 * place[rows], self.fields(rows))
            if frame + 1 in checkpoints:
                writer.checkpoint({"frame": frame + 1})

    def saved(self, path, recording=None, text=SCENE):
        with self.open(path, recording, text) as writer:
            self.write(writer)
            return writer.close("done", finished=True)


@cache
def cut_block():
    """Return the block; the same one each time."""
    return CutBlock()
