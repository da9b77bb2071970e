"""Natural modes of a state: shape, frequency, damping and energy of each.

With K φ = ω² M φ and φᵀ M φ = 1, the damping ratio of a mode is ζ = φᵀ D φ / 2ω, D being what
dashpots and ambient damping add to the forces, and the share of a body in the energy of motion
is the sum of m |φ|² over its nodes. (R. W. Clough, J. Penzien, Dynamics of Structures, 2003,
chapters 11 and 12.)
"""

from collections.abc import Iterator, Mapping
from math import pi, sqrt
from typing import Literal

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix, diags_array

from tissuec.analysis.vibration.operator import (
    ZERO,
    NotFound,
    Operator,
    count_below,
    lowest,
    operator_of,
)
from tissuec.core.errors import SimulationError, counted
from tissuec.core.structs import replace
from tissuec.core.units import FORCE, show
from tissuec.forces.springs.resting_springs import Bars
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.rigid import Freedom, assembled, rigid_motions
from tissuec.mechanics.settling import greatest
from tissuec.mechanics.state import State
from tissuec.model.network import Floats

Kind = Literal["unstable", "rigid", "mechanism", "vibration"]
IN_BALANCE = 1e-6  # of the largest force: what may be left at an equilibrium


class Mode(Struct, frozen=True, eq=False):
    """A motion about a state in which all nodes move in phase.

    Attributes:
        number: From 1.
        kind: "vibration"; "rigid" where a part moves as a whole without any force, "mechanism"
            where it deforms and no spring resists, "unstable" where it grows by itself.
        frequency: Natural frequency without damping [Hz]; 0 if nothing resists, None if it is
            unstable.
        growth: Of an unstable one without damping, d(ln u)/dt [1/s]; otherwise None.
        damping_ratio: Of a vibration; otherwise None.
        shares: Of each body in the energy of motion; the sum is 1.
        shape: Displacements φ of the nodes, with φᵀ M φ = 1 [kg^-½], shape (node, 3).
    """

    number: int
    kind: Kind
    frequency: float | None
    growth: float | None
    damping_ratio: float | None
    shares: Mapping[str, float]
    shape: Floats

    @property
    def period(self) -> float | None:
        """Return the period [s]; None if it does not vibrate."""
        return 1.0 / self.frequency if self.frequency else None

    def __repr__(self) -> str:
        value = f"grows by {self.growth:.3g} 1/s" if self.growth is not None else ""
        if self.frequency:
            value = f"{self.frequency:.4g} Hz"
        return f"<mode {self.number}: {self.kind}{', ' if value else ''}{value}>"


class Modes(Struct, frozen=True, eq=False):
    """Modes of a scene or a body: unstable ones, then rigid ones, then by frequency.

    Attributes:
        modes: Shape (mode,).
        state: About which they move.
        free_nodes: How many nodes can move.
        notes: What is to be known of them, as sentences.
    """

    modes: tuple[Mode, ...]
    state: State
    free_nodes: int
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        head = f"{counted(len(self), 'mode')} of {counted(self.free_nodes, 'free node')}"
        return "\n".join([head, *(f"  {mode}" for mode in self.modes)])

    def __len__(self) -> int:
        return len(self.modes)

    def __iter__(self) -> Iterator[Mode]:
        return iter(self.modes)

    def __getitem__(self, place: int) -> Mode:
        return self.modes[place]


class _Net(Struct, frozen=True, eq=False):
    """The free nodes of a state with their springs, and the matrix of their motions."""

    state: State
    balance: Balance
    bars: Bars
    operator: Operator


