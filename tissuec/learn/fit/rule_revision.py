"""Revision of rules: each candidate is fitted, and chosen by rows that were not fitted.

Words and numbers are fitted to two thirds of the rows from where the text has them, with each
candidate: words that were moved for a wrong rule say nothing of the right one. The other rows
choose. What is held out has no say in it, so that it can judge the result.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tissuec.compiler.compile import Compiled
from tissuec.core.errors import TissueError
from tissuec.core.structs import replace
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.problem import Problem
from tissuec.learn.fit.search import Search
from tissuec.learn.fit.session import LearnSession, prepare
from tissuec.learn.vocabulary.revision import GAIN, revise
from tissuec.learn.vocabulary.used import request_of
from tissuec.measurements.experiment import Experiment
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.fit_problem import FitProblem

EVERY = 3  # rows, of which the last one chooses
ROUNDS = 12  # of the fit of a candidate
CHANCE = 5.0  # over the count of numbers: a part by which errors may differ by chance


class CandidateScene(NamedTuple):
    """A scene with its fit problem, and the request that compiles it."""

    compiled: Compiled
    fit_problem: FitProblem
    request: Request


class Revised(NamedTuple):
    """New texts by the names of their files, and the changes in sentences."""

    texts: Mapping[str, str]
    sentences: tuple[str, ...]


def with_texts(scene: CandidateScene, texts: Mapping[str, str]) -> CandidateScene:
    """Return a scene with other texts of some of its files; raises CompileError."""
    files = request_of(scene.compiled.scene, texts)
    request = replace(scene.request, source=files.source, files=files.files)
    compiled, _ = compile_request(request)
    fit_problem = next(
        one for one in compiled.fit_problems if one.name == scene.fit_problem.name
    )
    return CandidateScene(compiled, fit_problem, request)


def revised(scene: CandidateScene, session: LearnSession) -> Revised:
    """Return the texts of rules that let rows which were not fitted be met better.

    Args:
        scene: The scene with the rules as they are written.
        session: Prepared from it.
    """
    texts, sentences = dict[str, str](), list[str]()
    gain = max(GAIN, CHANCE / max(int(_chooses(session.problem).sum()), 1))
    for name in scene.fit_problem.revise:
        changes = revise(
            scene.compiled.scene,
            name,
            lambda more: _score(scene, more, session.experiments),
            start=texts,
            gain=gain,
        )
        for change in changes:
            texts[change.file] = change.text
            sentences.append(change.sentence)
    return Revised(texts, tuple(sentences))


def _score(
    scene: CandidateScene, texts: Mapping[str, str], experiments: Sequence[Experiment]
) -> tuple[float, float]:
    """Return the errors of the rows that are fitted and of those that choose.

    Both are infinite where there is no motion.
    """
    try:
        session = prepare(*with_texts(scene, texts), experiments)
        problem = session.problem
        chooses = _chooses(problem)
        problem.part = ~chooses
        theta = Search(problem, session.bounds(problem), lambda _: None).once(ROUNDS)
        problem.freeze(theta)
        fitted = problem.relative(theta)
        problem.part = chooses
        return fitted, problem.relative(theta)
    except (TissueError, Diverged):
        return np.inf, np.inf


def _chooses(problem: Problem) -> np.ndarray:
    """Return which numbers choose between rules, shape (number,)."""
    return problem.rows % EVERY == EVERY - 1
