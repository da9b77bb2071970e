"""The state from which an interrupted run resumes, and the part of the file that is valid.

A checkpoint contains its format, the version of the program, and digests of the scene and the
network.
"""

import json
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.version import __version__
from tissuec.model.network import Network
from tissuec.results import ResultError, access
from tissuec.results.access import Dataset, ResultGroup
from tissuec.results.arrays import array_of
from tissuec.results.schema import CHECKPOINT, NETWORK
from tissuec.results.store import Store, member_name

FORMAT = 8  # another number for any other entries
Value = NDArray[Any] | int | float | bool | str


class Checkpoint(Struct, frozen=True, eq=False):
    """Contents of the last checkpoint of a file.

    Attributes:
        state: What the run gave, by name; arrays, numbers and texts as they were given.
        rows: How many rows every growing dataset had.
        alive: Which entities were alive, shape (entity,).
        wall_time: How long the run had taken [s].
        scene: Digest of the scene and the network that were run.
    """

    state: Mapping[str, Value]
    rows: Mapping[str, int]
    alive: NDArray[np.bool_]
    wall_time: float
    scene: str


def scene_digest(text: str, network: Network) -> str:
    """Return the SHA-256 of a scene and of the arrays that it was compiled to."""
    total = sha256(text.encode())
    for name in NETWORK:
        value = array_of(network, name)
        total.update(f"{name} {value.dtype.str} {value.shape}".encode())
        total.update(np.ascontiguousarray(value).data)
    return total.hexdigest()


def write_checkpoint(store: Store, checkpoint: Checkpoint) -> None:
    """Replace the checkpoint of a file; it takes effect with the next commit.

    Raises:
        ValueError: A value is no number, text or array of numbers.
    """
    names = {member_name(name): name for name in checkpoint.state}
    state = CHECKPOINT["state/{name}"]
    for former in set(store.group(state.path.rpartition("/")[0])) - set(names):
        store.remove(state.of(name=former).path)
    for member, name in names.items():
        value = checkpoint.state[name]
        if not isinstance(value, str) and np.asarray(value).dtype.kind not in "biuf":
            raise ValueError(f'"{name}" is not a number, text or array of numbers')
        store.array(state.of(name=member), value)
        store.label(state.of(name=member).path, name=name)
    store.arrays(
        CHECKPOINT,
        rows=json.dumps(checkpoint.rows),
        version=json.dumps([FORMAT, __version__]),
        scene=checkpoint.scene,
        alive=checkpoint.alive,
        wall_time=checkpoint.wall_time,
    )


def read_checkpoint(file: ResultGroup) -> Checkpoint | None:
    """Return the last checkpoint in ``file``; None if there never was one.

    Raises:
        ResultError: Another version of tissuec wrote it, or it is not as it was written.
    """
    if CHECKPOINT.path not in file:
        return None
    group = access.group(file, CHECKPOINT.path)
    _check_version(group)
    members = access.group(group, "state")
    values = [access.dataset(members, member) for member in members]
    state = {access.attribute(value, "name", str): _value(members, value) for value in values}
    rows, wall_time = access.json(group, "rows"), access.number(group, "wall_time")
    scene = access.text(group, "scene")
    return Checkpoint(state, rows, access.array(group, "alive"), wall_time, scene)


def _check_version(group: ResultGroup) -> None:
    """Refuse the checkpoint of another version, which might continue differently."""
    written = access.json(group, "version") if "version" in group else None
    if written != [FORMAT, __version__]:
        version = "another version of tissuec"
        if isinstance(written, list) and written[:1] == [FORMAT]:
            version = f"tissuec {written[-1]}"
        raise ResultError(
            f'"{group.file}" has a checkpoint of {version}, but this is '
            f"{__version__}: only the version that wrote it can resume"
        )


def truncate(store: Store, checkpoint: Checkpoint) -> None:
    """Cut every growing dataset to its size at ``checkpoint``.

    Raises:
        ResultError: The file holds less than that: the checkpoint is not of this file.
    """
    for path, rows in checkpoint.rows.items():
        if path not in store.file or len(access.dataset(store.content, path)) < rows:
            raise ResultError(
                f'cannot resume "{store.path}": "{path}" has fewer than the {rows} rows of the '
                "checkpoint, which must come from another file"
            )
        store.truncate(path, rows)


def _value(group: ResultGroup, dataset: Dataset) -> Value:
    if dataset.dtype.kind in "SO":
        return access.text(group, dataset.path)
    data = dataset.whole()
    return data if dataset.shape else data.item()
