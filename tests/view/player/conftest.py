"""Results to be shown: the sterilisation, and small ones that are made up."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import Struct, field

from tissuec.core.structs import replace
from tissuec.model.network import Network
from tissuec.results.recording import LogChannel, Recording
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter


@pytest.fixture(scope="session")
def sterilisation(shipped) -> Path:
    """The result of the sterilisation that is shipped."""
    return shipped("sterilisation").path


def grid(rows: int, columns: int, *, size: float = 0.1) -> Network:
    """A flat sheet of one body, with one diagonal in each cell, and its skin."""
    from tests.hand_net import span
    from tissuec.laws import LINEAR
    from tissuec.model.network import BodyPart
    from tissuec.model.springs import Springs

    node = np.arange(rows * columns).reshape(rows, columns)
    pairs = [(node[:, :-1], node[:, 1:]), (node[:-1], node[1:]), (node[:-1, :-1], node[1:, 1:])]
    ends = np.concatenate([np.stack(pair, -1).reshape(-1, 2) for pair in pairs])
    a, b, c, d = node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]
    skin = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    x, y = np.meshgrid(
        np.linspace(0.0, size, rows), np.linspace(0.0, size, columns), indexing="ij"
    )
    position = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    nodes, springs = len(position), len(ends)
    return Network(
        position=position,
        velocity=np.zeros((nodes, 3)),
        mass=np.full(nodes, 1e-3),
        springs=Springs(
            ends=ends.astype(np.int32),
            stiffness=np.full(springs, 10.0),
            damping=np.zeros(springs),
            rest=np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1),
            strength=np.full(springs, np.inf),
            crush=np.full(springs, np.inf),
            law=np.zeros(springs, dtype=np.int32),
            laws=(LINEAR,),
            ids=np.arange(springs),
        ),
        skin=skin.astype(np.int32),
        node_ids=np.arange(nodes),
        bodies=(BodyPart("sheet", slice(0, nodes), slice(0, springs), span()),),
        provenance={},
    )


def without_springs(network: Network) -> Network:
    """The nodes of a network alone."""
    body = replace(network.bodies[0], springs=slice(0, 0))
    return replace(
        network,
        springs=network.springs.some(np.zeros(0, dtype=np.int64)),
        skin=np.zeros((0, 3), dtype=np.int32),
        bodies=(body,),
    )


class Show(Struct):
    """A result to be made up.

    Attributes:
        frames: How many.
        cut: From this frame on, springs across the middle are gone.
        logs: Names -> rows of one column, at the times of the frames; the cut changes them
            at once, from the row before to the one after it.
        finished: Whether the run came to its end.
    """

    network: Network
    frames: int = 5
    cut: int | None = None
    step: float = 0.02
    logs: dict[str, Any] = field(default_factory=dict)
    scene: str = "made up.tis"
    text: str = "language 1\n"
    about: str = ""
    finished: bool = True

    def crossing(self) -> np.ndarray:
        """Return which springs cross the middle, shape (spring,)."""
        x = self.network.position[self.network.springs.ends][:, :, 0]
        middle = self.network.position[:, 0].mean() + 1e-9
        return (x.min(axis=1) < middle) & (x.max(axis=1) >= middle)

    def place(self, frame: int) -> np.ndarray:
        """Return where the nodes are [m]: they rise, and part after the cut."""
        place = self.network.position.copy()
        place[:, 2] += 0.002 * frame * np.sin(40.0 * place[:, 0])
        if self.cut is not None and frame >= self.cut:
            place[place[:, 0] >= self.network.position[:, 0].mean() + 1e-9, 0] += 0.02
        return place

    def write(self, path: Path) -> Path:
        """Write it, and return where it is."""
        net = self.network
        channels = tuple(LogChannel(name, ("value",), "N", "made up") for name in self.logs)
        recording = Recording(
            np.arange(net.node_count), np.arange(net.spring_count), False, channels, False
        )
        manifest = {"scene": self.scene, "about": self.about}
        with ResultWriter(path, net, recording, manifest, self.text) as writer:
            alive = np.ones(net.spring_count, dtype=bool)
            writer.topology(alive)
            for frame in range(self.frames):
                if frame == self.cut:
                    alive = ~self.crossing()
                    writer.topology(alive)
                    gone = np.flatnonzero(~alive).tolist()
                    writer.event((frame - 0.5) * self.step, "cut", gone, "cut", "made.tis:1")
                place = self.place(frame)
                way = place[net.springs.ends[:, 1]] - place[net.springs.ends[:, 0]]
                length = np.linalg.norm(way, axis=1)
                tension = net.springs.stiffness * (length - net.springs.rest)
                force = np.zeros_like(place)
                pull = way * (alive * tension / np.maximum(length, 1e-12))[:, None]
                np.add.at(force, net.springs.ends[:, 0], pull)
                np.add.at(force, net.springs.ends[:, 1], -pull)
                writer.frames(
                    [frame * self.step],
                    place[None],
                    0.0 * place[None],
                    {"force": force[None], "tension": tension[None]},
                )
            for name, rows in self.logs.items():
                rows = np.asarray(rows, dtype=float)
                writer.log(name, self.step * np.arange(len(rows)), rows[:, None])
                if self.cut is not None and len(rows) > self.cut:
                    before, after = rows[self.cut - 1 : self.cut + 1, None]
                    writer.log_jump(name, (self.cut - 0.5) * self.step, before, after)
            return writer.close("done" if self.finished else "interrupted", self.finished)


@pytest.fixture
def shown(tmp_path):
    """Return a function that writes a made-up result and opens it."""
    opened = []

    def make(show: Show, name: str = "made.vtkhdf") -> Trajectory:
        opened.append(Trajectory.open(show.write(tmp_path / name)))
        return opened[-1]

    yield make
    for one in opened:
        one.close()
