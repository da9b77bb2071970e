"""Equilibration, with Newton's method: nodes are moved to where all forces balance, and rest.

Newton's method goes first; where it ends short of an equilibrium, relaxation continues from
there and Newton's method again. Where the equilibrium is unstable, the net is pushed off along
the motion in which it buckles, and continues from there.

Shared arguments:
    balance: The free nodes and what acts on them.
    x: Positions of the free nodes [m], shape (free, 3).
    bars: The springs at these positions.
    force: Force on each free node [N], shape (free, 3).
"""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import norm
from tissuec.core.errors import counted, shown_size
from tissuec.core.signals import give_way
from tissuec.core.structs import replace
from tissuec.core.units import FORCE, show
from tissuec.mechanics import observables
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.newton import (
    HALVINGS,
    NEAR,
    ROUNDS,
    Reached,
    descend,
    greatest,
    lost_in_rounding,
    predicted,
)
from tissuec.mechanics.relaxation import relax
from tissuec.mechanics.rest import LOOSE
from tissuec.mechanics.rigid import NeutralMotions
from tissuec.mechanics.stability import SoftestMotion, is_firm, softest
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network

SWEEPS = 500
TURNS = 4  # of Newton's method and relaxation
FAR, NEARBY = 100.0, 1.0  # times the size of the net: where a search ends
# Of Newton's method from nearby: rounds at most, as contact makes it converge linearly, and
# rounds in succession in which forces may grow, as they do if there is no equilibrium ahead.
SOON, WORSE = 160, 8
UNLOADED = 1e-12  # of the largest load: a sum of loads that is none
EVEN = 1e-6  # of the force that presses: along what is level, rounding drives less
LEVEL = 1e-3  # the same, with what an uneven mesh drives
WAYS = 4  # softest motions that are looked at where an equilibrium is unstable
SEARCHED = 600  # free nodes of a net at most for this search, which takes 25 s in 16³ cells
EVENLY = 1e-6  # of a way: a part along a motion that is no more than rounding
LANDING = 20  # halvings of the step in which a piece that falls touches something
FOLLOWS = 0.1  # of the motion of holders: how far free nodes have moved that wait for it


class Unsettled(Exception):
    """There is no equilibrium, or none was found.

    Attributes:
        message: Why, as a sentence without the node.
        node: The one to name.
    """

    def __init__(self, message: str, node: int):
        super().__init__(message)
        self.message, self.node = message, node


class Remark(Struct, frozen=True):
    """A remark on an equilibrium.

    Attributes:
        message: What is said once in a run.
        node: The one that shows it best, if there is one.
        numbers: Further text, which may differ from one equilibrium to the next.
    """

    message: str
    node: int | None = None
    numbers: str = ""


BUCKLED = "the net buckled to one of several possible sides"
UNKNOWN = Remark("the stability of this equilibrium could not be determined")


def settle(
    state: State,
    chosen: NDArray[np.bool_],
    guess: Floats | None = None,
    *,
    before: Floats | None = None,
    patiently: bool = True,
) -> tuple[Remark, ...]:
    """Move the chosen free nodes to where the forces on them balance, at rest.

    Forces are then as small as rounding allows, or 1e-12 of the largest force.

    Args:
        state: Changed in place; held nodes must be where they belong.
        chosen: Which nodes may move, shape (node,).
        guess: Where the equilibrium may be [m], shape (node, 3); without it, the search starts
            at the present positions, or where these lead if held nodes have moved. Motions
            without resistance keep their value in the state.
        before: Where all nodes were before held ones moved [m], shape (node, 3); as drawn if
            None.
        patiently: Whether to continue if Newton's method does not converge soon.

    Raises:
        Unsettled: The state is as it was.
        Halted: Likewise.
    """
    balance = Balance(state, chosen)
    if not len(balance.free):
        return ()
    start = balance.start if guess is None else guess[balance.free]
    start = set_down(balance, start - balance.held_part(start - balance.start))
    with np.errstate(over="ignore", invalid="ignore"):  # on the way to nowhere
        before = state.network.position if before is None else before
        if guess is None and _have_holders_moved(state, balance, start, before):
            start = predicted(balance, start, before)
        x, remarks = _settled(balance, state.network, start, patiently=patiently)
    remarks = (*remarks, *_lost(balance, state.network, x))
    state.position[balance.free] = NeutralMotions.of(balance, x).restored(x, balance.start)
    state.velocity[balance.free] = 0.0
    state.follow_hosts()
    state.forget_friction(balance.free)
    _let_relax(state, balance)
    return remarks


