"""The fit of words to numbers of tissues, by least squares.

E = ½ Σ w ((y(θ) - t) / σ)² + ½ Σ (θ / s)²

with the conclusion y of the words and the number t of a tissue, both in the coordinate of the
scale of the quantity (the logarithm on a scale with ``on log scale``), their standard deviation
σ, and the weight w of the fit. The second sum determines parameters that the first leaves open.
"""

import time as clock
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.core.errors import CompileError, TissueError
from tissuec.learn.fit.expectations import DemandVerdict, verdicts_of
from tissuec.learn.fit.learning import LearnProgress
from tissuec.learn.vocabulary.moving import Drift, drifts_between
from tissuec.learn.vocabulary.texts import apply
from tissuec.learn.vocabulary.used import Replaced
from tissuec.learn.words_fit.model import RuleWeight, VocabularyModel, factor
from tissuec.model.network import Floats
from tissuec.pipeline import read_words
from tissuec.scene.learning.model import VocabularyFit, WordTarget
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.request import Request
from tissuec.scene.tissues.quantities import QUANTITIES
from tissuec.script.fit_problem import Errors

HELD_OUT, ALL = "held out", "data"
NOTABLE = 1.01
"""Factor from which a change of a number that is not fitted is reported."""


class FittedNumber(Struct, frozen=True):
    """A number of a tissue, and those that its words give, in SI units.

    Attributes:
        name: Name of the quantity and the tissue: "Young's modulus of liver".
        before, after: Numbers from words before and after the fit.
    """

    target: WordTarget
    name: str
    before: float
    after: float

    @property
    def factor(self) -> float:
        """Return the factor by which words are off after the fit, at least 1."""
        return factor(self.target.value, self.after)

    @property
    def factor_before(self) -> float:
        """Return the factor by which they were off before."""
        return factor(self.target.value, self.before)


class LearntVocabulary(Struct, frozen=True, eq=False):
    """A finished fit of words.

    Attributes:
        numbers: In the order of the targets.
        error, first_error: The error function after and before.
        evaluations: Number of evaluations of the words.
        reason: The reason why it ended.
        converged: Whether it ended before the passes ran out.
        wall_time: [s].
        texts: New texts of files by the names that the program has for them.
        moved: Displacements of words.
        weights: Weights that changed, each with its new value.
        notes: Further remarks.
    """

    fit: VocabularyFit
    numbers: tuple[FittedNumber, ...]
    error: float
    first_error: float
    evaluations: int
    reason: str
    converged: bool
    wall_time: float
    texts: Mapping[str, str]
    moved: tuple[Drift, ...]
    weights: tuple[tuple[RuleWeight, float], ...]
    notes: tuple[str, ...]

    @property
    def errors(self) -> Errors:
        """Return the errors that expectations can use, by name: the largest factor less 1.

        These are the errors of the fitted numbers, of those held out, and of each tissue.
        """
        parts = {
            ALL: [one for one in self.numbers if not one.target.held_out],
            HELD_OUT: [one for one in self.numbers if one.target.held_out],
        }
        for one in self.numbers:
            parts.setdefault(one.target.tissue, []).append(one)
        return {
            name: max(one.factor for one in some) - 1.0 for name, some in parts.items() if some
        }

    @property
    def verdicts(self) -> list[DemandVerdict]:
        """Return a verdict on each expectation."""
        return verdicts_of(self.fit.demands, self.errors)


def fit_words(
    request: Request,
    fit: VocabularyFit,
    words: ResolvedProgram,
    *,
    progress: Callable[[LearnProgress], None] | None = None,
) -> LearntVocabulary:
    """Carry out a ``learn`` block that fits words to numbers of tissues.

    Args:
        request: The text with the block; it need not be a scene.
        fit: The block.
        words: The vocabulary and the tissues of the text.
        progress: Callback after each evaluation.

    Raises:
        TissueError: The new words cannot be written.
    """
    from scipy.optimize import least_squares

    began = clock.monotonic()
    model = VocabularyModel(words, fit)
    problem = _Problem(model, fit)
    start = np.zeros(model.size)
    first = problem.error(start)

    def residuals(theta: Floats) -> Floats:
        found = problem.residuals(theta)
        if progress is not None:
            error, seconds = 0.5 * float(found @ found), clock.monotonic() - began
            progress(
                LearnProgress(problem.evaluations, fit.passes, 1.0, error, first, None, seconds)
            )
        return found

    found: Any = least_squares(
        residuals, start, jac=problem.jacobian, bounds=model.bounds(), x_scale=1.0,
        ftol=max(fit.tolerance, 1e-15), xtol=1e-10, gtol=None, max_nfev=fit.passes,
    )  # fmt: skip
    theta = np.asarray(found.x) if problem.error(found.x) < first else start
    texts = apply(model.edits(theta))
    after = reread_words(request, texts)
    converged = found.status > 0
    return LearntVocabulary(
        fit=fit,
        numbers=tuple(_numbers(fit, words, after)),
        error=problem.error(theta),
        first_error=first,
        evaluations=problem.evaluations,
        reason="the error no longer decreases" if converged else "the passes ran out",
        converged=converged,
        wall_time=clock.monotonic() - began,
        texts=texts,
        moved=tuple(drifts_between(words.vocabulary, after.vocabulary)),
        weights=tuple(model.changed_weights(theta)),
        notes=(*fit.left_out, *_side_effects(fit, words, after)),
    )


