"""Where names are declared and used; renaming; the outline."""

import pytest

from tests.every import every
from tests.lsp.editor_documents import LIBRARY, asked, shipped
from tissuec.core.errors import TissueError
from tissuec.core.resources import library
from tissuec.lsp import navigation
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.findings import check
from tissuec.lsp.hover import hover
from tissuec.lsp.views import view_of

SCENE = """language 1
use "./words"
param lift = 6 mm
body vessel {
  mesh is tube { axis from (0, 0, 0) mm to (9, 0, 0) mm; radius = 3 mm; rings = 3; sides = 6 }
  tissue is wall
  region lump where x > lift { tissue is wall; prestress = 3 % }
  interface is mean
}
set Top End = nodes of vessel where region is lump
tool forceps A { kind is forceps }
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: grasp top end with forceps A
  from 0 s to 1 s: move forceps A by (lift, 0, 0) using smooth profile
}
simulate { duration = 1 s }
study lifts {
  vary lift = 2 mm to 6 mm in 3 steps
  vary firmness of wall = [soft, very hard]
  measure pull = max(force of top end)
  expect max(pull) > 0 N
}
expect force(TOP  end) > 0 N at 1 s
"""
WORDS = """language 1
hedge very = shift(50 %, outward)
property firmness from 0 to 1 { evenly = [soft, hard] }
quantity spring constant from 1 N/m to 9 N/m { evenly = [low, high]; applies to each spring }
rules simple { if firmness is very hard then spring constant is high }
tissue wall {
  described in simple; firmness is very hard; spring constant = 2 N/m
  viscosity = 1 mN*s/m; mass = 1 mg
}
"""


@pytest.fixture
def documents(tmp_path):
    documents = OpenDocuments()
    documents.put(tmp_path / "scene.tis", SCENE)
    documents.put(tmp_path / "words.tis", WORDS)
    return documents


def jump(documents, path, place):
    """Return the name of the file and what begins where a place of a text leads."""
    view = view_of(documents, path)
    places = navigation.definitions(view, view.source.text.index(place) + len(place))
    if not places:
        return None
    (found,) = places
    return found.path.name, documents.raw(found.path)[found.start : found.stop]


@pytest.mark.parametrize(
    ("place", "target"),
    [
        ('use "./wor', ("words.tis", "")),
        ("tissue is wal", ("words.tis", "wall")),
        ("x > lif", ("scene.tis", "lift")),
        ("by (lif", ("scene.tis", "lift")),
        ("nodes of ves", ("scene.tis", "vessel")),
        ("region is lu", ("scene.tis", "lump")),
        ("grasp to", ("scene.tis", "Top End")),
        ("force(TOP  e", ("scene.tis", "Top End")),
        ("move forc", ("scene.tis", "forceps A")),
        ("with forceps", ("scene.tis", "forceps A")),
        ("vary li", ("scene.tis", "lift")),
        ("firmness of wa", ("words.tis", "wall")),
        ("vary firm", ("words.tis", "firmness")),
        ("very ha", ("words.tis", "hard")),
        ("force of to", ("scene.tis", "Top End")),
        ("max(pu", ("scene.tis", "pull")),
        ("smooth pro", None),
    ],
)
def test_names_lead_to_their_declarations(documents, tmp_path, place, target):
    assert jump(documents, tmp_path / "scene.tis", place) == target


@pytest.mark.parametrize(
    ("place", "target"),
    [
        ("described in simp", ("words.tis", "simple")),
        ("if firm", ("words.tis", "firmness")),
        ("if firmness is ver", ("words.tis", "very")),
        ("very ha", ("words.tis", "hard")),
        ("then spring cons", ("words.tis", "spring constant")),
        ("constant is hi", ("words.tis", "high")),
    ],
)
def test_words_of_a_vocabulary_lead_to_their_scale(documents, tmp_path, place, target):
    assert jump(documents, tmp_path / "words.tis", place) == target


def test_every_place_of_a_name_is_found_across_files(documents, tmp_path):
    view = view_of(documents, tmp_path / "scene.tis")
    symbol, _, _ = view.symbol_at(view.source.text.index("is wall") + 4)
    places = navigation.references(navigation.around(view), symbol)
    assert sorted(place.path.name for place in places) == [
        "scene.tis",
        "scene.tis",
        "scene.tis",
        "words.tis",
    ]