def _lost(balance: Balance, network: Network, x: Floats) -> tuple[Remark, ...]:
    """Return a remark if rounding hides the loads on a piece."""
    bars = balance.bars(x)
    lost = lost_in_rounding(balance, bars, balance.force(bars))
    if lost is None:
        return ()
    node = int(balance.free[lost.node])
    name = network.body_at(node).name
    numbers = (
        f": they are at most {show(lost.load, FORCE)} at a node, and the rounding of places "
        f"leaves residual forces of up to {show(lost.left, FORCE)}; displacements by these "
        "loads are uncertain. Use larger loads, to which small displacements are "
        "proportional, or thicker cells"
    )
    return (Remark(f"loads on {name} are lost in rounding", node, numbers),)


def _have_holders_moved(state: State, balance: Balance, x: Floats, before: Floats) -> bool:
    """Return whether held nodes have moved far more than free ones."""
    held = state.held
    shift = x - before[balance.free]
    across = balance.held_part(shift)
    moved = norm(state.position[held] - before[held]).max(initial=0.0)
    moved = max(moved, norm(across).max(initial=0.0))
    follows = norm(shift - across).max(initial=0.0)
    return bool(moved > 0.0) and bool(follows <= FOLLOWS * moved)


def _let_relax(state: State, balance: Balance) -> None:
    """Make branches at the free nodes give way, so that they no longer pull."""
    if not state.network.relaxes:
        return
    moved = np.zeros(state.network.node_count, dtype=bool)
    moved[balance.free] = True
    if state.embedding is not None:
        moved[state.embedding.nodes] = state.embedding.any_of(moved)
    for field in state.fields:
        field.let_relax(state.velocity, state.position, moved)
    if state.springs.inelastic is None:
        return
    ends = state.springs.ends
    rest = observables.rest_lengths(state, state.velocity)
    e = observables.elongation(ends, state.position, rest)
    springs = np.flatnonzero(state.alive_springs & moved[ends].any(axis=1))
    state.springs.inelastic.let_relax(state.velocity, e, springs)


def _minimum(
    balance: Balance, x: Floats, *, patiently: bool
) -> tuple[Floats, tuple[Remark, ...]]:
    """Return a minimum of the energy near x, and what is to be known of it.

    Both are positions of the free nodes [m], shape (free, 3).
    """
    start, node = x, 0
    leaving: list[tuple[SoftestMotion, bool]] = []

    def leaves(there: Floats) -> bool:
        """Note along which motion the net leaves an equilibrium, and what decides its side."""
        leaving[:] = _leaving(softest(balance, there, WAYS), start - there)
        return bool(leaving)

    looks = leaves if len(balance.free) <= SEARCHED else None
    (x, _, firm), remarks = _equilibrium(balance, x, patiently=patiently, looks=looks)
    for _ in range(TURNS):
        free = _free_pieces(NeutralMotions.of(balance, x))
        if not leaving and (firm or is_firm(balance, x)):
            return x, (*remarks, *free)
        found = leaving or [(mode, True) for mode in softest(balance, x)]
        mode, is_even = found[0] if found else (None, True)
        leaving.clear()
        if mode is None:
            return x, (*remarks, *free, UNKNOWN)
        if mode.resists > LOOSE:
            return x, (*remarks, *free)
        node = mode.node(balance)
        if mode.resists > -LOOSE:
            text = "the net is a mechanism here: it can move without any force"
            return x, (*remarks, *free, Remark(text, node))
        remarks = (Remark(BUCKLED, node),) if is_even else remarks
        aside = _pushed_off(balance, x, mode)
        (x, _, firm), _ = _equilibrium(balance, aside, patiently=patiently)
    return x, (Remark("this equilibrium is unstable", node),)