def modes_of(
    state: State,
    chosen: NDArray[np.bool_],
    *,
    count: int = 10,
    above: float | None = None,
) -> Modes:
    """Return the lowest modes about a state; contact does not resist.

    Args:
        state: With held nodes where they belong; not changed.
        chosen: Which nodes may move unless somebody holds them, shape (node,); some do.
        count: How many, if there are as many.
        above: Leave out the modes at and below this frequency [Hz].

    Raises:
        SimulationError: The modes could not be computed.
    """
    net, wanted = _net(state, chosen), count
    rigid = _rigid(net)
    limit = None
    if above is not None:
        limit = max((2.0 * pi * above) ** 2, 10.0 * ZERO * net.operator.top)
    count = min(count, net.operator.size - net.balance.across)  # those across are the last
    try:
        values, vectors = lowest(net.operator, rigid, count, limit)
    except NotFound as error:
        text = "the modes could not be computed; request fewer modes"
        raise SimulationError(text) from error
    is_inside = net.balance.keep_to_guides(vectors)
    values, vectors = values[is_inside], vectors[:, is_inside]
    zero = ZERO * net.operator.top
    parts: list[tuple[Kind, float, Floats]] = [
        (_kind(value, zero), value, y) for value, y in zip(values, vectors.T, strict=True)
    ]
    if above is None:
        first = sum(kind == "unstable" for kind, _, _ in parts)
        parts[first:first] = [("rigid", 0.0, y) for y in rigid[:, :count].toarray().T]
    found = tuple(_mode(net, k + 1, *part) for k, part in enumerate(parts[:count]))
    notes = tuple(_notes(net, chosen, rigid, found, wanted, above))
    return Modes(found, state, len(net.balance.free), notes)


def _net(state: State, chosen: NDArray[np.bool_]) -> _Net:
    balance = Balance(state.without_contact, chosen)
    bars = balance.bars(balance.start)
    return _Net(state, balance, bars, operator_of(balance, bars))


def _rigid(net: _Net) -> csc_matrix:
    """Return the rigid motions y that nothing resists, orthonormal, shape (n, motion).

    Translations of a free piece come before its rotations.
    """
    balance = net.balance
    found: list[Freedom] = []
    for freedom in rigid_motions(balance, balance.start):
        alone = _scaled((freedom,), balance.mass)
        _, sizes, ways = np.linalg.svd(_pulls(net.operator, alone), full_matrices=False)
        ways = ways[sizes <= ZERO * net.operator.top].T
        mass = balance.mass[freedom.piece.nodes]
        moved = freedom.motion.reshape(len(mass), 3, -1)
        _, _, turned = np.linalg.svd(np.einsum("n,nkw->kw", mass, moved) @ ways)
        if ways.shape[1]:
            found.append(replace(freedom, motion=freedom.motion @ ways @ turned.T))
    return _scaled(tuple(found), balance.mass)


def _scaled(freedoms: tuple[Freedom, ...], mass: Floats) -> csc_matrix:
    """Return motions φ of pieces as y = M^½ φ, side by side, shape (n, motion)."""
    root = diags_array(np.sqrt(np.repeat(mass, 3)))
    return csc_matrix(root @ assembled(freedoms, len(mass)))


def _pulls(operator: Operator, motions: csc_matrix) -> Floats:
    """Return the rows of A y that are not zero for some motions, and more, shape (row, motion).

    The part of volumes is complete by itself: no rigid motion changes a closed volume.
    """
    pulled = coo_matrix(operator.sparse @ motions)
    rows, place = np.unique(pulled.row, return_inverse=True)
    count = motions.shape[1]  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
    springs = np.zeros((len(rows), count))
    springs[place, pulled.col] = pulled.data
    volumes = float(np.linalg.norm(operator.wide)) * (operator.wide.T @ motions)
    # As many rows as motions at least, so that all singular vectors are there.
    return np.vstack((springs, volumes, np.zeros((count, count))))


def _kind(value: float, zero: float) -> Kind:
    if abs(value) <= zero:
        return "mechanism"
    return "vibration" if value > 0.0 else "unstable"


def _mode(net: _Net, number: int, kind: Kind, value: float, y: Floats) -> Mode:
    """Return the mode of an eigenvalue [1/s²] and an eigenvector, shape (n,)."""
    balance, network = net.balance, net.state.network
    y = y * np.sign(y[np.argmax(np.abs(y) > (1.0 - 1e-6) * np.abs(y).max())])
    phi = y.reshape(-1, 3) / np.sqrt(balance.mass)[:, None]
    shape = np.zeros_like(network.position)
    shape[balance.free] = phi
    if net.state.embedding is not None:
        net.state.embedding.follow(shape)
    energy = np.bincount(balance.free, (y * y).reshape(-1, 3).sum(axis=1), len(shape))
    shares = {body.name: float(energy[body.nodes].sum()) for body in network.bodies}
    omega = sqrt(abs(value))
    vibrates = kind == "vibration"
    return Mode(
        number,
        kind,
        frequency=omega / (2.0 * pi) if vibrates else None if kind == "unstable" else 0.0,
        growth=omega if kind == "unstable" else None,
        damping_ratio=_resisted(net, phi) / (2.0 * omega) if vibrates else None,
        shares={name: share for name, share in shares.items() if share > 0.0},
        shape=shape,
    )


