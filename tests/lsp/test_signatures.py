"""Forms of what is typed, and which part of them comes next."""

import pytest

from tests.every import every
from tests.lsp.editor_documents import asked
from tissuec.lsp.signatures import signature

ORDER = "script { at 0 s: "
CASES = {
    ORDER + "move ‸": ("move SET by VECTOR using PROFILE", "SET"),
    ORDER + "move grip by ‸": ("move SET by VECTOR using PROFILE", "by VECTOR"),
    ORDER + "move grip by (1, 2, 3) mm using ‸ }": (
        "move SET by VECTOR using PROFILE", "using PROFILE",
    ),
    ORDER + "pull tip with 3 N along ‸": ("pull SET with FORCE along VECTOR", "along VECTOR"),
    ORDER + "cut b along line from (0, 0, 0) mm to ‸": (
        "cut BODY along line from POINT to POINT facing VECTOR", "to POINT",
    ),
    ORDER + "change spring constant of s to ‸": (
        "change spring constant of SET to NUMBER", "to NUMBER",
    ),
    "expect force(‸": ("force(A)", "A"),
    "expect distance(a, ‸) < 3 mm": ("distance(A, B)", "B"),
    "expect force(tip) < 1 N at ‸": ("expect CONDITION at TIME", "at TIME"),
    "body b { mesh is tube { axis from (0, 0, 0) mm to ‸": ("axis from … to …", "to …"),
    "environment { gravity = ‸": ("gravity = (x, y, z)", "= (x, y, z)"),
    "param x = 3 mm between ‸": (
        "param NAME = NUMBER between NUMBER and NUMBER", "between NUMBER",
    ),
    "set a = nodes of ‸": ("set NAME = nodes of BODY in LIST where CONDITION", "of BODY"),
}  # fmt: skip


@every("text", CASES)
def test_the_form_and_the_place_of_what_is_typed(text):
    found = signature(*asked(text))
    assert found is not None
    form = found.forms[found.active]
    start, stop = form.places[found.place]
    assert (form.text, form.text[start:stop]) == CASES[text]
    assert found.about


@pytest.mark.parametrize(("typed", "active"), [("is ", 0), ("is not ", 1), ("by ", 2)])
def test_forms_with_nothing_to_fill_in_are_a_choice(typed, active):
    found = signature(*asked(f"body b {{ rupture {typed}‸"))
    assert found is not None
    known = [
        f"rupture {each}"
        for each in ("is allowed", "is not allowed", "by toughness", "by faces")
    ]
    assert [form.text for form in found.forms] == known
    assert (found.active, found.place, found.forms[active].places) == (active, 0, ())


@pytest.mark.parametrize("text", ["# move ‸", "‸", "frobnicate the ‸", ORDER + "‸"])
def test_elsewhere_there_is_none(text):
    assert signature(*asked(text)) is None


@pytest.mark.parametrize("step", [37, pytest.param(1, marks=pytest.mark.slow)])
def test_there_is_always_an_answer_while_a_scene_is_typed(step, repository):
    text = (repository / "library/scenes/sterilisation.tis").read_text(encoding="utf-8")
    for end in range(0, len(text), step):
        found = signature(*asked(text[:end] + "‸" + text[end:]))
        if found is not None:
            assert 0 <= found.place < max(len(found.forms[found.active].places), 1)
