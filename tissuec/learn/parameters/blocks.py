"""Parameters of each ``adjust`` entry: their values, places and prior expectations.

Parameters are pure numbers that begin at 0: logarithms of what is positive, over its value at
the beginning, and otherwise differences in units of a scale.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct
from scipy import sparse

from tissuec.compiler.compile import Compiled
from tissuec.compiler.learning.laws import is_variable
from tissuec.compiler.learning.starts import (
    ARRAYS,
    array_of,
    is_given,
    start_of,
    start_of_tissues,
)
from tissuec.core.names import key_of
from tissuec.learn.parameters.numbers import NumberOrder
from tissuec.learn.parameters.substitution import ForcePlace, UsePlace
from tissuec.model.network import Floats, Indices
from tissuec.scene.tissues.quantities import QUANTITIES, STIFFENING
from tissuec.script.fit_problem import START_POSITION, START_VELOCITY, Adjust

_SMALL = {"prestress": 0.01}  # what counts as one of them, where the beginning is at zero


class ParameterBlock(Struct, frozen=True, eq=False):
    """The parameters of one ``adjust`` entry.

    Attributes:
        names: What each is, shape (parameter,).
        start: Values at the beginning, in SI units, shape (parameter,).
        scale: Of differences; None where parameters are logarithms.
        group: Of those that act on entries of an array: which parameter each entry belongs to,
            -1 for none, shape (entry,); None for numbers of tissues, laws and forces.
        places: Of numbers of tissues, laws and forces: where each is used.
        parts: Whose each number is: a part of a body by name, or a spring or node by number.
        is_variable: Whether these are constants of laws with exact derivatives.
    """

    adjust: Adjust
    names: tuple[str, ...]
    start: Floats
    scale: float | None
    group: Indices | None = None
    places: tuple[UsePlace | ForcePlace, ...] = ()
    parts: "tuple[str, ...] | Indices" = ()
    is_variable: bool = False

    @property
    def is_constant(self) -> bool:
        """Return whether these are constants of laws."""
        what = self.adjust.what
        is_known = what in ARRAYS or (what in QUANTITIES and what != STIFFENING)
        return not self.is_of_force and not is_known

    @property
    def is_of_force(self) -> bool:
        """Return whether this is a number of a force."""
        return self.adjust.per == "force"

    @property
    def is_difference(self) -> bool:
        """Return whether these are differences whose scale only their start suggests."""
        may_be = self.is_constant or self.is_of_force or self.adjust.what == "prestress"
        return self.scale is not None and may_be

    @property
    def array(self) -> str:
        """Return the name of the array that changes."""
        return array_of(self.adjust.what)

    def value(self, theta: Floats) -> Floats:
        """Return the values in SI units, shape (parameter,)."""
        if self.scale is None:
            return self.start * np.exp(theta)
        return self.start + self.scale * theta

    def theta(self, value: Floats | float) -> Floats:
        """Return the parameters of some values; infinite where no parameter has the value.

        Args:
            value: In SI units, shape (parameter,) or a number.

        Returns:
            Parameters, dimensionless, shape (parameter,).
        """
        if self.scale is not None:
            return (value - self.start) / self.scale
        with np.errstate(divide="ignore"):
            return np.log(np.maximum(value, 0.0) / self.start)

    def slope(self, theta: Floats) -> Floats:
        """Return the derivatives of the values, in SI units, shape (parameter,)."""
        return self.value(theta) if self.scale is None else np.full(len(theta), self.scale)


def block_of(adjust: Adjust, compiled: Compiled) -> ParameterBlock:
    """Return the parameters of an entry of a fit_problem."""
    if adjust.per == "force":
        return _force_block(adjust, compiled)
    if adjust.per in ("tissue", "region"):
        return _tissue_block(adjust, compiled)
    if adjust.what in (START_POSITION, START_VELOCITY):
        return _start_block(adjust, compiled)
    return _entry_block(adjust, compiled)


def _entry_block(adjust: Adjust, compiled: Compiled) -> ParameterBlock:
    """Return factors of entries of an array, or one that a set of them shares."""
    network, start = compiled.network, start_of(adjust, compiled)
    group = np.full(len(network.array(array_of(adjust.what))), -1, dtype=np.int64)
    if adjust.per == "set":
        group[adjust.members] = 0
        name = f"{_called(adjust.what)} of {adjust.of}"
        return ParameterBlock(adjust, (name,), start, None, group, parts=(adjust.of,))
    group[adjust.members] = np.arange(len(adjust.members))
    ids = network.springs.ids if adjust.per == "spring" else network.node_ids
    names = tuple(
        f"{_called(adjust.what)} of {adjust.per} {ids[m]} of {adjust.of}"
        for m in adjust.members.tolist()
    )
    return ParameterBlock(adjust, names, start, None, group, parts=np.asarray(adjust.members))


def _tissue_block(adjust: Adjust, compiled: Compiled) -> ParameterBlock:
    """Return numbers of a tissue or of its laws, or those of each part of a body."""
    scene = compiled.scene
    if adjust.per == "region":
        body = scene.bodies[key_of(adjust.of)]
        parts = [("", body.tissue), *((r.name, r.tissue or body.tissue) for r in body.regions)]
        used = [(name, tissue) for name, tissue in parts if tissue is not None]
        places = tuple(
            UsePlace(key_of(tissue.name), (key_of(body.name), key_of(name)))
            for name, tissue in used
        )
        names = tuple(
            f"{_called(adjust.what)} of {n + ' of ' if n else ''}{body.name}" for n, _ in used
        )
        tissues, whose = [tissue for _, tissue in used], tuple(name for name, _ in used)
    else:
        tissues, whose = [scene.tissues[key_of(adjust.of)]], (adjust.of,)
        places, names = (
            (UsePlace(key_of(adjust.of)),),
            (f"{_called(adjust.what)} of {adjust.of}",),
        )
    start = start_of_tissues(adjust.what, tissues, scene)
    may_turn = adjust.what == "prestress" or not is_given(adjust.what, tissues)
    positive = bool((start > 0.0).all()) and not may_turn
    scale = None if positive else max(float(np.abs(start).max()), _SMALL.get(adjust.what, 1.0))
    are_variables = all(is_variable(t, adjust.what, scene) for t in tissues)
    return ParameterBlock(
        adjust, names, start, scale, places=places, parts=whose, is_variable=are_variables
    )


def _force_block(adjust: Adjust, compiled: Compiled) -> ParameterBlock:
    """Return a number of a force: its logarithm, unless it may be negative or starts at 0."""
    (start,) = start_of(adjust, compiled)
    scale = None if start > 0.0 and adjust.low >= 0.0 else abs(start) or 1.0
    name, places = f"{adjust.what} of {adjust.of}", (ForcePlace(key_of(adjust.of)),)
    return ParameterBlock(
        adjust, (name,), np.array([start]), scale, places=places, parts=(adjust.of,)
    )


def _called(what: str) -> str:
    """Return the adjusted quantity, as it is written."""
    return QUANTITIES[what].name if what in QUANTITIES else what


def _start_block(adjust: Adjust, compiled: Compiled) -> ParameterBlock:
    """Return changes of places or velocities at 0 s, along one direction or all three axes."""
    network = compiled.network
    values = network.array(ARRAYS[adjust.what])
    size = max(network.extent, 1e-3)
    scale = 0.01 * size
    if adjust.what == START_VELOCITY:
        scale = max(float(np.abs(values).max()), size / compiled.plan.simulation.duration)
    whole, along = adjust.per == "set", adjust.along
    axes = [""] if along is not None else [" x", " y", " z"]
    group = np.full(values.shape, -1, dtype=np.int64)
    names: list[str] = []
    for number, node in enumerate(adjust.members.tolist()):
        first = 0 if whole else number * len(axes)
        group[node] = first + np.arange(3) if along is None else first
        if not whole or not number:
            who = adjust.of if whole else f"node {network.node_ids[node]} of {adjust.of}"
            names += [f"{adjust.what}{axis} of {who}" for axis in axes]
    start = start_of(adjust, compiled)
    return ParameterBlock(adjust, tuple(names), start, scale, group.ravel())


_NONE: Indices = np.zeros(0, dtype=np.int64)


class Entries:
    """Blocks whose parameters change entries by themselves, on top of all else.

    Args:
        blocks: All blocks of a fit_problem.
        parts: Places of the parameters of each.
    """

    def __init__(self, blocks: Sequence[ParameterBlock], parts: Sequence[slice]):
        self._own = [
            (block, block.group, part)
            for block, part in zip(blocks, parts, strict=True)
            if block.group is not None
        ]

    def __bool__(self) -> bool:
        return bool(self._own)

    def put(self, order: NumberOrder, vector: Floats, theta: Floats) -> Floats:
        """Return the numbers of a net in SI units, shape (number,), changed in place."""
        for block, chosen, parameters in self._chosen():
            array, change = order.array(vector, block.array), theta[parameters]
            if block.scale is None:
                array[chosen] *= np.exp(change)
            else:
                array[chosen] += block.scale * change * _sense(block, order)[chosen]
        return vector

    def factors(self, order: NumberOrder, theta: Floats) -> Floats:
        """Return the dimensionless factors of ``put``, shape (number,)."""
        factors = np.ones(order.size)
        for block, chosen, parameters in self._chosen():
            if block.scale is None:
                order.array(factors, block.array)[chosen] *= np.exp(theta[parameters])
        return factors

    def change(self, order: NumberOrder, vector: Floats, size: int) -> sparse.csr_matrix:
        """Return the derivative of the numbers, shape (number, parameter).

        Args:
            vector: Result of ``put`` in SI units, shape (number,).
            size: Number of parameters.
        """
        rows, columns, entries = [_NONE], [_NONE], [np.zeros(0)]
        for block, chosen, parameters in self._chosen():
            rows.append(chosen + order.places[block.array].start)
            columns.append(parameters)
            entries.append(
                order.array(vector, block.array)[chosen]
                if block.scale is None
                else block.scale * _sense(block, order)[chosen]
            )
        parts = np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))
        return sparse.csr_matrix(sparse.coo_matrix(parts, shape=(order.size, size)))

    def _chosen(self) -> Iterator[tuple[ParameterBlock, Indices, Indices]]:
        """Yield each block with the entries that it changes and the parameter of each."""
        for block, group, part in self._own:
            chosen = np.flatnonzero(group >= 0)
            yield block, chosen, part.start + group[chosen]


def _sense(block: ParameterBlock, order: NumberOrder) -> Floats:
    """Return the share that each component of a place or velocity has in its parameter."""
    along = block.adjust.along
    if along is None:
        return np.ones(order.sizes[block.array])
    return np.tile(along, order.sizes[block.array] // 3)


class Prior(Struct, frozen=True, eq=False):
    """Prior of one parameter: its place, its value, and its standard deviation."""

    place: int
    value: float
    spread: float
