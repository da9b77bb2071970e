"""The state from which an interrupted run goes on, and how much of the file belongs to it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass

import h5py
import numpy as np
from numpy.typing import NDArray

from tissuec.results import access
from tissuec.results.errors import ResultError
from tissuec.results.store import Store, member_name

CHECKPOINT = "/tissuec/checkpoint"
Value = NDArray | int | float | bool | str


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """What the last checkpoint of a file holds.

    Attributes:
        state: What the run gave, by name; arrays, numbers and texts as they were given.
        rows: How many rows every growing dataset had.
        alive: Which springs were alive, shape (spring,).
        wall_time: How long the run had taken [s].
    """

    state: Mapping[str, Value]
    rows: Mapping[str, int]
    alive: NDArray[np.bool_]
    wall_time: float


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
    rows = json.dumps(checkpoint.rows)
    store.array(f"{CHECKPOINT}/rows", rows, "rows of every growing dataset, as JSON")
    store.array(f"{CHECKPOINT}/alive", checkpoint.alive, "which springs were alive")
    store.array(
        f"{CHECKPOINT}/wall_time", checkpoint.wall_time, "how long it had taken", unit="s"
    )


def read_checkpoint(file: h5py.File) -> Checkpoint | None:
    """Return the last checkpoint in ``file``; None if there never was one."""
    if CHECKPOINT not in file:
        return None
    group = access.group(file, CHECKPOINT)
    members = access.group(group, "state")
    values = [access.dataset(members, str(member)) for member in members]
    state = {str(access.attribute(value, "name")): _value(value) for value in values}
    rows = json.loads(access.text(group, "rows"))
    wall_time = float(access.dataset(group, "wall_time")[()])
    return Checkpoint(state, rows, access.array(group, "alive"), wall_time)


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
