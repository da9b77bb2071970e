"""What was answered by silence is reported, and the way out that is named leads out."""

import re

import tissuec
from tests.every import every
from tests.mistakes.silences import SCENE, SILENCES
from tissuec.core.errors import Diagnostic

_PLACES = re.compile(r"\b[A-Z]{4,}\b")


def answered(place: str, text: str) -> list[Diagnostic]:
    """Return what is said of the scene with a text at a place."""
    scene = SCENE.replace(place, text, 1) if place else f"{SCENE}{text}\n"
    return tissuec.check(_PLACES.sub("", scene))


def test_the_scene_is_right():
    assert not answered("", "")


@every("name", SILENCES)
def test_a_silence_is_answered_and_the_way_out_leads_out(name):
    place, text, code, said, mended = SILENCES[name]
    found = answered(place, text)
    assert {one.code for one in found} == {code}, found
    assert any(said in f"{one.message}: {one.hint}" for one in found), found
    assert not answered(place, mended)
