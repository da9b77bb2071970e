"""From what is learnt to the numbers of a net: parameters, their meaning, and the derivative.

Parameters are pure numbers that begin at 0: logarithms of what is positive, over its value at
the beginning, and otherwise differences in units of a scale. A number of a tissue changes
every entry of the arrays that is made of it, whatever shares and interfaces do; compiling is
linear in it, or at least piecewise, so that a small difference gives its derivative to
rounding.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np
from scipy import sparse

from tissuec.compiler import Compiled
from tissuec.compiling.touching import contact_of
from tissuec.lang.syntax import key_of
from tissuec.laws import Law
from tissuec.laws.formula import Variable
from tissuec.laws.partial import constant_name
from tissuec.learn.changing import Numbers, Place, changed, recompiled
from tissuec.learn.numbers import STATE, Order
from tissuec.learn.priors import Prior
from tissuec.lesson import REST_LENGTH, START_POSITION, START_VELOCITY, WORDS, Adjust, Lesson
from tissuec.network import Floats, Indices, Network
from tissuec.scene.findings import Findings
from tissuec.scene.model import Scene, Tissue
from tissuec.scene.quantities import QUANTITIES

SIGMA = 0.5  # of words, in the numbers that move them
STEP = 2.0**-20  # of a number, by which what is linear in it is derived
ARRAYS = {REST_LENGTH: "rest", START_POSITION: "position", START_VELOCITY: "velocity"}


class Words(Protocol):
    """The words of a vocabulary as parameters; see ``learn.words``."""

    names: tuple[str, ...]
    size: int

    def given(self, theta: Floats) -> Mapping[tuple[str, str], float]: ...
    def jacobian(self, theta: Floats) -> tuple[Sequence[tuple[str, str]], Floats]: ...


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """The parameters of one ``adjust`` entry.

    Attributes:
        names: What each is, shape (parameter,).
        start: Values at the beginning, in SI units, shape (parameter,).
        scale: Of differences; None where parameters are logarithms.
        group: Of those that act on entries of an array: which parameter each entry belongs to,
            -1 for none, shape (entry,); None for numbers of tissues and laws.
        places: Of numbers of tissues and laws: where each is used.
        parts: Whose each number is: a part of a body by name, or a spring or node by number.
    """

    adjust: Adjust
    names: tuple[str, ...]
    start: Floats
    scale: float | None
    group: Indices | None = None
    places: tuple[Place, ...] = ()
    parts: "tuple[str, ...] | Indices" = ()

    @property
    def array(self) -> str:
        """Return the name of the array that changes."""
        what = self.adjust.what
        return ARRAYS[what] if what in ARRAYS else QUANTITIES[what].array

    def value(self, theta: Floats) -> Floats:
        """Return the values in SI units, shape (parameter,)."""
        if self.scale is None:
            return self.start * np.exp(theta)
        return self.start + self.scale * theta

    def theta(self, value: Floats | float) -> Floats:
        """Return the parameters that have some values; infinite where they cannot be."""
        if self.scale is not None:
            return (value - self.start) / self.scale
        with np.errstate(divide="ignore"):
            return np.log(np.maximum(value, 0.0) / self.start)

    def slope(self, theta: Floats) -> Floats:
        """Return the derivatives of the values, shape (parameter,)."""
        return self.value(theta) if self.scale is None else np.full(len(theta), self.scale)


class Shaping:
    """Parameters of a lesson, for a scene as one experiment has it.

    Attributes:
        blocks: Of each entry but words, in order; their parameters stand first.
        words: The words of the vocabulary that move, whose parameters come next.
    """

    def __init__(self, compiled: Compiled, lesson: Lesson, words: Words | None = None):
        self.compiled, self.words = compiled, words
        adjusts = [adjust for adjust in lesson.adjusts if adjust.what != WORDS]
        self.blocks = tuple(_block(adjust, compiled) for adjust in adjusts)
        ends = np.cumsum([0, *(len(block.names) for block in self.blocks)]).tolist()
        self._parts = [slice(a, b) for a, b in pairwise(ends)]
        self.own = ends[-1]
        self.size = self.own + (0 if words is None else words.size)
        self._inner = [
            (block, number)
            for block in self.blocks
            if is_constant(block)
            for number in range(len(block.names))
        ]
        self.order = Order.of(compiled.network, len(self._inner))
        variables = {
            (block.places[number], block.adjust.what): Variable(constant_name(k))
            for k, (block, number) in enumerate(self._inner)
        }
        self._variable = variables
        # Which of two tissues is the softer decides for all of their springs.
        bodies = compiled.scene.bodies.values()
        self._is_linear = all(body.interface in ("", "mean") for body in bodies)
        self._columns: dict[tuple, Floats] = {}
        scene = changed(compiled.scene, {}, variables)
        self.laws: tuple[Law, ...] = (
            recompiled(compiled, lambda _: scene).network.laws
            if variables
            else compiled.network.laws
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Return what each parameter is."""
        own = [name for block in self.blocks for name in block.names]
        return (*own, *(() if self.words is None else self.words.names))

    def part(self, theta: Floats, number: int) -> Floats:
        """Return the parameters of one block."""
        return theta[self._parts[number]]

    def place(self, number: int) -> slice:
        """Return where the parameters of a block stand."""
        return self._parts[number]

    def bounds(self) -> tuple[Floats, Floats]:
        """Return the least and the greatest parameters, shape (parameter,)."""
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        for block, part in zip(self.blocks, self._parts, strict=True):
            low[part], high[part] = (
                block.theta(block.adjust.low),
                block.theta(block.adjust.high),
            )
        return low, high

    def priors(self) -> list[Prior]:
        """Return what is expected of parameters: of words, that they are the expert's."""
        found = [Prior(place, 0.0, SIGMA) for place in range(self.own, self.size)]
        for block, where in zip(self.blocks, self._parts, strict=True):
            if block.adjust.prior is None:
                continue
            value, part = block.adjust.prior
            spread = np.log1p(part) if block.scale is None else part * abs(value) / block.scale
            expected = np.broadcast_to(block.theta(value), (where.stop - where.start,))
            places = range(where.start, where.stop)
            found += [
                Prior(k, float(e), float(spread)) for k, e in zip(places, expected, strict=True)
            ]
        return found

    def network(self, theta: Floats) -> Network:
        """Return the net with its numbers, and with numbers in its laws.

        Raises:
            CompileError: The numbers make no scene.
        """
        return self._recompiled(theta).network

    def present(self, theta: Floats) -> Compiled:
        """Return the net with its numbers, and a plan whose contact is as stiff as it is.

        Raises:
            CompileError: The numbers make no scene.
        """
        found = self._recompiled(theta)
        if found.plan.contact is None or all(block.group is None for block in self.blocks):
            return found
        scene = found.scene
        tools = [tool for tool in scene.tools.values() if tool.may_touch]
        contact = contact_of(found.network, tools, scene.environment, Findings())
        return replace(found, plan=replace(found.plan, contact=contact))

    def vector(self, theta: Floats) -> Floats:
        """Return the numbers of the net, shape (number,)."""
        given, _ = self._tissues(theta)
        constants = [float(b.value(self._of(theta, b))[k]) for b, k in self._inner]
        return self._by_entry(self.order, self._compiled_vector(given, constants), theta)

    def change(self, theta: Floats) -> sparse.csr_matrix:
        """Return the derivative of the numbers by the parameters, shape (number, parameter)."""
        given, _ = self._tissues(theta)
        own = self._of_entries(theta, self.vector(theta)) + self._of_constants(theta)
        return sparse.csr_matrix(own + self._of_tissues(theta, given))

    # --- parts --------------------------------------------------------------------------------

    def _of(self, theta: Floats, block: Block) -> Floats:
        return self.part(theta, self.blocks.index(block))

    def _tissues(self, theta: Floats) -> tuple[dict[tuple[Place, str], float], Numbers]:
        """Return the numbers of tissues and the constants of laws."""
        given: dict[tuple[Place, str], float] = {}
        constants: dict[tuple[Place, str], float] = {}
        if self.words is not None:
            for (tissue, quantity), value in self.words.given(theta[self.own :]).items():
                given[Place(tissue), quantity] = value
        for block, part in zip(self.blocks, self._parts, strict=True):
            into = constants if is_constant(block) else given
            for place, value in zip(block.places, block.value(theta[part]), strict=False):
                into[place, block.adjust.what] = float(value)
        return given, constants

    def _recompiled(self, theta: Floats) -> Compiled:
        """Return the scene with its numbers, also those of single entries."""
        given, constants = self._tissues(theta)
        scene = changed(self.compiled.scene, given, constants)
        found = recompiled(self.compiled, lambda _: scene)
        plain = Order.of(found.network, 0)
        vector = self._by_entry(plain, plain.vector(found.network, np.zeros(0)), theta)
        return replace(found, network=plain.network(vector, found.network))

    def _compiled_vector(self, given: Numbers, constants: Sequence[float]) -> Floats:
        """Return the numbers of the net for numbers of tissues, shape (number,)."""
        vector = self._compiled(given).copy()
        self.order.array(vector, "constants")[:] = constants
        return vector

    def _compiled(self, given: Numbers) -> Floats:
        """Return the same for constants of 0; where compiling is linear, without doing it."""
        if not self._is_linear:
            return self._by_compiling(given)
        first, base = self._base
        total = base.copy()
        for key, value in given.items():
            if value != first[key]:
                total += (value - first[key]) * self._column(key, first)
        return total

    @cached_property
    def _base(self) -> tuple[Numbers, Floats]:
        """Return the numbers of tissues at the beginning, and those of the net."""
        given, _ = self._tissues(np.zeros(self.size))
        return given, self._by_compiling(given)

    def _column(self, key: tuple[Place, str], given: Numbers) -> Floats:
        """Return the derivative by one number of a tissue, shape (number,)."""
        where = (key, *(() if self._is_linear else given.values()))
        if where not in self._columns:
            step = STEP * (abs(given[key]) or 1.0)
            moved = self._by_compiling({**given, key: given[key] + step})
            before = self._base[1] if self._is_linear else self._by_compiling(given)
            self._columns[where] = (moved - before) / step
        return self._columns[where]

    def _by_compiling(self, given: Numbers) -> Floats:
        scene = changed(self.compiled.scene, given, self._variable)
        network = recompiled(self.compiled, lambda _: scene).network
        return self.order.vector(network, np.zeros(len(self._inner)))

    def _by_entry(self, order: Order, vector: Floats, theta: Floats) -> Floats:
        """Return numbers with what belongs to single entries put on top."""
        for block, part in zip(self.blocks, self._parts, strict=True):
            if block.group is None:
                continue
            array, chosen = order.array(vector, block.array), block.group >= 0
            change = theta[part][block.group[chosen]]
            if block.scale is None:
                array[chosen] *= np.exp(change)
            else:
                array[chosen] += block.scale * change * _sense(block, order)[chosen]
        return vector

    def _of_entries(self, theta: Floats, vector: Floats) -> sparse.csr_matrix:
        """Return the derivative by parameters of single entries."""
        rows, columns, entries = [_NONE], [_NONE], [np.zeros(0)]
        for block, part in zip(self.blocks, self._parts, strict=True):
            if block.group is None:
                continue
            chosen = np.flatnonzero(block.group >= 0)
            rows.append(chosen + self.order.places[block.array].start)
            columns.append(part.start + block.group[chosen])
            entries.append(
                self.order.array(vector, block.array)[chosen]
                if block.scale is None
                else block.scale * _sense(block, self.order)[chosen]
            )
        parts = np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))
        return sparse.csr_matrix(sparse.coo_matrix(parts, shape=(self.order.size, self.size)))

    def _of_constants(self, theta: Floats) -> sparse.csr_matrix:
        found = sparse.lil_matrix((self.order.size, self.size))
        first = self.order.places["constants"].start
        for k, (block, number) in enumerate(self._inner):
            part = self.place(self.blocks.index(block))
            found[first + k, part.start + number] = block.slope(theta[part])[number]
        return sparse.csr_matrix(found)

    def _of_tissues(
        self, theta: Floats, given: dict[tuple[Place, str], float]
    ) -> sparse.csr_matrix:
        """Return the derivative by numbers of tissues, and by words through these."""
        factor = self._factors(theta)
        first = self._base[0] if self._is_linear else given

        def column(key: tuple[Place, str]) -> Floats:
            return factor * self._column(key, first)

        found = sparse.lil_matrix((self.order.size, self.size))
        for block, part in zip(self.blocks, self._parts, strict=True):
            if block.group is not None or is_constant(block):
                continue
            slopes = block.slope(theta[part])
            for k, (place, slope) in enumerate(zip(block.places, slopes, strict=True)):
                _put(found, part.start + k, slope * column((place, block.adjust.what)))
        if self.words is not None:
            pairs, slopes = self.words.jacobian(theta[self.own :])
            total = np.zeros((self.order.size, self.words.size))
            for (tissue, quantity), slope in zip(pairs, slopes, strict=True):
                key = Place(tissue), quantity
                if slope.any():
                    total += np.outer(given[key] * column(key), slope)
            for k in range(self.words.size):
                _put(found, self.own + k, total[:, k])
        return sparse.csr_matrix(found)

    def _factors(self, theta: Floats) -> Floats:
        """Return what single entries are multiplied by, shape (number,)."""
        factors = np.ones(self.order.size)
        for block, part in zip(self.blocks, self._parts, strict=True):
            if block.group is not None and block.scale is None:
                chosen = block.group >= 0
                self.order.array(factors, block.array)[chosen] *= np.exp(
                    theta[part][block.group[chosen]]
                )
        return factors


