"""From parameters to the numbers of a net, with derivatives.

Parameters of ``adjust`` entries come first, in the order of the entries; those of words follow.
All are 0 at the beginning.

Preserved volumes follow from start positions: a cell keeps the volume V0 = V(x) as drawn, so V0
changes by ∂V/∂x δx when start positions change by δx.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import Protocol

import numpy as np
from scipy import sparse

from tissuec.compiler.compile import Compiled
from tissuec.compiler.contact.build import contact_of
from tissuec.core.errors import CompileError
from tissuec.core.structs import replace
from tissuec.forces.enclosed.volume import Enclosure
from tissuec.forces.springs.spring_items import constant_name
from tissuec.laws.formula import Constant, Formula, Variable, replaced
from tissuec.learn.parameters.blocks import Entries, ParameterBlock, Prior, block_of
from tissuec.learn.parameters.elements import OpenElements, elements_of, opened, with_open
from tissuec.learn.parameters.numbers import Fields, NumberOrder, every_field, numbered
from tissuec.learn.parameters.substitution import Compilations, Number, UsePlace, recompiled
from tissuec.model.network import Floats, Indices, Network
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import DENSITY, STIFFENING
from tissuec.script.fit_problem import WORDS, FitProblem
from tissuec.script.verbs.end import without_end

SIGMA = 0.5  # of words, in the numbers that move them
REACH, DIFFERENCE = 2.0, 10.0  # of logarithms, and of differences in units of their scale

MOVED = 1e-3  # of a parameter: what changes with it is seen then

Given = dict[Number, float]


class WordParameters(Protocol):
    """The words of a vocabulary as parameters; see ``learn.vocabulary``."""

    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def size(self) -> int: ...
    def given(self, theta: Floats) -> Mapping[tuple[str, str], float]:
        """Return conclusions of rules in SI units, for parameters of shape (parameter,)."""
        ...

    def jacobian(self, theta: Floats) -> tuple[Sequence[tuple[str, str]], Floats]:
        """Return conclusions and their derivatives in SI units, shape (given, parameter)."""
        ...


class Parametrisation:
    """Parameters of a fit problem, for a scene as one experiment has it.

    Args:
        scales: Of blocks of differences, by their places, where the data gives better ones.

    Attributes:
        compiled: The scene, its net with ``laws`` that have numbers.
        blocks: Of each entry but words, in order.
        words: The words of the vocabulary that move; None if none do.
        own: How many parameters the blocks have.
        size: How many there are.
        order: Of the numbers of the net.
        refusal: Name of a number of tissues whose effect has no exact derivatives; "" if there
            is none.
    """

    def __init__(
        self,
        compiled: Compiled,
        fit_problem: FitProblem,
        words: WordParameters | None = None,
        scales: Mapping[int, float] = MappingProxyType({}),
    ):
        compiled = replace(compiled, plan=without_end(compiled.plan))
        self._written, self.words = compiled, words
        adjusts = [adjust for adjust in fit_problem.adjusts if adjust.what != WORDS]
        blocks = [block_of(adjust, compiled) for adjust in adjusts]
        self.blocks = tuple(
            replace(block, scale=scales.get(k, block.scale)) for k, block in enumerate(blocks)
        )
        ends = np.cumsum([0, *(len(block.names) for block in self.blocks)]).tolist()
        self._parts = [slice(a, b) for a, b in pairwise(ends)]
        self.own: int = ends[-1]
        self.size = self.own + (0 if words is None else words.size)
        # Constants of laws that are variables: each one's block, and which of the block's
        # parameters it is. Others are numbers with which laws are compiled.
        self._constants = [
            (block, number)
            for block in self.blocks
            if block.is_constant and block.is_variable
            for number in range(len(block.names))
        ]
        variables: dict[Number, Variable] = {
            (block.places[number], block.adjust.what): Variable(constant_name(k))
            for k, (block, number) in enumerate(self._constants)
        }
        closed = {
            (place, block.adjust.what)
            for block in self.blocks
            if block.is_constant and not block.is_variable
            for place in block.places
        }
        _, constants = self._numbers(np.zeros(self.size))
        begun = {key: value for key, value in constants.items() if key in closed}
        network = recompiled(compiled, {}, begun).network if begun else compiled.network
        self._elements, refusal = self._open(compiled, network, begun)
        self.refusal = refusal or self._unweighed(compiled)
        network = with_open(network, self._elements)
        shaped = recompiled(compiled, {}, variables).network if variables else compiled.network
        self._law, laws = shaped.springs.law, shaped.springs.laws
        fields = _derived_fields(replace(compiled, network=network))
        self.order = NumberOrder.of(network, len(self._constants), fields, laws)
        self._entries = Entries(self.blocks, self._parts)
        first = self._tissues(np.zeros(self.size))
        self._compilations = Compilations(
            compiled, self.order, variables, first, closed, self._elements
        )
        start = self._with_laws(network, np.zeros(self.size))
        self.compiled = replace(compiled, network=start)

    @property
    def names(self) -> tuple[str, ...]:
        """Return a description of each parameter."""
        own = [name for block in self.blocks for name in block.names]
        return (*own, *(() if self.words is None else self.words.names))

    def place(self, number: int) -> slice:
        """Return the places of the parameters of a block."""
        return self._parts[number]

    @property
    def moves(self) -> bool:
        """Return whether start positions are learnt."""
        return any(block.array == "position" for block in self.blocks if not block.places)

    @property
    def stretches(self) -> bool:
        """Return whether the shape of elements without stress changes with what is learnt."""
        return any(one.is_stretched for one in self._elements.values())

    @property
    def _has_closed(self) -> bool:
        """Return whether laws are compiled with some of the constants that are learnt."""
        return any(one.is_constant and not one.is_variable for one in self.blocks)

    @property
    def stiffens_by_words(self) -> bool:
        """Return whether words change the laws of tissues."""
        if self.words is None:
            return False
        pairs, slopes = self.words.jacobian(np.zeros(self.words.size))
        rows = [key == STIFFENING for _, key in pairs]
        return bool(np.nan_to_num(slopes[np.array(rows, dtype=bool)], nan=1.0).any())

    @property
    def groups(self) -> Indices:
        """Return the entry of each parameter, each word by itself, shape (parameter,)."""
        own = [k for k, block in enumerate(self.blocks) for _ in block.names]
        words = range(len(self.blocks), len(self.blocks) + self.size - self.own)
        return np.array([*own, *words], dtype=np.int64)

    @property
    def reaches(self) -> Floats:
        """Return plausible distances of parameters from their start, dimensionless.

        The shape is (parameter,).
        """
        own = [
            REACH if block.scale is None else DIFFERENCE
            for block in self.blocks
            for _ in block.names
        ]
        return np.array([*own, *[REACH * SIGMA] * (self.size - self.own)])

    def bounds(self) -> tuple[Floats, Floats]:
        """Return the smallest and the largest parameters, dimensionless.

        Both have the shape (parameter,).
        """
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        for block, part in zip(self.blocks, self._parts, strict=True):
            low[part] = block.theta(block.adjust.low)
            high[part] = block.theta(block.adjust.high)
        return low, high

    def priors(self) -> list[Prior]:
        """Return the priors of parameters: words are expected at their original places."""
        found = [Prior(place, 0.0, SIGMA) for place in range(self.own, self.size)]
        for block, where in zip(self.blocks, self._parts, strict=True):
            if block.adjust.prior is None:
                continue
            value, part = block.adjust.prior
            value = block.start if value is None else value
            spread = (
                np.log1p(part) if block.scale is None else part * np.abs(value) / block.scale
            )
            size = where.stop - where.start
            pairs = zip(
                np.broadcast_to(block.theta(value), size).tolist(),
                np.broadcast_to(spread, size).tolist(),
                strict=True,
            )
            found += [Prior(where.start + k, *pair) for k, pair in enumerate(pairs)]
        return found

    def network(self, theta: Floats) -> Network:
        """Return the net with numbers of parameters, also in its laws.

        Raises:
            CompileError: The numbers make no scene.
        """
        return self._recompiled(theta).network

    def present(self, theta: Floats) -> Compiled:
        """Return the scene with numbers of parameters, and the contact that follows of them.

        Raises:
            CompileError: The numbers make no scene.
        """
        found = self._recompiled(theta)
        if found.network.contact is None or not self._entries:
            return found
        scene = found.scene
        tools = [tool for tool in scene.tools.values() if tool.may_touch]
        balances = found.plan.balances
        contact = contact_of(
            found.network, tools, scene.environment, Findings(), balances=balances
        )
        assert contact is not None
        return replace(found, network=found.network.with_blocks(contact.block))

    def vector(self, theta: Floats) -> Floats:
        """Return the numbers of the net in SI units, shape (number,).

        Raises:
            CompileError: The numbers make no scene.
        """
        given = self._tissues(theta)
        vector = self._compilations.vector(given).copy()
        self.order.array(vector, "constants")[:] = [
            block.value(theta[self._part(block)])[number] for block, number in self._constants
        ]
        vector = self._entries.put(self.order, vector, theta)
        return put_volumes(self.order, vector) if self.moves else vector

    def change(self, theta: Floats) -> sparse.csr_matrix:
        """Return the derivative of the numbers by the parameters, shape (number, parameter)."""
        vector = self.vector(theta)
        entries = self._entries.change(self.order, vector, self.size)
        found = entries + self._of_constants(theta) + self._of_tissues(theta)
        if self.moves:
            found = found + change_of_volumes(self.order, vector, sparse.csr_matrix(found))
        return sparse.csr_matrix(found)

    # --- parts --------------------------------------------------------------------------------

    def _part(self, block: ParameterBlock) -> slice:
        return self._parts[self.blocks.index(block)]

    def _tissues(self, theta: Floats) -> Given:
        """Return the numbers that are compiled: of tissues and forces, and closed constants."""
        given, constants = self._numbers(theta)
        variables = {
            (block.places[number], block.adjust.what) for block, number in self._constants
        }
        return given | {key: one for key, one in constants.items() if key not in variables}

    def _numbers(self, theta: Floats) -> tuple[Given, Given]:
        """Return the numbers of tissues and forces, and the constants of laws."""
        given: Given = {}
        constants: Given = {}
        if self.words is not None:
            for (tissue, quantity), value in self.words.given(theta[self.own :]).items():
                given[UsePlace(tissue), quantity] = value
        for block, part in zip(self.blocks, self._parts, strict=True):
            into = constants if block.is_constant else given
            for place, value in zip(block.places, block.value(theta[part]), strict=False):
                into[place, block.adjust.what] = float(value)
        return given, constants

    def _recompiled(self, theta: Floats) -> Compiled:
        """Return the scene with its numbers, also those of single entries."""
        found = recompiled(self._written, *self._numbers(theta))
        plain = NumberOrder.of(found.network, 0)
        vector = self._entries.put(plain, plain.vector(found.network), theta)
        network = found.network
        if not self._has_closed:  # with which laws were compiled, too
            network = self._with_laws(network, theta)
        network = with_open(plain.network(vector, network), self._elements)
        return replace(found, network=network)

    def _open(
        self, compiled: Compiled, before: Network, begun: Given
    ) -> tuple[OpenElements, str]:
        """Return elements with variables for what is learnt of their laws.

        Also, the name of the first number whose effect on them has no exact derivatives; "" if
        there is none.

        Args:
            before: The network at the beginning.
            begun: Constants of laws with which it is compiled.
        """
        every = Given()
        blocks = [block for block in self.blocks if block.places and not block.is_of_force]
        if not elements_of(before):
            closed = (one for one in blocks if one.is_constant and not one.is_variable)
            return {}, next((one.names[0] for one in closed), "")
        for count, block in enumerate(blocks, start=1):
            moved = block.value(np.full(len(block.names), MOVED * count))
            outside = (moved < block.adjust.low) | (moved > block.adjust.high)
            moved = np.where(outside, block.value(np.full(len(moved), -MOVED * count)), moved)
            own = {
                (place, block.adjust.what): float(value)
                for place, value in zip(block.places, moved, strict=True)
            }
            every |= own
            try:
                after = self._moved(compiled, begun | own)
                opened(before, after)
            except (ValueError, CompileError):
                return {}, block.names[0]
            is_closed = block.is_constant and not block.is_variable
            if is_closed and after.springs.laws != before.springs.laws:
                return {}, block.names[0]
        return opened(before, self._moved(compiled, begun | every)), ""

    def _unweighed(self, compiled: Compiled) -> str:
        """Return the name of a density that changes masses otherwise than weights, or ""."""
        if compiled.network.weighing is None or not compiled.plan.gravity.any():
            return ""
        if not any(body.elements and body.regions for body in compiled.scene.bodies.values()):
            return ""
        of_density = (one for one in self.blocks if one.adjust.what == DENSITY)
        return next((one.names[0] for one in of_density), "")

    def _moved(self, compiled: Compiled, given: Given) -> Network:
        names = {block.adjust.what for block in self.blocks if block.is_constant}
        constants = {key: value for key, value in given.items() if key[1] in names}
        rest = {key: value for key, value in given.items() if key not in constants}
        return recompiled(compiled, rest, constants).network

    def _with_laws(self, network: Network, theta: Floats) -> Network:
        """Return a net with numbers in ``laws``, each spring with the law that it has there.

        Two laws, or one and the linear law, may be the same for some numbers: a net that is
        compiled from these has fewer of them, in another order.
        """
        numbers: dict[str, Formula] = {
            constant_name(k): Constant(float(block.value(theta[self._part(block)])[number]))
            for k, (block, number) in enumerate(self._constants)
        }
        laws = tuple(
            replace(
                law,
                elastic=replaced(law.elastic, numbers),
                viscous=replaced(law.viscous, numbers),
            )
            for law in self.order.laws
        )
        if not numbers:
            return network
        return replace(network, springs=replace(network.springs, laws=laws, law=self._law))

    def _of_constants(self, theta: Floats) -> sparse.csr_matrix:
        """Return the derivative by constants of laws."""
        found = sparse.lil_matrix((self.order.size, self.size))
        first = self.order.places["constants"].start
        for k, (block, number) in enumerate(self._constants):
            part = self._part(block)
            found[first + k, part.start + number] = block.slope(theta[part])[number]
        return sparse.csr_matrix(found)

    def _of_tissues(self, theta: Floats) -> sparse.csr_matrix:
        """Return the derivative by numbers of tissues and forces, and by words."""
        given = self._tissues(theta)
        factors = self._entries.factors(self.order, theta)
        found = sparse.lil_matrix((self.order.size, self.size))
        for block, part in zip(self.blocks, self._parts, strict=True):
            if block.group is not None or (block.is_constant and block.is_variable):
                continue
            slopes = block.slope(theta[part])
            for k, (place, slope) in enumerate(zip(block.places, slopes, strict=True)):
                column = self._compilations.column((place, block.adjust.what), given)
                _put(found, part.start + k, slope * factors * column)
        if self.words is not None:
            pairs, slopes = self.words.jacobian(theta[self.own :])
            total = np.zeros((self.order.size, self.words.size))
            for (tissue, quantity), slope in zip(pairs, slopes, strict=True):
                key = UsePlace(tissue), quantity
                if slope.any():
                    column = factors * self._compilations.column(key, given)
                    total += np.outer(given[key] * column, slope)
            for k, column in enumerate(total.T):
                _put(found, self.own + k, column)
        return sparse.csr_matrix(found)


def _derived_fields(compiled: Compiled) -> Fields:
    """Return the fields of a scene that have derivatives."""
    every = every_field(compiled.plan, compiled.network)
    return {name: one for name, one in every.items() if not isinstance(one.derivatives, str)}


def _put(matrix: sparse.lil_matrix, column: int, values: Floats) -> None:
    """Enter a column, as far as it is not zero."""
    rows = np.flatnonzero(values)
    matrix[rows, column] = values[rows][:, None]


def put_volumes(order: NumberOrder, vector: Floats) -> Floats:
    """Return the numbers with volumes as they are at start positions, changed in place.

    Args:
        vector: In SI units, shape (number,).
    """
    position = order.array(vector, "position").reshape(-1, 3)
    for part, enclosure in _drawn(order):
        vector[part] = enclosure.volumes(position)
    return vector


def change_of_volumes(
    order: NumberOrder, vector: Floats, change: sparse.csr_matrix
) -> sparse.csr_matrix:
    """Return the derivative of these volumes, in the rows of all numbers.

    Args:
        vector: In SI units, shape (number,).
        change: Of all numbers by each parameter, shape (number, parameter).

    Returns:
        Shape (number, parameter).
    """
    position = order.array(vector, "position").reshape(-1, 3)
    first, size = order.places["position"].start, order.size
    total = sparse.csr_matrix(change.shape)
    for part, enclosure in _drawn(order):
        (slopes,) = enclosure.slopes_of_sums(position, np.arange(len(position)), len(position))
        by = sparse.coo_matrix(slopes.T)
        entries = by.data, (part.start + by.row, first + by.col)
        total = total + sparse.csr_matrix(entries, shape=(size, size)) @ change
    return sparse.csr_matrix(total)


def _drawn(order: NumberOrder) -> Iterator[tuple[slice, Enclosure]]:
    """Yield the places of the drawn volumes of each enclosure, which follow its modulus."""
    first = order.places["fields"].start
    for _, field, part in numbered(order.fields):
        if isinstance(field, Enclosure):
            yield slice(first + part.start + 1, first + part.stop), field
