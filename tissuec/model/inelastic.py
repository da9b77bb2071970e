"""What springs remember: branches that relax, and rest lengths that flow.

A branch is a spring c1 and a dashpot c1 τ in a row, beside the spring; q is what its dashpot
gave way by. Above the yield force F the rest length flows by p, with the viscosity η. For the
equations see ``forces.springs``.

The variables q and p follow the velocities of nodes in a state, each times a ``rate``, so that
they are stepped, stored and resumed like all other motion; see ``Network.internal``.
"""

from collections.abc import Callable
from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

ORDINALS = ("", "second ", "third ")  # of the branches that a spring can have
CONSTANTS = tuple(f"{ordinal}relaxing constant" for ordinal in ORDINALS)
TIMES = tuple(f"{ordinal}relaxation time" for ordinal in ORDINALS)
LIMIT, VISCOSITY = "yield force", "yield viscosity"
#: What says nothing without the other, and by which of both a spring has a variable.
PAIRS = (*zip(CONSTANTS, TIMES, strict=True), (LIMIT, VISCOSITY))
NAMES = tuple(name for pair in PAIRS for name in pair)


class Inelastic(Struct, frozen=True, eq=False):
    """Internal variables of springs: parameters and storage.

    Attributes:
        constant: c1 of each branch [N/m], shape (branch, spring).
        time: τ of each branch [s], shape (branch, spring); infinite where there is none.
        limit: F [N], shape (spring,); infinite where nothing yields.
        viscosity: η [N s/m], shape (spring,); infinite where nothing ever will.
        slot: Place of q of each branch, and last of p, among the components of all velocities,
            -1 where there is none, shape (branch + 1, spring).
        rate: What variables are multiplied by there [1/s], shape (branch + 1, spring).
    """

    constant: Floats
    time: Floats
    limit: Floats
    viscosity: Floats
    slot: Indices
    rate: Floats

    @property
    def remembers(self) -> NDArray[np.bool_]:
        """Return which springs have any variable, shape (spring,)."""
        return np.any(self.slot >= 0, axis=0, keepdims=True)[0]

    @property
    def sudden(self) -> Floats:
        """Return the stiffness that branches add to a sudden pull [N/m], shape (spring,)."""
        return self.constant.sum(axis=0)

    def some(self, springs: NDArray[np.integer] | slice) -> Self:
        """Return the same for some springs.

        Args:
            springs: Indices of shape (n,), or a slice.
        """
        return replace(
            self,
            constant=self.constant[:, springs],
            time=self.time[:, springs],
            limit=self.limit[springs],
            viscosity=self.viscosity[springs],
            slot=self.slot[:, springs],
            rate=self.rate[:, springs],
        )

    def only(self, alive: NDArray[np.bool_]) -> Self:
        """Return the same without forces, relaxation or flow in springs that are not alive.

        Args:
            alive: Which springs act, shape (spring,).
        """
        return replace(
            self,
            constant=np.where(alive, self.constant, 0.0),
            time=np.where(alive, self.time, np.inf),
            limit=np.where(alive, self.limit, np.inf),
        )

    def renumbered(self, place: Indices) -> Self:
        """Return the same with node i renamed to ``place[i]``, ``place`` of shape (node,)."""
        moved = 3 * place[self.slot // 3] + self.slot % 3
        return replace(self, slot=np.where(self.slot >= 0, moved, -1))

    def without_branches(self) -> Self:
        """Return the same with branches that have given way for good, and so do not pull."""
        return replace(self, constant=np.zeros_like(self.constant))

    def changed(
        self, name: str, springs: Indices, change: Callable[[Floats], Floats | float]
    ) -> Self:
        """Return the same with changed parameters of some springs.

        Args:
            name: One of ``NAMES``.
            springs: Indices of the springs, shape (n,).
            change: Returns new values for the present ones, both of shape (n,), in the unit of
                the attribute.
        """
        field, row = _FIELDS[name]
        values = getattr(self, field).copy()
        part = values if row is None else values[row]
        part[springs] = change(part[springs])
        return replace(self, **{field: values})

    def has(self, name: str) -> NDArray[np.bool_]:
        """Return which springs have the variable of a parameter in ``NAMES``.

        The shape is (spring,).
        """
        row = _FIELDS[name][1]
        if row is not None and row >= len(self.constant):
            return np.zeros(len(self.slot[0]), dtype=np.bool_)
        return np.asarray(self.slot[-1 if row is None else row], dtype=np.int64) >= 0

    # --- variables ----------------------------------------------------------------------------

    def variables(self, velocity: Floats) -> Floats:
        """Return q of each branch and last p [m], shape (…, branch + 1, spring).

        Args:
            velocity: Of all nodes, flat, shape (…, 3 node).
        """
        has = self.slot >= 0
        found = velocity[..., np.where(has, self.slot, 0)]
        return np.where(has, found / self.rate, 0.0)

    def flowed(self, velocity: Floats) -> Floats:
        """Return p alone [m], shape (…, spring)."""
        has = self.slot[-1] >= 0
        found = velocity[..., np.where(has, self.slot[-1], 0)]
        return np.where(has, found / self.rate[-1], 0.0)

    def pull(self, e: Floats, variables: Floats) -> Floats:
        """Return Σ c1 (e - q) [N], shape (…, spring)."""
        return (self.constant * (e[..., None, :] - variables[..., :-1, :])).sum(axis=-2)

    def energy(self, e: Floats, variables: Floats) -> Floats:
        """Return Σ ½ c1 (e - q)² [J], shape (…, spring)."""
        own = e[..., None, :] - variables[..., :-1, :]
        return (0.5 * self.constant * own * own).sum(axis=-2)

    def fastest(self, steepness: Floats) -> Floats:
        """Return a bound of the rates at which springs relax and flow [1/s], shape (spring,).

        Args:
            steepness: f' [N/m], shape (spring,).
        """
        flowing = np.isfinite(self.limit) * (steepness + self.sudden) / self.viscosity
        return np.maximum((1.0 / self.time).max(axis=0, initial=0.0), flowing)

    def let_relax(self, velocity: Floats, e: Floats, springs: Indices) -> None:
        """Make the branches of some springs give way for good, in the velocities of all nodes.

        Args:
            velocity: Changed in place, shape (node, 3).
            e: Elongations of all springs [m], shape (spring,).
        """
        flat = velocity.reshape(-1)
        for slot, rate in zip(self.slot[:-1, springs], self.rate[:-1, springs], strict=True):
            has = slot >= 0
            flat[slot[has]] = (rate * e[springs])[has]


_FIELDS: dict[str, tuple[str, int | None]] = {
    **{name: ("constant", row) for row, name in enumerate(CONSTANTS)},
    **{name: ("time", row) for row, name in enumerate(TIMES)},
    LIMIT: ("limit", None),
    VISCOSITY: ("viscosity", None),
}
