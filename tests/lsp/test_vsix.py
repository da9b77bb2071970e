"""The extension as one file: what an installer reads of it is there, and agrees."""

import json
import subprocess
import sys
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree
from zipfile import ZipFile

import pytest

from tissuec.cli.lsp import _write
from tissuec.core.errors import TissueError
from tissuec.core.resources import grammar
from tissuec.lsp import vsix
from tissuec.lsp.vsix import CLIENT, write_vsix

ROOT = Path(__file__).resolve().parent.parent.parent
TYPES = "{http://schemas.openxmlformats.org/package/2006/content-types}"
VSX = "{http://schemas.microsoft.com/developer/vsx-schema/2011}"


@pytest.fixture
def written(tmp_path):
    target = tmp_path / "tissuec.vsix"
    has_client = write_vsix(target)
    with ZipFile(target) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}, has_client


def test_each_part_has_a_type(written):
    parts, _ = written
    assert next(iter(parts)) == "[Content_Types].xml"
    types = ElementTree.fromstring(parts["[Content_Types].xml"])
    assert types.tag == f"{TYPES}Types"
    endings = {one.get("Extension") for one in types.findall(f"{TYPES}Default")}
    named = {one.get("PartName") for one in types.findall(f"{TYPES}Override")}
    for path in set(parts) - {"[Content_Types].xml"}:
        assert PurePosixPath(path).suffix in endings or f"/{path}" in named
    assert all(one.get("ContentType") for one in types)


def test_the_manifest_agrees_with_the_package(written):
    parts, _ = written
    package = json.loads(parts["extension/package.json"])
    manifest = ElementTree.fromstring(parts["extension.vsixmanifest"])
    assert (manifest.tag, manifest.get("Version")) == (f"{VSX}PackageManifest", "2.0.0")
    identity = manifest.find(f"{VSX}Metadata/{VSX}Identity")
    said = [identity.get(name) for name in ("Id", "Version", "Publisher")]
    assert said == [package["name"], package["version"], package["publisher"]]
    engines = {one.get("Id"): one.get("Value") for one in manifest.iter(f"{VSX}Property")}
    assert engines["Microsoft.VisualStudio.Code.Engine"] == package["engines"]["vscode"]
    target = manifest.find(f"{VSX}Installation/{VSX}InstallationTarget")
    assert target.get("Id") == "Microsoft.VisualStudio.Code"
    assets = [one.get("Path") for one in manifest.iter(f"{VSX}Asset")]
    assert "extension/package.json" in assets and set(assets) <= set(parts)


def test_what_the_package_names_is_there(written):
    parts, has_client = written
    package = json.loads(parts["extension/package.json"])
    contributes = package["contributes"]
    named = [package["main"], *(one["path"] for one in contributes["grammars"])]
    named += [one["configuration"] for one in contributes["languages"]]
    for path in named:
        assert f"extension/{path.removeprefix('./')}" in parts
    for path, content in parts.items():
        assert path.startswith("extension") or path == "[Content_Types].xml"
        if path.endswith(".json"):
            json.loads(content)
    assert has_client == (f"extension/{CLIENT}" in parts)


def test_what_npm_fetched_goes_with_it(tmp_path, monkeypatch):
    folder = tmp_path / "vscode"
    for name in ("extension.js", "README.md"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes((grammar("vscode") / name).read_bytes())
    for path in (
        CLIENT,
        "node_modules/.bin/tool",
        "node_modules/vscode-languageclient/LICENSE",
    ):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text("{}")
    monkeypatch.setattr(vsix, "grammar", lambda name: folder)
    assert write_vsix(tmp_path / "a.vsix")
    with ZipFile(tmp_path / "a.vsix") as archive:
        names = set(archive.namelist())
        types = archive.read("[Content_Types].xml").decode()
    assert f"extension/{CLIENT}" in names
    assert not any(".bin" in name for name in names)
    assert 'PartName="/extension/node_modules/vscode-languageclient/LICENSE"' in types


def test_equal_contents_make_equal_files(tmp_path):
    for name in "ab":
        write_vsix(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_the_command_says_what_it_wrote(tmp_path):
    command = [sys.executable, "-m", "tissuec", "lsp", "--vsix", str(tmp_path / "t.vsix")]
    run = subprocess.run([*command, "--json"], capture_output=True, text=True, cwd=ROOT)
    said = json.loads(run.stdout)
    assert said["file"] == str(tmp_path / "t.vsix") and (tmp_path / "t.vsix").is_file()
    run = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert said["client"] or "npm install" in run.stderr
    run = subprocess.run(
        [*command[:-1], str(tmp_path / "no" / "t.vsix")],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert run.returncode == 2 and "cannot write" in run.stderr


def test_a_file_of_the_extension_that_cannot_be_read_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(vsix, "_WRITTEN", ("absent.js",))
    with pytest.raises(TissueError, match=r'cannot read ".*absent\.js"'):
        _write(tmp_path / "t.vsix", None)
