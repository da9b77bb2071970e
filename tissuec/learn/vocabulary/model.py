"""A vocabulary whose words move: from parameters to the numbers that rules give.

Each number moves a corner of one scale (or the width of a bell); zero is the expert's text.
Rules and tissues are read anew with the moved words, by the functions that compile a scene, so
that hedges, operators and facts given as words mean what they mean there. Derivatives are
carried along by the same functions; minimum and maximum choose a branch.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.fuzzy.duals import slopes_of
from tissuec.fuzzy.rulebase import Inference
from tissuec.lang import syntax as s
from tissuec.learn.vocabulary.moving import MovingVocabulary
from tissuec.learn.vocabulary.used import Use, used_tissues
from tissuec.model.network import Floats
from tissuec.scene.model import Scene
from tissuec.scene.program.parameters import Constants
from tissuec.scene.reading.findings import Findings
from tissuec.scene.words.vocabulary import RulesBlock, RulesReader
from tissuec.script.fit_problem import WORDS, Adjust

SIGMA = 0.5
"""How far numbers are expected to be from the expert's words, where nothing else is said."""

Pair = tuple[str, str]
"""A tissue and a quantity, both by their names in small letters."""


class NoAnswer(TissueError):
    """With these words no rule speaks for a quantity that the rules gave before."""


class RuleOutputs(NamedTuple):
    """Numbers that rules give, with their derivatives.

    Attributes:
        pairs: Tissues and quantities.
        values: In SI units, shape (pair,).
        slopes: Derivatives by the numbers, shape (pair, number).
    """

    pairs: list[Pair]
    values: Floats
    slopes: Floats


class WordsModel(MovingVocabulary):
    """Numbers that the rules of a scene give, as a function of the parameters of words.

    Args:
        scene: The scene.
        adjusts: Entries of a ``learn`` block; those of ``WORDS`` count, each for one scale.
        frozen: Words that stay where they are, by the name of their scale.

    Attributes:
        names: Of each number, such as "hardness: peak of medium".
        pairs: Tissues that the scene uses, with their quantities that rules give.

    Raises:
        ValueError: The vocabulary has no such scale, or the scale no such word.
    """

    def __init__(
        self,
        scene: Scene,
        adjusts: Sequence[Adjust],
        *,
        frozen: Mapping[str, Collection[str]] | None = None,
    ):
        self._scene = scene
        chosen = (s.key_of(one.of) for one in adjusts if one.what == WORDS)
        super().__init__(scene, chosen, frozen)
        self._uses = used_tissues(scene)
        self.pairs: list[Pair] = [
            (use.key, quantity) for use in self._uses for quantity in use.quantities
        ]

    def given(self, theta: Floats) -> dict[Pair, float]:
        """Return the numbers that rules give with words moved by ``theta``, in SI units.

        Raises:
            NoAnswer: No rule fires any more where one did.
        """
        return self._answers(theta, None)

    def linearised(self, theta: Floats) -> RuleOutputs:
        """Return the numbers that rules give and their derivatives; raises like ``given``."""
        answers = self._answers(theta, self.size)
        values = np.array([float(value) for value in answers.values()])
        slopes = [slopes_of(value, self.size) for value in answers.values()]
        return RuleOutputs(self.pairs, values, np.reshape(slopes, (len(values), self.size)))

    def jacobian(self, theta: Floats) -> tuple[list[Pair], Floats]:
        """Return the derivatives of the logarithms of what rules give; raises like ``given``.

        Returns:
            Tissues and quantities, and shape (pair, number). Of negative values, the logarithms
            of their amounts are meant; a value of zero has none, and its row is not finite.
        """
        pairs, values, slopes = self.linearised(theta)
        with np.errstate(divide="ignore", invalid="ignore"):
            return pairs, slopes / values[:, None]

    def prior(self, theta: Floats, sigma: float = SIGMA) -> tuple[Floats, Floats]:
        """Return residuals that pull words to their original places, and their derivatives.

        Args:
            theta: Parameters of words, dimensionless, shape (number,).
            sigma: Standard deviation of the parameters.

        Returns:
            Dimensionless, shapes (number,) and (number, number).
        """
        return np.asarray(theta, dtype=float) / sigma, np.eye(self.size) / sigma

    # --- inference ----------------------------------------------------------------------------

    def _answers(self, theta: Floats, total: int | None) -> dict[Pair, float]:
        scene = self._scene
        vocabulary = self.vocabulary(theta, total=total)
        # Warnings were given when the scene was read.
        scope = Constants(scene.declarations, scene.constants.overrides, Findings())
        rules: dict[str, RulesBlock] = {}
        answers: dict[Pair, float] = {}
        for use in self._uses:
            if use.rules not in rules:
                declared = scene.declarations.of("rules")[use.rules]
                reader = RulesReader(declared.name, declared.item, vocabulary, scope)
                rules[use.rules] = reader.read()
            said = rules[use.rules].base.infer(use.facts(vocabulary, scope))
            for quantity in use.quantities:
                answer = said[quantity]
                if not isinstance(answer, Inference):
                    raise NoAnswer(_silence(use, quantity))
                answers[use.key, quantity] = answer.value
        return answers


def _silence(use: Use, quantity: str) -> str:
    return f"with these words, no rule gives the {quantity} of {use.key}"
