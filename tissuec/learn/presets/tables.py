"""Numbers of single springs and nodes as tables beside a preset.

The language gives single springs numbers of their own only where their whole net is typed in.
So these tables are for people and for other programs; they have exactly what was learnt.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from msgspec import Struct

from tissuec.core.units import si_unit
from tissuec.learn.fit.outcome import Estimates, Learnt
from tissuec.learn.presets.comments import ONE_BY_ONE
from tissuec.model.network import Network

_AXES = "xyz"


class LearntTables(Struct, frozen=True):
    """Tables of numbers that were learnt one by one.

    Attributes:
        texts: By the names of files.
        names: These names by the places of the estimates in what was learnt.
    """

    texts: Mapping[str, str]
    names: dict[int, str]


def tables(learnt: Learnt, network: Network, target: Path, mark: str) -> LearntTables:
    """Return the tables of everything that was learnt per spring or per node.

    ``fat_springs.csv`` beside ``fat.tis``, or with numbers where there are several.
    """
    places = [k for k, one in enumerate(learnt.estimates) if one.adjust.per in ONE_BY_ONE]
    kinds = [learnt.estimates[place].adjust.per for place in places]
    texts: dict[str, str] = {}
    names: dict[int, str] = {}
    for number, (place, kind) in enumerate(zip(places, kinds, strict=True)):
        which = f"_{kinds[: number + 1].count(kind)}" if kinds.count(kind) > 1 else ""
        names[place] = f"{target.stem}_{kind}s{which}.csv"
        texts[names[place]] = _text(learnt.estimates[place], network, mark)
    return LearntTables(texts, names)


def _text(estimates: Estimates, network: Network, mark: str) -> str:
    adjust = estimates.adjust
    unit = si_unit(adjust.dimension)
    what = f"# {adjust.what} per {adjust.per} of {adjust.of}{f', in {unit}' if unit else ''}"
    rows = _spring_rows if adjust.per == "spring" else _node_rows
    lines = [mark, f"{what}; low and high: 95 %", *rows(estimates, network)]
    return "\n".join([*lines, ""])


def _spring_rows(estimates: Estimates, network: Network) -> Iterator[str]:
    members = estimates.adjust.members
    ends = network.node_ids[network.springs.ends[members]]
    yield "id,a,b,value,low,high,identified"
    for spring, (a, b), rest in zip(
        network.springs.ids[members].tolist(), ends.tolist(), _values(estimates), strict=True
    ):
        yield f"{spring},{a},{b},{rest}"


def _node_rows(estimates: Estimates, network: Network) -> Iterator[str]:
    """Yield the header and the rows; places and velocities may have one for each axis."""
    members, count = estimates.adjust.members, len(estimates.value)
    has_axes = count == 3 * len(members)
    ids = network.node_ids[np.repeat(members, 3) if has_axes else members]
    yield f"id,{'axis,' if has_axes else ''}value,low,high,identified"
    for number, (node, rest) in enumerate(zip(ids.tolist(), _values(estimates), strict=True)):
        yield f"{node},{f'{_AXES[number % 3]},' if has_axes else ''}{rest}"


def _values(estimates: Estimates) -> Iterator[str]:
    """Yield value, low and high as the shortest numbers that are exactly these."""
    for value, low, high, known in zip(
        estimates.value.tolist(),
        estimates.low.tolist(),
        estimates.high.tolist(),
        estimates.identified.tolist(),
        strict=True,
    ):
        yield f"{value!r},{low!r},{high!r},{'yes' if known else 'no'}"
