"""Quick fixes: every edit of a hint is offered, and after it its finding is gone."""

import pytest

from tests.every import every
from tests.lsp.editor_documents import BAD, SCENES
from tissuec.core.hints import removal
from tissuec.core.resources import library
from tissuec.core.source import Source, Span
from tissuec.lang.characters import normalise
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.findings import check, fixes_at
from tissuec.lsp.positions import Positions
from tissuec.scene.program.imports import read_source


def is_plain(path):
    raw = path.read_bytes()
    return b"# set: " not in raw and b"\0" not in raw and b"\xe9" not in raw


PLAIN = [path for path in BAD if is_plain(path)]


def kinds(findings):
    return sorted((one.code, one.message) for one in findings)


def applied(documents, fix):
    """Return a text after an edit that is made by lines and columns, as editors make it."""
    raw = documents.raw(fix.path)
    positions = Positions(raw)
    lines = raw.splitlines(keepends=True)
    start, stop = (
        sum(map(len, lines[: place.line])) + _index(lines, place)
        for place in map(positions.position, (fix.place.start, fix.place.end))
    )
    return raw[:start] + fix.text + raw[stop:]


def _index(lines, place):
    """Return how many characters of a line stand before a column, in units of UTF-16."""
    if place.line >= len(lines):
        return 0
    units = lines[place.line].encode("utf-16-le")[: 2 * place.character]
    return len(units.decode("utf-16-le"))


def offered(documents, path, checked):
    """Return what is offered at each finding, by the text and place of the edit."""
    for finding in checked.diagnostics:
        if finding.span is None:
            continue
        line = finding.span.line - 1
        fixes = fixes_at(finding.span.source.path, line, line, [checked], documents)
        for edit in finding.edits:
            yield (
                finding,
                next(fix for fix in fixes if (fix.text, fix.place) == (edit.text, edit.span)),
            )


@pytest.mark.parametrize(
    "paths", [PLAIN[::4], pytest.param(PLAIN, marks=pytest.mark.slow)], ids=["some", "all"]
)
def test_every_edit_of_a_hint_is_offered_in_its_place(paths):
    """That the finding goes then is tested by tests/test_hints.py."""
    for path in paths:
        documents = OpenDocuments()
        for finding, fix in offered(documents, path, check(documents, path)):
            (edit,) = (
                one for one in finding.edits if (one.text, one.span) == (fix.text, fix.place)
            )
            text, span = edit.span.source.text, edit.span
            edited = text[: span.start] + edit.text + text[span.end :]
            assert normalise(applied(documents, fix), "after").text == edited, path


@pytest.mark.slow
@pytest.mark.parametrize("path", PLAIN, ids=lambda path: path.stem)
def test_behind_every_edit_its_finding_is_gone(path):
    documents = OpenDocuments()
    before = check(documents, path)
    for finding, fix in offered(documents, path, before):
        documents.put(fix.path, applied(documents, fix))
        kind = finding.code, finding.message
        after = kinds(check(documents, path).diagnostics)
        assert after.count(kind) < kinds(before.diagnostics).count(kind), fix.title
        documents.take_away(fix.path)


def test_a_finding_of_another_file_is_fixed_there(tmp_path):
    scene, words, documents = tmp_path / "scene.tis", tmp_path / "words.tis", OpenDocuments()
    documents.put(scene, 'language 1\nuse "./words"\n\n')
    documents.put(words, "language 1\n\ntissue silk { mass = 1 }\n")
    checked = check(documents, scene)
    assert [one.code for one in checked.diagnostics] == ["TIS501"]
    assert fixes_at(scene, 0, 9, [checked], documents) == []
    (fix, *_) = fixes_at(words, 2, 2, [checked, checked], documents)
    assert fix.path == words
    assert fixes_at(words, 0, 1, [checked], documents) == []


def test_nothing_is_offered_for_a_text_that_has_changed_since():
    path, documents = SCENES / "bad" / "word_misspelt.tis", OpenDocuments()
    checked = check(documents, path)
    assert fixes_at(path, 0, 99, [checked], documents)
    documents.put(path, f"# one line more\n{documents.raw(path)}")
    assert fixes_at(path, 0, 99, [checked], documents) == []


def test_no_shipped_file_is_fixed():
    path, documents = library() / "tissues" / "fat.tis", OpenDocuments()
    documents.put(path, documents.raw(path).replace("language 1", "langage 1"))
    checked = check(documents, path)
    assert any(one.edits for one in checked.diagnostics)
    assert fixes_at(path, 0, 99, [checked], documents) == []


@every(
    ("text", "left"),
    [
        ("a\n«param b»\nc", "a\nc"),
        ("a\n  «param b»  # a remark\nc", "a\nc"),
        ("a\n«param b»", "a\n"),
        ("x { «b»; c }", "x { c }"),
        ("x { a; «b» }", "x { a }"),
        ("x { a; «b»; c }", "x { a; c }"),
        ("x {\n  a; «b»\n  c }", "x {\n  a\n  c }"),
        ("x { «b» }", "x {  }"),
        ("at 0 s: «b»\nc", "at 0 s: \nc"),
    ],
)
def test_a_statement_is_removed_with_its_separator(text, left):
    start, end = text.index("«"), text.index("»") - 1
    source = Source("t", text.replace("«", "").replace("»", ""))
    edit = removal(Span(source, start, end))
    assert source.text[: edit.span.start] + edit.text + source.text[edit.span.end :] == left


def test_a_bad_scene_is_plain_text_as_the_desk_reads_it():
    for path in PLAIN[::9]:
        assert OpenDocuments().read(path, path.name).text == read_source(path, path.name).text


def test_a_table_of_a_body_without_mesh_has_no_edit(tmp_path):
    path, documents = tmp_path / "scene.tis", OpenDocuments()
    text = 'body net { }\ntable nodes of net in mm with columns "id x" { 1 0 }\n'
    documents.put(path, f"language 1\n{text}simulate {{ duration = 1 s }}\n")
    assert all(not one.edits or one.span for one in check(documents, path).diagnostics)