def _leaving(
    soft: Sequence[SoftestMotion], way: Floats
) -> Iterator[tuple[SoftestMotion, bool]]:
    """Yield how a net leaves an unstable equilibrium, and whether its side is undecided.

    Args:
        soft: The softest motions.
        way: Towards where the search began, for each free node [m], shape (free, 3).
    """
    unstable = [one for one in soft if one.resists < -LOOSE]
    parts = [float(np.vdot(one.shape, way)) for one in unstable]
    far = float(np.linalg.norm(way))
    if even := [
        one for one, part in zip(unstable, parts, strict=True) if abs(part) <= EVENLY * far
    ]:
        yield even[0], True
    elif unstable:
        along = sum(part * one.shape for one, part in zip(unstable, parts, strict=True))
        yield replace(unstable[0], shape=along), False


def _settled(
    balance: Balance, network: Network, x: Floats, *, patiently: bool
) -> tuple[Floats, tuple[Remark, ...]]:
    """Return a minimum of the energy near x, or where all but friction balances.

    Both are positions of the free nodes [m], shape (free, 3).
    """
    # What friction holds does not slide; on level ground, forces balance wherever it is.
    slid = _without_slides(balance, network, x) if patiently else None
    if slid is not None and slid.stays:
        return slid.x, slid.remarks
    try:
        return _minimum(balance, x, patiently=patiently)
    except Unsettled as failure:
        if slid is None:
            raise
        if slid.refusal is not None:
            raise slid.refusal from failure
        return slid.x, slid.remarks


class _Slid(NamedTuple):
    """A place where forces balance but for those along which pieces can slide in contact.

    Attributes:
        x: Positions of the free nodes [m], shape (free, 3).
        remarks: What can slide.
        stays: Whether nothing drives it, or no more than friction bears.
        refusal: Why it does not stay, if more than friction bears drives it.
    """

    x: Floats
    remarks: tuple[Remark, ...]
    stays: bool
    refusal: Unsettled | None


def _without_slides(balance: Balance, network: Network, x: Floats) -> _Slid | None:
    """Return where forces balance but for those along which pieces can slide in contact.

    Friction bears these, which equilibria do not know.

    Args:
        x: Where to begin [m], shape (free, 3).
    """
    balance.holds_slides = True
    try:
        if not NeutralMotions.of(balance, x).count:
            return None
        x, is_found, _ = descend(balance, x)
        neutral = NeutralMotions.of(balance, x)
    finally:
        balance.holds_slides = False
    if not is_found or not neutral.count:
        return None
    left = balance.force(balance.bars(x))
    remarks: list[Remark] = []
    refusal, stays = None, True
    for freedom in neutral.freedoms:
        nodes = freedom.piece.nodes
        force = float(norm(left[nodes].sum(axis=0)))
        pressed, rubs = balance.pressed(x, nodes)
        node, way = int(balance.free[nodes[0]]), _direction(freedom.motion)
        name = network.body_at(node).name
        stays &= force <= max(rubs, EVEN * pressed)
        if force > max(rubs, LEVEL * pressed):
            by = f"friction bears {show(rubs, FORCE)} only" if rubs else "there is no friction"
            text = (
                f"there is no equilibrium: {name} can slide {way} along what it touches, "
                f"{show(force, FORCE)} drive it, and {by}"
            )
            refusal = refusal or Unsettled(text, node)
        if not rubs:
            text = f"{name} can slide freely {way} along what it touches; it stays in place"
            remarks.append(Remark(text))
    return _Slid(x, tuple(remarks), stays, refusal)


