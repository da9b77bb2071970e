"""A small tube and a rod, made-up frames of them, and how to write these."""

import numpy as np
import pytest
from msgspec import Struct

from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.laws import LINEAR, C, E, Law
from tissuec.laws.formula import ZERO, Choice
from tissuec.model.network import BodyPart, Network
from tissuec.model.springs import Springs
from tissuec.results.recording import LogChannel, Recording, SurfaceChannel
from tissuec.results.writer import ResultWriter

SCENE = 'language 1\nabout "a tube and a rod, größer"\n'
RINGS, SIDES = 5, 4
FRAMES, CUT, RUPTURE = 40, 17, 29  # frames from which fewer springs are alive


def tube_and_rod():
    """A tube of rings and longitudinal springs with a skin, and a rod of three nodes."""
    number = np.arange(RINGS * SIDES).reshape(RINGS, SIDES)
    ring = np.stack([number, np.roll(number, -1, axis=1)], axis=-1).reshape(-1, 2)
    along = np.stack([number[:-1], number[1:]], axis=-1).reshape(-1, 2)
    rod = RINGS * SIDES + np.array([[0, 1], [1, 2]])
    a, b = number[:-1], np.roll(number, -1, axis=1)[:-1]
    c, d = number[1:], np.roll(number, -1, axis=1)[1:]
    skin = np.concatenate([np.stack([a, b, c], -1), np.stack([b, d, c], -1)]).reshape(-1, 3)
    ends = np.concatenate([ring, along, rod]).astype(np.int32)
    nodes, springs = RINGS * SIDES + 3, len(ends)
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    circle = np.stack([np.zeros(SIDES), np.cos(angle), np.sin(angle)], axis=-1)
    rings = [circle + np.array([x, 0.0, 0.0]) for x in range(RINGS)]
    position = np.concatenate([*rings, [[9.0, 0, 0], [10, 0, 0], [11, 0, 0]]])
    span = Span(Source("scene.tis", SCENE), 0, 10)
    tube = BodyPart("tube", slice(0, RINGS * SIDES), slice(0, springs - 2), span)
    return Network(
        position=position,
        velocity=np.zeros((nodes, 3)),
        mass=np.linspace(1.0, 2.0, nodes),
        springs=Springs(
            ends=ends,
            stiffness=np.linspace(10.0, 20.0, springs),
            damping=np.linspace(0.1, 0.2, springs),
            rest=np.ones(springs),
            strength=np.full(springs, np.inf),
            crush=np.full(springs, np.inf),
            law=np.arange(springs, dtype=np.int32) % 2,
            laws=(LINEAR, Law("tension only", Choice(E, C * E, ZERO), LINEAR.viscous)),
            ids=np.concatenate([np.arange(springs - 2) + 1, [1, 2]]),
        ),
        skin=skin.astype(np.int32),
        node_ids=np.concatenate([np.arange(RINGS * SIDES) + 1, [1, 2, 3]]),
        bodies=(
            tube,
            BodyPart("rod", slice(nodes - 3, nodes), slice(springs - 2, springs), span),
        ),
        provenance={},
    )


LOGS = (
    LogChannel("force of forceps A", ("x", "y", "z"), "N", "support force"),
    LogChannel("tension of a/b", (3, 7), "N", "tensions of two springs"),
)

SURFACES = (SurfaceChannel("tube", "loop subdivision", {"subdivisions": 2}),)


class Example(Struct, frozen=True):
    """Frames of a network, and what of them is recorded."""

    network: Network
    recording: Recording
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    tension: np.ndarray
    along: tuple[int, ...]  # springs that the cut removes: those between the rings 1 and 2

    def fields(self, rows):
        """What frames contain besides positions and velocities."""
        return {"force": self.force[rows], "tension": self.tension[rows]}

    def alive(self, frame):
        alive = np.ones(self.network.entity_count, dtype=bool)
        if frame >= CUT:
            alive[list(self.along)] = False
        if frame >= RUPTURE:
            alive[0] = False
        return alive

    def recorded(self, **changes):
        """The same frames with another recording."""
        return replace(self, recording=replace(self.recording, **changes))

    def open(self, path, **manifest):
        return ResultWriter(path, self.network, self.recording, manifest, SCENE)

    def write(self, writer, first=0, last=FRAMES, batch=3, checkpoints=()):
        """Write frames, logs, energies and events, split at the cut and the rupture."""
        while first < last:
            stops = (CUT, RUPTURE, *checkpoints, last)
            stop = min(first + batch, *(s for s in stops if s > first))
            if first in (0, CUT, RUPTURE):
                self.happen(writer, first)
            rows = slice(first, stop)
            writer.frames(
                self.time[rows],
                self.position[rows],
                self.velocity[rows],
                self.fields(rows),
            )
            for surface in self.recording.surfaces:
                writer.surface(surface.body, self.time[rows], self.position[rows])
            if self.recording.logs:
                writer.log(LOGS[0].name, self.time[rows], self.force[rows, 0])
                writer.log(LOGS[1].name, self.time[rows], self.tension[rows, 3:5])
            if self.recording.energies:
                writer.energies(self.time[rows], self.tension[rows, :6])
            first = stop
            if first in checkpoints:
                writer.checkpoint({"frame": first, "position": self.position[first]})

    def happen(self, writer, frame):
        writer.topology(self.alive(frame))
        time = self.time[frame]
        if frame == CUT:
            writer.event(time, "cut", self.along, "cut tube with shears", "scene.tis:8")
            if self.recording.logs:
                writer.log_jump(LOGS[0].name, time, *self.force[frame - 1 : frame + 1, 0])
            if self.recording.energies:
                writer.energy_jump(time, *self.tension[frame - 1 : frame + 1, :6])
        if frame == RUPTURE:
            writer.event(time, "rupture", [0], "tension above 2 N", "scene.tis:3")

    def saved(self, path, **manifest):
        """Write everything and return the finished file."""
        with self.open(path, **manifest) as writer:
            self.write(writer)
            return writer.close("the run reached its end", finished=True)


def example_of_a_tube():
    """Return frames of the tube and the rod, the same ones each time."""
    network = tube_and_rod()
    random = np.random.default_rng(5)
    nodes, springs = network.node_count, network.spring_count
    vectors = [random.normal(size=(FRAMES, nodes, 3)) for _ in range(3)]
    first = RINGS * SIDES + SIDES
    return Example(
        network=network,
        recording=Recording(np.arange(nodes), np.arange(springs), False, LOGS, True),
        time=np.arange(FRAMES) * 0.04,
        position=network.position + 0.1 * vectors[0],
        velocity=vectors[1],
        force=vectors[2],
        tension=random.normal(size=(FRAMES, springs)),
        along=tuple(range(first, first + SIDES)),
    )


@pytest.fixture
def example():
    return example_of_a_tube()
