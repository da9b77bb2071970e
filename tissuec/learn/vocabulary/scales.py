"""A scale whose words move: from parameters to sets, with derivatives of their corners.

Degrees of corners stay as the expert wrote them. A scale whose degrees sum to 1 keeps that
sum, because every slope of its words has a corner at every knot: between two knots all degrees
are straight, and at the knots they are what they were. Words keep their order; only of two
words of which one is fully true within the core of the other, either middle may be the higher.

Knots are places of a scale that move without meeting or passing one another. Corners of words
at one place are one knot, so that shared corners stay shared and sharp edges stay sharp. The
ends of the range, corners outside of it, and those of frozen words stay where they are; between
two knots that stay, m knots part the way into m + 1 gaps

    g_j = f g0_j + (1 - f) R s_j,    s_j = g0_j e^(l_j) / Σ_i g0_i e^(l_i),
    l_j = -Σ_(k<=j) θ_k,

of the expert's widths g0_j and their sum R. A gap keeps at least the part f of its width. At
θ = 0 it has all of it, and a positive θ_k moves knot k up: by its exponential, the gaps below
grow relative to those above.
"""

import math
from bisect import bisect_right
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from tissuec.core.structs import replace
from tissuec.fuzzy.duals import Dual, Slopes
from tissuec.fuzzy.scale import Axis, Scale
from tissuec.fuzzy.sets import Gaussian, Piecewise, Shape
from tissuec.learn.vocabulary.scale_texts import ScaleForm, WordForm
from tissuec.model.network import Floats

FLOOR = 0.1
"""Part of its width that every gap keeps."""

_NEGLIGIBLE = 1e-9  # of the range; corners closer than this are at one place


class Knots:
    """The places of all corners of a scale, and the numbers by which they move.

    Attributes:
        places: Where the expert has them, ascending, in the coordinate of the axis.
        movable: Indices of the knots that move, one number each, ascending.
    """

    def __init__(self, axis: Axis, corners: Iterable[float], fixed: Iterable[float] = ()):
        low, high = axis.bounds
        fixed = set(fixed)
        self._near = _NEGLIGIBLE * (high - low)
        places: list[float] = []
        stays: list[bool] = []
        last = low
        for x in sorted({low, high, *corners, *fixed}):
            is_fixed = not low < x < high or x in fixed
            if places and x - last <= self._near:
                stays[-1] |= is_fixed
            else:
                places.append(x)
                stays.append(is_fixed)
            last = x
        self.places = tuple(places)
        self.movable = tuple(i for i, stay in enumerate(stays) if not stay)
        self._anchors = [i for i, stay in enumerate(stays) if stay]

    @property
    def size(self) -> int:
        return len(self.movable)

    def index(self, place: float) -> int:
        """Return the knot at a place where the expert has a corner."""
        return bisect_right(self.places, place + self._near) - 1

    def moves(self, theta: Floats) -> tuple[Floats, Slopes]:
        """Return how far each knot moves, and the derivatives of that.

        Args:
            theta: Dimensionless, shape (number,), one for each movable knot; any numbers.

        Returns:
            Shapes (knot,) and (knot, number), in the coordinate of the axis. At zero nothing
            moves at all, not even by rounding.
        """
        moves, slopes = np.zeros(len(self.places)), np.zeros((len(self.places), self.size))
        first = 0
        for start, end in pairwise(self._anchors):
            count = end - start - 1
            if count:
                mine, inner = slice(first, first + count), slice(start + 1, end)
                gaps = np.diff(self.places[start : end + 1])
                moves[inner], slopes[inner, mine] = _parted(gaps, theta[mine])
                first += count
        return moves, slopes


