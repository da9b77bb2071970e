"""The state from which an interrupted run goes on, and how much of the file belongs to it.

A checkpoint says of which format, of which version of the program and of which scene and
network it is, and has a checksum of all that.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from typing import TYPE_CHECKING

import h5py
import numpy as np
from numpy.typing import NDArray

from tissuec import __version__
from tissuec.network import Network
from tissuec.results import access
from tissuec.results.arrays import ARRAYS
from tissuec.results.errors import ResultError
from tissuec.results.store import Store, member_name

if TYPE_CHECKING:
    from hashlib import _Hash as Hash

CHECKPOINT = "/tissuec/checkpoint"
FORMAT = 1
Value = NDArray | int | float | bool | str


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """What the last checkpoint of a file holds.

    Attributes:
        state: What the run gave, by name; arrays, numbers and texts as they were given.
        rows: How many rows every growing dataset had.
        alive: Which springs were alive, shape (spring,).
        wall_time: How long the run had taken [s].
        scene: Digest of the scene and the network that were run.
    """

    state: Mapping[str, Value]
    rows: Mapping[str, int]
    alive: NDArray[np.bool_]
    wall_time: float
    scene: str

    def checksum(self) -> str:
        """Return the SHA-256 of all that is kept, and of the versions."""
        about = [FORMAT, __version__, self.scene, self.wall_time, sorted(self.rows.items())]
        total = sha256(json.dumps(about).encode())
        for name, value in [*sorted(self.state.items()), ("", self.alive)]:
            _add(total, name, value)
        return total.hexdigest()


def scene_digest(text: str, network: Network) -> str:
    """Return the SHA-256 of a scene and of the arrays that it was compiled to."""
    total = sha256(text.encode())
    for name in ARRAYS:
        _add(total, name, getattr(network, name))
    return total.hexdigest()


def _add(total: "Hash", name: str, value: Value) -> None:
    """Add a value to a digest, with its name, kind and shape."""
    if np.ndim(value) == 0:
        plain = value if isinstance(value, str) else np.asarray(value).item()
        total.update(json.dumps([name, plain]).encode())
        return
    data = np.ascontiguousarray(value)
    total.update(json.dumps([name, data.dtype.str, data.shape]).encode())
    total.update(data)


def write_checkpoint(store: Store, checkpoint: Checkpoint) -> None:
    """Put ``checkpoint`` in the place of the former one; it counts from the next commit on."""
    names = {member_name(name): name for name in checkpoint.state}
    group = store.group(f"{CHECKPOINT}/state")
    for former in set(group) - set(names):
        del group[former]
    for member, name in names.items():
        value = checkpoint.state[name]
        if not isinstance(value, str) and np.asarray(value).dtype.kind not in "biuf":
            raise ValueError(f'"{name}" is no number, text or array of numbers')
        store.array(f"{CHECKPOINT}/state/{member}", value, "part of the state to go on from")
        attributes = access.dataset(group, member).attrs
        if "name" not in attributes:
            attributes["name"] = name
    for name, text, description in (
        ("rows", json.dumps(checkpoint.rows), "rows of every growing dataset, as JSON"),
        ("version", json.dumps([FORMAT, __version__]), "of this format and of tissuec"),
        ("scene", checkpoint.scene, "SHA-256 of the scene and the network"),
        ("checksum", checkpoint.checksum(), "SHA-256 of all of this"),
    ):
        store.array(f"{CHECKPOINT}/{name}", text, description)
    store.array(f"{CHECKPOINT}/alive", checkpoint.alive, "which springs were alive")
    store.array(
        f"{CHECKPOINT}/wall_time", checkpoint.wall_time, "how long it had taken", unit="s"
    )


def read_checkpoint(file: h5py.File) -> Checkpoint | None:
    """Return the last checkpoint in ``file``; None if there never was one.

    Raises:
        ResultError: Another version of tissuec wrote it, or it is not as it was written.
    """
    if CHECKPOINT not in file:
        return None
    group = access.group(file, CHECKPOINT)
    _check_version(group)
    members = access.group(group, "state")
    values = [access.dataset(members, str(member)) for member in members]
    state = {str(access.attribute(value, "name")): _value(value) for value in values}
    rows = json.loads(access.text(group, "rows"))
    wall_time = float(access.dataset(group, "wall_time")[()])
    scene = access.text(group, "scene")
    checkpoint = Checkpoint(state, rows, access.array(group, "alive"), wall_time, scene)
    if access.text(group, "checksum") != checkpoint.checksum():
        access.damaged(file, "its checkpoint is not as it was written")
    return checkpoint


def _check_version(group: h5py.Group) -> None:
    """Refuse the checkpoint of another version, which might go on otherwise."""
    written = json.loads(access.text(group, "version")) if "version" in group else None
    if written != [FORMAT, __version__]:
        known = isinstance(written, list) and written[:1] == [FORMAT]
        version = f"tissuec {written[-1]}" if known else "another version of tissuec"
        raise ResultError(
            f'"{group.file.filename}" holds a checkpoint of {version}, and this is '
            f"{__version__}: only the version that wrote it can go on from there"
        )


def truncate(store: Store, checkpoint: Checkpoint) -> None:
    """Cut every growing dataset to what it was at ``checkpoint``.

    Raises:
        ResultError: The file holds less than that: the checkpoint is not of this file.
    """
    for path, rows in checkpoint.rows.items():
        dataset = store.file.get(path)
        if not isinstance(dataset, h5py.Dataset) or len(dataset) < rows:
            raise ResultError(
                f'cannot resume "{store.path}": "{path}" has fewer than the {rows} rows of the '
                "checkpoint, which must come from another file"
            )
        dataset.resize(rows, axis=0)


def _value(dataset: h5py.Dataset) -> Value:
    if h5py.check_string_dtype(dataset.dtype):
        return str(dataset.asstr()[()])
    return dataset[:] if dataset.shape else dataset[()].item()