def renamed(documents, path, place, name):
    """Rename what stands at a place, in the texts of a documents."""
    view = view_of(documents, path)
    offset = view.source.text.index(place) + len(place)
    renaming = navigation.rename(view, navigation.around(view), offset, name)
    for one in sorted(renaming.places, key=lambda one: -one.start):
        text = documents.raw(one.path)
        documents.put(one.path, text[: one.start] + renaming.text + text[one.stop :])


@pytest.mark.parametrize(
    ("place", "name"),
    [
        ("grasp to", "upper half"),
        ("grasp to", "head of gland"),
        ("param li", "way up"),
        ("tissue is wa", "thin wall"),
        ("region lu", "nodule"),
        ("tool for", "clamp"),
        ("body ves", "duct"),
        ("measure pu", "largest force"),
    ],
)
def test_a_scene_means_the_same_under_other_names(documents, tmp_path, place, name):
    path = tmp_path / "scene.tis"
    before = check(documents, path, thorough=False)
    assert before.compiled is not None, before.diagnostics
    renamed(documents, path, place, name)
    after = check(documents, path, thorough=False)
    assert after.compiled is not None, after.diagnostics
    assert (after.compiled.network.springs.rest == before.compiled.network.springs.rest).all()
    assert [d.code for d in after.diagnostics] == [d.code for d in before.diagnostics]


@pytest.mark.parametrize(
    ("place", "name", "reason"),
    [
        ("param li", "forceps A", "already defined"),
        ("param li", "mm", "is a unit"),
        ("param li", "", "a name consists of words"),
        ("smooth pro", "rough", "no defined name at this position"),
    ],
)
def test_a_name_that_cannot_be_is_refused(documents, tmp_path, place, name, reason):
    with pytest.raises(TissueError, match=reason):
        renamed(documents, tmp_path / "scene.tis", place, name)


def test_the_library_keeps_its_names():
    text = shipped("scenes/sterilisation.tis").replace(
        "is fallopian tube", "is fallopian‸ tube"
    )
    view, offset = asked(text, library() / "scenes" / "sterilisation.tis")
    with pytest.raises(TissueError, match="shipped library"):
        navigation.renamable(view, offset)


@every("path", LIBRARY)
def test_no_name_of_a_library_file_is_left_unknown(path):
    view = view_of(OpenDocuments(), path)
    known = {start for _, start, _ in view.occurrences()}
    for phrase in view.all_phrases():
        names = set(phrase.expected.names) - {"param", "let"}
        if phrase.parts and names and phrase.term is None and phrase.parts[0].kind == "word":
            assert phrase.start in known or view.symbols_at(phrase.start), phrase.key


def test_a_name_with_an_index_means_each_that_it_can_be():
    text = SCENE.replace("set Top", "set Low End = nodes of vessel where x < 1 mm\nset Top")
    text = text.replace("script {", "script {\n  repeat e in [top, low] { at 0 s: fix e e‸nd }")
    view, offset = asked(text)
    places, said = navigation.definitions(view, offset), hover(view, offset)
    assert [text[one.start : one.stop] for one in places] == ["Low End", "Top End"]
    assert "**Low End**, set" in said.text and "**Top End**, set" in said.text
    with pytest.raises(TissueError, match="no defined name"):
        navigation.renamable(view, offset)


def test_the_outline_names_what_a_text_consists_of_right_or_wrong():
    text = SCENE.replace("interface is mean", "interface is (((")
    view, _ = asked(text + "‸")
    found = {(part.kind, part.name) for part in navigation.outline(view.structure)}
    assert {("body", "vessel"), ("set", "Top End"), ("tool", "forceps A")} <= found
    (body,) = (part for part in navigation.outline(view.structure) if part.kind == "body")
    assert [(part.kind, part.name) for part in body.inner] == [("region", "lump")]
    (script,) = (part for part in navigation.outline(view.structure) if part.kind == "script")
    assert script.inner[0].name == "at 0 s: grasp top end with forceps A"
