"""New texts of a vocabulary: words that moved, and rules that were revised."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.learn.motion import Diverged
from tissuec.learn.problem import Problem
from tissuec.learn.session import Session, prepare
from tissuec.learn.words.rereading import request_of
from tissuec.learn.words.revision import revise
from tissuec.lesson import WORDS
from tissuec.network import Floats
from tissuec.pipeline import Request, compile_request


class Revised(NamedTuple):
    """New texts by the name of their file, and what was changed, in sentences."""

    texts: Mapping[str, str]
    sentences: tuple[str, ...]


def revised(session: Session, request: Request, problem: Problem, theta: Floats) -> Revised:
    """Return the vocabulary with moved words and, where that was asked for, other rules."""
    shaping, words = session.shaping, session.words
    own = theta[shaping.own : shaping.size]
    texts: dict[str, str] = {} if words is None else dict(words.texts(own))
    sentences = [] if words is None else [one.sentence for one in words.drift(own)]
    for name in session.lesson.revise:

        def score(more: Mapping[str, str]) -> tuple[float, float]:
            return _score(session, request, problem, theta, {**texts, **more})

        for change in revise(session.shaping.compiled.scene, name, score):
            texts[change.file] = change.text
            sentences.append(change.sentence)
    return Revised(texts, tuple(sentences))


def _score(
    session: Session,
    request: Request,
    problem: Problem,
    theta: Floats,
    texts: Mapping[str, str],
) -> tuple[float, float]:
    """Return the errors, in units of the data, with other texts of the vocabulary.

    That of what was held out is infinite where nothing was; both are where there is no motion.
    """
    old = session.lesson
    try:
        files = request_of(session.shaping.compiled.scene, texts)
        compiled, _ = compile_request(replace(request, source=files.source, files=files.files))
        lesson = next(one for one in compiled.lessons if one.name == old.name)
        kept = tuple(adjust for adjust in lesson.adjusts if adjust.what != WORDS)
        other = prepare(compiled, replace(lesson, adjusts=kept), request)
        inner = np.concatenate([theta[: session.shaping.own], theta[session.shaping.size :]])
        errors = []
        for trials in (other.learning, other.held_out):
            judged = other.judged(trials, problem)
            judged.freeze(inner)
            errors.append(judged.relative(inner) if trials else np.inf)
    except (TissueError, Diverged):
        return np.inf, np.inf
    return errors[0], errors[1]