def _parted(gaps: Floats, theta: Floats) -> tuple[Floats, Slopes]:
    """Return how far the knots between two that stay move, and the derivatives of that.

    Args:
        gaps: The expert's widths, shape (knot + 1,).
        theta: Shape (knot,).
    """
    logs = np.concatenate(([0.0], -np.cumsum(theta)))
    grown = gaps * np.exp(logs - logs.max())
    parts, whole = grown / grown.sum(), (1.0 - FLOOR) * gaps.sum()
    moves = whole * np.cumsum(parts - gaps / gaps.sum())[:-1]
    # Number k lowers the logarithms of gaps k and above: d s_j = s_j ([k > j] - Σ_(i<k) s_i).
    below = np.cumsum(parts)[:-1]
    order = np.arange(len(gaps))
    slopes = parts[:, None] * ((order[:, None] <= order[:-1]) - below)
    return moves, whole * np.cumsum(slopes, axis=0)[:-1]


WIDEST = 0.99
"""Part of the range that the sigma of a bell grows up to."""

_WHOLE = 1e-9  # a sum of degrees this close to 1 is meant to be 1


class MovingScale:
    """The words of a property or quantity as functions of the numbers that move them.

    Attributes:
        form: How the scale is written; words of one that sums to 1 may have further corners.
        names: Of each number, such as "hardness: peak of medium".
        start: Index of the first of its numbers among those of all scales.
    """

    def __init__(self, form: ScaleForm, start: int = 0, frozen: Collection[str] = ()):
        axis = form.named.scale.axis
        corners = [x for word in form.words for x in word.corners]
        is_whole = _sums_to_one(form, Knots(axis, corners))
        fixed = _fixed(form, frozen, corners if is_whole else ())
        self.knots = Knots(axis, corners, fixed)
        self.form = _refined(form, self.knots) if is_whole else form
        pairs = zip(form.words, self.form.words, strict=True)
        #: Words that have further corners, where their slopes pass over others.
        self.added = {new.word for old, new in pairs if new is not old}
        self.start = start
        #: Bells whose width may change; one nearly as wide as the range stays so.
        self.bells = [
            word
            for word in form.words
            if word.bell is not None
            and word.word not in frozen
            and word.bell.sigma < WIDEST * (axis.bounds[1] - axis.bounds[0])
        ]
        title = form.named.name
        self.names = tuple(f"{title}: {name}" for name in self._names())

    @property
    def size(self) -> int:
        return len(self.names)

    def scale(self, theta: Floats, *, total: int | None = None) -> Scale:
        """Return the scale with its words moved.

        Args:
            theta: Parameters of this scale, dimensionless, shape (number,); zero is the
                original.
            total: Where derivatives are wanted: the number of parameters of all scales. Corners
                are dual numbers then.
        """
        axis = self.form.named.scale.axis
        places = self._places(theta, total)
        widths = dict(self._widths(theta, total))
        words: dict[str, Shape] = {}
        for word in self.form.words:
            xs = tuple(x + places[self.knots.index(x)] for x in word.corners)
            if word.bell is not None:
                shape = Gaussian(xs[0], widths.get(word.word, word.bell.sigma))
            else:
                shape = Piecewise(xs, word.degrees)
            words[word.word] = shape.within(*axis.bounds)
        return Scale(axis, words)

    def _places(self, theta: Floats, total: int | None) -> Sequence[float]:
        """Return by how much each knot moves."""
        moves, slopes = self.knots.moves(theta[: self.knots.size])
        if total is None:
            return moves.tolist()
        moving = set(self.knots.movable)
        return [
            Dual(move, self._widened(slope, 0, total)) if knot in moving else move
            for knot, (move, slope) in enumerate(zip(moves.tolist(), slopes, strict=True))
        ]

    def _widths(self, theta: Floats, total: int | None) -> Iterator[tuple[str, float]]:
        """Yield the width of each bell: from a part of the expert's to most of the range."""
        low, high = self.form.named.scale.axis.bounds
        for number, word in enumerate(self.bells, self.knots.size):
            assert word.bell is not None
            least = FLOOR * word.bell.sigma
            most = WIDEST * (high - low) - least
            part = (word.bell.sigma - least) / most
            share, slope = _logistic(part, float(theta[number]))
            width = word.bell.sigma + most * (share - part)
            if total is None:
                yield word.word, width
            else:
                yield word.word, Dual(width, self._widened([most * slope], number, total))

    def _widened(self, slopes: Sequence[float] | Slopes, first: int, total: int) -> Slopes:
        """Return derivatives by some numbers of this scale as ones by all numbers."""
        wide = np.zeros(total)
        wide[self.start + first : self.start + first + len(slopes)] = slopes
        return wide

    # --- names --------------------------------------------------------------------------------

    def _names(self) -> Iterator[str]:
        taken: dict[str, int] = {}
        for knot in self.knots.movable:
            name = min(
                (named for word in self.form.words if (named := self._named(knot, word))),
                key=lambda named: named[0],
            )[1]
            taken[name] = taken.get(name, 0) + 1
            yield name if taken[name] == 1 else f"{name} ({taken[name]})"
        for word in self.bells:
            yield f"width of {word.word}"

    def _named(self, knot: int, word: WordForm) -> tuple[int, str] | None:
        """Return the role of a knot in a word, and its rank: the lower, the more it says."""
        own = [self.knots.index(x) for x in word.corners]
        if knot not in own:
            return None
        top = max(word.degrees)
        core = [at for at, y in zip(own, word.degrees, strict=True) if y == top]
        if knot in core:
            first, last = core[0] == knot, core[-1] == knot
            what = "peak" if first and last else "start" if first else "end"
            return (0 if what == "peak" else 1), f"{what} of {word.word}"
        side = "lower" if knot < core[0] else "upper"
        return 2, f"{side} flank of {word.word}"


