"""Scenes whose tissues are described in words: random vocabularies, and one that is small."""

import random
from functools import cache

import numpy as np

from tests.view.explorer.vocabularies import vocabulary
from tissuec.core.source import Source, Span
from tissuec.core.units import NUMBER, show
from tissuec.lang.words import RESERVED
from tissuec.learn.vocabulary.moving import WordsModel
from tissuec.scene.model import Scene
from tissuec.scene.program.imports import load
from tissuec.scene.reading.findings import Findings
from tissuec.scene.resolve import resolve
from tissuec.script.fit_problem import WORDS, Adjust

LETTERS = "PQRS"
BODY = """
body part {k} {{
  mesh is tube {{ axis from (0, 0, 0) cm to (4, 0, 0) cm; radius = 3 mm
    rings = 3; sides = 4; diagonals is both; interior is none }}
  tissue is flesh {k}
}}
"""
SETTING = """
environment { gravity = (0, 0, 0) m/s^2; contact is off; damping = 0 N*s/m }
simulate { duration = 1 ms; integrator is automatic; tolerance = 1e-3 }
"""


def scene_of(text: str, *overrides: str) -> Scene:
    findings = Findings()
    program = load(Source("words.tis", text), (), findings)
    scene = resolve(program, findings, overrides)
    findings.raise_errors()
    return scene


def words_of(name: str) -> Adjust:
    """Return the entry ``adjust words of NAME``."""
    span = Span(Source("a.tis", ""), 0, 0)
    nobody = np.zeros(0, dtype=np.int64)
    return Adjust(WORDS, name, "word", nobody, None, NUMBER, 0.0, 0.0, None, span)


def everything(scene: Scene, **options) -> WordsModel:
    """Return the model in which all words move."""
    words = scene.vocabulary
    return WordsModel(
        scene, [words_of(key) for key in (*words.properties, *words.quantities)], **options
    )


@cache
def random_scene(seed: int) -> Scene:
    """Return a scene of tissues that are described in a random vocabulary."""
    one = vocabulary(seed)
    source = random.Random(seed)
    tissues = "".join(tissue(one, k, source) for k in LETTERS)
    bodies = "".join(BODY.format(k=k) for k in LETTERS)
    return scene_of(one.text + tissues + bodies + SETTING)


def tissue(one, letter: str, source: random.Random) -> str:
    """Return a tissue described in words, hedged words, pairs of words and numbers."""
    words = one.words.vocabulary
    lines = [f"described in {_quoted(next(iter(words.rules)))}"]
    hedges = [hedge for hedge in words.hedges if hedge in ("very", "rather")]
    for key, named in words.properties.items():
        listed = list(named.scale.words)
        phrase = _quoted(source.choice(listed))
        kind = source.random()
        if kind < 0.2:
            axis = named.scale.axis
            place = source.uniform(*axis.bounds)
            lines.append(f"{_quoted(key)} = {_number(axis.from_scale(place), named)}")
            continue
        if kind < 0.4 and hedges:
            phrase = f"{source.choice(hedges)} {phrase}"
        elif kind < 0.6 and len(listed) > 1:
            phrase = "between " + " and ".join(map(_quoted, source.sample(listed, 2)))
        lines.append(f"{_quoted(key)} is {phrase}")
    body = "\n  ".join(lines)
    return f"\ntissue flesh {letter} {{\n  {body}\n}}\n"


def _number(value: float, named) -> str:
    return show(value, named.dimension, digits=12)


def _quoted(key: str) -> str:
    """Return a name in quotes where it has a word that is reserved."""
    return f'"{key}"' if set(key.split()) & RESERVED else key
