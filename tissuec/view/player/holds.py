"""What is held: patches of the skin, springs between held nodes, and single nodes."""

from collections.abc import Container, Iterator
from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.film import HeldTissue, SkinPiece
from tissuec.view.player.lifetimes import Mask, Timeline, lives
from tissuec.view.player.thinning import Thinning

FIX = "fix"


class DrawnNet(Struct, frozen=True, eq=False):
    """What held nodes can be seen by.

    Attributes:
        thin: Which nodes are drawn.
        skin: Triangles between them.
        ends: Of springs between them, shape (spring, 2).
        at_skin: Which of these are edges of the skin, shape (spring,).
    """

    thin: Thinning
    skin: SkinPiece
    ends: Indices
    at_skin: Mask

    @classmethod
    def of(cls, thin: Thinning, skin: SkinPiece, ends: Indices) -> Self:
        """Return that of a film.

        Args:
            thin: Which nodes are drawn.
            skin: Triangles between them.
            ends: Of springs between them, shape (spring, 2).
        """
        corners = skin.triangles.astype(np.int64)
        sides = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        pairs, key = np.sort(ends, axis=1), np.array([len(thin.kept), 1])
        return cls(thin, skin, ends, np.isin(pairs @ key, sides @ key))

    def triangles(self, held: Mask) -> Mask:
        """Return which drawn triangles have held nodes only, shape (triangle,)."""
        return held[self.skin.triangles].all(axis=1) & ~self.skin.smooth

    def springs(self, held: Mask) -> Mask:
        """Return which edges of the skin lead between held nodes outside of patches.

        Args:
            held: Which nodes are held, shape (node,).

        Returns:
            Shape (spring,).
        """
        covered = self._covered(held)[self.ends].all(axis=1)
        return held[self.ends].all(axis=1) & self.at_skin & ~covered

    def nodes(self, held: Mask) -> Mask:
        """Return which held nodes belong to no such triangle or spring, shape (node,)."""
        covered = self._covered(held)
        covered[self.ends[self.springs(held)]] = True
        return held & ~covered

    def _covered(self, held: Mask) -> Mask:
        covered = np.zeros(len(held), dtype=bool)
        covered[self.skin.triangles[self.triangles(held)]] = True
        return covered


def read_held(
    trajectory: Trajectory, timeline: Timeline, drawn: DrawnNet, seen: Container[str]
) -> HeldTissue:
    """Return what is held when.

    Args:
        trajectory: The result.
        timeline: The frames that are shown.
        drawn: What held nodes can be seen by.
        seen: Tools that are drawn themselves, and not what they hold.
    """
    patches = np.zeros((len(drawn.skin.triangles), 2))
    moved = np.zeros(len(patches), dtype=bool)
    rods: list[tuple[Indices, Floats, bool]] = []
    for fixed in (True, False):
        masks = list(_changes(trajectory, timeline, drawn.thin, seen, fixed=fixed))
        if not masks:
            continue
        found = lives(((at, drawn.triangles(held)) for at, held in masks), len(patches))
        longest = np.argsort(found.life[:, 1] - found.life[:, 0], kind="stable")
        patches[found.of[longest]] = found.life[longest]
        moved[found.of] = not fixed
        springs = lives(((at, drawn.springs(held)) for at, held in masks), len(drawn.ends))
        nodes = lives(((at, drawn.nodes(held)) for at, held in masks), len(drawn.thin.kept))
        rods.append((drawn.ends[springs.of], springs.life, fixed))
        rods.append((np.stack([nodes.of, nodes.of], axis=1), nodes.life, fixed))
    none = np.zeros((0, 2))
    return HeldTissue(
        patches,
        moved,
        np.concatenate([none.astype(np.int64), *(ends for ends, _, _ in rods)]),
        np.concatenate([none, *(life for _, life, _ in rods)]),
        np.repeat([fixed for _, _, fixed in rods], [len(ends) for ends, _, _ in rods]) > 0,
    )


def _changes(
    trajectory: Trajectory,
    timeline: Timeline,
    thin: Thinning,
    seen: Container[str],
    *,
    fixed: bool,
) -> Iterator[tuple[float, Mask]]:
    """Yield frames, and which of the drawn nodes are held from then on."""
    holders: dict[str, NDArray[np.integer]] = {}
    for hold in trajectory.holds:
        if hold.holder in seen or hold.time > timeline.times[-1]:
            continue
        if (hold.holder == FIX) == fixed:
            holders[hold.holder] = hold.nodes
            held = np.unique(np.concatenate(list(holders.values())))
            shown = np.isin(trajectory.nodes, held)
            yield float(timeline.frame_of(hold.time)), shown[thin.kept]