def _logistic(part: float, theta: float) -> tuple[float, float]:
    """Return the part of a whole at ``theta``, exactly ``part`` at zero, and its slope."""
    if theta > 0.0:
        share = part / (part + (1.0 - part) * math.exp(-theta))
    else:
        grown = part * math.exp(theta)
        share = grown / (grown + (1.0 - part))
    return (part if theta == 0.0 else share), share * (1.0 - share)


def _fixed(form: ScaleForm, frozen: Collection[str], corners: Sequence[float]) -> list[float]:
    """Return the corners of frozen words, and those of others that lie on their slopes."""
    words = [word for word in form.words if word.word in frozen]
    fixed = [x for word in words for x in word.corners]
    for word in words:
        if word.bell is None:
            shape, top = Piecewise(word.corners, word.degrees), max(word.degrees)
            fixed += [x for x in corners if 0.0 < shape.degree(x) < top]
    return fixed


def _refined(form: ScaleForm, knots: Knots) -> ScaleForm:
    """Return a scale that sums to 1 with a corner of every word at each knot on its slopes."""
    words = tuple(_with_corners(word, knots) for word in form.words)
    return replace(form, words=words)


def _sums_to_one(form: ScaleForm, knots: Knots) -> bool:
    shapes = list(form.named.scale.words.values())
    if any(isinstance(shape, Gaussian) for shape in shapes):
        return False
    low, high = form.named.scale.axis.bounds
    inside = [x for x in knots.places if low <= x <= high]
    # Exactly on a sharp edge both words are true; beside it, the sum shows.
    places = [a + (b - a) * part for a, b in pairwise(inside) for part in (0.25, 0.75)]
    return all(abs(sum(s.degree(x) for s in shapes) - 1.0) < _WHOLE for x in places)


def _with_corners(word: WordForm, knots: Knots) -> WordForm:
    """Return a word with further corners where its slopes pass over knots that move."""
    shape = Piecewise(word.corners, word.degrees)
    own = {knots.index(x) for x in word.corners}
    passed = [
        (knots.places[knot], shape.degree(knots.places[knot]))
        for knot in knots.movable
        if knot not in own
    ]
    added = [(x, y) for x, y in passed if 0.0 < y < max(word.degrees)]
    if not added:
        return word
    pairs = list(zip(word.corners, word.degrees, strict=True))
    for x, y in added:
        at = next(i for i, (corner, _) in enumerate(pairs) if corner > x)
        pairs.insert(at, (x, y))
    xs, ys = zip(*pairs, strict=True)
    return replace(word, corners=xs, degrees=ys)
