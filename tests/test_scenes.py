"""Scenes as users write them: good ones are checked in silence, bad ones are answered in words.

Beside each bad scene stands everything that ``check`` says about it. To change what it says,
change the compiler, then run

    TISSUEC_UPDATE=1 python -m pytest tests/test_scenes.py

which writes those texts anew and fails with the differences, so that somebody reads them. A
comment ``# set: NAME = VALUE`` in a scene stands for ``--set`` on the command line.
"""

import os
import re
from difflib import unified_diff
from pathlib import Path

import pytest

from tests.every import every
from tissuec.core.catalogue import CODES
from tissuec.core.errors import CompileError, Diagnostic, render
from tissuec.core.resources import root
from tissuec.core.source import Source
from tissuec.lang.parser import parse
from tissuec.lang.printer import format_source
from tissuec.pipeline import check_request
from tissuec.scene.program.imports import read_source
from tissuec.scene.request import Request

SCENES = Path(__file__).parent / "scenes"
BAD = sorted((SCENES / "bad").glob("*.tis"))
GOOD = sorted((SCENES / "good").glob("*.tis"))
UPDATE = "TISSUEC_UPDATE"


def request_of(path: Path) -> Request:
    """Return the request of a scene file, with the ``--set`` texts in its comments."""
    source = read_source(path, path.name)
    overrides = re.findall(r"^# set: (.*)$", source.text, re.MULTILINE)
    return Request(source, overrides=tuple(overrides))


def said(path: Path) -> str:
    """Return all that ``check`` says about a scene."""
    diagnostics: tuple[Diagnostic, ...]
    try:
        _, diagnostics = check_request(request_of(path))
    except CompileError as error:
        diagnostics = error.diagnostics
    text = "".join(f"{render(diagnostic)}\n" for diagnostic in diagnostics)
    return text.replace(str(path.parent), ".").replace(str(root()), "…")


@every("path", BAD, parts=2)
def test_a_bad_scene_is_answered_as_written_beside_it(path: Path) -> None:
    beside = path.with_suffix(".txt")
    expected = beside.read_text(encoding="utf-8") if beside.exists() else ""
    answer = said(path)
    difference = "".join(
        unified_diff(
            expected.splitlines(keepends=True),
            answer.splitlines(keepends=True),
            "expected",
            "said",
        )
    )
    if difference and os.environ.get(UPDATE):
        beside.write_text(answer, encoding="utf-8")
        pytest.fail(f"{beside.name} was written anew:\n{difference}", pytrace=False)
    assert not difference, f"{path.name}\n{difference}"
    assert answer, "a bad scene must be answered"


@every("path", GOOD)
def test_a_good_scene_is_checked_without_a_word(path: Path) -> None:
    try:
        compiled, warnings = check_request(request_of(path))
    except CompileError as error:
        pytest.fail("\n".join(map(render, error.diagnostics)), pytrace=False)
    assert not warnings, "\n".join(map(render, warnings))
    assert compiled is not None
    assert compiled.network.node_count > 0


@every("path", GOOD)
def test_formatting_a_good_scene_is_stable_and_keeps_its_meaning(path: Path) -> None:
    source = read_source(path, path.name)
    once = Source(path.name, format_source(source))
    assert format_source(once) == once.text
    assert parse(once) == parse(source)


def test_every_code_is_shown_by_a_scene() -> None:
    answers = "".join(path.with_suffix(".txt").read_text(encoding="utf-8") for path in BAD)
    assert set(re.findall(r"\[((?:TIS|W)\d{3})\]:", answers)) == set(CODES)


def test_every_answer_belongs_to_a_scene() -> None:
    answers = {path.stem for path in (SCENES / "bad").glob("*.txt")}
    assert answers == {path.stem for path in BAD}
