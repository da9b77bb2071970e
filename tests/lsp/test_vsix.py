"""The extension as one file: what an installer reads of it is there, and agrees."""

import json
import shutil
import subprocess
import sys
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree
from zipfile import ZipFile

import pytest

from docs.make_client import bundle, heading
from tissuec.cli.lsp import _write
from tissuec.core.errors import TissueError
from tissuec.core.resources import grammar
from tissuec.lsp import vscode
from tissuec.lsp.vscode import write_vsix

ROOT = Path(__file__).resolve().parent.parent.parent
TYPES = "{http://schemas.openxmlformats.org/package/2006/content-types}"
VSX = "{http://schemas.microsoft.com/developer/vsx-schema/2011}"


@pytest.fixture
def written(tmp_path):
    target = tmp_path / "tissuec.vsix"
    write_vsix(target)
    with ZipFile(target) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


def test_each_part_has_a_type(written):
    parts = written
    assert next(iter(parts)) == "[Content_Types].xml"
    types = ElementTree.fromstring(parts["[Content_Types].xml"])
    assert types.tag == f"{TYPES}Types"
    endings = {one.get("Extension") for one in types.findall(f"{TYPES}Default")}
    named = {one.get("PartName") for one in types.findall(f"{TYPES}Override")}
    for path in set(parts) - {"[Content_Types].xml"}:
        assert PurePosixPath(path).suffix in endings or f"/{path}" in named
    assert all(one.get("ContentType") for one in types)


def test_the_manifest_agrees_with_the_package(written):
    parts = written
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
    parts = written
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


def test_the_client_is_made_of_the_present_sources():
    first = (grammar("vscode") / "client.js").read_text(encoding="utf-8").split("\n", 1)[0]
    assert first + "\n" == heading(), "run python docs/make_client.py"


def test_the_licence_of_each_package_in_the_client_goes_with_it(written):
    text = written["extension/client.licences.txt"].decode()
    locked = json.loads((grammar("vscode") / "package-lock.json").read_bytes())["packages"]
    for path, package in locked.items():
        if "esbuild" not in path and path:
            assert f"{path.removeprefix('node_modules/')} {package['version']}\n---" in text
    assert len(written["extension/client.js"]) < 400_000


#: Stands for VS Code: whatever is asked of it is a class, a function, and an object.
STAND_IN = """
const any = () => new Proxy(class {}, {get: (of, name) => of[name] ?? (of[name] = any())});
const Module = require("module"), load = Module._load, vscode = any();
Module._load = (name, ...rest) => name === "vscode" ? vscode : load(name, ...rest);
const client = require(process.argv[1]);
console.log(typeof client.activate, typeof client.deactivate);
"""


def test_the_client_loads_with_nothing_beside_it(written, tmp_path):
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node")
    (tmp_path / "client.js").write_bytes(written["extension/client.js"])
    command = [node, "-e", STAND_IN, str(tmp_path / "client.js")]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env={})
    assert run.stdout.split() == ["function", "function"], run.stderr


@pytest.mark.slow
def test_the_client_can_be_made_again_to_the_last_byte():
    if shutil.which("npm") is None:
        pytest.skip("needs npm")
    for name, text in bundle().items():
        assert (grammar("vscode") / name).read_text(encoding="utf-8") == text


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
    assert "code --install-extension" in run.stderr
    run = subprocess.run(
        [*command[:-1], str(tmp_path / "no" / "t.vsix")],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert run.returncode == 2 and "cannot write" in run.stderr


def test_a_file_of_the_extension_that_cannot_be_read_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(vscode, "_WRITTEN", ("absent.js",))
    with pytest.raises(TissueError, match=r'cannot read ".*absent\.js"'):
        _write(tmp_path / "t.vsix")
