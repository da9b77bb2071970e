"""What was answered by silence is reported, and the way out that is named leads out."""

import re
from collections.abc import Sequence

from tests.every import every
from tests.mistakes.silences import IDLE, MEASURED, MORE, RIGHT, SCENE, UNITS, Silence
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Source
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

_PLACES = re.compile(r"\b[A-Z]{4,}\b")


def answered(place: str, text: str) -> Sequence[Diagnostic]:
    """Return what is said of the scene with a text at a place."""
    scene = SCENE.replace(place, text, 1) if place else f"{SCENE}{text}\n"
    source = Source("scene.tis", _PLACES.sub("", scene))
    try:
        return compile_request(Request(source))[1]
    except CompileError as error:
        return error.diagnostics


def test_the_scene_is_right():
    assert not answered("", "")


@every("name", {**IDLE, **MEASURED, **UNITS})
def test_a_silence_is_answered_and_the_way_out_leads_out(name):
    one = (IDLE | MEASURED | UNITS)[name]
    _is_answered(one)
    assert not one.mended or not answered(one.place, one.mended)


@every("name", MORE)
def test_mistakes_of_the_same_kinds_are_answered(name):
    _is_answered(MORE[name])


@every("name", RIGHT)
def test_what_is_right_is_not_answered(name):
    assert not answered(*RIGHT[name])


def _is_answered(one: Silence) -> None:
    found = answered(one.place, one.text)
    assert {each.code for each in found} == {one.code}, found
    assert any(one.said in f"{each.message}: {each.hint}" for each in found), found
