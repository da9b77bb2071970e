"""Resistance: friction, areas of springs, energies of cuts, and the force of blades."""

from collections.abc import Mapping, Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.profiles import TimeProfile

Floats = NDArray[np.float64]


class CuttingResistance(Struct, frozen=True, eq=False):
    """The energy that a blade needs, by area of the cut surface as drawn.

    Attributes:
        areas: Sections of bars [m²], 0 of other springs, shape (spring,).
        springs: Resistance of bars [J/m²], shape (spring,).
        elements: Resistance of elements [J/m²] by the name of their block, shape (element,).
    """

    areas: Floats
    springs: Floats
    elements: Mapping[str, Floats]


SAME = 1e-9  # share of a line: what ends and what begins so near to each other adjoin


class ClosingForce(Struct, frozen=True, eq=False):
    """The force of blades that close along a line.

    The cut consists of pieces. While the blades are between two shares of the line, a piece
    takes an energy per share that changes evenly from the first share to the second.

    Attributes:
        tool: The tool; empty if none is named.
        way: From the beginning of the line to its end [m], shape (3,).
        profile: Share of the line that the blades have come.
        shares: From 0 to 1, the first below the second, shape (piece, 2).
        rates: Energies per share there [J], shape (piece, 2).
    """

    tool: str
    way: Floats
    profile: TimeProfile
    shares: Floats
    rates: Floats

    @classmethod
    def of(
        cls, tool: str, way: Floats, profile: TimeProfile, shares: Floats, rates: Floats
    ) -> "ClosingForce":
        """Return the force of pieces that adjoin to within rounding.

        Shares that differ by rounding alone become one, so that no moment belongs to two
        neighbours, or to none.

        Args:
            tool: The scissors.
            way: From the beginning of the line to its end [m], shape (3,).
            profile: Share of the line that the blades have come.
            shares: Where pieces begin and end, shape (piece, 2).
            rates: Energies per share there [J], shape (piece, 2).
        """
        shares = np.clip(shares, 0.0, 1.0)
        every, where = np.unique(shares, return_inverse=True)
        starts = np.diff(every, prepend=-np.inf) > SAME
        shares = every[starts][np.cumsum(starts) - 1][where].reshape(shares.shape)
        kept = (shares[:, 0] < shares[:, 1]) & rates.any(axis=1)
        return cls(tool, way, profile, shares[kept], rates[kept])

    def at(self, time: Floats | float) -> Floats:
        """Return the force that closes the blades [N], shape (…, 3).

        Args:
            time: [s], shape (…).
        """
        time = np.asarray(time, dtype=float)
        share = np.asarray(self.profile.at(time)[0])[..., None]
        moves = (time > self.profile.start) & (time < self.profile.stop)
        (low, high), (first, second) = self.shares.T, self.rates.T
        reached = moves[..., None] & (share >= low) & (share < high)
        rate = first + (second - first) * ((share - low) / (high - low))
        per_share = np.where(reached, rate, 0.0).sum(axis=-1)
        return per_share[..., None] * self.way / (self.way @ self.way)


class SurfaceFriction(Struct, frozen=True, eq=False):
    """Coefficients of friction that tissues give.

    Attributes:
        nodes: Of the nodes of bodies, shape (body node,).
        skin: Of the triangles of their surfaces, shape (triangle,).
    """

    nodes: Floats
    skin: Floats

    @classmethod
    def joined(cls, parts: Sequence["SurfaceFriction"]) -> "SurfaceFriction | None":
        """Return the coefficients of several bodies, one after the other; None without any."""
        if not any(one.nodes.any() for one in parts):
            return None
        return cls(
            np.concatenate([one.nodes for one in parts]),
            np.concatenate([one.skin for one in parts]),
        )