def _direction(motion: Floats) -> str:
    """Return along which directions a piece slides, as text.

    Args:
        motion: Rigid motions of its nodes, shape (3 n, motion).
    """
    shift = motion.reshape(-1, 3, motion.shape[1]).mean(axis=0)
    ways, sizes, _ = np.linalg.svd(shift, full_matrices=False)
    along = ways[:, sizes > 0.1 * sizes.max(initial=0.0)].T
    if len(along) == 2:
        across = np.cross(*along)
        return (
            f"at right angles to {_written(across * np.sign(across[np.abs(across).argmax()]))}"
        )
    return f"along {' and '.join(_written(one) for one in along)}"


def _written(vector: Floats) -> str:
    """Return a vector as it is written in a scene, to two decimals."""
    return "(" + ", ".join(f"{round(float(one), 2) + 0.0:g}" for one in vector) + ")"


def _free_pieces(neutral: NeutralMotions) -> tuple[Remark, ...]:
    """Return notes on pieces that can move as a whole without any force."""
    if not neutral.freedoms:
        return ()
    loose = [one for one in neutral.freedoms if one.pivot is None]
    who = "the net" if len(neutral.freedoms) == 1 else counted(len(neutral.freedoms), "piece")
    if not loose:
        text = f"{who} can rotate about its support without any force"
        return (Remark(f"{text}; its orientation is unchanged"),)
    if all(one.is_on_plane for one in loose):
        text = f"nothing but planes of symmetry holds {who}: along these"
        return (Remark(f"{text}, the centre of mass is unchanged"),)
    return (Remark(f"nothing holds {who}: the centre of mass is unchanged"),)


def _equilibrium(
    balance: Balance,
    x: Floats,
    *,
    patiently: bool,
    looks: Callable[[Floats], bool] | None = None,
) -> tuple[Reached, tuple[Remark, ...]]:
    """Return where the forces balance, from x on, and what happened.

    Near an unstable equilibrium, Newton's steps may become so small that they neither reach nor
    leave it: there the net is pushed off.

    Args:
        looks: Whether an unstable equilibrium near x is the result; see ``descend``.

    Raises:
        Unsettled: They balance nowhere.
    """
    remarks: tuple[Remark, ...] = ()
    longest = float(balance.link_lengths(balance.bars(x)).max(initial=0.0))
    size = max(float(np.ptp(balance.start, axis=0).max()), longest)
    far = (FAR if patiently else NEARBY) * size or np.inf
    for _ in range(TURNS if patiently else 1):
        rounds, worse = (ROUNDS, ROUNDS) if patiently else (SOON, WORSE)
        found = descend(balance, x, rounds, far, worse, looks=looks)
        x = found.x
        if found.is_balanced:
            return found, remarks
        looks = None
        if not patiently or not greatest(x - balance.start) <= far or balance.inverses.refused:
            break
        bars = balance.bars(x)
        left = greatest(balance.force(bars))
        soft = softest(balance, x) if left <= NEAR * balance.largest(bars) else ()
        if soft and (mode := soft[0]).resists < -LOOSE:
            remarks = (Remark(BUCKLED, mode.node(balance)),)
            x = _pushed_off(balance, x, mode)
        elif balance.is_embedding:
            break  # relaxation knows springs between free nodes only
        else:
            relaxed = relax(balance, x, threshold=1e-3 * left, most=SWEEPS).x
            x = relaxed if np.isfinite(relaxed).all() else x
    force = balance.force(balance.bars(x))
    worst = int(np.argmax((force**2).sum(axis=1)))
    left = show(float(np.linalg.norm(force[worst])), FORCE)
    text = f"no equilibrium was found: a residual force of {left} remains"
    if refused := balance.inverses.refused:
        text += (
            "; conjugate gradients do not converge, and a factor of the stiffness would take "
            f"{shown_size(int(refused))} of memory. Use larger cells, a Poisson's ratio "
            "further from 0.5, or a dynamic method"
        )
    raise Unsettled(text, int(balance.free[worst]))


