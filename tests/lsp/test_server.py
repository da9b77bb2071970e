"""A real client speaks with ``tissuec lsp`` over stdio."""

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.lsp.editor_documents import BAD, LIBRARY, SCENES
from tissuec.cli.check import _check
from tissuec.cli.common import SceneOptions
from tissuec.core.errors import as_dict
from tissuec.lsp.positions import formatted

pytest.importorskip("pygls.lsp.server")
from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient

ROOT = Path(__file__).resolve().parent.parent.parent
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT)}
PATIENCE = 60.0  # seconds; other tests may keep the computer busy


class Editor(LanguageClient):
    """A client that keeps what it is told of each text."""

    def __init__(self):
        super().__init__("tests", "1")
        self.told: dict[str, list[lsp.Diagnostic]] = {}
        self.news = asyncio.Condition()

        @self.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        async def _published(parameters: lsp.PublishDiagnosticsParams):
            async with self.news:
                self.told[parameters.uri] = list(parameters.diagnostics)
                self.news.notify_all()

    def open(self, path: Path, text: str | None = None) -> str:
        text = path.read_bytes().decode("utf-8") if text is None else text
        uri = path.resolve().as_uri()
        item = lsp.TextDocumentItem(uri, "tissuec", 1, text)
        self.text_document_did_open(lsp.DidOpenTextDocumentParams(item))
        return uri

    def change(self, uri: str, text: str) -> None:
        self.text_document_did_change(
            lsp.DidChangeTextDocumentParams(
                lsp.VersionedTextDocumentIdentifier(uri=uri, version=2),
                [lsp.TextDocumentContentChangeWholeDocument(text)],
            )
        )

    def type(self, uri: str, place: lsp.Position, text: str, end: lsp.Position | None = None):
        """Replace a stretch of a text."""
        stretch = lsp.Range(place, end or place)
        self.text_document_did_change(
            lsp.DidChangeTextDocumentParams(
                lsp.VersionedTextDocumentIdentifier(uri=uri, version=3),
                [lsp.TextDocumentContentChangePartial(range=stretch, text=text)],
            )
        )

    async def until(self, uri: str, fits) -> None:
        """Wait until what is told of a text fits."""
        async with self.news:
            await asyncio.wait_for(
                self.news.wait_for(lambda: uri in self.told and fits(self.told[uri])), PATIENCE
            )


@asynccontextmanager
async def editor(encodings=("utf-16",)):
    client = Editor()
    await client.start_io(sys.executable, "-m", "tissuec", "lsp", env=ENVIRONMENT)
    general = lsp.GeneralClientCapabilities(
        position_encodings=[lsp.PositionEncodingKind(name) for name in encodings]
    )
    await client.initialize_async(
        lsp.InitializeParams(
            capabilities=lsp.ClientCapabilities(general=general),
            process_id=os.getpid(),
            root_uri=None,
        )
    )
    client.initialized(lsp.InitializedParams())
    yield client
    await client.shutdown_async(None)
    client.exit(None)
    await client.stop()


def expected(found, path: Path) -> list[tuple]:
    """Return findings of the JSON document as the protocol has those of one file."""
    return sorted(
        (
            one["code"],
            one["severity"],
            "\n".join([one["message"], *_more(one)]),
            _place(one, path),
        )
        for one in found
        if one["file"] in (str(path), None)
    )


def _more(one) -> Iterator[str]:
    if one["hint"]:
        yield f"hint: {one['hint']}"
    yield from (f"note: {note['message']}" for note in one["notes"] if note["file"] is None)


def _place(one, path: Path) -> tuple[int, int, int, int]:
    if one["file"] is None:
        return (0, 0, 0, 0)
    lines = path.read_text(encoding="utf-8").split("\n")  # any line end becomes this one
    columns = (
        len(lines[one[line] - 1][: one[column] - 1].encode("utf-16-le")) // 2
        for line, column in (("line", "column"), ("end_line", "end_column"))
    )
    start, end = columns
    return one["line"] - 1, start, one["end_line"] - 1, end