_NONE: Indices = np.zeros(0, dtype=np.int64)


def is_constant(block: Block) -> bool:
    """Tell whether a block holds constants of laws."""
    what = block.adjust.what
    return what not in QUANTITIES and what not in ARRAYS


def _put(matrix: sparse.lil_matrix, column: int, values: Floats) -> None:
    rows = np.flatnonzero(values)
    matrix[rows, column] = values[rows][:, None]


def _sense(block: Block, order: Order) -> Floats:
    """Return the share that each component of a place or velocity has in its parameter."""
    along = block.adjust.along
    if along is None:
        return np.ones(order.sizes[block.array])
    return np.tile(along, order.sizes[block.array] // 3)


def _block(adjust: Adjust, compiled: Compiled) -> Block:
    """Return the parameters of an entry."""
    if adjust.per in ("tissue", "region"):
        return _tissue_block(adjust, compiled)
    network = compiled.network
    if adjust.what in (START_POSITION, START_VELOCITY):
        return _start_block(adjust, compiled)
    array = ARRAYS.get(adjust.what) or QUANTITIES[adjust.what].array
    values = getattr(network, array)
    group = np.full(len(values), -1, dtype=np.int64)
    if adjust.per == "set":
        group[adjust.members] = 0
        mean = float(np.exp(np.log(values[adjust.members]).mean()))
        name = f"{adjust.what} of {adjust.of}"
        return Block(adjust, (name,), np.array([mean]), None, group, parts=(adjust.of,))
    group[adjust.members] = np.arange(len(adjust.members))
    ids = network.spring_ids if adjust.per == "spring" else network.node_ids
    names = tuple(
        f"{adjust.what} of {adjust.per} {ids[m]} of {adjust.of}" for m in adjust.members
    )
    start = values[adjust.members].astype(float)
    return Block(adjust, names, start, None, group, parts=np.asarray(adjust.members))


def _tissue_block(adjust: Adjust, compiled: Compiled) -> Block:
    scene = compiled.scene
    if adjust.per == "region":
        body = scene.bodies[key_of(adjust.of)]
        parts = [("", body.tissue), *((r.name, r.tissue or body.tissue) for r in body.regions)]
        used = [(name, tissue) for name, tissue in parts if tissue is not None]
        places = tuple(
            Place(key_of(tissue.name), (key_of(body.name), key_of(name)))
            for name, tissue in used
        )
        names = tuple(f"{adjust.what} of {n + ' of ' if n else ''}{body.name}" for n, _ in used)
        tissues, whose = [tissue for _, tissue in used], tuple(name for name, _ in used)
    else:
        tissues, whose = [scene.tissues[key_of(adjust.of)]], (adjust.of,)
        places, names = (Place(key_of(adjust.of)),), (f"{adjust.what} of {adjust.of}",)
    if adjust.what in QUANTITIES:
        start = np.array([t.given[adjust.what].value for t in tissues])
    else:
        start = np.array([_constant_of(t, adjust.what, scene) for t in tissues])
    may_turn = adjust.what == "prestress" or adjust.what not in QUANTITIES
    positive = bool((start > 0.0).all()) and not may_turn
    scale = None if positive else max(float(np.abs(start).max()), _SMALL.get(adjust.what, 1.0))
    return Block(adjust, names, start, scale, places=places, parts=whose)


_SMALL = {"prestress": 0.01}  # what counts as one of them, where the beginning is at zero


def _constant_of(tissue: Tissue, name: str, scene: Scene) -> float:
    """Return the constant of a law, or the param of a free formula."""
    laws = (written.law for written in tissue.laws.values())
    own = [float(getattr(law, name)) for law in laws if hasattr(law, name)]
    params = {key_of(p.name): p.value for p in scene.constants.parameters()}
    return own[0] if own else float(params[key_of(name)].amount)


def _start_block(adjust: Adjust, compiled: Compiled) -> Block:
    network = compiled.network
    values = getattr(network, ARRAYS[adjust.what]).ravel()
    size = max(network.extent, 1e-3)
    scale = 0.01 * size
    if adjust.what == START_VELOCITY:
        scale = max(float(np.abs(values).max()), size / compiled.plan.simulation.duration)
    group = np.full(len(values), -1, dtype=np.int64)
    axes = np.arange(3)
    ids = network.node_ids
    names, start, count = [], [], 0
    together = adjust.per == "set"
    for node in adjust.members:
        place = 3 * node + axes
        if adjust.along is not None:
            group[place] = 0 if together else count
            if not together or not names:
                names.append(f"{adjust.what} of {_who(adjust, ids[node])}")
                start.append(float(values[place] @ adjust.along))
                count += 1
            continue
        group[place] = axes if together else count + axes
        if not together or not names:
            names += [f"{adjust.what} {axis} of {_who(adjust, ids[node])}" for axis in "xyz"]
            start += values[place].tolist()
            count += 3
    return Block(adjust, tuple(names), np.array(start), scale, group)


def _who(adjust: Adjust, node: int) -> str:
    return adjust.of if adjust.per == "set" else f"node {node} of {adjust.of}"


assert set(STATE) <= set(ARRAYS.values())
