"""Names in the files of a folder are found, open or not."""

import pytest

from tissuec.lsp import session
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.session import names_in

SCENE = """language 1
tissue silk { mass = 1 mg }
body left flap { mesh is explicit; region edge where x > 1 mm { tissue is silk } }
set rim = nodes of left flap
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "deep" / "er").mkdir(parents=True)
    (tmp_path / ".hidden").mkdir()
    (tmp_path / "deep" / "er" / "scene.tis").write_text(SCENE)
    (tmp_path / ".hidden" / "other.tis").write_text("language 1\ntissue hidden { }\n")
    (tmp_path / "notes.txt").write_text("tissue none { }\n")
    (tmp_path / "odd.tis").write_bytes(b"\xff\xfe\x00")
    return tmp_path


def found(folder, query, documents=None):
    hits = names_in([folder], documents or OpenDocuments(), query)
    return [(one.part.kind, one.part.name, one.within, one.path.name) for one in hits]


def test_all_names_of_a_folder_are_found(folder):
    assert found(folder, "") == [
        ("tissue", "silk", "", "scene.tis"),
        ("body", "left flap", "", "scene.tis"),
        ("region", "edge", "left flap", "scene.tis"),
        ("set", "rim", "", "scene.tis"),
    ]


@pytest.mark.parametrize(
    ("query", "names"),
    [("FLAP", ["left flap"]), ("lfp", ["left flap"]), ("pf", []), ("ft fl", ["left flap"])],
)
def test_a_query_gives_letters_in_their_order(folder, query, names):
    assert [name for _, name, _, _ in found(folder, query)] == names


def test_an_open_text_counts_in_place_of_its_file(folder):
    documents = OpenDocuments()
    path = folder / "deep" / "er" / "scene.tis"
    documents.put(path, SCENE.replace("silk", "wool") + "set half typed = nodes of")
    assert ("tissue", "wool", "", "scene.tis") in found(folder, "", documents)
    assert [name for _, name, _, _ in found(folder, "half", documents)] == ["half typed"]


def test_no_more_names_are_returned_than_an_editor_can_show(folder, monkeypatch):
    monkeypatch.setattr(session, "MOST_NAMES", 2)
    assert len(found(folder, "")) == 2