def _pushed_off(balance: Balance, x: Floats, mode: SoftestMotion) -> Floats:
    """Return a place beside an unstable equilibrium with less energy [m], shape (free, 3)."""
    bars = balance.bars(x)
    energy, _ = balance.energy(x, bars)
    size = 0.1 * float(balance.link_lengths(bars).mean()) / greatest(mode.shape)
    for _ in range(HALVINGS):
        give_way()
        for there in (x + size * mode.shape, x - size * mode.shape):
            after, rounding = balance.energy(there, balance.bars(there))
            if after < energy - rounding:
                return there
        size *= 0.5
    return x


class _Falling(NamedTuple):
    """Pieces on which forces act, and that nothing holds.

    Attributes:
        piece: Their numbers, shape (n,).
        load: Sum of the forces on each [N], shape (n, 3).
        labels: Piece of each free node, shape (free,).
    """

    piece: Indices
    load: Floats
    labels: NDArray[np.integer]


def _falling(balance: Balance, x: Floats) -> _Falling:
    """Return the pieces that fall from where they are."""
    inner, labels = (balance.link_ends >= 0).all(axis=1), balance.labels
    anchored = np.zeros(int(labels.max(initial=-1)) + 1, dtype=bool)
    anchored[labels[balance.link_ends[~inner].max(axis=1)]] = True
    anchored[labels[balance.touched(balance.bars(x).position)]] = True
    total = np.zeros((len(anchored), 3))
    np.add.at(total, labels, balance.load)
    off = np.zeros((len(anchored), 3, 3))  # planes of symmetry bear what is across them
    np.add.at(off, labels, balance.held_directions)
    total -= np.einsum("pij,pj->pi", np.linalg.pinv(off) @ off, total)
    most = UNLOADED * float(np.abs(balance.load).sum(axis=0).max())
    piece = np.flatnonzero(~anchored & (np.abs(total).max(axis=1) > most))
    return _Falling(piece, total[piece], labels)


def refuse_falling(balance: Balance, x: Floats) -> None:
    """Refuse a net with a loaded piece that nothing holds.

    Raises:
        Unsettled: Forces act on such a piece.
    """
    found = _falling(balance, x)
    if len(found.piece):
        acting = show(float(np.linalg.norm(found.load[0])), FORCE)
        text = f"there is no equilibrium: no support balances a force of {acting}"
        raise Unsettled(text, int(balance.free[np.argmax(found.labels == found.piece[0])]))


def set_down(balance: Balance, x: Floats) -> Floats:
    """Return places where pieces that fall have come upon something [m], shape (free, 3).

    Each is moved along the force on it, those furthest ahead first, until it touches.

    Raises:
        Unsettled: Nothing is in the way of one.
    """
    found, stride = _falling(balance, x), balance.contact_stride
    if not len(found.piece):
        return x
    way: Floats = found.load / norm(found.load)[:, None]
    own = [found.labels == piece for piece in found.piece]
    ahead = [float((x[nodes] @ along).max()) for nodes, along in zip(own, way, strict=True)]
    for number in np.argsort(ahead)[::-1].tolist() if np.isfinite(stride) else ():
        x = _set_down(balance, x, own[number], stride * way[number])
    refuse_falling(balance, x)
    return x


def _set_down(balance: Balance, x: Floats, own: NDArray[np.bool_], step: Floats) -> Floats:
    """Return places with some nodes moved in steps until one of them touches something.

    Args:
        own: The nodes that move together, shape (free,).
        step: So short that nothing passes through a surface unseen [m], shape (3,).
    """
    position = balance.bars(x).position.copy()
    along = step / float(np.linalg.norm(step))
    far = float(np.ptp(position @ along)) / float(np.linalg.norm(step))

    def touches(steps: float) -> bool:
        there = position.copy()
        there[balance.free[own]] += steps * step
        return bool(balance.touched(there)[own].any())

    before, after = 0.0, 1.0
    while not touches(after):
        before, after = after, after + 1.0
        if after > far + 1.0:
            return x
    for _ in range(LANDING):
        middle = 0.5 * (before + after)
        before, after = (before, middle) if touches(middle) else (middle, after)
    moved = x.copy()
    moved[own] += after * step
    return moved
