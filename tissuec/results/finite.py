"""Checks that numbers in frames are finite."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.model.network import Floats, Network
from tissuec.results.recording import body_of

LARGEST = np.float64(1e100)  # as in scenes


def are_numbers(data: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which entries are finite and have finite squares, in the shape of ``data``.

    Args:
        data: In any unit, of any shape.
    """
    return np.abs(data) < LARGEST  # false for NaN


def all_numbers(data: NDArray[Any]) -> bool:
    """Return whether all entries, of any shape and unit, are finite and have finite squares."""
    return not data.size or bool(data.max() < LARGEST and data.min() > -LARGEST)


def check_times(time: ArrayLike, *, after: float) -> Floats:
    """Return ``time`` as an array of shape (frame,) [s].

    Raises:
        ValueError: A time is not finite, or earlier than the one before it or ``after``.
    """
    times = np.atleast_1d(np.asarray(time, dtype=float))
    if times.ndim != 1 or not np.isfinite(times).all():
        raise ValueError(
            f"times of frames must be a one-dimensional array of finite numbers, not {time}"
        )
    if (np.diff(times, prepend=after) < 0).any():
        raise ValueError(f"times of frames must ascend, but {times} s follows {after} s")
    return times


def check_finite(
    data: NDArray[Any],
    quantity: str,
    time: Floats,
    network: Network,
    numbers: NDArray[np.integer],
    what: str,
) -> None:
    """Refuse arrays with an entry that is not finite; the message names the first one.

    Args:
        data: In any unit, shape (frame, node or spring, …).
        quantity: Its name in the message, such as "position".
        time: Times of the frames [s], shape (frame,).
        network: Whose ids the message uses.
        numbers: Network numbers of the second axis.
        what: "node", "spring", "triangle" or "cell".

    Raises:
        ValueError: An entry is not finite.
    """
    if all_numbers(data):
        return
    finite = are_numbers(data)
    place = tuple(np.argwhere(~finite)[0])
    number = int(numbers[place[1]])
    identity, name = _named(network, number, what)
    owner = f' of "{name}"' if name else ""
    fits = " in single precision" if data.dtype == np.float32 else ""
    raise ValueError(
        f"the {quantity} of {what} {identity}{owner} is {data[place]}{fits} "
        f"at {time[place[0]]:.9g} s"
    )


def _named(network: Network, number: int, what: str) -> tuple[int, str]:
    """Return the id of something, and the name of what it belongs to."""
    if what == "node":
        return int(network.node_ids[number]), body_of(network, number)
    if what == "spring":
        return int(network.springs.ids[number]), network.owner(number).name
    owner = body_of(network, int(network.skin[number, 0])) if what == "triangle" else ""
    return number, owner


def check_shape(data: NDArray[Any], shape: tuple[int, ...], name: str) -> None:
    """Refuse an array of another shape.

    Args:
        data: The array, in any unit.
        shape: The required shape.
        name: Its name in the message.

    Raises:
        ValueError: The shape is another one.
    """
    if data.shape != shape:
        raise ValueError(f"{name} has shape {data.shape}, not {shape}")
