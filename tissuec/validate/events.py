"""Events of two solutions compared: ruptures and triggers, and their times."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats, Network
from tissuec.validate.crossings import Break
from tissuec.validate.solution import TriggerFiring

TIE = 1e-9  # of the duration: events closer than this have no order


class Miss(Struct, frozen=True):
    """An event of one solution only.

    Attributes:
        number: Of the spring or trigger.
        time: When it happened [s].
        in_run: Whether in the run rather than in the reference.
        strain: Of a spring, how near the other solution came to breaking it: largest tension
            or pressure over the force that breaks; of a trigger 0.
        is_tie: Whether an error of positions as large as the promise can explain it.
    """

    number: int
    time: float
    in_run: bool
    strain: float = 0.0
    is_tie: bool = False


class Matching(Struct, frozen=True):
    """Comparison of the events of a run with those of the reference.

    Attributes:
        run, reference: How many events there were.
        error: Largest difference between times of the same event [s]; 0 without any.
        worst: The spring or trigger of that event; None without any.
        in_order: Whether the events of both came in the same order.
        misses: What happened in one of them only, ascending in time.
    """

    run: int
    reference: int
    error: float
    worst: int | None
    in_order: bool
    misses: tuple[Miss, ...]


Times = dict[int, float]


def break_times(breaks: Sequence[Break]) -> Times:
    """Return when each spring broke [s]."""
    return {int(spring): entry.time for entry in breaks for spring in entry.springs}


def firing_times(firings: Sequence[TriggerFiring]) -> Times:
    """Return when each trigger fired [s]."""
    return {firing.trigger: firing.time for firing in firings}


def match(run: Times, reference: Times, misses: Sequence[Miss], duration: float) -> Matching:
    """Return how times of events in a run match those of the reference.

    Args:
        run: Times of events in the run [s].
        reference: Times of events in the reference [s].
        misses: Events of only one of them.
        duration: Of the run [s].
    """
    both = sorted(run.keys() & reference.keys(), key=lambda key: (reference[key], run[key]))
    errors = {key: abs(run[key] - reference[key]) for key in both}
    worst = max(errors, key=lambda key: errors[key], default=None)
    apart = TIE * duration
    in_order = all(
        run[before] <= run[after] + apart or reference[after] - reference[before] <= apart
        for before, after in pairwise(both)
    )
    error = errors[worst] if worst is not None else 0.0
    found = tuple(sorted(misses, key=lambda miss: miss.time))
    return Matching(len(run), len(reference), error, worst, in_order and not found, found)


def missed(run: Times, reference: Times) -> list[Miss]:
    """Return the events of one solution that are missing in the other."""
    only_run = [Miss(key, run[key], True) for key in run.keys() - reference.keys()]
    only_reference = [Miss(key, reference[key], False) for key in reference.keys() - run.keys()]
    return only_run + only_reference


def near_ties(
    misses: Sequence[Miss],
    network: Network,
    strains: tuple[Floats, Floats],
    shift: float,
) -> list[Miss]:
    """Return missed breaks with the distance of the other solution from breaking.

    Args:
        misses: Breaks in only one solution.
        network: The network.
        strains: Largest tension or pressure divided by its limit, of each spring in the run and
            in the reference, shape (spring,) each.
        shift: Allowed error of positions [m]; two ends give twice the change of length.
    """
    run, reference = strains
    found: list[Miss] = []
    for miss in misses:
        spring = miss.number
        strain = float((reference if miss.in_run else run)[spring])
        limit = min(network.springs.strength[spring], network.springs.crush[spring])
        allowed = 2.0 * network.springs.sudden[spring] * shift / limit
        tie = abs(1.0 - strain) <= allowed
        found.append(Miss(spring, miss.time, miss.in_run, strain, bool(tie)))
    return found


def between_events(
    rows: Floats, run: Times, reference: Times, duration: float
) -> NDArray[np.bool_]:
    """Return at which times an event has happened in only one solution, shape (row,).

    Forces and velocities jump at events, so that they cannot be compared there.

    Args:
        rows: Times [s], shape (row,).
        run: Times of events in the run [s].
        reference: Times of events in the reference [s].
        duration: Of the run [s].
    """
    apart = np.zeros(len(rows), dtype=bool)
    for key in run.keys() & reference.keys():
        low, high = sorted((run[key], reference[key]))
        apart |= (rows >= low - TIE * duration) & (rows <= high + TIE * duration)
    return apart