def _resisted(net: _Net, phi: Floats) -> float:
    """Return φᵀ D φ [1/s] of dashpots and ambient damping for φ of shape (free, 3)."""
    ends = net.balance.springs.ends
    moved = np.where(ends[..., None] >= 0, net.balance.following(phi)[ends], 0.0)
    closing = np.einsum("sk,sk->s", net.bars.direction, moved[:, 1] - moved[:, 0])
    elongation = net.bars.length - net.balance.springs.rest
    viscosity = net.balance.springs.behaviour.sluggishness(elongation, np.zeros(len(ends)))
    braked = float(net.state.lumped(net.state.braking)[net.balance.free] @ (phi**2).sum(axis=1))
    moving = np.zeros_like(net.bars.position)
    moving[net.balance.free] = phi
    if net.state.embedding is not None:
        net.state.embedding.follow(moving)
    for field in net.state.without_contact.fields:
        braked += float(field.relaxed.powers(net.state.time, net.bars.position, moving)[1])
    return float(viscosity @ closing**2) + braked


def _notes(
    net: _Net,
    chosen: NDArray[np.bool_],
    rigid: csc_matrix,
    found: tuple[Mode, ...],
    count: int,
    above: float | None,
) -> Iterator[str]:
    """Yield notes on the modes."""
    state, unknowns = net.state, net.operator.size - net.balance.across
    zero = ZERO * net.operator.top
    if unbalanced := out_of_balance(state, chosen):
        yield (
            f"{unbalanced}; the modes use the stiffness of this "
            'state. Write "at 0 s: settle" for the modes about an equilibrium'
        )
    if (contact := state.touching) is not None:
        touched = int(contact.touched(state.position)[net.balance.free].sum())
        if touched:
            yield f"contact is ignored: it acts on {counted(touched, 'node')}"
    if state.springs.inelastic is not None:
        yield "springs that relax or yield have the stiffness after complete relaxation"
    if any(len(one.relaxed.internal_rows) < len(one.internal_rows) for one in state.fields):
        yield "elements that relax have the stiffness after complete relaxation"
    elongation = net.bars.length - net.balance.springs.rest
    viscosity = net.balance.springs.behaviour.brake_slope(elongation, np.zeros_like(elongation))
    if not np.isfinite(viscosity).all():
        yield "damping ratios ignore dashpots whose resistance is infinite at rest"
    if count > unknowns:
        nodes = counted(len(net.balance.free), "free node")
        yield f"there are only {unknowns} modes: {nodes} in three directions"
    if above is not None:
        if not found:
            yield f"there is no mode above {above:g} Hz"
    elif found and found[-1].frequency == 0.0 and len(found) == count < unknowns:
        total = count_below(net.operator, rigid, 10.0 * zero)
        if total is None:
            yield "there are more modes of frequency 0; --above 0 omits them"
        else:
            free = total - sum(mode.kind == "unstable" for mode in found)
            yield f"{free} modes have frequency 0; --above 0 omits them"


def out_of_balance(state: State, chosen: NDArray[np.bool_]) -> str:
    """Return by how much forces fail to balance, as a clause; empty if they balance.

    Args:
        chosen: Which nodes move, shape (node,).
    """
    balance = Balance(state, chosen)
    bars = balance.bars(balance.start)
    force, largest = greatest(balance.force(bars)), balance.largest(bars)
    if force <= IN_BALANCE * largest + balance.noise(bars):
        return ""
    return (
        f"forces do not balance: up to {show(force, FORCE)} on a node, where the largest force "
        f"is {show(largest, FORCE)}"
    )