def shown(told: list[lsp.Diagnostic]) -> list[tuple]:
    """Return what a client was told, in the same form."""
    severity = {1: "error", 2: "warning"}
    return sorted(
        (
            one.code,
            severity[one.severity],
            one.message,
            (
                one.range.start.line, one.range.start.character,
                one.range.end.line, one.range.end.character,
            ),
        )
        for one in told
    )  # fmt: skip


def is_plain(path: Path) -> bool:
    """Return whether a bad scene is a text as editors have them, and needs no options."""
    raw = path.read_bytes()
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return "# set: " not in text and "\0" not in text and not text.startswith("\ufeff")


def said_of(path: Path):
    return [as_dict(one) for one in _check(path, SceneOptions())[0]]


def carry_out(conversation: Coroutine[Any, Any, None]) -> None:
    """Run a coroutine in a thread of its own: in this one a browser may keep its loop."""
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, conversation).result()


async def agree(paths: list[Path]) -> None:
    """Open texts one after the other and compare what is told with what ``check`` says."""
    async with editor() as client:
        for path in paths:
            wanted = expected(said_of(path), path)
            uri = client.open(path)
            try:
                await client.until(uri, lambda told, wanted=wanted: shown(told) == wanted)
            except TimeoutError:
                assert shown(client.told[uri]) == wanted, path.name
            for one in client.told[uri]:
                assert one.code_description.href.startswith("file:")
                assert one.source == "tissuec"
            client.text_document_did_close(
                lsp.DidCloseTextDocumentParams(lsp.TextDocumentIdentifier(uri))
            )


PLAIN = [path for path in BAD if is_plain(path)]


@pytest.mark.parametrize(
    "paths",
    [
        [*LIBRARY[::6], *PLAIN[::64]],
        pytest.param(LIBRARY, marks=pytest.mark.slow),
        pytest.param(PLAIN, marks=pytest.mark.slow),
    ],
    ids=["some", "library", "bad scenes"],
)
def test_a_file_is_told_as_the_command_says_it(paths):
    carry_out(agree(paths))


def test_the_command_says_so_too():
    """The tests above compare with what the command computes, this one with what it prints."""
    path = SCENES / "bad" / "word_misspelt.tis"
    command = [sys.executable, "-m", "tissuec", "check", "--json", str(path)]
    run = subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT)
    assert json.loads(run.stdout)["diagnostics"] == said_of(path)


TEXT = """language 1
use "./words"
about "Ein Gerät 😀"; param höhe = 6 mm
let half = höhe / 2  # 😀
tissue t like silk { mass = 2 mg }
"""
WORDS = """language 1
tissue silk { mass = 1 mg; spring constant = 4 N/m; viscosity = 1 mN*s/m }
"""