class _Problem:
    """Residuals of one fit, in units of their standard deviations."""

    def __init__(self, model: VocabularyModel, fit: VocabularyFit):
        self.model = model
        self.rows = np.array([not one.held_out for one in fit.targets])
        learning = [one for one in fit.targets if not one.held_out]
        self.wanted = np.array(
            [model.coordinate(one.quantity, one.value) for one in learning], dtype=float
        )
        self.scale = np.array([one.weight**0.5 / one.deviation for one in learning])
        self.sigma = model.sigma()
        self.evaluations = 0
        self.last: tuple[Floats, Floats, Floats] | None = None

    def residuals(self, theta: Floats) -> Floats:
        """Return the deviations, and the pull to the old text; NaN if no rule fires."""
        try:
            places, _ = self._places(theta)
        except TissueError:
            return np.full(len(self.wanted) + len(theta), np.nan)
        return np.concatenate([self.scale * (places - self.wanted), theta / self.sigma])

    def jacobian(self, theta: Floats) -> Floats:
        """Return the derivatives of the residuals, shape (residual, number)."""
        _, slopes = self._places(theta)
        return np.concatenate([self.scale[:, None] * slopes, np.diag(1.0 / self.sigma)])

    def error(self, theta: Floats) -> float:
        """Return the error function."""
        left = self.residuals(theta)
        return 0.5 * float(left @ left)

    def _places(self, theta: Floats) -> tuple[Floats, Floats]:
        if self.last is None or not np.array_equal(self.last[0], theta):
            self.evaluations += 1
            places, slopes = self.model.places(theta)
            self.last = np.array(theta), places[self.rows], slopes[self.rows]
        return self.last[1], self.last[2]


def reread_words(request: Request, texts: Mapping[str, str]) -> ResolvedProgram:
    """Return vocabulary and tissues with new texts of some files.

    Raises:
        TissueError: The new texts are not valid.
    """
    source = request.source
    main = replace(source, text=texts.get(source.name, source.text))
    again = replace(request, source=main, strict=False, files=Replaced(texts, request.files))
    try:
        return read_words(again)[0]
    except CompileError as error:
        raise TissueError(f"the new words cannot be written:\n{error}") from error


def _numbers(
    fit: VocabularyFit, before: ResolvedProgram, after: ResolvedProgram
) -> list[FittedNumber]:
    found: list[FittedNumber] = []
    for target in fit.targets:
        old, new = before.tissues[target.tissue], after.tissues[target.tissue]
        quantity = before.vocabulary.quantities[target.quantity].named.name
        found.append(
            FittedNumber(
                target,
                f"{quantity} of {old.name}",
                old.concluded[target.quantity],
                new.concluded[target.quantity],
            )
        )
    return found


def _side_effects(
    fit: VocabularyFit, before: ResolvedProgram, after: ResolvedProgram
) -> list[str]:
    """Return sentences about quantities that are not fitted and change with the words."""
    fitted = {target.quantity for target in fit.targets}
    most: dict[str, tuple[float, str]] = {}
    for key, old in before.tissues.items():
        for quantity, value in old.concluded.items():
            now = after.tissues[key].concluded.get(quantity, value)
            if quantity not in fitted and (far := factor(value, now)) >= NOTABLE:
                most[quantity] = max(most.get(quantity, (1.0, "")), (far, old.name))
    return [
        f"words also change the {QUANTITIES[key].name}, which is not fitted, by up to a factor "
        f"of {far:.3g} ({tissue})"
        for key, (far, tissue) in most.items()
    ]
