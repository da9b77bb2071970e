"""The catalogue of codes: complete, true, and the same in the manual.

    TISSUEC_UPDATE=1 python -m pytest tests/test_catalogue.py

writes ``docs/errors.md`` anew.
"""

import ast
import os
import re
from pathlib import Path

import pytest

from tests.every import every
from tests.modules import nodes, trees
from tissuec.core.catalogue import CODES, HERE_IN_PAGE, CodeEntry, example_files, reference
from tissuec.core.errors import CompileError, Diagnostic, render
from tissuec.pipeline import check_request
from tissuec.scene.program.imports import read_source
from tissuec.scene.request import Request

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "errors.md"
CODE = re.compile(r"(TIS|W)\d{3}")


def codes_in_sources() -> set[str]:
    """Return every code that stands as a text of its own in the sources."""
    return {
        node.value
        for path in trees()
        for node in nodes(path)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        if CODE.fullmatch(node.value)
    }


def diagnostics_of(entry: CodeEntry, piece: str, folder: Path) -> tuple[Diagnostic, ...]:
    """Return what is said about a piece of text in its frame, in a folder of its own."""
    for name, text in example_files().items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    scene = folder / "scene.tis"
    scene.write_text(entry.whole(piece), encoding="utf-8")
    override = entry.override(piece)
    overrides = () if override is None else (override,)
    try:
        return check_request(Request(read_source(scene, "scene.tis"), overrides=overrides))[1]
    except CompileError as error:
        return error.diagnostics


def test_every_code_is_explained_and_every_explanation_has_a_code() -> None:
    assert set(CODES) == codes_in_sources()


@pytest.mark.parametrize("code", CODES)
def test_the_text_before_earns_the_code(code: str, tmp_path: Path) -> None:
    found = diagnostics_of(CODES[code], CODES[code].before, tmp_path)
    assert found, "nothing was said"
    assert found[0].code == code, render(found[0])
    assert {diagnostic.code for diagnostic in found} == {code}, "\n".join(map(render, found))


@pytest.mark.parametrize("code", CODES)
def test_the_text_after_is_good(code: str, tmp_path: Path) -> None:
    found = diagnostics_of(CODES[code], CODES[code].after, tmp_path)
    assert not found, "\n".join(map(render, found))


@every("code", CODES)
def test_an_explanation_is_made_of_sentences(code: str) -> None:
    entry = CODES[code]
    assert entry.title[0].islower()
    assert not entry.title.endswith(".")
    assert not entry.text[0].isspace()
    assert entry.text.endswith(".")
    assert "  " not in entry.text


def test_the_manual_holds_the_catalogue() -> None:
    if os.environ.get("TISSUEC_UPDATE"):
        PAGE.write_text(reference(), encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == reference(), "run with TISSUEC_UPDATE=1"


SECTION = re.compile(r"^## (?P<code>(?:TIS|W)\d+):.*?(?=^## )", re.MULTILINE | re.DOTALL)
BLOCK = re.compile(r"^```(?:tis|text)\n(.*?)\n```$", re.MULTILINE | re.DOTALL)


def shown(heading: str) -> str:
    """Return the block below a heading of the page."""
    page = PAGE.read_text(encoding="utf-8")
    return BLOCK.search(page, page.index(f"\n### {heading}\n"))[1]


def test_examples_of_the_page_are_complete_with_the_scenes_on_the_page() -> None:
    page = PAGE.read_text(encoding="utf-8")
    found = {section["code"]: section[0] for section in SECTION.finditer(page)}
    assert set(found) == set(CODES)
    for code, section in found.items():
        pieces, link = BLOCK.findall(section), re.search(r"\(#scene-(\w+)\)", section)
        for piece, tested in zip(pieces, (CODES[code].before, CODES[code].after), strict=True):
            scene = shown(f"Scene {link[1]}") if link else HERE_IN_PAGE
            whole = scene.replace(HERE_IN_PAGE, piece)
            assert whole.split() == CODES[code].whole(tested).split(), code
    for name, text in example_files().items():
        assert shown(f"File {name}").split() == text.split()