def place(text: str, what: str, more: int = 0, encoding: str = "utf-16-le", unit: int = 2):
    """Return the position behind something in a text."""
    start = text.index(what) + len(what) + more
    line = text.count("\n", 0, start)
    column = text[text.rfind("\n", 0, start) + 1 : start]
    return lsp.Position(line, len(column.encode(encoding)) // unit)


@pytest.mark.parametrize(
    ("name", "encoding", "unit"),
    [
        ("utf-16", "utf-16-le", 2),
        ("utf-8", "utf-8", 1),
        pytest.param("utf-32", "utf-32-le", 4, marks=pytest.mark.slow),
    ],
)
def test_places_are_right_behind_any_character(tmp_path, name, encoding, unit):
    def behind(what):
        return place(TEXT, what, 0, encoding, unit)

    async def ask(client, uri):
        document = lsp.TextDocumentIdentifier(uri)
        said = await client.text_document_hover_async(
            lsp.HoverParams(document, behind("param höh"))
        )
        assert "`6 mm` = `0.006 m`" in said.contents.value
        name_range = lsp.Range(behind("param "), behind("höhe"))
        assert said.range == name_range
        led = await client.text_document_definition_async(
            lsp.DefinitionParams(document, behind("= höh"))
        )
        assert [(one.uri, one.range) for one in led] == [(uri, name_range)]

    async def talk():
        (tmp_path / "words.tis").write_text(WORDS)
        async with editor((name,)) as client:
            for file, end in (("unix.tis", "\n"), ("windows.tis", "\r\n")):
                await ask(client, client.open(tmp_path / file, TEXT.replace("\n", end)))

    carry_out(talk())


def test_an_editor_session(tmp_path):
    """Everything a session asks, of texts that are not on disk."""

    async def talk():
        async with editor() as client:
            scene, words = tmp_path / "scene.tis", tmp_path / "words.tis"
            uri = client.open(scene, TEXT)
            document = lsp.TextDocumentIdentifier(uri)
            await client.until(uri, lambda told: [one.code for one in told] == ["TIS601"])
            other = client.open(words, WORDS)
            await client.until(uri, lambda told: not told)

            # Typing: half a line, then the whole one.
            typed = TEXT + "tissue u like si"
            client.change(uri, typed)
            await client.until(uri, lambda told: [one.code for one in told] == ["TIS312"])
            offers = await client.text_document_completion_async(
                lsp.CompletionParams(document, place(typed, "u like si"))
            )
            (offer,) = (one for one in offers.items if one.label == "silk")
            assert offer.text_edit.new_text == "silk"
            assert offer.text_edit.range.start == place(typed, "tissue u like ")
            client.change(uri, TEXT)
            await client.until(uri, lambda told: not told)

            led = await client.text_document_definition_async(
                lsp.DefinitionParams(document, place(TEXT, "like sil"))
            )
            assert (led[0].uri, led[0].range.start) == (other, lsp.Position(1, 7))
            led = await client.text_document_definition_async(
                lsp.DefinitionParams(document, place(TEXT, "./wor"))
            )
            assert [one.uri for one in led] == [other]

            change = await client.text_document_rename_async(
                lsp.RenameParams(document, place(TEXT, "like sil"), "spun silk")
            )
            assert {where: len(edits) for where, edits in change.changes.items()} == {
                uri: 1, other: 1,
            }  # fmt: skip
            # Where no name is, the answer is none, and a message says why.
            assert not await client.text_document_rename_async(
                lsp.RenameParams(document, lsp.Position(0, 2), "x")
            )

            # A part of a line is replaced; forms of what is typed, and names everywhere.
            start, stop = place(TEXT, "half = "), place(TEXT, "höhe / 2")
            client.type(uri, start, "max(höhe, 1 m", stop)
            await client.until(uri, bool)
            typed = TEXT.replace("höhe / 2", "max(höhe, 1 m")
            said = await client.text_document_signature_help_async(
                lsp.SignatureHelpParams(document, place(typed, "1 m"))
            )
            assert said.signatures[0].label == "max(…)"
            client.type(uri, start, "höhe / 2", place(typed, "1 m"))
            await client.until(uri, lambda told: not told)
            found = await client.workspace_symbol_async(lsp.WorkspaceSymbolParams("silk"))
            assert [(one.name, one.location.uri) for one in found] == [("silk", other)]

            # A mistake in what is used is told there.
            client.change(other, WORDS.replace("4 N/m", "4 N"))
            await client.until(other, lambda told: [one.code for one in told] == ["TIS502"])

            untidy = TEXT.replace("half =", "half    =")
            client.change(uri, untidy)
            (edit,) = await client.text_document_formatting_async(
                lsp.DocumentFormattingParams(document, lsp.FormattingOptions(2, True))
            )
            assert edit.new_text == formatted(untidy) != untidy
            assert edit.range.start == lsp.Position(0, 0)
            outline = await client.text_document_document_symbol_async(
                lsp.DocumentSymbolParams(document)
            )
            assert [part.name for part in outline] == ["höhe", "half", "t"]
            coloured = await client.text_document_semantic_tokens_full_async(
                lsp.SemanticTokensParams(document)
            )
            assert len(coloured.data) % 5 == 0 and len(coloured.data) > 50
            folds = await client.text_document_folding_range_async(
                lsp.FoldingRangeParams(document)
            )
            assert not folds
            uses = await client.text_document_references_async(
                lsp.ReferenceParams(
                    lsp.ReferenceContext(include_declaration=True),
                    document,
                    place(untidy, "param hö"),
                )
            )
            assert len(uses) == 2

    carry_out(talk())


def test_without_pygls_the_command_says_what_to_install():
    code = (
        "import sys; sys.modules['pygls'] = None; sys.argv = ['tissuec', 'lsp']; "
        "from tissuec.cli import main; main()"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=ENVIRONMENT
    )
    assert run.returncode != 0
    assert 'pip install "tissuec[lsp]"' in run.stderr
    assert run.stdout == ""


def test_no_other_command_imports_the_protocol():
    code = (
        "import sys, tissuec.cli.check, tissuec.lsp.semantic_tokens; "
        "sys.exit(any(m.split('.')[0] in ('pygls', 'lsprotocol') for m in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT).returncode == 0


async def fix(path: Path) -> None:
    raw = path.read_text(encoding="utf-8")
    async with editor() as client:
        uri = client.open(path)
        await client.until(uri, bool)
        told = client.told[uri][0]
        document, context = lsp.TextDocumentIdentifier(uri), lsp.CodeActionContext([told])
        offered = await client.text_document_code_action_async(
            lsp.CodeActionParams(document, told.range, context)
        )
        assert [(one.title, one.kind, one.is_preferred) for one in offered] == [
            ('Write "soft"', "quickfix", True)
        ]
        ((where, (edit,)),) = offered[0].edit.changes.items()
        assert where == uri
        lines = raw.split("\n")
        line, place = lines[edit.range.start.line], edit.range
        lines[place.start.line] = (
            line[: place.start.character] + edit.new_text + line[place.end.character :]
        )
        client.change(uri, "\n".join(lines))
        await client.until(uri, lambda found: not found)


def test_a_hint_is_offered_as_a_quick_fix():
    carry_out(fix(SCENES / "bad" / "word_misspelt.tis"))


async def fixed(paths: list[Path]) -> None:
    """Ask for the fixes of what is told of texts, and make each."""
    async with editor() as client:
        for path in paths:
            raw = path.read_text(encoding="utf-8")
            uri, document = client.open(path), lsp.TextDocumentIdentifier(path.as_uri())
            await client.until(uri, bool)
            told = client.told[uri]
            place = lsp.Range(lsp.Position(0, 0), lsp.Position(raw.count("\n"), 0))
            context = lsp.CodeActionContext(told, only=[lsp.CodeActionKind.QuickFix])
            offered = await client.text_document_code_action_async(
                lsp.CodeActionParams(document, place, context)
            )
            for action in offered:
                (about,) = action.diagnostics
                ((where, (edit,)),) = action.edit.changes.items()
                assert where == uri and about in told
                client.change(uri, with_edit(raw, edit))
                before = told.count(about)
                await client.until(
                    uri,
                    lambda found, about=about, before=before: (
                        sum(one.message == about.message for one in found) < before
                    ),
                )
                client.change(uri, raw)
                await client.until(uri, lambda found, about=about: about in found)
            client.text_document_did_close(lsp.DidCloseTextDocumentParams(document))


def with_edit(raw: str, edit: lsp.TextEdit) -> str:
    """Return an ASCII text after an edit."""
    lines = raw.splitlines(keepends=True)
    start, end = (
        sum(map(len, lines[: place.line])) + place.character
        for place in (edit.range.start, edit.range.end)
    )
    return raw[:start] + edit.new_text + raw[end:]


def test_quick_fixes_are_made_by_a_client():
    names = ("param_not_used", "table_beside_mesh", "open_backwards", "step_and_tolerance")
    carry_out(fixed([SCENES / "bad" / f"{name}.tis" for name in names]))
